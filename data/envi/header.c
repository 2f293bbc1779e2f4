/* SPDX-License-Identifier: MIT */
/* Reads ENVI headers. The first line is "ENVI", each further one "KEY = VALUE", where a value in
 * braces may span lines; a line that begins with ';' is a comment. First all values are found, then
 * those of known keys are read. Every refusal has its place in the header. */
#include <ctype.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "data/envi/envi.h"

/* ---- finding the values ---- */

enum key {
    SAMPLES,
    LINES,
    BANDS,
    HEADER_OFFSET,
    FILE_TYPE,
    DATA_TYPE,
    INTERLEAVE,
    BYTE_ORDER,
    WAVELENGTH,
    WAVELENGTH_UNITS,
    GAINS,
    OFFSETS,
    REFLECTANCE_SCALE,
    IGNORED,
    GOOD_BANDS,
    DESCRIPTION,
    COMPRESSION,
    MAJOR_FRAMES,
    MINOR_FRAMES,
    KEYS
};
static const char *const key_names[KEYS] = {"samples",
                                            "lines",
                                            "bands",
                                            "header offset",
                                            "file type",
                                            "data type",
                                            "interleave",
                                            "byte order",
                                            "wavelength",
                                            "wavelength units",
                                            "data gain values",
                                            "data offset values",
                                            "reflectance scale factor",
                                            "data ignore value",
                                            "bbl",
                                            "description",
                                            "file compression",
                                            "major frame offsets",
                                            "minor frame offsets"};

/* A value without its braces, and without the blanks at both ends. */
struct value {
    const char *start, *end;
    struct place place; /* of `start`; line 0: the header does not have this key */
};
struct values {
    struct text text;
    struct value of[KEYS];
};

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* Returns the first place from `at` on that is not blank, or `end`. *place goes along. */
static const char *skip_blanks(const char *at, const char *end, struct place *place)
{
    for (; at < end && is_blank(*at); at++) {
        place->column++;
        if (*at == '\n') {
            place->line++;
            place->column = 1;
        }
    }
    return at;
}

static const char *trimmed_end(const char *start, const char *end)
{
    while (end > start && is_blank(end[-1]))
        end--;
    return end;
}

/* Returns whether these bytes are the name, in any case and with any blanks between its words. */
static bool is_name(const char *at, const char *end, const char *name)
{
    while (at < end && *name != '\0') {
        if (is_blank(*at) && *name == ' ') {
            while (at < end && is_blank(*at))
                at++;
            name++;
        } else if (tolower((unsigned char)*at++) != tolower((unsigned char)*name++))
            return false;
    }
    return at == end && *name == '\0';
}

/* Reads the value behind the '='. A value in braces ends at the first closing one. */
static bool find_value(struct text *text, struct value *out, struct error *err)
{
    out->place = text_place(text);
    out->start = text->at = skip_blanks(text->at, text->line_end, &out->place);
    out->end = trimmed_end(out->start, text->line_end);
    if (out->start == text->line_end || *out->start != '{')
        return true;
    const struct place brace = out->place;
    const char *close;
    while ((close = memchr(text->at, '}', (size_t)(text->line_end - text->at))) == NULL)
        if (!text_next_line(text))
            return error_at(err, brace, "no } closes this {");
    text->at = close + 1;
    struct place behind = text_place(text);
    if (skip_blanks(text->at, text->line_end, &behind) < text->line_end)
        return error_at(err, behind, "expected the end of the line behind }");
    out->place.column++;
    out->start = skip_blanks(out->start + 1, close, &out->place);
    out->end = trimmed_end(out->start, close);
    return true;
}

static bool find_line(struct values *out, struct error *err)
{
    struct text *text = &out->text;
    struct place place = text_place(text);
    const char *start = skip_blanks(text->at, text->line_end, &place);
    if (start == text->line_end || *start == ';')
        return true;
    const char *equals = memchr(start, '=', (size_t)(text->line_end - start));
    if (equals == NULL)
        return error_at(err, place, "expected a line KEY = VALUE, or a comment that begins with ;");
    struct value value;
    const char *end = trimmed_end(start, equals);
    text->at = equals + 1;
    if (!find_value(text, &value, err))
        return false;
    for (int key = 0; key < KEYS; key++)
        if (is_name(start, end, key_names[key])) {
            struct place *first = &out->of[key].place;
            if (!place_once(first, place, key_names[key], err))
                return false;
            out->of[key] = value;
        }
    return true;
}

