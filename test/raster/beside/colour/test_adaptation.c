/* SPDX-License-Identifier: MIT */
/* Compares adaptations and displays with the thesis's equations worked by hand and with published
 * values. develop.py adapts by all published matrices, encodes and clips all values of a picture
 * once more, for the thesis's monitor, too, and takes whites to D65. */
#include "raster/beside/colour/colour.h"
#include "spectral.h"
#include "test.h"

static const double equal[3] = {100, 100, 100};
static const double lamp[3] = {109.85, 100, 35.58}; /* illuminant A */
static const double colour[3] = {40, 30, 10};

static void matrix_of(enum adaptation_kind kind, double luminance, const double white[3],
                      double out[3][3])
{
    const struct adaptation adaptation = {kind, luminance};
    struct error err = {0};
    CHECK(adaptation_matrix(&adaptation, white, equal, out, &err), "%s adapts to %.4g, %.4g, %.4g",
          adaptation_names[kind], white[0], white[1], white[2]);
}

static void check_columns(const double seen[3], const double expected[3], double tolerance,
                          const char *what)
{
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(seen[i], expected[i], tolerance, "%s: %c", what, "XYZ"[i]);
}

/* Checks what the colour becomes under a white. */
static void check_adapted(enum adaptation_kind kind, double luminance, const double white[3],
                          const double from[3], const double expected[3], double tolerance,
                          const char *what)
{
    double matrix[3][3], seen[3];
    matrix_of(kind, luminance, white, matrix);
    tristimulus_apply(matrix, from, seen);
    check_columns(seen, expected, tolerance, what);
}

/* Equations 18 to 20, with the unrounded matrix, for the colour 40, 30, 10 under A.
 *   white  L = 0.4002 x 109.85 + 0.7076 x 100 - 0.0808 x 35.58 = 111.847106
 *          M = -0.2263 x 109.85 + 1.1653 x 100 + 0.0457 x 35.58 = 93.296951
 *          S = 0.9182 x 35.58 = 32.669556
 *   colour L = 36.428, M = 26.364, S = 9.182; for the display's white 99.9976596, 99.9981763,
 *          99.9972827 (the thesis takes 100 for each)
 *   adapted L = 36.428 / 111.847106 x 99.9976596 = 32.5686991, M = 28.2576428, S = 28.1049136
 *   X = 1.8600666 L - 1.1294801 M + 0.2198983 S, Y = 0.3612229 L + 0.6388043 M - 0.0000071 S,
 *   Z = 1.0890873 S
 * The inverse of the thesis and its 100 give 34.84484, 29.81624, 30.60961: 3.6e-5 more. */
static void check_von_kries(void)
{
    check_adapted(ADAPTATION_VON_KRIES, 0, lamp, colour,
                  (double[]){34.8437280, 29.8154644, 30.6087058}, 1e-6,
                  "von Kries agrees with the value worked by hand");
    check_adapted(ADAPTATION_VON_KRIES, 0, lamp, colour, (double[]){34.84484, 29.81624, 30.60961},
                  40 * 3.6e-5, "von Kries agrees with the thesis's rounded inverse");
}

/* Equations 21 to 23 for the same colour.
 *   equal energy L = 102.7, M = 98.47, S = 91.82
 *   white / equal 1.0890663, 0.9474657, 0.3558000; together 2.3923320
 *   m = 3 x 1.0890663 / 2.3923320 = 1.3656962, 1.1881282, 0.4461755
 *   10^(1/3) = 2.1544347: p = (3.1544347 + m) / (3.1544347 + 1/m) = 1.1629854, 1.0867017, 0.6673104
 *   adapted, p x those of von Kries: 37.8769202, 30.7076288, 18.7547017
 * and at luminance 1: p = 1.2318508, 1.1219246, 0.5767554; 40.1197770, 31.7029445, 16.2096603. */
