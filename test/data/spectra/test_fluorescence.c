/* SPDX-License-Identifier: MIT */
/* Compares excitation and Donaldson matrices with integrals in closed form. effects.py has the
 * thesis's sums, and matrices as they are measured; test/cases/bad/matrices.cases has refused ones.
 */
#include <float.h>

#include "spectral.h"
#include "spectra.h"

static const double half_epsilon = DBL_EPSILON / 2; /* of a rounding */

/* Returns a spectrum that owns nothing. */
static struct spectrum samples(double *nm, double *value, int count)
{
    return (struct spectrum){
        .kind = SPECTRUM_SAMPLED, .factor = 1, .count = count, .wavelength_nm = nm, .value = value};
}

static struct spectrum gaussian(double centre, double width)
{
    return (struct spectrum){.kind = SPECTRUM_GAUSSIAN, .factor = 1, .parameter = {centre, width}};
}

static struct spectrum constant(double value)
{
    return (struct spectrum){.kind = SPECTRUM_CONSTANT, .factor = 1, .parameter = {value}};
}

/* ---- the mean ---- */

static void check_limits(void)
{
    struct spectrum uv = spectrum_of("uv"), light = spectrum_of("d65"), flat = constant(0.3);
    struct spectrum blackbody = spectrum_of("blackbody:2856");
    double mean = excitation_mean(&light, &uv), one_nm[] = {431}, one[] = {7};
    struct spectrum single = samples(one_nm, one, 1), outside = samples(one_nm, one, 1);
    long double sum = 0;
    CHECK(excitation_mean(&flat, &uv) == 0.3, "the mean of a constant is that constant");
    light.factor = ldexp(1, -900);
    CHECK(excitation_mean(&light, &uv) == ldexp(mean, -900), "a faint light scales exactly");
    light.factor = ldexp(1, 1000);
    CHECK(excitation_mean(&light, &uv) == ldexp(mean, 1000), "a bright light scales exactly");
    light.factor = 1;
    uv.factor = ldexp(1, -1000);
    CHECK(excitation_mean(&light, &uv) == mean, "a weak excitation has the same mean");
    uv.factor = 1e300;
    CHECK_NEAR(excitation_mean(&light, &uv) / mean, 1, 4 * 93 * half_epsilon,
               "an excitation of 1e300 has the same mean");
    flat.parameter[0] = DBL_MAX;
    CHECK(excitation_mean(&flat, &uv) == DBL_MAX, "the largest number is its own mean");
    CHECK(excitation_mean(&light, &single) == spectrum_at(&light, 431, SPECTRUM_ZERO),
          "an excitation of one sample takes the light there");
    one_nm[0] = 299;
    CHECK(excitation_mean(&light, &outside) == 0 && excitation_mean(&outside, &uv) == 0,
          "a light outside the excitation gives nothing");
    flat.parameter[0] = 2;
    for (int nm = 300; nm <= 780; nm++)
        sum += (long double)spectrum_at(&blackbody, nm, SPECTRUM_ZERO);
    CHECK_NEAR(excitation_mean(&blackbody, &flat) / (double)(sum / 481), 1, 2 * 485 * half_epsilon,
               "two smooth spectra are taken every nm from 300 to 780");
    uv.factor = 0;
    CHECK(excitation_mean(&light, &uv) == 0, "an excitation of 0 gives no NaN");
    spectrum_free(&uv);
    spectrum_free(&light);
    spectrum_free(&blackbody);
}

/* Excitations are piecewise linear and 0 at their ends, so that trapezoids sum them exactly. */
static void check_union(void)
{
    double nm[] = {400, 410, 420}, value[] = {0, 1, 0};
    double line_nm[] = {403, 404, 405}, line[] = {0, 2, 0};
    double ramp_nm[] = {100, 900}, ramp[] = {1, 9};
    double box_nm[] = {400, 410}, box[] = {1, 1};
    double step_nm[] = {300, 400, 410, 900}, step[] = {0, 0, 1, 1};
    struct spectrum tooth = samples(nm, value, 3);
    struct spectrum light = samples(line_nm, line, 3);
    /* integral of the line 2, times the excitation at its middle 0.4, over 10 */
    CHECK_NEAR(excitation_mean(&light, &tooth), 0.08, 10 * half_epsilon,
               "a line between the samples of the excitation is not lost");
    CHECK_NEAR(excitation_mean(&tooth, &light), 0.4, 10 * half_epsilon,
               "an excitation between the samples of the light is not lost");
    light = samples(ramp_nm, ramp, 2);
    CHECK_NEAR(excitation_mean(&light, &tooth), 4.1, 4.1 * 10 * half_epsilon,
               "a ramp's mean is its value at the excitation's centre of mass");
    tooth = samples(box_nm, box, 2);
    light = samples(step_nm, step, 4);
    CHECK(excitation_mean(&light, &tooth) == 0.5,
          "samples beyond the excitation do not change the weight of its end");
}

