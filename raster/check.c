/* SPDX-License-Identifier: MIT */
/* The verdict: is what OpenGL drew at this pixel what some surface there must look like, at all
 * wavelengths at once, within that surface's own bound? And the only place that turns radiance into
 * counts.
 *
 * Bound of a sample, in counts: sum over terms of (error of the weight) x (spectrum), which
 * raster/light.c and raster/bound.c derive, plus the roundings of the colour sum. u = 2^-24. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "spectral.h"

static const double u = 1.0 / 16777216;
static const double full_count = 65535;

/* A colour: its spectrum rounded to single precision (1), light times material (2), a texture's
 * value and its product (2), the buffer (1); each colour and each pass added (1 each). */
enum { COLOUR_ROUNDINGS = 6 };
/* Mesa flushes results below 2^-126 = 1.2e-38 to zero. In a plane's set-up that is magnified by one
 * over the triangle's area (10^4 at most, smaller ones are too thin for a bound) and by the
 * distance to the framebuffer's origin (2 x 16384); 4 such steps. Some 10^-29 of full scale, in
 * counts. */
static const double flushed = 65535 * 1.2e-38 * 1e4 * 32768 * 4;

/* Pixels evaluated together, few enough to stay in the first-level cache. */
enum { BLOCK = 256 };

/* A candidate on trial: it lives as long as it has explained every sample. */
struct check_trial {
    bool alive;
    bool undefined; /* of a contest's background: OpenGL drew what is no finite number */
    struct check_samples samples;
    double seen, expected, bound; /* where it died */
    int band;
};

/* ---- comparing ---- */

/* In [0, full_count]; NaN becomes 0. */
static double clamped(double counts)
{
    double positive = counts >= 0 ? counts : 0;
    return positive < full_count ? positive : full_count;
}

static int rounded(double counts)
{
    return (int)(clamped(counts) + 0.5);
}

/* Sums over a block are kept in lanes, which the compiler can do together. A block is filled up to
 * whole lanes with samples that are 0 and expected to be 0. */
enum { LANES = 4 };

/* Samples together with what is expected of them; difference is filled by differ. */
struct block {
    size_t n;
    double seen[BLOCK], expected[BLOCK], bound[BLOCK], difference[BLOCK];
};

static size_t fill_lanes(struct block *block)
{
    size_t n = block->n;
    for (; n % LANES != 0; n++)
        block->seen[n] = block->expected[n] = block->bound[n] = 0;
    return n;
}

static double lane_sum(const double lanes[LANES])
{
    return lanes[0] + lanes[1] + lanes[2] + lanes[3];
}

/* Fills differences; returns their sum of squares. */
static double differ(struct block *block, size_t all)
{
    double squares[LANES] = {0};
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++) {
            double difference = fabs(block->seen[i + k] - block->expected[i + k]);
            block->difference[i + k] = difference;
            squares[k] += difference * difference;
        }
    return lane_sum(squares);
}

/* How many values are above factor x limits (NaN is above all). */
static double count_above(const double *values, double factor, const double *limits, size_t all)
{
    double above[LANES] = {0};
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++)
            above[k] += values[i + k] <= factor * limits[i + k] ? 0.0 : 1.0;
    return lane_sum(above);
}

static double count_above_one(const double *values, double limit, size_t all)
{
    double above[LANES] = {0};
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++)
            above[k] += values[i + k] <= limit ? 0.0 : 1.0;
    return lane_sum(above);
}

/* The largest of the values and what is known already; looks only where something is larger. */
static void raise_to(double *largest, const double *values, size_t n, size_t all)
{
    if (count_above_one(values, *largest, all) == 0)
        return;
    for (size_t i = 0; i < n; i++)
        *largest = fmax(*largest, values[i]);
}

static void raise_ratio(double *worst, const struct block *block, size_t all)
{
    if (count_above(block->difference, *worst, block->bound, all) == 0)
        return;
    for (size_t i = 0; i < block->n; i++)
        if (block->difference[i] <= block->bound[i] &&
            block->difference[i] > *worst * block->bound[i])
            *worst = block->difference[i] / block->bound[i];
}

