/* SPDX-License-Identifier: MIT */
/* spectral drivers: lists what OpenGL can draw here, and the options that choose it. Tries each
 * library with each driver. A process can open one library only. */
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
    if (!listed->usable ||
        (wish.driver && strncmp(listed->is.names.renderer, wish.driver, strlen(wish.driver)) != 0))
        return false;
    for (int i = 0; i < before->n; i++) {
        const struct listed_driver *other = &before->list[i];
        if (other->usable && strcmp(other->library, listed->library) == 0 &&
            wish_of(other).way == wish.way &&
            strcmp(other->is.names.renderer, listed->is.names.renderer) == 0)
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
    struct error own = {.status = EXIT_AGREED};
    snprintf(listed.library, sizeof listed.library, "%s", library);
    listed.usable = process_run(describe, &listed, &listed.is, sizeof listed.is, &own);
    snprintf(listed.reason, sizeof listed.reason, "%.500s", error_words(&own));
    return (renderer && !is_new(&listed, out)) ||
           array_add(&out->list, &out->n, &listed, sizeof listed, err);
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

/* ---- the command ---- */

struct drivers_options {
    bool measure;
};

static bool measure(void *context, void *out, struct error *err)
{
    const struct context_wish wish = wish_of(context);
    struct contexts *contexts;
    const bool done = contexts_open(&wish, &contexts, err) && traits_measure(contexts, out, err);
    contexts_close(contexts);
    return done;
}

/* Returns the profile by which a render judges a driver. */
static const char *profile_of(const struct context_description *is)
{
    const struct driver *known = driver_of(is->names.renderer);
    return known == driver_of(NULL) ? "measured" : known->name;
}

/* Prints the options, and what they choose; what was measured (NULL: nothing), and the bounds of a
 * driver that does so. */
static void print_driver(const struct listed_driver *driver, const struct traits *traits,
                         struct json *json)
{
    const struct context_description *is = &driver->is;
    struct printed *to = &json->printed;
    struct driver profile;
    struct error refused = {.status = EXIT_AGREED};
    char words[DRIVER_WORDS];
    print(to, "--gl %s%s%s\n", driver->library, driver->renderer ? " --renderer " : "",
          driver->renderer ? driver->renderer : "");
    if (!driver->usable) {
        print(to, "  cannot draw: %s\n", driver->reason);
        return;
    }
    print(to,
          "  renderer        %s, by %s\n  version         %s, of %s\n  profile         %s\n"
          "  largest         %d x %d pixels, textures of %d x %d texels\n",
          is->names.renderer, is->names.library, is->names.version, is->vendor, profile_of(is),
          is->largest_viewport[0], is->largest_viewport[1], is->largest_texture,
          is->largest_texture);
    if (!traits)
        return;
    traits_print(traits, to);
    const bool bounded = traits_profile(traits, &profile, &refused);
    if (bounded)
        driver_print(&profile, words);
    print(to, "  bounds          %s%s\n",
          bounded ? "" : "none: ", bounded ? words : error_words(&refused));
}

static void json_bounds(const struct driver *of, struct json *json)
{
    json_open(json, "measured_bounds", '{');
    json_number(json, "edge_px", of->grid_px);
    json_number(json, "value_px", of->corner_px);
    json_number(json, "depth_steps", of->depth_roundings);
    json_number(json, "filter_texels", of->filter_texels);
    json_number(json, "lighting", of->lighting);
    json_truth(json, "watertight", of->watertight);
    json_truth(json, "exact_fill_rule", of->fill_rule != FILL_ANY);
    json_close(json, '}');
}

static void json_driver(const struct listed_driver *driver, const struct traits *traits,
                        struct json *json)
{
    const struct context_description *is = &driver->is;
    struct driver profile;
    struct error refused = {.status = EXIT_AGREED};
    json_open(json, NULL, '{');
    json_string(json, "gl", driver->library);
    json_string(json, "renderer", driver->renderer);
    json_truth(json, "usable", driver->usable);
    json_string(json, "reason", driver->usable ? NULL : driver->reason);
    if (driver->usable) {
        json_string(json, "gl_library", is->names.library);
        json_string(json, "gl_vendor", is->vendor);
        json_string(json, "gl_renderer", is->names.renderer);
        json_string(json, "gl_version", is->names.version);
        json_string(json, "driver_profile", profile_of(is));
        json_count(json, "largest_width", (uint64_t)is->largest_viewport[0]);
        json_count(json, "largest_height", (uint64_t)is->largest_viewport[1]);
        json_count(json, "largest_texture", (uint64_t)is->largest_texture);
    }
    if (traits) {
        const bool bounded = traits_profile(traits, &profile, &refused);
        traits_json(traits, json);
        json_string(json, "cannot_be_checked", bounded ? NULL : error_words(&refused));
        if (bounded)
            json_bounds(&profile, json);
    }
    json_close(json, '}');
}

static bool run_drivers(struct options *options, struct error *err)
{
    const struct drivers_options *own = options->own;
    struct driver_list drivers;
    struct json json;
    bool usable = false, done = drivers_list(&drivers, err);
    (options->json ? json_begin : words_begin)(&json);
    json_open(&json, "drivers", '[');
    for (int i = 0; done && i < drivers.n; i++) {
        struct listed_driver *driver = &drivers.list[i];
        struct traits traits;
        const bool measured = own->measure && driver->usable;
        done = !measured || process_run(measure, driver, &traits, sizeof traits, err);
        usable = usable || driver->usable;
        if (done)
            (options->json ? json_driver : print_driver)(driver, measured ? &traits : NULL, &json);
    }
    json_close(&json, ']');
    if (!done)
        free(printed_end(&json.printed));
    done = done && json_write(&json, options->json, &options->outputs, err);
    free(drivers.list);
    return done && (usable || error_failed(err, "no OpenGL can draw here; --renderer raster can"));
}

static const struct option drivers_rows[] = {
    {"--measure", "measures what each one does where OpenGL leaves it free",
     OWN(FLAG, drivers_options, measure)},
};
static const struct option_list driver_options = OPTION_LIST(drivers_rows);
static const struct option_list *const lists[] = {&driver_options, &json_option, &common_options,
                                                  NULL};
const struct command drivers_command = {
    .name = "drivers",
    .operands = "[--measure] [--json FILE]",
    .summary = "list what OpenGL can draw here, by which options",
    .example = "drivers",
    .run = run_drivers,
    .lists = lists,
    .own_size = sizeof(struct drivers_options),
};
