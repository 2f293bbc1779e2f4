/* SPDX-License-Identifier: MIT */
/* Judges the triangle that OpenGL names at each pixel, its depth, and the number of fragments. */
#include <math.h>

#include "raster/check/inside.h"

static const double depth_steps = 16777215;

/* A triangle that OpenGL may show at a pixel. Depths are rounded to single precision: their errors
 * cover that. */
struct named {
    int32_t surface, triangle; /* -1: the background */
    double depth, error;
};
static const struct named background = {-1, -1, 1, 0};

/* Returns whether OpenGL shows this there, at this depth. Beyond the near or the far plane, where a
 * cut edge may still cover a centre, OpenGL stores the nearest depth that it can. Where only the
 * depth differs, *failure says so. */
static bool is_shown(struct check *check, const struct named *named, const struct shown *shown,
                     const struct renderer_lacks *lacks, struct check_failure *failure)
{
    if (!lacks->numbers && (shown->surface != named->surface ||
                            (named->surface >= 0 && shown->triangle != named->triangle)))
        return false;
    const double seen = shown->depth / depth_steps, error = named->error,
                 off = fabs(seen - fmin(fmax(named->depth, 0), 1));
    if (lacks->depths)
        return true;
    if (off <= error && error > 0 && error < HUGE_VAL)
        check->verdict.worst_depth_ratio = fmax(check->verdict.worst_depth_ratio, off / error);
    else if (!(off <= error))
        *failure = (struct check_failure){
            .kind = FAILURE_DEPTH, .seen = seen, .expected = named->depth, .bound = error};
    return off <= error;
}

static void identify_settled(struct check *check, size_t pixel, const struct shown *shown,
                             const struct renderer_lacks *lacks)
{
    const struct picture *picture = &check->chunk->picture;
    const struct named named = {picture->surface[pixel], picture->triangle[pixel],
                                round_to_single(picture->depth[pixel]),
                                (double)check->chunk->pixels[pixel].depth_error};
    struct check_failure failure = {.kind = FAILURE_TRIANGLE, .shown = *shown};
    if (!is_shown(check, named.surface < 0 ? &background : &named, shown, lacks, &failure))
        check_fail(check, pixel, &failure);
}

/* Only the hypothesis that OpenGL shows stays alive. */
static void identify_ambiguous(struct check *check, size_t index, const struct shown *shown,
                               const struct renderer_lacks *lacks)
{
    const struct chunk *chunk = check->chunk;
    const struct ambiguous_pixel *ambiguous = &chunk->ambiguous[index];
    bool *is_background = &check->hypotheses[chunk->n_candidates + index].alive;
    struct check_failure failure = {.kind = FAILURE_TRIANGLE, .shown = *shown}, ignored;
    *is_background = *is_background && is_shown(check, &background, shown, lacks, &ignored);
    bool any = *is_background;
    for (int c = ambiguous->first; c < ambiguous->first + ambiguous->count; c++) {
        const struct candidate *candidate = &chunk->candidates[c];
        const struct named named = {candidate->surface, candidate->triangle,
                                    (double)candidate->depth, (double)candidate->depth_error};
        check->hypotheses[c].alive = is_shown(check, &named, shown, lacks, &failure);
        any = any || check->hypotheses[c].alive;
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
    const bool tight = check->scene->limits->strict || check->scene->lit->driver->watertight;
    if (possible && !(leaks && tight))
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
