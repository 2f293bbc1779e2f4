/* SPDX-License-Identifier: MIT */
/* Points, directions and matrices in double. Only +, -, *, / and sqrt, which IEEE 754 rounds alike
 * everywhere: the C libraries' sin and cos differ in their last bit, which pictures would show. */
#include "spectral.h"

#include <math.h>

struct vector vector_add(struct vector a, struct vector b)
{
    struct vector sum = {a.x + b.x, a.y + b.y, a.z + b.z};
    return sum;
}

struct vector vector_subtract(struct vector a, struct vector b)
{
    struct vector difference = {a.x - b.x, a.y - b.y, a.z - b.z};
    return difference;
}

struct vector vector_scale(struct vector a, double factor)
{
    struct vector scaled = {a.x * factor, a.y * factor, a.z * factor};
    return scaled;
}

double vector_dot(struct vector a, struct vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

struct vector vector_cross(struct vector a, struct vector b)
{
    struct vector product = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return product;
}

/* The vector and its squared length, times a power of two (and its square) where the square of the
 * vector itself would overflow or lose bits. The power of two is exact: it changes no rounding.
 * Squares below 2^-1022 lose bits; beside a sum above 2^-900 they are under its last bit. */
static struct vector rescale(struct vector a, double *squared, int *exponent)
{
    double largest = fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
    *exponent = 0;
    *squared = vector_dot(a, a);
    if ((*squared >= 0x1p-900 && isfinite(*squared)) || largest == 0 || isinf(largest))
        return a;
    frexp(largest, exponent);
    a.x = ldexp(a.x, -*exponent);
    a.y = ldexp(a.y, -*exponent);
    a.z = ldexp(a.z, -*exponent);
    *squared = vector_dot(a, a);
    return a;
}

double vector_length(struct vector a)
{
    double squared;
    int exponent;
    rescale(a, &squared, &exponent);
    return ldexp(sqrt(squared), exponent);
}

struct vector vector_normalise(struct vector a)
{
    double squared, length;
    int exponent;
    a = rescale(a, &squared, &exponent);
    if (squared == 0)
        return a;
    length = sqrt(squared);
    a.x /= length;
    a.y /= length;
    a.z /= length;
    return a;
}

struct matrix matrix_identity(void)
{
    struct matrix identity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    return identity;
}

struct matrix matrix_product(struct matrix a, struct matrix b)
{
    struct matrix product;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            product.row[i][j] = a.row[i][0] * b.row[0][j] + a.row[i][1] * b.row[1][j] +
                                a.row[i][2] * b.row[2][j] + a.row[i][3] * b.row[3][j];
    return product;
}

struct matrix matrix_translation(struct vector by)
{
    struct matrix m = {{{1, 0, 0, by.x}, {0, 1, 0, by.y}, {0, 0, 1, by.z}, {0, 0, 0, 1}}};
    return m;
}

struct matrix matrix_scaling(struct vector by)
{
    struct matrix m = {{{by.x, 0, 0, 0}, {0, by.y, 0, 0}, {0, 0, by.z, 0}, {0, 0, 0, 1}}};
    return m;
}

/* Sine and cosine of an angle of at most 45 degrees by their series. The first term left out is
 * (pi/4)^19 / 19! < 1e-19 of the sine and (pi/4)^20 / 20! < 1e-20 of the cosine: below the last bit
 * (1.1e-16). */
static void sine_cosine(double angle_deg, double *sine, double *cosine)
{
    double x = angle_deg * (3.14159265358979323846 / 180), x2 = x * x, s = 1, c = 1;
    for (int k = 18; k > 0; k -= 2) {
        c = 1 - c * x2 / (k * (k - 1));
        if (k < 18)
            s = 1 - s * x2 / (k * (k + 1));
    }
    *sine = s * x;
    *cosine = c;
}

struct matrix matrix_rotation(double angle_deg, struct vector axis)
{
    struct vector a = vector_normalise(axis);
    struct matrix m = matrix_identity();
    int quarters;
    double sine, cosine, s, c, t;
    /* Exact, in degrees: no multiple of 90 meets a rounded pi. */
    sine_cosine(remquo(angle_deg, 90, &quarters), &s, &c);
    quarters &= 3; /* remquo gives at least the low three bits of the quotient, with its sign */
    sine = quarters == 0 ? s : quarters == 1 ? c : quarters == 2 ? -s : -c;
    cosine = quarters == 0 ? c : quarters == 1 ? -s : quarters == 2 ? -c : s;
    t = 1 - cosine;
    m.row[0][0] = a.x * a.x * t + cosine;
    m.row[0][1] = a.x * a.y * t - a.z * sine;
    m.row[0][2] = a.x * a.z * t + a.y * sine;
    m.row[1][0] = a.x * a.y * t + a.z * sine;
    m.row[1][1] = a.y * a.y * t + cosine;
    m.row[1][2] = a.y * a.z * t - a.x * sine;
    m.row[2][0] = a.x * a.z * t - a.y * sine;
    m.row[2][1] = a.y * a.z * t + a.x * sine;
    m.row[2][2] = a.z * a.z * t + cosine;
    return m;
}

static void set_row(struct matrix *m, int row, struct vector direction, struct vector eye)
{
    m->row[row][0] = direction.x;
    m->row[row][1] = direction.y;
    m->row[row][2] = direction.z;
    m->row[row][3] = -vector_dot(direction, eye);
}

/* The rows are the camera's right side, its upward direction, and the direction behind it. */
struct matrix matrix_look_at(struct vector eye, struct vector look, struct vector up)
{
    struct matrix m = matrix_identity();
    struct vector back = vector_normalise(vector_subtract(eye, look));
    struct vector side = vector_normalise(vector_cross(vector_normalise(up), back));
    set_row(&m, 0, side, eye);
    set_row(&m, 1, vector_cross(back, side), eye);
    set_row(&m, 2, back, eye);
    return m;
}

struct vector matrix_point(const struct matrix *m, struct vector p)
{
    struct vector out = matrix_direction(m, p);
    out.x += m->row[0][3];
    out.y += m->row[1][3];
    out.z += m->row[2][3];
    return out;
}

struct vector matrix_direction(const struct matrix *m, struct vector d)
{
    struct vector out;
    out.x = m->row[0][0] * d.x + m->row[0][1] * d.y + m->row[0][2] * d.z;
    out.y = m->row[1][0] * d.x + m->row[1][1] * d.y + m->row[1][2] * d.z;
    out.z = m->row[2][0] * d.x + m->row[2][1] * d.y + m->row[2][2] * d.z;
    return out;
}

/* The cofactors are the inverse transpose times the determinant. Its size plays no part in a
 * direction, so that its sign is all that is taken out of them (a mirror keeps normals outward). They are of second and the determinant
 * of third degree in the entries: a matrix scaled by 1e-150 would underflow, one by 1e150 overflow,
 * so that the entries are first brought below 1 by a power of two, which is exact. */
bool matrix_normal(const struct matrix *m, struct matrix *out)
{
    double a[3][3], largest = 0, determinant;
    int exponent;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            largest = fmax(largest, fabs(m->row[i][j]));
    *out = matrix_identity();
    if (largest == 0 || isinf(largest))
        return false;
    frexp(largest, &exponent);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            a[i][j] = ldexp(m->row[i][j], -exponent);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            out->row[i][j] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
        }
    determinant = a[0][0] * out->row[0][0] + a[0][1] * out->row[0][1] + a[0][2] * out->row[0][2];
    for (int i = 0; i < 3 && determinant < 0; i++)
        for (int j = 0; j < 3; j++)
            out->row[i][j] = -out->row[i][j];
    return isfinite(determinant) && determinant != 0;
}
