/* SPDX-License-Identifier: MIT */
/* Reads materials from files in the format of the 1998 thesis (in its Table 1, the first word of a
 * line is the kind of the line) and from the words of a scene. Both have the same ranges. */
#include <ctype.h>
#include <strings.h>

#include "data/scene/inside.h"

/* Refuses an excitation whose sum is not above 0 and finite. The excitation by a light is divided
 * by this sum, the excitation by a light of 1 at all wavelengths. */
static bool check_excitation(const struct spectrum *excitation, struct error *err)
{
    double sum = excitation->kind == SPECTRUM_CONSTANT  ? excitation->parameter[0]
                 : excitation->kind == SPECTRUM_SAMPLED ? 0
                                                        : 1;
    for (int i = 0; i < excitation->count; i++)
        sum += excitation->value[i];
    sum *= excitation->factor;
    return (sum > 0 && isfinite(sum)) ||
           error_at(err, excitation->place,
                    "the sum of the excitation is %g; expected a finite sum above 0", sum);
}

/* ---- material files ---- */

static bool read_wavelength(struct text *text, struct word *word, double *nm, struct error *err)
{
    return text_expect(text, word, "a wavelength", err) &&
           word_number(word, "wavelength", -HUGE_VAL, HUGE_VAL, nm, err);
}

/* Reads WAVELENGTH REFLECTANCE. */
static bool read_reflectance(struct text *text, struct spectrum *out, struct error *err)
{
    struct word word;
    double nm, value;
    return read_wavelength(text, &word, &nm, err) &&
           text_number(text, "reflectance", 0, 1, &value, err) &&
           spectrum_append(out, nm, value, word.place, err);
}

/* Reads WAVELENGTH EXCITATION EMISSION. */
static bool read_fluorescence(struct text *text, struct material *out, struct error *err)
{
    struct word word;
    double nm, excitation, emission;
    return read_wavelength(text, &word, &nm, err) &&
           text_number(text, "excitation", 0, HUGE_VAL, &excitation, err) &&
           text_number(text, "emission", 0, HUGE_VAL, &emission, err) &&
           spectrum_append(&out->excitation, nm, excitation, word.place, err) &&
           spectrum_append(&out->emission, nm, emission, word.place, err);
}

/* Returns the kind of a line: the first letter of its first word, in lower case, as the program of
 * the thesis read it; behind an m the second. 0: unknown word. */
static char line_kind(const struct word *word)
{
    const bool partner = tolower((unsigned char)word->start[0]) == 'm' && word->length > 1;
    const char kind = (char)tolower((unsigned char)word->start[partner]);
    return !word->quoted && kind != '\0' && strchr(partner ? "rsfgt" : "sfgt", kind) ? kind : 0;
}

static bool read_line(struct text *text, const struct word *first, struct material *out,
                      struct error *err)
{
    bool number = word_begins_number(first);
    char kind = number ? 'r' : line_kind(first);
    struct word word;
    if (number)
        text->at = first->start;
    if (kind != 0 && tolower((unsigned char)first->start[0]) == 'm') {
        if (!out->partner) {
            if (!MAKE_ARRAY(out->partner, 1, err, "a metameric partner"))
                return false;
            out->partner->place = out->partner_place = first->place;
        }
        out = out->partner;
    }
    switch (kind) {
    case 'r':
        return read_reflectance(text, &out->diffuse, err);
    case 's':
        return read_reflectance(text, &out->specular, err);
    case 'f':
        return read_fluorescence(text, out, err);
    case 'g':
        return place_once(&out->gloss_place, first->place, "gloss", err) &&
               text_expect(text, &word, "a gloss", err) &&
               word_number(&word, "gloss", 0, HIGHEST_GLOSS, &out->gloss, err);
    case 't':
        return place_once(&out->texture_place, first->place, "texture", err) &&
               text_expect(text, &word, "a texture file", err) &&
               word_file_or_here(&word, FILE_TEXTURE, &out->texture, err);
    default:
        return error_at(err, first->place,
                        "unknown line '%.*s'; a line begins with a wavelength, g, s, f, t, mr, mg, "
                        "ms, mf or mt",
                        word_shown(first), first->start);
    }
}

static bool read_lines(struct text *text, struct material *out, struct error *err)
{
    struct word word;
    while (text_next_line(text))
        if (text_word(text, &word) &&
            (!read_line(text, &word, out, err) || !text_end(text, "this line", err)))
            return false;
    return true;
}

/* Checks the material when all its lines are read, and names its spectra. */
static bool complete(struct material *material, const char *no_diffuse, struct error *err)
{
    struct spectrum *spectra[] = {&material->diffuse, &material->specular, &material->excitation,
                                  &material->emission};
    if (material->diffuse.kind == SPECTRUM_NONE)
        return error_at(err, material->place, "%s", no_diffuse);
    if (material->excitation.kind != SPECTRUM_NONE && !check_excitation(&material->excitation, err))
        return false;
    for (size_t i = 0; i < sizeof spectra / sizeof spectra[0]; i++)
        if (spectra[i]->kind != SPECTRUM_NONE &&
            (!spectrum_is_in_nm(spectra[i], err) ||
             !string_copy(material->name, &spectra[i]->name, err)))
            return false;
    return true;
}

