/* SPDX-License-Identifier: MIT */
/* Compares spectra with closed forms and physical constants. Both renderers share the readers of
 * spectra, so the check of pictures would not find their errors. test/cases/bad/tables.cases has
 * the files that are refused. */
#include <float.h>

#include "data/spectra/spectra.h"
#include "data/text/text.h"
#include "spectral.h"
#include "test.h"

static const char *const path =
    "spectrum-content"; /* of the file that the next spectrum is read from */

/* Reads the first word of a line; returns an absent spectrum after an error. */
static struct spectrum read_between(const char *line, double lowest, double highest,
                                    struct error *err)
{
    struct spectrum out = {0};
    struct text text;
    struct word word;
    *err = (struct error){0};
    text_open_string(&text, "line", line, err);
    text_next_line(&text);
    text_word(&text, &word);
    if (!spectrum_read(&word, lowest, highest, &out, err))
        CHECK(out.kind == SPECTRUM_NONE && out.name == NULL && out.value == NULL,
              "a refused spectrum is left empty");
    out.place.path = NULL; /* the text is not kept */
    text_free(&text);
    return out;
}

static struct spectrum read_word(const char *line)
{
    struct error err;
    struct spectrum out = read_between(line, -HUGE_VAL, HUGE_VAL, &err);
    if (err.text[0] != '\0')
        printf("# %s\n", err.text);
    return out;
}

static double value_of(const char *line, double nm)
{
    struct spectrum spectrum = read_word(line);
    double value =
        spectrum.kind != SPECTRUM_NONE ? spectrum_at(&spectrum, nm, SPECTRUM_HOLD) : (double)NAN;
    spectrum_free(&spectrum);
    return value;
}

/* Returns the message that refuses a reflectance. */
static const char *refusal(const char *line, struct error *err)
{
    struct spectrum spectrum = read_between(line, 0, 1, err);
    spectrum_free(&spectrum);
    return err->text;
}

/* Writes a file and reads it as a spectrum's word. */
static struct spectrum read_content(const char *content)
{
    return read_word(test_write(path, content));
}

static void check_words(void)
{
    struct spectrum s = read_word("d65*0.5");
    CHECK(s.kind == SPECTRUM_SAMPLED && s.factor == 0.5, "a built-in name may have a factor");
    CHECK_TEXT(s.name, "d65*0.5", "its name is as written");
    CHECK(s.place.line == 1 && s.place.column == 1, "its source place is the word");
    spectrum_free(&s);
    spectrum_free(&s);
    CHECK(value_of("0.25", 500) == 0.25, "a number is constant over wavelengths");
    CHECK(value_of("0.25*3", 1) == 0.75, "a number is multiplied by its factor");
    CHECK(value_of("2e-1", 1) == 0.2, "numbers may have any notation");
    CHECK(value_of("gaussian:380,40", 380) == 1, "a gaussian is 1 at its centre");
    CHECK_NEAR(value_of("gaussian:380,40*3", 400), 1.5, DBL_EPSILON,
               "a gaussian is 1/2 at half its width from the centre");
    CHECK(value_of("gaussian:380,1e-300", 381) == 0,
          "a narrow gaussian vanishes beside its centre");
    CHECK(value_of("cie1931:2", 555) == value_of("builtin:tables/cie1931.csv:2", 555) &&
              value_of("cie1931:2", 555) > 0.99,
          "column 2 of an observer is read");
}

/* Planck's law computed with the C library in long double. */
static double planck_ratio(double temperature, double nm)
{
    long double c2 = 6.62607015e-34L * 299792458.0L / 1.380649e-23L * 1e9L;
    long double t = (long double)temperature, wavelength = (long double)nm;
    long double x0 = c2 / (560 * t), x = c2 / (wavelength * t);
    return (double)(powl(560 / wavelength, 5) * (expm1l(x0) / expm1l(x)));
}

