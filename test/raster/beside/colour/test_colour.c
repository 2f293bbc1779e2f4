/* SPDX-License-Identifier: MIT */
/* Compares colour spaces and differences with published values and with values worked by hand. */
#include <float.h>

#include "raster/beside/colour/colour.h"
#include "test.h"

static const double rounding = 0.5e-4 + 1e-9; /* of 4 decimals */

/* Pairs of colours that were published to test programs with; stack_viewer.py has them, too. */
static void check_sharma(void)
{
    FILE *file = fopen("test/cases/ciede2000.cases", "r");
    char line[256];
    int n = 0;
    test_need(file != NULL, "test/cases/ciede2000.cases");
    while (fgets(line, sizeof line, file)) {
        double one[3], two[3], difference;
        if (sscanf(line, "%lf %lf %lf %lf %lf %lf %lf", &one[0], &one[1], &one[2], &two[0], &two[1],
                   &two[2], &difference) != 7)
            continue;
        const double forth = ciede2000_difference(one, two);
        CHECK_NEAR(forth, difference, rounding, "CIEDE2000 agrees with published pair %d", ++n);
        CHECK_NEAR(ciede2000_difference(two, one), forth, 1e-12,
                   "the pair differs as much the other way round");
    }
    fclose(file);
    CHECK(n == 34, "there are 34 pairs");
}

static void check_limits(void)
{
    const double black[3] = {0, 0, 0}, white[3] = {100, 0, 0}, red[3] = {50, 60, 40};
    CHECK(ciede2000_difference(red, red) == 0 && ciede2000_difference(black, black) == 0 &&
              cie94_difference(red, red) == 0 && cie76_difference(red, red) == 0,
          "a colour does not differ from itself");
    /* The mean lightness is 50, where lightness counts in full. */
    CHECK_NEAR(ciede2000_difference(black, white), 100, 1e-12, "black and white differ by 100");
}

/* L* + 16 is 116 cube roots of Y / Yn. They are within 8 units in the last place; three more are
 * lost on the way, where L* is small. */
static void check_lightness(void)
{
    const double white[3] = {1, 1, 1};
    uint64_t state = 3;
    double worst = 0;
    for (int i = 0; i < 500000; i++) {
        const double y = ldexp(test_random(&state, 1, 2), i % 338 - 6), grey[3] = {y, y, y};
        double lab[3];
        cielab(grey, white, lab);
        worst = fmax(worst, fabs((lab[0] + 16) / 116 / (double)cbrtl((long double)y) - 1));
    }
    CHECK_NEAR(worst / DBL_EPSILON, 0, 11, "L* of greys follows the cube root");
}

/* Lasers and mistyped whites have an X, Y or Z near 0. */
static void check_overflow(void)
{
    const double bright[3] = {1e38, 1e38, -1e38}, grey[3] = {50, 50, 50};
    const double traces[2][3] = {{1e-300, 1e-300, 1e-300}, {90, 100, 1e-188}};
    double one[3], two[3];
    for (int i = 0; i < 2; i++) {
        cielab(bright, traces[i], one);
        cielab(grey, traces[i], two);
        const double difference = ciede2000_difference(one, two);
        CHECK(difference > 10 && isfinite(difference),
              "under a nearly black white %d colours differ by a finite %g", i, difference);
    }
}

/* c = 50 of (30, 40): S_C = 1 + 0.045 x 50 = 3.25, S_H = 1 + 0.015 x 50 = 1.75. */
static void check_older(void)
{
    const double standard[3] = {50, 30, 40};
    const double duller[3] = {50, 24, 32}, turned[3] = {50, 40, 30}, other[3] = {52, 30, 30};
    const double grey[3] = {62, 0, 0}, small[3] = {50, 3, 4};
    CHECK_NEAR(cie76_difference(small, grey), 13, 1e-13, "CIE76: the root of 12^2 + 3^2 + 4^2");
    CHECK_NEAR(cie94_difference(standard, duller), 10 / 3.25, 1e-13,
               "CIE94 compares a chroma of 40 with a standard of 50");
    CHECK_NEAR(cie94_difference(duller, standard), 10 / 2.8, 1e-13,
               "CIE94 is larger for a standard of 40");
    CHECK_NEAR(cie94_difference(standard, turned), 8.0812203564176860, 1e-12,
               "CIE94 of another hue: the root of 10^2 + 10^2 over 1.75");
    /* dL 2; C 42.426407, dC 7.573593, dC^2 57.359313; dH^2 = 100 - 57.359313 = 42.640687;
     * 4 + 57.359313 / 10.5625 + 42.640687 / 3.0625 = 23.353957 */
    CHECK_NEAR(cie94_difference(standard, other), 4.8325932, 1e-7,
               "CIE94 of another lightness, chroma and hue");
}