static void check_fairchild(void)
{
    double matrix[3][3], complete[3], seen[3], xy[2], xy_complete[2];
    check_adapted(ADAPTATION_FAIRCHILD, 10, lamp, colour,
                  (double[]){39.8940667, 33.2980437, 20.4255083}, 1e-6,
                  "Fairchild agrees with the value worked by hand");
    check_adapted(ADAPTATION_FAIRCHILD, 1, lamp, colour,
                  (double[]){42.3820902, 34.7440451, 17.6537359}, 1e-6,
                  "Fairchild adapts less in dim light");
    matrix_of(ADAPTATION_FAIRCHILD, 10, lamp, matrix);
    tristimulus_apply(matrix, lamp, seen);
    chromaticity(seen, xy);
    chromaticity(display_white, xy_complete);
    CHECK(xy[0] > xy_complete[0] + 0.01, "Fairchild's white stays yellower than D65 (x %.4f)",
          xy[0]);
    matrix_of(ADAPTATION_VON_KRIES, 0, lamp, matrix);
    tristimulus_apply(matrix, colour, complete);
    /* p differs from 1 by (m - 1/m) / 10^4, which is 1.8e-4 of S */
    check_adapted(ADAPTATION_FAIRCHILD, 1e12, lamp, colour, complete, 40 * 2e-4,
                  "Fairchild adapts completely in very bright light");
    matrix_of(ADAPTATION_VON_KRIES, 0, equal, matrix);
    tristimulus_apply(matrix, colour, complete);
    check_adapted(ADAPTATION_FAIRCHILD, 10, equal, colour, complete, 1e-12,
                  "Fairchild agrees with von Kries under equal energy");
}

static void check_refused(void)
{
    static const double bad[][3] = {{0, 0, 0}, {10, 0, 90}, {100, 20, 0}, {50, 50, -10}};
    for (int kind = ADAPTATION_VON_KRIES; kind <= ADAPTATION_CAT16; kind++)
        for (size_t i = 0; i < 4; i++) {
            const struct adaptation adaptation = {(enum adaptation_kind)kind, 10};
            struct error err = {0};
            double matrix[3][3];
            CHECK(!adaptation_matrix(&adaptation, bad[i], equal, matrix, &err) &&
                      err.status == EXIT_INPUT,
                  "%s refuses a white of %g, %g, %g", adaptation_names[adaptation.kind], bad[i][0],
                  bad[i][1], bad[i][2]);
        }
}

static void check_names(void)
{
    struct adaptation adaptation;
    struct error err = {0};
    for (int kind = ADAPTATION_NONE; kind <= ADAPTATION_CAT16; kind++)
        CHECK(adaptation_read("--adaptation", adaptation_names[(enum adaptation_kind)kind],
                              &adaptation, &err) &&
                  (int)adaptation.kind == kind && adaptation.luminance == 0,
              "%s is read", adaptation_names[(enum adaptation_kind)kind]);
    CHECK(adaptation_read("--adaptation", "fairchild:318.3", &adaptation, &err) &&
              adaptation.kind == ADAPTATION_FAIRCHILD && adaptation.luminance == 318.3,
          "its luminance is read");
}

/* ---- displays ---- */

/* W3C's CSS Color Module Level 4 gives the matrix from XYZ in full, for the chromaticities of IEC
 * 61966-2-1. */
static void check_srgb(void)
{
    static const double from_xyz[9] = {
        3.2409699419045226,  -1.537383177570094,   -0.4986107602930034,
        -0.9692436362808796, 1.8759675015077202,   0.04155505740717559,
        0.05563007969699366, -0.20397695888897652, 1.0569715142428786};
    /* 1.055 x 0.18^(1/2.4) - 0.055 and so on; the linear part ends at 0.04045. The last: tolerance.
     */
    static const double encoded[5][3] = {{0.18, 0.46135612950044164, 1e-15},
                                         {0.5, 0.7353569830524495, 1e-15},
                                         {0.21404114048223255, 0.5, 1e-15},
                                         {0.002, 0.02584, 1e-16},
                                         {0.0031308, 0.04045, 1e-7}};
    double matrix[3][3], white[3], worst = 0;
    display_matrix(DISPLAY_SRGB, matrix);
    for (int i = 0; i < 9; i++)
        worst = fmax(worst, fabs(100 * matrix[i / 3][i % 3] - from_xyz[i]));
    CHECK_NEAR(worst, 0, 1e-12, "sRGB's matrix from XYZ agrees with the published one");
    tristimulus_apply(matrix, display_white, white);
    check_columns(white, (double[]){1, 1, 1}, 1e-14, "D65 has red, green and blue 1");
    for (int i = 0; i < 5; i++)
        CHECK_NEAR(display_encode(DISPLAY_SRGB, i % 3, encoded[i][0]), encoded[i][1], encoded[i][2],
                   "sRGB encodes %g", encoded[i][0]);
    CHECK(display_largest(DISPLAY_SRGB, 0) == 1, "the largest linear value is 1");
}

int main(void)
{
    check_von_kries();
    check_fairchild();
    check_refused();
    check_names();
    check_srgb();
    return test_end();
}
