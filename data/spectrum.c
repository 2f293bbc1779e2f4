/* SPDX-License-Identifier: MIT */
/* Spectra: constants, tables in three formats, and two formulas. The formulas use an exponential of
 * our own, for the C libraries' differ in the last bit and pictures must not. */
#include "spectral.h"

#include <errno.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double smallest_positive = DBL_MIN;

/* Beyond a millimetre nothing is light; the bound keeps sums and steps of wavelengths finite. */
static const double longest_nm = 1e6;

/* ---- values ---- */

/* e^r - 1 for |r| <= ln(2) / 2 by its series. The first term left out, r^15 / 15! < 1e-19, is below
 * the last bit of the sum. */
static double exponential_series(double r)
{
    double sum = 1;
    for (int k = 14; k > 1; k--)
        sum = 1 + r * sum / k;
    return r * sum;
}

/* e^x as (1 + fraction) 2^power. ln 2 comes in two parts: the first has 32 zeros at its end, so
 * that its product with a power of at most 12 bits is exact. */
static double reduce(double x, int *power)
{
    const double ln2_high = 0x1.62e42feep-1, ln2_low = 0x1.a39ef35793c76p-33;
    double n = floor(x / (ln2_high + ln2_low) + 0.5);
    *power = (int)n;
    return exponential_series((x - n * ln2_high) - n * ln2_low);
}

/* Outside these bounds e^x is no finite positive double. */
static double exponential(double x)
{
    int power;
    double fraction;
    if (x < -746)
        return 0;
    if (x > 710)
        return HUGE_VAL;
    fraction = reduce(x, &power);
    return ldexp(1 + fraction, power);
}

/* 1 - e^-x for x >= 0, without cancellation near 0. From 40 on, e^-x < 2^-54 does not show. */
static double one_minus_decay(double x)
{
    int power;
    double fraction;
    if (x > 40)
        return 1;
    fraction = reduce(-x, &power);
    return power == 0 ? -fraction : 1 - ldexp(1 + fraction, power);
}

/* Planck's radiance over that at 560 nm: (560/nm)^5 (e^x0 - 1) / (e^x - 1), x = c2 / (nm T). With
 * e^x taken out of both, nothing overflows on the way to a result that fits. */
static double blackbody(double temperature, double nm)
{
    const double c2 = 1.4387768775039338e7; /* h c / k in nm K, exact in CODATA 2018 */
    double x0 = c2 / (560 * temperature), x = c2 / (nm * temperature), q = 560 / nm;
    double ratio = exponential(x0 - x);
    if (ratio == 0) /* q^5 may be infinite there */
        return 0;
    return q * q * q * q * q * ratio * one_minus_decay(x0) / one_minus_decay(x);
}

static double gaussian(double centre, double width, double nm)
{
    const double four_ln2 = 2.772588722239781237668928485832706;
    double u = (nm - centre) / width;
    return exponential(-four_ln2 * u * u);
}

/* Linear from the nearer sample: so the ends are met exactly and never passed by rounding. */
static double interpolate(const struct spectrum *s, double nm)
{
    int low = 0, high = s->count - 1;
    double span, slope;
    while (high - low > 1) {
        int middle = low + (high - low) / 2;
        if (s->wavelength_nm[middle] <= nm)
            low = middle;
        else
            high = middle;
    }
    if (nm == s->wavelength_nm[low])
        return s->value[low];
    span = s->wavelength_nm[high] - s->wavelength_nm[low];
    slope = s->value[high] - s->value[low];
    if (nm - s->wavelength_nm[low] < s->wavelength_nm[high] - nm)
        return s->value[low] + slope * ((nm - s->wavelength_nm[low]) / span);
    return s->value[high] - slope * ((s->wavelength_nm[high] - nm) / span);
}

