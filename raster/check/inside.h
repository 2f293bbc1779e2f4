/* SPDX-License-Identifier: MIT */
/* Only the files of the room "check" include this. */
#ifndef RASTER_CHECK_INSIDE_H
#define RASTER_CHECK_INSIDE_H

#include "raster/check/check.h"

/* True if the pass holds pilots. */
bool fit_has_pilots(const struct fit *fit, int pass);
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

/* A pilot that explains more than this part of itself, says nothing. */
#define MOST_OF_ITSELF 0.96875

/* Knowledge of the errors of a material's weights. */
struct knowledge {
    const struct material_fit *material;
    int n_terms, n_bands;
    double brightest;   /* the largest sum of a band's spectra */
    double *covariance; /* [term][term]; owned */
    double *moved;      /* covariance x spectra of the band that came last; owned */
};
/* Nothing is known but that errors are at most some multiple of roundings. False: no memory;
 * knowledge_free accepts what is left. */
bool knowledge_begin(const struct fit *fit, int material, struct knowledge *out, struct error *err);
void knowledge_free(struct knowledge *knowledge);
/* Takes a band into account. Returns by how much that narrows the errors, as a binary logarithm of
 * the product of standard deviations; 0 for a band that is black. */
double knowledge_add(struct knowledge *knowledge, int band);
/* The sum of a band's spectra: its rounding if each term rounds by 1. 0: too dark to teach us. */
double band_rounding(const struct knowledge *knowledge, int band);
/* Chooses fit->passes. False: no memory. */
bool pilots_choose(struct fit *fit, struct error *err);
/* place.c: the same for surfaces whose texture differs from band to band. */
enum { PLACE_ROWS = 5 };
bool has_places(const struct shaded_material *shaded);
void place_add(const struct run *run, const double *difference, float *estimate);
void place_explain(const struct fit *fit, const struct run *run, int band, const float *estimate,
                   struct fit_block *out);

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

#endif
