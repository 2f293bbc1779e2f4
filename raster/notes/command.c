/* SPDX-License-Identifier: MIT */
/* spectral plan: what would be simulated, and why. */
#include <stdio.h>
#include <unistd.h>

#include "data/invocation/invocation.h"
#include "raster/notes/notes.h"

/* Makes the notes on a plan. Refuses what lit_make refuses, as a render does. */
static bool note_plan(const struct plan *plan, struct notes *out, struct error *err)
{
    struct lit_scene lit;
    struct light_work work;
    bool done = lit_make(plan, driver_of(NULL), &lit, &work, err) &&
                notes_make(&lit, MANY_PIXELS, out, err);
    lit_free(&lit);
    return done;
}

/* Prints two digits of seconds, or whole ones. */
static void print_seconds(double seconds, struct printed *to)
{
    print(to, "%.*f", seconds < 1 ? 2 : seconds < 10 ? 1 : 0, seconds);
}

/* Prints both figures of a line: with OpenGL, and without. */
static void print_expected(const char *name, const struct forecast *forecast,
                           void (*print_one)(const struct forecast *forecast,
                                             enum forecast_kind kind, struct printed *to),
                           struct printed *to)
{
    print(to, "%-17s about ", name);
    print_one(forecast, FORECAST_CHECKED, to);
    print_text(to, " with OpenGL and its check, ");
    print_one(forecast, FORECAST_REFERENCE, to);
    print_text(to, " by the reference alone");
}

static void print_seconds_of(const struct forecast *forecast, enum forecast_kind kind,
                             struct printed *to)
{
    print_seconds(forecast->planned + forecast->seconds[kind], to);
}

static void print_peak_of(const struct forecast *forecast, enum forecast_kind kind,
                          struct printed *to)
{
    print(to, "%.0f MiB", forecast->peak_bytes[kind] / 1048576);
}

static void print_forecast(const struct forecast *forecast, struct printed *to)
{
    if (forecast->part.count > 0)
        print(to, "part              %d of %d: %d tiles; the lines below are of these\n",
              forecast->part.number, forecast->part.count, forecast->n_tiles);
    print(to, "disk              %.4g MB%s\n", 1e-6 * forecast->disk_bytes,
          forecast->part.count > 0 ? " for the part" : "");
    print_expected("peak memory", forecast, print_peak_of, to);
    print_text(to, "\n");
    print_expected("seconds", forecast, print_seconds_of, to);
    if (!forecast->learnt[FORECAST_CHECKED])
        print_text(to, "; known better when this machine has rendered something");
    print_text(to, "\n");
}

bool command_plan(struct options *options, struct error *err)
{
    const struct plan_options plan_options = {.threads = options->threads};
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.detector = NULL};
    struct asked_plan asked = {.plan = {.scene = NULL}};
    struct notes notes = {.refined = options->accuracy ? &asked.refined : NULL};
    struct forecast forecast;
    struct picture_part part = {0, 0};
    struct json json;
    const double start = clock_seconds();
    bool done = (!options->part || part_read("--part", options->part, &part, err)) &&
                scene_read_sampled(options, &scene, &sampling, err) &&
                scene_spared(options->json, &scene, err) &&
                plan_asked(options, &plan_options, &scene, &sampling, &asked, err) &&
                forecast_make(&asked.plan, &part, &forecast, err);
    forecast.planned = clock_seconds() - start;
    done = done && note_plan(&asked.plan, &notes, err);
    if (done && options->json) {
        done = plan_json(&asked.plan, &notes, &forecast, &json, err) &&
               json_write(&json, options->json, &options->outputs, err);
    } else if (done) {
        struct printed printed = {.text = NULL};
        done = plan_print(&asked.plan, &printed, err);
        shading_print(&asked.plan, &notes, &printed);
        print_forecast(&forecast, &printed);
        notes_print(&notes, &printed);
        done = printed_show(&printed, STDOUT_FILENO, err) && done;
    }
    notes_free(&notes);
    asked_plan_free(&asked);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}