/* Adds a block to a comparison; false when any sample is outside its bound. */
static bool compare(struct check_samples *samples, struct block *block)
{
    size_t all = fill_lanes(block);
    int exact = 0, within_1 = 0;
    samples->sum_of_squares += differ(block, all);
    for (size_t i = 0; i < block->n; i++) {
        int apart = rounded(block->seen[i]) - rounded(block->expected[i]);
        exact += apart == 0;
        within_1 += apart >= -1 && apart <= 1;
    }
    samples->n += block->n;
    samples->exact += (uint64_t)exact;
    samples->within_1 += (uint64_t)within_1;
    raise_to(&samples->largest, block->difference, block->n, all);
    raise_ratio(&samples->worst_ratio, block, all);
    return count_above(block->difference, 1, block->bound, all) == 0;
}

static void add_samples(struct check_samples *to, const struct check_samples *from)
{
    to->n += from->n;
    to->exact += from->exact;
    to->within_1 += from->within_1;
    to->sum_of_squares += from->sum_of_squares;
    to->largest = fmax(to->largest, from->largest);
    to->worst_ratio = fmax(to->worst_ratio, from->worst_ratio);
}

/* ---- what is expected ---- */

/* How a run of pixels of one surface keeps its finish_rows, `stride` apart. */
struct rows {
    const double *weights;
    const float *errors; /* NULL: no bounds are wanted */
    size_t stride;
};

/* Multiplies a run by what a spectral texture shows there in this band. bound may be NULL. */
static void apply_texture(const struct finish *finish, const struct rows *rows, size_t n, int band,
                          double *expected, double *bound)
{
    size_t across = (size_t)finish->n_terms * rows->stride, up = across + rows->stride;
    for (size_t i = 0; i < n; i++) {
        struct texel_point at = {rows->weights[across + i], rows->weights[up + i], 0, 0};
        double error;
        if (bound) {
            at.e_u = rows->errors[across + i];
            at.e_v = rows->errors[up + i];
        }
        double value =
            texel_value(finish->texture, band % BANDS_PER_PASS, at, bound ? &error : NULL);
        if (bound)
            bound[i] = bound[i] * (value + error) + fabs(expected[i]) * error;
        expected[i] *= value;
    }
}

/* Radiance of a run in one band, times scale, and its bound where errors are given. */
static void evaluate(const struct plan *plan, const struct finish *finish, const struct rows *rows,
                     size_t n, int band, double scale, double *expected, double *bound)
{
    double rounding = (COLOUR_ROUNDINGS + finish->n_colours + plan->n_light_groups) * u;
    memset(expected, 0, n * sizeof *expected);
    if (bound)
        memset(bound, 0, n * sizeof *bound);
    for (int t = 0; t < finish->n_terms; t++) {
        double spectrum = finish->spectra[(size_t)t * (size_t)plan->n_bands + (size_t)band] * scale;
        const double *weight = rows->weights + (size_t)t * rows->stride;
        for (size_t i = 0; i < n; i++)
            expected[i] += weight[i] * spectrum;
        if (!bound)
            continue;
        const float *error = rows->errors + (size_t)t * rows->stride;
        for (size_t i = 0; i < n; i++)
            bound[i] += (double)error[i] * spectrum;
    }
    if (finish->texture && finish->texture->spectral)
        apply_texture(finish, rows, n, band, expected, bound);
    for (size_t i = 0; i < n && bound; i++) {
        double whole = bound[i] + flushed + rounding * fabs(expected[i]);
        bound[i] = whole <= DBL_MAX ? whole : -1; /* what is not finite explains nothing */
    }
}

/* ---- pixels with a single candidate ---- */