/* Returns the integral of the product of two gaussians, divided by the integral of the second. */
static double overlap(double distance, double width, double excitation_width)
{
    const double a = 4 * log(2) / (width * width);
    const double b = 4 * log(2) / (excitation_width * excitation_width);
    return exp(-a * b / (a + b) * distance * distance) * sqrt(b / (a + b));
}

static void check_gaussians(void)
{
    const double root_ln2 = sqrt(4 * log(2)), pi = acos(-1);
    double nm[] = {400, 410, 420}, value[] = {0, 1, 0};
    struct spectrum tooth = samples(nm, value, 3);
    struct spectrum light = gaussian(380, 40), excitation = gaussian(400, 40);
    double a, h = 1, variation;
    /* Both spectra have their points at whole nm, an even grid, where sums of gaussians equal
     * integrals. 341 terms round as in the plain sums, and exponents by 3 units, which x e^-x < 0.4
     * damps. */
    CHECK_NEAR(excitation_mean(&light, &excitation) / overlap(20, 40, 40), 1,
               2 * (341 + 20) * half_epsilon, "the overlap of two gaussians is the analytic one");
    /* Uneven trapezoids miss at most h^2 / 8 times the integral of |f''|, which for e^(-a x^2) is 4
     * times its steepest slope, sqrt(2 a / e), over its area, sqrt(pi / a). */
    light = gaussian(380.3, 56);
    excitation = gaussian(371, 40);
    a = 4 * log(2) / (40 * 40.0) +
        4 * log(2) / (56 * 56.0); /* the product has the narrower width */
    variation = 4 * sqrt(2 * a / exp(1)) / sqrt(pi / a);
    CHECK_NEAR(excitation_mean(&light, &excitation) / overlap(9.3, 56, 40), 1,
               2 * h * h / 8 * variation,
               "on an uneven grid the error is within the bound of trapezoids");
    /* Wavelengths of the line are rounded to 2^-45 nm, relative to its width; the points that mark
     * its ends, at 2^-64, stand for up to 3 nm each. */
    light = gaussian(404.7, 1e-3);
    CHECK_NEAR(excitation_mean(&light, &tooth) / (0.47 * 1e-3 * sqrt(pi) / root_ln2 / 10), 1,
               4 * ldexp(1, -45) / 1e-3 + 1e-12,
               "a laser line between the samples of the excitation is not lost");
    excitation = gaussian(404.7, 1e-300);
    light = constant(0.7);
    CHECK(excitation_mean(&light, &excitation) == 0.7,
          "the narrowest excitation between the samples of the light is not lost");
}

/* ---- the matrix ---- */

/* Returns a zeroed matrix after an error. */
static struct donaldson read_matrix(const char *content, double diffuse, struct error *err)
{
    struct spectrum reflectance = constant(diffuse);
    struct place nowhere = {0};
    struct donaldson out;
    *err = (struct error){0};
    if (!donaldson_read(test_write("matrix.csv", content), nowhere, false, &reflectance, &out, err))
        donaldson_free(&out);
    return out;
}

static struct spectrum emission_under(const struct donaldson *matrix, const struct spectrum *light)
{
    struct error err = {0};
    struct spectrum out;
    donaldson_emission(matrix, light, &out, &err);
    return out;
}

/* Returns what the matrix emits at its first wavelength. */
static double first_emission(const struct donaldson *matrix, const struct spectrum *light)
{
    struct spectrum given = emission_under(matrix, light);
    const double first = given.count > 0 ? given.value[0] : (double)NAN;
    spectrum_free(&given);
    return first;
}

