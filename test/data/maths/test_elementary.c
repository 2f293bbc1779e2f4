/* SPDX-License-Identifier: MIT */
/* Compares the program's functions with the C library's in long double. The library is right to a
 * unit in its own last place, 2^-11 units here, which suffices to check a bound of 0.501. */
#include <float.h>

#include "data/maths/maths.h"
#include "test.h"

/* Returns the larger of `worst` and |seen - exact|, in units in the last place; NaN counts as
 * larger. */
static double worse(double worst, double seen, long double exact)
{
    int exponent;
    frexpl(exact, &exponent);
    if (exponent < DBL_MIN_EXP)
        exponent = DBL_MIN_EXP;
    double units = (double)ldexpl(fabsl((long double)seen - exact), DBL_MANT_DIG - exponent);
    return worst != worst || units <= worst ? worst : units;
}

static double worse_power(double worst, double base, double exponent)
{
    return worse(worst, power(base, exponent), powl((long double)base, (long double)exponent));
}

/* GNU MPFR 4.2.0 rounded these correctly: mpfr_pow, then mpfr_subnormalize. */
static const struct {
    double base, exponent, power;
} rounded[] = {
    {0x1p-1, 0x1.999999999999ap-4, 0x1.ddb680117ab12p-1},
    {0x1.6666666666666p-1, 0x1.199999999999ap+1, 0x1.d336ba60b0d77p-2},
    {0x1.999999999999ap-4, 128, 0x1.bba08cf8c97d4p-426},
    {0x1.fae147ae147aep-1, 10000, 0x1.00c3c3333189fp-145},
    {0x1.fffffffffffffp-1, 128, 0x1.fffffffffff8p-1},
    {0x1.0000000000001p+0, 10000, 0x1.000000000271p+0},
    {0x1.00000bbe7a23bp+0, 128, 0x1.0005df4e2d05p+0},
    {1.5, 1.5, 0x1.d64d51e0db1c6p+0},
    {0x1.3333333333333p-2, 0x1.b7cdfd9d7bdbbp-34, 0x1.fffffffef73e6p-1},
    {0x1.56e1fc2f8f359p-997, 0x1.47ae147ae147bp-7, 0x1.0624dd2f1a9fbp-10},
    {0x0.0000000000001p-1022, 0x1.3333333333333p-2, 0x1.bdb8cdadbe161p-323},
    {0x1.e666666666666p+0, 1000, 0x1.ffcb2f699313dp+925},
    {0x1.89374bc6a7efap-9, 127.5, 0x0.000000000002cp-1022},
    {0x1.f75104d551d69p-16, 70, 0x0.00000004d4ecbp-1022},
    {0x1p-1, 1073.25, 0x0.0000000000002p-1022},
    {0x1p-2, 0x1.0ca6666666666p+9, 0x0.0000000000001p-1022},
};

static void check_rounded(void)
{
    for (size_t i = 0; i < sizeof rounded / sizeof rounded[0]; i++) {
        const double seen = power(rounded[i].base, rounded[i].exponent);
        if (!CHECK(seen == rounded[i].power, "%.17g^%.17g is rounded correctly", rounded[i].base,
                   rounded[i].exponent))
            printf("# saw %a, expected %a\n", seen, rounded[i].power);
    }
}