static bool complete_file(struct material *out, struct error *err)
{
    struct material *partner = out->partner;
    return complete(out, "no diffuse reflectance; a material has lines of a wavelength and one",
                    err) &&
           (!partner ||
            (string_copy(out->name, &partner->name, err) &&
             string_copy(out->path, &partner->path, err) &&
             complete(partner, "the partner has no mr lines; it needs a diffuse reflectance",
                      err)));
}

bool material_read(const char *path, struct place from, struct material *out, struct error *err)
{
    struct text text;
    bool done;
    *out = (struct material){0};
    if (!file_expected(path, from, FILE_MATERIAL, err) || !text_open(&text, path, from, 0, err))
        return false;
    out->path = text.path; /* taken over: the places point at it */
    out->place = text_whole(&text);
    out->name = output_name(path, "", err);
    done = out->name && read_lines(&text, out, err) && complete_file(out, err);
    text.path = NULL;
    text_free(&text);
    if (!done)
        material_free(out);
    return done;
}

/* ---- materials written in a scene ---- */

enum block_kind {
    BLOCK_DIFFUSE,
    BLOCK_SPECULAR,
    BLOCK_GLOSS,
    BLOCK_FLUORESCENCE,
    BLOCK_DONALDSON,
    BLOCK_TEXTURE,
    BLOCK_SPECTRAL_TEXTURE,
    BLOCK_EMISSION,
    BLOCK_METAMER,
    BLOCK_END
};
static const char *const block_words[] = {
    "diffuse", "specular",         "gloss",    "fluorescence", "donaldson",
    "texture", "spectral-texture", "emission", "metamer",      "}",
    NULL};
static const char *const block_values[BLOCK_END] = {"a spectrum", "a spectrum", "a gloss",
                                                    "a spectrum", "a file",     "a file",
                                                    "a file",     "a spectrum", "a material"};

/* Reads the next word, of this line or a later one. Refuses a } that touches a word: it would pass
 * for a part of the word. */
static bool block_word(struct text *text, struct word *out, struct place open, struct error *err)
{
    while (!text_peek(*text, out))
        if (!text_next_line(text))
            return error_at(err, open, "this { is never closed by a }");
    return text_expect(text, out, "a word", err) &&
           (out->quoted || out->length == 1 || !memchr(out->start, '}', out->length) ||
            error_at(err, out->place, "a } stands between blanks: { ... }"));
}

/* Reads the value behind a word. */
static bool block_value(struct text *text, struct word *out, const char *what, struct place open,
                        struct error *err)
{
    return block_word(text, out, open, err) &&
           (!word_is(out, "}") || error_at(err, out->place, "expected %s before }", what));
}

/* Reads one of some words (NULL ends them), if one of them follows: *out is its number, otherwise
 * 0. Refuses another word in the same line, unless it goes on with the material. `what` names the
 * words. */
static bool read_choice(struct text *text, const char *const words[], const char *what, int *out,
                        struct place open, struct error *err)
{
    struct text before = *text;
    struct word word;
    if (!block_word(text, &word, open, err))
        return false;
    *out = word_find(&word, words);
    if (*out >= 0)
        return true;
    *out = 0;
    if (text->line_start == before.line_start && word_find(&word, block_words) < 0)
        return (*out = word_choose(&word, words, what, err)) >= 0;
    *text = before;
    return true;
}

static bool block_entry(struct text *text, int kind, struct material *out, struct error *err)
{
    static const char *const sorts[] = {"shares", "densities", NULL};
    static const char *const filters[] = {"nearest", "linear", "bilinear", NULL};
    struct word word;
    int chosen;
    if (kind != BLOCK_END && !block_value(text, &word, block_values[kind], out->place, err))
        return false;
    switch ((enum block_kind)kind) {
    case BLOCK_DIFFUSE:
        return spectrum_read(&word, 0, 1, &out->diffuse, err);
    case BLOCK_SPECULAR:
        return spectrum_read(&word, 0, 1, &out->specular, err);
    case BLOCK_GLOSS:
        return word_number(&word, "gloss", 0, HIGHEST_GLOSS, &out->gloss, err);
    case BLOCK_FLUORESCENCE:
        return spectrum_read(&word, 0, HUGE_VAL, &out->excitation, err) &&
               check_excitation(&out->excitation, err) &&
               block_value(text, &word, "a spectrum", out->place, err) &&
               spectrum_read(&word, 0, HUGE_VAL, &out->emission, err);
    case BLOCK_DONALDSON:
        if (!word_file(&word, FILE_KINDS, &out->donaldson, err) ||
            !read_choice(text, sorts, "sort of matrix", &chosen, out->place, err))
            return false;
        out->densities = chosen == 1;
        return true;
    case BLOCK_TEXTURE:
    case BLOCK_SPECTRAL_TEXTURE: /* one of both: see material_read_words */
        free(out->texture);
        out->spectral_texture = kind == BLOCK_SPECTRAL_TEXTURE;
        if (!word_file(&word, FILE_TEXTURE, &out->texture, err) ||
            !read_choice(text, filters, "filter", &chosen, out->place, err))
            return false;
        out->texture_filter = (enum texture_filter)chosen;
        return true;
    case BLOCK_EMISSION:
        return spectrum_read(&word, 0, HUGE_VAL, &out->glow, err);
    case BLOCK_METAMER:
        out->partner_name = word_copy(&word, err);
        return out->partner_name != NULL;
    case BLOCK_END:
        break;
    }
    return true;
}

