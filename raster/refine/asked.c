/* SPDX-License-Identifier: MIT */
/* The plan of a scene as the command line asks for it: with wavelengths that --accuracy chooses,
 * and refined. */
#include <stdlib.h>

#include "data/invocation/invocation.h"
#include "raster/refine/refine.h"

/* So much of the wanted error may come from wavelengths; shading and wavelengths seldom err in the
 * same direction. */
static const double wavelengths_share = 0.5;

/* Finds the sampling that the colours of a plan need. */
static bool choose(const struct plan *plan, const char *observer, double error,
                   struct sampling_method *out, struct error *err)
{
    enum { SOME_PIXELS = 2048 };
    struct seen_pixels seen = {.pixels = NULL};
    struct shown_colours colours = {.n = 0};
    struct surface *surfaces = surfaces_place(plan, err);
    bool done = surfaces && seen_find(plan, surfaces, SOME_PIXELS, &seen, err) &&
                accuracy_colours(plan, surfaces, &seen, &colours, err);
    const struct stimuli stimuli = {.materials = colours.materials,
                                    .n_materials = plan->n_materials,
                                    .n = colours.n,
                                    .list = colours.list};
    done = done && sampling_choose(plan->scene, observer, error, &stimuli, out, err);
    surfaces_close(surfaces, plan->n_instances);
    shown_colours_free(&colours);
    seen_free(&seen);
    return done;
}

/* Samples the scene as --accuracy needs it. Counts are those of single bands, whose wavelengths
 * stay.
 */
static bool sample(const struct options *options, const struct plan_options *plan_options,
                   struct scene *scene, struct sampling *sampling, struct error *err)
{
    struct wanted_accuracy wanted;
    struct sampling_method method;
    struct plan plan = {.scene = NULL};
    if (!accuracy_read("--accuracy", options->accuracy, &wanted, err))
        return false;
    if (wanted.counts)
        return true;
    const char *observer = options_detector(options);
    const bool done = plan_make(scene, NULL, plan_options, &plan, err) &&
                      choose(&plan, observer, wavelengths_share * wanted.error, &method, err);
    plan_free(&plan);
    return done && scene_sample(scene, &method, observer, sampling, err);
}

bool plan_asked(const struct options *options, const struct plan_options *plan_options,
                struct scene *scene, struct sampling *sampling, struct asked_plan *out,
                struct error *err)
{
    *out = (struct asked_plan){.plan = {.scene = NULL}};
    if (options->accuracy && !gives_wavelengths(options) &&
        !sample(options, plan_options, scene, sampling, err))
        return false;
    return plan_make(scene, sampling_or_none(sampling), plan_options, &out->plan, err) &&
           refine_options(options, &out->plan, &out->refined, err);
}

void asked_plan_free(struct asked_plan *asked)
{
    refine_result_free(&asked->refined);
    plan_free(&asked->plan);
}
