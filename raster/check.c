/* SPDX-License-Identifier: MIT */
/* The verdict: is what OpenGL drew at this pixel what some surface there must look like, at all
 * wavelengths at once, within that surface's own bound? And the only place that turns radiance into
 * counts.
 *
 * Bound of a sample, in counts: sum over terms of (error of the weight) x (spectrum), which
 * raster/light.c and raster/bound.c derive, plus the roundings of the colour sum. u = 2^-24. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "spectral.h"

static const double u = 1.0 / 16777216;
static const double full_count = 65535;

/* A colour: its spectrum rounded to single precision (1), light times material (2), each term added
 * (1 a term), the constant part (1), the buffer (1). */
enum { COLOUR_ROUNDINGS = 5 };
/* Mesa flushes results below 2^-126 = 1.2e-38 to zero. In a plane's set-up that is magnified by one
 * over the triangle's area (10^4 at most, smaller ones are too thin for a bound) and by the distance to
 * the framebuffer's origin (2 x 16384); 4 such steps. Some 10^-29 of full scale, in counts. */
static const double flushed = 65535 * 1.2e-38 * 1e4 * 32768 * 4;

/* Pixels evaluated together, few enough to stay in the first-level cache. */
enum { BLOCK = 256 };

/* A candidate on trial: it lives as long as it has explained every sample. */
struct check_trial {
    bool alive;
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

/* What single samples need only where a block stands out. */
static void find_worst(struct check_samples *samples, const double *difference,
                       const double *bound, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (difference[i] <= bound[i] && difference[i] > samples->worst_ratio * bound[i])
            samples->worst_ratio = difference[i] / bound[i];
}

/* Adds up to BLOCK samples to a comparison; false when any is outside its bound. The loops are plain
 * enough for the compiler to do several samples at once. */
static bool compare(struct check_samples *samples, const double *seen, const double *expected,
                    const double *bound, size_t n)
{
    double difference[BLOCK], squares[4] = {0, 0, 0, 0}, largest = samples->largest;
    int outside = 0, worse = 0, exact = 0, within_1 = 0;
    for (size_t i = 0; i < n; i++) {
        difference[i] = fabs(seen[i] - expected[i]);
        outside |= !(difference[i] <= bound[i]);
        worse |= difference[i] > samples->worst_ratio * bound[i];
        squares[i % 4] += difference[i] * difference[i];
        largest = largest > difference[i] ? largest : difference[i];
    }
    for (size_t i = 0; i < n; i++) {
        int apart = rounded(seen[i]) - rounded(expected[i]);
        exact += apart == 0;
        within_1 += apart >= -1 && apart <= 1;
    }
    samples->n += n;
    samples->exact += (uint64_t)exact;
    samples->within_1 += (uint64_t)within_1;
    samples->sum_of_squares += squares[0] + squares[1] + squares[2] + squares[3];
    samples->largest = largest;
    if (worse)
        find_worst(samples, difference, bound, n);
    return !outside;
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

/* ---- pixels with a single candidate ---- */

/* Radiance of a run of pixels of one surface, times scale. */
static void evaluate(const struct plan *plan, const struct finish *finish, const double *weights,
                     size_t stride, size_t n, int band, double scale, double *out)
{
    double constant = finish->constant[band] * scale;
    for (size_t i = 0; i < n; i++)
        out[i] = constant;
    for (int t = 0; t < finish->n_terms; t++) {
        double spectrum = finish->spectra[(size_t)t * (size_t)plan->n_bands + (size_t)band] * scale;
        const double *weight = weights + (size_t)t * stride;
        for (size_t i = 0; i < n; i++)
            out[i] += weight[i] * spectrum;
    }
}

static double rounding_bound(const struct finish *finish)
{
    return (COLOUR_ROUNDINGS + finish->n_terms) * u;
}

static void evaluate_bound(const struct plan *plan, const struct finish *finish,
                           const float *errors, size_t stride, size_t n, int band, double scale,
                           const double *expected, double *out)
{
    double constant = finish->constant[band] * scale, rounding = rounding_bound(finish);
    for (size_t i = 0; i < n; i++)
        out[i] = flushed + rounding * expected[i] + constant * (double)errors[i];
    for (int t = 0; t < finish->n_terms; t++) {
        double spectrum = finish->spectra[(size_t)t * (size_t)plan->n_bands + (size_t)band] * scale;
        const float *error = errors + (size_t)(1 + t) * stride;
        for (size_t i = 0; i < n; i++)
            out[i] += (double)error[i] * spectrum;
    }
}

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
    const struct finish *finish = check->surfaces[chunk->surface[first]].finish;
    double scale = full_count / check->full_scale;
    evaluate(check->plan, finish, chunk->weights + first, n_pixels, n, band, scale, expected);
    evaluate_bound(check->plan, finish, chunk->errors + first, n_pixels, n, band, scale, expected,
                   bound);
}

static void note_bounds(struct check_tally *tally, const double *seen, const double *expected,
                        const double *bound, size_t n)
{
    double sum = 0, largest = tally->largest_bound, tight_largest = tally->largest_tight;
    int tight = 0;
    for (size_t i = 0; i < n; i++) {
        bool is_tight = bound[i] <= TIGHT_COUNTS;
        double difference = is_tight ? fabs(seen[i] - expected[i]) : 0;
        sum += bound[i];
        tight += is_tight;
        largest = bound[i] > largest ? bound[i] : largest;
        tight_largest = difference > tight_largest ? difference : tight_largest;
    }
    tally->sum_of_bounds += sum;
    tally->n_bounds += n;
    tally->n_tight += (uint64_t)tight;
    tally->largest_bound = largest;
    tally->largest_tight = tight_largest;
}

static void judge_run(struct check *check, size_t first, size_t n, int band, const float *channel)
{
    double seen[BLOCK], expected[BLOCK], bound[BLOCK];
    for (size_t i = 0; i < n; i++)
        seen[i] = (double)channel[4 * i] * full_count;
    expect_run(check, first, n, band, expected, bound);
    note_bounds(&check->tally, seen, expected, bound, n);
    if (compare(&check->tally.samples, seen, expected, bound, n))
        return;
    for (size_t i = 0; i < n; i++) {
        if (fabs(seen[i] - expected[i]) <= bound[i])
            continue;
        check->failed[first + i] = true;
        note_failure(check, first + i, band, seen[i], expected[i], bound[i]);
    }
}

/* How many pixels from `first` on, within the row and a block, share its surface and are settled. */
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
    double expected = 0, bound = 0;
    if (!trial->alive)
        return;
    if (candidate) {
        const struct finish *finish = check->surfaces[candidate->surface].finish;
        const double *numbers = check->chunk->numbers + candidate->first;
        size_t n_terms = (size_t)finish->n_terms, n_bands = (size_t)check->plan->n_bands;
        double scale = full_count / check->full_scale;
        expected = finish->constant[band] * scale;
        bound = flushed + finish->constant[band] * scale * numbers[n_terms];
        for (size_t t = 0; t < n_terms; t++) {
            double spectrum = finish->spectra[t * n_bands + (size_t)band] * scale;
            expected += numbers[t] * spectrum;
            bound += numbers[n_terms + 1 + t] * spectrum;
        }
        bound += rounding_bound(finish) * fabs(expected);
    }
    trial->alive = compare(&trial->samples, &seen, &expected, &bound, 1);
    trial->band = band;
    trial->seen = seen;
    trial->expected = expected;
    trial->bound = bound;
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
        try_candidate(check, NULL, &check->trials[chunk->n_candidates + i], band, seen);
    }
}

