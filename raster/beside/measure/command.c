/* SPDX-License-Identifier: MIT */
/* spectral drivers: lists what OpenGL can draw here, and the options that choose it. Tries each
 * library with each driver. A process can open one library only. */
#include <stdlib.h>
#include <string.h>

#include "raster/beside/measure/inside.h"
#include "raster/gl/gl.h"

/* The options of a plan that choose the library and the driver. */
static struct plan_options choice_of(const struct listed_driver *listed)
{
    struct plan_options choice = {.gl_library = listed->library, .threads = 1};
    choice.gl_way = driver_way(listed->renderer, &choice.gl_driver);
    return choice;
}

static bool describe(void *context, void *out, struct error *err)
{
    const struct plan_options choice = choice_of(context);
    return contexts_describe(&choice, out, err);
}

static bool count_devices(void *context, void *out, struct error *err)
{
    (void)context;
    return contexts_devices(out, err);
}

/* Uses a driver in a process of its own. One that fails there is not usable, and has the reason. */
static bool try_alone(bool (*job)(void *context, void *out, struct error *err),
                      struct listed_driver *driver, void *out, size_t size)
{
    struct error own = {.status = EXIT_AGREED};
    driver->usable = process_run(job, driver, out, size, &own);
    snprintf(driver->reason, sizeof driver->reason, "%.500s", error_words(&own));
    return driver->usable;
}

static bool is_same(const struct listed_driver *a, const struct listed_driver *b)
{
    const struct renderer_names *one = &a->is.names, *two = &b->is.names;
    return a->usable && b->usable && choice_of(a).gl_way == choice_of(b).gl_way &&
           strcmp(one->library, two->library) == 0 && strcmp(one->renderer, two->renderer) == 0 &&
           strcmp(one->version, two->version) == 0;
}

bool drivers_add(struct driver_list *to, const char *library, const char *renderer, bool new_only,
                 struct error *err)
{
    struct listed_driver added = {.renderer = renderer};
    snprintf(added.library, sizeof added.library, "%s", library);
    try_alone(describe, &added, &added.is, sizeof added.is);
    const char *driver = choice_of(&added).gl_driver;
    bool is_new =
        added.usable && (!driver || strncmp(added.is.names.renderer, driver, strlen(driver)) == 0);
    for (int i = 0; i < to->n; i++)
        if (is_same(&added, &to->list[i])) {
            added.again = true;
            is_new = is_new && strcmp(to->list[i].library, library) != 0;
        }
    return (new_only && !is_new) || array_add(&to->list, &to->n, &added, sizeof added, err);
}

/* A library that cannot draw may still draw with shaders. */
static bool try_library(const char *library, struct driver_list *to, struct error *err)
{
    const int n_ways = strcmp(library, "osmesa") == 0 ? 1 : GL_WAYS;
    for (int i = 0; i < n_ways * WAY_WORDS; i++)
        if (!drivers_add(to, library, i > 0 ? renderer_words[i] : NULL, i > 0, err))
            return false;
    return true;
}

bool drivers_list(struct driver_list *to, struct error *err)
{
    struct error own = {.status = EXIT_AGREED};
    char library[16];
    int n_devices = 0;
    bool done = try_library("osmesa", to, err) && try_library("egl", to, err);
    if (done && !process_run(count_devices, NULL, &n_devices, sizeof n_devices, &own))
        n_devices = 0;
    for (int i = 0; i < n_devices && done; i++) {
        snprintf(library, sizeof library, "egl:%d", i);
        done = try_library(library, to, err);
    }
    return done;
}

void driver_options(const struct listed_driver *driver, char out[64])
{
    snprintf(out, 64, "--gl %s%s%s", driver->library, driver->renderer ? " --renderer " : "",
             driver->renderer ? driver->renderer : "");
}

const char *driver_profile(const struct listed_driver *driver)
{
    const struct driver *known = driver_of(driver->is.names.renderer);
    return !driver->usable ? "" : driver_is_known(known) ? known->name : "measured";
}

/* ---- the command ---- */

struct drivers_options {
    bool measure;
};

static bool measure(void *context, void *out, struct error *err)
{
    const struct plan_options choice = choice_of(context);
    return driver_measure(&choice, out, err);
}

/* Measures a driver, and puts its bounds, or why there are none. verbose: as a table, too. */
static void put_bounds(struct listed_driver *driver, bool verbose, struct json *json)
{
    struct driver profile;
    char words[DRIVER_WORDS];
    const bool bounded = try_alone(measure, driver, &profile, sizeof profile);
    if (bounded)
        driver_print(&profile, words);
    if (json->words)
        print(&json->printed, "  bounds          %s%s\n",
              bounded ? "" : "none: ", bounded ? words : driver->reason);
    else
        json_string(json, "cannot_be_checked", bounded ? NULL : driver->reason);
    if (bounded && !json->words)
        traits_json(&profile, json);
    else if (bounded && verbose)
        traits_print(&profile, &json->printed);
}

/* Puts the options, and what they choose. */
static void put_driver(const struct listed_driver *driver, struct json *json)
{
    const struct context_description *is = &driver->is;
    char options[64];
    driver_options(driver, options);
    json_open(json, json->words ? options : NULL, '{');
    if (!json->words) {
        json_string(json, "gl", driver->library);
        json_string(json, "renderer", driver->renderer);
        json_truth(json, "usable", driver->usable);
    }
    json_string(json, json->words ? "cannot_draw" : "reason",
                driver->usable ? NULL : driver->reason);
    if (driver->usable) {
        json_string(json, "gl_library", is->names.library);
        json_string(json, "gl_vendor", is->vendor);
        json_string(json, "gl_renderer", is->names.renderer);
        json_string(json, "gl_version", is->names.version);
        json_string(json, "driver_profile", driver_profile(driver));
        json_count(json, "largest_width", (uint64_t)is->largest_viewport[0]);
        json_count(json, "largest_height", (uint64_t)is->largest_viewport[1]);
        json_count(json, "largest_texture", (uint64_t)is->largest_texture);
    }
}

static bool run_drivers(struct options *options, struct error *err)
{
    const struct drivers_options *own = options->own;
    struct driver_list drivers = {.n = 0};
    struct json json;
    bool usable = false, done = drivers_list(&drivers, err);
    (options->json ? json_begin : words_begin)(&json);
    if (!json.words)
        json_open(&json, "drivers", '[');
    for (int i = 0; done && i < drivers.n; i++) {
        struct listed_driver *driver = &drivers.list[i];
        put_driver(driver, &json);
        usable = usable || driver->usable;
        if (own->measure && driver->usable)
            put_bounds(driver, options->verbose, &json);
        json_close(&json, '}');
    }
    json_close(&json, ']');
    done = json_write(&json, options->json, &options->outputs, err);
    free(drivers.list);
    return done && (usable || error_failed(err, "no OpenGL can draw here; --renderer raster can"));
}

static const struct option drivers_rows[] = {
    {"--measure", "measures how far each one goes where OpenGL leaves it free",
     OWN(FLAG, drivers_options, measure)},
    {"-v, --verbose", "prints each trait, and what OpenGL allows, too", SHARED(FLAG, verbose),
     .needs = "--measure"},
};
const struct command drivers_command = {
    .name = "drivers",
    .operands = "[--measure [-v]] [--json FILE]",
    .summary = "list what OpenGL can draw here, by which options",
    .example = "drivers",
    .run = run_drivers,
    .rows = OPTION_LIST(drivers_rows),
    .shared = {&json_option},
    .own_size = sizeof(struct drivers_options),
};
