/* SPDX-License-Identifier: MIT */
/* Signs of determinants. Doubles decide where the result is above its rounding errors; otherwise
 * the determinant is summed up without any: as an expansion, numbers that do not overlap, in
 * ascending order (Shewchuk 1997). */
#include <math.h>

#include "raster/visibility/inside.h"

/* A determinant has 24 products of three numbers, each the sum of four doubles. */
enum { PARTS = 24 * 4 };
struct expansion {
    double part[PARTS];
    int n;
};

/* The sum of two numbers, and what its rounding took (Knuth 1969). */
static double sum_of(double a, double b, double *rest)
{
    const double sum = a + b, of_b = sum - a;
    *rest = (a - (sum - of_b)) + (b - of_b);
    return sum;
}

static void add(struct expansion *to, double number)
{
    for (int i = 0; i < to->n; i++)
        number = sum_of(number, to->part[i], &to->part[i]);
    to->part[to->n++] = number;
}

static void add_product(struct expansion *to, double a, double b, double c)
{
    const double high = a * b, low = fma(a, b, -high), first = high * c, second = low * c;
    add(to, fma(low, c, -second));
    add(to, second);
    add(to, fma(high, c, -first));
    add(to, first);
}

/* The determinant of the rows but one, times 1 or -1. */
static void add_minor(struct expansion *to, const struct homogeneous rows[4], int without)
{
    const struct vector *v[3];
    for (int i = 0, n = 0; i < 4; i++)
        if (i != without)
            v[n++] = &rows[i].at;
    for (int i = 0; i < 3; i++) {
        const struct vector *a = v[i], *b = v[(i + 1) % 3], *c = v[(i + 2) % 3];
        const double x = without % 2 == 1 ? a->x : -a->x;
        add_product(to, x, b->y, c->z);
        add_product(to, -x, c->y, b->z);
    }
}

static int exact_side(const struct homogeneous rows[4])
{
    struct expansion sum = {.n = 0};
    for (int i = 0; i < 4; i++)
        if (!rows[i].infinite)
            add_minor(&sum, rows, i);
    for (int i = sum.n - 1; i >= 0; i--)
        if (sum.part[i] != 0)
            return sum.part[i] > 0 ? 1 : -1;
    return 0;
}

/* Rows minus the first point's leave three vectors. Their determinant is off by less than eight
 * roundings of the sum of the magnitudes of its products. */
int side_of(const struct homogeneous rows[4])
{
    struct vector v[3];
    int base = 0, n = 0;
    while (base < 3 && rows[base].infinite)
        base++;
    for (int i = 0; i < 4; i++)
        if (i != base)
            v[n++] = rows[i].infinite ? rows[i].at : vector_subtract(rows[i].at, rows[base].at);
    const double xy = v[0].x * v[1].y, yx = v[0].y * v[1].x, yz = v[0].y * v[1].z,
                 zy = v[0].z * v[1].y, zx = v[0].z * v[1].x, xz = v[0].x * v[1].z;
    const double sum = (xy - yx) * v[2].z + (yz - zy) * v[2].x + (zx - xz) * v[2].y;
    const double size = (fabs(xy) + fabs(yx)) * fabs(v[2].z) +
                        (fabs(yz) + fabs(zy)) * fabs(v[2].x) + (fabs(zx) + fabs(xz)) * fabs(v[2].y);
    if (!(fabs(sum) > 16 * DOUBLE_ROUNDOFF * size))
        return exact_side(rows);
    return (sum > 0) == (base % 2 == 1) ? 1 : -1;
}