static void check_ends(void)
{
    static const double bases[] = {0, 0x1p-1074, DBL_MIN, 0.3, 1 - DBL_EPSILON / 2, 1, 1.7, 2};
    static const double exponents[] = {0x1p-1074, 1e-20, 0.5, 1, 2.2, 128, 1e4, 1e300};
    bool none = true, once = true, zero = true, one = true;
    for (size_t i = 0; i < 8; i++) {
        none = none && power(bases[i], 0) == 1;
        once = once && power(bases[i], 1) == bases[i];
        zero = zero && power(0, exponents[i]) == 0 && power(-0.0, exponents[i]) == 0;
        one = one && power(1, exponents[i]) == 1;
    }
    CHECK(none, "x^0 is 1");
    CHECK(once, "x^1 is x");
    CHECK(zero, "0^x is 0");
    CHECK(one, "1^x is 1");
    CHECK(power(0.5, 1e300) == 0 && power(0.5, 1075) == 0 && power(0x1.8p-1, 1e4) == 0,
          "a power that is too small is 0");
    CHECK(power(0.5, 1074) == 0x1p-1074 && power(0x1.0000000000001p-1, 1075) == 0x1p-1074,
          "a power above half of the smallest number is not 0");
    CHECK(power(2, 1024) == HUGE_VAL && power(2, 1e300) == HUGE_VAL && power(1.9, 1e4) == HUGE_VAL,
          "a power that is too large is infinite");
    CHECK(power(0x1.fffffffffffffp+1023, 1) == DBL_MAX && power(2, 1023) == 0x1p1023,
          "a power up to the largest number is finite");
}

/* A double holds these powers exactly. */
static void check_exact(void)
{
    int wrong_powers = 0, wrong_roots = 0, wrong_twos = 0;
    for (int i = 1; i < 256; i++) {
        double product = 1;
        for (int n = 1; n <= 6; n++) { /* 48 bits at most */
            product *= i / 128.;
            wrong_powers += power(i / 128., n) != product;
        }
    }
    for (int i = 1; i < 1 << 20; i += 7)
        wrong_roots += power(i * 0x1p-40 * i, 0.5) != i * 0x1p-20;
    for (int n = 0; n <= 1074; n++)
        wrong_twos += power(0.5, n) != ldexp(1, -n) || power(0.25, n * 0.5) != ldexp(1, -n) ||
                      binary_logarithm(ldexp(1, -n)) != -n;
    CHECK(wrong_powers == 0, "whole powers are exact products (%d wrong)", wrong_powers);
    CHECK(wrong_roots == 0, "x^0.5 is the root of a square (%d wrong)", wrong_roots);
    CHECK(wrong_twos == 0, "powers of 1/2 and 1/4, and logarithms, are exact (%d wrong)",
          wrong_twos);
}

/* Bases lie where the logarithm is hardest, 0.0169 from that of a root, and at random. */
static void check_power(void)
{
    uint64_t state = 1;
    double gloss = 0, near_one = 0, steep = 0, tiny = 0, root = 0;
    for (int i = 0; i < 500000; i++) {
        const double x = test_random(&state, 0, 1) + DBL_MIN,
                     exponent = 128 * test_random(&state, 0, 1);
        const double near = 1 - x * ldexp(1, -(i % 53));
        const double hard = exp2(-0.0155 - 0.0015 * x), large = 1e4 - 20 * exponent;
        const double falls = -(1022 + 53 * test_random(&state, 0, 1)) / log2(x);
        gloss = worse_power(gloss, 2 * x, exponent);
        near_one = worse_power(near_one, near, exponent);
        steep = worse_power(steep, hard, large);
        if (falls < 1e4)
            tiny = worse_power(tiny, x, falls);
        root = worse(root, power(x, 0.5), sqrtl((long double)x));
    }
    CHECK_NEAR(gloss, 0, 0.501, "x^y for x up to 2, y up to 128 (%.4f units)", gloss);
    CHECK_NEAR(near_one, 0, 0.501, "x^y for x just below 1 (%.4f units)", near_one);
    CHECK_NEAR(steep, 0, 0.51, "x^y for y up to 10,000 (%.4f units)", steep);
    CHECK_NEAR(tiny, 0, 0.51, "x^y below the normal numbers (%.4f units)", tiny);
    CHECK_NEAR(root, 0, 0.501, "x^0.5 is the square root (%.4f units)", root);
}

static void check_grid(void)
{
    double worst = 0;
    for (int i = 1; i <= 2048; i++)
        for (int n = 1; n <= 256; n++)
            worst = worse_power(worst, i / 2048., n / 2.);
    CHECK_NEAR(worst, 0, 0.501, "whole and half exponents on a dense grid (%.4f units)", worst);
}

