/* SPDX-License-Identifier: MIT */
/* Elementary functions. C libraries differ in their last bit, which pictures would show. Here they
 * are made of +, -, *, / and sqrt, which IEEE 754 rounds alike everywhere. Code that computes a
 * picture calls only those functions of the C library that are exact or correctly rounded, and that
 * all C libraries and emulated processors have right: sqrt, fabs, fmin, fmax, floor, ceil, frexp,
 * ldexp, fma, fmod and nearbyint. test/program/house.py finds calls of others, and
 * test/data/maths/test_elementary.c tests these. remquo is not among them: under qemu glibc's code
 * for i386 has no quotient.
 * Error bounds count units in the last place of the result. With u = DOUBLE_ROUNDOFF, a relative
 * error e is e / u units at most. */
#include <float.h>

#include "data/maths/maths.h"

#if FLT_EVAL_METHOD != 0
#error "sums wider than double change pictures (on 32-bit x86: -mfpmath=sse -msse2)"
#endif
#if FLT_RADIX != 2 || FLT_MANT_DIG != 24 || DBL_MANT_DIG != 53 || DBL_MAX_EXP != 1024 ||           \
    DBL_MIN_EXP != -1021
#error "float and double must be binary32 and binary64 of IEEE 754"
#endif
#ifdef __FAST_MATH__
#error "-ffast-math changes pictures"
#endif

/* ---- logarithm and power ---- */

/* A number as the sum of two. The head has 26 bits, so that the product of two heads, or of a head
 * and a number of 27 bits, is exact. */
struct split {
    double head, tail;
};

/* x rounded to 26 bits (Veltkamp 1968); x minus that is exact. */
static double head_of(double x)
{
    const double wide = 0x8000001p0 * x; /* 2^27 + 1 */
    return wide - (wide - x);
}

/* 2^(i/32): a head of 27 bits, and the rest to 2^-81. */
enum { STEPS = 32 };
static const struct split root[STEPS + 1] = {
    {0x1p+0, 0x0p+0},
    {0x1.059b0d4p+0, -0x1.d4f5178a30757p-29},
    {0x1.0b5586cp+0, 0x1.f3121ec531725p-29},
    {0x1.11301dp+0, 0x1.25b50a4ebbf1bp-32},
    {0x1.172b83cp+0, 0x1.f545eb737df23p-30},
    {0x1.1d4873p+0, 0x1.68b9aa7805b8p-28},
    {0x1.2387a7p+0, -0x1.8a9dc7993e052p-28},
    {0x1.29e9df4p+0, 0x1.1fdee12c25d16p-28},
    {0x1.306fe0cp+0, -0x1.ce48ead2172a6p-28},
    {0x1.371a738p+0, -0x1.8aac6ab1d756p-29},
    {0x1.3dea64cp+0, 0x1.2342235b41224p-32},
    {0x1.44e086p+0, 0x1.8624b40c4dbdp-30},
    {0x1.4bfdad4p+0, 0x1.362a271d4397bp-28},
    {0x1.5342b58p+0, -0x1.62b07e20f57c4p-28},
    {0x1.5ab07dcp+0, 0x1.48542958c9301p-28},
    {0x1.6247ebp+0, 0x1.d2ac258f87d03p-31},
    {0x1.6a09e68p+0, -0x1.80c4336f74d05p-28},
    {0x1.71f75e8p+0, 0x1.d8bee7ba46e1ep-29},
    {0x1.7a11474p+0, -0x1.4fe79282aefdcp-32},
    {0x1.8258998p+0, 0x1.4cce128acf88bp-28},
    {0x1.8ace544p+0, -0x1.d55f24a4583aap-28},
    {0x1.93737bp+0, 0x1.9b8bc9e8a0388p-29},
    {0x1.9c49184p+0, -0x1.5c0f6fe383b95p-28},
    {0x1.a5503b4p+0, -0x1.c1daa374bdbb7p-28},
    {0x1.ae89f98p+0, 0x1.5ad3ad5e8734dp-28},
    {0x1.b7f76f4p+0, -0x1.04a1b915584f8p-28},
    {0x1.c199bdcp+0, 0x1.85529c2220cb1p-28},
    {0x1.cb720dcp+0, 0x1.df20d22a0797ap-29},
    {0x1.d5818dcp+0, 0x1.f7490e4bb40b6p-29},
    {0x1.dfc9734p+0, -0x1.08c9428d2e6a8p-29},
    {0x1.ea4afa4p+0, -0x1.5b6f267a708c6p-28},
    {0x1.f50765cp+0, -0x1.23757f3160f69p-29},
    {0x1p+1, 0x0p+0},
};

/* log2 x with a relative error below 2^-66. x = 2^exponent m, and m is near the root r of a step,
 * so with s = (m - r) / (m + r), log2 x = exponent + step / 32 + 2 / ln 2 (s + s^3/3 + s^5/5 ...).
 * The cubic is log2 m within 0.0013, so that |log2(m / r)| < 0.0170 and |s| < 0.00587; the first
 * term left out, s^11/11, is below 2^-77 s. The terms after s are below 1.95e-7; rounded where they
 * are made and added, they are off by 6.4 u of that, 1.4e-22. s itself is in two parts. All other
 * errors are below 2^-78 (1 + |log2 x|). */
