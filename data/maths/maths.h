/* SPDX-License-Identifier: MIT */
/* The room "maths": elementary functions, vectors, matrices. It needs nothing but the C library, so
 * that the reference rasterizer can be compiled with this room alone. */
#ifndef DATA_MATHS_MATHS_H
#define DATA_MATHS_MATHS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* A function with loops over many numbers, compiled once more for processors that hold more of them
 * in a register. Its results are the same bits: each operation is rounded by itself. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) &&       \
    defined(__OPTIMIZE__) && !defined(__OPTIMIZE_SIZE__)
#define VECTORIZED __attribute__((target_clones("avx2", "default")))
#else
#define VECTORIZED
#endif

/* Unit roundoffs: rounding to the nearest number changes a value by at most this part of it, unless
 * it underflows. Single precision holds all whole numbers up to 1 / SINGLE_ROUNDOFF. */
#define SINGLE_ROUNDOFF 0x1p-24
#define DOUBLE_ROUNDOFF 0x1p-53
/* The largest relative error of n roundings in single precision, to first order. */
static inline double roundings(double n)
{
    return n * SINGLE_ROUNDOFF;
}

/* Rounds to single precision. The number is volatile, since gcc 12.2 takes (double)(float) for
 * nothing where it converts two numbers at once. */
static inline double round_to_single(double number)
{
    const volatile float rounded = (float)number;
    return (double)rounded;
}

/* ---- elementary.c: functions that give the same bits everywhere ---- */

/* Errors are bounded in units in the last place of the exact result. Pictures depend on these
 * functions, and on no inexact function of the C library. */
#define PI 3.14159265358979323846

/* Sine and cosine of an angle in degrees. Multiples of 45 degrees are rounded correctly, others
 * within 2 units in the last place. */
void sine_cosine(double angle_deg, double *sine, double *cosine);
/* Sine and cosine of part/whole of a full turn, both from 0 to 2^32, within 1.5 units. Equal
 * fractions give equal bits; mirrored fractions differ in sign or order only. */
void sine_cosine_of_turn(int64_t part, int64_t whole, double *sine, double *cosine);
/* The angle from 0 to pi that has this cosine and this sine. The sine must not be negative. Within
 * 11 units where both are rounded correctly. */
double angle_of(double sine, double cosine);
/* e^x within 1.2 units; 1 of 0. Where e^x is no finite positive double the result is 0 (below -746)
 * or HUGE_VAL (above 710). */
double exponential(double x);
/* 1 - e^-x for x >= 0 within 2.1 units: 0 of 0, 1 above 40. */
double one_minus_decay(double x);
/* log2 x for a finite x > 0 within 0.501 units; exact for powers of two. */
double binary_logarithm(double x);
/* base^exponent for a finite base >= 0 and an exponent from 0 to 1e300, within 0.501 units for
 * exponents up to 128 and 0.51 units up to 10,000, subnormal results too. So the result is exact
 * where a double can be exact. x^0 = 1, even of 0. Above all doubles the result is HUGE_VAL. With
 * exponents from 0.01 to 10,000 the result never falls as the base grows. */
double power(double base, double exponent);

/* ---- vector.c: points, directions and matrices ---- */

struct vector {
    double x, y, z;
};
struct matrix {
    double row[4][4]; /* acts on column vectors: out[i] = sum_j row[i][j] in[j] */
};

static inline struct vector vector_add(struct vector a, struct vector b)
{
    return (struct vector){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline struct vector vector_subtract(struct vector a, struct vector b)
{
    return (struct vector){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline struct vector vector_scale(struct vector a, double factor)
{
    return (struct vector){a.x * factor, a.y * factor, a.z * factor};
}
/* The least and the greatest of each component. */
static inline struct vector vector_least(struct vector a, struct vector b)
{
    return (struct vector){a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z};
}
static inline struct vector vector_greatest(struct vector a, struct vector b)
{
    return (struct vector){a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z};
}
/* The largest magnitude of a component. */
static inline double vector_reach(struct vector a)
{
    const double x = fabs(a.x), y = fabs(a.y), z = fabs(a.z), most = x > y ? x : y;
    return most > z ? most : z;
}
static inline double vector_dot(struct vector a, struct vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline struct vector vector_cross(struct vector a, struct vector b)
{
    return (struct vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double vector_length(struct vector a);           /* without avoidable overflow or underflow */
struct vector vector_normalise(struct vector a); /* (0,0,0) stays (0,0,0) */

struct matrix matrix_identity(void);
struct matrix matrix_product(struct matrix a, struct matrix b); /* a after b */
struct matrix matrix_translation(struct vector by);
struct matrix matrix_scaling(struct vector by);
/* Right-handed, about the axis, which may have any length but 0. Exact about x, y and z at
 * multiples of 90 degrees. */
struct matrix matrix_rotation(double angle_deg, struct vector axis);
struct matrix matrix_look_at(struct vector eye, struct vector look, struct vector up);
/* Transform a point (w = 1) and a direction (w = 0). Row 3 of the matrix is ignored. */
struct vector matrix_point(const struct matrix *m, struct vector p);
struct vector matrix_direction(const struct matrix *m, struct vector d);
/* The cofactors of the upper left 3x3 of a matrix divided by 2^exponent, the determinant of that,
 * and for each cofactor the sum of the magnitudes of the two products that it is the difference of.
 */
struct cofactors {
    double value[3][3], magnitude[3][3], determinant;
    int exponent;
};
/* Returns false when m is singular: its determinant is 0 or not finite. */
bool matrix_cofactors(const struct matrix *m, struct cofactors *out);
/* The matrix that transforms normals: the inverse transpose of the upper left 3x3, up to a positive
 * factor, so that a mirror keeps normals outward. Returns false when m is singular. */
bool matrix_normal(const struct matrix *m, struct matrix *out);

/* A corner of a triangle. */
struct vertex {
    struct vector position, normal; /* normal of unit length, outward */
    double s, t;                    /* texture coordinates */
};

/* The least and the greatest of three numbers. */
static inline double least_of(const double v[3])
{
    const double first = v[0] < v[1] ? v[0] : v[1];
    return first < v[2] ? first : v[2];
}
static inline double most_of(const double v[3])
{
    const double first = v[0] > v[1] ? v[0] : v[1];
    return first > v[2] ? first : v[2];
}

#endif
