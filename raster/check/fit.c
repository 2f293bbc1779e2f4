/* SPDX-License-Identifier: MIT */
/* The fit of each material: its pilots, gains and bounds, and what they say of a run of pixels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/check/inside.h"

int pilot_of(const struct fit *fit, int band)
{
    for (int p = 0; p < fit->n_passes; p++)
        if (fit->passes[p] == band / BANDS_PER_PASS)
            return p * BANDS_PER_PASS + band % BANDS_PER_PASS;
    return -1;
}

/* ---- the choice of pilots ---- */

/* Chooses the pilots. Knowledge of the errors of weights is a covariance V; a band narrows it
 * as one measurement does (Kalman 1960): with a for the band's spectra and r for its roundings, the
 * product of the standard deviations shrinks by the square root of 1 + a V a / r^2. Pass by pass,
 * the one is taken that narrows the errors of all materials most. */

/* Before any band is seen, a weight may be off by this many times its own roundings. The number
 * only steers the choice of pilots and gains: the bounds hold for every gain. */
static const double prior = 1024;
/* Bands that are darker than this part of the brightest one, or than this part of a count, teach
 * nothing: no error of theirs matters, and their gains would be beyond single precision. */
static const double dark = 0x1p-30;
/* A further pass is worth its memory if it narrows the errors of some material by a fifth. */
static const double worthwhile = 1.25;

/* Knowledge of the errors of a material's weights. */
struct knowledge {
    const struct material_fit *material;
    double brightest;   /* the largest sum of a band's spectra */
    double *covariance; /* [term][term]; owned, with room for the next two */
    double *saved;      /* room for a covariance */
    double *moved;      /* covariance x spectra of the band that came last */
};

/* The place of a term in the tables of a material: see struct material_fit. */
static size_t at(const struct material_fit *of, int term, int band)
{
    return (size_t)band * (size_t)of->n_terms + (size_t)term;
}

static double in_band(const struct material_fit *of, int term, int band)
{
    return (double)of->spectra[at(of, term, band)];
}

static double band_sum(const struct material_fit *material, int band)
{
    double sum = 0;
    for (int t = 0; t < material->n_terms; t++)
        sum += in_band(material, t, band);
    return sum;
}

/* The sum of a band's spectra: its rounding if each term rounds by 1. 0: too dark to teach us. */
static double band_rounding(const struct knowledge *knowledge, int band)
{
    double sum = band_sum(knowledge->material, band);
    return sum > dark * fmax(knowledge->brightest, 1) ? sum : 0;
}

/* Nothing is known but that errors are at most some multiple of roundings. False: no memory. */
static bool knowledge_begin(const struct fit *fit, const struct material_fit *material,
                            struct knowledge *out, struct error *err)
{
    const size_t n = (size_t)material->n_terms;
    *out = (struct knowledge){.material = material};
    if (!MAKE_ARRAY(out->covariance, n * (2 * n + 1), err, "the fit of a material"))
        return false;
    out->saved = out->covariance + n * n;
    out->moved = out->saved + n * n;
    for (size_t i = 0; i < n; i++)
        out->covariance[i * n + i] = prior * prior;
    for (int band = 0; band < fit->plan->n_bands; band++)
        out->brightest = fmax(out->brightest, band_sum(material, band));
    return true;
}

/* Takes a band into account. Returns by how much that narrows the errors, as a binary logarithm of
 * the product of standard deviations; 0 for a band that is black. */
