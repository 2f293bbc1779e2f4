/* SPDX-License-Identifier: MIT */
/* Fluorescence: what of a light is taken in, summed over the wavelengths of both the light and what
 * takes it in, so that neither a line between the samples of an excitation nor an excitation
 * between those of a light is lost; and the matrix that says where it is given out. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "data/base/base.h"
#include "data/spectra/spectra.h"
#include "data/text/text.h"
#include "spectral.h"

/* ---- the wavelengths of two spectra ---- */

/* The next wavelength where the course of a spectrum shows; HUGE_VAL: none, as in smooth ones. At 4
 * widths from its centre a gaussian is down to 2^-64, which no sum shows. */
static double next_above(const struct spectrum *spectrum, double nm)
{
    if (spectrum->kind == SPECTRUM_GAUSSIAN) {
        const double centre = spectrum->parameter[0], step = spectrum->parameter[1] / 40;
        for (double i = fmax(floor((nm - centre) / step), -160); i <= 160; i++)
            if (centre + i * step > nm)
                return centre + i * step;
    }
    if (spectrum->kind != SPECTRUM_SAMPLED)
        return HUGE_VAL;
    const int next = spectrum_count_up_to(spectrum, nm);
    return next < spectrum->count ? spectrum->wavelength_nm[next] : HUGE_VAL;
}

/* A walk over the positive wavelengths of two spectra, equal ones once. */
struct walk {
    const struct spectrum *within, *other;
    double before, nm, after; /* 0 and HUGE_VAL: none */
    double weight;            /* how many nm the wavelength stands for */
};

/* It stays between the first and the last sample of `within`, if that has any: as all else counts
 * for nothing there, it must not change what the ends stand for. Two smooth spectra are taken every
 * nm over the visible range. */
static double walk_peek(const struct walk *walk, double nm)
{
    const double next = next_above(walk->within, nm), other = next_above(walk->other, nm);
    if (walk->within->kind == SPECTRUM_SAMPLED && (nm == 0 || next == HUGE_VAL))
        return next;
    if (next_above(walk->within, 0) == HUGE_VAL && next_above(walk->other, 0) == HUGE_VAL)
        return nm < 300 ? 300 : nm < 780 ? nm + 1 : HUGE_VAL;
    return fmin(next, other);
}

static struct walk walk_start(const struct spectrum *within, const struct spectrum *other)
{
    struct walk walk = {.within = within, .other = other};
    walk.after = walk_peek(&walk, 0);
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
    walk->after = walk_peek(walk, walk->nm);
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
struct matrix_table {
    struct text text, header; /* header: the cursor before the first column */
    struct donaldson *out;
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

static bool read_header(struct matrix_table *table, struct error *err)
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
        if (!read_wavelength(&word, "excitation wavelength", &table->out->excitation, err))
            return false;
    return table->out->excitation.count > 0 ||
           error_at(err, text_place(text), "expected an excitation wavelength");
}

static bool read_row(struct matrix_table *table, const struct word *first, struct error *err)
{
    const int columns = table->out->excitation.count, row = table->out->emission.count;
    struct word word;
    if (!read_wavelength(first, "emission wavelength", &table->out->emission, err))
        return false;
    for (int i = 0; i < columns; i++) {
        double *more = array_more(table->out->share, row * columns + i, sizeof *more, err);
        if (more == NULL)
            return false;
        table->out->share = more;
        if (!text_expect(&table->text, &word, "a share for each excitation wavelength", err) ||
            !word_number(&word, "share", 0, 1, &more[row * columns + i], err))
            return false;
    }
    return text_end(&table->text, "this row", err);
}

static bool read_rows(struct matrix_table *table, struct error *err)
{
    struct word word;
    while (text_next_line(&table->text))
        if (text_word(&table->text, &word) && !read_row(table, &word, err))
            return false;
    return true;
}

static bool refuse_column(const struct matrix_table *table, int column, double given, double taken,
                          struct error *err)
{
    struct text header = table->header;
    struct word word = {0};
    for (int i = 0; i <= column; i++)
        text_word(&header, &word);
    return error_at(err, word.place,
                    "at %.15g nm the matrix gives out %.15g of the light, but the surface takes in "
                    "only %.15g (1 - diffuse)",
                    table->out->excitation.wavelength_nm[column], given, taken);
}

/* Decimal shares may add up to 1 - diffuse exactly. Half an epsilon a rounding: one a row for the
 * sum, and up to ten for the shares as read, the diffuse reflectance and its difference to 1. */
static bool check_shares(const struct matrix_table *table, const struct spectrum *diffuse,
                         struct error *err)
{
    const int columns = table->out->excitation.count, rows = table->out->emission.count;
    const double slack = (rows + 10) * (DBL_EPSILON / 2);
    double all = 0;
    for (int i = 0; i < columns; i++) {
        const double nm = table->out->excitation.wavelength_nm[i];
        const double taken = 1 - spectrum_at(diffuse, nm, SPECTRUM_HOLD);
        double given = 0;
        for (int j = 0; j < rows; j++)
            given += table->out->share[j * columns + i];
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
    struct matrix_table table = {.out = out};
    *out = (struct donaldson){.share = NULL};
    if (!text_open(&table.text, path, from, err))
        return false;
    table.text.separators = ",;";
    const bool done =
        read_header(&table, err) && read_rows(&table, err) && check_shares(&table, diffuse, err);
    text_free(&table.text);
    if (!done)
        donaldson_free(out);
    return done;
}

/* A row is a spectrum of what is taken in to be given out there. */
bool donaldson_emission(const struct donaldson *matrix, const struct spectrum *light,
                        struct spectrum *out, struct error *err)
{
    const struct spectrum none = {.kind = SPECTRUM_NONE};
    struct spectrum row = matrix->excitation;
    row.value = matrix->share;
    bool done = true;
    *out = (struct spectrum){0};
    for (struct walk walk = walk_start(&matrix->emission, &none); done && walk_step(&walk);) {
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
    spectrum_free(&matrix->excitation);
    spectrum_free(&matrix->emission);
    free(matrix->share);
    *matrix = (struct donaldson){0};
}