static bool exclude(struct place first, struct place second, const char *what, struct error *err)
{
    return first.line == 0 || second.line == 0 ||
           error_at(err, second, "a material has either %s, not both", what);
}

/* A material with an emission, a specular reflectance or a matrix needs no diffuse reflectance;
 * that is 0 then, or the diagonal of the matrix. */
static bool complete_diffuse(struct material *out, struct error *err)
{
    if (out->diffuse.kind != SPECTRUM_NONE)
        return true;
    if (out->specular.kind == SPECTRUM_NONE && out->glow.kind == SPECTRUM_NONE && !out->donaldson)
        return error_at(err, out->place,
                        "the material has none of diffuse, specular, emission and donaldson");
    out->diffuse = (struct spectrum){.kind = SPECTRUM_CONSTANT, .factor = 1, .place = out->place};
    return string_copy("0", &out->diffuse.name, err);
}

bool material_has_word(const struct word *word)
{
    const int kind = word_find(word, block_words);
    return kind >= 0 && kind < BLOCK_END;
}

/* Refuses a word that begins a later line than the { and is like no word of a material: it may be
 * the next statement, and then a } is missing. */
static bool check_closed(const struct text *text, const struct word *word, struct place open,
                         struct error *err)
{
    const char *line = text->line_start + strspn(text->line_start, " \t");
    struct suggestion suggestion = {.distance = 0};
    if (line != word->start || word->place.line == open.line || word_find(word, block_words) >= 0)
        return true;
    for (int kind = 0; kind < BLOCK_END; kind++)
        suggestion_add(&suggestion, word, block_words[kind], strlen(block_words[kind]));
    return suggestion.nearest[0] ||
           error_at(err, word->place,
                    "'%.*s' is no word of a material; a } is missing before it: the { is in line "
                    "%d, column %d",
                    word_shown(word), word->start, open.line, open.column);
}

bool material_read_words(struct text *text, struct material *out, struct error *err)
{
    struct place given[BLOCK_END + 1] = {{0}};
    struct word word;
    *out = (struct material){.place = text_place(text)};
    out->place.column--; /* the cursor stands behind the { */
    for (int kind = 0; kind != BLOCK_END;) {
        if (!block_word(text, &word, out->place, err) ||
            !check_closed(text, &word, out->place, err))
            return false;
        if (word_begins_number(&word) && given[kind].line > 0)
            return error_at(err, word.place, "'%.*s' is too much: %s takes one %s, and no RGB",
                            word_shown(&word), word.start, block_words[kind],
                            strchr(block_values[kind], ' ') + 1);
        kind = word_choose_once(&word, block_words, "word in a material", given, err);
        if (kind < 0 || !block_entry(text, kind, out, err))
            return false;
    }
    out->donaldson_place = given[BLOCK_DONALDSON];
    out->texture_place = given[out->spectral_texture ? BLOCK_SPECTRAL_TEXTURE : BLOCK_TEXTURE];
    out->partner_place = given[BLOCK_METAMER];
    return exclude(given[BLOCK_FLUORESCENCE], given[BLOCK_DONALDSON], "fluorescence or donaldson",
                   err) &&
           exclude(given[BLOCK_TEXTURE], given[BLOCK_SPECTRAL_TEXTURE],
                   "texture or spectral-texture", err) &&
           complete_diffuse(out, err);
}

bool material_read_emission(struct text *text, struct material *out, struct error *err)
{
    struct word word;
    double intensity;
    *out = (struct material){.place = text_place(text)};
    if (!text_expect(text, &word, "a spectrum", err) ||
        !spectrum_read(&word, 0, HUGE_VAL, &out->glow, err) ||
        !text_number(text, "intensity", 0, HUGE_VAL, &intensity, err))
        return false;
    out->glow.factor *= intensity;
    return string_copy(out->glow.name, &out->name, err) && complete_diffuse(out, err);
}

void material_free(struct material *material)
{
    struct spectrum *spectra[] = {&material->diffuse, &material->specular, &material->excitation,
                                  &material->emission, &material->glow};
    for (size_t i = 0; i < sizeof spectra / sizeof spectra[0]; i++)
        spectrum_free(spectra[i]);
    donaldson_free(&material->matrix);
    if (material->partner)
        material_free(material->partner);
    FREE_ALL(material->partner, material->partner_name, material->donaldson, material->texture,
             material->name, material->path);
    *material = (struct material){0};
}
