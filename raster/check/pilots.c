/* SPDX-License-Identifier: MIT */
/* Chooses the pilots. Knowledge of the errors of weights is a covariance V; a band narrows it
 * as one measurement does (Kalman 1960): with a for the band's spectra and r for its roundings, the
 * product of the standard deviations shrinks by the square root of 1 + a V a / r^2. Pass by pass,
 * the one is taken that narrows the errors of all materials most. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/maths/maths.h"
#include "raster/check/inside.h"

/* Before any band is seen, a weight may be off by this many times its own roundings. The number
 * only steers the choice of pilots and gains: the bounds hold for every gain. */
static const double prior = 1024;
/* Bands that are darker than this part of the brightest one, or than this part of a count, teach
 * nothing: no error of theirs matters, and their gains would be beyond single precision. */
static const double dark = 0x1p-30;
/* A further pass is worth its memory if it narrows the errors of some material by a fifth. */
static const double worthwhile = 1.25;

/* ---- knowledge ---- */

static double in_band(const struct knowledge *of, int term, int band)
{
    return (double)of->material->spectra[(size_t)band * (size_t)of->n_terms + (size_t)term];
}

static double band_sum(const struct knowledge *knowledge, int band)
{
    double sum = 0;
    for (int t = 0; t < knowledge->n_terms; t++)
        sum += in_band(knowledge, t, band);
    return sum;
}

double band_rounding(const struct knowledge *knowledge, int band)
{
    double sum = band_sum(knowledge, band);
    return sum > dark * fmax(knowledge->brightest, 1) ? sum : 0;
}

bool knowledge_begin(const struct fit *fit, int material, struct knowledge *out, struct error *err)
{
    const size_t n = (size_t)fit->plan->materials[material].n_terms;
    *out = (struct knowledge){
        .material = &fit->materials[material], .n_terms = (int)n, .n_bands = fit->plan->n_bands};
    if (!MAKE_ARRAY(out->covariance, n * n, err, "the fit of a material") ||
        !MAKE_ARRAY(out->moved, n, err, "the fit of a material"))
        return false;
    for (size_t i = 0; i < n; i++)
        out->covariance[i * n + i] = prior * prior;
    for (int band = 0; band < out->n_bands; band++)
        out->brightest = fmax(out->brightest, band_sum(out, band));
    return true;
}

void knowledge_free(struct knowledge *knowledge)
{
    FREE_ALL(knowledge->covariance, knowledge->moved);
}

double knowledge_add(struct knowledge *knowledge, int band)
{
    const int n = knowledge->n_terms;
    const double rounding = band_rounding(knowledge, band), noise = rounding * rounding;
    double signal = 0;
    if (!(noise > 0))
        return 0;
    for (int i = 0; i < n; i++) {
        knowledge->moved[i] = 0;
        for (int j = 0; j < n; j++)
            knowledge->moved[i] += knowledge->covariance[i * n + j] * in_band(knowledge, j, band);
        signal += knowledge->moved[i] * in_band(knowledge, i, band);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            knowledge->covariance[i * n + j] -=
                knowledge->moved[i] * knowledge->moved[j] / (noise + signal);
    return 0.5 * binary_logarithm(1 + signal / noise);
}

/* ---- pilots ---- */

/* The state of the choice. */
struct choice {
    struct fit *fit;
    struct knowledge *known; /* of each material, from the passes chosen so far */
    double *saved;           /* room for the largest covariance */
};

static double add_pass(const struct fit *fit, struct knowledge *known, int pass)
{
    double narrowed = 0;
    for (int band = pass * BANDS_PER_PASS;
         band < (pass + 1) * BANDS_PER_PASS && band < fit->plan->n_bands; band++)
        narrowed += knowledge_add(known, band);
    return narrowed;
}

/* Returns by how much a pass would narrow the errors of all materials; *most: of one of them. */
static double worth_of(struct choice *choice, int pass, double *most)
{
    double sum = 0;
    for (int m = 0; m < choice->fit->plan->n_materials; m++) {
        struct knowledge *known = &choice->known[m];
        size_t size = (size_t)known->n_terms * (size_t)known->n_terms * sizeof *known->covariance;
        memcpy(choice->saved, known->covariance, size);
        double narrowed = add_pass(choice->fit, known, pass);
        memcpy(known->covariance, choice->saved, size);
        sum += narrowed;
        *most = fmax(*most, narrowed);
    }
    return sum;
}

/* Adds the pass that is worth most. Returns false where none is worth its memory. */
static bool choose_pass(struct choice *choice)
{
    struct fit *fit = choice->fit;
    double largest = 0;
    int best = -1;
    for (int pass = 0; pass < fit->plan->n_passes; pass++) {
        double most = 0, worth = fit_has_pilots(fit, pass) ? 0 : worth_of(choice, pass, &most);
        if (worth > largest && most > binary_logarithm(worthwhile)) {
            largest = worth;
            best = pass;
        }
    }
    if (best < 0)
        return false;
    for (int m = 0; m < fit->plan->n_materials; m++)
        add_pass(fit, &choice->known[m], best);
    fit->passes[fit->n_passes++] = best;
    return fit->n_passes < MAX_PILOT_PASSES;
}

static int compare_passes(const void *a, const void *b)
{
    const int *first = a, *second = b;
    return *first - *second;
}

bool pilots_choose(struct fit *fit, struct error *err)
{
    const int n_materials = fit->plan->n_materials;
    size_t most = 0;
    struct choice choice = {.fit = fit};
    bool done = MAKE_ARRAY(choice.known, n_materials, err, "the fit of materials");
    for (int m = 0; m < n_materials && done; m++) {
        size_t n = (size_t)fit->plan->materials[m].n_terms;
        most = n > most ? n : most;
        done = knowledge_begin(fit, m, &choice.known[m], err);
    }
    done = done && MAKE_ARRAY(choice.saved, most * most, err, "the fit of materials");
    while (done && choose_pass(&choice))
        ;
    qsort(fit->passes, (size_t)fit->n_passes, sizeof *fit->passes, compare_passes);
    for (int m = 0; m < n_materials && choice.known; m++)
        knowledge_free(&choice.known[m]);
    FREE_ALL(choice.known, choice.saved);
    return done;
}
