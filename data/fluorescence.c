/* SPDX-License-Identifier: MIT */
/* Fluorescence: what of a light is taken in, summed over the wavelengths of both the light and what
 * takes it in, so that neither a line between the samples of an excitation nor an excitation
 * between those of a light is lost; and the matrix that says where it is given out. */
#include "scene.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* ---- the wavelengths of two spectra ---- */

/* Wavelengths that do not decrease: a table's, or evenly spaced ones about a centre. */
struct series {
    const double *table; /* NULL: evenly spaced */
    double centre, step;
    int count;
};

/* What shows the course of a spectrum; smooth ones need nothing. At 4 widths from its centre a
 * gaussian is down to 2^-64, which no sum shows. */
static struct series series_of(const struct spectrum *spectrum)
{
    struct series out = {0};
    if (spectrum->kind == SPECTRUM_SAMPLED)
        out = (struct series){.table = spectrum->wavelength_nm, .count = spectrum->count};
    if (spectrum->kind == SPECTRUM_GAUSSIAN)
        out = (struct series){NULL, spectrum->parameter[0], spectrum->parameter[1] / 40, 321};
    return out;
}

static double series_at(const struct series *series, int i)
{
    return series->table != NULL ? series->table[i]
                                 : series->centre + (i - series->count / 2) * series->step;
}

/* A walk over the positive wavelengths of two series, equal ones once. */
struct walk {
    struct series series[2];
    int index[2];
    double first, last;
    double before, nm, after; /* 0 and HUGE_VAL: none */
    double weight;            /* how many nm the wavelength stands for */
};

/* The next wavelength above `after`. */
static double walk_peek(struct walk *walk)
{
    double least = HUGE_VAL;
    for (int k = 0; k < 2; k++) {
        const struct series *series = &walk->series[k];
        int *i = &walk->index[k];
        while (*i < series->count &&
               (series_at(series, *i) <= walk->after || series_at(series, *i) < walk->first))
            ++*i;
        if (*i < series->count)
            least = fmin(least, series_at(series, *i));
    }
    return least <= walk->last ? least : HUGE_VAL;
}

/* Within the samples of `within`, if it has any: as all else counts for nothing there, it must not
 * change what the ends stand for. Two smooth spectra are taken every nm over the visible range. */
static struct walk walk_start(const struct spectrum *within, const struct spectrum *other)
{
    struct walk walk = {.series = {series_of(within), series_of(other)}, .last = DBL_MAX};
    if (within->kind == SPECTRUM_SAMPLED) {
        walk.first = within->wavelength_nm[0];
        walk.last = within->wavelength_nm[within->count - 1];
    }
    if (walk.series[0].count + walk.series[1].count == 0)
        walk.series[0] = (struct series){NULL, 540, 1, 481}; /* 300 to 780 */
    walk.after = walk_peek(&walk);
    return walk;
}

/* False at the end. */
static bool walk_step(struct walk *walk)
{
    double left, right;
    walk->before = walk->nm;
    walk->nm = walk->after;
    if (walk->nm == HUGE_VAL)
        return false;
    walk->after = walk_peek(walk);
    left = walk->nm - walk->before;
    right = walk->after - walk->nm;
    if (walk->before == 0)
        left = right < HUGE_VAL ? right : 1;
    if (right == HUGE_VAL)
        right = left;
    walk->weight = (left + right) / 2;
    return true;
}

/* ---- what is taken in ---- */

/* Sums relative to the largest values, so that they neither overflow nor vanish. */
struct intake {
    double largest_light, largest_excitation;
    double product, excitation;
};

static double relative(double value, double largest)
{
    return largest > 0 ? value / largest : 0;
}

static struct intake take_in(const struct spectrum *light, const struct spectrum *excitation)
{
    struct intake out = {0};
    for (struct walk walk = walk_start(excitation, light); walk_step(&walk);) {
        out.largest_light = fmax(out.largest_light, spectrum_at(light, walk.nm, SPECTRUM_ZERO));
        out.largest_excitation =
            fmax(out.largest_excitation, spectrum_at(excitation, walk.nm, SPECTRUM_ZERO));
    }
    for (struct walk walk = walk_start(excitation, light); walk_step(&walk);) {
        const double share = walk.weight * relative(spectrum_at(excitation, walk.nm, SPECTRUM_ZERO),
                                                    out.largest_excitation);
        out.product +=
            share * relative(spectrum_at(light, walk.nm, SPECTRUM_ZERO), out.largest_light);
        out.excitation += share;
    }
    return out;
}

/* Never above the light's largest value: rounding keeps product <= excitation. A blackbody as
 * excitation may be 0 at all of the light's wavelengths. */
double excitation_mean(const struct spectrum *light, const struct spectrum *excitation)
{
    const struct intake in = take_in(light, excitation);
    return in.largest_light * relative(in.product, in.excitation);
}

/* ---- the matrix ---- */

enum { LARGEST_MATRIX = 4096 }; /* rows, and columns */

/* A matrix being read. */
struct table {
    struct text text, header;             /* header: the cursor before the first column */
    struct spectrum excitation, emission; /* their wavelengths; the values are 0 */
    double *share;
};

static bool read_wavelength(const struct word *word, const char *what, struct spectrum *axis,
                            struct error *err)
{
    double nm;
    if (axis->count == LARGEST_MATRIX)
        return error_at(err, word->place, "a matrix has at most %d %ss", LARGEST_MATRIX, what);
    return word_number(word, what, -HUGE_VAL, HUGE_VAL, &nm, err) &&
           spectrum_append(axis, nm, 0, word->place, err);
}