static struct split logarithm(double x)
{
    /* 2 / ln 2: 27 bits of it and the rest; then over 3, 5, 7 and 9 */
    const double c = 0x1.7154764p+1, c_rest = 0x1.2b82fe1777d1p-27;
    const double c3 = 0.96179669392597556, c5 = 0.57707801635558533, c7 = 0.41219858311113238,
                 c9 = 0.32059889797532519;
    int exponent;
    const double m = 2 * frexp(x, &exponent), z = m - 1;
    const int step = (int)(STEPS * z * (1.42 - z * (0.57 - 0.15 * z)) + 0.5);
    const struct split r = root[step];
    /* The sum m + r is head + tail. Differences of heads, and of heads and m, are exact. */
    const double sum = m + r.head + r.tail, inverse = 1 / sum, from = m - r.head;
    const double head = head_of(sum), tail = m - (head - r.head) + r.tail;
    const double s = head_of((from - r.tail) * inverse);
    const double s_rest = ((from - s * head) - s * tail - r.tail) * inverse;
    const double all = s + s_rest, square = all * all;
    const double series = c3 + square * (c5 + square * (c7 + square * c9));
    /* The first sum is exact with its error, since |whole| is 0 or the larger one. */
    const double whole = exponent - 1 + step / (double)STEPS, first = whole + s * c;
    const double rest =
        s * c - (first - whole) + (s * c_rest + s_rest * (c + c_rest) + all * square * series);
    const double log_head = head_of(first + rest);
    return (struct split){log_head, first - log_head + rest};
}

double binary_logarithm(double x)
{
    const struct split log = logarithm(x);
    return log.head + log.tail;
}

/* (head + tail) 2^exponent, rounded once, 0.98 < head < 2. A subnormal one is rounded where a
 * number of the size of `large` is. */
static double scale(double head, double tail, int exponent)
{
    const double plain = ldexp(head + tail, exponent);
    if (plain >= DBL_MIN)
        return plain;
    const double large = ldexp(1, DBL_MIN_EXP - 1 - exponent), sum = large + head;
    return ldexp(sum + (head - (sum - large) + tail) - large, exponent);
}

/* 2^(head + tail), |tail| below 2^-24 |head|. With the nearest step taken out it is the root times
 * e^p, |p| < 0.01084; e^p - 1 = e + e_rest. The first term left out, p^8/8!, is below 2^-67; the
 * terms after p are below 2^-14 and carry 5 u of that, and twice that size is rounded twice when
 * it is added: 2^-63.9 in total. */
static double power_of_two(double head, double tail)
{
    /* ln 2: 27 bits of it and the rest */
    const double ln2 = 0x1.62e43p-1, ln2_rest = -0x1.05c610ca86c39p-29;
    const int lowest = -1100;
    const int steps = (int)(STEPS * (head - lowest) + 0.5); /* not negative: it cuts off */
    const struct split r = root[steps % STEPS];
    const double from = head - (steps / (double)STEPS + lowest); /* exact */
    const double f = head_of(from + tail), f_rest = from - f + tail;
    const double exact = f * ln2, small = f * ln2_rest + f_rest * (ln2 + ln2_rest);
    const double p = exact + small, square = p * p;
    const double series =
        1. / 2 + p * (1. / 6) +
        square * (1. / 24 + p * (1. / 120) + square * (1. / 720 + p * (1. / 5040)));
    const double e = head_of(p), e_rest = exact - e + (small + square * series);
    const double sum = r.head + r.head * e, rounding = r.head * e - (sum - r.head);
    return scale(sum, rounding + (r.head * e_rest + r.tail * (1 + (e + e_rest))),
                 steps / STEPS + lowest);
}

/* The exponent multiplies the logarithm's error: an exponent of 10,000 makes 0.009 units of it,
 * and one of 128 makes 0.0002. All other errors are below 0.0006. */
double power(double base, double exponent)
{
    if (base == 0 || exponent == 0)
        return exponent == 0;
    const struct split log = logarithm(base);
    const double head = head_of(exponent), tail = exponent - head;
    const double octaves = head * log.head;
    if (octaves < DBL_MIN_EXP - DBL_MANT_DIG - 1)
        return 0;
    if (octaves > DBL_MAX_EXP + 1)
        return HUGE_VAL;
    return power_of_two(octaves, head * log.tail + tail * (log.head + log.tail));
}

/* ---- exponential ---- */

/* e^x as (1 + fraction) 2^power; returns the fraction, e^r - 1 with |r| <= ln(2) / 2. ln 2 comes in
 * two parts: the first has 32 zeros at its end, so that its product with a power of at most 12 bits
 * is exact. The first term of the series left out, r^15 / 15! < 1e-19, is below its last bit. For
 * r < 0 the fraction is off by at most 0.7 u, for r > 0 by 1.1 u: half from the sum, and a quarter
 * each from r and the product. */
