/* SPDX-License-Identifier: MIT */
/* Computes the expected sample of a pixel, and stores radiances as counts. A radiance is a sum over
 * terms of weight x spectrum.
 *
 * The bound of a sample, in counts, is the sum over terms of (error of the weight) x spectrum.
 * raster/bounds/light.c, raster/bounds/plane.c and raster/candidates/pixel.c derive the errors. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "data/texture/texture.h"
#include "raster/radiance/radiance.h"

/* In counts, some 10^-25 of full scale. Mesa flushes results below 2^-126 = 1.2e-38 to zero. The
 * set-up of a plane magnifies this error by one over the triangle's area (10^4 at most; smaller
 * triangles are too thin for a bound), by the distance to the framebuffer's origin (2 x 16384), and
 * by a w of up to 2048. There are 4 such steps. */
double flushed_counts(void)
{
    return 65535 * 1.2e-38 * 1e4 * 32768 * 2048 * 4;
}

/* ---- OpenGL's colour buffer ---- */

/* A driver rounds each pass to the nearest step. Before that it multiplies and adds (2 roundings).
 * The step as a part of full scale, and the sum of such parts, are rounded again (2). Measured on
 * Mesa 22.3.6 with 3 million colours: llvmpipe and softpipe round to the nearest step, and miss it
 * by half a roundoff of full scale at most (0.002 of a step of 16 bits). */
double buffer_rounding(const struct plan *plan)
{
    int steps = buffer_steps(plan);
    return steps > 0 ? plan->n_light_groups * (0.5 / steps + roundings(4)) * FULL_COUNT : 0;
}

/* ---- expected samples ---- */

/* Multiplies sample i of a run with errors by its texture. */
static void texture_sample(const struct run *run, const struct texels *texels, size_t i,
                           double *expected, float *bound)
{
    const size_t across = (size_t)run->shaded->n_terms * run->stride + i, up = across + run->stride;
    const struct texel_point at = {{run->rows[across], run->rows[up]},
                                   {run->errors[across], run->errors[up]}};
    struct textured_sample *sample = &run->textured[i];
    texel_value(texels, &at, run->shaded->texture->largest, &sample->texel);
    sample->radiance = *expected;
    sample->error = (double)*bound;
    *bound = (float)(sample->error * (sample->texel.value + sample->texel.error) +
                     fabs(sample->radiance) * sample->texel.error);
    *expected *= sample->texel.value;
}

/* Multiplies the samples of a run by the values of its spectral texture in this band. */
static void apply_texture(const struct run *run, int band, double *expected, float *bound)
{
    const struct texels texels = plan_texels(run->shaded->texture, band % BANDS_PER_PASS);
    const size_t across = (size_t)run->shaded->n_terms * run->stride, up = across + run->stride;
    for (size_t i = 0; i < run->n && run->errors; i++)
        texture_sample(run, &texels, i, &expected[i], &bound[i]);
    for (size_t i = 0; i < run->n && !run->errors; i++) {
        const double place[2] = {run->rows[across + i], run->rows[up + i]};
        expected[i] *= texel_at(&texels, place);
    }
}

/* Turns expected colours into the expected content of a buffer of steps. Such a buffer cuts each
 * pass off at full scale. If the sum of all passes is full scale or more, the buffers add up to at
 * least full scale, and at most to that sum. */
static void expect_steps(const struct plan *plan, size_t n, double *expected, float *bound)
{
    double most = (double)plan->n_light_groups * FULL_COUNT, rounding = buffer_rounding(plan);
    for (size_t i = 0; i < n; i++) {
        double low = expected[i] < FULL_COUNT ? expected[i] : FULL_COUNT,
               high = expected[i] < most ? expected[i] : most;
        float more = (float)(0.5 * (high - low) + rounding);
        expected[i] = 0.5 * (low + high);
        bound[i] += more;
    }
}

/* Adds what may be flushed to zero. A bound that single precision cannot hold is infinite. */
static void add_flushed(size_t n, float *bound)
{
    const float flushed = (float)flushed_counts();
    for (size_t i = 0; i < n; i++) {
        const float more = bound[i] + flushed;
        bound[i] = more < HUGE_VALF ? more : HUGE_VALF; /* NaN too */
    }
}

/* Rows that are added together, so that sums are loaded and stored half as often. */
enum { PAIR = 2 };

