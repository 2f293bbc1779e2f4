/* SPDX-License-Identifier: MIT */
/* Tries each library with each driver. A process can open one library only. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/process/process.h"
#include "raster/context/context.h"
#include "raster/drivers/drivers.h"
#include "raster/traits/traits.h"

static bool describe(void *context, void *out, struct error *err)
{
    const struct listed_driver *listed = context;
    const struct context_wish wish = {listed->library, listed->driver, 1};
    return contexts_describe(&wish, out, err);
}

static bool count_devices(void *context, void *out, struct error *err)
{
    (void)context;
    return contexts_devices(out, err);
}

/* Returns whether a driver that was asked for is one, and not the one that comes without. */
static bool is_new(const struct listed_driver *listed, const struct driver_list *before)
{
    const struct listed_driver *first = &before->list[before->n - 1];
    return listed->is &&
           strncmp(listed->is->renderer, listed->driver, strlen(listed->driver)) == 0 &&
           strcmp(listed->is->renderer, first->is->renderer) != 0;
}

/* Tries a library with a driver, NULL first; lists it if it says something new. */
static bool try_driver(const char *library, const char *driver, struct driver_list *out,
                       struct error *err)
{
    struct listed_driver listed = {.driver = driver};
    struct context_description is;
    struct error own = {.status = EXIT_AGREED};
    snprintf(listed.library, sizeof listed.library, "%s", library);
    if (process_run(describe, &listed, &is, sizeof is, &own)) {
        listed.is = malloc(sizeof *listed.is);
        if (!listed.is)
            return error_memory(err);
        *listed.is = is;
    } else
        snprintf(listed.reason, sizeof listed.reason, "%.500s", error_words(&own));
    if ((!driver || is_new(&listed, out)) &&
        array_add(&out->list, &out->n, &listed, sizeof listed, err))
        return true;
    free(listed.is);
    return err->status == EXIT_AGREED;
}

static bool try_library(const char *library, struct driver_list *out, struct error *err)
{
    static const char *const drivers[] = {"llvmpipe", "softpipe"};
    if (is_interrupted())
        return error_system(err, "interrupted");
    if (!try_driver(library, NULL, out, err))
        return false;
    for (int i = 0; i < 2 && out->list[out->n - 1].is; i++)
        if (!try_driver(library, drivers[i], out, err))
            return false;
    return true;
}

bool drivers_list(struct driver_list *out, struct error *err)
{
    struct error own = {.status = EXIT_AGREED};
    int n_devices = 0;
    *out = (struct driver_list){.n = 0};
    if (!try_library("osmesa", out, err) || !try_library("egl", out, err))
        return false;
    if (!process_run(count_devices, NULL, &n_devices, sizeof n_devices, &own))
        n_devices = 0;
    for (int i = 0; i < n_devices; i++) {
        char library[16];
        snprintf(library, sizeof library, "egl:%d", i);
        if (!try_library(library, out, err))
            return false;
    }
    return true;
}

/* ---- measurements ---- */

static bool measure(void *context, void *out, struct error *err)
{
    const struct listed_driver *listed = context;
    const struct context_wish wish = {listed->library, listed->driver, 1};
    struct contexts *contexts;
    const bool done = contexts_open(&wish, &contexts, err) && traits_measure(contexts, out, err);
    contexts_close(contexts);
    return done;
}

bool drivers_measure(struct driver_list *drivers, struct error *err)
{
    for (int i = 0; i < drivers->n; i++) {
        struct listed_driver *listed = &drivers->list[i];
        if (!listed->is)
            continue;
        if (is_interrupted())
            return error_system(err, "interrupted");
        listed->traits = malloc(sizeof *listed->traits);
        if (!listed->traits)
            return error_memory(err);
        if (!process_run(measure, listed, listed->traits, sizeof *listed->traits, err))
            return false;
    }
    return true;
}

void drivers_free(struct driver_list *drivers)
{
    for (int i = 0; i < drivers->n; i++) {
        free(drivers->list[i].is);
        free(drivers->list[i].traits);
    }
    free(drivers->list);
    *drivers = (struct driver_list){.n = 0};
}
