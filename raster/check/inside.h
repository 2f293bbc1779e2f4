/* SPDX-License-Identifier: MIT */
/* Only the files of the room "check" include this. */
#ifndef RASTER_CHECK_INSIDE_H
#define RASTER_CHECK_INSIDE_H

#include "raster/check/check.h"

/* Returns the number of a pass with pilots; -1: it has none. */
int pilot_pass(const struct fit *fit, int pass);
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

/* Numbers that the compiler treats together: BLOCK is a multiple. */
enum { LANES = 4 };

/* ---- outcome.c: the verdict on the picture ---- */

/* A pixel with a larger floor is not checked. The steps of a colour buffer come on top. */
double checked_counts(const struct plan *plan);
/* Adds a pixel of an object to the totals. An infinite floor: it has no bound. */
void totals_note(struct check_totals *totals, int surface, int triangle, double floor,
                 const struct mean_bound *mean);

/* Counts the pixel as not explained. The first such pixel is kept with its failure. */
void check_fail(struct check *check, size_t pixel, const struct check_failure *failure);

void samples_add(struct check_samples *to, const struct check_samples *from);
extern const struct check_verdict empty_verdict; /* of no pixel */

size_t chunk_pixels(const struct chunk *chunk);

#endif
