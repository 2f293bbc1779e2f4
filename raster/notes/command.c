/* SPDX-License-Identifier: MIT */
/* spectral plan: what would be simulated, and why. */
#include <stdio.h>
#include <unistd.h>

#include "data/invocation/invocation.h"
#include "raster/notes/notes.h"

bool command_plan(struct options *options, struct error *err)
{
    const struct plan_options plan_options = {.threads = options->threads,
                                              .detector = options->detector};
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.detector = NULL};
    struct plan plan = {.scene = NULL};
    struct refine_result refined = {.levels = 0};
    struct notes notes = {.refined = options->accuracy ? &refined : NULL};
    struct json json;
    bool done = scene_read_sampled(options, &scene, &sampling, err) &&
                plan_make(&scene, sampling_or_none(&sampling), &plan_options, &plan, err) &&
                refine_options(options, &plan, &refined, err) &&
                notes_of_plan(&plan, MANY_PIXELS, &notes, err);
    if (done && options->json) {
        done = plan_json(&plan, &notes, &json, err) &&
               json_write(&json, options->json, &options->outputs, err);
    } else if (done) {
        struct printed printed = {.text = NULL};
        done = plan_print(&plan, &printed, err);
        shading_print(&plan, &notes, &printed);
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
