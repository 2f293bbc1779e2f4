/* SPDX-License-Identifier: MIT */
/* spectral drivers: lists what OpenGL can draw here, and the options that choose it. */
#include <stdio.h>
#include <stdlib.h>

#include "raster/beside/measure/inside.h"

struct drivers_options {
    bool measure;
};

/* Returns the profile by which a render judges a driver. */
static const char *profile_of(const struct context_description *is)
{
    const struct driver *known = driver_of(is->names.renderer);
    return known == driver_of(NULL) ? "measured" : known->name;
}

/* Prints the options, and what they choose; what was measured, and the bounds of a driver that does
 * so. */
static void print_driver(const struct listed_driver *driver, struct printed *to)
{
    const struct context_description *is = driver->is;
    struct driver profile;
    char words[DRIVER_WORDS], reason[TRAITS_REASON];
    print(to, "--gl %s%s%s\n", driver->library, driver->renderer ? " --renderer " : "",
          driver->renderer ? driver->renderer : "");
    if (!is) {
        print(to, "  cannot draw: %s\n", driver->reason);
        return;
    }
    print(to,
          "  renderer        %s, by %s\n  version         %s, of %s\n  profile         %s\n"
          "  largest         %d x %d pixels, textures of %d x %d texels\n",
          is->names.renderer, is->names.library, is->names.version, is->vendor, profile_of(is),
          is->largest_viewport[0], is->largest_viewport[1], is->largest_texture,
          is->largest_texture);
    if (!driver->traits)
        return;
    traits_print(driver->traits, to);
    const bool bounded = traits_profile(driver->traits, &profile, reason);
    if (bounded)
        driver_print(&profile, words);
    print(to, "  bounds          %s%s\n", bounded ? "" : "none: ", bounded ? words : reason);
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

static void json_driver(const struct listed_driver *driver, struct json *json)
{
    const struct context_description *is = driver->is;
    struct driver profile;
    char reason[TRAITS_REASON];
    json_open(json, NULL, '{');
    json_string(json, "gl", driver->library);
    json_string(json, "renderer", driver->renderer);
    json_truth(json, "usable", is != NULL);
    json_string(json, "reason", is ? NULL : driver->reason);
    if (is) {
        json_string(json, "gl_library", is->names.library);
        json_string(json, "gl_vendor", is->vendor);
        json_string(json, "gl_renderer", is->names.renderer);
        json_string(json, "gl_version", is->names.version);
        json_string(json, "driver_profile", profile_of(is));
        json_count(json, "largest_width", (uint64_t)is->largest_viewport[0]);
        json_count(json, "largest_height", (uint64_t)is->largest_viewport[1]);
        json_count(json, "largest_texture", (uint64_t)is->largest_texture);
    }
    if (is && driver->traits) {
        const bool bounded = traits_profile(driver->traits, &profile, reason);
        traits_json(driver->traits, json);
        json_string(json, "cannot_be_checked", bounded ? NULL : reason);
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
    bool usable = false,
         done = drivers_list(&drivers, err) && (!own->measure || drivers_measure(&drivers, err));
    (options->json ? json_begin : words_begin)(&json);
    json_open(&json, "drivers", '[');
    for (int i = 0; done && i < drivers.n; i++) {
        usable = usable || drivers.list[i].is;
        if (options->json)
            json_driver(&drivers.list[i], &json);
        else
            print_driver(&drivers.list[i], &json.printed);
    }
    json_close(&json, ']');
    if (!done)
        free(printed_end(&json.printed));
    done = done && json_write(&json, options->json, &options->outputs, err);
    drivers_free(&drivers);
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
