/* SPDX-License-Identifier: MIT */
/* Computes the expected sample of a pixel. A radiance is a sum over terms of weight x spectrum.
 *
 * The bound of a sample, in counts, is the sum over terms of (error of the weight) x spectrum.
 * raster/bounds/light_bound.c, raster/bounds/plane.c and raster/candidates/pixel.c derive the
 * errors. */
#include <math.h>
#include <string.h>

#include "raster/counts/counts.h"

/* ---- OpenGL's colour buffer ---- */

/* A driver rounds each pass to the nearest step. Before that it multiplies and adds (2 roundings).
 * The step as a part of full scale, and the sum of such parts, are rounded again (2). Measured on
 * Mesa 22.3.6 with 3 million colours: llvmpipe and softpipe round to the nearest step, and miss it
 * by half a roundoff of full scale at most (0.002 of a step of 16 bits). Of a colour c
 * llvmpipe stores floor(1024 c + e) in 10 bits, 1023 at most: e was between -0.003 and 0.008, so
 * that it misses 1023 c by 1.01 steps at most. */
double buffer_rounding(const struct plan *plan)
{
    const int steps = buffer_steps(plan);
    const double part = plan->options.buffer_bits == 10 ? 1.01 : 0.5; /* of a step */
    return steps > 0 ? plan->n_light_groups * (part / steps + roundings(4)) * FULL_COUNT : 0;
}

/* ---- expected samples ---- */

/* Multiplies the samples of a run by the values of its spectral texture in this band. */
static void apply_texture(const struct lit_scene *lit, const struct run *run, int band,
                          double *expected, float *bound)
{
    const struct texture *texture = run->shaded->texture;
    const struct texels texels = plan_texels(texture, band % BANDS_PER_PASS);
    const float e_weights = texel_weights_error(&texels, lit->driver);
    for (size_t i = 0; i < run->n; i++) {
        const size_t first = (size_t)run->shaded->n_terms * run->stride + i;
        struct texel_point at = {.e_weights = e_weights};
        plan_place(&texels, run->rows + first, run->stride, at.place);
        if (!run->errors) {
            expected[i] *= texel_at(&texels, at.place);
            continue;
        }
        for (int k = 0; k < place_rows(&texels); k++)
            at.e_place[k] = run->errors[first + (size_t)k * run->stride];
        struct textured_sample *sample = &run->textured[i];
        texel_value(&texels, &at, texture->largest, &sample->texel);
        sample->radiance = expected[i];
        sample->error = (double)bound[i];
        bound[i] = (float)(sample->error * (sample->texel.value + sample->texel.error) +
                           fabs(sample->radiance) * sample->texel.error);
        expected[i] *= sample->texel.value;
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
VECTORIZED static void add_flushed(size_t n, float *bound)
{
    const float flushed = (float)FLUSHED_COUNTS;
    for (size_t i = 0; i < n; i++) {
        const float more = bound[i] + flushed;
        bound[i] = more < HUGE_VALF ? more : HUGE_VALF; /* NaN too */
    }
}

VECTORIZED void add_rows(const struct run *run, const float *rows, const float *factors,
                         size_t n_terms, float *restrict sums)
{
    for (size_t t = 0; t < n_terms; t++)
        for (size_t i = 0; i < run->n; i++)
            sums[i] += rows[t * run->stride + i] * factors[t];
}

void expect_counts(const struct lit_scene *lit, const struct run *run, int band, double *expected,
                   float *bound)
{
    const struct plan *plan = lit->plan;
    const struct shaded_material *shaded = run->shaded;
    memset(expected, 0, run->n * sizeof *expected);
    if (bound)
        memset(bound, 0, run->n * sizeof *bound);
    if (!shaded)
        return;
    for (size_t t = 0; t < (size_t)shaded->n_terms; t++) {
        const double spectrum = shaded->made.spectra[t * (size_t)plan->n_bands + (size_t)band] /
                                lit->full_scale * FULL_COUNT;
        const float factor = (float)spectrum;
        add_term(run->rows + t * run->stride, spectrum, run->n, expected);
        if (bound)
            add_rows(run, run->errors + t * run->stride, &factor, 1, bound);
    }
    if (shaded->texture && shaded->texture->spectral)
        apply_texture(lit, run, band, expected, bound);
    if (!bound)
        return;
    add_flushed(run->n, bound);
    if (buffer_steps(plan) > 0)
        expect_steps(plan, run->n, expected, bound);
}
