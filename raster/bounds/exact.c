/* SPDX-License-Identifier: MIT */
/* Where single precision makes no error. Numbers that are all multiples of one power of two q, and
 * whose magnitudes add up to at most 2^24 q, keep within 24 bits in every partial sum, so that
 * neither the order of additions nor fused multiply-add matters. */
#include <float.h>
#include <math.h>

#include "raster/bounds/inside.h"

/* The largest power of two that x, not 0, is a multiple of. */
static double lowest_bit(double x)
{
    int exponent;
    uint64_t digits = (uint64_t)ldexp(fabs(frexp(x, &exponent)), DBL_MANT_DIG);
    return ldexp((double)(digits & (~digits + 1)), exponent - DBL_MANT_DIG);
}

bool exact_sum(const double *terms, int n)
{
    double sum = 0, unit = HUGE_VAL;
    for (int i = 0; i < n; i++) {
        sum += fabs(terms[i]);
        if (terms[i] != 0)
            unit = fmin(unit, lowest_bit(terms[i]));
    }
    return sum == 0 || (sum <= unit / SINGLE_ROUNDOFF && unit >= (double)FLT_MIN);
}

bool exact_row(const double row[4], const double v[4])
{
    double terms[4];
    for (int i = 0; i < 4; i++) {
        terms[i] = row[i] * v[i];
        if (round_to_single(row[i]) != row[i] || round_to_single(v[i]) != v[i])
            return false;
    }
    return exact_sum(terms, 4);
}

bool exact_product(const struct matrix *a, const struct matrix *b)
{
    for (int j = 0; j < 4; j++) {
        double column[4] = {b->row[0][j], b->row[1][j], b->row[2][j], b->row[3][j]};
        for (int i = 0; i < 4; i++)
            if (!exact_row(a->row[i], column))
                return false;
    }
    return true;
}