static void check_blackbody(void)
{
    static const double temperatures[] = {300, 1500, 2856, 6504, 25000, 1e6};
    double worst = 0, largest = 0, at = 0;
    char word[64];
    for (size_t i = 0; i < sizeof temperatures / sizeof temperatures[0]; i++) {
        snprintf(word, sizeof word, "blackbody:%g", temperatures[i]);
        struct spectrum s = read_word(word);
        CHECK(spectrum_at(&s, 560, SPECTRUM_ZERO) == 1, "%s is 1 at 560 nm", word);
        for (double nm = 200; nm <= 2000; nm += 7.3) {
            double expected = planck_ratio(temperatures[i], nm);
            double x = 1.44e7 / (nm * temperatures[i]), x0 = 1.44e7 / (560 * temperatures[i]);
            /* x0 and x are rounded three times each, and e^(x0 - x) propagates their errors; some
             * 20 roundings follow. */
            double bound = DBL_EPSILON * (10 + 2 * (x0 + x));
            worst = fmax(worst, fabs(spectrum_at(&s, nm, SPECTRUM_ZERO) / expected - 1) / bound);
        }
        spectrum_free(&s);
    }
    CHECK_NEAR(worst, 0, 1, "a blackbody follows Planck's law");
    for (double nm = 400; nm < 1600; nm += 0.01)
        if (value_of("blackbody:2897.771955", nm) > largest) {
            largest = value_of("blackbody:2897.771955", nm);
            at = nm;
        }
    CHECK_NEAR(at, 1000, 0.02, "a blackbody's peak obeys Wien's law");
    /* Far in the infrared Rayleigh and Jeans's T / nm^4 remains: (560/nm)^4 (e^x0 - 1) / x0 with
     * x0 = c2 / (560 T) = 0.025692445; it neglects c2 / (2 nm T) = 8e-6 of the value. */
    CHECK_NEAR(value_of("blackbody:1e6", 9e5) /
                   (pow(560 / 9e5, 4) * expm1(0.025692445) / 0.025692445),
               1, 1e-5, "a blackbody follows Rayleigh and Jeans's law far in the infrared");
    CHECK(value_of("blackbody:1000", 1e-3) == 0 && value_of("blackbody:1000", 1e-200) == 0,
          "a blackbody vanishes at short wavelengths, without a NaN");
}

static void check_interpolation(void)
{
    struct spectrum s = read_content("400 0.1\n410 0.3\n# comment\n\n430.5 0.7\n");
    CHECK(s.count == 3, "two columns are read");
    CHECK(spectrum_at(&s, 400, SPECTRUM_ZERO) == 0.1 &&
              spectrum_at(&s, 410, SPECTRUM_ZERO) == 0.3 &&
              spectrum_at(&s, 430.5, SPECTRUM_ZERO) == 0.7,
          "the spectrum equals its samples to the last bit");
    CHECK_NEAR(spectrum_at(&s, 402.5, SPECTRUM_ZERO), 0.15, DBL_EPSILON,
               "the spectrum is linear between samples");
    CHECK_NEAR(spectrum_at(&s, 430, SPECTRUM_ZERO), 0.7 - 0.4 * 0.5 / 20.5, DBL_EPSILON,
               "the spectrum is linear between uneven samples");
    CHECK(spectrum_at(&s, 399.9, SPECTRUM_ZERO) == 0 && spectrum_at(&s, 431, SPECTRUM_ZERO) == 0,
          "SPECTRUM_ZERO is 0 outside the samples");
    CHECK(spectrum_at(&s, 399.9, SPECTRUM_HOLD) == 0.1 &&
              spectrum_at(&s, 431, SPECTRUM_HOLD) == 0.7,
          "SPECTRUM_HOLD keeps the end values outside the samples");
    CHECK(spectrum_extrapolates(&s, 399.9) && spectrum_extrapolates(&s, 430.6) &&
              !spectrum_extrapolates(&s, 400) && !spectrum_extrapolates(&s, 430.5),
          "extrapolation is detected");
    spectrum_free(&s);
    s = read_content("400 0.3\n500 0.3\n600 1\n");
    bool inside = true, level = true;
    for (double nm = 400; nm <= 600; nm += 0.0173) {
        double value = spectrum_at(&s, nm, SPECTRUM_ZERO);
        inside = inside && value >= 0.3 && value <= 1;
        level = level && (nm > 500 || value == 0.3);
    }
    CHECK(inside && level, "rounding never leaves the range of two samples");
    spectrum_free(&s);
    s = read_content("555 2\n");
    CHECK(spectrum_at(&s, 555, SPECTRUM_ZERO) == 2 && spectrum_at(&s, 554, SPECTRUM_ZERO) == 0 &&
              spectrum_at(&s, 1, SPECTRUM_HOLD) == 2,
          "a spectrum may have one sample");
    spectrum_free(&s);
}

static double largest_difference(const char *a, const char *b)
{
    struct spectrum one = read_word(a), two = read_word(b);
    double largest = one.count == 107 && two.count == 107 ? 0 : (double)NAN;
    for (double nm = 300; nm <= 830; nm += 2.5)
        largest = fmax(largest, fabs(spectrum_at(&one, nm, SPECTRUM_ZERO) -
                                     spectrum_at(&two, nm, SPECTRUM_ZERO)));
    spectrum_free(&one);
    spectrum_free(&two);
    return largest;
}