static void check_monotone(void)
{
    static const double exponents[] = {0.01, 0.3, 1, 2.2, 77.7, 128, 1e4};
    uint64_t state = 2;
    int falls = 0;
    for (int i = 0; i < 7000; i++) {
        double base =
            i % 2 ? test_random(&state, 0, 1) : 1 + ldexp(test_random(&state, 0, 1) - 0.5, -i % 9);
        double last = 0;
        for (int k = 0; k < 50; k++, base = nextafter(base, 2)) {
            const double next = power(base, exponents[i % 7]);
            falls += !(next >= last);
            last = next;
        }
    }
    CHECK(falls == 0, "a power never falls as its base grows (%d times)", falls);
}

static void check_logarithm(void)
{
    uint64_t state = 3;
    double worst = 0;
    for (int i = 0; i < 500000; i++) {
        const double x = test_random(&state, 0, 1) + DBL_MIN, near = 1 + ldexp(x - 0.5, -(i % 50));
        const double any = ldexp(1 + x, i % 2000 - 1000);
        worst = worse(worst, binary_logarithm(near), log2l((long double)near));
        worst = worse(worst, binary_logarithm(any), log2l((long double)any));
    }
    CHECK_NEAR(worst, 0, 0.501, "log2, near 1 and far from it (%.4f units)", worst);
}

static void check_exponential(void)
{
    uint64_t state = 4;
    double worst = 0, decay = 0;
    for (int i = 0; i < 500000; i++) {
        const double x = 2 * test_random(&state, 0, 1) - 1, far = (x < 0 ? 745.13 : 709.78) * x;
        const double fall = 40 * fabs(x) * ldexp(1, -(i % 40));
        worst = worse(worst, exponential(x), expl((long double)x));
        worst = worse(worst, exponential(far), expl((long double)far));
        decay = worse(decay, one_minus_decay(fall), -expm1l((long double)-fall));
    }
    CHECK_NEAR(worst, 0, 1.2, "e^x (%.2f units)", worst);
    CHECK_NEAR(decay, 0, 2.1, "1 - e^-x (%.2f units)", decay);
    CHECK(exponential(0) == 1 && exponential(-1000) == 0 && exponential(1000) == HUGE_VAL,
          "e^x is right at 0 and far outside its range");
    CHECK(exponential(-745.13) == 0x1p-1074 && exponential(709.78) < HUGE_VAL,
          "e^x is neither 0 nor infinite just inside its range");
    CHECK(one_minus_decay(0) == 0 && one_minus_decay(1e-300) == 1e-300 && one_minus_decay(41) == 1,
          "1 - e^-x is right at the ends of its range");
    CHECK(one_minus_decay(37.4) == 1 - DBL_EPSILON / 2,
          "1 - e^-x is below 1 as long as a double can be");
}

/* The tangents are longest, and the series with them, at 90 degrees. The largest error is 5 units;
 * the contract allows more. */
static void check_angle(void)
{
    uint64_t state = 5;
    double worst = 0;
    for (int i = 0; i < 500000; i++) {
        const double x = test_random(&state, 0, 1), part = ldexp(x, -(i / 2 % 30));
        const long double angle = (long double)(i % 2 ? PI * part : PI / 2 * (1 - part));
        worst = worse(worst, angle_of((double)sinl(angle), (double)cosl(angle)), angle);
    }
    CHECK_NEAR(worst, 0, 6, "the angle of a sine and a cosine (%.2f units)", worst);
    CHECK(angle_of(0, 1) == 0 && angle_of(0, -1) == PI, "the angles at the ends are 0 and pi");
}

/* Returns whether these are the sine and cosine of `eighths` times 45 degrees, without a negative
 * zero. */
static bool of_eighths(int eighths, double sine, double cosine)
{
    const double root = 0x1.6a09e667f3bcdp-1; /* of 1/2 */
    const double exact[8] = {0, root, 1, root, 0, -root, -1, -root};
    return sine == exact[eighths & 7] && cosine == exact[(eighths + 2) & 7] &&
           !(sine == 0 && signbit(sine)) && !(cosine == 0 && signbit(cosine));
}

