/* SPDX-License-Identifier: MIT */
/* spectral plan: what would be simulated, and why. */
#include <stdlib.h>

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
    (options->json ? json_begin : words_begin)(&json);
    bool done = scene_read_sampled(options, &scene, &sampling, err) &&
                plan_make(&scene, sampling_or_none(&sampling), &plan_options, &plan, err) &&
                refine_options(options, &plan, &refined, err) &&
                notes_of_plan(&plan, MANY_PIXELS, &notes, err) &&
                plan_facts(&plan, &notes, &json, err) &&
                json_write(&json, options->json, &options->outputs, err);
    free(printed_end(&json.printed)); /* after a failure */
    notes_free(&notes);
    refine_result_free(&refined);
    plan_free(&plan);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}
