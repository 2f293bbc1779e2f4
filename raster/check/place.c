/* SPDX-License-Identifier: MIT */
/* One place explains all bands. Where a texture differs from band to band, OpenGL's place in it is
 * off by the same p = (across, up) in every band. With g for the slope of a band's radiance there
 * and n for a bound on everything else, d_b = g_b . p + n_b. Least squares over the pilots k, with
 * a bound e on p as prior knowledge, estimate p by M^-1 sum_k g_k d_k / n_k^2, where M = sum_k g_k
 * g_k' / n_k^2 + diag(1 / e^2). Let q = g_b' M^-1 g_b. By the inequality of Cauchy and Schwarz the
 * roundings of K pilots move the estimate's g_b . p by at most sqrt(K q), and the prior by at most
 * sqrt(2 q). */
#include <math.h>

#include "raster/check/inside.h"

enum { UU, UV, VV, U, V }; /* rows of an estimate: of the sums g g' / n^2 and g d / n^2 */
/* Single precision rounds the sums by less than this part of their largest number, and what they
 * explain of differences up to 10^4 n by less than a hundredth of the bound. */
static const double sums_error = MAX_PILOTS * 6e-8, estimate_factor = 1.01;

bool has_places(const struct shaded_material *shaded)
{
    return shaded->texture && shaded->texture->spectral;
}

/* A pixel in a band, in counts. */
struct slope {
    double g[2], noise;
    double e_place[2];
    bool is_straight; /* within the bounds of the place; otherwise nothing else is set */
};

static struct slope slope_of(const struct run *run, size_t i)
{
    const struct textured_sample *sample = &run->textured[i];
    const struct texel_value *texel = &sample->texel;
    const size_t u = (size_t)run->shaded->n_terms * run->stride + i, v = u + run->stride;
    if (!texel->is_straight)
        return (struct slope){.is_straight = false};
    return (struct slope){.g = {sample->radiance * texel->across, sample->radiance * texel->up},
                          .noise = sample->error * (texel->value + texel->error) +
                                   fabs(sample->radiance) * texel->rest + flushed_counts(),
                          .e_place = {(double)run->errors[u], (double)run->errors[v]},
                          .is_straight = true};
}

void place_add(const struct run *run, const double *difference, float *estimate)
{
    for (size_t i = 0; i < run->n; i++) {
        const struct slope slope = slope_of(run, i);
        if (!slope.is_straight)
            continue;
        const double over = 1 / (slope.noise * slope.noise), *g = slope.g;
        const double sums[PLACE_ROWS] = {[UU] = g[0] * g[0] * over,
                                         [UV] = g[0] * g[1] * over,
                                         [VV] = g[1] * g[1] * over,
                                         [U] = g[0] * difference[i] * over,
                                         [V] = g[1] * difference[i] * over};
        for (size_t k = 0; k < PLACE_ROWS; k++)
            estimate[k * run->stride + i] += (float)sums[k];
    }
}

/* The estimate of a pixel. */
struct place_estimate {
    double p[2], q; /* of the place; and g' M^-1 g */
};

static struct place_estimate estimate_of(const struct slope *slope, const float *sums,
                                         size_t stride)
{
    const double *g = slope->g, trace = (double)sums[UU * stride] + (double)sums[VV * stride],
                 uu = (double)sums[UU * stride] + sums_error * trace +
                      1 / (slope->e_place[0] * slope->e_place[0]),
                 vv = (double)sums[VV * stride] + sums_error * trace +
                      1 / (slope->e_place[1] * slope->e_place[1]),
                 uv = (double)sums[UV * stride], over = 1 / (uu * vv - uv * uv),
                 u = (double)sums[U * stride], v = (double)sums[V * stride];
    return (struct place_estimate){{(vv * u - uv * v) * over, (uu * v - uv * u) * over},
                                   (vv * g[0] * g[0] - 2 * uv * g[0] * g[1] + uu * g[1] * g[1]) *
                                       over};
}

/* Where the texture bends, or its place has no error, nothing is explained. */
void place_explain(const struct fit *fit, const struct run *run, int band, const float *estimate,
                   struct fit_block *out)
{
    const bool is_pilot = fit_has_pilots(fit, band / BANDS_PER_PASS);
    const double spread = sqrt((double)fit->n_passes * BANDS_PER_PASS) + sqrt(2);
    for (size_t i = 0; i < run->n; i++) {
        const struct slope slope = slope_of(run, i);
        out->explained[i] = 0;
        out->limit[i] = out->floor[i] = slope.is_straight ? (float)slope.noise : HUGE_VALF;
        if (!slope.is_straight || !(slope.e_place[0] > 0 && slope.e_place[1] > 0))
            continue;
        const struct place_estimate found = estimate_of(&slope, estimate + i, run->stride);
        const double itself = is_pilot ? found.q / (slope.noise * slope.noise) : 0;
        out->explained[i] = (float)(slope.g[0] * found.p[0] + slope.g[1] * found.p[1]);
        out->limit[i] = (float)(slope.noise + estimate_factor * spread * sqrt(fmax(0, found.q)));
        out->floor[i] = itself < MOST_OF_ITSELF ? out->limit[i] / (float)(1 - itself) : HUGE_VALF;
    }
}
