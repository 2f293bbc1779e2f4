/* SPDX-License-Identifier: MIT */
/* Compares colour spaces and differences with published values and with values worked by hand. */
#include "raster/beside/colour/colour.h"
#include "test.h"

/* G. Sharma, W. Wu, E. N. Dalal, The CIEDE2000 color-difference formula: implementation notes,
 * supplementary test data, and mathematical observations, Color Res. Appl. 30, 21-30 (2005), table
 * 1: facts, published to test programs with. Pairs 9 to 15 lie about opposite hues. */
static const struct pair {
    double one[3], two[3], difference;
} sharma[34] = {
    {{50, 2.6772, -79.7751}, {50, 0, -82.7485}, 2.0425},
    {{50, 3.1571, -77.2803}, {50, 0, -82.7485}, 2.8615},
    {{50, 2.8361, -74.0200}, {50, 0, -82.7485}, 3.4412},
    {{50, -1.3802, -84.2814}, {50, 0, -82.7485}, 1.0000},
    {{50, -1.1848, -84.8006}, {50, 0, -82.7485}, 1.0000},
    {{50, -0.9009, -85.5211}, {50, 0, -82.7485}, 1.0000},
    {{50, 0, 0}, {50, -1, 2}, 2.3669},
    {{50, -1, 2}, {50, 0, 0}, 2.3669},
    {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0009}, 7.1792},
    {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0010}, 7.1792},
    {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0011}, 7.2195},
    {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0012}, 7.2195},
    {{50, -0.0010, 2.4900}, {50, 0.0009, -2.4900}, 4.8045},
    {{50, -0.0010, 2.4900}, {50, 0.0010, -2.4900}, 4.8045},
    {{50, -0.0010, 2.4900}, {50, 0.0011, -2.4900}, 4.7461},
    {{50, 2.5, 0}, {50, 0, -2.5}, 4.3065},
    {{50, 2.5, 0}, {73, 25, -18}, 27.1492},
    {{50, 2.5, 0}, {61, -5, 29}, 22.8977},
    {{50, 2.5, 0}, {56, -27, -3}, 31.9030},
    {{50, 2.5, 0}, {58, 24, 15}, 19.4535},
    {{50, 2.5, 0}, {50, 3.1736, 0.5854}, 1.0000},
    {{50, 2.5, 0}, {50, 3.2972, 0}, 1.0000},
    {{50, 2.5, 0}, {50, 1.8634, 0.5757}, 1.0000},
    {{50, 2.5, 0}, {50, 3.2592, 0.3350}, 1.0000},
    {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
    {{63.0109, -31.0961, -5.8663}, {62.8187, -29.7946, -4.0864}, 1.2630},
    {{61.2901, 3.7196, -5.3901}, {61.4292, 2.2480, -4.9620}, 1.8731},
    {{35.0831, -44.1164, 3.7933}, {35.0232, -40.0716, 1.5901}, 1.8645},
    {{22.7233, 20.0904, -46.6940}, {23.0331, 14.9730, -42.5619}, 2.0373},
    {{36.4612, 47.8580, 18.3852}, {36.2715, 50.5065, 21.2231}, 1.4146},
    {{90.8027, -2.0831, 1.4410}, {91.1528, -1.6435, 0.0447}, 1.4441},
    {{90.9257, -0.5406, -0.9208}, {88.6381, -0.8985, -0.7239}, 1.5381},
    {{6.7747, -0.2908, -2.4247}, {5.8714, -0.0985, -2.2286}, 0.6377},
    {{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082},
};
static const double rounding = 0.5e-4 + 1e-9; /* of 4 decimals */

static void check_sharma(void)
{
    for (int i = 0; i < 34; i++) {
        const double forth = ciede2000_difference(sharma[i].one, sharma[i].two);
        CHECK_NEAR(forth, sharma[i].difference, rounding, "CIEDE2000 agrees with published pair %d",
                   i + 1);
        CHECK_NEAR(ciede2000_difference(sharma[i].two, sharma[i].one), forth, 1e-12,
                   "the pair differs as much the other way round");
    }
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

static void check_product(void)
{
    double m[3][3] = {{2, 1, 0}, {0, 1, 4}, {1, 0, 3}}, swap[3][3] = {{0, 1}, {1}, {0, 0, 1}};
    double product[3][3];
    tristimulus_product(swap, m, product);
    CHECK(product[0][2] == 4 && product[1][0] == 2 && product[2][2] == 3,
          "the second factor of a product of matrices acts first");
}

/* IEC 61966-2-1: 12.92 L up to 0.0031308, beyond that 1.055 L^(1/2.4) - 0.055. */
static void check_srgb(void)
{
    static const double linear[] = {0, 0.002, 0.0031, 0.0032, 0.01, 0.5, 1, 2};
    for (size_t i = 0; i < sizeof linear / sizeof *linear; i++) {
        const double l = fmin(linear[i], 1),
                     expected = l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055;
        CHECK_NEAR(display_encode(DISPLAY_SRGB, 1, linear[i]), expected, 1e-12,
                   "sRGB shows %g as the standard says", linear[i]);
    }
    uint16_t words[3];
    CHECK(!display_store(DISPLAY_SRGB, 16, (const double[]){-1e-9, 0.5, 1 + 1e-9}, words) &&
              words[0] == 0 && words[1] == 48192 && words[2] == 65535,
          "what rounding leaves beyond black and white is not called clipped");
    CHECK(display_store(DISPLAY_SRGB, 16, (const double[]){-1e-5, 0.5, 1}, words) &&
              display_store(DISPLAY_SRGB, 16, (const double[]){0, 0.5, 1 + 1e-5}, words),
          "more than that is");
}

int main(void)
{
    check_sharma();
    check_limits();
    check_overflow();
    check_older();
    check_conversions();
    check_chromaticity();
    check_product();
    check_srgb();
    return test_end();
}
