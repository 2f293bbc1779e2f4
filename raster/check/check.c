/* SPDX-License-Identifier: MIT */
/* The verdict on each pixel. OpenGL names the triangle that it shows there: this triangle must be a
 * candidate. Its depth must be within the candidate's bound, the number of fragments must be
 * possible, and OpenGL's radiance must be that of this one triangle in all bands, each within its
 * own bound. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/check/check.h"
#include "raster/plan/plan.h"

/* The hypothesis that OpenGL shows a candidate: it is alive until it fails to explain a sample. */
struct hypothesis {
    bool alive;
    struct check_samples samples;
    double floor;                 /* its largest bound */
    double seen, expected, bound; /* of the sample at which it died */
    int band;                     /* of the same; -1: OpenGL shows another candidate */
};

static const double depth_steps = 16777215;

static size_t count_pixels(const struct chunk *chunk)
{
    return (size_t)chunk->picture.at.width * (size_t)chunk->picture.at.height;
}

/* Counts the pixel as not explained. The first such pixel is kept with its failure. */
static void fail(struct check *check, size_t pixel, const struct check_failure *failure)
{
    const struct rectangle *rows = &check->chunk->picture.at;
    check->failed[pixel] = true;
    if (check->verdict.first.found)
        return;
    check->verdict.first = *failure;
    check->verdict.first.found = true;
    check->verdict.first.x = rows->x + (int)pixel % rows->width;
    check->verdict.first.y = rows->y + (int)pixel / rows->width;
    check->verdict.first.surface = check->chunk->picture.surface[pixel];
}

/* ---- triangle, depth and number of fragments ---- */

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
static void identify_settled(struct check *check, size_t pixel, const struct shown *shown)
{
    const struct chunk *chunk = check->chunk;
    bool background = chunk->picture.surface[pixel] < 0;
    double depth = background ? 1 : (double)(float)chunk->picture.depth[pixel],
           error = background ? 0 : (double)chunk->depth_error[pixel];
    struct check_failure failure = {.kind = FAILURE_TRIANGLE, .shown = *shown};
    if (shown->surface == chunk->picture.surface[pixel] &&
        (background || shown->triangle == chunk->picture.triangle[pixel])) {
        if (fits_depth(check, shown, depth, error))
            return;
        failure = depth_failure(shown, depth, error);
    }
    fail(check, pixel, &failure);
}

/* Only the hypothesis that OpenGL shows stays alive. */
static void identify_ambiguous(struct check *check, size_t index, const struct shown *shown)
{
    const struct chunk *chunk = check->chunk;
    const struct ambiguous_pixel *ambiguous = &chunk->ambiguous[index];
    struct hypothesis *background = &check->hypotheses[chunk->n_candidates + index];
    background->alive = background->alive && shown->surface < 0 && fits_depth(check, shown, 1, 0);
    struct check_failure failure = {.kind = FAILURE_TRIANGLE, .shown = *shown};
    bool any = background->alive;
    for (int c = ambiguous->first; c < ambiguous->first + ambiguous->count; c++) {
        const struct candidate *candidate = &chunk->candidates[c];
        double depth = (double)candidate->depth, error = (double)candidate->depth_error;
        bool named = candidate->surface == shown->surface && candidate->triangle == shown->triangle;
        check->hypotheses[c].alive = named && fits_depth(check, shown, depth, error);
        any = any || check->hypotheses[c].alive;
        if (named)
            failure = depth_failure(shown, depth, error);
    }
    if (!any)
        fail(check, (size_t)ambiguous->pixel, &failure);
}

/* Fragments are counted modulo 256. Where triangles meet, a driver with leaking edges may have one
 * too few or too many: such pixels are counted. */
static void count_fragments(struct check *check, size_t pixel, const struct shown *shown)
{
    const struct overdraw *overdraw = &check->chunk->overdraw[pixel];
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
    fail(check, pixel, &failure);
}

