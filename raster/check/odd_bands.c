/* SPDX-License-Identifier: MIT */
/* The bands that are wrong where no one geometry explains all bands of a pixel. The test across
 * bands compares each band with the pilots, and so fails in all bands if a pilot is wrong. With
 * c_ib for what an error of 1 in band i leaves in band b, errors x_i of the bands of a set explain
 * the pixel if |rest_b - sum_i c_ib x_i| is within the limit of each band b. Least squares, each
 * band divided by its limit, find the errors. Bands before the first one that failed were within
 * their limits; their rests, not kept, are taken for 0, and may be off by another limit. */
#include <math.h>

#include "raster/check/inside.h"

enum { COLUMNS = BANDS_PER_PASS + 1 };

/* Finds what errors of 1 in n bands leave in a band, and the rest there: over its limit. Returns
 * false if that is not known. */
static bool leaves(const struct check *check, int first, int n, int band, double out[COLUMNS])
{
    const struct lit_scene *lit = check->scene->lit;
    const struct shaded_material *shaded = lit->bounds[check->verdict.first.surface].shaded;
    const double limit = (double)check->limits[band];
    for (int i = 0; i < n; i++)
        out[i] = fit_leaves(&check->scene->fit, shaded, first + i, band) / limit;
    out[n] = (double)check->rests[band] / limit;
    return limit > 0;
}

/* Solves n normal equations (Gauss and Jordan). A band that leaves nothing anywhere is taken to be
 * right. */
static void solve(double rows[BANDS_PER_PASS][COLUMNS], int n, double x[BANDS_PER_PASS])
{
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            const double factor = k == i || !(rows[i][i] > 0) ? 0 : rows[k][i] / rows[i][i];
            for (int j = n; j >= i; j--)
                rows[k][j] -= factor * rows[i][j];
        }
    for (int i = 0; i < n; i++)
        x[i] = rows[i][i] > 0 ? rows[i][n] / rows[i][i] : 0;
}

/* Returns whether errors of n bands alone explain the pixel. */
static bool explain(const struct check *check, int first, int n, struct odd_bands *out)
{
    const int n_bands = check->scene->lit->plan->n_bands;
    double normal[BANDS_PER_PASS][COLUMNS] = {{0}}, row[COLUMNS], x[BANDS_PER_PASS] = {0};
    for (int band = 0; band < n_bands; band++)
        for (int i = 0; leaves(check, first, n, band, row) && i < n; i++)
            for (int j = 0; j <= n; j++)
                normal[i][j] += row[i] * row[j];
    solve(normal, n, x);
    for (int band = 0; band < n_bands; band++) {
        if (!leaves(check, first, n, band, row))
            continue;
        for (int i = 0; i < n; i++)
            row[n] -= row[i] * x[i];
        if (!(fabs(row[n]) <= (band < check->verdict.first.band ? 2 : 1)))
            return false;
    }
    *out = (struct odd_bands){first, first + n - 1, x[0]};
    return true;
}

/* Adds the sets of `size` bands of a pass that explain the pixel. */
static void add_odd(const struct check *check, int pass, int size, struct check_failure *failure)
{
    const int begin = pass * BANDS_PER_PASS, n = pass_bands(check->scene->lit->plan, begin);
    struct odd_bands odd;
    for (int first = begin; first + (size < n ? size : n) <= begin + n; first++)
        if (explain(check, first, size < n ? size : n, &odd) && failure->n_odd++ < MOST_ODD)
            failure->odd[failure->n_odd - 1] = odd;
}

/* Only pilots leave their errors in other bands, so no other pass explains the band that failed. */
void find_odd_bands(struct check *check)
{
    struct check_failure *failure = &check->verdict.first;
    const int n_passes = check->scene->lit->plan->n_passes, own = failure->band / BANDS_PER_PASS;
    for (int size = 1; size <= BANDS_PER_PASS && failure->n_odd == 0; size += BANDS_PER_PASS - 1)
        for (int pass = 0; pass < n_passes; pass++)
            if (pass == own || pilot_of(&check->scene->fit, pass * BANDS_PER_PASS) >= 0)
                add_odd(check, pass, size, failure);
    failure->n_odd = failure->n_odd > MOST_ODD ? 0 : failure->n_odd;
}
