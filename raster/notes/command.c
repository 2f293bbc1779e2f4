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

/* Seconds have two digits, or whole numbers. */
static int decimals(double seconds)
{
    return seconds < 1 ? 2 : seconds < 10 ? 1 : 0;
}

static void print_forecast(const struct forecast *forecast, struct printed *to)
{
    const double mib = 1048576, *bytes = forecast->peak_bytes,
                 checked = forecast->planned + forecast->seconds[FORECAST_CHECKED],
                 alone = forecast->planned + forecast->seconds[FORECAST_REFERENCE];
    if (forecast->part.count > 0)
        print(to, "part              %d of %d: %d tiles; the lines below are of these\n",
              forecast->part.number, forecast->part.count, forecast->n_tiles);
    print(to, "disk              %.4g MB%s\n", 1e-6 * forecast->disk_bytes,
          forecast->part.count > 0 ? " for the part" : "");
    print(to,
          "peak memory       about %.0f MiB with OpenGL and its check, %.0f MiB by the reference "
          "alone\n",
          bytes[FORECAST_CHECKED] / mib, bytes[FORECAST_REFERENCE] / mib);
    print(to,
          "seconds           about %.*f with OpenGL and its check, %.*f by the reference alone%s\n",
          decimals(checked), checked, decimals(alone), alone,
          forecast->learnt[FORECAST_CHECKED]
              ? ""
              : "; known better when this machine has rendered something");
}

bool command_plan(struct options *options, struct error *err)
{
    const struct plan_options plan_options = {.threads = options->threads};
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.detector = NULL};
    struct plan plan = {.scene = NULL};
    struct refine_result refined = {.levels = 0};
    struct notes notes = {.refined = options->accuracy ? &refined : NULL};
    struct forecast forecast;
    struct picture_part part = {0, 0};
    struct json json;
    const double start = clock_seconds();
    bool done = (!options->part || part_read("--part", options->part, &part, err)) &&
                scene_read_sampled(options, &scene, &sampling, err) &&
                scene_spared(options->json, &scene, err) &&
                plan_make(&scene, sampling_or_none(&sampling), &plan_options, &plan, err) &&
                refine_options(options, &plan, &refined, err) &&
                forecast_make(&plan, &part, &forecast, err);
    forecast.planned = clock_seconds() - start;
    done = done && note_plan(&plan, &notes, err);
    if (done && options->json) {
        done = plan_json(&plan, &notes, &forecast, &json, err) &&
               json_write(&json, options->json, &options->outputs, err);
    } else if (done) {
        struct printed printed = {.text = NULL};
        done = plan_print(&plan, &printed, err);
        shading_print(&plan, &notes, &printed);
        print_forecast(&forecast, &printed);
        notes_print(&notes, &printed);
        done = printed_show(&printed, STDOUT_FILENO, err) && done;
    }
    notes_free(&notes);
    refine_result_free(&refined);
    plan_free(&plan);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}