void check_identity(struct check *check, const struct gl *gl, const struct rectangle *tile)
{
    const struct chunk *chunk = check->chunk;
    size_t ambiguous = 0;
    for (size_t i = 0; i < count_pixels(chunk); i++) {
        int x = chunk->picture.at.x - tile->x + (int)i % chunk->picture.at.width,
            y = chunk->picture.at.y - tile->y + (int)i / chunk->picture.at.width;
        struct shown shown = gl_shown(gl, x, y);
        if (chunk->is_ambiguous[i])
            identify_ambiguous(check, ambiguous++, &shown);
        else
            identify_settled(check, i, &shown);
        count_fragments(check, i, &shown);
    }
}

/* ---- pixels with a single candidate ---- */

/* Evaluates the surface of a run, or the background, into expected and bound. */
static void expect_run(const struct check *check, size_t first, size_t n, int band,
                       struct block *block)
{
    const struct chunk *chunk = check->chunk;
    if (chunk->picture.surface[first] < 0) { /* the cleared background is exactly 0 */
        memset(block->expected, 0, n * sizeof *block->expected);
        memset(block->bound, 0, n * sizeof *block->bound);
        return;
    }
    struct run run = {check->lit->bounds[chunk->picture.surface[first]].shaded,
                      chunk->picture.rows + first, chunk->errors + first, count_pixels(chunk), n};
    expect_counts(check->lit->plan, &run, band, check->full_scale, block->expected, block->bound);
}

static void judge_run(struct check *check, size_t first, size_t n, int band, const float *channel)
{
    struct block block;
    block.n = n;
    for (size_t i = 0; i < n; i++)
        block.seen[i] = (double)channel[4 * i] * FULL_COUNT;
    expect_run(check, first, n, band, &block);
    bool explained = samples_compare(&check->verdict.samples, &block);
    float *floor = check->floor + first;
    for (size_t i = 0; i < n; i++)
        floor[i] = floor[i] < block.bound[i] ? block.bound[i] : floor[i];
    for (size_t i = 0; i < n && !explained; i++) {
        if (block.difference[i] <= block.bound[i])
            continue;
        fail(check, first + i,
             &(struct check_failure){.kind = FAILURE_RADIANCE,
                                     .band = band,
                                     .seen = block.seen[i],
                                     .expected = block.expected[i],
                                     .bound = (double)block.bound[i]});
    }
}

/* Returns how many pixels from `first` on, within the row and a block, show its surface without
 * ambiguity. */
static size_t settled_run(const struct chunk *chunk, size_t first, size_t row_end)
{
    size_t last = row_end - first < BLOCK ? row_end : first + BLOCK, at = first;
    while (at < last && !chunk->is_ambiguous[at] &&
           chunk->picture.surface[at] == chunk->picture.surface[first])
        at++;
    return at - first;
}

/* ---- ambiguous pixels ---- */

/* candidate NULL stands for the background. A candidate without a bound explains every number. */
static void try_candidate(struct check *check, const struct candidate *candidate,
                          struct hypothesis *hypothesis, int band, double seen)
{
    struct block single;
    if (!hypothesis->alive)
        return;
    single.n = 1;
    single.seen[0] = seen;
    single.expected[0] = 0;
    single.bound[0] = 0;
    if (candidate) {
        const struct chunk *chunk = check->chunk;
        struct run run = {check->lit->bounds[candidate->surface].shaded,
                          chunk->candidate_rows + candidate->first,
                          chunk->candidate_errors + candidate->first, 1, 1};
        expect_counts(check->lit->plan, &run, band, check->full_scale, single.expected,
                      single.bound);
    }
    hypothesis->seen = seen;
    hypothesis->expected = single.expected[0];
    hypothesis->bound = (double)single.bound[0];
    hypothesis->band = band;
    hypothesis->floor = fmax(hypothesis->floor, hypothesis->bound);
    hypothesis->alive = samples_compare(&hypothesis->samples, &single);
    if (candidate && candidate->loose)
        hypothesis->alive = isfinite(seen);
}

