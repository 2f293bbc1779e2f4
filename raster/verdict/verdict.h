/* SPDX-License-Identifier: MIT */
/* The verdict on a picture: sums over samples and pixels, how much was checked, and what follows.
 */
#ifndef VERDICT_H
#define VERDICT_H

#include "raster/candidates/candidates.h"
#include "raster/fit/fit.h"
#include "raster/plan/plan.h"
#include "raster/radiance/radiance.h"
#include "raster/renderer/renderer.h"
#include "spectral.h"

/* ---- statistics.c: sums over many samples ---- */

/* Samples beside the candidates that explain them; in counts, before rounding. */
struct check_samples {
    uint64_t n, exact, within_1;
    double largest;             /* |OpenGL - reference| */
    double sum, sum_of_squares; /* of OpenGL - reference */
    double worst_ratio;     /* largest |OpenGL - reference| / bound of those within it; -1: none */
    double worst_fit_ratio; /* the same of what the other bands do not explain */
};
/* The floor of a pixel: the largest error that can pass there, in counts. An error of twice the
 * floor is always found. A histogram of pixels, and how many have a floor of at most 1, 8 and 256
 * counts. Above CHECKED_COUNTS, a step of a picture of 8 bits, a pixel is not checked. */
enum { FLOOR_BINS = 320, FLOOR_LEVELS = 3, CHECKED_COUNTS = 256 };
struct check_floor {
    uint64_t n, bins[FLOOR_BINS], within[FLOOR_LEVELS];
    double worst;
};
/* Returns the floor that `part` of the pixels do not exceed; too high by an eighth at most. */
double floor_quantile(const struct check_floor *of, double part);

enum failure_kind {
    FAILURE_RADIANCE,
    FAILURE_BANDS, /* no one geometry explains all bands */
    FAILURE_TRIANGLE,
    FAILURE_DEPTH,
    FAILURE_FRAGMENTS
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
    uint64_t pixels, ambiguous, unexplained;
    /* pixels of objects; those of them that have no bound below full scale; those not checked */
    uint64_t objects, unbounded, unchecked;
    int unchecked_surface;            /* the one with most of these; -1: there are none */
    enum bound_cause unchecked_cause; /* of most of its own */
    double mean_limit;                /* what roundings may leave of the mean residual, in counts */
    /* pixels where triangles meet, with too few or too many fragments */
    uint64_t edge_holes, edge_doubles;
    double worst_depth_ratio;
    /* of an error common to all bands; of that inside smooth surfaces; of an error of one band */
    struct check_floor floor, smooth_floor, band_floor;
    struct check_failure first;
    struct renderer_lacks lacks; /* not judged */
};

/* Samples together with the values and bounds that are expected. */
struct block {
    size_t n;
    float *seen;            /* OpenGL's, in parts of full scale; has room for whole lanes */
    double expected[BLOCK]; /* in counts */
    float bound[BLOCK];
    struct textured_sample textured[BLOCK]; /* kept for the fit */
    bool fitted;
    struct fit_block fit;    /* with no limit if the band is not fitted */
    float difference[BLOCK]; /* seen - expected, in counts */
};
/* Numbers that the compiler treats together: BLOCK is a multiple. */
enum { LANES = 4 };
/* Adds a block to a comparison, and fills in its differences. Returns false where any is outside of
 * its bound, or the rest that the fit leaves of it is outside of the limit. */
bool samples_compare(struct check_samples *samples, struct block *block);
void samples_add(struct check_samples *to, const struct check_samples *from);
void floor_note(struct check_floor *to, double counts);
void verdict_add(struct check_verdict *to, const struct check_verdict *from);

/* ---- outcome.c: the verdict on the picture ---- */

/* Shared by all checks of a render. */
struct check_scene {
    const struct lit_scene *lit;
    const struct fit *fit;
    double full_scale;
    bool clips;  /* of find_full_scale */
    bool mapped; /* a map is wanted */
};
/* Sums over the chunks of a tile, or over the tiles of a picture. The picture's are sums of tiles'
 * sums, in the order of the tiles: to the last bit they do not depend on who drew which tile. */
struct check_totals {
    const struct check_scene *scene;
    struct check_verdict verdict;
    double shared;   /* of all pixels: see struct mean_bound; in counts */
    double *varying; /* of each triangle, the sum over its pixels */
    size_t n_triangles;
    size_t *shown, n_shown, most_shown;  /* the triangles of a tile whose sum is above 0 */
    size_t *first;                       /* of each surface, its first triangle in `varying` */
    uint64_t (*unchecked)[BOUND_CAUSES]; /* of each surface: its pixels that are not checked */
};
/* False: no memory. The scene must outlive it. totals_free accepts what a failure left. */
bool totals_open(const struct check_scene *scene, struct check_totals *out, struct error *err);
void totals_free(struct check_totals *totals);
/* A pixel with a larger floor is not checked. The steps of a colour buffer come on top. */
double checked_counts(const struct plan *plan);
/* Adds a pixel of an object to the totals. An infinite floor: it has no bound. */
void totals_note(struct check_totals *totals, int surface, int triangle, double floor,
                 const struct mean_bound *mean);
/* Completes the verdict of the picture when all tiles are added. */
void totals_finish(struct check_totals *totals);

/* Agreed: no pixel is unexplained, and few enough are not checked. Differs: some pixel, or the mean
 * of all samples, is not what OpenGL may show. Not verified: too little could be checked. */
enum check_outcome { OUTCOME_AGREED, OUTCOME_DIFFERS, OUTCOME_NOT_VERIFIED };
enum check_outcome check_outcome(const struct plan *plan, const struct check_verdict *verdict);
/* The mean of OpenGL - reference over all samples; NaN: there is none. */
double mean_residual(const struct check_samples *samples);
/* True if roundings cannot leave so large a mean. */
bool is_biased(const struct check_verdict *verdict);

/* ---- sums over a tile ---- */

struct tile_sums {
    struct check_totals totals; /* open; scene NULL: there is no check */
    struct odd_samples odd;
    struct light_work light;
};
/* Adds a tile's sums to the picture's, and sets them to 0 for the next tile. */
void sums_add(struct tile_sums *picture, struct tile_sums *tile);

#endif