static double reduce(double x, int *power)
{
    const double ln2_high = 0x1.62e42feep-1, ln2_low = 0x1.a39ef35793c76p-33;
    const double n = floor(x / (ln2_high + ln2_low) + 0.5);
    const double r = (x - n * ln2_high) - n * ln2_low;
    double sum = 1;
    for (int k = 14; k > 1; k--)
        sum = 1 + r * sum / k;
    *power = (int)n;
    return r * sum;
}

/* Outside these bounds e^x is no finite positive double. 1 + fraction is rounded to a unit of u
 * below 1, and of 2 u above. */
double exponential(double x)
{
    int power;
    double fraction;
    if (x < -746 || x > 710)
        return x < 0 ? 0 : HUGE_VAL;
    fraction = reduce(x, &power);
    return ldexp(1 + fraction, power);
}

/* 1 - e^-x for x >= 0, without cancellation near 0. From 40 on, e^-x < 2^-54 does not show. The
 * error shows most where x is little above ln(2) / 2: 1 + fraction is off by 2.1 u, half of that is
 * left, and the difference, 0.29, has units of u / 2. */
double one_minus_decay(double x)
{
    int power;
    double fraction;
    if (x > 40)
        return 1;
    fraction = reduce(-x, &power);
    return power == 0 ? -fraction : 1 - ldexp(1 + fraction, power);
}

/* ---- sine, cosine and angle ---- */

/* Sine and cosine of (head + tail) 45 degrees, 0 <= head <= 1 with 31 bits, tail below its last
 * one. Series of the angle x + rest: the first term left out is below x^18/18! < 2^-58, and x +
 * rest carries the angle to 2^-74, so that only the rounding of the last additions remains:
 * below 1.5 units in the last place, and 2 where head is 0 and the angle is a rounded tail. */
static void series(double head, double tail, double *sine, double *cosine)
{
    /* pi/4 in two pieces; the first has 21 bits, so that its product with head is exact. */
    const double quarter_pi = 0x1.921fbp-1, quarter_pi_rest = 0x1.5110b4611a626p-23;
    const double exact = quarter_pi * head;
    const double small = quarter_pi_rest * head + (quarter_pi + quarter_pi_rest) * tail;
    const double x = exact + small, rest = small - (x - exact), square = x * x;
    double even = 1, odd = 1;

    for (int k = 15; k >= 3; k -= 2) {
        even = 1 - square / (k * (k + 1)) * even;
        odd = 1 - square / ((k + 1) * (k + 2)) * odd;
    }
    *cosine = 1 - (square / 2 * even + rest * x);
    *sine = x + (rest * *cosine - x * square / 6 * odd);
}

/* Turns by so many quarters after mirroring. 0 - 0 is +0: no negative zeros. */
static void place(bool mirrored, int quarters, double *sine, double *cosine)
{
    const double s = mirrored ? 0 - *sine : *sine, c = *cosine;
    const double turned[4] = {c, 0 - s, 0 - c, s};

    *cosine = turned[quarters & 3];
    *sine = turned[(quarters + 3) & 3];
}

void sine_cosine_of_turn(int64_t part, int64_t whole, double *sine, double *cosine)
{
    /* From the nearest quarter of a turn, in units of 45 degrees / whole. */
    const int64_t eighths = 8 * (part % whole), quarters = (eighths / whole + 1) / 2;
    const int64_t off = eighths - 2 * quarters * whole;
    const uint64_t size = (uint64_t)(off < 0 ? -off : off) << 31, unit = (uint64_t)whole;

    series((double)(size / unit) * 0x1p-31, (double)(size % unit) / (double)whole * 0x1p-31, sine,
           cosine);
    place(off < 0, (int)quarters, sine, cosine);
}

void sine_cosine(double angle_deg, double *sine, double *cosine)
{
    int quarters = 0;
    double off = fmod(angle_deg, 360); /* exact, and so are the sums */
    for (; off > 45 || (off == 45 && quarters % 2 != 0); quarters++)
        off -= 90;
    for (; off < -45 || (off == -45 && quarters % 2 != 0); quarters--)
        off += 90;
    const double size = fabs(off);
    const double head = floor(size / 45 * 0x1p31) * 0x1p-31;

    series(head, (size - 45 * head) / 45, sine, cosine); /* the difference is exact, too */
    place(off < 0, quarters, sine, cosine);
}

/* Halved three times by tan(a/2) = tan a / (1 + sqrt(1 + tan^2)), tan is below 0.2, and the first
 * term of the series left out below 0.2^22/23 < 2^-53. The first tangent is off by 3.5 u, the given
 * values' roundings included, the other two by 2.9 u more each, the series by 0.6 u and the last
 * product by 1 u. */
double angle_of(double sine, double cosine)
{
    const double half = sine / (1 + fabs(cosine));
    const double quarter = half / (1 + sqrt(1 + half * half));
    const double eighth = quarter / (1 + sqrt(1 + quarter * quarter)), square = eighth * eighth;
    double series = 1.0 / 21;

    for (int k = 19; k > 0; k -= 2)
        series = 1.0 / k - square * series;
    const double angle = 8 * eighth * series;
    return cosine < 0 ? PI - angle : angle;
}