static double sampled(const struct spectrum *s, double nm, enum spectrum_ends ends)
{
    if (!spectrum_extrapolates(s, nm))
        return interpolate(s, nm);
    if (ends == SPECTRUM_ZERO)
        return 0;
    return nm < s->wavelength_nm[0] ? s->value[0] : s->value[s->count - 1];
}

double spectrum_at(const struct spectrum *spectrum, double wavelength_nm, enum spectrum_ends ends)
{
    const double *parameter = spectrum->parameter;
    switch (spectrum->kind) {
    case SPECTRUM_CONSTANT:
        return spectrum->factor * parameter[0];
    case SPECTRUM_SAMPLED:
        return spectrum->factor * sampled(spectrum, wavelength_nm, ends);
    case SPECTRUM_BLACKBODY:
        return spectrum->factor * blackbody(parameter[0], wavelength_nm);
    case SPECTRUM_GAUSSIAN:
        return spectrum->factor * gaussian(parameter[0], parameter[1], wavelength_nm);
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

/* The largest value without the factor. A blackbody's is at Wien's wavelength. */
static double peak(const struct spectrum *s)
{
    const double wien = 2.897771955e6; /* b in nm K, CODATA 2018 */
    double largest;
    if (s->kind == SPECTRUM_BLACKBODY)
        return blackbody(s->parameter[0], wien / s->parameter[0]);
    if (s->kind == SPECTRUM_GAUSSIAN)
        return 1;
    if (s->kind == SPECTRUM_CONSTANT)
        return s->parameter[0];
    largest = s->value[0];
    for (int i = 1; i < s->count; i++)
        largest = fmax(largest, s->value[i]);
    return largest;
}

/* ---- storage ---- */

/* Room for one more. A count that is a power of two has filled its arrays: they double. */
static bool grow(struct spectrum *s, struct error *err)
{
    size_t room = s->count > 0 ? 2 * (size_t)s->count : 1;
    double *wavelengths, *values;
    if ((s->count & (s->count - 1)) != 0)
        return true;
    if (s->count > INT_MAX / 2 || room > SIZE_MAX / sizeof(double))
        return error_memory(err);
    wavelengths = realloc(s->wavelength_nm, room * sizeof(double));
    if (wavelengths == NULL)
        return error_memory(err);
    s->wavelength_nm = wavelengths;
    values = realloc(s->value, room * sizeof(double));
    if (values == NULL)
        return error_memory(err);
    s->value = values;
    return true;
}

bool spectrum_append(struct spectrum *spectrum, double wavelength_nm, double value,
                     struct place place, struct error *err)
{
    if (!(wavelength_nm > 0 && wavelength_nm < longest_nm))
        return error_at(err, place, "wavelength %.15g nm; it lies between 0 and %.15g nm",
                        wavelength_nm, longest_nm);
    /* Half the range, so that the difference of two values is finite. */
    if (!(fabs(value) <= DBL_MAX / 2))
        return error_at(err, place, "value %.15g at %.15g nm is too large", value, wavelength_nm);
    if (spectrum->count > 0 && wavelength_nm <= spectrum->wavelength_nm[spectrum->count - 1])
        return error_at(err, place,
                        "wavelength %.15g nm follows %.15g nm; wavelengths must increase",
                        wavelength_nm, spectrum->wavelength_nm[spectrum->count - 1]);
    if (!grow(spectrum, err))
        return false;
    if (spectrum->kind == SPECTRUM_NONE) {
        spectrum->kind = SPECTRUM_SAMPLED;
        spectrum->factor = 1;
        spectrum->place = place;
    }
    spectrum->wavelength_nm[spectrum->count] = wavelength_nm;
    spectrum->value[spectrum->count] = value;
    spectrum->count++;
    return true;
}

bool spectrum_copy(const struct spectrum *from, struct spectrum *out, struct error *err)
{
    bool done = true;
    *out = (struct spectrum){0};
    for (int i = 0; done && i < from->count; i++)
        done = spectrum_append(out, from->wavelength_nm[i], from->value[i], from->place, err);
    out->kind = from->kind;
    out->parameter[0] = from->parameter[0];
    out->parameter[1] = from->parameter[1];
    out->factor = from->factor;
    out->place = from->place;
    if (done && from->name != NULL) {
        out->name = strdup(from->name);
        done = out->name != NULL || error_memory(err);
    }
    if (!done)
        spectrum_free(out);
    return done;
}

void spectrum_free(struct spectrum *spectrum)
{
    free(spectrum->wavelength_nm);
    free(spectrum->value);
    free(spectrum->name);
    *spectrum = (struct spectrum){0};
}

/* ---- tables ---- */

/* A file being read into a spectrum. */
struct table {
    struct text text;
    const struct word *word; /* that asks for it */
    long column;             /* asked for; 0: none, so that the file must have one only */
    long n_columns;          /* of values; 0: not known before the first row */
    double lowest, highest;
    struct spectrum *out;
};

/* Finds the first line with a word and goes to its beginning. */
static bool first_line(struct table *table, struct word *word, struct error *err)
{
    while (text_next_line(&table->text))
        if (text_word(&table->text, word)) {
            table->text.at = table->text.line_start;
            return true;
        }
    return error_at(err, text_whole(&table->text), "no samples; a spectrum needs at least one");
}

static bool is_numeric(const struct word *word)
{
    bool digit = false;
    if (word->quoted)
        return false;
    for (size_t i = 0; i < word->length; i++) {
        if (strchr("0123456789+-.eE", word->start[i]) == NULL)
            return false;
        digit = digit || (word->start[i] >= '0' && word->start[i] <= '9');
    }
    return digit;
}

static bool check_columns(struct table *table, struct error *err)
{
    int length = (int)table->word->length;
    const char *start = table->word->start;
    if (table->column > table->n_columns)
        return error_at(err, table->word->place, "'%.*s' has no value column %ld; its last is %ld",
                        length, start, table->column, table->n_columns);
    if (table->column == 0 && table->n_columns > 1)
        return error_at(err, table->word->place,
                        "'%.*s' has %ld value columns; write '%.*s:1' for the first of them",
                        length, start, table->n_columns, length, start);
    return true;
}

/* A wavelength and one or more values. */
static bool read_row(struct table *table, struct error *err)
{
    long wanted = table->column > 0 ? table->column : 1, n = 0;
    double nm, value, kept = 0;
    struct word first, word;
    if (!text_expect(&table->text, &first, "a wavelength", err) ||
        !word_number(&first, "wavelength", -HUGE_VAL, HUGE_VAL, &nm, err))
        return false;
    while (text_word(&table->text, &word)) {
        bool keep = ++n == wanted;
        if (!word_number(&word, "value", keep ? table->lowest : -HUGE_VAL,
                         keep ? table->highest : HUGE_VAL, &value, err))
            return false;
        kept = keep ? value : kept;
    }
    if (n == 0)
        return error_at(err, text_place(&table->text), "expected a value after the wavelength");
    if (table->n_columns == 0) {
        table->n_columns = n;
        if (!check_columns(table, err))
            return false;
    }
    if (n != table->n_columns)
        return error_at(err, first.place, "this row has %ld values, the first row has %ld", n,
                        table->n_columns);
    return spectrum_append(table->out, nm, kept, first.place, err);
}

/* The words above the columns. A number among them would be a sample whose wavelength is mistyped,
 * and so would a word that begins like one. */
static bool is_header(struct table *table, const struct word *first)
{
    struct word word;
    bool header = first->quoted || strchr("0123456789+-.", first->start[0]) == NULL;
    while (header && text_word(&table->text, &word))
        header = !is_numeric(&word);
    if (!header)
        table->text.at = table->text.line_start;
    return header;
}

static bool read_columns(struct table *table, const struct word *first, struct error *err)
{
    struct text *text = &table->text;
    struct word word;
    bool row = !is_header(table, first);
    do {
        const char *start = text->at;
        bool blank = !text_word(text, &word);
        text->at = start;
        if (row && !blank && !read_row(table, err))
            return false;
        row = true;
    } while (text_next_line(text));
    return table->out->count > 0 ||
           error_at(err, text_whole(text), "no samples; a spectrum needs at least one");
}

/* What the head of a CGATS file says of its data. */
struct cgats {
    long n_bands;
    double start_nm, end_nm, norm;
    bool has_start, has_end;
};

/* The value of a keyword; writers put numbers in quotes or not. */
static bool read_keyword(struct text *text, const char *what, double lowest, double *out,
                         struct error *err)
{
    struct word word;
    if (!text_expect(text, &word, what, err))
        return false;
    word.quoted = false;
    return word_number(&word, what, lowest, HUGE_VAL, out, err) && text_end(text, what, err);
}

static bool read_bands(struct text *text, long *out, struct error *err)
{
    static const char what[] = "SPECTRAL_BANDS";
    struct word word;
    if (!text_expect(text, &word, what, err))
        return false;
    word.quoted = false;
    return word_integer(&word, what, 1, INT_MAX, out, err) && text_end(text, what, err);
}

/* Adds the values up to END_DATA, over as many lines as they take. */
static bool read_data(struct table *table, const struct cgats *head, struct place begin,
                      struct error *err)
{
    struct text *text = &table->text;
    struct word word;
    double value, span = head->end_nm - head->start_nm;
    do {
        while (text_word(text, &word)) {
            int i = table->out->count;
            double nm = head->start_nm;
            if (word_is(&word, "END_DATA"))
                return i == head->n_bands ||
                       error_at(err, word.place, "%d values, but SPECTRAL_BANDS is %ld", i,
                                head->n_bands);
            if (i == head->n_bands)
                return error_at(err, word.place, "more values than SPECTRAL_BANDS, %ld",
                                head->n_bands);
            if (i > 0)
                nm += span * i / (double)(head->n_bands - 1);
            if (!word_number(&word, "value", table->lowest * head->norm,
                             table->highest * head->norm, &value, err) ||
                !spectrum_append(table->out, nm, value / head->norm, word.place, err))
                return false;
        }
    } while (text_next_line(text));
    return error_at(err, begin, "BEGIN_DATA without END_DATA");
}

static bool check_cgats(const struct cgats *head, struct place place, struct error *err)
{
    const char *missing = head->n_bands == 0 ? "SPECTRAL_BANDS"
                          : !head->has_start ? "SPECTRAL_START_NM"
                          : !head->has_end   ? "SPECTRAL_END_NM"
                                             : NULL;
    if (missing != NULL)
        return error_at(err, place, "%s is missing before the data", missing);
    if (head->n_bands > 1 ? head->start_nm < head->end_nm : head->start_nm == head->end_nm)
        return true;
    return error_at(err, place, "%ld bands from %.15g to %.15g nm; they must increase",
                    head->n_bands, head->start_nm, head->end_nm);
}

static bool skip_format(struct text *text, struct place begin, struct error *err)
{
    struct word word;
    do
        while (text_word(text, &word))
            if (word_is(&word, "END_DATA_FORMAT"))
                return true;
    while (text_next_line(text));
    return error_at(err, begin, "BEGIN_DATA_FORMAT without END_DATA_FORMAT");
}

/* One line of the file, or one of its two blocks; other keywords say nothing about the samples. */
static bool read_statement(struct table *table, struct cgats *head, const struct word *word,
                           struct error *err)
{
    struct text *text = &table->text;
    if (word_is(word, "SPECTRAL_BANDS"))
        return read_bands(text, &head->n_bands, err);
    if (word_is(word, "SPECTRAL_START_NM"))
        return head->has_start = read_keyword(text, "SPECTRAL_START_NM", smallest_positive,
                                              &head->start_nm, err);
    if (word_is(word, "SPECTRAL_END_NM"))
        return head->has_end =
                   read_keyword(text, "SPECTRAL_END_NM", smallest_positive, &head->end_nm, err);
    if (word_is(word, "SPECTRAL_NORM"))
        return read_keyword(text, "SPECTRAL_NORM", smallest_positive, &head->norm, err);
    if (word_is(word, "BEGIN_DATA_FORMAT"))
        return skip_format(text, word->place, err);
    if (!word_is(word, "BEGIN_DATA"))
        return true;
    if (table->out->count > 0)
        return error_at(err, word->place, "a second table of data; a spectrum has one");
    return check_cgats(head, word->place, err) && read_data(table, head, word->place, err);
}

static bool read_cgats(struct table *table, struct error *err)
{
    struct cgats head = {0};
    struct word word;
    head.norm = 1;
    do
        if (text_word(&table->text, &word) && !read_statement(table, &head, &word, err))
            return false;
    while (text_next_line(&table->text));
    return table->out->count > 0 ||
           error_at(err, text_whole(&table->text), "no BEGIN_DATA; a spectrum needs samples");
}

static bool begins(const struct word *word, const char *with)
{
    return word->length >= strlen(with) && strncmp(word->start, with, strlen(with)) == 0;
}

static bool read_file(const char *path, const struct word *word, long column, double lowest,
                      double highest, struct spectrum *out, struct error *err)
{
    struct table table = {.word = word, .column = column, .lowest = lowest, .highest = highest,
                          .out = out};
    struct word first;
    bool done;
    if (!text_open(&table.text, path, word->place, err))
        return false;
    done = first_line(&table, &first, err);
    if (done && (word_is(&first, "SPECT") || begins(&first, "CGATS") ||
                 begins(&first, "SPECTRAL_"))) {
        table.n_columns = 1;
        done = check_columns(&table, err) && read_cgats(&table, err);
    } else if (done) {
        table.text.separators = ",;";
        done = read_columns(&table, &first, err);
    }
    text_free(&table.text);
    return done;
}

/* ---- words ---- */

/* A part of a word, with its own place. */
static struct word part(const struct word *word, size_t from, size_t length)
{
    struct word out = *word;
    out.start += from;
    out.length = length;
    out.place.column += (int)from + word->quoted;
    out.quoted = false;
    return out;
}

/* Where the last `mark` stands; false when there is none. */
static bool find_last(const struct word *word, char mark, size_t *at)
{
    for (size_t i = word->length; i > 0; i--)
        if (word->start[i - 1] == mark) {
            *at = i - 1;
            return true;
        }
    return false;
}

static bool refuse_unknown(const struct word *word, const char *name, struct error *err)
{
    char list[1024] = "";
    size_t used = 0;
    for (size_t i = 0; i < builtin_file_count; i++) {
        const char *file = builtin_files[i].name, *end = strrchr(file, '.');
        if (strncmp(file, "tables/", 7) == 0 && end != NULL && strcmp(end, ".csv") == 0 &&
            used < sizeof list)
            used += (size_t)snprintf(list + used, sizeof list - used, " %.*s",
                                     (int)(end - file - 7), file + 7);
    }
    return error_at(err, word->place,
                    "no built-in spectrum and no file '%.100s'; it is a number, a file, "
                    "blackbody:KELVIN, gaussian:CENTRE,WIDTH or one of%s",
                    name, list);
}

/* NAME or FILE, with :COLUMN or without. */
static bool read_named(const struct word *word, double lowest, double highest,
                       struct spectrum *out, struct error *err)
{
    struct word stem = *word, digits;
    char *name, *path = NULL, builtin[256];
    long column = 0;
    size_t colon;
    bool done = false;
    if (find_last(word, ':', &colon) && colon + 1 < word->length) {
        digits = part(word, colon + 1, word->length - colon - 1);
        if (strspn(digits.start, "0123456789") >= digits.length) {
            stem.length = colon;
            if (!word_integer(&digits, "column", 1, INT_MAX, &column, err))
                return false;
        }
    }
    name = word_copy(&stem);
    if (name != NULL)
        path = builtin_path("tables/", name, ".csv", builtin, sizeof builtin)
                   ? strdup(builtin)
                   : file_relative(word->place.path, name);
    if (path == NULL)
        error_memory(err);
    else if (strncmp(path, "builtin:", 8) != 0 && access(path, F_OK) != 0 && errno == ENOENT)
        refuse_unknown(word, name, err);
    else
        done = read_file(path, &stem, column, lowest, highest, out, err);
    free(name);
    free(path);
    return done;
}

static bool read_gaussian(const struct word *word, struct spectrum *out, struct error *err)
{
    struct word centre, width;
    size_t comma;
    if (!find_last(word, ',', &comma))
        return error_at(err, word->place,
                        "a gaussian has a centre and a width in nm, as gaussian:380,40");
    centre = part(word, 0, comma);
    width = part(word, comma + 1, word->length - comma - 1);
    out->kind = SPECTRUM_GAUSSIAN;
    return word_number(&centre, "centre", smallest_positive, longest_nm, &out->parameter[0],
                       err) &&
           word_number(&width, "width", smallest_positive, longest_nm, &out->parameter[1], err);
}

/* A spectrum without its factor. */
static bool read_body(const struct word *word, double lowest, double highest,
                      struct spectrum *out, struct error *err)
{
    static const char blackbody_prefix[] = "blackbody:", gaussian_prefix[] = "gaussian:";
    size_t prefix;
    struct word rest;
    if (is_numeric(word)) {
        out->kind = SPECTRUM_CONSTANT;
        return word_number(word, "spectrum", lowest, highest, &out->parameter[0], err);
    }
    if (begins(word, blackbody_prefix)) {
        prefix = strlen(blackbody_prefix);
        rest = part(word, prefix, word->length - prefix);
        out->kind = SPECTRUM_BLACKBODY;
        return word_number(&rest, "temperature", smallest_positive, 1e6, &out->parameter[0], err);
    }
    if (begins(word, gaussian_prefix)) {
        prefix = strlen(gaussian_prefix);
        rest = part(word, prefix, word->length - prefix);
        return read_gaussian(&rest, out, err);
    }
    return read_named(word, lowest, highest, out, err);
}

/* The word without *FACTOR, and the factor. */
static bool split_factor(const struct word *word, struct word *body, double *factor,
                         struct error *err)
{
    struct word number;
    size_t star;
    *body = *word;
    *factor = 1;
    if (!find_last(word, '*', &star))
        return true;
    body->length = star;
    number = part(word, star + 1, word->length - star - 1);
    return word_number(&number, "factor", 0, HUGE_VAL, factor, err);
}

/* Samples and constants were held against the range as written; the factor is held against it here,
 * and so are the formulas. */
static bool check_peak(const struct spectrum *s, double highest, struct error *err)
{
    double largest = s->factor * peak(s);
    if (!isfinite(largest))
        return error_at(err, s->place, "'%.100s' reaches values too large for a number", s->name);
    if (largest > highest)
        return error_at(err, s->place, "'%.100s' reaches %.15g, above %.15g; scale it by a factor, "
                        "as *0.5", s->name, largest, highest);
    return true;
}

bool spectrum_read(const struct word *word, double lowest, double highest, struct spectrum *out,
                   struct error *err)
{
    struct word body;
    double factor;
    bool done;
    *out = (struct spectrum){0};
    if (word->quoted && word->start[word->length] != '"')
        return error_at(err, word->place, "a quote must be closed on its line");
    done = split_factor(word, &body, &factor, err) && read_body(&body, lowest, highest, out, err);
    if (done) {
        out->factor = factor;
        out->place = word->place;
        out->name = word_copy(word);
        done = out->name != NULL ? check_peak(out, highest, err) : error_memory(err);
    }
    if (!done)
        spectrum_free(out);
    return done;
}
