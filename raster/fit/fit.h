/* SPDX-License-Identifier: MIT */
/* One geometry explains all bands. Where OpenGL's positions, lighting or places in a texture are
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
#ifndef FIT_H
#define FIT_H

#include "raster/plan/plan.h"
#include "raster/radiance/radiance.h"
#include "spectral.h"

enum { MAX_PILOT_PASSES = 3, MAX_PILOTS = MAX_PILOT_PASSES * BANDS_PER_PASS };
/* A material; spectra are in counts. Arrays are owned. */
struct material_fit {
    float *spectra, *own, *rest; /* [band][term] */
    float *gains;                /* [pilot][term] */
    float *share;   /* [band] rest_tb / spectrum_tb of the term where that is largest */
    float *flushed; /* [band] what results flushed to zero may add, in counts */
    float *scale;   /* [band] 1 / (1 - h_bb), or 0: the band is not fitted */
};
struct fit {
    const struct plan *plan;
    int n_passes,
        passes[MAX_PILOT_PASSES];   /* of the pilots, ascending: only the last may be short */
    struct material_fit *materials; /* as of the plan */
};
/* Chooses the pilots: the passes that say most about the weights of all materials. Nothing is
 * fitted in a colour buffer of few steps, whose rounding hides what a fit could show, and on
 * surfaces whose texture differs from band to band. The plan must outlive *out; fit_free accepts
 * what a failure left. */
bool fit_make(const struct plan *plan, double full_scale, struct fit *out, struct error *err);
void fit_free(struct fit *fit);
/* True if the pass holds pilots. */
bool fit_has_pilots(const struct fit *fit, int pass);
/* Numbers of an estimate: of a pixel, at most; of a run's material. */
int fit_rows(const struct plan *plan);
/* Adds what a pilot band says to the estimate of a run's errors; numbers are as far apart as the
 * run's rows. difference: OpenGL's counts minus the reference's. The run keeps what expect_counts
 * filled in for this band, here and in fit_explain. */
void fit_add(const struct fit *fit, const struct run *run, int band, const double *difference,
             float *estimate);
/* A run in a band, in counts: the part of each difference that the estimate explains, a bound on
 * the rest, and the largest error of this band alone that can pass. */
struct fit_block {
    float explained[BLOCK], limit[BLOCK], floor[BLOCK];
};
/* The run has errors, and bounds in this band: see expect_counts. False: the band is not fitted,
 * and *out is not set. */
bool fit_explain(const struct fit *fit, const struct run *run, int band, const float *estimate,
                 const float *bound, struct fit_block *out);

/* ---- inside this room ---- */

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

#endif
