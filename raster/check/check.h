/* SPDX-License-Identifier: MIT */
/* The room "check": judges each pixel of OpenGL's picture: some candidate must explain its
 * triangle, its depth, its fragments and its radiance in every band, within bounds. Then it judges
 * the picture: sums over samples and pixels, how much was checked, and what follows. This room
 * draws nothing, and may not know how bounds and candidates come about. No pixel is skipped.
 *
 * One geometry explains all bands. Where OpenGL's positions, lighting or places in a texture are
 * off, they are off by the same amount in every band: a pixel's radiances stay a sum over terms of
 * weight x spectrum, with weights that are off. A few bands, the pilots, show by how much. What the
 * weights so found leave of another band must be small: the roundings of that band, and those of
 * the pilots.
 *
 * With d for OpenGL's counts minus the reference's, S for spectra in counts, w for the error of the
 * weights and r for a band's own roundings, d_b = sum_t S_tb w_t + r_b. From the pilots k, linear
 * gains make the estimate v_t = sum_k g_tk d_k. With h_bk = sum_t S_tb g_tk a band then keeps
 *     d_b - sum_t S_tb v_t = r_b - sum_k h_bk r_k + sum_t (S_tb - sum_k h_bk S_tk) w_t,
 * whatever the gains are. With |r_b| <= sum_t q_t S_tb and |w_t| <= e_t this has the bound
 * sum_t (own_tb q_t + rest_tb e_t). A pilot helps to explain itself: what it keeps, and the bound,
 * are divided by 1 - h_bb, so that an error of this band alone shows in full. The gains are those
 * of least squares, with the bounds e as prior knowledge (Kalman 1960). */
#ifndef RASTER_CHECK_CHECK_H
#define RASTER_CHECK_CHECK_H

#include "raster/candidates/candidates.h"
#include "raster/counts/counts.h"

enum { MOST_PILOT_PASSES = 3, MOST_PILOTS = MOST_PILOT_PASSES * BANDS_PER_PASS };
/* A material; spectra are in counts. Arrays are owned. */
struct material_fit {
    int n_terms;
    float *spectra, *own, *rest; /* [band][term] */
    float *gains;                /* [pilot][term] */
    struct band_fit {
        float share;   /* rest_tb / spectrum_tb of the term where that is largest */
        float flushed; /* what results flushed to zero may add, in counts */
        float scale;   /* 1 / (1 - h_bb), or 0: the band is not fitted */
    } * bands;
};
struct fit {
    const struct plan *plan;
    int n_passes,
        passes[MOST_PILOT_PASSES];     /* of the pilots, ascending: only the last may be short */
    int n_pilots, pilots[MOST_PILOTS]; /* their bands */
    struct material_fit *materials;    /* as of the plan */
};
/* Chooses the pilots: the passes that say most about the weights of all materials. Nothing is
 * fitted in a colour buffer of few steps, whose rounding hides what a fit could show, and on
 * surfaces whose texture differs from band to band. The plan must outlive *out; fit_free accepts
 * what a failure left. Spectra are in counts of the scene's full scale. */
bool fit_make(const struct lit_scene *lit, struct fit *out, struct error *err);
void fit_free(struct fit *fit);

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
/* Bands, one or a whole pass, that alone would explain a pixel if they were wrong; and by how many
 * counts the first one is. */
struct odd_bands {
    int first, last;
    double off;
};
enum { MOST_ODD = 2 };
/* The first pixel that no candidate explains. */
struct check_failure {
    bool found;
    enum failure_kind kind;
    int x, y;
    int surface;                    /* of the reference; -1: background */
    struct shown shown;             /* FAILURE_TRIANGLE: by OpenGL */
    int band;                       /* FAILURE_RADIANCE, FAILURE_BANDS */
    struct odd_bands odd[MOST_ODD]; /* FAILURE_BANDS: each explains the pixel as well */
    int n_odd;                      /* 0: none does, or more */
    double seen, expected, bound;   /* counts; depths; fragments */
};
/* A pixel inside a surface is smooth if its radiance changes by no more than this within a pixel's
 * width, in any band: one step of a picture of 8 bits. */
enum { SMOOTH_COUNTS = 256 };
struct check_verdict {
    struct check_samples samples;
    uint64_t pixels, ambiguous, unexplained;
    /* of the ambiguous ones: OpenGL names the triangle on this side of an edge; not checked, since
     * OpenGL may as well show a rival; those of them that lie between others: see is_between */
    uint64_t edges, open, between;
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
    double most_unchecked;       /* of struct verdict_limits */
};

/* ---- outcome.c: the verdict on the picture ---- */