static void check_daylight(void)
{
    /* Nominal temperatures are older than today's second radiation constant: times 1.4388/1.4380.
     * D65 is published in 6 digits. M1 and M2 of 6504 K and 5003 K differ by 0.001 from those of
     * D65 and D50, and the components by which they multiply reach 0.463 and 0.102. */
    static const struct {
        const char *a, *b;
        double tolerance;
    } same[] = {{"daylight:6503.616", "d65", 1e-5}, {"daylight:5002.782", "d50", 1e-15},
                {"daylight:5503.06", "d55", 1e-15}, {"daylight:7504.172", "d75", 1e-15},
                {"daylight:6504", "d65", 0.00048},  {"daylight:5003", "d50", 0.00011},
                {"daylight:5503", "d55", 1e-15},    {"daylight:7504", "d75", 1e-15}};
    struct error err;
    for (size_t i = 0; i < sizeof same / sizeof same[0]; i++)
        CHECK_NEAR(largest_difference(same[i].a, same[i].b), 0, same[i].tolerance, "%s is %s",
                   same[i].a, same[i].b);
    CHECK(value_of("daylight:4000", 560) == 1 && value_of("daylight:25000", 560) == 1,
          "the coldest and the hottest daylight are 1 at 560 nm");
    CHECK(value_of("daylight:6504*2", 560) == 2, "daylight may have a factor");
    CHECK_TEXT(refusal("daylight:25001", &err),
               "line:1:10: error: daylight has a temperature from 4000 to 25000 K, not 25001",
               "daylight that is too hot is refused");
    CHECK_TEXT(refusal("daylight:d65", &err),
               "line:1:10: error: temperature must be a number such as 2.5 or 1e-3, not 'd65'",
               "daylight of a name is refused");
}

static void check_bad_words(void)
{
    const char *bad =
        "d65*-1 d65* d65*nan *2 1e999 nan 0x1 cie1931 cie1931:4 cie1931:0 d65*1e999 "
        "blackbody:-5 blackbody:2e6 blackbody: blackbody:x blackbody:2856 gaussian:380 "
        "gaussian:,40 gaussian:380,40,50 gaussian:400,40*1.1 \"d65 builtin:tables/none.csv "
        "d65: 1.5abc 3*0.5";
    char word[64];
    struct error err;
    while (test_word(&bad, word))
        CHECK(refusal(word, &err)[0] != '\0' && err.status == EXIT_INPUT,
              "%s is refused as a reflectance", word);
    CHECK(refusal("d65*0.5", &err)[0] == '\0' && refusal("2*0.5", &err)[0] == '\0',
          "built-in tables and numbers, too, are checked with their factor");
    refusal("sun", &err);
    CHECK(strncmp(err.text, "line:1:1: error: no built-in spectrum and no file 'sun'", 55) == 0 &&
              strstr(err.text, " d65, ") != NULL && !strstr(err.text, "cie1931"),
          "the message for an unknown name lists the built-in illuminants, and no detectors");
    CHECK_TEXT(refusal("0.5*x", &err),
               "line:1:5: error: factor must be a number such as 2.5 or 1e-3, not 'x'",
               "the message names the place of a bad factor");
    CHECK_TEXT(refusal("\"0.5*x\"", &err),
               "line:1:6: error: factor must be a number such as 2.5 or 1e-3, not 'x'",
               "the message names the place of a bad factor in quotes");
    CHECK_TEXT(refusal("gaussian:380,-1", &err),
               "line:1:14: error: width -1 is not above 0; it lies between 0 and 1000000",
               "the message names the place of a bad width");
    read_between("blackbody:5", 0, HUGE_VAL, &err);
    CHECK(strstr(err.text, "reaches values that are too large") != NULL,
          "a blackbody too cold for its infrared is refused");
    read_between("d65*1e308*1e308", 0, HUGE_VAL, &err);
    CHECK(err.text[0] != '\0', "only the last * is a factor");
}

static void check_append(void)
{
    const struct place place = {"f", 3, 1};
    struct spectrum s = {0};
    struct error err = {0};
    bool appended = true;
    for (int i = 1; i <= 1000; i++)
        appended = appended && spectrum_append(&s, i, i * 0.5, place, &err);
    CHECK(appended && s.count == 1000 && s.kind == SPECTRUM_SAMPLED && s.factor == 1 &&
              s.place.line == 3,
          "samples are appended");
    CHECK(!spectrum_append(&s, 1000, 1, place, &err) && s.count == 1000,
          "a sample that does not increase in wavelength is refused, and changes nothing");
    CHECK(!spectrum_append(&s, 1001, HUGE_VAL, place, &err) &&
              !spectrum_append(&s, (double)NAN, 1, place, &err) &&
              !spectrum_append(&s, 1001, (double)NAN, place, &err),
          "an infinite or undefined sample is refused");
    spectrum_free(&s);
    CHECK(spectrum_at(&s, 500, SPECTRUM_HOLD) == 0, "an absent spectrum is 0");
}

int main(void)
{
    test_enter();
    check_words();
    check_blackbody();
    check_interpolation();
    check_daylight();
    check_bad_words();
    check_append();
    return test_end();
}
