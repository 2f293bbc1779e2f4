/* SPDX-License-Identifier: MIT */
/* What a sample should be, and radiance as counts: a sum over terms of weight x spectrum.
 *
 * Bound of a sample, in counts: sum over terms of (error of the weight) x (spectrum), which
 * raster/light.c and raster/bound.c derive, plus the roundings of the colour sum. u = 2^-24. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "check.h"

static const double u = 1.0 / 16777216;

/* A colour: its spectrum rounded to single precision (1), light times material (2), a texture's
 * value and its product (2), the buffer (1); each colour and each pass added (1 each). One more for
 * those of the bound itself. */
enum { COLOUR_ROUNDINGS = 7 };
/* Mesa flushes results below 2^-126 = 1.2e-38 to zero. In a plane's set-up that is magnified by one
 * over the triangle's area (10^4 at most, smaller ones are too thin for a bound) and by the
 * distance to the framebuffer's origin (2 x 16384), and by a w of up to 2048; 4 such steps. Some
 * 10^-25 of full scale, in counts. */
static const double flushed = 65535 * 1.2e-38 * 1e4 * 32768 * 2048 * 4;

/* ---- OpenGL's colour buffer ---- */

int buffer_steps(const struct plan *plan)
{
    return plan->options.buffer_bits == 8    ? UINT8_MAX
           : plan->options.buffer_bits == 16 ? UINT16_MAX
                                             : 0;
}

/* Each pass is rounded to the nearest step. On the way to that a driver multiplies and adds (2
 * roundings); the step as a part of full scale, and the sum of such parts, are rounded again (2).
 * Measured on Mesa 22.3.6, 3 million colours: llvmpipe and softpipe round to the nearest step, but
 * for 0.5 u of full scale at most (0.002 of a step of 16 bits). */
double buffer_rounding(const struct plan *plan)
{
    int steps = buffer_steps(plan);
    return steps > 0 ? plan->n_light_groups * (0.5 / steps + 4 * u) * FULL_COUNT : 0;
}

/* ---- what is expected ---- */

/* Multiplies a run by what a spectral texture shows there in this band. bound may be NULL. */
static void apply_texture(const struct finish *finish, const struct rows *rows, size_t n, int band,
                          double *expected, float *bound)
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
            bound[i] = (float)((double)bound[i] * (value + error) + fabs(expected[i]) * error);
        expected[i] *= value;
    }
}

/* What a buffer of steps makes of a colour. Each pass is cut off at full scale: of what passes add
 * up to that leaves a full scale at least, where there is as much, and all of it at most. */
static void expect_steps(const struct plan *plan, size_t n, double *expected, float *bound)
{
    double most = (double)plan->n_light_groups * FULL_COUNT, rounding = buffer_rounding(plan);
    for (size_t i = 0; i < n; i++) {
        double low = expected[i] < FULL_COUNT ? expected[i] : FULL_COUNT,
               high = expected[i] < most ? expected[i] : most;
        float more = (float)(0.5 * (high - low) + rounding);
        expected[i] = 0.5 * (low + high);
        bound[i] = bound[i] < 0 ? bound[i] : bound[i] + more;
    }
}

void counts_expect(const struct plan *plan, const struct finish *finish, const struct rows *rows,
                   size_t n, int band, double full_scale, double *expected, float *bound)
{
    double rounding = (COLOUR_ROUNDINGS + finish->n_colours + plan->n_light_groups) * u;
    memset(expected, 0, n * sizeof *expected);
    if (rows->errors)
        memset(bound, 0, n * sizeof *bound);
    for (int t = 0; t < finish->n_terms; t++) {
        double spectrum = finish->spectra[(size_t)t * (size_t)plan->n_bands + (size_t)band] /
                          full_scale * FULL_COUNT;
        const double *weight = rows->weights + (size_t)t * rows->stride;
        for (size_t i = 0; i < n; i++)
            expected[i] += weight[i] * spectrum;
        if (!rows->errors)
            continue;
        const float *error = rows->errors + (size_t)t * rows->stride;
        for (size_t i = 0; i < n; i++)
            bound[i] += error[i] * (float)spectrum;
    }
    if (finish->texture && finish->texture->spectral)
        apply_texture(finish, rows, n, band, expected, rows->errors ? bound : NULL);
    for (size_t i = 0; i < n && rows->errors; i++) {
        float whole = bound[i] + (float)(flushed + rounding * fabs(expected[i]));
        bound[i] = whole <= FLT_MAX ? whole : -1;
    }
    if (rows->errors && buffer_steps(plan) > 0)
        expect_steps(plan, n, expected, bound);
}

/* ---- counts ---- */

/* Whether a page can hold a value; NaN no page can. */
static bool is_storable(double value)
{
    return fabs(value) <= (double)FLT_MAX;
}

enum { COUNTS_PER_BYTE = FULL_COUNT / UINT8_MAX };

/* From where on a sample is cut off, not rounded. */
static double clipping_limit(const struct plan *plan)
{
    return plan->options.bits == 32  ? HUGE_VAL
           : plan->options.bits == 8 ? FULL_COUNT + 0.5 * COUNTS_PER_BYTE
                                     : FULL_COUNT + 0.5;
}

/* Stores n samples given in units of full scale x FULL_COUNT; those at `limit` or above it count as
 * clipped. */
static void store(const struct plan *plan, const double *counts, size_t n, double full_scale,
                  double limit, size_t at, void *out, struct odd_samples *odd)
{
    double scale = plan->options.bits == 32 ? full_scale / FULL_COUNT : 1;
    int clipped = 0, undefined = 0;
    for (size_t i = 0; i < n; i++) {
        clipped += counts[i] >= limit;
        undefined += !is_storable(counts[i] * scale);
    }
    odd->clipped += (uint64_t)clipped;
    odd->undefined += (uint64_t)undefined;
    for (size_t i = 0; i < n && plan->options.bits == 8; i++)
        ((uint8_t *)out)[at + i] = (uint8_t)(counts_clamp(counts[i]) / COUNTS_PER_BYTE + 0.5);
    for (size_t i = 0; i < n && plan->options.bits == 16; i++)
        ((uint16_t *)out)[at + i] = (uint16_t)counts_round(counts[i]);
    for (size_t i = 0; i < n && plan->options.bits == 32; i++)
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
            counts_expect(plan, surfaces[chunk->surface[at]].finish, &rows, n, band, full_scale,
                          counts, NULL);
        store(plan, counts, n, full_scale, clipping_limit(plan), at, out, &odd);
    }
    return odd;
}

struct odd_samples counts_of_gl(const struct plan *plan, const struct tile *rows, int channel,
                                double full_scale, bool clips, const float *pixels, size_t stride,
                                void *out)
{
    double limit = clips && buffer_steps(plan) > 0 ? FULL_COUNT : clipping_limit(plan);
    size_t width = (size_t)rows->width, n;
    struct odd_samples odd = {0, 0};
    double counts[BLOCK];
    for (size_t y = 0; y < (size_t)rows->height; y++)
        for (size_t x = 0; x < width; x += n) {
            const float *from = pixels + (y * stride + x) * 4 + channel;
            n = width - x < BLOCK ? width - x : BLOCK;
            for (size_t i = 0; i < n; i++)
                counts[i] = (double)from[4 * i] * FULL_COUNT;
            store(plan, counts, n, full_scale, limit, y * width + x, out, &odd);
        }
    return odd;
}
