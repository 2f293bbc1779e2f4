/* SPDX-License-Identifier: MIT */
/* The bands that are wrong where no one geometry explains all bands of a pixel. The test across
 * bands compares each band with the pilots, and so fails in all bands if a pilot is wrong. With
 * c_ib for what an error of 1 in band i leaves in band b, errors x_i of the bands of a set explain
 * the pixel if |rest_b - sum_i c_ib x_i| is within the limit of each band b. Least squares, each
 * band divided by its limit, find the errors. Bands before the first one that failed were within
 * their limits; their rests, not kept, are taken for 0, and may be off by another limit. */
#include <math.h>

#include "raster/check/inside.h"

/* A set of bands that may be wrong, and least squares over all bands. */
struct suspects {
    const struct check *check;
    int first, n;
    double normal[BANDS_PER_PASS][BANDS_PER_PASS + 1]; /* the last column: the right-hand side */
};

/* Finds what errors of 1 in each suspect leave in a band, and the rest there: over its limit. */
static void leaves(const struct suspects *of, int band, double out[BANDS_PER_PASS + 1])
{
    const struct check *check = of->check;
    const struct lit_scene *lit = check->scene->lit;
    const struct shaded_material *shaded = lit->bounds[check->verdict.first.surface].shaded;
    const double limit = (double)check->limits[band];
    for (int i = 0; i < of->n; i++)
        out[i] = fit_leaves(&check->scene->fit, shaded, of->first + i, band) / limit;
    out[of->n] = (double)check->rests[band] / limit;
}

/* Solves the normal equations (Gauss and Jordan). A suspect that leaves nothing anywhere is taken
 * to be right. */
static void solve(struct suspects *of, double x[BANDS_PER_PASS])
{
    for (int i = 0; i < of->n; i++) {
        const double pivot = of->normal[i][i];
        for (int k = 0; k < of->n; k++) {
            const double factor = k == i || !(pivot > 0) ? 0 : of->normal[k][i] / pivot;
            for (int j = i; j <= of->n; j++)
                of->normal[k][j] -= factor * of->normal[i][j];
        }
    }
    for (int i = 0; i < of->n; i++)
        x[i] = of->normal[i][i] > 0 ? of->normal[i][of->n] / of->normal[i][i] : 0;
}

/* Returns whether errors of these bands alone explain the pixel. */
static bool explain(const struct check *check, int first, int n, struct odd_bands *out)
{
    struct suspects of = {.check = check, .first = first, .n = n};
    const int n_bands = check->scene->lit->plan->n_bands;
    double row[BANDS_PER_PASS + 1], x[BANDS_PER_PASS] = {0};
    for (int band = 0; band < n_bands; band++) {
        if (!(check->limits[band] > 0))
            continue;
        leaves(&of, band, row);
        for (int i = 0; i < n; i++)
            for (int j = 0; j <= n; j++)
                of.normal[i][j] += row[i] * row[j];
    }
    solve(&of, x);
    for (int band = 0; band < n_bands; band++) {
        double rest = 0;
        if (!(check->limits[band] > 0))
            continue;
        leaves(&of, band, row);
        for (int i = 0; i <= n; i++)
            rest += i < n ? -row[i] * x[i] : row[i];
        if (!(fabs(rest) <= (band < check->verdict.first.band ? 2 : 1)))
            return false;
    }
    *out = (struct odd_bands){first, first + n - 1, x[0]};
    return true;
}

/* Adds the sets of `size` bands of a pass that explain the pixel. */
static void add_odd(const struct check *check, int pass, int size, struct check_failure *failure)
{
    const int begin = pass * BANDS_PER_PASS, left = check->scene->lit->plan->n_bands - begin,
              n = left < BANDS_PER_PASS ? left : BANDS_PER_PASS;
    struct odd_bands odd;
    for (int first = begin; first + (size < n ? size : n) <= begin + n; first++)
        if (explain(check, first, size < n ? size : n, &odd) && failure->n_odd++ < MOST_ODD)
            failure->odd[failure->n_odd - 1] = odd;
}

void find_odd_bands(struct check *check)
{
    struct check_failure *failure = &check->verdict.first;
    const struct fit *fit = &check->scene->fit;
    const int pass = failure->band / BANDS_PER_PASS;
    for (int size = 1; size <= BANDS_PER_PASS && failure->n_odd == 0; size += BANDS_PER_PASS - 1) {
        bool own = false;
        for (int p = 0; p < fit->n_passes; p++) {
            add_odd(check, fit->passes[p], size, failure);
            own = own || fit->passes[p] == pass;
        }
        if (!own)
            add_odd(check, pass, size, failure);
    }
    failure->n_odd = failure->n_odd > MOST_ODD ? 0 : failure->n_odd;
}
