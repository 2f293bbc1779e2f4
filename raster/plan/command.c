/* SPDX-License-Identifier: MIT */
/* spectral plan: what would be simulated, and why. */
#include <stdio.h>

#include "commands.h"
#include "raster/raster.h"

bool scene_read_sampled(const struct options *options, struct scene *out, struct error *err)
{
    struct sampling_method method;
    if (!options->sampling)
        return options->detector ? error_usage(err, "--detector is for whom --sampling samples; "
                                                    "develop shows a stack to any detector")
                                 : scene_read_options(options, out, err);
    return sampling_read("--sampling", options->sampling, &method, err) &&
           scene_read_options(options, out, err) &&
           scene_sample(out, &method, options_detector(options), err);
}

bool command_plan(struct options *options, struct error *err)
{
    const struct plan_options plan_options = {.check = false};
    struct scene scene = {.path = NULL};
    struct plan plan = {.scene = NULL};
    bool done =
        scene_read_sampled(options, &scene, err) && plan_make(&scene, &plan_options, &plan, err);
    if (done)
        plan_print(&plan, stdout);
    plan_free(&plan);
    scene_free(&scene);
    return done;
}