void add_rows(const struct run *run, const float *rows, const float *factors, size_t n_terms,
              float *restrict sums)
{
    const size_t n = run->n;
    size_t t = 0;
    for (; t + 1 < n_terms; t += PAIR) {
        const float *restrict row = rows + t * run->stride, *restrict next = row + run->stride;
        for (size_t i = 0; i < n; i++)
            sums[i] = sums[i] + row[i] * factors[t] + next[i] * factors[t + 1];
    }
    const float *restrict last = rows + t * run->stride;
    for (size_t i = 0; i < n && t < n_terms; i++)
        sums[i] += last[i] * factors[t];
}

void expect_counts(const struct plan *plan, const struct run *run, int band, double full_scale,
                   double *expected, float *bound)
{
    const struct shaded_material *shaded = run->shaded;
    memset(expected, 0, run->n * sizeof *expected);
    if (bound)
        memset(bound, 0, run->n * sizeof *bound);
    for (size_t t = 0; t < (size_t)shaded->n_terms; t += PAIR) {
        const size_t left = (size_t)shaded->n_terms - t, n = left < PAIR ? left : PAIR;
        const double *rows[PAIR];
        double spectra[PAIR] = {0};
        float factors[PAIR];
        for (size_t i = 0; i < PAIR; i++) {
            rows[i] = run->rows + (t + (i < n ? i : 0)) * run->stride;
            if (i < n)
                spectra[i] = shaded->made.spectra[(t + i) * (size_t)plan->n_bands + (size_t)band] /
                             full_scale * FULL_COUNT;
            factors[i] = (float)spectra[i];
        }
        add_terms(rows, spectra, run->n, expected); /* of a single one twice, once as nothing */
        if (bound)
            add_rows(run, run->errors + t * run->stride, factors, n, bound);
    }
    if (shaded->texture && shaded->texture->spectral)
        apply_texture(run, band, expected, bound);
    if (!bound)
        return;
    add_flushed(run->n, bound);
    if (buffer_steps(plan) > 0)
        expect_steps(plan, run->n, expected, bound);
}

/* Returns how many pixels from `first` on, at most BLOCK and none from `last` on, show the same
 * surface. */
static size_t run_length(const int32_t *surface, size_t first, size_t last)
{
    size_t n = 1;
    while (n < BLOCK && first + n < last && surface[first + n] == surface[first])
        n++;
    return n;
}

/* ---- counts ---- */

/* Returns whether a page can hold the value. No page can hold NaN. */
static bool is_storable(double value)
{
    return fabs(value) <= (double)FLT_MAX;
}

enum { COUNTS_PER_BYTE = FULL_COUNT / UINT8_MAX };

/* Returns the counts from which on a sample is cut off instead of rounded. */
static double clipping_limit(const struct plan *plan)
{
    return plan->options.bits == 32  ? HUGE_VAL
           : plan->options.bits == 8 ? FULL_COUNT + 0.5 * COUNTS_PER_BYTE
                                     : FULL_COUNT + 0.5;
}

/* A page of counts holds none above full scale; a page of floats holds them as radiances. */
static bool holds_counts(const struct stored_band *band)
{
    return band->plan->options.bits < 32;
}

/* The sample of a page that stands for one count. */
static double page_scale(const struct stored_band *band)
{
    return holds_counts(band) ? 1 : band->full_scale / FULL_COUNT;
}

/* Returns whether all are in [0, FULL_COUNT]; NaN is not. Sums are kept in lanes, which the
 * compiler can do together; `counts` is filled up to whole lanes with 0. */
static bool are_counts(double *counts, size_t n)
{
    enum { LANES = 4 };
    const double middle = 0.5 * FULL_COUNT;
    double odd[LANES] = {0}, sum = 0;
    for (; n % LANES != 0; n++)
        counts[n] = 0;
    for (size_t i = 0; i < n; i += LANES)
        for (size_t k = 0; k < LANES; k++)
            odd[k] += fabs(counts[i + k] - middle) <= middle ? 0 : 1;
    for (size_t k = 0; k < LANES; k++)
        sum += odd[k];
    return sum < 1;
}

/* Replaces what the page cannot hold by what it stores instead. Counts at or above `limit` are
 * counted as clipped. */
static void tame(const struct stored_band *band, double *counts, size_t n, double limit,
                 struct odd_samples *odd)
{
    const double scale = page_scale(band);
    for (size_t i = 0; i < n; i++) {
        const bool storable = is_storable(counts[i] * scale);
        odd->clipped += counts[i] >= limit;
        odd->undefined += !storable;
        counts[i] = holds_counts(band) ? counts_clamp(counts[i]) : storable ? counts[i] : 0;
    }
}

