/* SPDX-License-Identifier: MIT */
/* Judges each pixel of OpenGL's picture: some candidate must explain its triangle, its depth, its
 * fragments and its radiance in every band, within bounds. This room draws nothing, and may not
 * know how bounds and candidates come about. No pixel is skipped. */
#ifndef CHECK_H
#define CHECK_H

#include "raster/bounds/bounds.h"
#include "raster/candidates/candidates.h"
#include "raster/fit/fit.h"
#include "raster/gl/gl.h"
#include "raster/radiance/radiance.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- statistics.c: sums over many samples ---- */

/* Samples beside the candidates that explain them; in counts, before rounding. */
struct check_samples {
    uint64_t n, exact, within_1;
    double largest;             /* |OpenGL - reference| */
    double sum, sum_of_squares; /* of OpenGL - reference */
    double worst_ratio;         /* largest |OpenGL - reference| / bound */
    double worst_fit_ratio;     /* largest of what the other bands do not explain / bound */
};
/* The detectability floor: the largest bound of a pixel over all bands, in counts; a histogram of
 * all pixels. An error of twice the floor is always found, an error below the floor can pass. */
enum { FLOOR_BINS = 320 };
struct check_floor {
    uint64_t n, bins[FLOOR_BINS];
    double worst;
};
/* Returns the floor that `part` of the pixels do not exceed; too high by an eighth at most. */
double floor_quantile(const struct check_floor *of, double part);

enum failure_kind {
    FAILURE_RADIANCE,
    FAILURE_BANDS, /* no one geometry explains all bands */
    FAILURE_TRIANGLE,
    FAILURE_DEPTH,
    FAILURE_FRAGMENTS,
    FAILURE_UNBOUNDED
};
/* The first pixel that no candidate explains. */
struct check_failure {
    bool found;
    enum failure_kind kind;
    int x, y;
    int surface;                  /* of the reference; -1: background */
    struct shown shown;           /* FAILURE_TRIANGLE: by OpenGL */
    int band;                     /* FAILURE_RADIANCE, FAILURE_BANDS */
    double seen, expected, bound; /* counts; depths; fragments */
};
/* A pixel inside a surface is smooth if its radiance changes by no more than this within a pixel's
 * width, in any band: one step of a picture of 8 bits. */
enum { SMOOTH_COUNTS = 256 };
struct check_verdict {
    struct check_samples samples;
    uint64_t pixels, ambiguous, unexplained, unbounded;
    /* pixels where triangles meet, with too few or too many fragments */
    uint64_t edge_holes, edge_doubles;
    double worst_depth_ratio;
    /* of an error common to all bands; of that inside smooth surfaces; of an error of one band */
    struct check_floor floor, smooth_floor, band_floor;
    struct check_failure first;
};

/* ---- check.c: the verdict on each pixel ---- */

/* What all checks of a render share. */
struct check_scene {
    const struct lit_scene *lit;
    const struct fit *fit;
    double full_scale;
};
/* The state of a chunk while its bands go by. */
struct check {
    const struct check_scene *scene;
    const struct chunk *chunk;
    bool tight_edges; /* fragments lost or doubled where triangles meet are failures */
    struct check_verdict verdict;
    struct hypothesis *hypotheses; /* one a candidate, then each ambiguous pixel's background */
    bool *failed;                  /* pixels that are not explained */
    /* of each pixel that is not ambiguous: the largest error that could pass in all bands alike,
     * and in one band alone */
    float *floor, *band_floor;
    float *estimates;           /* of picture.rows: errors of the weights, see fit.h */
    float *candidate_estimates; /* of candidate_rows */
};
/* Opens the check of a chunk. Scene and chunk must outlive it. On failure *out is zeroed. */
bool check_open(const struct check_scene *scene, const struct chunk *chunk, struct check *out,
                struct error *err);
/* Judges triangles, depths and fragments of the last gl_identify, which drew this tile; to be
 * called before the first pass. */
void check_identity(struct check *check, const struct gl *gl, const struct rectangle *tile);
/* Learns from a pass with pilots; to be called for all of those before the first check_pass. Judges
 * the bands of one pass. `pixels` is the chunk's first pixel, 4 floats each, rows
 * `stride` pixels apart, in units of full_scale. */
void check_pilots(struct check *check, int first_band, const float *pixels, size_t stride);
void check_pass(struct check *check, int first_band, const float *pixels, size_t stride);
/* Settles ambiguous pixels, adds the chunk's verdict to *total, and frees the check. The tile has
 * the chunk and its neighbours, all of them drawn. */
void check_close(struct check *check, const struct tile *tile, struct check_verdict *total);

/* ---- inside this room ---- */

/* Samples together with the values and bounds that are expected. */
struct block {
    size_t n;
    double seen[BLOCK], expected[BLOCK];
    float bound[BLOCK], difference[BLOCK];
    /* of a band that is fitted: what other bands explain of seen - expected; the rest, its bound */
    float explained[BLOCK], rest[BLOCK], limit[BLOCK];
    double scale; /* see fit_explain */
};
/* The hypothesis that OpenGL shows a candidate: it is alive until it fails to explain a sample. */
struct hypothesis {
    bool alive;
    struct check_samples samples;
    double floor, band_floor; /* the largest errors that could pass */
    struct check_failure failure;
    int band; /* the last one; -1: OpenGL shows another candidate */
};
size_t chunk_pixels(const struct chunk *chunk);
/* Counts the pixel as not explained. The first such pixel is kept with its failure. */
void check_fail(struct check *check, size_t pixel, const struct check_failure *failure);
/* Adds a block to a comparison, and fills in the magnitudes of its differences. Returns false where
 * any is outside its bound. */
bool samples_compare(struct check_samples *samples, struct block *block);
/* The same for what the fit leaves. */
bool samples_compare_fit(struct check_samples *samples, struct block *block);
void samples_add(struct check_samples *to, const struct check_samples *from);
void floor_note(struct check_floor *to, double counts);
void verdict_add(struct check_verdict *to, const struct check_verdict *from);

#endif
