/* SPDX-License-Identifier: MIT */
/* spectral plan: what would be simulated, and why. */
#include "raster/render/inside.h"

/* Refuses what lit_make refuses, as a render does. */
static bool run_plan(struct options *options, struct error *err)
{
    struct render_job job = {.options = {.threads = options->threads}};
    struct lit_scene lit = {.plan = NULL};
    struct json json;
    (options->json ? json_begin : words_begin)(&json);
    if (scene_read_sampled(options, &job.scene, &job.sampling, err) &&
        job_plan(options, &job, err) && lit_make(&job.plan, driver_of(NULL), &lit, err) &&
        notes_make(&lit, MANY_PIXELS, &job.notes, err)) {
        plan_facts(&job.plan, &json);
        if (job.notes.shading)
            shading_judge->put(&job.plan, job.notes.shading, &json);
        notes_put(&job.notes, &json);
        plan_put_files(&job.plan, options->detector, &json, err);
    }
    const bool done = json_write(&json, options->json, &options->outputs, err);
    lit_free(&lit);
    job_free(&job);
    return done;
}

const struct command plan_command = {
    .name = "plan",
    .operands = "[SCENE]",
    .summary = "print what would be simulated, and why; draw nothing",
    .example = "plan fluorescence",
    .run = run_plan,
    .shared = {&scene_options, &shading_options, &accuracy_options, &sampling_options,
               &threads_option, &json_option},
    .n_operands = 1,
};
