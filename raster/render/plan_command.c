/* SPDX-License-Identifier: MIT */
/* spectral plan: what would be simulated, and why. */
#include <stdlib.h>

#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "raster/render/inside.h"

static bool put_plan(const struct plan *plan, const struct notes *notes, const char *detector,
                     struct json *json, struct error *err)
{
    plan_facts(plan, json);
    notes_put_shading(plan, notes, json);
    notes_put(notes, json);
    return plan_put_files(plan, detector, json, err);
}

static bool run_plan(struct options *options, struct error *err)
{
    const struct plan_options plan_options = {.threads = options->threads};
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.detector = NULL};
    struct plan plan = {.scene = NULL};
    struct notes notes = {.n = 0};
    struct json json;
    (options->json ? json_begin : words_begin)(&json);
    bool done = scene_read_sampled(options, &scene, &sampling, err) &&
                plan_make(&scene, sampling_or_none(&sampling), &plan_options, &plan, err) &&
                notes_refine(options, &plan, &notes, err) &&
                notes_of_plan(&plan, MANY_PIXELS, &notes, err) &&
                put_plan(&plan, &notes, options->detector, &json, err) &&
                json_write(&json, options->json, &options->outputs, err);
    free(printed_end(&json.printed)); /* after a failure */
    notes_free(&notes);
    plan_free(&plan);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}

static const struct option_list *const lists[] = {
    &scene_options,  &shading_options, &accuracy_options, &sampling_options,
    &threads_option, &json_option,     &common_options,   NULL};
const struct command plan_command = {
    .name = "plan",
    .operands = "[SCENE]",
    .summary = "print what would be simulated, and why; draw nothing",
    .example = "plan fluorescence",
    .run = run_plan,
    .lists = lists,
    .n_operands = 1,
};
