/* SPDX-License-Identifier: MIT */
/* Compares vectors and matrices with closed forms, exactly where the contract promises exactness.
 * brute.py has products of matrices, and cameras. */
#include <float.h>

#include "data/maths/maths.h"
#include "test.h"

static const struct vector x_axis = {1, 0, 0}, y_axis = {0, 1, 0}, z_axis = {0, 0, 1};

static bool same(struct vector a, struct vector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static struct vector vector(double x, double y, double z)
{
    struct vector v = {x, y, z};
    return v;
}

/* Returns the largest difference of two vectors' components. */
static double distance(struct vector a, struct vector b)
{
    return fmax(fabs(a.x - b.x), fmax(fabs(a.y - b.y), fabs(a.z - b.z)));
}

static void check_lengths(void)
{
    static const double scales[] = {1, 0x1p-1070, 0x1p-500, 0x1p-450, 0x1p511, 0x1p1020};
    double seen;
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        struct vector v = {2 * scales[i], -3 * scales[i], 6 * scales[i]};
        CHECK(vector_length(v) == 7 * scales[i], "2 -3 6 has length 7, times %g", scales[i]);
        CHECK(distance(vector_normalise(v), vector(2. / 7, -3. / 7, 6. / 7)) == 0,
              "its unit vector is right to the last bit, times %g", scales[i]);
    }
    CHECK(same(vector_normalise(vector(0, 0, 0)), vector(0, 0, 0)), "the zero vector stays 0");
    CHECK(vector_length(vector(0, 0, 0)) == 0, "the length of the zero vector is 0");
    CHECK(vector_length(vector(0, HUGE_VAL, 1)) == HUGE_VAL,
          "the length of an infinite vector is infinite");
    seen = vector_length(vector(0, (double)NAN, 1));
    CHECK(seen != seen, "a NaN makes the length NaN");
}

static void check_quarters(void)
{
    static const double angles[] = {0,    90,   180, 270,      360,      -90,
                                    -180, -270, 450, 36000090, -36000270};
    static const int quarters[] = {0, 1, 2, 3, 0, 3, 2, 1, 1, 1, 1};
    const struct vector turned[] = {x_axis, y_axis, {-1, 0, 0}, {0, -1, 0}};
    for (size_t i = 0; i < sizeof angles / sizeof angles[0]; i++) {
        struct matrix m = matrix_rotation(angles[i], vector(0, 0, 5));
        CHECK(same(matrix_direction(&m, x_axis), turned[quarters[i]]) &&
                  same(matrix_direction(&m, z_axis), z_axis),
              "x turned by %g about z, exactly", angles[i]);
    }
    struct matrix about_x = matrix_rotation(90, x_axis), about_y = matrix_rotation(90, y_axis);
    CHECK(same(matrix_direction(&about_x, y_axis), z_axis), "y turned by 90 about x is z");
    CHECK(same(matrix_direction(&about_y, z_axis), x_axis), "z turned by 90 about y is x");
}

/* Half a unit in the last place of 1 is 2^-53, and a component sums a few products of such values.
 */
static const double few_ulps = 8 * DBL_EPSILON;

static void check_rotations(void)
{
    const struct vector axis = {1, -2, 3}, v = {0.3, 0.7, -0.2};
    double worst = 0, longest = 0;
    for (int i = -1000; i <= 1000; i++) {
        double angle = i * 0.73, radians = remainder(angle, 360) * (3.14159265358979323846 / 180);
        struct matrix m = matrix_rotation(angle, axis), about_z = matrix_rotation(angle, z_axis);
        struct vector turned = matrix_direction(&m, v);
        struct vector expected = {cos(radians), sin(radians), 0};
        worst = fmax(worst, distance(matrix_direction(&about_z, x_axis), expected));
        longest = fmax(longest, fabs(vector_length(turned) - vector_length(v)));
        longest = fmax(longest, fabs(vector_dot(turned, axis) - vector_dot(v, axis)) / 4);
    }
    /* The radians of the expected value carry three roundings of at most pi: 1.05e-15. */
    CHECK_NEAR(worst, 0, few_ulps, "x turned about z is (cos, sin, 0)");
    CHECK_NEAR(longest, 0, few_ulps, "a rotation keeps lengths, and vectors along the axis");
}

static void check_look_at(void)
{
    struct matrix m = matrix_look_at(vector(0, 0, 0), vector(0, 0, -1), y_axis);
    CHECK(same(matrix_point(&m, vector(1, 2, -3)), vector(1, 2, -3)),
          "the default view changes no coordinate");
    m = matrix_look_at(vector(5, 0, 0), vector(0, 0, 0), vector(0, 0, 1e200));
    CHECK(same(matrix_point(&m, vector(5, 1, 2)), vector(1, 2, 0)),
          "seen from +x with z up, y is to the right");
}

/* A plane's normal stays perpendicular to the plane under any transformation. */
static void check_normals(void)
{
    static const double scales[] = {1, 1e-100, 1e100, 1e-300, 1e300};
    const struct vector a = {1, 2, 3}, b = {-2, 0.5, 1};
    const struct vector normal = vector_cross(a, b);
    struct matrix out;
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        struct matrix m =
            matrix_product(matrix_rotation(33, vector(1, 2, -1)),
                           matrix_scaling(vector(scales[i], 3 * scales[i], 0.25 * scales[i])));
        CHECK(matrix_normal(&m, &out), "a matrix scaled by %g has normals", scales[i]);
        struct vector n = vector_normalise(matrix_direction(&out, normal));
        struct vector ta = vector_normalise(matrix_direction(&m, a));
        struct vector tb = vector_normalise(matrix_direction(&m, b));
        CHECK_NEAR(fmax(fabs(vector_dot(n, ta)), fabs(vector_dot(n, tb))), 0, few_ulps,
                   "its normal is perpendicular to the plane");
        CHECK_NEAR(vector_dot(n, vector_normalise(vector_cross(ta, tb))), 1, few_ulps,
                   "its normal is on the side from which the edges run anticlockwise");
    }
    struct matrix mirror = matrix_scaling(vector(-1, 1, 1)), move = matrix_translation(x_axis);
    CHECK(matrix_normal(&mirror, &out) && same(vector_normalise(matrix_direction(&out, a)),
                                               vector_normalise(vector(-a.x, a.y, a.z))),
          "a mirror keeps outward normals outward");
    CHECK(matrix_normal(&move, &out) && same(matrix_direction(&out, a), vector_scale(a, 0.25)),
          "a translation does not turn a normal");
    struct matrix flat = matrix_scaling(vector(1, 0, 1)), none = matrix_scaling(vector(0, 0, 0));
    struct matrix endless = matrix_scaling(vector(1, HUGE_VAL, 1)),
                  undefined = matrix_scaling(vector(1, 1, (double)NAN));
    CHECK(!matrix_normal(&flat, &out) && !matrix_normal(&none, &out),
          "a flat matrix has no normals");
    CHECK(!matrix_normal(&endless, &out) && !matrix_normal(&undefined, &out),
          "an infinite or undefined matrix has no normals");
}

int main(void)
{
    check_lengths();
    check_quarters();
    check_rotations();
    check_look_at();
    check_normals();
    return test_end();
}