static const double pale[3] = {80, 100, 40}, no_blue[3] = {80, 100, 0};
static const double d65[3] = {95.047, 100, 108.883};

static const struct conversion {
    const char *what;
    double xyz[3];
    const double *white;
    double expected[3], tolerance;
} conversions[] = {
    {"white", {80, 100, 40}, pale, {100, 0, 0}, 1e-13},
    {"an eighth of white: 116 / 2 - 16", {10, 12.5, 5}, pale, {42, 0, 0}, 1e-12},
    /* roots 0.5, 0.6, 0.7: 116 x 0.6 - 16, 500 x -0.1, 200 x -0.1 */
    {"a green", {10, 21.6, 13.72}, pale, {53.6, -50, -20}, 1e-12},
    {"black", {0, 0, 0}, pale, {0, 0, 0}, 1e-13},
    /* Below (6/29)^3 the slope is 24389/27 per 1: 0.9032963 at a thousandth. */
    {"a thousandth of white", {0.08, 0.1, 0.04}, pale, {0.9032963, 0, 0}, 1e-7},
    /* 500 x 0.0077870370 for Y, and -200 x 0.0077870370 */
    {"negative Y", {0, -0.1, 0}, pale, {-0.9032963, 3.8935185, -1.5574074}, 1e-6},
    /* 500 x 841/108 x -0.01 for X, and 200 x 841/108 x 0.01 for Z */
    {"negative X and Z", {-0.8, 0, -0.4}, pale, {0, -38.9351852, 15.5740741}, 1e-7},
    {"a white without Z", {10, 12.5, 0}, no_blue, {42, 0, 200 * (0.5 - 4. / 29)}, 1e-12},
    /* The red of sRGB, (255, 0, 0), as converted by B. Lindbloom, www.brucelindbloom.com. */
    {"red", {41.24564, 21.26729, 1.93339}, d65, {53.2408, 80.0925, 67.2032}, 5e-5},
};

static void check_conversions(void)
{
    for (size_t i = 0; i < sizeof conversions / sizeof conversions[0]; i++) {
        const struct conversion *c = &conversions[i];
        double seen[3];
        cielab(c->xyz, c->white, seen);
        for (int axis = 0; axis < 3; axis++)
            CHECK_NEAR(seen[axis], c->expected[axis], c->tolerance, "%s: axis %d", c->what, axis);
    }
}

static void check_chromaticity(void)
{
    const double orange[3] = {30, 20, 50}, black[3] = {0, 0, 0};
    double xy[2];
    chromaticity(orange, xy);
    CHECK(xy[0] == 0.3 && xy[1] == 0.2, "x and y are shares of the sum");
    chromaticity(black, xy);
    CHECK(xy[0] == 0 && xy[1] == 0, "black has no x and y");
    chromaticity(display_white, xy);
    CHECK(fabs(xy[0] - 0.3127) <= 1e-15 && fabs(xy[1] - 0.3290) <= 1e-15 && display_white[1] == 100,
          "the display's white has D65's x and y, and Y = 100");
}

/* develop.py encodes whole pictures once more. */
static void check_clipped(void)
{
    uint16_t words[3];
    struct display srgb;
    struct error err = {.status = EXIT_AGREED};
    CHECK(display_read("srgb", &srgb, &err), "sRGB is known");
    CHECK(!display_store(&srgb, 16, (const double[]){-1e-9, 0.5, 1 + 1e-9}, words) &&
              words[0] == 0 && words[1] == 48192 && words[2] == 65535,
          "what rounding leaves beyond black and white is not called clipped");
    CHECK(display_store(&srgb, 16, (const double[]){-1e-5, 0.5, 1}, words) &&
              display_store(&srgb, 16, (const double[]){0, 0.5, 1 + 1e-5}, words),
          "more than that is");
}

int main(void)
{
    check_sharma();
    check_limits();
    check_lightness();
    check_overflow();
    check_older();
    check_conversions();
    check_chromaticity();
    check_clipped();
    return test_end();
}