static void note_failure(struct check *check, size_t pixel, int band, double seen, double expected,
                         double bound)
{
    if (check->tally.first.found)
        return;
    const struct tile *rows = &check->chunk->rows;
    check->tally.first = (struct check_failure){.found = true,
                                                .x = rows->x + (int)pixel % rows->width,
                                                .y = rows->y + (int)pixel / rows->width,
                                                .band = band,
                                                .surface = check->chunk->surface[pixel],
                                                .seen = seen,
                                                .expected = expected,
                                                .bound = bound};
}

/* The surface of a run, or -1, evaluated into expected and bound. */
static void expect_run(const struct check *check, size_t first, size_t n, int band,
                       double *expected, double *bound)
{
    const struct chunk *chunk = check->chunk;
    size_t n_pixels = (size_t)chunk->rows.width * (size_t)chunk->rows.height;
    if (chunk->surface[first] < 0) { /* the cleared background is exactly 0 */
        memset(expected, 0, n * sizeof *expected);
        memset(bound, 0, n * sizeof *bound);
        return;
    }
    struct rows rows = {chunk->weights + first, chunk->errors + first, n_pixels};
    evaluate(check->plan, check->surfaces[chunk->surface[first]].finish, &rows, n, band,
             full_count / check->full_scale, expected, bound);
}

/* Statistics of a block's bounds, after compare. Nearly all bounds are tight. */
static void note_bounds(struct check_tally *tally, const struct block *block)
{
    double sum[LANES] = {0};
    size_t all = (block->n + LANES - 1) / LANES * LANES;
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++)
            sum[k] += block->bound[i + k];
    tally->sum_of_bounds += lane_sum(sum);
    tally->n_bounds += block->n;
    raise_to(&tally->largest_bound, block->bound, block->n, all);
    size_t loose = (size_t)count_above_one(block->bound, TIGHT_COUNTS, all);
    tally->n_tight += block->n - loose;
    if (loose == 0)
        raise_to(&tally->largest_tight, block->difference, block->n, all);
    for (size_t i = 0; i < block->n && loose > 0; i++)
        if (block->bound[i] <= TIGHT_COUNTS)
            tally->largest_tight = fmax(tally->largest_tight, block->difference[i]);
}

static void judge_run(struct check *check, size_t first, size_t n, int band, const float *channel)
{
    struct block block;
    block.n = n;
    for (size_t i = 0; i < n; i++)
        block.seen[i] = (double)channel[4 * i] * full_count;
    expect_run(check, first, n, band, block.expected, block.bound);
    bool explained = compare(&check->tally.samples, &block);
    note_bounds(&check->tally, &block);
    for (size_t i = 0; i < n && !explained; i++) {
        if (block.difference[i] <= block.bound[i])
            continue;
        check->failed[first + i] = true;
        note_failure(check, first + i, band, block.seen[i], block.expected[i], block.bound[i]);
    }
}

/* How many pixels from `first` on, within the row and a block, share its surface settled. */
static size_t run_length(const struct chunk *chunk, size_t first, size_t row_end)
{
    size_t last = row_end - first < BLOCK ? row_end : first + BLOCK, at = first;
    while (at < last && !chunk->contested[at] && chunk->surface[at] == chunk->surface[first])
        at++;
    return at - first;
}

/* ---- contested pixels ---- */

/* candidate NULL stands for the background. */
static void try_candidate(struct check *check, const struct candidate *candidate,
                          struct check_trial *trial, int band, double seen)
{
    struct block single;
    if (!trial->alive)
        return;
    single.n = 1;
    single.seen[0] = seen;
    single.expected[0] = single.bound[0] = 0;
    if (candidate) {
        const struct chunk *chunk = check->chunk;
        struct rows rows = {chunk->candidate_weights + candidate->first,
                            chunk->candidate_errors + candidate->first, 1};
        evaluate(check->plan, check->surfaces[candidate->surface].finish, &rows, 1, band,
                 full_count / check->full_scale, single.expected, single.bound);
    }
    trial->seen = seen;
    trial->expected = single.expected[0];
    trial->bound = single.bound[0];
    trial->band = band;
    trial->alive = compare(&trial->samples, &single);
}

