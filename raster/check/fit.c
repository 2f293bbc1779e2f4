/* SPDX-License-Identifier: MIT */
/* Gains and bounds of each material, and what they say of a run of pixels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/maths/maths.h"
#include "raster/check/inside.h"

/* ---- a material ---- */

/* The pilots of a material, while its bounds are computed. */
struct pilots {
    const struct fit *fit;
    const struct shaded_material *shaded;
    struct material_fit *out;
    int n, band[MAX_PILOTS];
};

static float *at(const struct pilots *of, float *table, int term, int band)
{
    return &table[(size_t)band * (size_t)of->shaded->n_terms + (size_t)term];
}

/* Computes the gains of least squares: covariance x spectra / rounding^2, with the covariance after
 * all pilots. */
static bool make_gains(const struct pilots *of, int material, struct error *err)
{
    struct knowledge known;
    const int n = of->shaded->n_terms;
    bool done = knowledge_begin(of->fit, material, &known, err);
    for (int k = 0; k < of->n && done; k++)
        knowledge_add(&known, of->band[k]);
    for (int k = 0; k < of->n && done; k++) {
        double rounding = band_rounding(&known, of->band[k]);
        for (int i = 0; i < n && rounding > 0; i++) {
            double sum = 0;
            for (int j = 0; j < n; j++)
                sum +=
                    known.covariance[i * n + j] * (double)*at(of, of->out->spectra, j, of->band[k]);
            of->out->gains[k * n + i] = (float)(sum / (rounding * rounding));
        }
    }
    knowledge_free(&known);
    return done;
}

/* The influence of the pilots on a band: h of each, and the sum of |S_tb g_tk|, which its roundings
 * are relative to. */
struct influence {
    double h[MAX_PILOTS], size[MAX_PILOTS], sum;
    int itself; /* the pilot that is this band; -1: none */
};

static struct influence influence_on(const struct pilots *of, int band)
{
    struct influence out = {.itself = -1};
    for (int k = 0; k < of->n; k++) {
        for (int t = 0; t < of->shaded->n_terms; t++) {
            double part = (double)*at(of, of->out->spectra, t, band) *
                          (double)of->out->gains[k * of->shaded->n_terms + t];
            out.h[k] += part;
            out.size[k] += fabs(part);
        }
        out.sum += fabs(out.h[k]);
        if (of->band[k] == band)
            out.itself = k;
    }
    return out;
}

/* A rest of errors that is not worth a loop over terms. */
static const float small_share = 0x1p-10F;

/* The estimate is a sum over pilots in single precision, and so is what it explains. */
enum { ESTIMATE_ROUNDINGS = MAX_PILOTS + 8 };

static void bound_band(const struct pilots *of, int band)
{
    struct influence by = influence_on(of, band);
    double kept = by.itself < 0 ? 1 : 1 - by.h[by.itself];
    bool fitted = by.sum > 0 && kept >= 1 - MOST_OF_ITSELF;
    of->out->scale[band] = fitted ? (float)(1 / kept) : 0;
    of->out->flushed[band] = (float)(flushed_counts() * (1 + by.sum));
    for (int t = 0; t < of->shaded->n_terms; t++) {
        double s = (double)*at(of, of->out->spectra, t, band), own = s * fabs(kept), rest = s,
               rounding = 0;
        for (int k = 0; k < of->n; k++) {
            double of_pilot = (double)*at(of, of->out->spectra, t, of->band[k]);
            own += k == by.itself ? 0 : fabs(by.h[k]) * of_pilot;
            rest -= by.h[k] * of_pilot;
            rounding += by.size[k] * of_pilot;
        }
        *at(of, of->out->own, t, band) = (float)own;
        double left = fabs(rest) + roundings(ESTIMATE_ROUNDINGS) * (s + rounding);
        *at(of, of->out->rest, t, band) = (float)left;
        of->out->share[band] =
            fmaxf(of->out->share[band], left > 0 ? (float)(1.000001 * left / s) : 0);
    }
}

static bool allocate(const struct fit *fit, const struct shaded_material *shaded,
                     struct material_fit *out, struct error *err)
{
    const size_t n_bands = (size_t)fit->plan->n_bands, n = (size_t)shaded->n_terms * n_bands;
    return MAKE_ARRAY(out->spectra, n, err, "the spectra of a material") &&
           MAKE_ARRAY(out->own, n, err, "the bounds of a material") &&
           MAKE_ARRAY(out->rest, n, err, "the bounds of a material") &&
           MAKE_ARRAY(out->gains, shaded->n_terms * MAX_PILOTS, err, "the fit of a material") &&
           MAKE_ARRAY(out->share, n_bands, err, "the fit of a material") &&
           MAKE_ARRAY(out->flushed, n_bands, err, "the fit of a material") &&
           MAKE_ARRAY(out->scale, n_bands, err, "the fit of a material");
}