static void check_eighths(void)
{
    int wrong_degrees = 0, wrong_turns = 0;
    double sine, cosine;
    for (int i = -10000; i <= 10000; i++) {
        sine_cosine(45. * i, &sine, &cosine);
        wrong_degrees += !of_eighths(i, sine, cosine);
        sine_cosine(45 * (i + (i < 0 ? -8e9 : 8e9)), &sine, &cosine); /* whole turns more */
        wrong_degrees += !of_eighths(i, sine, cosine);
    }
    for (int64_t size = 2; size <= 1 << 29; size *= 2)
        for (int i = 0; i <= 8; i++) {
            sine_cosine_of_turn(size * i, size * 8, &sine, &cosine);
            wrong_turns += !of_eighths(i, sine, cosine);
            sine_cosine_of_turn((size - 1) * i, size * 8 - 8, &sine, &cosine);
            wrong_turns += !of_eighths(i, sine, cosine);
        }
    sine_cosine(-0.0, &sine, &cosine);
    const bool zero = of_eighths(0, sine, cosine);
    sine_cosine(-0x1p-1074, &sine, &cosine);
    CHECK(zero && of_eighths(0, sine, cosine),
          "the sine of -0, and a sine that is too small, is 0");
    CHECK(wrong_degrees == 0, "multiples of 45 degrees are exact (%d wrong)", wrong_degrees);
    CHECK(wrong_turns == 0, "eighths of a turn are exact (%d wrong)", wrong_turns);
}

/* ---- the C library ---- */

/* Asks the C library of this system, on this processor or an emulated one, for results that are not
 * known when this is compiled. 2^1000 mod 360 is 16. */
static void check_library(void)
{
    volatile double half = 0.5, two = 2, big = 0x1p27, least = 0x1p-1074;
    const double one = half * two;
    int exponent;
    CHECK(sqrt(two) == 0x1.6a09e667f3bcdp+0 && sqrt(least * two * two) == 0x1p-536,
          "sqrt rounds correctly");
    CHECK(fma(big + one, big - one, -big * big) == -1, "fma rounds once");
    CHECK(fmod(ldexp(one, 1000), 360) == 16 && fmod(-725.25 * one, 360) == -5.25 &&
              fmod(least, 360) == least,
          "fmod is exact");
    CHECK(nearbyint(half) == 0 && nearbyint(3 * half) == 2 && nearbyint(-5 * half) == -2,
          "nearbyint rounds ties to even");
    CHECK(floor(-half) == -1 && ceil(half) == 1 && floor(big + half) == big,
          "floor and ceil are exact");
    CHECK(frexp(3 * least, &exponent) == 0.75 && exponent == -1072 &&
              ldexp(1.25 * one, -1074) == least && ldexp(1.5 * one, -1074) == 2 * least,
          "frexp is exact, and ldexp rounds subnormal numbers to even");
    CHECK(fmax(NAN, one) == 1 && fmin(one, NAN) == 1 && fabs(-half) == half,
          "fmax and fmin prefer a number, and fabs is exact");
}

/* ---- sine and cosine ---- */

/* As remquol, whose quotient is lost where glibc runs on some emulated processors. */
static long double off_quarters(long double angle, int *quarters)
{
    long double off = fmodl(angle, 360);
    *quarters = 0;
    for (; off > 45; ++*quarters)
        off -= 90;
    for (; off < -45; --*quarters)
        off += 90;
    return off;
}

/* Returns the sine of a number of quarter turns plus `off` degrees, at most 45. */
static long double exact_sine(int quarters, long double off)
{
    const long double angle = off * (3.141592653589793238462643383279502884L / 180);
    const long double sine = quarters & 1 ? cosl(angle) : sinl(angle);
    return quarters & 2 ? -sine : sine;
}

