/* SPDX-License-Identifier: MIT */
/* Spectra: their values, and the words that name them. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "data/base/base.h"
#include "data/maths/maths.h"
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

/* No light has less than 20 nm, nor a table of reflectances more than 20 micrometres. */
bool spectrum_is_in_nm(const struct spectrum *spectrum, struct error *err)
{
    const double longest = spectrum->count > 0 ? spectrum->wavelength_nm[spectrum->count - 1] : 20;
    if (longest >= 20)
        return true;
    return error_at(err, spectrum->place,
                    "expected wavelengths in nm; these look like %s: multiply them by %s",
                    longest < 1e-3 ? "metres" : "micrometres", longest < 1e-3 ? "1e9" : "1000");
}

void spectrum_free(struct spectrum *spectrum)
{
    FREE_ALL(spectrum->wavelength_nm, spectrum->value, spectrum->name, spectrum->path);
    *spectrum = (struct spectrum){0};
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

static bool is_numeric(const struct word *word)
{
    bool digit = false;
    for (size_t i = 0; i < word->length; i++) {
        if (strchr("0123456789+-.eE", word->start[i]) == NULL)
            return false;
        digit = digit || (word->start[i] >= '0' && word->start[i] <= '9');
    }
    return digit && !word->quoted;
}

/* Reads NAME or FILE, with :COLUMN or without. */
static bool read_named(const struct word *word, struct columns *columns, struct spectrum *out,
                       struct error *err)
{
    struct word before, digits;
    bool xyz;
    columns->table = *word;
    if (split(word, ':', &before, &digits) && digits.length > 0 &&
        strspn(digits.start, "0123456789") >= digits.length) {
        columns->table.length = before.length;
        if (!word_integer(&digits, "column", 1, INT_MAX, &columns->first, err))
            return false;
    }
    return table_read(columns, out, &xyz, err);
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

/* Reads a spectrum without its factor. */
static bool read_unscaled(const struct word *word, struct columns *columns, struct spectrum *out,
                          struct error *err)
{
    const double highest = columns->scaled ? HUGE_VAL : columns->highest;
    double *parameter = out->parameter;
    struct word rest;
    if (is_numeric(word)) {
        out->kind = SPECTRUM_CONSTANT;
        return word_number(word, "spectrum", columns->lowest, highest, &parameter[0], err);
    }
    if (names_formula(word, "blackbody:", &rest)) {
        out->kind = SPECTRUM_BLACKBODY;
        return word_number(&rest, "temperature", DBL_MIN, 1e6, &parameter[0], err);
    }
    if (names_formula(word, "daylight:", &rest))
        return daylight_read(&rest, out, err);
    if (!names_formula(word, "gaussian:", &rest))
        return read_named(word, columns, out, err);
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
    struct columns columns = {.lowest = lowest, .highest = highest, .factor = 1, .count = 1};
    struct word unscaled = *word, before, number;
    bool done = true;
    *out = (struct spectrum){0};
    if (word->quoted && word->start[word->length] != '"')
        return error_at(err, word->place, "a quote must be closed on its line");
    if (split(word, '*', &before, &number)) {
        unscaled.length = before.length;
        columns.scaled = true;
        done = word_number(&number, "factor", 0, HUGE_VAL, &columns.factor, err);
    }
    done = done && read_unscaled(&unscaled, &columns, out, err);
    if (done) {
        out->factor = columns.factor;
        out->place = word->place;
        out->name = word_copy(word, err);
        done = out->name != NULL && check_peak(out, highest, err);
    }
    if (!done)
        spectrum_free(out);
    return done;
}