static double knowledge_add(struct knowledge *knowledge, int band)
{
    const int n = knowledge->material->n_terms;
    const double rounding = band_rounding(knowledge, band), noise = rounding * rounding;
    double signal = 0;
    if (!(noise > 0))
        return 0;
    for (int i = 0; i < n; i++) {
        knowledge->moved[i] = 0;
        for (int j = 0; j < n; j++)
            knowledge->moved[i] +=
                knowledge->covariance[i * n + j] * in_band(knowledge->material, j, band);
        signal += knowledge->moved[i] * in_band(knowledge->material, i, band);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            knowledge->covariance[i * n + j] -=
                knowledge->moved[i] * knowledge->moved[j] / (noise + signal);
    return 0.5 * binary_logarithm(1 + signal / noise);
}

/* ---- pilots ---- */

static double add_pass(const struct fit *fit, struct knowledge *known, int pass)
{
    double narrowed = 0;
    const int first = pass * BANDS_PER_PASS;
    for (int i = 0; i < pass_bands(fit->plan, first); i++)
        narrowed += knowledge_add(known, first + i);
    return narrowed;
}

/* Returns by how much a pass would narrow the errors of all materials; *most: of one of them. */
static double worth_of(const struct fit *fit, struct knowledge *of, int pass, double *most)
{
    double sum = 0;
    for (int m = 0; m < fit->plan->n_materials; m++) {
        struct knowledge *known = &of[m];
        const size_t n = (size_t)known->material->n_terms, size = n * n * sizeof *known->covariance;
        memcpy(known->saved, known->covariance, size);
        double narrowed = add_pass(fit, known, pass);
        memcpy(known->covariance, known->saved, size);
        sum += narrowed;
        *most = fmax(*most, narrowed);
    }
    return sum;
}

/* Adds the pass that is worth most. known: of each material, from the passes chosen so far. Returns
 * false where none is worth its memory. */
static bool choose_pass(struct fit *fit, struct knowledge *known)
{
    double largest = 0;
    int best = -1, at;
    for (int pass = 0; pass < fit->plan->n_passes; pass++) {
        double most = 0;
        const bool is_chosen = pilot_of(fit, pass * BANDS_PER_PASS) >= 0;
        const double worth = is_chosen ? 0 : worth_of(fit, known, pass, &most);
        if (worth > largest && most > binary_logarithm(worthwhile)) {
            largest = worth;
            best = pass;
        }
    }
    if (best < 0)
        return false;
    for (int m = 0; m < fit->plan->n_materials; m++)
        add_pass(fit, &known[m], best);
    for (at = fit->n_passes++; at > 0 && fit->passes[at - 1] > best; at--)
        fit->passes[at] = fit->passes[at - 1];
    fit->passes[at] = best;
    return fit->n_passes < MOST_PILOT_PASSES;
}

/* Chooses fit->passes and fit->pilots. False: no memory. */
static bool pilots_choose(struct fit *fit, struct error *err)
{
    const int n_materials = fit->plan->n_materials;
    struct knowledge *known;
    bool done = MAKE_ARRAY(known, n_materials, err, "the fit of materials");
    for (int m = 0; m < n_materials && done; m++)
        done = knowledge_begin(fit, &fit->materials[m], &known[m], err);
    while (done && choose_pass(fit, known))
        ;
    for (int p = 0; p < fit->n_passes; p++)
        for (int i = 0, first = fit->passes[p] * BANDS_PER_PASS; i < pass_bands(fit->plan, first);
             i++)
            fit->pilots[fit->n_pilots++] = first + i;
    for (int m = 0; m < n_materials && known; m++)
        free(known[m].covariance);
    free(known);
    return done;
}

/* ---- places: surfaces whose texture differs from band to band ---- */

/* One place explains all bands. Where a texture differs from band to band, OpenGL's place in it is
 * off by the same p = (across, up, level of detail) in every band. With g for the slope of a band's
 * radiance there and n for a bound on everything else, d_b = g_b . p + n_b. Least squares over the
 * pilots k, with a bound e on p as prior knowledge, estimate p by M^-1 sum_k g_k d_k / n_k^2, where
 * M = sum_k g_k g_k' / n_k^2 + diag(1 / e^2). Let q = g_b' M^-1 g_b. By the inequality of Cauchy
 * and Schwarz the roundings of K pilots move the estimate's g_b . p by at most sqrt(K q), and the
 * prior of m unknowns by at most sqrt(m q).
 * Sums in single precision are off, those of M by r at most: r is added to the diagonal, so that M
 * does not become less. Both move g_b . p by at most sqrt(r q) |e|; the errors of the sum of
 * g_k d_k / n_k^2 by as much, and by a hundredth of the bounds above. */

/* Rows of an estimate: of the sum g g' / n^2 the lower triangle, row by row, and then of the sum
 * b of g d / n^2, for m unknowns m (m + 3) / 2; after the last pilot what take_root makes of them,
 * and one more. */
static size_t row_of_pair(int i, int j)
{
    return (size_t)(i * (i + 1) / 2 + j);
}
/* A sum of as many numbers as there are pilots is off by less than this part of its largest; r is
 * the same part of the trace of M. */
static const double sums_error = MOST_PILOTS * 6e-8, estimate_factor = 1.01;

static bool has_places(const struct shaded_material *shaded)
{
    return shaded->texture && shaded->texture->spectral;
}

/* Returns the numbers of a place that count, m. */
static int unknowns_of(const struct shaded_material *shaded)
{
    const struct texels texels = plan_texels(shaded->texture, 0);
    return place_rows(&texels);
}

/* A pilot that explains more than this part of itself, says nothing. */
#define MOST_OF_ITSELF 0.96875

/* A pixel in a band, in counts. */
struct slope {
    int m;
    double g[TEXEL_PLACE], noise;
    double e_place[TEXEL_PLACE];
    bool is_straight; /* within the bounds of the place; otherwise nothing else is set */
};

static struct slope slope_of(const struct run *run, int m, size_t i)
{
    const struct textured_sample *sample = &run->textured[i];
    const struct texel_value *texel = &sample->texel;
    struct slope out = {.m = m, .is_straight = texel->is_straight};
    if (!texel->is_straight)
        return out;
    out.noise = sample->error * (texel->value + texel->error) +
                fabs(sample->radiance) * texel->rest + FLUSHED_COUNTS;
    for (int k = 0; k < m; k++) {
        out.g[k] = sample->radiance * texel->slope[k];
        out.e_place[k] = (double)run->errors[(size_t)(run->shaded->n_terms + k) * run->stride + i];
    }
    return out;
}

/* Solves L x = b: see take_root. */
static void solve(int m, const float *root, size_t stride, const double *b, double *x)
{
    for (int i = 0; i < m; i++) {
        x[i] = b[i];
        for (int k = 0; k < i; k++)
            x[i] -= (double)root[row_of_pair(i, k) * stride] * x[k];
        x[i] *= (double)root[row_of_pair(i, i) * stride];
    }
}

/* Puts the root L of M = L L' (Cholesky) into the rows of M, with reciprocals on the diagonal, and
 * L^-1 b into those of b, for all bands to explain by: single precision rounds both by less than it
 * did the sums. The last row gets sqrt(K) + sqrt(m) + 3 sqrt(r) |e|, and a hundredth more. A place
 * without an error in some direction is not off in it: the reciprocal is 0. */
static void take_root(const struct slope *slope, int n_pilots, float *rows, size_t stride)
{
    const int m = slope->m;
    double root[TEXEL_PLACE][TEXEL_PLACE], b[TEXEL_PLACE], of_b[TEXEL_PLACE], r = 0, square = 0;
    for (int i = 0; i < m; i++) {
        r += sums_error * (double)rows[row_of_pair(i, i) * stride];
        square += slope->e_place[i] * slope->e_place[i];
        b[i] = (double)rows[row_of_pair(m, i) * stride];
    }
    for (int i = 0; i < m; i++)
        for (int j = 0; j <= i; j++) {
            double left = (double)rows[row_of_pair(i, j) * stride];
            left += i == j ? r + 1 / (slope->e_place[i] * slope->e_place[i]) : 0;
            for (int k = 0; k < j; k++)
                left -= root[i][k] * root[j][k];
            root[i][j] = i == j ? 1 / sqrt(left) : left * root[j][j];
            rows[row_of_pair(i, j) * stride] = (float)root[i][j];
        }
    solve(m, rows, stride, b, of_b);
    for (int i = 0; i < m; i++)
        rows[row_of_pair(m, i) * stride] = (float)of_b[i];
    rows[row_of_pair(m, m) * stride] =
        (float)(estimate_factor * (sqrt(n_pilots) + sqrt(m) + 3 * sqrt(r * square)));
}

static void place_add(const struct fit *fit, const struct run *run, const double *difference,
                      bool is_last, float *estimate)
{
    const int m = unknowns_of(run->shaded);
    for (size_t i = 0; i < run->n; i++) {
        const struct slope slope = slope_of(run, m, i);
        const double over = 1 / (slope.noise * slope.noise), *g = slope.g;
        for (int j = 0; j < m && slope.is_straight; j++) {
            for (int k = 0; k <= j; k++)
                estimate[row_of_pair(j, k) * run->stride + i] += (float)(g[j] * g[k] * over);
            estimate[row_of_pair(m, j) * run->stride + i] += (float)(g[j] * difference[i] * over);
        }
        if (is_last && slope.is_straight)
            take_root(&slope, fit->n_passes * BANDS_PER_PASS, estimate + i, run->stride);
    }
}

/* Finds g . M^-1 b, what the estimate explains, and q. */
static void estimate_place(const struct slope *slope, const float *rows, size_t stride,
                           double *explained, double *q)
{
    double of_g[TEXEL_PLACE];
    solve(slope->m, rows, stride, slope->g, of_g);
    *explained = *q = 0;
    for (int k = 0; k < slope->m; k++) {
        *explained += of_g[k] * (double)rows[row_of_pair(slope->m, k) * stride];
        *q += of_g[k] * of_g[k];
    }
}

/* Where the texture bends, nothing is explained. */
static void place_explain(const struct fit *fit, const struct run *run, int band,
                          const float *estimate, struct fit_block *out)
{
    const bool is_pilot = pilot_of(fit, band) >= 0;
    const int m = unknowns_of(run->shaded);
    for (size_t i = 0; i < run->n; i++) {
        const struct slope slope = slope_of(run, m, i);
        double explained, q;
        out->explained[i] = 0;
        out->limit[i] = out->floor[i] = HUGE_VALF;
        if (!slope.is_straight)
            continue;
        estimate_place(&slope, estimate + i, run->stride, &explained, &q);
        const double itself = is_pilot ? q / (slope.noise * slope.noise) : 0;
        out->explained[i] = (float)explained;
        out->limit[i] =
            (float)slope.noise + estimate[row_of_pair(m, m) * run->stride + i] * (float)sqrt(q);
        out->floor[i] = itself < MOST_OF_ITSELF ? out->limit[i] / (float)(1 - itself) : HUGE_VALF;
    }
}

/* ---- a material ---- */

/* Computes the gains of least squares: covariance x spectra / rounding^2, with the covariance after
 * all pilots. */
static bool make_gains(const struct fit *fit, struct material_fit *of, struct error *err)
{
    struct knowledge known;
    const int n = of->n_terms;
    bool done = knowledge_begin(fit, of, &known, err);
    for (int k = 0; k < fit->n_pilots && done; k++)
        knowledge_add(&known, fit->pilots[k]);
    for (int k = 0; k < fit->n_pilots && done; k++) {
        double rounding = band_rounding(&known, fit->pilots[k]);
        for (int i = 0; i < n && rounding > 0; i++) {
            double sum = 0;
            for (int j = 0; j < n; j++)
                sum += known.covariance[i * n + j] * in_band(of, j, fit->pilots[k]);
            of->gains[k * n + i] = (float)(sum / (rounding * rounding));
        }
    }
    free(known.covariance);
    return done;
}

/* The influence of the pilots on a band: h of each, and the sum of |S_tb g_tk|, which its roundings
 * are relative to. */
struct influence {
    double h[MOST_PILOTS], size[MOST_PILOTS], sum;
};

static struct influence influence_on(const struct fit *fit, const struct material_fit *of, int band)
{
    struct influence out = {.sum = 0};
    for (int k = 0; k < fit->n_pilots; k++) {
        for (int t = 0; t < of->n_terms; t++) {
            double part = in_band(of, t, band) * (double)of->gains[k * of->n_terms + t];
            out.h[k] += part;
            out.size[k] += fabs(part);
        }
        out.sum += fabs(out.h[k]);
    }
    return out;
}

double fit_leaves(const struct fit *fit, const struct shaded_material *shaded, int from, int band)
{
    const struct material_fit *of = &fit->materials[shaded - fit->plan->materials];
    const int pilot = pilot_of(fit, from);
    const double itself = from == band;
    if (has_places(shaded))
        return (double)NAN;
    return pilot < 0 ? itself : itself - influence_on(fit, of, band).h[pilot];
}

/* A rest of errors that is not worth a loop over terms. */
static const float small_share = 0x1p-10F;

/* The estimate is a sum over pilots in single precision, and so is what it explains. */
enum { ESTIMATE_ROUNDINGS = MOST_PILOTS + 8 };

static void bound_band(const struct fit *fit, struct material_fit *of, int band)
{
    struct influence by = influence_on(fit, of, band);
    struct band_fit *out = &of->bands[band];
    const int itself = pilot_of(fit, band);
    const double kept = itself < 0 ? 1 : 1 - by.h[itself];
    bool fitted = by.sum > 0 && kept >= 1 - MOST_OF_ITSELF;
    out->scale = fitted ? (float)(1 / kept) : 0;
    out->flushed = (float)(FLUSHED_COUNTS * (1 + by.sum));
    for (int t = 0; t < of->n_terms; t++) {
        double s = in_band(of, t, band), own = s * fabs(kept), rest = s, rounding = 0;
        for (int k = 0; k < fit->n_pilots; k++) {
            double of_pilot = in_band(of, t, fit->pilots[k]);
            own += k == itself ? 0 : fabs(by.h[k]) * of_pilot;
            rest -= by.h[k] * of_pilot;
            rounding += by.size[k] * of_pilot;
        }
        double left = fabs(rest) + roundings(ESTIMATE_ROUNDINGS) * (s + rounding);
        of->own[at(of, t, band)] = (float)own;
        of->rest[at(of, t, band)] = (float)left;
        out->share = fmaxf(out->share, left > 0 ? (float)(1.000001 * left / s) : 0);
    }
}

/* ---- all materials ---- */

static bool make_spectra(struct fit *fit, double full_scale, struct error *err)
{
    const struct plan *plan = fit->plan;
    for (int m = 0; m < plan->n_materials; m++) {
        const struct shaded_material *shaded = &plan->materials[m];
        struct material_fit *out = &fit->materials[m];
        const size_t n_terms = (size_t)shaded->n_terms, n_bands = (size_t)plan->n_bands,
                     n = n_terms * n_bands;
        out->n_terms = shaded->n_terms;
        if (!MAKE_ARRAY(out->spectra, n, err, "the spectra of a material") ||
            !MAKE_ARRAY(out->own, n, err, "the bounds of a material") ||
            !MAKE_ARRAY(out->rest, n, err, "the bounds of a material") ||
            !MAKE_ARRAY(out->gains, n_terms * MOST_PILOTS, err, "the fit of a material") ||
            !MAKE_ARRAY(out->bands, n_bands, err, "the fit of a material"))
            return false;
        for (size_t t = 0; t < n_terms; t++)
            for (size_t band = 0; band < n_bands; band++)
                out->spectra[band * n_terms + t] =
                    (float)(shaded->made.spectra[t * n_bands + band] / full_scale * FULL_COUNT);
    }
    return true;
}

bool fit_make(const struct lit_scene *lit, struct fit *out, struct error *err)
{
    const struct plan *plan = lit->plan;
    *out = (struct fit){.plan = plan};
    bool done = MAKE_ARRAY(out->materials, plan->n_materials, err, "the fit of materials") &&
                make_spectra(out, lit->full_scale, err) &&
                (buffer_steps(plan) > 0 || pilots_choose(out, err));
    for (int m = 0; m < plan->n_materials && done && out->n_passes > 0; m++) {
        if (has_places(&plan->materials[m]))
            continue;
        done = make_gains(out, &out->materials[m], err);
        for (int band = 0; band < plan->n_bands && done; band++)
            bound_band(out, &out->materials[m], band);
    }
    return done;
}

void fit_free(struct fit *fit)
{
    for (int m = 0; fit->materials && m < fit->plan->n_materials; m++) {
        struct material_fit *material = &fit->materials[m];
        FREE_ALL(material->spectra, material->own, material->rest, material->gains,
                 material->bands);
    }
    free(fit->materials);
    *fit = (struct fit){.plan = NULL};
}

/* ---- a run of pixels ---- */

static const struct material_fit *material_of(const struct fit *fit, const struct run *run)
{
    return &fit->materials[run->shaded - fit->plan->materials];
}

int fit_rows(const struct plan *plan)
{
    int rows = plan->max_rows;
    for (int i = 0; i < plan->n_materials; i++) {
        const int m = has_places(&plan->materials[i]) ? unknowns_of(&plan->materials[i]) : 0,
                  n = m > 0 ? m * (m + 3) / 2 + 1 : 0;
        rows = n > rows ? n : rows;
    }
    return rows;
}

void fit_add(const struct fit *fit, const struct run *run, int band, const double *difference,
             float *estimate)
{
    const size_t n_terms = (size_t)run->shaded->n_terms;
    if (has_places(run->shaded)) {
        place_add(fit, run, difference, band == fit->pilots[fit->n_pilots - 1], estimate);
        return;
    }
    const float *gains = material_of(fit, run)->gains + (size_t)pilot_of(fit, band) * n_terms;
    for (size_t t = 0; t < n_terms; t++)
        for (size_t i = 0; i < run->n; i++)
            estimate[t * run->stride + i] += gains[t] * (float)difference[i];
}

VECTORIZED bool fit_explain(const struct fit *fit, const struct run *run, int band,
                            const float *estimate, const float *bound, struct fit_block *out)
{
    const struct material_fit *material = material_of(fit, run);
    const size_t n_terms = (size_t)run->shaded->n_terms, at = (size_t)band * n_terms;
    if (has_places(run->shaded) && fit->n_passes > 0) {
        place_explain(fit, run, band, estimate, out);
        return true;
    }
    if (!(material->bands[band].scale > 0))
        return false;
    /* where what is left of the errors of weights is a small share of them, it is at most the same
     * share of the bounds */
    const float scale = material->bands[band].scale, left = material->bands[band].share,
                share = left <= small_share ? left : 0;
    memset(out->explained, 0, run->n * sizeof *out->explained);
    for (size_t i = 0; i < run->n; i++)
        out->limit[i] = material->bands[band].flushed;
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
