/* SPDX-License-Identifier: MIT */
/* The verdict on each pixel. */
#ifndef CHECK_H
#define CHECK_H

#include "raster/bounds/bounds.h"
#include "raster/candidates/candidates.h"
#include "raster/gl/gl.h"
#include "raster/radiance/radiance.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- statistics.c: how samples compare ---- */

/* How samples compare with the candidate that explains them; in counts, before rounding. */
struct check_samples {
    uint64_t n, exact, within_1;
    double largest;             /* |OpenGL - reference| */
    double sum, sum_of_squares; /* of OpenGL - reference */
    double worst_ratio;         /* largest |OpenGL - reference| / bound */
};
/* The detectability floor: of each pixel of a surface the largest bound over all wavelengths, in
 * counts. An error of twice that is always seen, one below the bound may be not. */
enum { FLOOR_BINS = 320 };
struct check_floor {
    uint64_t n, bins[FLOOR_BINS];
    double worst;
};
/* What `part` of the pixels have at most; too high by an eighth at most. */
double floor_quantile(const struct check_floor *of, double part);

enum failure_kind {
    FAILURE_RADIANCE,
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
    int surface;                  /* the reference's; -1: background */
    struct shown shown;           /* FAILURE_TRIANGLE: what OpenGL shows */
    int band;                     /* FAILURE_RADIANCE */
    double seen, expected, bound; /* counts; depths; fragments */
};
/* A pixel inside a surface is smooth if its radiance changes by no more than this within a pixel's
 * width, in any wavelength: one step of a picture of 8 bits. */
enum { SMOOTH_COUNTS = 256 };
struct check_verdict {
    struct check_samples samples;
    uint64_t pixels, ambiguous, unexplained, unbounded;
    /* pixels where triangles meet, with too few or too many fragments */
    uint64_t edge_holes, edge_doubles;
    double worst_depth_ratio;
    struct check_floor floor, smooth_floor;
    struct check_failure first;
};

/* ---- check.c: the verdict on each pixel ---- */

/* The state of a chunk while its bands go by. */
struct check {
    const struct lit_scene *lit;
    const struct chunk *chunk;
    double full_scale;
    bool tight_edges; /* fragments lost or doubled where triangles meet are failures */
    struct check_verdict verdict;
    struct hypothesis *hypotheses; /* one a candidate, then each ambiguous pixel's background */
    bool *failed;                  /* pixels that are not explained */
    float *floor;                  /* the largest bound of each pixel that is not ambiguous */
};
/* Opens the check of a chunk, whose memory the check does not own. */
bool check_open(const struct lit_scene *lit, const struct chunk *chunk, double full_scale,
                struct check *out, struct error *err);
/* Judges what gl_identify drew of the tile; to be called before the first pass. */
void check_identity(struct check *check, const struct gl *gl, const struct rectangle *tile);
/* Judges the bands of one GL pass. `pixels` is the chunk's first pixel, 4 floats each, rows
 * `stride` pixels apart, in units of full_scale. */
void check_pass(struct check *check, int first_band, const float *pixels, size_t stride);
/* Settles ambiguous pixels, adds the chunk's verdict to *total and frees the check. */
void check_close(struct check *check, struct check_verdict *total);

/* ---- inside this room ---- */

/* Samples together with what is expected of them. */
struct block {
    size_t n;
    double seen[BLOCK], expected[BLOCK];
    float bound[BLOCK], difference[BLOCK];
};
/* Adds a block to a comparison, and fills the magnitudes of its differences; false when any is
 * outside its bound. */
bool samples_compare(struct check_samples *samples, struct block *block);
void samples_add(struct check_samples *to, const struct check_samples *from);
void floor_note(struct check_floor *to, double counts);
void verdict_add(struct check_verdict *to, const struct check_verdict *from);

#endif