static bool find_values(struct values *out, struct error *err)
{
    struct text *text = &out->text;
    if (!text_next_line(text) || !is_name(text->at, trimmed_end(text->at, text->line_end), "ENVI"))
        return error_at(err, (struct place){text->path, 1, 1},
                        "expected ENVI in the first line: only ENVI's headers are read");
    while (text_next_line(text))
        if (!find_line(out, err))
            return false;
    return true;
}

/* ---- reading a value ---- */

static bool is_given(const struct values *values, enum key key)
{
    return values->of[key].place.line > 0;
}

/* Finds the one word of a value. Refuses a header that does not have the key. */
static bool word_find(const struct values *values, enum key key, struct word *out,
                      struct error *err)
{
    const struct value *value = &values->of[key];
    if (!is_given(values, key))
        return error_at(err, text_whole(&values->text), "the line '%s = ...' is missing",
                        key_names[key]);
    *out = (struct word){.start = value->start,
                         .length = (size_t)(value->end - value->start),
                         .place = value->place};
    if (out->length > 0 && memchr(out->start, '\n', out->length) == NULL)
        return true;
    return error_at(err, value->place, "expected one value of %s", key_names[key]);
}

static bool whole_read(const struct values *values, enum key key, long lowest, long highest,
                       long *out, struct error *err)
{
    struct word word;
    return word_find(values, key, &word, err) &&
           word_integer(&word, key_names[key], lowest, highest, out, err);
}

/* Returns the index of the value's word in `known`, in any case; -1: it is refused. */
static int choice_read(const struct values *values, enum key key, const char *const *known,
                       struct error *err)
{
    struct word word;
    return word_find(values, key, &word, err) ? word_choose(&word, known, key_names[key], err) : -1;
}

/* Reads the next number of a list, and goes behind its comma. */
static bool number_next(struct value *rest, enum key key, double *out, struct error *err)
{
    rest->start = skip_blanks(rest->start, rest->end, &rest->place);
    struct word word = {.start = rest->start, .place = rest->place};
    while (rest->start < rest->end && *rest->start != ',' && !is_blank(*rest->start))
        rest->start++;
    word.length = (size_t)(rest->start - word.start);
    rest->place.column += (int)word.length;
    if (word.length == 0)
        return error_at(err, word.place, "expected a number of %s", key_names[key]);
    if (!word_number(&word, key_names[key], -HUGE_VAL, HUGE_VAL, out, err))
        return false;
    rest->start = skip_blanks(rest->start, rest->end, &rest->place);
    if (rest->start == rest->end)
        return true;
    if (*rest->start != ',')
        return error_at(err, rest->place, "expected a comma between two numbers of %s",
                        key_names[key]);
    rest->start++;
    rest->place.column++;
    return rest->start < rest->end ||
           error_at(err, rest->place, "expected a number of %s", key_names[key]);
}

/* Reads n numbers into *out, allocated. If the header does not have the key, all are `otherwise`.
 */
static bool list_read(const struct values *values, enum key key, int n, double otherwise,
                      double **out, struct error *err)
{
    struct value rest = values->of[key];
    int count = 0;
    *out = malloc((size_t)n * sizeof **out);
    if (*out == NULL)
        return error_memory(err);
    for (int i = 0; i < n; i++)
        (*out)[i] = otherwise;
    for (double number; rest.place.line > 0 && rest.start < rest.end; count++) {
        if (!number_next(&rest, key, &number, err))
            return false;
        if (count < n)
            (*out)[count] = number;
    }
    return rest.place.line == 0 || count == n ||
           error_at(err, values->of[key].place, "%s has %d numbers; expected %d, one for each band",
                    key_names[key], count, n);
}

/* ---- the layout ---- */

/* Refuses samples that do not lie plainly one after the other. */
static bool plain_read(const struct values *values, struct error *err)
{
    static const enum key zero[] = {COMPRESSION, MAJOR_FRAMES, MINOR_FRAMES};
    for (size_t i = 0; i < sizeof zero / sizeof zero[0]; i++) {
        struct value rest = values->of[zero[i]];
        double number = 0;
        while (rest.place.line > 0 && rest.start < rest.end) {
            if (!number_next(&rest, zero[i], &number, err))
                return false;
            if (number != 0)
                return error_at(err, values->of[zero[i]].place,
                                "%s other than 0 cannot be read; expected raw samples without gaps",
                                key_names[zero[i]]);
        }
    }
    return true;
}

