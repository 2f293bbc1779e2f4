/* SPDX-License-Identifier: MIT */
/* Weights become radiance: a sum over terms of weight x spectrum, times the texture; radiance
 * becomes counts, of which 65535 stand for the full scale. */
#ifndef RADIANCE_H
#define RADIANCE_H

#include "raster/bounds/bounds.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- full_scale.c ---- */

/* The full scale that is asked for, or the largest vertex radiance over all surfaces and
 * wavelengths. It is not below 2^-100 of the light, which would be too much for single precision
 * beside it, and 1 for an all-black scene. Refuses radiances that are not finite, by object.
 *
 * Phong shading may be brighter between vertices. There it is an upper bound: every surface turned
 * squarely to every light, in the middle of its highlight, and as near as it comes to it. A light
 * that a surface touches, and that has no constant attenuation, has no bound: it is refused, unless
 * a full scale is asked for.
 *
 * *clips: a vertex is brighter than the full scale. */
bool find_full_scale(const struct lit_scene *lit, double *out, bool *clips, struct error *err);

/* ---- counts.c ---- */

/* Pixels evaluated together, few enough to stay in the first-level cache. */
enum { BLOCK = 256 };
enum { FULL_COUNT = 65535 };

/* Bound on what OpenGL's colour buffer rounds off a sample, in counts; 0 of floats, whose roundings
 * are OpenGL's. */
double buffer_rounding(const struct plan *plan);

/* A run of n <= BLOCK pixels of one surface, whose rows and errors are `stride` apart. */
struct run {
    const struct shaded_material *shaded;
    const double *rows;
    const float *errors; /* NULL: no bounds are wanted */
    size_t stride, n;
};
/* Counts of a run in one band, before rounding, and bounds on OpenGL's error where errors are
 * given. A pixel without a finite bound gets -1, which explains nothing. */
void expect_counts(const struct plan *plan, const struct run *run, int band, double full_scale,
                   double *expected, float *bound);
/* As stored: clamped and rounded; NaN becomes 0. Here, so that loops over samples take it in. */
static inline double counts_clamp(double counts)
{
    double positive = counts > 0 ? counts : 0;
    return positive < FULL_COUNT ? positive : FULL_COUNT;
}
static inline int counts_round(double counts)
{
    return (int)(counts_clamp(counts) + 0.5);
}

/* Samples that a file cannot hold as they are. */
struct odd_samples {
    uint64_t clipped;   /* above full_scale, stored as 65535 (or 255) */
    uint64_t undefined; /* NaN, infinite, or too large for a float page; stored as 0 */
};
/* One band of some rows as stored: uint8_t or uint16_t counts, or float radiances, as the plan
 * says. */
struct stored_band {
    const struct plan *plan;
    int band;
    double full_scale;
    void *out; /* room for the rows, without gaps */
};
struct odd_samples store_reference(const struct stored_band *band, const struct lit_scene *lit,
                                   const struct picture *picture);
/* `pixels` is the band's channel of the first pixel, 4 floats a pixel, rows `stride` pixels apart.
 * Where a vertex `clips`, a colour buffer of counts may have been cut off where it is full: such
 * samples count as clipped. */
struct odd_samples store_gl(const struct stored_band *band, const struct rectangle *rows,
                            bool clips, const float *pixels, size_t stride);

#endif