static void judge_contests(struct check *check, int band, int channel, const float *pixels,
                           size_t stride)
{
    const struct chunk *chunk = check->chunk;
    for (size_t i = 0; i < chunk->n_contests; i++) {
        const struct contest *contest = &chunk->contests[i];
        int x = contest->pixel % chunk->rows.width, y = contest->pixel / chunk->rows.width;
        double seen =
            (double)pixels[((size_t)y * stride + (size_t)x) * 4 + (size_t)channel] * full_count;
        for (int c = contest->first; c < contest->first + contest->count; c++)
            try_candidate(check, &chunk->candidates[c], &check->trials[c], band, seen);
        struct check_trial *background = &check->trials[chunk->n_candidates + i];
        try_candidate(check, NULL, background, band, seen);
        background->undefined = background->undefined || !isfinite(seen);
    }
}

/* The trial that explains best: the living one closest to its bound's middle; where all are dead,
 * the one that lived longest. */
static const struct check_trial *best_trial(const struct check_trial *a,
                                            const struct check_trial *b)
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
    const struct contest *contest = &chunk->contests[index];
    const struct check_trial *background = &check->trials[chunk->n_candidates + index];
    const struct check_trial *best = contest->background ? background : NULL;
    bool loose = false;
    for (int c = contest->first; c < contest->first + contest->count; c++) {
        best = best ? best_trial(&check->trials[c], best) : &check->trials[c];
        loose = loose || chunk->candidates[c].loose;
    }
    struct check_samples samples = best->samples;
    if (loose) /* OpenGL may show what has no bound */
        samples.worst_ratio = 0;
    check->tally.ambiguous++;
    add_samples(&check->tally.samples, &samples);
    if (best->alive)
        return;
    if (loose && !background->undefined) {
        check->tally.unbounded++;
        return;
    }
    check->tally.unexplained++;
    note_failure(check, (size_t)contest->pixel, best->band, best->seen, best->expected,
                 best->bound);
}

/* ---- a chunk ---- */

bool check_open(const struct plan *plan, const struct surface *surfaces, const struct chunk *chunk,
                double full_scale, struct check *out, struct error *err)
{
    size_t n_pixels = (size_t)chunk->rows.width * (size_t)chunk->rows.height;
    size_t n_trials = chunk->n_candidates + chunk->n_contests;
    *out = (struct check){
        .plan = plan, .surfaces = surfaces, .chunk = chunk, .full_scale = full_scale};
    out->failed = calloc(n_pixels, sizeof *out->failed);
    out->trials = calloc(n_trials + 1, sizeof *out->trials);
    if (!out->failed || !out->trials) {
        free(out->failed);
        free(out->trials);
        *out = (struct check){.plan = NULL};
        return error_memory(err);
    }
    for (size_t i = 0; i < n_trials; i++)
        out->trials[i].alive = true;
    for (size_t i = 0; i < chunk->n_contests; i++)
        out->trials[chunk->n_candidates + i].alive = chunk->contests[i].background;
    return true;
}

void check_pass(struct check *check, int first_band, const float *pixels, size_t stride)
{
    const struct chunk *chunk = check->chunk;
    size_t width = (size_t)chunk->rows.width;
    int n_channels = check->plan->n_bands - first_band;
    if (n_channels > BANDS_PER_PASS)
        n_channels = BANDS_PER_PASS;
    for (size_t y = 0; y < (size_t)chunk->rows.height; y++) {
        size_t row = y * width;
        for (size_t at = row; at < row + width;) {
            size_t n = run_length(chunk, at, row + width);
            for (int c = 0; c < n_channels && n > 0; c++)
                judge_run(check, at, n, first_band + c, pixels + (y * stride + (at - row)) * 4 + c);
            at += n > 0 ? n : 1;
        }
    }
    for (int c = 0; c < n_channels; c++)
        judge_contests(check, first_band + c, c, pixels, stride);
}

