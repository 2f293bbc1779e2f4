/* SPDX-License-Identifier: MIT */
/* spectral drivers: lists what OpenGL can draw here, and the options that choose it. Tries each
 * library with each driver. A process can open one library only. */
#include "raster/beside/measure/inside.h"

/* A driver that takes longer to start, or to draw the targets, hangs: those here take a second. */
enum { START_SECONDS = 30 };

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
static bool try_alone(process_job *job, struct listed_driver *driver, void *out, size_t size)
{
    struct error own = {.status = EXIT_AGREED};
    driver->usable = process_run(job, driver, out, size, START_SECONDS, &own);
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
    if (done &&
        !process_run(count_devices, NULL, &n_devices, sizeof n_devices, START_SECONDS, &own))
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

static bool measure(void *context, void *out, struct error *err)
{
    const struct plan_options choice = choice_of(context);
    return driver_measure(&choice, out, err);
}

/* Puts the bounds that were measured, or why there are none; in words as a table, too. */
static void put_bounds(const struct listed_driver *driver, const struct driver *profile,
                       struct json *json)
{
    char words[DRIVER_WORDS];
    if (profile)
        driver_print(profile, words);
    if (json->words)
        print(&json->printed, "  bounds          %s%s\n",
              profile ? "" : "none: ", profile ? words : driver->reason);
    else
        json_string(json, "cannot_be_checked", profile ? NULL : driver->reason);
    if (profile && !json->words)
        traits_json(profile, json);
    else if (profile)
        traits_print(profile, &json->printed);
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
        json_count(json, "subpixel_bits", (uint64_t)is->subpixel_bits);
        json_count(json, "depth_bits", (uint64_t)is->depth_bits);
    }
}

static void print_driver(const struct listed_driver *driver, bool bounded, struct printed *to)
{
    const struct context_description *is = &driver->is;
    char options[64];
    driver_options(driver, options);
    print(to, "%-42s", options);
    if (driver->usable)
        print(to, "%s, %s, %d subpixel and %d depth bits, ", is->names.renderer, is->names.version,
              is->subpixel_bits, is->depth_bits);
    print(to, "%s%s\n",
          bounded          ? "can be checked"
          : driver->usable ? "cannot be checked: "
                           : "cannot draw: ",
          bounded ? "" : driver->reason);
}

static bool run_drivers(struct options *options, struct error *err)
{
    struct driver_list drivers = {.n = 0};
    struct json json;
    bool usable = false, done = drivers_list(&drivers, err);
    (options->json ? json_begin : words_begin)(&json);
    if (!json.words)
        json_open(&json, "drivers", '[');
    for (int i = 0; done && i < drivers.n; i++) {
        struct listed_driver *driver = &drivers.list[i];
        const bool listed = driver->usable;
        struct driver profile;
        const bool bounded = listed && try_alone(measure, driver, &profile, sizeof profile);
        driver->usable = listed;
        usable = usable || listed;
        if (json.words && !options->verbose) {
            print_driver(driver, bounded, &json.printed);
            continue;
        }
        put_driver(driver, &json);
        if (listed)
            put_bounds(driver, bounded ? &profile : NULL, &json);
        json_close(&json, '}');
    }
    json_close(&json, ']');
    done = json_write(&json, options->json, &options->outputs, err);
    free(drivers.list);
    return done && (usable || error_failed(err, "no OpenGL can draw here; --renderer raster can"));
}

static const struct option drivers_rows[] = {
    {"-v, --verbose", "prints all figures: what was measured beside what OpenGL allows",
     SHARED(FLAG, verbose)},
};
const struct command drivers_command = {
    .name = "drivers",
    .operands = "[-v] [--json FILE]",
    .summary = "list what OpenGL can draw here, by which options",
    .example = "drivers",
    .run = run_drivers,
    .rows = OPTION_LIST(drivers_rows),
    .shared = {&json_option},
};