static void judge_ambiguous(struct check *check, int band, int channel, const float *pixels,
                            size_t stride)
{
    const struct chunk *chunk = check->chunk;
    for (size_t i = 0; i < chunk->n_ambiguous; i++) {
        const struct ambiguous_pixel *ambiguous = &chunk->ambiguous[i];
        int x = ambiguous->pixel % chunk->picture.at.width,
            y = ambiguous->pixel / chunk->picture.at.width;
        double seen =
            (double)pixels[((size_t)y * stride + (size_t)x) * 4 + (size_t)channel] * FULL_COUNT;
        for (int c = ambiguous->first; c < ambiguous->first + ambiguous->count; c++)
            try_candidate(check, &chunk->candidates[c], &check->hypotheses[c], band, seen);
        try_candidate(check, NULL, &check->hypotheses[chunk->n_candidates + i], band, seen);
    }
}

/* Returns the hypothesis that explains best: the living one with the smallest ratio of error to
 * bound; of dead ones the one that lived longest. */
static const struct hypothesis *best_hypothesis(const struct hypothesis *a,
                                                const struct hypothesis *b)
{
    if (a->alive != b->alive)
        return a->alive ? a : b;
    if (a->alive)
        return a->samples.worst_ratio <= b->samples.worst_ratio ? a : b;
    return a->band >= b->band ? a : b;
}

static void settle(struct check *check, size_t index)
{
    const struct chunk *chunk = check->chunk;
    const struct ambiguous_pixel *ambiguous = &chunk->ambiguous[index];
    const struct hypothesis *best = &check->hypotheses[chunk->n_candidates + index];
    for (int c = ambiguous->first; c < ambiguous->first + ambiguous->count; c++)
        best = best_hypothesis(&check->hypotheses[c], best);
    ptrdiff_t candidate = best - check->hypotheses;
    bool nothing = candidate >= (ptrdiff_t)chunk->n_candidates,
         loose = !nothing && chunk->candidates[candidate].loose;
    struct check_samples samples = best->samples;
    if (loose) /* counted, but no measure of OpenGL's errors */
        samples.largest = samples.sum = samples.sum_of_squares = samples.worst_ratio = 0;
    check->verdict.ambiguous++;
    samples_add(&check->verdict.samples, &samples);
    if (!best->alive) {
        fail(check, (size_t)ambiguous->pixel,
             &(struct check_failure){.kind = FAILURE_RADIANCE,
                                     .band = best->band,
                                     .seen = best->seen,
                                     .expected = best->expected,
                                     .bound = best->bound});
    } else if (loose) {
        check->verdict.unbounded++;
        if (check->lit->plan->options.strict)
            fail(check, (size_t)ambiguous->pixel,
                 &(struct check_failure){.kind = FAILURE_UNBOUNDED});
    } else if (!nothing) {
        floor_note(&check->verdict.floor, best->floor);
    }
}

/* ---- floors ---- */

static bool surely_shows(const struct chunk *chunk, size_t pixel, int32_t surface)
{
    return !chunk->is_ambiguous[pixel] && chunk->picture.surface[pixel] == surface;
}

/* Returns whether a pixel and its neighbours in the tile lie inside one surface, and the pixel's
 * radiance changes little. */