static bool fit_material(const struct fit *fit, int material, struct error *err)
{
    const struct shaded_material *shaded = &fit->plan->materials[material];
    struct pilots of = {.fit = fit, .shaded = shaded, .out = &fit->materials[material]};
    if (has_places(shaded))
        return true;
    for (int p = 0; p < fit->n_passes; p++)
        for (int c = 0; c < BANDS_PER_PASS; c++)
            if (fit->passes[p] * BANDS_PER_PASS + c < fit->plan->n_bands)
                of.band[of.n++] = fit->passes[p] * BANDS_PER_PASS + c;
    if (!make_gains(&of, material, err))
        return false;
    for (int band = 0; band < fit->plan->n_bands; band++)
        bound_band(&of, band);
    return true;
}

/* ---- all materials ---- */

static bool make_spectra(struct fit *fit, double full_scale, struct error *err)
{
    const struct plan *plan = fit->plan;
    for (int m = 0; m < plan->n_materials; m++) {
        const struct shaded_material *shaded = &plan->materials[m];
        if (!allocate(fit, shaded, &fit->materials[m], err))
            return false;
        const size_t n_terms = (size_t)shaded->n_terms, n_bands = (size_t)plan->n_bands;
        for (size_t t = 0; t < n_terms; t++)
            for (size_t band = 0; band < n_bands; band++)
                fit->materials[m].spectra[band * n_terms + t] =
                    (float)(shaded->made.spectra[t * n_bands + band] / full_scale * FULL_COUNT);
    }
    return true;
}

bool fit_make(const struct plan *plan, double full_scale, struct fit *out, struct error *err)
{
    *out = (struct fit){.plan = plan};
    bool done = MAKE_ARRAY(out->materials, plan->n_materials, err, "the fit of materials") &&
                make_spectra(out, full_scale, err) &&
                (buffer_steps(plan) > 0 || pilots_choose(out, err));
    for (int m = 0; m < plan->n_materials && done && out->n_passes > 0; m++)
        done = fit_material(out, m, err);
    return done;
}

void fit_free(struct fit *fit)
{
    for (int m = 0; fit->materials && m < fit->plan->n_materials; m++) {
        struct material_fit *material = &fit->materials[m];
        FREE_ALL(material->spectra, material->own, material->rest, material->gains, material->share,
                 material->flushed, material->scale);
    }
    free(fit->materials);
    *fit = (struct fit){.plan = NULL};
}

bool fit_has_pilots(const struct fit *fit, int pass)
{
    for (int p = 0; p < fit->n_passes; p++)
        if (fit->passes[p] == pass)
            return true;
    return false;
}

/* ---- a run of pixels ---- */

static const struct material_fit *material_of(const struct fit *fit, const struct run *run)
{
    return &fit->materials[run->shaded - fit->plan->materials];
}

/* The number of a pilot band: see struct material_fit. */
static size_t pilot_of(const struct fit *fit, int band)
{
    size_t p = 0;
    while (fit->passes[p] != band / BANDS_PER_PASS)
        p++;
    return p * BANDS_PER_PASS + (size_t)(band % BANDS_PER_PASS);
}

int fit_rows(const struct plan *plan)
{
    int rows = plan->max_rows;
    for (int m = 0; m < plan->n_materials; m++)
        if (has_places(&plan->materials[m]) && rows < PLACE_ROWS)
            rows = PLACE_ROWS;
    return rows;
}

void fit_add(const struct fit *fit, const struct run *run, int band, const double *difference,
             float *estimate)
{
    const size_t n_terms = (size_t)run->shaded->n_terms;
    if (has_places(run->shaded)) {
        place_add(run, difference, estimate);
        return;
    }
    const float *gains = material_of(fit, run)->gains + pilot_of(fit, band) * n_terms;
    for (size_t t = 0; t < n_terms; t++)
        for (size_t i = 0; i < run->n; i++)
            estimate[t * run->stride + i] += gains[t] * (float)difference[i];
}

bool fit_explain(const struct fit *fit, const struct run *run, int band, const float *estimate,
                 const float *bound, struct fit_block *out)
{
    const struct material_fit *material = material_of(fit, run);
    const size_t n_terms = (size_t)run->shaded->n_terms, at = (size_t)band * n_terms;
    if (has_places(run->shaded) && fit->n_passes > 0) {
        place_explain(fit, run, band, estimate, out);
        return true;
    }
    if (!(material->scale[band] > 0))
        return false;
    /* where what is left of the errors of weights is a small share of them, it is at most the same
     * share of the bounds */
    const float scale = material->scale[band], left = material->share[band],
                share = left <= small_share ? left : 0;
    memset(out->explained, 0, run->n * sizeof *out->explained);
    for (size_t i = 0; i < run->n; i++)
        out->limit[i] = material->flushed[band];
    add_rows(run, estimate, material->spectra + at, n_terms, out->explained);
    add_rows(run, run->own, material->own + at, n_terms, out->limit);
    if (!(left <= small_share))
        add_rows(run, run->errors, material->rest + at, n_terms, out->limit);
    for (size_t i = 0; i < run->n; i++) {
        const float limit = out->limit[i] + (share > 0 ? share * bound[i] : 0);
        out->limit[i] = limit;
        out->floor[i] = limit * scale;
    }
    return true;
}
