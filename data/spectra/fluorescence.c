/* SPDX-License-Identifier: MIT */
/* Fluorescence: the light that a surface absorbs, and the matrix that says where it emits this
 * light. Sums run over the wavelengths of both the light and the excitation: neither a line between
 * the samples of the excitation nor an excitation between the samples of the light is lost. */
#include <ctype.h>
#include <float.h>

#include "data/spectra/spectra.h"

/* ---- the wavelengths of two spectra ---- */

/* The other spectrum of a walk over the wavelengths of one alone. */
static const struct spectrum none = {.kind = SPECTRUM_NONE};

/* Returns the next wavelength that a sum over the spectrum needs; HUGE_VAL: there is none, as for
 * smooth spectra. A gaussian needs none beyond 4 widths from its centre: there it is below 2^-64,
 * which changes no sum. */
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
    const int next = samples_up_to(spectrum->wavelength_nm, spectrum->count, nm);
    return next < spectrum->count ? spectrum->wavelength_nm[next] : HUGE_VAL;
}

/* A walk over the positive wavelengths of two spectra. Equal wavelengths come once. */
struct walk {
    const struct spectrum *within, *other;
    double nm, after; /* 0 and HUGE_VAL: none */
    double weight;    /* the nm that the wavelength stands for */
};

/* Returns the next wavelength of the walk. It stays between the first and the last sample of
 * `within`, if that has samples: beyond them `within` is 0, and a wavelength there must not change
 * the nm that the ends stand for. The walk takes two smooth spectra every nm from 300 to 780 nm. */
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

/* Returns false at the end. */
static bool walk_step(struct walk *walk)
{
    const double before = walk->nm;
    walk->nm = walk->after;
    if (walk->nm == HUGE_VAL)
        return false;
    walk->after = walk_peek(walk, walk->nm);
    const double right = walk->after - walk->nm;
    const double left = before > 0 ? walk->nm - before : right < HUGE_VAL ? right : 1;
    walk->weight = (left + (right < HUGE_VAL ? right : left)) / 2;
    return true;
}

/* ---- absorption ---- */

/* Sums over values that are divided by the largest, so that they neither overflow nor vanish. */
struct absorption {
    double largest_light, largest_excitation;
    double product, excitation;
};

static double relative(double value, double largest)
{
    return largest > 0 ? value / largest : 0;
}

static struct absorption absorb(const struct spectrum *light, const struct spectrum *excitation)
{
    struct absorption out = {0};
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

/* The mean is never above the light's largest value: rounding keeps product <= excitation. A
 * blackbody as excitation may be 0 at all wavelengths of the light. */
double excitation_mean(const struct spectrum *light, const struct spectrum *excitation)
{
    const struct absorption in = absorb(light, excitation);
    return in.largest_light * relative(in.product, in.excitation);
}

/* ---- the matrix ---- */

/* A matrix that is being read. */
struct matrix_table {
    struct text text, header; /* header: the cursor before the first column */
    bool densities;
    double highest;           /* of the diagonal */
    struct spectrum diagonal; /* the values where the light is emitted at its own wavelength */
    struct donaldson *out;
};

/* Refuses a comma within the digits of a row, if there is none among the excitation wavelengths:
 * read as a separator, it would cut a number in two. */
static bool check_comma(const struct matrix_table *table, const struct word *word,
                        struct error *err)
{
    const char *end = word->start + word->length, *header = table->header.at;
    return end[0] != ',' || !isdigit((unsigned char)end[1]) ||
           memchr(header, ',', strcspn(header, "#\n")) ||
           error_at(err, word->place, "a decimal comma; a matrix has points, as in 0.05");
}

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
            return error_at(err, text_whole(text), "no rows; a matrix needs at least two");
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
    const int columns = table->out->excitation.count;
    int n_shares = table->out->emission.count * columns;
    double share, nm;
    struct word word;
    if (!check_comma(table, first, err) ||
        !read_wavelength(first, "emission wavelength", &table->out->emission, err))
        return false;
    nm = table->out->emission.wavelength_nm[table->out->emission.count - 1];
    for (int i = 0; i < columns; i++) {
        const bool own = table->out->excitation.wavelength_nm[i] == nm;
        if (!text_expect(&table->text, &word, "a share for each excitation wavelength", err) ||
            !check_comma(table, &word, err) ||
            !word_number(&word, own ? "reflectance on the diagonal" : "share", 0,
                         table->densities && !own ? HUGE_VAL : 1, &share, err) ||
            (own && !spectrum_append(&table->diagonal, nm, share, word.place, err)))
            return false;
        table->highest = fmax(table->highest, own ? share : 0);
        share = own ? 0 : share;
        if (!array_add(&table->out->share, &n_shares, &share, sizeof share, err))
            return false;
    }
    return text_end(&table->text, "this row", err);
}

/* The diagonal becomes the diffuse reflectance, unless it is 0. */
static bool take_diagonal(struct matrix_table *table, struct spectrum *diffuse, struct error *err)
{
    if (table->highest == 0)
        return true;
    if (diffuse->kind != SPECTRUM_CONSTANT || spectrum_at(diffuse, 0, SPECTRUM_HOLD) > 0)
        return error_at(err, diffuse->place,
                        "the matrix has reflectances on its diagonal, at %.15g nm and others: "
                        "leave out diffuse, or write 0 there",
                        table->diagonal.wavelength_nm[0]);
    spectrum_free(diffuse);
    *diffuse = table->diagonal;
    table->diagonal = (struct spectrum){.kind = SPECTRUM_NONE};
    return string_copy("diagonal of the matrix", &diffuse->name, err);
}

