/* SPDX-License-Identifier: MIT */
/* Judges the triangle that OpenGL names at each pixel, its depth, and the number of fragments. */
#include <math.h>

#include "raster/check/inside.h"

static const double depth_steps = 16777215;

/* Returns whether OpenGL's depth is within the error; the background's is 1. Beyond the near or the
 * far plane, where a cut edge may still cover a centre, OpenGL stores the nearest depth that it
 * can. */
static bool fits_depth(struct check *check, const struct shown *shown, double depth, double error)
{
    double off = fabs(shown->depth / depth_steps - fmin(fmax(depth, 0), 1));
    if (off <= error && error > 0 && error < HUGE_VAL)
        check->verdict.worst_depth_ratio = fmax(check->verdict.worst_depth_ratio, off / error);
    return off <= error;
}

static struct check_failure depth_failure(const struct shown *shown, double depth, double error)
{
    return (struct check_failure){.kind = FAILURE_DEPTH,
                                  .seen = shown->depth / depth_steps,
                                  .expected = depth,
                                  .bound = error};
}

/* The depth is rounded to single precision, as those of candidates: depth_error covers that. */
static void identify_settled(struct check *check, size_t pixel, const struct shown *shown,
                             const struct renderer_lacks *lacks)
{
    const struct chunk *chunk = check->chunk;
    bool background = chunk->picture.surface[pixel] < 0;
    double depth = background ? 1 : (double)(float)chunk->picture.depth[pixel],
           error = background ? 0 : (double)chunk->pixels[pixel].depth_error;
    struct check_failure failure = {.kind = FAILURE_TRIANGLE, .shown = *shown};
    if (lacks->numbers || (shown->surface == chunk->picture.surface[pixel] &&
                           (background || shown->triangle == chunk->picture.triangle[pixel]))) {
        if (lacks->depths || fits_depth(check, shown, depth, error))
            return;
        failure = depth_failure(shown, depth, error);
    }
    check_fail(check, pixel, &failure);
}

/* Only the hypothesis that OpenGL shows stays alive. */
static void identify_ambiguous(struct check *check, size_t index, const struct shown *shown,
                               const struct renderer_lacks *lacks)
{
    const struct chunk *chunk = check->chunk;
    const struct ambiguous_pixel *ambiguous = &chunk->ambiguous[index];
    struct hypothesis *background = &check->hypotheses[chunk->n_candidates + index];
    background->alive = background->alive && (lacks->numbers || shown->surface < 0) &&
                        (lacks->depths || fits_depth(check, shown, 1, 0));
    struct check_failure failure = {.kind = FAILURE_TRIANGLE, .shown = *shown};
    bool any = background->alive;
    for (int c = ambiguous->first; c < ambiguous->first + ambiguous->count; c++) {
        const struct candidate *candidate = &chunk->candidates[c];
        double depth = (double)candidate->depth, error = (double)candidate->depth_error;
        bool named = lacks->numbers || (candidate->surface == shown->surface &&
                                        candidate->triangle == shown->triangle);
        check->hypotheses[c].alive =
            named && (lacks->depths || fits_depth(check, shown, depth, error));
        any = any || check->hypotheses[c].alive;
        if (named)
            failure = depth_failure(shown, depth, error);
    }
    if (!any)
        check_fail(check, (size_t)ambiguous->pixel, &failure);
}

/* Fragments are counted modulo 256. Where triangles meet, a driver with leaking edges may have one
 * too few or too many: such pixels are counted. */
static void count_fragments(struct check *check, size_t pixel, const struct shown *shown)
{
    const struct overdraw *overdraw = &check->chunk->pixels[pixel].overdraw;
    uint8_t above = (uint8_t)(shown->fragments - overdraw->least),
            off = (uint8_t)(shown->fragments - overdraw->meant);
    bool leaks = overdraw->closed && off != 0, possible = above <= overdraw->spread;
    if (leaks && possible) {
        check->verdict.edge_holes += off >= 128;
        check->verdict.edge_doubles += off < 128;
    }
    if (possible && !(leaks && check->tight_edges))
        return;
    struct check_failure failure = {.kind = FAILURE_FRAGMENTS,
                                    .seen = shown->fragments,
                                    .expected = overdraw->meant,
                                    .bound = overdraw->closed ? 0 : overdraw->spread};
    check_fail(check, pixel, &failure);
}

void check_identity(struct check *check, const struct renderer *renderer,
                    const struct rectangle *tile)
{
    const struct chunk *chunk = check->chunk;
    size_t ambiguous = 0;
    for (size_t i = 0; i < chunk_pixels(chunk); i++) {
        int x = chunk->picture.at.x - tile->x + (int)i % chunk->picture.at.width,
            y = chunk->picture.at.y - tile->y + (int)i / chunk->picture.at.width;
        struct shown shown = renderer->kind->shown(renderer, x, y);
        if (chunk->is_ambiguous[i])
            identify_ambiguous(check, ambiguous++, &shown, &renderer->lacks);
        else
            identify_settled(check, i, &shown, &renderer->lacks);
        if (!renderer->lacks.depths)
            count_fragments(check, i, &shown);
    }
}
