/* SPDX-License-Identifier: MIT */
/* A model of seconds, and what this machine makes of them. */
#include "data/threads/threads.h"
#include "raster/forecast/forecast.h"
#include "raster/passes/passes.h"

/* Seconds of a virtual machine with two processors of an AMD EPYC, for each: triangle that OpenGL
 * draws in a pass; position in a band; triangle; position. Fitted to renders of the nine built-in
 * scenes, whose seconds are 0.7 to 1.2 of these. */
struct model {
    double start, drawn_triangle, sample, triangle, position;
};
static const struct model models[FORECAST_KINDS] = {
    [FORECAST_CHECKED] = {0.02, 1.4e-7, 7.9e-9, 2.1e-6, 3.4e-7},
    [FORECAST_REFERENCE] = {0.01, 0, 1.6e-9, 9.6e-7, 1.1e-7}};

/* Counts the passes that OpenGL draws of the whole picture. */
static bool count_passes(const struct plan *plan, long *out, struct error *err)
{
    const struct rectangle picture = plan_picture(plan);
    struct passes passes;
    const bool done = passes_make(plan, &passes, err);
    *out = 0;
    for (int group = 0; done && group < plan->n_light_groups; group++)
        *out += group_is_drawn(plan, group) ? passes.n_frames : 0;
    *out *= plan_tiles(plan, &picture);
    passes_free(&passes);
    return done;
}

static double model_seconds(const struct plan *plan, long passes, const struct model *model)
{
    const double positions = (double)plan->view.width * plan->view.height,
                 triangles = (double)plan->n_triangles;
    return model->start + model->drawn_triangle * (double)passes * triangles +
           model->sample * positions * plan->n_bands + model->triangle * triangles +
           model->position * positions;
}

bool forecast_make(const struct plan *plan, struct forecast *out, struct error *err)
{
    double pace[FORECAST_KINDS];
    long passes;
    *out = (struct forecast){.learnt = {false, false}};
    if (!count_passes(plan, &passes, err))
        return false;
    pace_read(pace);
    for (int kind = 0; kind < FORECAST_KINDS; kind++) {
        out->learnt[kind] = pace[kind] > 0;
        out->seconds[kind] =
            model_seconds(plan, passes, &models[kind]) * (out->learnt[kind] ? pace[kind] : 1);
    }
    return true;
}

/* In shorter renders the beginning weighs too much: Mesa may compile its shaders anew. */
static const double least_seconds[FORECAST_KINDS] = {
    [FORECAST_CHECKED] = 0.5, [FORECAST_REFERENCE] = 0.1};

/* Finds the kind of a render; false if none is like it. */
static bool kind_of(const struct plan *plan, enum forecast_kind *out)
{
    const struct plan_options *options = &plan->options;
    *out = options->use_gl ? FORECAST_CHECKED : FORECAST_REFERENCE;
    return options->check == options->use_gl && !options->gl_driver &&
           options->gl_way == GL_WITHOUT_SHADERS && buffer_steps(plan) == 0 &&
           plan->view.shading != PHONG && options->threads == threads_count(0);
}

void forecast_learn(const struct plan *plan, double seconds)
{
    double pace[FORECAST_KINDS];
    enum forecast_kind kind;
    struct error ignored = {.status = EXIT_AGREED};
    long passes;
    if (!kind_of(plan, &kind) || !count_passes(plan, &passes, &ignored))
        return;
    const double expected = model_seconds(plan, passes, &models[kind]);
    if (expected < least_seconds[kind])
        return;
    pace_read(pace);
    pace[kind] = seconds / expected;
    pace_write(pace);
}
