/* SPDX-License-Identifier: MIT */
/* Colours: chromaticities, CIELAB, and three formulas for the difference of two colours. */
#include "raster/beside/colour/colour.h"

/* ---- colour spaces ---- */

void chromaticity(const double xyz[3], double out[2])
{
    const double sum = xyz[0] + xyz[1] + xyz[2];
    for (int i = 0; i < 2; i++)
        out[i] = sum != 0 ? xyz[i] / sum : 0;
}

/* The cube root of a finite x > 0 within 8 units in the last place; several times as fast as power.
 * Halley's method: each step triples the digits of the first guess, which is right within 0.2 %. */
static double cube_root(double x)
{
    static const double roots[3] = {1, 1.2599210498948732, 1.5874010519681996}; /* of 1, 2, 4 */
    int exponent;
    const double m = frexp(x, &exponent); /* from 0.5 to below 1 */
    const int third = (exponent + 3000) / 3 - 1000;
    double out = 0.493 + m * (0.698 - m * 0.1912);
    for (int i = 0; i < 2; i++) {
        const double cube = out * out * out;
        out *= (cube + 2 * m) / (2 * cube + m);
    }
    return ldexp(out * roots[exponent - 3 * third], third);
}

/* Returns the cube root of value / white; below (6/29)^3 its tangent. The white may have almost
 * none of X, Y or Z. A ratio above `most` therefore counts as `most`, so that no difference
 * overflows. */
static double compressed(double value, double white)
{
    const double most = 1e100;
    const double ratio = white != 0 ? fmax(-most, fmin(value / white, most)) : 0;
    return ratio > 216.0 / 24389 ? cube_root(ratio) : ratio * 841 / 108 + 4.0 / 29;
}

void cielab(const double xyz[3], const double white[3], double out[3])
{
    double f[3];
    for (int i = 0; i < 3; i++)
        f[i] = compressed(xyz[i], white[i]);
    out[0] = 116 * f[1] - 16;
    out[1] = 500 * (f[0] - f[1]);
    out[2] = 200 * (f[1] - f[2]);
}

/* ---- colour differences ---- */

static double square(double x)
{
    return x * x;
}

static double chroma(double a, double b)
{
    return sqrt(a * a + b * b);
}

double cie76_difference(const double a[3], const double b[3])
{
    return sqrt(square(a[0] - b[0]) + square(a[1] - b[1]) + square(a[2] - b[2]));
}

double cie94_difference(const double standard[3], const double sample[3])
{
    const double c = chroma(standard[1], standard[2]);
    const double lightness = standard[0] - sample[0];
    const double chroma_difference = c - chroma(sample[1], sample[2]);
    const double hue_squared = square(standard[1] - sample[1]) + square(standard[2] - sample[2]) -
                               square(chroma_difference);
    return sqrt(square(lightness) + square(chroma_difference / (1 + 0.045 * c)) +
                fmax(0, hue_squared) / square(1 + 0.015 * c));
}

/* Returns sqrt(c^7 / (c^7 + 25^7)), which grows from 0 to 1 around a chroma of 25. It rounds to 1
 * far below the limit of 1e40, which keeps c^7 finite. */
static double saturation(double c)
{
    const double c7 = power(fmin(c, 1e40), 7);
    return sqrt(c7 / (c7 + 6103515625.0));
}

static double cosine_of(double degrees)
{
    double sine, cosine;
    sine_cosine(degrees, &sine, &cosine);
    return cosine;
}

static double sine_of(double degrees)
{
    double sine, cosine;
    sine_cosine(degrees, &sine, &cosine);
    return sine;
}

/* A colour in CIELAB with a stretched a axis, as in CIEDE2000. Hues are in degrees, 0 to 360; a
 * grey has hue 0. */
struct hued {
    double a, b, chroma, hue;
};
static struct hued hued(double a, double b)
{
    struct hued out = {a, b, chroma(a, b), 0};
    if (out.chroma > 0) {
        const double upper = angle_of(fabs(b) / out.chroma, a / out.chroma) * (180 / PI);
        out.hue = b < 0 ? 360 - upper : upper;
    }
    return out;
}

/* Returns the turn from one hue to the other in degrees, the shorter way. Its direction follows
 * from the colours, not from the rounded hues, so that opposite hues are recognised exactly. The
 * turn is 0 if one colour is grey. */
static double turn(struct hued one, struct hued two)
{
    const double both = one.chroma * two.chroma;
    const double cross = one.a * two.b - one.b * two.a, dot = one.a * two.a + one.b * two.b;
    if (!(both > 0))
        return 0;
    const double size = angle_of(fabs(cross) / both, dot / both) * (180 / PI);
    return cross > 0 || (cross == 0 && two.hue > one.hue) ? size : -size;
}

/* Returns the mean hue, 0 to 360. If one colour is grey, it is the hue of the other. */
static double mean_hue(struct hued one, struct hued two)
{
    if (!(one.chroma * two.chroma > 0))
        return one.hue + two.hue;
    const double hue = one.hue + turn(one, two) / 2;
    return hue < 0 ? hue + 360 : hue >= 360 ? hue - 360 : hue;
}

double ciede2000_difference(const double a[3], const double b[3])
{
    const double stretch = 1.5 - 0.5 * saturation((chroma(a[1], a[2]) + chroma(b[1], b[2])) / 2);
    const struct hued one = hued(stretch * a[1], a[2]), two = hued(stretch * b[1], b[2]);
    const double lightness = (a[0] + b[0]) / 2, c = (one.chroma + two.chroma) / 2;
    const double hue = mean_hue(one, two);
    const double t = 1 - 0.17 * cosine_of(hue - 30) + 0.24 * cosine_of(2 * hue) +
                     0.32 * cosine_of(3 * hue + 6) - 0.20 * cosine_of(4 * hue - 63);
    const double from_grey = square(lightness - 50);
    const double dl = (b[0] - a[0]) / (1 + 0.015 * from_grey / sqrt(20 + from_grey));
    const double dc = (two.chroma - one.chroma) / (1 + 0.045 * c);
    const double dh =
        2 * sqrt(one.chroma * two.chroma) * sine_of(turn(one, two) / 2) / (1 + 0.015 * c * t);
    const double blue = 60 * exponential(-square((hue - 275) / 25));
    const double rotation = -2 * saturation(c) * sine_of(blue);
    const double sum = square(dl) + square(dc) + square(dh) + rotation * dc * dh;
    return sqrt(sum < 0 ? 0 : sum); /* NaN stays NaN */
}
