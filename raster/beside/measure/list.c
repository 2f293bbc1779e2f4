/* SPDX-License-Identifier: MIT */
/* Tries each library with each driver. A process can open one library only. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster/beside/measure/inside.h"

static struct context_wish wish_of(const struct listed_driver *listed)
{
    struct context_wish wish = {.library = listed->library, .threads = 1};
    wish.way = driver_way(listed->renderer, &wish.driver);
    return wish;
}

static bool describe(void *context, void *out, struct error *err)
{
    const struct context_wish wish = wish_of(context);
    return contexts_describe(&wish, out, err);
}

static bool count_devices(void *context, void *out, struct error *err)
{
    (void)context;
    return contexts_devices(out, err);
}

/* Returns whether a choice is what it asks for, and says more than those before it. */
static bool is_new(const struct listed_driver *listed, const struct driver_list *before)
{
    const struct context_wish wish = wish_of(listed);
    if (!listed->is ||
        (wish.driver && strncmp(listed->is->names.renderer, wish.driver, strlen(wish.driver)) != 0))
        return false;
    for (int i = 0; i < before->n; i++) {
        const struct listed_driver *other = &before->list[i];
        if (other->is && strcmp(other->library, listed->library) == 0 &&
            wish_of(other).way == wish.way &&
            strcmp(other->is->names.renderer, listed->is->names.renderer) == 0)
            return false;
    }
    return true;
}

/* Tries a library with a choice of --renderer; lists it if it says something new. NULL, which comes
 * first, is always listed. */
static bool try_renderer(const char *library, const char *renderer, struct driver_list *out,
                         struct error *err)
{
    struct listed_driver listed = {.renderer = renderer};
    struct context_description is;
    struct error own = {.status = EXIT_AGREED};
    snprintf(listed.library, sizeof listed.library, "%s", library);
    if (process_run(describe, &listed, &is, sizeof is, &own)) {
        if (!MAKE_ARRAY(listed.is, 1, err, "the list of drivers"))
            return false;
        *listed.is = is;
    } else
        snprintf(listed.reason, sizeof listed.reason, "%.500s", error_words(&own));
    if ((!renderer || is_new(&listed, out)) &&
        array_add(&out->list, &out->n, &listed, sizeof listed, err))
        return true;
    free(listed.is);
    return err->status == EXIT_AGREED;
}

/* A library that cannot draw may still draw with shaders. */
static bool try_library(const char *library, struct driver_list *out, struct error *err)
{
    static const char *const renderers[] = {
        NULL,        "llvmpipe",           "softpipe",
        "gl-shader", "gl-shader:llvmpipe", "gl-shader:softpipe",
        "es-shader", "es-shader:llvmpipe", "es-shader:softpipe"};
    enum { ALL = sizeof renderers / sizeof *renderers, WITHOUT_SHADERS = 3 };
    const int n = strcmp(library, "osmesa") == 0 ? WITHOUT_SHADERS : ALL;
    for (int i = 0; i < n; i++)
        if (!try_renderer(library, renderers[i], out, err))
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
    const struct context_wish wish = wish_of(context);
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
        if (!MAKE_ARRAY(listed->traits, 1, err, "the traits of a driver") ||
            !process_run(measure, listed, listed->traits, sizeof *listed->traits, err))
            return false;
    }
    return true;
}

void drivers_free(struct driver_list *drivers)
{
    for (int i = 0; i < drivers->n; i++)
        FREE_ALL(drivers->list[i].is, drivers->list[i].traits);
    free(drivers->list);
    *drivers = (struct driver_list){.n = 0};
}
