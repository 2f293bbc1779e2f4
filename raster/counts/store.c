/* SPDX-License-Identifier: MIT */
/* Stores radiances as the samples of a page: counts, or floats. A pixel of several positions has
 * their mean. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "raster/counts/counts.h"

/* ---- samples of a page ---- */

enum { COUNTS_PER_BYTE = FULL_COUNT / UINT8_MAX };

/* Returns the counts from which on a sample is cut off instead of rounded. */
static double clipping_limit(const struct plan *plan)
{
    return plan->options.bits == 32  ? HUGE_VAL
           : plan->options.bits == 8 ? FULL_COUNT + 0.5 * COUNTS_PER_BYTE
                                     : FULL_COUNT + 0.5;
}

/* Stores n samples from band->out[at] on. `counts` are in units of full scale / FULL_COUNT; those
 * at or above `limit` are counted as clipped. A page of counts holds none above full scale; a page
 * of floats holds them as radiances. */
static void store(const struct stored_band *band, const double *counts, size_t n, double limit,
                  size_t at, struct odd_samples *odd)
{
    const int bits = band->lit->plan->options.bits;
    const double scale = bits == 32 ? band->lit->full_scale / FULL_COUNT : 1;
    uint8_t *bytes = (uint8_t *)band->out + at;
    uint16_t *words = (uint16_t *)band->out + at;
    float *floats = (float *)band->out + at;
    for (size_t i = 0; i < n; i++) {
        const bool storable = fabs(counts[i] * scale) <= (double)FLT_MAX; /* NaN is not */
        odd->clipped += counts[i] >= limit;
        odd->undefined += !storable;
        if (bits == 8)
            bytes[i] = (uint8_t)(int)(counts_clamp(counts[i]) / COUNTS_PER_BYTE + 0.5);
        else if (bits == 16)
            words[i] = (uint16_t)counts_round(counts[i]);
        else
            floats[i] = storable ? (float)(counts[i] * scale) : 0;
    }
}

/* ---- one picture's positions ---- */

/* Positions of the reference, or of OpenGL if picture is NULL. */
struct positions {
    const struct picture *picture;
    const float *pixels; /* as store_gl takes them, with the stride */
    size_t stride;
};

/* Finds the counts of n <= BLOCK positions of a row. */
static void row_counts(const struct positions *of, const struct stored_band *band,
                       const size_t at[2], size_t n, double *counts)
{
    const size_t channel = (size_t)(band->band % BANDS_PER_PASS);
    const struct picture *picture = of->picture;
    if (!picture) {
        const float *seen = of->pixels + (at[1] * of->stride + at[0]) * 4;
        for (size_t i = 0; i < n; i++)
            counts[i] = (double)seen[4 * i + channel] * FULL_COUNT;
        return;
    }
    const size_t first = at[1] * (size_t)picture->at.width + at[0];
    struct run run = {.stride = (size_t)picture->at.width * (size_t)picture->at.height};
    for (size_t i = 0; i < n; i += run.n) {
        const int32_t surface = picture->surface[first + i];
        run.shaded = surface >= 0 ? band->lit->bounds[surface].shaded : NULL;
        run.rows = picture->rows + first + i;
        run.n = 1;
        while (i + run.n < n && picture->surface[first + i + run.n] == surface)
            run.n++;
        expect_counts(band->lit, &run, band->band, counts + i, NULL);
    }
}

/* ---- means ---- */

/* Finds the means of n pixels in a row. Returns how many have a position that a buffer of steps may
 * have cut off, but not all of them; limit: that of store. */
static uint64_t mean_counts(const struct positions *of, const struct stored_band *band,
                            const size_t pixel[2], size_t n, double limit, double *means)
{
    const size_t side = (size_t)band->lit->plan->scene->positions;
    double counts[BLOCK], most[BLOCK] = {0};
    uint64_t cut = 0;
    memset(means, 0, n * sizeof *means);
    for (size_t row = 0; row < side; row++) {
        const size_t at[2] = {pixel[0] * side, pixel[1] * side + row};
        row_counts(of, band, at, n * side, counts);
        for (size_t i = 0; i < n * side; i++) {
            means[i / side] += counts[i];
            most[i / side] = fmax(most[i / side], counts[i]);
        }
    }
    for (size_t i = 0; i < n; i++) {
        means[i] /= (double)(side * side);
        cut += limit <= FULL_COUNT && most[i] >= limit && means[i] < limit;
    }
    return cut;
}

/* ---- all positions ---- */

/* Stores pixels; a pixel of several positions has their mean. rows: in positions, whole pixels. */
static struct odd_samples store_rows(const struct stored_band *bands, int n_bands,
                                     const struct rectangle *rows, const struct positions *of,
                                     double limit)
{
    const size_t side = (size_t)bands->lit->plan->scene->positions,
                 width = (size_t)rows->width / side, height = (size_t)rows->height / side;
    struct odd_samples odd = {0, 0};
    double counts[BLOCK];
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0, n; x < width; x += n) {
            const size_t at[2] = {x, y};
            n = width - x < BLOCK / side ? width - x : BLOCK / side;
            for (const struct stored_band *band = bands; band < bands + n_bands; band++) {
                if (side == 1)
                    row_counts(of, band, at, n, counts);
                else
                    odd.clipped += mean_counts(of, band, at, n, limit, counts);
                store(band, counts, n, limit, y * width + x, &odd);
            }
        }
    return odd;
}

struct odd_samples store_reference(const struct stored_band *bands, int n_bands,
                                   const struct picture *picture)
{
    const struct positions positions = {.picture = picture};
    return store_rows(bands, n_bands, &picture->at, &positions, clipping_limit(bands->lit->plan));
}

struct odd_samples store_gl(const struct stored_band *bands, int n_bands,
                            const struct rectangle *rows, const float *pixels, size_t stride)
{
    const struct plan *plan = bands->lit->plan;
    const struct positions positions = {.pixels = pixels, .stride = stride};
    return store_rows(bands, n_bands, rows, &positions,
                      bands->lit->clips && buffer_steps(plan) > 0 ? FULL_COUNT
                                                                  : clipping_limit(plan));
}
