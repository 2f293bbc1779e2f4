/* SPDX-License-Identifier: MIT */
/* Only the files of the room "check" include this. */
#ifndef RASTER_CHECK_INSIDE_H
#define RASTER_CHECK_INSIDE_H

#include "raster/check/check.h"

/* A run in a band, in counts: the part of each difference that the estimate explains, a bound on
 * the rest, and the largest error of this band alone that can pass. */
struct fit_block {
    float explained[BLOCK], limit[BLOCK], floor[BLOCK];
};

/* Returns the number of the pilot that is a band; -1: the band is none. */
int pilot_of(const struct fit *fit, int band);
/* Numbers of an estimate: of a pixel, at most; of a run's material. */
int fit_rows(const struct plan *plan);
/* Adds what a pilot band says to the estimate of a run's errors; numbers are as far apart as the
 * run's rows. difference: OpenGL's counts minus the reference's. The run keeps what expect_counts
 * filled in for this band, here and in fit_explain. */
void fit_add(const struct fit *fit, const struct run *run, int band, const double *difference,
             float *estimate);

/* The run has errors, and bounds in this band: see expect_counts. False: the band is not fitted,
 * and *out is not set. */
bool fit_explain(const struct fit *fit, const struct run *run, int band, const float *estimate,
                 const float *bound, struct fit_block *out);

/* Returns by how much an error of 1 in band `from` changes what the fit leaves of `band`; NaN: that
 * depends on the pixel, as the texture differs from band to band. */
double fit_leaves(const struct fit *fit, const struct shaded_material *shaded, int from, int band);

/* ---- odd_bands.c ---- */

/* Finds the bands that explain the first pixel that failed, with one candidate and in the test
 * across bands; its rests and limits are set: see struct odd_bands. */
void find_odd_bands(struct check *check);

/* ---- statistics.c: sums over many samples ---- */

/* Samples together with the values and bounds that are expected. */
struct block {
    size_t n;
    const float *seen;      /* OpenGL's, in parts of full scale */
    double expected[BLOCK]; /* in counts */
    float bound[BLOCK];
    struct textured_sample textured[BLOCK]; /* kept for the fit */
    bool fitted;
    struct fit_block fit;    /* with no limit if the band is not fitted */
    float difference[BLOCK]; /* seen - expected, in counts */
};

/* Adds a block to a comparison, and fills in its differences. Returns false where any is outside of
 * its bound, or the rest that the fit leaves of it is outside of the limit. */
bool samples_compare(struct check_samples *samples, struct block *block);
void floor_note(struct check_floor *to, double counts);

/* ---- outcome.c: the verdict on the picture ---- */

/* A pixel with a larger floor is not checked. The steps of a colour buffer come on top. */
double checked_counts(const struct plan *plan);
/* Adds a pixel of an object to the totals. An infinite floor: it has no bound. */
void totals_note(struct check_totals *totals, int surface, int triangle, double floor,
                 const struct mean_bound *mean);

/* The hypothesis that OpenGL shows a candidate: it is alive until it fails to explain a sample. */
struct hypothesis {
    bool alive;
    struct check_samples samples;
    float floor, band_floor; /* the largest errors that could pass */
    struct check_failure failure;
    int band; /* the last one; -1: OpenGL shows another candidate */
};

/* Counts the pixel as not explained. The first such pixel is kept with its failure. */
void check_fail(struct check *check, size_t pixel, const struct check_failure *failure);

void samples_add(struct check_samples *to, const struct check_samples *from);
extern const struct check_verdict empty_verdict; /* of no pixel */
void verdict_add(struct check_verdict *to, const struct check_verdict *from);

#endif
