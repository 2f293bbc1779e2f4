/* SPDX-License-Identifier: MIT */
/* A model of seconds, and what this machine makes of them. */
#include <stdlib.h>

#include "data/threads/threads.h"
#include "raster/forecast/forecast.h"
#include "raster/passes/passes.h"

/* Seconds of a virtual machine with two processors of an AMD EPYC, for each: triangle that OpenGL
 * draws in a pass; position in a band; triangle; position. Fitted to renders of the nine built-in
 * scenes, whose seconds are 0.7 to 1.2 of these. */
struct model {
    double start, drawn_triangle, sample, triangle, position;
    /* Bytes of the program and of OpenGL; of each triangle; of each byte that a plan gives a tile.
     * The peaks of the same scenes, in three sizes each, are 0.78 to 1.36 of these, and 0.68 to
     * 1.48 by the reference alone. */
    double bytes, triangle_bytes, tile;
};
static const struct model models[FORECAST_KINDS] = {
    [FORECAST_CHECKED] = {0.02, 1.4e-7, 7.9e-9, 2.1e-6, 3.4e-7, 78e6, 230, 1},
    [FORECAST_REFERENCE] = {0.01, 0, 1.6e-9, 9.6e-7, 1.1e-7, 5e6, 110, 0.2}};

/* Counts the passes that OpenGL draws of a tile. */
static bool count_passes(const struct plan *plan, long *out, struct error *err)
{
    struct passes passes;
    const bool done = passes_make(plan, &passes, err);
    *out = 0;
    for (int group = 0; done && group < plan->n_light_groups; group++)
        *out += group_is_drawn(plan, group) ? passes.n_frames : 0;
    passes_free(&passes);
    return done;
}

/* The work that a plan, or a part of it, asks for. */
struct load {
    double passes, positions, triangles;
};

static double model_seconds(const struct plan *plan, const struct load *load,
                            const struct model *model)
{
    return model->start + model->drawn_triangle * load->passes * load->triangles +
           model->sample * load->positions * plan->n_bands + model->triangle * load->triangles +
           model->position * load->positions;
}

/* Fills all but the seconds and the bytes of memory. Each part lights all triangles. */
static bool find_load(const struct plan *plan, struct forecast *forecast, struct load *out,
                      struct error *err)
{
    int *tiles;
    long passes;
    if (!count_passes(plan, &passes, err) ||
        !part_deal(plan, &forecast->part, &tiles, &forecast->n_tiles, err))
        return false;
    const double share = part_share(plan, tiles, forecast->n_tiles);
    free(tiles);
    forecast->disk_bytes = share * (double)plan->file_bytes;
    *out = (struct load){.passes = (double)passes * forecast->n_tiles,
                         .positions = share * plan->view.width * plan->view.height,
                         .triangles = (double)plan->n_triangles};
    return true;
}

bool forecast_make(const struct plan *plan, const struct picture_part *part, struct forecast *out,
                   struct error *err)
{
    double pace[FORECAST_KINDS];
    struct load load;
    *out = (struct forecast){.part = *part};
    if (!find_load(plan, out, &load, err))
        return false;
    pace_read(pace);
    for (int kind = 0; kind < FORECAST_KINDS; kind++) {
        const struct model *model = &models[kind];
        out->learnt[kind] = pace[kind] > 0;
        out->seconds[kind] =
            model_seconds(plan, &load, model) * (out->learnt[kind] ? pace[kind] : 1);
        out->peak_bytes[kind] = model->bytes + model->triangle_bytes * load.triangles +
                                model->tile * (double)plan->tile_bytes;
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
    struct forecast whole = {.part = {0, 0}};
    struct load load;
    if (!kind_of(plan, &kind) || !find_load(plan, &whole, &load, &ignored))
        return;
    const double expected = model_seconds(plan, &load, &models[kind]);
    if (expected < least_seconds[kind])
        return;
    pace_read(pace);
    pace[kind] = seconds / expected;
    pace_write(pace);
}