static bool type_read(const struct values *values, struct envi_layout *out, struct error *err)
{
    long type;
    if (!whole_read(values, DATA_TYPE, 0, INT_MAX, &type, err))
        return false;
    out->type = (enum envi_type)type;
    if (envi_type_bytes(out->type) > 0)
        return true;
    return error_at(err, values->of[DATA_TYPE].place,
                    "data type %ld %s; expected 1 to 5 or 12 to 15", type,
                    type == 6   ? "is of complex numbers, two 32-bit floats each"
                    : type == 9 ? "is of complex numbers, two 64-bit floats each"
                                : "is unknown");
}

/* Reads how the samples lie. A byte order may be missing if samples have one byte. */
static bool layout_read(const struct values *values, struct envi_layout *out, struct error *err)
{
    static const char *const file_types[] = {"ENVI Standard", "ENVI", NULL};
    static const char *const interleaves[] = {"bsq", "bil", "bip", NULL};
    const int most_bands = 65535; /* as pages of a stack */
    long samples, lines, bands, offset = 0, order = 0;
    if (!plain_read(values, err) ||
        (is_given(values, FILE_TYPE) && choice_read(values, FILE_TYPE, file_types, err) < 0) ||
        !whole_read(values, SAMPLES, 1, LONGEST_SIDE, &samples, err) ||
        !whole_read(values, LINES, 1, LONGEST_SIDE, &lines, err) ||
        !whole_read(values, BANDS, 1, most_bands, &bands, err) ||
        (is_given(values, HEADER_OFFSET) &&
         !whole_read(values, HEADER_OFFSET, 0, LONG_MAX / 2, &offset, err)) ||
        !type_read(values, out, err))
        return false;
    const int interleave = choice_read(values, INTERLEAVE, interleaves, err);
    const bool ordered = is_given(values, BYTE_ORDER) || envi_type_bytes(out->type) > 1;
    if (interleave < 0 || (ordered && !whole_read(values, BYTE_ORDER, 0, 1, &order, err)))
        return false;
    out->samples = (int)samples;
    out->lines = (int)lines;
    out->bands = (int)bands;
    out->offset = (uint64_t)offset;
    out->interleave = (enum envi_interleave)interleave;
    out->big_endian = order == 1;
    return true;
}

/* ---- the bands ---- */

/* Finds the bands that are not bad: those with a 1 in bbl. */
static bool good_bands_read(const struct values *values, struct envi_header *out, struct error *err)
{
    const int n = out->layout.bands;
    double *good;
    bool done = list_read(values, GOOD_BANDS, n, 1, &good, err);
    out->band = done ? malloc((size_t)n * sizeof *out->band) : NULL;
    if (done && out->band == NULL)
        done = error_memory(err);
    for (int band = 0; done && band < n; band++) {
        if (good[band] != 0 && good[band] != 1)
            done = error_at(err, values->of[GOOD_BANDS].place,
                            "number %d of bbl is %g; expected 1 for a good band or 0 for a bad one",
                            band + 1, good[band]);
        if (good[band] == 1)
            out->band[out->n++] = band;
    }
    free(good);
    return done && (out->n > 0 || error_at(err, values->of[GOOD_BANDS].place,
                                           "bbl marks all bands as bad; expected a 1 in it"));
}

/* Reads a value for each band, and keeps those of the bands that are not bad. */
static bool per_band_read(const struct values *values, enum key key, double otherwise,
                          const struct envi_header *header, double **out, struct error *err)
{
    if (!list_read(values, key, header->layout.bands, otherwise, out, err))
        return false;
    for (int i = 0; i < header->n; i++)
        (*out)[i] = (*out)[header->band[i]];
    return true;
}

/* Finds how many nm the unit of the wavelengths has. */
static bool unit_read(const struct values *values, double *nm, struct error *err)
{
    static const char *const units[] = {
        "Nanometers", "Nanometer", "nm", "Micrometers", "Micrometer", "Microns", "um", "µm", NULL};
    const int first_of_micrometres = 3;
    if (!is_given(values, WAVELENGTH_UNITS))
        return error_at(err, values->of[WAVELENGTH].place,
                        "the unit of the wavelengths is missing; add a line"
                        " 'wavelength units = Nanometers' or 'wavelength units = Micrometers'");
    const int unit = choice_read(values, WAVELENGTH_UNITS, units, err);
    *nm = unit < first_of_micrometres ? 1 : 1000;
    return unit >= 0;
}

