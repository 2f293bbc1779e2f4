/* SPDX-License-Identifier: MIT */
/* Spectra: their values, daylight, and the words that name them. */
#include <float.h>
#include <limits.h>

#include "data/spectra/inside.h"

/* A millimetre: longer waves are no light. The limit keeps sums and steps of wavelengths finite. */
static const double longest_nm = 1e6;

/* ---- values ---- */

/* Planck's radiance, divided by that at 560 nm: (560/nm)^5 (e^x0 - 1) / (e^x - 1), x = c2 / (nm T).
 * Both differences are divided by their e^x, so that no step overflows if the result does not. */
static double blackbody(double temperature, double nm)
{
    const double c2 = 1.4387768775039338e7; /* h c / k in nm K, exact in CODATA 2018 */
    double x0 = c2 / (560 * temperature), x = c2 / (nm * temperature), q = 560 / nm;
    double ratio = exponential(x0 - x);
    if (ratio == 0) /* q^5 may be infinite there */
        return 0;
    return q * q * q * q * q * ratio * one_minus_decay(x0) / one_minus_decay(x);
}

int samples_up_to(const double *wavelengths_nm, int n, double wavelength_nm)
{
    int low = 0, high = n;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (wavelengths_nm[middle] > wavelength_nm)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* Interpolates from the nearer sample: so the values at samples are exact, and rounding never
 * passes them. */
static double sampled(const struct spectrum *s, double nm, enum spectrum_ends ends)
{
    const double *x = s->wavelength_nm, *y = s->value;
    if (spectrum_extrapolates(s, nm))
        return ends == SPECTRUM_ZERO ? 0 : nm < x[0] ? y[0] : y[s->count - 1];
    const int low = samples_up_to(x, s->count, nm) - 1, high = low + 1;
    if (nm == x[low])
        return y[low];
    const int nearer = nm - x[low] < x[high] - nm ? low : high;
    return y[nearer] + (y[high] - y[low]) * ((nm - x[nearer]) / (x[high] - x[low]));
}

double spectrum_at(const struct spectrum *spectrum, double wavelength_nm, enum spectrum_ends ends)
{
    const double four_ln2 = 2.772588722239781237668928485832706;
    const double first = spectrum->parameter[0], from = wavelength_nm - first;
    const double width = spectrum->parameter[1];
    switch (spectrum->kind) {
    case SPECTRUM_CONSTANT:
        return spectrum->factor * first;
    case SPECTRUM_SAMPLED:
        return spectrum->factor * sampled(spectrum, wavelength_nm, ends);
    case SPECTRUM_BLACKBODY:
        return spectrum->factor * blackbody(first, wavelength_nm);
    case SPECTRUM_GAUSSIAN:
        return spectrum->factor * exponential(-four_ln2 * (from / width) * (from / width));
    case SPECTRUM_NONE:
        break;
    }
    return 0;
}

bool spectrum_extrapolates(const struct spectrum *spectrum, double wavelength_nm)
{
    return spectrum->kind == SPECTRUM_SAMPLED &&
           (wavelength_nm < spectrum->wavelength_nm[0] ||
            wavelength_nm > spectrum->wavelength_nm[spectrum->count - 1]);
}

/* Returns the largest value without the factor. A blackbody has it at Wien's wavelength. */
static double peak(const struct spectrum *s)
{
    const double wien = 2.897771955e6; /* b in nm K, CODATA 2018 */
    double largest = s->kind == SPECTRUM_CONSTANT ? s->parameter[0] : 1;
    if (s->kind == SPECTRUM_BLACKBODY)
        largest = blackbody(s->parameter[0], wien / s->parameter[0]);
    for (int i = 0; i < s->count; i++)
        largest = i == 0 ? s->value[i] : fmax(largest, s->value[i]);
    return largest;
}

/* ---- storage ---- */

bool spectrum_append(struct spectrum *spectrum, double wavelength_nm, double value,
                     struct place place, struct error *err)
{
    const int n = spectrum->count;
    int n_nm = n;
    if (!(wavelength_nm > 0 && wavelength_nm < longest_nm))
        return error_at(err, place, "wavelength %.15g nm; it lies between 0 and %.15g nm",
                        wavelength_nm, longest_nm);
    /* Half the range, so that the difference of two values is finite. */
    if (!(fabs(value) <= DBL_MAX / 2))
        return error_at(err, place, "value %.15g at %.15g nm is too large", value, wavelength_nm);
    if (n > 0 && wavelength_nm <= spectrum->wavelength_nm[n - 1])
        return error_at(err, place,
                        "wavelength %.15g nm follows %.15g nm; wavelengths must increase",
                        wavelength_nm, spectrum->wavelength_nm[n - 1]);
    if (!array_add(&spectrum->wavelength_nm, &n_nm, &wavelength_nm, sizeof wavelength_nm, err) ||
        !array_add(&spectrum->value, &spectrum->count, &value, sizeof value, err))
        return false;
    if (n == 0) {
        spectrum->kind = SPECTRUM_SAMPLED;
        spectrum->factor = 1;
        spectrum->place = place;
    }
    return true;
}

/* No light has less than 20 nm, nor a table of reflectances more than 20 micrometres, or less than
 * 0.1. */
bool spectrum_is_in_nm(const struct spectrum *spectrum, struct error *err)
{
    const int n = spectrum->count;
    const double longest = n > 0 ? spectrum->wavelength_nm[n - 1] : 20;
    const double first = n > 0 ? spectrum->wavelength_nm[0] : 0;
    /* thermal infrared reaches 300 um; tables in nm that begin below 10 nm do not end there */
    return longest >= (n > 1 && first < 10 ? 300 : 20) ||
           error_at(err, spectrum->place, "expected wavelengths in nm%s",
                    longest < 1e-3 ? "; these look like metres: multiply them by 1e9"
                    : first >= 0.1 ? "; these look like micrometres: multiply them by 1000"
                                   : "");
}

void spectrum_free(struct spectrum *spectrum)
{
    FREE_ALL(spectrum->wavelength_nm, spectrum->value, spectrum->name, spectrum->path);
    *spectrum = (struct spectrum){0};
}

/* ---- daylight ---- */

/* CIE daylight of a correlated colour temperature (CIE 015:2018): a mean and two directions
 * of variation, whose parts M1 and M2 follow from the chromaticity. The CIE rounds M1 and M2 to
 * three decimals, and so does this file. So daylight:6503.616 is D65 to one unit of its sixth
 * digit, and daylight:5002.782 is D50. (6503.616 K is 6500 K times 1.4388/1.4380, the ratio of
 * today's second radiation constant to that of the time when D65 was named.) At the round 6504 K M1
 * is -0.294, and for D65 it is -0.295: daylight:6504 differs from D65 by up to 0.0005, at 410 nm.
 */
static const double coldest = 4000, hottest = 25000;

/* Rounds to three decimals. */
static double round_part(double part)
{
    return floor(part * 1000 + 0.5) / 1000;
}

/* Computes M1 and M2 from the chromaticity x, y. */
static void find_parts(double kelvin, double out[2])
{
    const double t = 1000 / kelvin;
    const double x = kelvin <= 7000 ? ((-4.6070 * t + 2.9678) * t + 0.09911) * t + 0.244063
                                    : ((-2.0064 * t + 1.9018) * t + 0.24748) * t + 0.237040;
    const double y = (-3.000 * x + 2.870) * x - 0.275;
    const double divisor = 0.0241 + 0.2562 * x - 0.7341 * y;
    out[0] = round_part((-1.3515 - 1.7703 * x + 5.9114 * y) / divisor);
    out[1] = round_part((0.0300 - 31.4424 * x + 30.0717 * y) / divisor);
}

static bool read_temperature(const struct word *word, double *out, struct error *err)
{
    if (word->length == 0)
        return error_at(err, word->place,
                        "expected a temperature from %g to %g K, as daylight:6504", coldest,
                        hottest);
    return word_number(word, "temperature", -HUGE_VAL, HUGE_VAL, out, err) &&
           ((*out >= coldest && *out <= hottest) ||
            error_at(err, word->place,
                     *out > 0 && *out < coldest
                         ? "daylight has a temperature from %g to %g K; for %.15g K write "
                           "blackbody:%.15g"
                         : "daylight has a temperature from %g to %g K, not %.15g",
                     coldest, hottest, *out, *out));
}

/* Computes CIE daylight of a correlated colour temperature from 4000 to 25000 K.
 * The first component is 100 at 560 nm, where the others are 0: daylight is 1 there. */
static bool daylight_read(const struct word *temperature, struct spectrum *out, struct error *err)
{
    struct spectrum components[3] = {{0}};
    double kelvin, parts[2];
    bool done = read_temperature(temperature, &kelvin, err) &&
                spectra_read("builtin:daylight/components.csv", 3, components, NULL, err);
    if (done)
        find_parts(kelvin, parts);
    for (int i = 0; done && i < components[0].count; i++)
        done = spectrum_append(out, components[0].wavelength_nm[i],
                               (components[0].value[i] + parts[0] * components[1].value[i] +
                                parts[1] * components[2].value[i]) /
                                   100,
                               temperature->place, err);
    for (int i = 0; i < 3; i++)
        spectrum_free(&components[i]);
    return done;
}

/* ---- words ---- */

/* Returns the part of a word from byte `from` to before byte `to`, with its own place. */
static struct word part(const struct word *word, size_t from, size_t to)
{
    struct word out = *word;
    out.start += from;
    out.length = to - from;
    out.place.column += (int)from + word->quoted;
    out.quoted = false;
    return out;
}

/* Splits a word at the last `mark`. Returns false if there is none. */
static bool split(const struct word *word, char mark, struct word *before, struct word *after)
{
    size_t at = word->length;
    while (at > 0 && word->start[at - 1] != mark)
        at--;
    if (at == 0)
        return false;
    *after = part(word, at, word->length);
    *before = part(word, 0, at - 1);
    return true;
}

/* Reads NAME or FILE; behind it may be :COLUMN, the number of a column or a sample, or, where no
 * file has the whole name, its name. */
static bool read_named(const struct word *word, struct wanted *wanted, struct spectrum *out,
                       struct error *err)
{
    struct word before, sample;
    char *path = NULL;
    wanted->table = *word;
    if (!word_file(word, FILE_TABLE, &path, err))
        return false;
    const bool missing = file_is_missing(path);
    free(path);
    if (split(word, ':', &before, &sample) && sample.length > 0) {
        const bool number = strspn(sample.start, "0123456789") >= sample.length;
        if (number || missing) {
            wanted->table.length = before.length;
            wanted->sample = sample;
        }
        if (number && !word_integer(&sample, "column", 1, INT_MAX, &wanted->first, err))
            return false;
    }
    return table_read(wanted, out, NULL, err);
}

static bool read_gaussian(const struct word *word, double parameter[2], struct error *err)
{
    struct word centre, width;
    if (!split(word, ',', &centre, &width))
        return error_at(err, word->place,
                        "a gaussian has a centre and a width in nm, as gaussian:380,40");
    return word_number(&centre, "centre", DBL_MIN, longest_nm, &parameter[0], err) &&
           word_number(&width, "width", DBL_MIN, longest_nm, &parameter[1], err);
}

/* Finds the rest of a word that begins with the name of a formula. */
static bool names_formula(const struct word *word, const char *formula, struct word *rest)
{
    const size_t length = strlen(formula);
    if (word->length < length || strncmp(word->start, formula, length) != 0)
        return false;
    *rest = part(word, length, word->length);
    return true;
}

/* Reads a spectrum without its factor. A light of 1000 to 10^5 is likelier a temperature. */
static bool read_unscaled(const struct word *word, struct wanted *wanted, struct spectrum *out,
                          struct error *err)
{
    const double highest = wanted->scaled ? HUGE_VAL : wanted->highest;
    double *parameter = out->parameter;
    struct word rest;
    if (!word->quoted && word_is_numeric(word, "0123456789+-.eE")) {
        out->kind = SPECTRUM_CONSTANT;
        return word_number(word, "spectrum", wanted->lowest, highest, &parameter[0], err) &&
               (wanted->lowest < 0 || wanted->scaled || parameter[0] < 1000 || parameter[0] > 1e5 ||
                error_at(err, word->place,
                         "the spectrum is %.*s at every wavelength; for a temperature write "
                         "daylight:%.*s or blackbody:%.*s, for the number %.*s*1",
                         word_shown(word), word->start, word_shown(word), word->start,
                         word_shown(word), word->start, word_shown(word), word->start));
    }
    if (names_formula(word, "blackbody:", &rest)) {
        out->kind = SPECTRUM_BLACKBODY;
        return word_number(&rest, "temperature", DBL_MIN, 1e6, &parameter[0], err);
    }
    if (names_formula(word, "daylight:", &rest))
        return daylight_read(&rest, out, err);
    if (!names_formula(word, "gaussian:", &rest))
        return read_named(word, wanted, out, err);
    out->kind = SPECTRUM_GAUSSIAN;
    return read_gaussian(&rest, parameter, err);
}

/* Refuses a spectrum that is too large with its factor. */
static bool check_peak(const struct spectrum *s, double highest, struct error *err)
{
    const double largest = s->factor * peak(s), limit = fmin(highest, DBL_MAX);
    if (!isfinite(largest))
        return error_at(err, s->place, "'%.100s' reaches values that are too large", s->name);
    return largest <= limit ||
           error_at(err, s->place,
                    "'%.100s' reaches %.15g, above %.15g; scale it by a factor, "
                    "as *0.5",
                    s->name, largest, limit);
}

bool spectrum_read(const struct word *word, double lowest, double highest, struct spectrum *out,
                   struct error *err)
{
    struct wanted wanted = {.lowest = lowest, .highest = highest, .factor = 1, .count = 1};
    struct word unscaled = *word, before, number;
    bool done = true;
    *out = (struct spectrum){0};
    if (split(word, '*', &before, &number)) {
        unscaled.length = before.length;
        wanted.scaled = true;
        done = word_number(&number, "factor", 0, HUGE_VAL, &wanted.factor, err);
    }
    done = done && read_unscaled(&unscaled, &wanted, out, err);
    if (done) {
        out->factor = wanted.factor;
        out->place = word->place;
        out->name = word_copy(word, err);
        done = out->name != NULL && check_peak(out, highest, err);
    }
    if (!done)
        spectrum_free(out);
    return done;
}