static bool read_header(struct table *table, struct error *err)
{
    struct text *text = &table->text;
    struct word word;
    while (!text_peek(*text, &word))
        if (!text_next_line(text))
            return error_at(err, text_whole(text), "no rows; a matrix needs two at least");
    if (!text_expect(text, &word, "a word", err))
        return false;
    if (word_begins_number(&word))
        return error_at(
            err, word.place,
            "expected a word, such as nm, before the excitation wavelengths, not '%.*s'",
            word_shown(&word), word.start);
    table->header = *text;
    while (text_word(text, &word))
        if (!read_wavelength(&word, "excitation wavelength", &table->excitation, err))
            return false;
    return table->excitation.count > 0 ||
           error_at(err, text_place(text), "expected an excitation wavelength");
}

static bool read_row(struct table *table, const struct word *first, struct error *err)
{
    const int columns = table->excitation.count, row = table->emission.count;
    struct word word;
    if (!read_wavelength(first, "emission wavelength", &table->emission, err))
        return false;
    for (int i = 0; i < columns; i++) {
        double *more = array_more(table->share, row * columns + i, sizeof *more, err);
        if (more == NULL)
            return false;
        table->share = more;
        if (!text_expect(&table->text, &word, "a share for each excitation wavelength", err) ||
            !word_number(&word, "share", 0, 1, &more[row * columns + i], err))
            return false;
    }
    return text_end(&table->text, "this row", err);
}

static bool read_rows(struct table *table, struct error *err)
{
    struct word word;
    while (text_next_line(&table->text))
        if (text_word(&table->text, &word) && !read_row(table, &word, err))
            return false;
    return true;
}

static bool refuse_column(const struct table *table, int column, double given, double taken,
                          struct error *err)
{
    struct text header = table->header;
    struct word word = {0};
    for (int i = 0; i <= column; i++)
        text_word(&header, &word);
    return error_at(err, word.place,
                    "at %.15g nm the matrix gives out %.15g of the light, but the surface takes in "
                    "only %.15g (1 - diffuse)",
                    table->excitation.wavelength_nm[column], given, taken);
}

/* Decimal shares may add up to 1 - diffuse exactly. Half an epsilon a rounding: one a row for the
 * sum, and up to ten for the shares as read, the diffuse reflectance and its difference to 1. */
static bool check_shares(const struct table *table, const struct spectrum *diffuse,
                         struct error *err)
{
    const int columns = table->excitation.count, rows = table->emission.count;
    const double slack = (rows + 10) * (DBL_EPSILON / 2);
    double all = 0;
    for (int i = 0; i < columns; i++) {
        const double nm = table->excitation.wavelength_nm[i];
        const double taken = 1 - spectrum_at(diffuse, nm, SPECTRUM_HOLD);
        double given = 0;
        for (int j = 0; j < rows; j++)
            given += table->share[j * columns + i];
        if (given > taken + slack)
            return refuse_column(table, i, given, taken, err);
        all += given;
    }
    return all > 0 || error_at(err, text_whole(&table->text),
                               "no share is above 0; rows of an emission wavelength and its shares "
                               "follow the first");
}

bool donaldson_read(const char *path, struct place from, const struct spectrum *diffuse,
                    struct donaldson *out, struct error *err)
{
    struct table table = {0};
    bool done;
    *out = (struct donaldson){0};
    if (!text_open(&table.text, path, from, err))
        return false;
    table.text.separators = ",;";
    done = read_header(&table, err) && read_rows(&table, err) && check_shares(&table, diffuse, err);
    *out = (struct donaldson){table.excitation.count, table.emission.count,
                              table.excitation.wavelength_nm, table.emission.wavelength_nm,
                              table.share};
    table.excitation.wavelength_nm = table.emission.wavelength_nm = NULL; /* taken over */
    spectrum_free(&table.excitation);
    spectrum_free(&table.emission);
    text_free(&table.text);
    if (!done)
        donaldson_free(out);
    return done;
}

/* A row is a spectrum of what is taken in to be given out there. */
bool donaldson_emission(const struct donaldson *matrix, const struct spectrum *light,
                        struct spectrum *out, struct error *err)
{
    const struct spectrum none = {0}, emission = {.kind = SPECTRUM_SAMPLED,
                                                  .count = matrix->n_emission,
                                                  .wavelength_nm = matrix->emission_nm};
    struct spectrum row = {.kind = SPECTRUM_SAMPLED,
                           .factor = 1,
                           .count = matrix->n_excitation,
                           .wavelength_nm = matrix->excitation_nm,
                           .value = matrix->share};
    bool done = true;
    *out = (struct spectrum){0};
    for (struct walk walk = walk_start(&emission, &none); done && walk_step(&walk);) {
        const struct intake in = take_in(light, &row);
        const double value = in.largest_excitation * (in.product / walk.weight) * in.largest_light;
        done = spectrum_append(out, walk.nm, value, light->place, err);
        row.value += row.count;
    }
    done = done && string_copy("donaldson", &out->name, err);
    if (!done)
        spectrum_free(out);
    return done;
}

void donaldson_free(struct donaldson *matrix)
{
    free(matrix->excitation_nm);
    free(matrix->emission_nm);
    free(matrix->share);
    *matrix = (struct donaldson){0};
}