static bool refuse_column(const struct matrix_table *table, int column, double emitted,
                          double absorbed, struct error *err)
{
    struct text header = table->header;
    struct word word = {0};
    for (int i = 0; i <= column; i++)
        text_word(&header, &word);
    return error_at(err, word.place,
                    "at %.15g nm the matrix emits %.15g of the light, but the surface absorbs only "
                    "%.15g (1 - diffuse)",
                    table->out->excitation.wavelength_nm[column], emitted, absorbed);
}

/* Refuses a column that emits more than 1 - diffuse. Decimal shares may add up to it exactly, so
 * that the slack is half an epsilon a rounding: one for each row of the sum, and up to ten for the
 * shares as read, the diffuse reflectance and its difference to 1. Beyond its ends nobody has
 * measured a diagonal. */
static bool check_shares(const struct matrix_table *table, const struct spectrum *diffuse,
                         struct error *err)
{
    const int columns = table->out->excitation.count, rows = table->out->emission.count;
    const double slack = (rows + 10) * (DBL_EPSILON / 2);
    double all = 0;
    for (int i = 0; i < columns; i++) {
        const double nm = table->out->excitation.wavelength_nm[i];
        const double absorbed =
            1 - spectrum_at(diffuse, nm, table->highest > 0 ? SPECTRUM_ZERO : SPECTRUM_HOLD);
        double emitted = 0;
        for (int j = 0; j < rows; j++)
            emitted += table->out->share[j * columns + i];
        if (emitted > absorbed + slack)
            return refuse_column(table, i, emitted, absorbed, err);
        all += emitted;
    }
    return all > 0 || table->highest > 0 ||
           error_at(err, text_whole(&table->text),
                    "no share is above 0; rows of an emission wavelength and its shares "
                    "follow the first");
}

bool donaldson_read(const char *path, struct place from, bool densities, struct spectrum *diffuse,
                    struct donaldson *out, struct error *err)
{
    struct matrix_table table = {.out = out, .densities = densities};
    struct word word;
    *out = (struct donaldson){.share = NULL};
    if (!text_open(&table.text, path, from, TEXT_LARGE, err))
        return false;
    table.text.separators = ",;";
    bool done = read_header(&table, err);
    while (done && text_next_line(&table.text))
        done = !text_word(&table.text, &word) || read_row(&table, &word, err);
    double *share = out->share; /* densities, per nm of emission, become shares of bands */
    for (struct walk walk = walk_start(&out->emission, &none);
         done && densities && walk_step(&walk);)
        for (int i = 0; i < out->excitation.count; i++)
            *share++ *= walk.weight;
    table.diagonal.place = from; /* its own ends with the text */
    done = done && take_diagonal(&table, diffuse, err) && check_shares(&table, diffuse, err);
    spectrum_free(&table.diagonal);
    text_free(&table.text);
    return done;
}

/* A row of the matrix is an excitation spectrum: of the light that is emitted at the row's
 * wavelength. */
bool donaldson_emission(const struct donaldson *matrix, const struct spectrum *light,
                        struct spectrum *out, struct error *err)
{
    struct spectrum row = matrix->excitation;
    row.value = matrix->share;
    bool done = true;
    *out = (struct spectrum){0};
    for (struct walk walk = walk_start(&matrix->emission, &none); done && walk_step(&walk);) {
        const struct absorption in = absorb(light, &row);
        const double value = in.largest_excitation * (in.product / walk.weight) * in.largest_light;
        done = spectrum_append(out, walk.nm, value, light->place, err);
        row.value += row.count;
    }
    done = done && string_copy("donaldson", &out->name, err);
    if (!done)
        spectrum_free(out);
    return done;
}

/* ---- the balance of light ---- */

void fluorescence_balance(const struct spectrum *excitation, const struct spectrum *emission,
                          const double *share, double *shorter, double *most)
{
    double sum = 0, all = 0;
    int i = 0;
    *shorter = *most = 0;
    for (struct walk in = walk_start(excitation, &none); walk_step(&in); i++) {
        const double absorbed = spectrum_at(excitation, in.nm, SPECTRUM_ZERO);
        double column = 0;
        int at = i;
        for (struct walk to = walk_start(emission, &none); walk_step(&to);) {
            const double light =
                share ? share[at]
                      : absorbed * to.weight * spectrum_at(emission, to.nm, SPECTRUM_ZERO);
            column += light;
            *shorter += to.nm < in.nm ? in.weight * light : 0;
            at += excitation->count;
        }
        all += in.weight * column;
        sum += in.weight * absorbed;
        *most = fmax(*most, column);
    }
    *shorter = relative(*shorter, all);
    *most = share ? *most : relative(*most, sum);
}

void donaldson_free(struct donaldson *matrix)
{
    spectrum_free(&matrix->excitation);
    spectrum_free(&matrix->emission);
    free(matrix->share);
    *matrix = (struct donaldson){0};
}