static double worse_degrees(double worst, double angle)
{
    int quarters;
    const long double off = off_quarters((long double)angle, &quarters);
    double sine, cosine;
    sine_cosine(angle, &sine, &cosine);
    worst = worse(worst, sine, exact_sine(quarters, off));
    return worse(worst, cosine, exact_sine(quarters + 1, off));
}

/* At any angle, near multiples of 45 degrees and near 0. The mean error shows if the last bits of
 * the angle count: from 30 to 40 degrees it is 0.253 units for the sine and 0.278 for the cosine;
 * correct rounding would give 0.25. */
static void check_degrees(void)
{
    const int count = 100000;
    uint64_t state = 6;
    double any = 0, near = 0, tiny = 0, sines = 0, cosines = 0, sine, cosine;
    for (int i = 0; i < count; i++) {
        const double x = 2 * test_random(&state, 0, 1) - 1, angle = 35 + 5 * x;
        any = worse_degrees(any, 720 * x);
        near = worse_degrees(near, 45 * (i % 33 - 16) + ldexp(x, -(i % 50)));
        tiny = worse_degrees(tiny, ldexp(x, -(i % 1070)));
        sine_cosine(angle, &sine, &cosine);
        sines += worse(0, sine, exact_sine(0, (long double)angle)) / count;
        cosines += worse(0, cosine, exact_sine(1, (long double)angle)) / count;
    }
    CHECK_NEAR(any, 0, 2, "sine and cosine up to 720 degrees (%.2f units)", any);
    CHECK_NEAR(near, 0, 2, "sine and cosine near multiples of 45 degrees (%.2f units)", near);
    CHECK_NEAR(tiny, 0, 2, "sine and cosine near 0 (%.2f units)", tiny);
    CHECK_NEAR(sines, 0, 0.26, "the mean error of sines (%.3f units)", sines);
    CHECK_NEAR(cosines, 0, 0.29, "the mean error of cosines (%.3f units)", cosines);
}

static double worse_turn(double worst, int64_t part, int64_t whole)
{
    const int64_t quarters = (8 * part + whole) / (2 * whole);
    const long double off = 90 * (long double)(4 * part - quarters * whole) / (long double)whole;
    double sine, cosine;
    sine_cosine_of_turn(part, whole, &sine, &cosine);
    worst = worse(worst, sine, exact_sine((int)(quarters & 3), off));
    return worse(worst, cosine, exact_sine((int)(quarters & 3) + 1, off));
}

/* Turns in few parts and in many, more than a turn, and near eighths of one. */
static void check_turns(void)
{
    uint64_t state = 7;
    double any = 0, near = 0, sine, cosine, s, c;
    int unequal = 0, unmirrored = 0;
    for (int i = 0; i < 100000; i++) {
        const double most = ldexp(1, i % 33);
        const int64_t whole = 1 + (int64_t)(most * test_random(&state, 0, 1));
        const int64_t part = (int64_t)(0x1p32 * test_random(&state, 0, 1)), less = part % whole;
        any = worse_turn(any, part, whole);
        near = worse_turn(near, whole * (i % 8) / 8 + i % 5, whole);
        sine_cosine_of_turn(less, whole, &sine, &cosine);
        sine_cosine_of_turn(part, whole, &s, &c);
        unequal += s != sine || c != cosine;
        sine_cosine_of_turn(whole - less, whole, &s, &c);
        unmirrored += s != -sine || c != cosine;
    }
    CHECK_NEAR(any, 0, 1.5, "sine and cosine of parts of a turn (%.2f units)", any);
    CHECK_NEAR(near, 0, 1.5, "sine and cosine near eighths of a turn (%.2f units)", near);
    CHECK(unequal == 0, "whole turns change nothing (%d times)", unequal);
    CHECK(unmirrored == 0, "the rest of a turn mirrors the part (%d times not)", unmirrored);
}

int main(void)
{
    check_rounded();
    check_ends();
    check_exact();
    check_power();
    check_grid();
    check_monotone();
    check_logarithm();
    check_exponential();
    check_angle();
    check_eighths();
    check_library();
    check_degrees();
    check_turns();
    return test_end();
}