/* The trial that explains best: the living one closest to its bound's middle; where all are dead, the
 * one that lived longest. */
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
    check->tally.ambiguous++;
    add_samples(&check->tally.samples, &best->samples);
    if (best->alive)
        return;
    if (loose) {
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
                judge_run(check, at, n, first_band + c,
                          pixels + (y * stride + (at - row)) * 4 + c);
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

/* Stores n samples given in units of full scale x full_count. */
static size_t store(const struct plan *plan, const double *counts, size_t n, double full_scale,
                    size_t at, void *out)
{
    size_t above = 0;
    if (plan->options.floating) {
        float *samples = (float *)out + at;
        for (size_t i = 0; i < n; i++)
            samples[i] = (float)(counts[i] * (full_scale / full_count));
        return 0;
    }
    uint16_t *samples = (uint16_t *)out + at;
    for (size_t i = 0; i < n; i++) {
        above += counts[i] >= full_count + 0.5;
        samples[i] = (uint16_t)rounded(counts[i]);
    }
    return above;
}

size_t counts_of_reference(const struct plan *plan, const struct surface *surfaces,
                           const struct chunk *chunk, int band, double full_scale, void *out)
{
    size_t n_pixels = (size_t)chunk->rows.width * (size_t)chunk->rows.height, n, above = 0;
    double counts[BLOCK];
    for (size_t at = 0; at < n_pixels; at += n) {
        size_t last = n_pixels - at < BLOCK ? n_pixels : at + BLOCK;
        for (n = 1; at + n < last && chunk->surface[at + n] == chunk->surface[at];)
            n++;
        if (chunk->surface[at] < 0)
            memset(counts, 0, n * sizeof *counts);
        else
            evaluate(plan, surfaces[chunk->surface[at]].finish, chunk->weights + at, n_pixels, n,
                     band, full_count / full_scale, counts);
        above += store(plan, counts, n, full_scale, at, out);
    }
    return above;
}

size_t counts_of_gl(const struct plan *plan, const struct tile *rows, int channel,
                    double full_scale, const float *pixels, size_t stride, void *out)
{
    size_t width = (size_t)rows->width, above = 0, n;
    double counts[BLOCK];
    for (size_t y = 0; y < (size_t)rows->height; y++)
        for (size_t x = 0; x < width; x += n) {
            const float *from = pixels + (y * stride + x) * 4 + channel;
            n = width - x < BLOCK ? width - x : BLOCK;
            for (size_t i = 0; i < n; i++)
                counts[i] = (double)from[4 * i] * full_count;
            above += store(plan, counts, n, full_scale, y * width + x, out);
        }
    return above;
}