static bool wavelengths_read(const struct values *values, struct envi_header *out,
                             struct error *err)
{
    double unit_nm = 1, before = 0;
    if (!is_given(values, WAVELENGTH))
        return true;
    if (!unit_read(values, &unit_nm, err) ||
        !per_band_read(values, WAVELENGTH, 0, out, &out->wavelengths_nm, err))
        return false;
    for (int i = 0; i < out->n; i++) {
        double *nm = &out->wavelengths_nm[i];
        *nm *= unit_nm;
        if (!(*nm > before && *nm <= DBL_MAX))
            return error_at(err, values->of[WAVELENGTH].place,
                            "band %d is at %.10g nm, the band before it at %.10g nm; expected"
                            " wavelengths that increase from above 0; bbl may leave bands out",
                            out->band[i] + 1, *nm, before);
        before = *nm;
    }
    return true;
}

/* ---- values of samples ---- */

/* A reflectance scale factor divides samples. Beside gains it must mean the same. */
static bool scale_read(const struct values *values, struct envi_header *out, struct error *err)
{
    const double same = 1e-6; /* relative: what six digits in a header leave */
    struct word word;
    double factor;
    if (!per_band_read(values, GAINS, 1, out, &out->gain, err) ||
        !per_band_read(values, OFFSETS, 0, out, &out->offset, err))
        return false;
    if (!is_given(values, REFLECTANCE_SCALE))
        return true;
    if (!word_find(values, REFLECTANCE_SCALE, &word, err) ||
        !word_number(&word, key_names[REFLECTANCE_SCALE], DBL_MIN, HUGE_VAL, &factor, err))
        return false;
    for (int i = 0; i < out->n; i++) {
        if (!is_given(values, GAINS))
            out->gain[i] = 1 / factor;
        else if (!(fabs(out->gain[i] * factor - 1) <= same))
            return error_at(err, word.place,
                            "a reflectance scale factor of %g and a gain of %g in band %d are two"
                            " scales; expected one of these lines only",
                            factor, out->gain[i], out->band[i] + 1);
    }
    return true;
}

/* Samples are compared with the value as they store it: a float. A header may round the largest
 * float up, in as few as six digits. */
static bool ignored_read(const struct values *values, struct envi_header *out, struct error *err)
{
    const double largest = (double)FLT_MAX;
    struct word word;
    out->has_ignored = is_given(values, IGNORED);
    if (!out->has_ignored)
        return true;
    if (!word_find(values, IGNORED, &word, err))
        return false;
    out->ignored = (double)NAN;
    if (!is_name(word.start, word.start + word.length, "nan") &&
        !word_number(&word, key_names[IGNORED], -HUGE_VAL, HUGE_VAL, &out->ignored, err))
        return false;
    if (out->layout.type == ENVI_FLOAT && fabs(out->ignored) <= largest * (1 + 1e-5))
        out->ignored = (double)(float)fmax(-largest, fmin(out->ignored, largest));
    return true;
}

/* Copies the description, with one blank for each run of blanks and line ends. */
static bool description_read(const struct values *values, struct envi_header *out,
                             struct error *err)
{
    const struct value *value = &values->of[DESCRIPTION];
    const size_t length = is_given(values, DESCRIPTION) ? (size_t)(value->end - value->start) : 0;
    char *to = out->description = calloc(length + 1, 1);
    if (to == NULL)
        return error_memory(err);
    for (size_t i = 0; i < length; i++) {
        const char c = is_blank(value->start[i]) ? ' ' : value->start[i];
        if (c != ' ' || to[-1] != ' ') /* the first one is not blank */
            *to++ = c;
    }
    return true;
}

/* ---- the header ---- */

bool envi_header_read(const char *path, struct place from, struct envi_header *out,
                      struct error *err)
{
    struct values values = {.text = {.path = NULL}};
    *out = (struct envi_header){.n = 0};
    const bool done = text_open(&values.text, path, from, err) && find_values(&values, err) &&
                      layout_read(&values, &out->layout, err) &&
                      good_bands_read(&values, out, err) && wavelengths_read(&values, out, err) &&
                      scale_read(&values, out, err) && ignored_read(&values, out, err) &&
                      description_read(&values, out, err);
    text_free(&values.text);
    if (!done)
        envi_header_free(out);
    return done;
}

void envi_header_free(struct envi_header *header)
{
    free(header->band);
    free(header->wavelengths_nm);
    free(header->gain);
    free(header->offset);
    free(header->description);
    *header = (struct envi_header){.n = 0};
}