/* The most that a picture that agrees may leave unchecked. */
struct verdict_limits {
    bool strict;      /* fragments that are lost or doubled where triangles meet are differences */
    double unchecked; /* the largest share of object pixels that may stay unchecked */
};
/* Shared by all checks of a render. */
struct check_scene {
    const struct lit_scene *lit; /* with its full scale */
    struct fit fit;
    const struct verdict_limits *limits;
    bool mapped; /* a map is wanted */
};
/* Sums over all chunks of a picture, in their order: to the last bit they do not depend on which
 * thread drew which chunk. */
struct check_totals {
    const struct check_scene *scene;
    struct check_verdict verdict;
    double shared;   /* of all pixels: see struct mean_bound; in counts */
    double *varying; /* of each triangle, the sum over its pixels */
    size_t n_triangles;
    size_t *first;                       /* of each surface, its first triangle in `varying` */
    uint64_t (*unchecked)[BOUND_CAUSES]; /* of each surface: its pixels that are not checked */
};
/* False: no memory. The scene must outlive it. totals_free accepts what a failure left. */
bool totals_open(const struct check_scene *scene, struct check_totals *out, struct error *err);
void totals_free(struct check_totals *totals);
/* Completes the verdict of the picture when all chunks are settled. */
void totals_finish(struct check_totals *totals);

/* Agreed: no pixel is unexplained, and few enough are not checked. Differs: some pixel, or the mean
 * of all samples, is not what OpenGL may show. Not verified: too little could be checked. */
enum check_outcome { OUTCOME_AGREED, OUTCOME_DIFFERS, OUTCOME_NOT_VERIFIED };
enum check_outcome check_outcome(const struct check_verdict *verdict);
/* Returns how many of the unchecked pixels decide: see stack_unchecked. */
uint64_t check_unchecked(const struct check_verdict *verdict);
/* The mean of OpenGL - reference over all samples; NaN: there is none. */
double mean_residual(const struct check_samples *samples);
/* True if roundings cannot leave so large a mean. */
bool is_biased(const struct check_verdict *verdict);

/* ---- check.c: the verdict on each pixel ---- */

/* The state of a chunk while its bands go by. */
struct check {
    const struct check_scene *scene;
    const struct chunk *chunk;
    struct check_verdict verdict;
    struct hypothesis *hypotheses; /* one a candidate, then each ambiguous pixel's background */
    bool *failed;                  /* pixels that are not explained */
    /* of each pixel: the largest error that could pass in all bands alike, and in one band alone;
     * infinite: it has no bound; negative: it shows the background */
    float *floor, *band_floor;
    float *ratio;               /* the largest error / bound; NULL: no map is wanted */
    size_t first_failed;        /* the pixel of verdict.first; what the fit leaves of it there, */
    float *rests, *limits;      /* and the limit, of each band from that one on; 0: not known */
    float *estimates;           /* [row][pixel]: see fit_rows */
    float *candidate_estimates; /* [candidate][row] */
};
/* Returns the run of pixels from `first` on, below `end` and within a block, that show its surface
 * without ambiguity, none if it is ambiguous; or that of a candidate; NULL: of the background.
 * `textured` has room for a block. */
struct run settled_run(const struct lit_scene *lit, const struct chunk *chunk, size_t first,
                       size_t end, struct textured_sample *textured);
struct run candidate_run(const struct lit_scene *lit, const struct chunk *chunk,
                         const struct candidate *candidate, struct textured_sample *textured);
/* Opens the check of a chunk. Scene and chunk must outlive it. check_free accepts what a failure
 * left. */
bool check_open(const struct check_scene *scene, const struct chunk *chunk, struct check *out,
                struct error *err);
/* Judges triangles, depths and fragments that the renderer has identified in this tile; to be
 * called before the first pass. */
void check_identity(struct check *check, const struct renderer *renderer,
                    const struct rectangle *tile);
/* Judges the bands of a pass; if it `learns`, learns from a pass with pilots, to be called for all
 * of these before. `pixels` is the chunk's first pixel, 4 floats each, rows `stride` pixels apart,
 * in units of full_scale. */
void check_pass(struct check *check, int first_band, const float *pixels, size_t stride,
                bool learns);
/* Settles ambiguous pixels, and adds the chunk's verdict to the totals. The tile has the chunk and
 * its neighbours, all of them drawn. */
void check_settle(struct check *check, const struct tile *tile, struct check_totals *totals);
/* The class of a pixel in the map; the chunk is settled. */
enum check_class { CLASS_CHECKED, CLASS_AMBIGUOUS, CLASS_NOT_CHECKED, CLASS_DIFFERS };
enum check_class check_class(const struct check *check, size_t pixel);
void check_free(struct check *check);

#endif