void check_close(struct check *check, struct check_tally *total)
{
    size_t n_pixels = (size_t)check->chunk->rows.width * (size_t)check->chunk->rows.height;
    for (size_t i = 0; i < check->chunk->n_contests; i++)
        settle(check, i);
    for (size_t i = 0; i < n_pixels; i++)
        check->tally.unexplained += check->failed[i];
    total->pixels += n_pixels;
    total->ambiguous += check->tally.ambiguous;
    total->unexplained += check->tally.unexplained;
    total->unbounded += check->tally.unbounded;
    total->n_tight += check->tally.n_tight;
    total->n_bounds += check->tally.n_bounds;
    total->sum_of_bounds += check->tally.sum_of_bounds;
    total->largest_tight = fmax(total->largest_tight, check->tally.largest_tight);
    total->largest_bound = fmax(total->largest_bound, check->tally.largest_bound);
    add_samples(&total->samples, &check->tally.samples);
    if (!total->first.found)
        total->first = check->tally.first;
    free(check->failed);
    free(check->trials);
}

/* ---- counts ---- */

/* Whether a page can hold a value; NaN no page can. */
static bool is_storable(double value)
{
    return fabs(value) <= (double)FLT_MAX;
}

/* Stores n samples given in units of full scale x full_count. */
static void store(const struct plan *plan, const double *counts, size_t n, double full_scale,
                  size_t at, void *out, struct odd_samples *odd)
{
    double scale = plan->options.floating ? full_scale / full_count : 1;
    int clipped = 0, undefined = 0;
    for (size_t i = 0; i < n; i++) {
        clipped += !plan->options.floating && counts[i] >= full_count + 0.5;
        undefined += !is_storable(counts[i] * scale);
    }
    odd->clipped += (uint64_t)clipped;
    odd->undefined += (uint64_t)undefined;
    for (size_t i = 0; i < n && !plan->options.floating; i++)
        ((uint16_t *)out)[at + i] = (uint16_t)rounded(counts[i]);
    for (size_t i = 0; i < n && plan->options.floating; i++)
        ((float *)out)[at + i] = is_storable(counts[i] * scale) ? (float)(counts[i] * scale) : 0.0F;
}

struct odd_samples counts_of_reference(const struct plan *plan, const struct surface *surfaces,
                                       const struct chunk *chunk, int band, double full_scale,
                                       void *out)
{
    size_t n_pixels = (size_t)chunk->rows.width * (size_t)chunk->rows.height, n;
    struct odd_samples odd = {0, 0};
    double counts[BLOCK];
    for (size_t at = 0; at < n_pixels; at += n) {
        size_t last = n_pixels - at < BLOCK ? n_pixels : at + BLOCK;
        struct rows rows = {chunk->weights + at, NULL, n_pixels};
        for (n = 1; at + n < last && chunk->surface[at + n] == chunk->surface[at];)
            n++;
        if (chunk->surface[at] < 0)
            memset(counts, 0, n * sizeof *counts);
        else
            evaluate(plan, surfaces[chunk->surface[at]].finish, &rows, n, band,
                     full_count / full_scale, counts, NULL);
        store(plan, counts, n, full_scale, at, out, &odd);
    }
    return odd;
}

struct odd_samples counts_of_gl(const struct plan *plan, const struct tile *rows, int channel,
                                double full_scale, const float *pixels, size_t stride, void *out)
{
    size_t width = (size_t)rows->width, n;
    struct odd_samples odd = {0, 0};
    double counts[BLOCK];
    for (size_t y = 0; y < (size_t)rows->height; y++)
        for (size_t x = 0; x < width; x += n) {
            const float *from = pixels + (y * stride + x) * 4 + channel;
            n = width - x < BLOCK ? width - x : BLOCK;
            for (size_t i = 0; i < n; i++)
                counts[i] = (double)from[4 * i] * full_count;
            store(plan, counts, n, full_scale, y * width + x, out, &odd);
        }
    return odd;
}
