/* SPDX-License-Identifier: MIT */
/* Turns weights into radiance: a sum over terms of weight x spectrum, times the texture. Turns
 * radiance into counts: 65535 counts stand for the full scale. */
#ifndef RASTER_COUNTS_COUNTS_H
#define RASTER_COUNTS_COUNTS_H

#include "raster/bounds/bounds.h"

/* ---- full_scale.c ---- */

/* Finds the full scale: the one that the plan asks for, or the largest vertex radiance over all
 * surfaces and wavelengths; 1 for an all-black scene. It is at least 2^-100 of the lights, since
 * single precision cannot hold a larger ratio. Refuses radiances that are not finite, and a largest
 * radiance that is rounding noise, at the place of their object.
 *
 * With phong shading points between vertices may be brighter. There the largest radiance is an
 * upper bound: every surface faces every light, shows the middle of its highlight, and is as near
 * to it as its nearest point. A light that touches a surface and has no constant attenuation has no
 * bound: it is refused unless the plan asks for a full scale. */
bool find_full_scale(struct lit_scene *lit, struct error *err);

/* ---- counts.c ---- */

/* Pixels evaluated together, few enough to stay in the first-level cache. */
enum { BLOCK = 256 };
enum { FULL_COUNT = 65535 };

/* Bound on the rounding of a sample by the steps of OpenGL's colour buffer, in counts. 0 for a
 * buffer of floats: its roundings are in the bounds of expect_counts. */
double buffer_rounding(const struct plan *plan);

/* A pixel of a spectral texture, in a band: the radiance that the texture is multiplied by, with a
 * bound on its error, in counts. */
struct textured_sample {
    struct texel_value texel;
    double radiance, error;
};
/* A run of n <= BLOCK pixels of one surface, whose rows and errors are `stride` apart. */
struct run {
    const struct shaded_material *shaded; /* NULL: the cleared background, which is exactly 0 */
    const double *rows;
    const float *errors; /* of rows; NULL: no bounds are needed */
    const float *own;    /* the part of errors that each band rounds by itself */
    size_t stride, n;
    struct textured_sample *textured; /* of the band that came last; NULL without errors */
};
/* The most of a sample that OpenGL's results that are flushed to zero take, in counts, some 10^-25
 * of full scale. Mesa flushes results below 2^-126 = 1.2e-38 to zero. The set-up of a plane
 * magnifies this error by one over the triangle's area (10^4 at most; smaller triangles are too
 * thin for a bound), by the distance to the framebuffer's origin (2 x 16384), and by a w of up to
 * 2048. There are 4 such steps. */
#define FLUSHED_COUNTS (FULL_COUNT * 1.2e-38 * 1e4 * 32768 * 2048 * 4)
/* Computes the counts of a run in one band, before rounding, and bounds on OpenGL's error if the
 * run has errors. A bound may be infinite. Fills in what the run keeps. */
void expect_counts(const struct lit_scene *lit, const struct run *run, int band, double *expected,
                   float *bound);
/* Adds to the sum of each pixel n_terms rows times factors; rows are run->stride apart. */
void add_rows(const struct run *run, const float *rows, const float *factors, size_t n_terms,
              float *sums);

/* ---- store.c ---- */

/* Numbers of samples that a file cannot hold as they are. */
struct odd_samples {
    uint64_t clipped;   /* above full_scale, stored as 65535 (or 255) */
    uint64_t undefined; /* NaN, infinite, or too large for a float page; stored as 0 */
};
/* Memory for one band of some rows: uint8_t or uint16_t counts, or float radiances, as the plan
 * says. Where the scene has several positions a pixel, the rows are whole pixels, and memory is for
 * their means. */
struct stored_band {
    const struct lit_scene *lit; /* with its full scale */
    int band;
    void *out; /* without gaps */
};
/* Stores bands of a picture by the reference. */
struct odd_samples store_reference(const struct stored_band *bands, int n_bands,
                                   const struct picture *picture);
/* Stores the bands of a pass, one after the other, of rows by OpenGL: `pixels` is their first
 * pixel, 4 floats each, rows `stride` pixels apart, in parts of full scale. Where a vertex is
 * brighter than full scale, a colour buffer of steps may have cut samples off; full ones then count
 * as clipped. */
struct odd_samples store_gl(const struct stored_band *bands, int n_bands,
                            const struct rectangle *rows, const float *pixels, size_t stride);

/* Clamp counts, and clamp and round them, as they are stored; NaN becomes 0. They stand in the
 * header so that loops over samples inline them. */
static inline double counts_clamp(double counts)
{
    double positive = counts > 0 ? counts : 0;
    return positive < FULL_COUNT ? positive : FULL_COUNT;
}
static inline int counts_round(double counts)
{
    return (int)(counts_clamp(counts) + 0.5);
}

#endif
