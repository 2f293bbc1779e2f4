/* SPDX-License-Identifier: MIT */
/* Spectra: constants, tables in three formats, and two formulas. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/maths/maths.h"
#include "data/names/names.h"
#include "data/spectra/spectra.h"

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

void spectrum_free(struct spectrum *spectrum)
{
    free(spectrum->wavelength_nm);
    free(spectrum->value);
    free(spectrum->name);
    *spectrum = (struct spectrum){0};
}

/* ---- tables ---- */

enum { MAX_COLUMNS = 3 }; /* kept of a row: those of a detector */

/* A file that is being read into spectra. */
struct table {
    struct text text;
    const struct word *word; /* that names the file */
    long column;             /* the first one wanted; 0: the file has exactly n_out */
    long n_columns;          /* of values; 0: not known before the first row */
    double lowest, highest;
    struct spectrum *out; /* one a column */
    int n_out;
    bool xyz; /* the header names three columns x, y and z */
};

static bool begins(const struct word *word, const char *with)
{
    return word->length >= strlen(with) && strncmp(word->start, with, strlen(with)) == 0;
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

/* Keeps the number of columns, or refuses it. */
static bool check_columns(struct table *table, long n_columns, struct place place,
                          struct error *err)
{
    const int length = (int)table->word->length;
    const char *start = table->word->start;
    table->n_columns = n_columns;
    if (table->column > n_columns)
        return error_at(err, table->word->place, "'%.*s' has no value column %ld; its last is %ld",
                        length, start, table->column, n_columns);
    if (table->n_out > 1 && table->n_out != n_columns)
        return error_at(err, place, "%ld value columns; a detector has %d, as 'wavelength,x,y,z'",
                        n_columns, table->n_out);
    if (table->column == 0 && n_columns > table->n_out)
        return error_at(err, table->word->place,
                        "'%.*s' has %ld value columns; write '%.*s:1' for the first of them",
                        length, start, n_columns, length, start);
    return true;
}

/* Reads the next word of the file, on this line or a later one. */
static bool next_word(struct text *text, struct word *out)
{
    while (!text_word(text, out))
        if (!text_next_line(text))
            return false;
    return true;
}

/* Reads the rest of a row: a wavelength and one or more values. */
static bool read_row(struct table *table, const struct word *first, struct error *err)
{
    const long wanted = table->column > 0 ? table->column : 1;
    double nm, value, kept[MAX_COLUMNS] = {0};
    struct word word;
    long n = 0;
    if (!word_number(first, "wavelength", -HUGE_VAL, HUGE_VAL, &nm, err))
        return false;
    while (text_word(&table->text, &word)) {
        const bool keep = ++n >= wanted && n < wanted + table->n_out;
        if (!word_number(&word, "value", keep ? table->lowest : -HUGE_VAL,
                         keep ? table->highest : HUGE_VAL, &value, err))
            return false;
        if (keep)
            kept[n - wanted] = value;
    }
    if (n == 0)
        return error_at(err, text_place(&table->text), "expected a value after the wavelength");
    if (table->out->count == 0 && !check_columns(table, n, first->place, err))
        return false;
    if (n != table->n_columns)
        return error_at(err, first->place, "this row has %ld values, the first row has %ld", n,
                        table->n_columns);
    for (int i = 0; i < table->n_out; i++)
        if (!spectrum_append(&table->out[i], nm, kept[i], first->place, err))
            return false;
    return true;
}

/* Skips the words above the columns. A line is no such header if its first word begins like a
 * number, or another word is one: it is then a row with a mistake in it. */
static void skip_header(struct table *table)
{
    struct text *text = &table->text;
    struct word word;
    int n = 0, named = 0;
    bool header = text_word(text, &word) && !word_begins_number(&word);
    while (header && text_word(text, &word)) {
        header = !is_numeric(&word);
        named += n < 3 && word.length == 1 && word.start[0] == "xyz"[n];
        n++;
    }
    table->xyz = header && n == 3 && named == 3;
    if (!header)
        text->at = text->line_start;
}

static bool read_columns(struct table *table, struct error *err)
{
    struct word first;
    table->text.separators = ",;";
    skip_header(table);
    while (next_word(&table->text, &first))
        if (!read_row(table, &first, err))
            return false;
    return true;
}

/* The words of a CGATS file that describe its data. */
enum { BANDS, START_NM, END_NM, NORM, CGATS_WORDS };
static const char *const cgats_words[] = {"SPECTRAL_BANDS", "SPECTRAL_START_NM", "SPECTRAL_END_NM",
                                          "SPECTRAL_NORM"};

static bool check_cgats(const double *head, struct place place, struct error *err)
{
    for (int i = BANDS; i <= END_NM; i++)
        if (head[i] == 0)
            return error_at(err, place, "%s is missing before the data", cgats_words[i]);
    if (head[BANDS] > 1 ? head[START_NM] < head[END_NM] : head[START_NM] == head[END_NM])
        return true;
    return error_at(err, place, "%.15g bands from %.15g to %.15g nm; they must increase",
                    head[BANDS], head[START_NM], head[END_NM]);
}

/* Adds the values up to END_DATA, on any number of lines. */
static bool read_data(struct table *table, const double *head, struct place begin,
                      struct error *err)
{
    const double norm = head[NORM], bands = head[BANDS], span = head[END_NM] - head[START_NM];
    struct word word;
    double value;
    while (next_word(&table->text, &word)) {
        const int i = table->out->count;
        const double nm = head[START_NM] + (i > 0 ? span * i / (bands - 1) : 0);
        if (word_is(&word, "END_DATA"))
            return i == bands ||
                   error_at(err, word.place, "%d values, but SPECTRAL_BANDS is %.15g", i, bands);
        if (i >= bands)
            return error_at(err, word.place, "more values than SPECTRAL_BANDS, %.15g", bands);
        if (!word_number(&word, "value", table->lowest * norm, table->highest * norm, &value,
                         err) ||
            !spectrum_append(table->out, nm, value / norm, word.place, err))
            return false;
    }
    return error_at(err, begin, "BEGIN_DATA without END_DATA");
}

/* Some programs write numbers in quotes. */
static bool read_cgats_number(struct text *text, const char *name, double *out, struct error *err)
{
    struct word word;
    if (!text_expect(text, &word, name, err))
        return false;
    word.quoted = false;
    return word_number(&word, name, DBL_MIN, HUGE_VAL, out, err) && text_end(text, name, err);
}

/* Reads a CGATS file. Skips all words that do not describe its data. */
static bool read_cgats(struct table *table, struct error *err)
{
    double head[CGATS_WORDS] = {[NORM] = 1}; /* 0: missing */
    struct word word;
    bool done = check_columns(table, 1, text_whole(&table->text), err);
    while (done && next_word(&table->text, &word)) {
        if (word_is(&word, "BEGIN_DATA"))
            done = check_cgats(head, word.place, err) && read_data(table, head, word.place, err);
        for (int i = 0; i < CGATS_WORDS; i++)
            if (word_is(&word, cgats_words[i]))
                done = read_cgats_number(&table->text, cgats_words[i], &head[i], err);
    }
    return done;
}

/* Reads a file in the format that its first word implies. */
static bool read_file(const char *path, struct table *table, struct error *err)
{
    struct text *text = &table->text;
    struct word first;
    bool done = true;
    if (!text_open(text, path, table->word->place, err))
        return false;
    if (next_word(text, &first)) {
        text->at = text->line_start;
        done = word_is(&first, "SPECT") || begins(&first, "CGATS") || begins(&first, "SPECTRAL_")
                   ? read_cgats(table, err)
                   : read_columns(table, err);
    }
    if (done && table->out->count == 0)
        done = error_at(err, text_whole(text), "no samples; a spectrum needs at least one");
    text_free(text);
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

bool table_is_detector(const struct builtin_file *file)
{
    return strncmp(file->name, "tables/", 7) == 0 &&
           (strstr((const char *)file->bytes, "\nwavelength_nm,x,y,z\n") != NULL ||
            strstr((const char *)file->bytes, "\nwavelength_nm,r,g,b\n") != NULL);
}

static bool refuse_unknown(const struct table *table, struct error *err)
{
    const bool detector = table->n_out > 1;
    const struct word *word = table->word;
    struct suggestion suggestion = {.distance = 0};
    char known[BUILTIN_NAME];
    for (size_t i = 0; i < builtin_file_count; i++)
        if (builtin_is(&builtin_files[i], FILE_TABLE, known) &&
            table_is_detector(&builtin_files[i]) == detector && !strchr(known, '/'))
            suggestion_add(&suggestion, word, known, strlen(known));
    return error_at(
        err, word->place, "no built-in %s and no file '%.*s'; %s",
        detector ? "detector" : "spectrum", word_shown(word), word->start,
        suggestion_end(&suggestion, detector ? "it is a file of a wavelength and three values a "
                                               "line, or one of"
                                             : "it is a number, a file, blackbody:KELVIN, "
                                               "gaussian:CENTRE,WIDTH, or one of"));
}

/* Reads the built-in table, or the file, that table->word names. */
static bool read_table(struct table *table, struct error *err)
{
    char *path;
    bool done = word_file(table->word, FILE_TABLE, &path, err) &&
                (file_is_missing(path) ? refuse_unknown(table, err) : read_file(path, table, err));
    free(path);
    return done;
}

/* Reads NAME or FILE, with :COLUMN or without. */
static bool read_named(const struct word *word, double lowest, double highest, struct spectrum *out,
                       struct error *err)
{
    struct word stem = *word, before, digits;
    struct table table = {
        .word = &stem, .lowest = lowest, .highest = highest, .out = out, .n_out = 1};
    if (split(word, ':', &before, &digits) && digits.length > 0 &&
        strspn(digits.start, "0123456789") >= digits.length) {
        stem.length = before.length;
        if (!word_integer(&digits, "column", 1, INT_MAX, &table.column, err))
            return false;
    }
    return read_table(&table, err);
}

bool spectra_read(const char *name, struct spectrum out[3], bool *xyz, struct error *err)
{
    const struct word word = {.start = name, .length = strlen(name)};
    struct table table = {
        .word = &word, .lowest = -HUGE_VAL, .highest = HUGE_VAL, .out = out, .n_out = 3};
    bool done = read_table(&table, err);
    *xyz = table.xyz;
    return done;
}

/* Reads a spectrum without its factor. */
static bool read_unscaled(const struct word *word, double lowest, double highest,
                          struct spectrum *out, struct error *err)
{
    static const char blackbody_prefix[] = "blackbody:", gaussian_prefix[] = "gaussian:";
    double *parameter = out->parameter;
    struct word rest, centre, width;
    if (is_numeric(word)) {
        out->kind = SPECTRUM_CONSTANT;
        return word_number(word, "spectrum", lowest, highest, &parameter[0], err);
    }
    if (begins(word, blackbody_prefix)) {
        rest = part(word, strlen(blackbody_prefix), word->length);
        out->kind = SPECTRUM_BLACKBODY;
        return word_number(&rest, "temperature", DBL_MIN, 1e6, &parameter[0], err);
    }
    if (!begins(word, gaussian_prefix))
        return read_named(word, lowest, highest, out, err);
    rest = part(word, strlen(gaussian_prefix), word->length);
    out->kind = SPECTRUM_GAUSSIAN;
    if (!split(&rest, ',', &centre, &width))
        return error_at(err, rest.place,
                        "a gaussian has a centre and a width in nm, as gaussian:380,40");
    return word_number(&centre, "centre", DBL_MIN, longest_nm, &parameter[0], err) &&
           word_number(&width, "width", DBL_MIN, longest_nm, &parameter[1], err);
}

/* Refuses a spectrum that is too large with its factor. Samples and constants are already in range
 * without it. */
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
    struct word unscaled = *word, before, number;
    double factor = 1;
    bool done = true;
    *out = (struct spectrum){0};
    if (word->quoted && word->start[word->length] != '"')
        return error_at(err, word->place, "a quote must be closed on its line");
    if (split(word, '*', &before, &number)) {
        unscaled.length = before.length;
        done = word_number(&number, "factor", 0, HUGE_VAL, &factor, err);
    }
    done = done && read_unscaled(&unscaled, lowest, highest, out, err);
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