/* Stores n <= BLOCK samples from band->out[at] on. `counts`, BLOCK of them, in units of full scale
 * / FULL_COUNT, are changed where the page cannot hold them. Usually none are. */
static void store(const struct stored_band *band, double *counts, size_t n, double limit, size_t at,
                  struct odd_samples *odd)
{
    const int bits = band->plan->options.bits;
    const double scale = page_scale(band);
    uint8_t *bytes = (uint8_t *)band->out + at;
    uint16_t *words = (uint16_t *)band->out + at;
    float *floats = (float *)band->out + at;
    if (!holds_counts(band) || limit <= FULL_COUNT || !are_counts(counts, n))
        tame(band, counts, n, limit, odd);
    for (size_t i = 0; i < n && bits == 8; i++)
        bytes[i] = (uint8_t)(int)(counts[i] / COUNTS_PER_BYTE + 0.5);
    for (size_t i = 0; i < n && bits == 16; i++)
        words[i] = (uint16_t)(int)(counts[i] + 0.5);
    for (size_t i = 0; i < n && bits == 32; i++)
        floats[i] = (float)(counts[i] * scale);
}

struct odd_samples store_reference(const struct stored_band *bands, int n_bands,
                                   const struct lit_scene *lit, const struct picture *picture)
{
    const double limit = clipping_limit(bands->plan);
    size_t n_pixels = (size_t)picture->at.width * (size_t)picture->at.height, n;
    struct odd_samples odd = {0, 0};
    double counts[BLOCK];
    for (size_t at = 0; at < n_pixels; at += n) {
        const int32_t surface = picture->surface[at];
        n = run_length(picture->surface, at, n_pixels);
        for (const struct stored_band *band = bands; band < bands + n_bands; band++) {
            memset(counts, 0, n * sizeof *counts);
            if (surface >= 0) {
                const struct run run = {.shaded = lit->bounds[surface].shaded,
                                        .rows = picture->rows + at,
                                        .stride = n_pixels,
                                        .n = n};
                expect_counts(band->plan, &run, band->band, band->full_scale, counts, NULL);
            }
            store(band, counts, n, limit, at, &odd);
        }
    }
    return odd;
}

void split_channels(const float *pixels, size_t n, float out[BANDS_PER_PASS][BLOCK])
{
    for (size_t i = 0; i < n; i++) {
        out[0][i] = pixels[4 * i];
        out[1][i] = pixels[4 * i + 1];
        out[2][i] = pixels[4 * i + 2];
    }
}

/* Returns whether all are from 0 to full scale; NaN is not. */
static bool are_parts(const float *seen, size_t n)
{
    int odd = 0;
    for (size_t i = 0; i < n; i++)
        odd |= !(seen[i] >= 0) | !(seen[i] <= 1);
    return odd == 0;
}

/* Stores n <= BLOCK samples of OpenGL, in parts of full scale: see store. */
static void store_parts(const struct stored_band *band, const float *seen, size_t n, double limit,
                        size_t at, struct odd_samples *odd)
{
    uint16_t *restrict words = (uint16_t *)band->out + at;
    const bool plain = band->plan->options.bits == 16 && limit > FULL_COUNT && are_parts(seen, n);
    double counts[BLOCK];
    for (size_t i = 0; i < n && plain; i++)
        words[i] = (uint16_t)(int)((double)seen[i] * FULL_COUNT + 0.5);
    for (size_t i = 0; i < n && !plain; i++)
        counts[i] = (double)seen[i] * FULL_COUNT;
    if (!plain)
        store(band, counts, n, limit, at, odd);
}

struct odd_samples store_gl(const struct stored_band *bands, int n_bands,
                            const struct rectangle *rows, bool clips, const float *pixels,
                            size_t stride)
{
    const struct plan *plan = bands->plan;
    const double limit = clips && buffer_steps(plan) > 0 ? FULL_COUNT : clipping_limit(plan);
    size_t width = (size_t)rows->width, n;
    struct odd_samples odd = {0, 0};
    float seen[BANDS_PER_PASS][BLOCK];
    for (size_t y = 0; y < (size_t)rows->height; y++)
        for (size_t x = 0; x < width; x += n) {
            n = width - x < BLOCK ? width - x : BLOCK;
            split_channels(pixels + (y * stride + x) * 4, n, seen);
            for (int c = 0; c < n_bands; c++)
                store_parts(&bands[c], seen[c], n, limit, y * width + x, &odd);
        }
    return odd;
}