/* A column of effects.py takes a line of its own; this line lies between two. */
static void check_line(void)
{
    struct error err;
    struct donaldson matrix =
        read_matrix("# measured\n\nnm;300;310 320\t330 # excitation\n"
                    "400, 0, 0.1, 0.3, 0\r\n420, 0, 0.2, 0.1, 0\n\n450 0 0.1 0.2 0",
                    0.4, &err);
    double nm[] = {300, 311, 312, 313, 330}, value[] = {0, 0, 3, 0, 0};
    struct spectrum light = samples(nm, value, 5), given;
    CHECK_TEXT(err.text, "", "blanks, commas and semicolons separate");
    if (matrix.share == NULL)
        return;
    /* a line of integral 3, and a band of 20 nm */
    CHECK_NEAR(first_emission(&matrix, &light), (0.8 * 0.1 + 0.2 * 0.3) * 3 / 20, 8 * half_epsilon,
               "a line between two columns is shared between them");
    light = gaussian(312, 0.1);
    /* its wings end at 2^-64; the wavelengths are rounded to 2^-45 nm */
    CHECK_NEAR(first_emission(&matrix, &light) / (0.14 * 0.1 * sqrt(acos(-1) / (4 * log(2))) / 20),
               1, 4 * ldexp(1, -45) / 0.1 + 1e-14,
               "a gaussian line between two columns is shared between them");
    nm[0] = 331, nm[1] = 332, nm[2] = 333;
    light = samples(nm, value, 3);
    given = emission_under(&matrix, &light);
    CHECK(given.count == 3 && given.value[0] == 0 && given.value[2] == 0,
          "light outside the matrix gives nothing");
    spectrum_free(&given);
    donaldson_free(&matrix);
}

static void check_extremes(void)
{
    double nm[] = {400, 410}, dim_nm[] = {500}, share[] = {1e-300, 1e-300};
    struct donaldson matrix = {samples(nm, NULL, 2), samples(dim_nm, NULL, 1), share};
    struct spectrum light = constant(1e300), given;
    struct error err = {0};
    CHECK_NEAR(first_emission(&matrix, &light), 20, 20 * 8 * half_epsilon,
               "a bright light and a faint matrix meet in the middle");
    share[0] = share[1] = 1;
    light = constant(1e308);
    CHECK(!donaldson_emission(&matrix, &light, &given, &err) && err.status == EXIT_INPUT &&
              given.kind == SPECTRUM_NONE && given.value == NULL,
          "an emission beyond the largest number is refused");
    matrix.excitation.count = 1;
    light = constant(0.5);
    CHECK(first_emission(&matrix, &light) == 0.5, "single bands are 1 nm wide");
    matrix = read_matrix("nm 400\n500 .04\n510 .06\n", 0.9, &err);
    CHECK(matrix.share != NULL, "0.04 + 0.06 is 1 - 0.9, though that difference is rounded down");
    donaldson_free(&matrix);
}

static void check_diffuse_and_size(void)
{
    double nm[] = {350, 390}, value[] = {0.5, 0.9};
    struct spectrum diffuse = samples(nm, value, 2);
    struct place nowhere = {0};
    struct donaldson matrix;
    struct error err = {0};
    char *wide = malloc(5 * 4097 + 3), *at = wide + sprintf(wide, "nm");
    CHECK(donaldson_read(test_write("matrix.csv", "nm 300 360 500\n600 0.5 0.4 0.1\n"), nowhere,
                         false, &diffuse, &matrix, &err),
          "the ends of the diffuse reflectance are held, and between samples it is linear");
    donaldson_free(&matrix);
    CHECK(!donaldson_read(test_write("matrix.csv", "nm 300 360 500\n600 0.5 0.4 0.11\n"), nowhere,
                          false, &diffuse, &matrix, &err) &&
              strstr(err.text, ":1:12: error: at 500 nm") != NULL,
          "the matrix is also held to the diffuse reflectance beyond its samples");
    donaldson_free(&matrix);
    for (int i = 0; i < 4097; i++)
        at += sprintf(at, " %d", 1000 + i);
    matrix = read_matrix(wide, 0.5, &err);
    /* the 4097th word behind "nm ", each of 4 figures and a blank */
    CHECK(strstr(err.text, ":1:20484: error: a matrix has at most 4096 excitation wavelengths") !=
              NULL,
          "a matrix has at most 4096 columns");
    free(wide);
}

int main(void)
{
    test_enter();
    check_limits();
    check_union();
    check_gaussians();
    check_line();
    check_extremes();
    check_diffuse_and_size();
    return test_end();
}
