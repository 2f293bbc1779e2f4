/* SPDX-License-Identifier: MIT */
/* Points, directions and matrices in double. */
#include "data/maths/maths.h"

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
    length = squared == 0 ? 1 : sqrt(squared);
    return (struct vector){a.x / length, a.y / length, a.z / length};
}

struct matrix matrix_identity(void)
{
    return (struct matrix){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
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
    return (struct matrix){{{1, 0, 0, by.x}, {0, 1, 0, by.y}, {0, 0, 1, by.z}, {0, 0, 0, 1}}};
}

struct matrix matrix_scaling(struct vector by)
{
    return (struct matrix){{{by.x, 0, 0, 0}, {0, by.y, 0, 0}, {0, 0, by.z, 0}, {0, 0, 0, 1}}};
}

struct matrix matrix_rotation(double angle_deg, struct vector axis)
{
    struct vector a = vector_normalise(axis);
    double s, c, t;
    sine_cosine(angle_deg, &s, &c);
    t = 1 - c;
    return (struct matrix){
        {{a.x * a.x * t + c, a.x * a.y * t - a.z * s, a.x * a.z * t + a.y * s, 0},
         {a.x * a.y * t + a.z * s, a.y * a.y * t + c, a.y * a.z * t - a.x * s, 0},
         {a.x * a.z * t - a.y * s, a.y * a.z * t + a.x * s, a.z * a.z * t + c, 0},
         {0, 0, 0, 1}}};
}

/* The rows are the camera's right side, its upward direction, and the direction behind it. */
struct matrix matrix_look_at(struct vector eye, struct vector look, struct vector up)
{
    struct vector z = vector_normalise(vector_subtract(eye, look));
    struct vector x = vector_normalise(vector_cross(vector_normalise(up), z));
    struct vector y = vector_cross(z, x);
    return (struct matrix){{{x.x, x.y, x.z, -vector_dot(x, eye)},
                            {y.x, y.y, y.z, -vector_dot(y, eye)},
                            {z.x, z.y, z.z, -vector_dot(z, eye)},
                            {0, 0, 0, 1}}};
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

/* Cofactors are of second and the determinant of third degree in the entries, so that those of
 * 1e-150 would underflow and of 1e150 overflow: entries are first brought below 1 by a power of
 * two, which is exact. */
bool matrix_cofactors(const struct matrix *m, struct cofactors *out)
{
    double a[3][3], largest = 0;
    *out = (struct cofactors){.exponent = 0};
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, fabs(m->row[i / 3][i % 3]));
    if (largest == 0 || isinf(largest))
        return false;
    frexp(largest, &out->exponent);
    for (int i = 0; i < 9; i++)
        a[i / 3][i % 3] = ldexp(m->row[i / 3][i % 3], -out->exponent);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            double plus = a[i1][j1] * a[i2][j2], minus = a[i1][j2] * a[i2][j1];
            out->value[i][j] = plus - minus;
            out->magnitude[i][j] = fabs(plus) + fabs(minus);
        }
    for (int j = 0; j < 3; j++)
        out->determinant += a[0][j] * out->value[0][j];
    return isfinite(out->determinant) && out->determinant != 0;
}

/* The cofactors are the inverse transpose times the determinant. Only its sign matters to
 * directions: it is taken out, so that a mirror keeps normals outward. */
bool matrix_normal(const struct matrix *m, struct matrix *out)
{
    struct cofactors cofactors;
    *out = matrix_identity();
    if (!matrix_cofactors(m, &cofactors))
        return false;
    for (int i = 0; i < 9; i++)
        out->row[i / 3][i % 3] = cofactors.determinant < 0 ? -cofactors.value[i / 3][i % 3]
                                                           : cofactors.value[i / 3][i % 3];
    return true;
}