static bool is_smooth(const struct check *check, const struct tile *tile, size_t pixel)
{
    const struct chunk *chunk = check->chunk, *last = tile->chunks + tile->n_chunks - 1;
    const size_t width = (size_t)chunk->picture.at.width, n_pixels = count_pixels(chunk);
    const size_t column = pixel % width;
    const int32_t surface = chunk->picture.surface[pixel];
    if ((double)chunk->steepness[pixel] * FULL_COUNT > SMOOTH_COUNTS * check->full_scale)
        return false;
    if ((column > 0 && !surely_shows(chunk, pixel - 1, surface)) ||
        (column < width - 1 && !surely_shows(chunk, pixel + 1, surface)))
        return false;
    if (pixel >= width && !surely_shows(chunk, pixel - width, surface))
        return false;
    if (pixel < width && chunk > tile->chunks &&
        !surely_shows(chunk - 1, count_pixels(chunk - 1) - width + column, surface))
        return false;
    return pixel + width < n_pixels ? surely_shows(chunk, pixel + width, surface)
                                    : chunk == last || surely_shows(chunk + 1, column, surface);
}

static void note_floors(struct check *check, const struct tile *tile)
{
    const struct chunk *chunk = check->chunk;
    for (size_t i = 0; i < count_pixels(chunk); i++) {
        if (chunk->is_ambiguous[i] || chunk->picture.surface[i] < 0)
            continue;
        floor_note(&check->verdict.floor, (double)check->floor[i]);
        if (is_smooth(check, tile, i))
            floor_note(&check->verdict.smooth_floor, (double)check->floor[i]);
    }
}

/* ---- a chunk ---- */

bool check_open(const struct lit_scene *lit, const struct chunk *chunk, double full_scale,
                struct check *out, struct error *err)
{
    size_t n_hypotheses = chunk->n_candidates + chunk->n_ambiguous;
    *out = (struct check){.lit = lit,
                          .chunk = chunk,
                          .full_scale = full_scale,
                          .failed = calloc(count_pixels(chunk), sizeof *out->failed),
                          .floor = calloc(count_pixels(chunk), sizeof *out->floor),
                          .hypotheses = calloc(n_hypotheses + 1, sizeof *out->hypotheses)};
    if (!out->failed || !out->floor || !out->hypotheses) {
        free(out->failed);
        free(out->floor);
        free(out->hypotheses);
        *out = (struct check){.lit = NULL};
        return error_memory(err);
    }
    for (size_t i = 0; i < n_hypotheses; i++)
        out->hypotheses[i] = (struct hypothesis){.alive = true, .band = -1};
    for (size_t i = 0; i < chunk->n_ambiguous; i++)
        out->hypotheses[chunk->n_candidates + i].alive = chunk->ambiguous[i].background;
    out->tight_edges =
        lit->plan->options.strict || (lit->plan->n_instances > 0 && lit->driver->watertight);
    return true;
}

void check_pass(struct check *check, int first_band, const float *pixels, size_t stride)
{
    const struct chunk *chunk = check->chunk;
    size_t width = (size_t)chunk->picture.at.width;
    int n_channels = check->lit->plan->n_bands - first_band;
    if (n_channels > BANDS_PER_PASS)
        n_channels = BANDS_PER_PASS;
    for (size_t y = 0; y < (size_t)chunk->picture.at.height; y++) {
        size_t row = y * width;
        for (size_t at = row; at < row + width;) {
            size_t n = settled_run(chunk, at, row + width);
            for (int c = 0; c < n_channels && n > 0; c++)
                judge_run(check, at, n, first_band + c, pixels + (y * stride + (at - row)) * 4 + c);
            at += n > 0 ? n : 1;
        }
    }
    for (int c = 0; c < n_channels; c++)
        judge_ambiguous(check, first_band + c, c, pixels, stride);
}

void check_close(struct check *check, const struct tile *tile, struct check_verdict *total)
{
    for (size_t i = 0; i < check->chunk->n_ambiguous; i++)
        settle(check, i);
    note_floors(check, tile);
    check->verdict.pixels = count_pixels(check->chunk);
    for (size_t i = 0; i < check->verdict.pixels; i++)
        check->verdict.unexplained += check->failed[i];
    verdict_add(total, &check->verdict);
    free(check->failed);
    free(check->floor);
    free(check->hypotheses);
}
