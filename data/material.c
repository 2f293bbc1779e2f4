/* SPDX-License-Identifier: MIT */
/* Materials, from files in the format of the 1998 thesis (its Table 1: the first word of a line
 * says what the line is) and from the words of a scene. Both are held to the same ranges. */
#include "scene.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double highest_gloss = 128; /* as GL_SHININESS */

/* ---- what both forms share ---- */

static bool read_gloss(const struct word *word, struct material *out, struct error *err)
{
    return word_number(word, "gloss", 0, highest_gloss, &out->gloss, err);
}

/* The excitation by a light is divided by the sum, which stands for a light of 1 everywhere. */
static bool check_excitation(const struct spectrum *excitation, struct error *err)
{
    double sum = excitation->factor;
    if (excitation->kind == SPECTRUM_CONSTANT)
        sum *= excitation->parameter[0];
    if (excitation->kind == SPECTRUM_SAMPLED) {
        double values = 0;
        for (int i = 0; i < excitation->count; i++)
            values += excitation->value[i];
        sum *= values;
    }
    if (sum > 0 && isfinite(sum))
        return true;
    return error_at(err, excitation->place,
                    "the sum of the excitation is %g; it is above 0 and finite", sum);
}

static bool copy_string(const char *from, char **out, struct error *err)
{
    *out = strdup(from);
    return *out != NULL || error_memory(err);
}

/* ---- material files ---- */

/* WAVELENGTH REFLECTANCE */
static bool read_reflectance(struct text *text, struct spectrum *out, struct error *err)
{
    struct word word;
    double nm, value;
    return text_expect(text, &word, "a wavelength", err) &&
           word_number(&word, "wavelength", -HUGE_VAL, HUGE_VAL, &nm, err) &&
           text_number(text, "reflectance", 0, 1, &value, err) &&
           spectrum_append(out, nm, value, word.place, err);
}

/* WAVELENGTH EXCITATION EMISSION */
static bool read_fluorescence(struct text *text, struct material *out, struct error *err)
{
    struct word word;
    double nm, excitation, emission;
    return text_expect(text, &word, "a wavelength", err) &&
           word_number(&word, "wavelength", -HUGE_VAL, HUGE_VAL, &nm, err) &&
           text_number(text, "excitation", 0, HUGE_VAL, &excitation, err) &&
           text_number(text, "emission", 0, HUGE_VAL, &emission, err) &&
           spectrum_append(&out->excitation, nm, excitation, word.place, err) &&
           spectrum_append(&out->emission, nm, emission, word.place, err);
}

static bool read_gloss_line(struct text *text, struct place place, struct material *out,
                            struct error *err)
{
    struct word word;
    if (!place_once(out->gloss_place, place, "gloss", err) ||
        !text_expect(text, &word, "a gloss", err))
        return false;
    out->gloss_place = place;
    return read_gloss(&word, out, err);
}

static bool read_texture_line(struct text *text, struct place place, struct material *out,
                              struct error *err)
{
    struct word word;
    if (!place_once(out->texture_place, place, "texture", err) ||
        !text_expect(text, &word, "a texture file", err))
        return false;
    out->texture_place = place;
    out->texture = word_path(&word, err);
    return out->texture != NULL;
}

/* What a line's first word says: g s f t, R G S F for the partner's, r for a number, 0 for nothing
 * known. Letters may be small or capital. */
static char line_kind(const struct word *word)
{
    int first, second;
    if (word->quoted)
        return 0;
    if (strchr("0123456789+-.", word->start[0]) != NULL)
        return 'r';
    first = tolower((unsigned char)word->start[0]);
    if (word->length == 1)
        return strchr("gsft", first) != NULL ? (char)first : 0;
    second = tolower((unsigned char)word->start[1]);
    if (word->length == 2 && first == 'm' && strchr("rgsf", second) != NULL)
        return (char)toupper(second);
    return 0;
}

/* The partner, made when its first line comes. */
static struct material *partner_of(struct material *material, struct place place, struct error *err)
{
    if (material->partner != NULL)
        return material->partner;
    material->partner = calloc(1, sizeof *material->partner);
    if (material->partner == NULL) {
        error_memory(err);
        return NULL;
    }
    material->partner->place = material->partner_place = place;
    return material->partner;
}

static bool read_line(struct text *text, const struct word *first, struct material *out,
                      struct error *err)
{
    char kind = line_kind(first);
    if (kind == 'r')
        text->at = first->start;
    if (isupper((unsigned char)kind)) {
        out = partner_of(out, first->place, err);
        if (out == NULL)
            return false;
    }
    switch (tolower((unsigned char)kind)) {
    case 'r':
        return read_reflectance(text, &out->diffuse, err);
    case 's':
        return read_reflectance(text, &out->specular, err);
    case 'f':
        return read_fluorescence(text, out, err);
    case 'g':
        return read_gloss_line(text, first->place, out, err);
    case 't':
        return read_texture_line(text, first->place, out, err);
    default:
        return error_at(err, first->place,
                        "unknown line '%.*s'; a line begins with a wavelength, g, s, f, t, mr, mg, "
                        "ms or mf",
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

/* Checks what only the whole file shows, and names the spectra. */
static bool complete(struct material *material, struct error *err)
{
    struct spectrum *spectra[] = {&material->diffuse, &material->specular, &material->excitation,
                                  &material->emission};
    if (material->excitation.kind != SPECTRUM_NONE && !check_excitation(&material->excitation, err))
        return false;
    for (size_t i = 0; i < sizeof spectra / sizeof spectra[0]; i++)
        if (spectra[i]->kind != SPECTRUM_NONE &&
            !copy_string(material->name, &spectra[i]->name, err))
            return false;
    material->specular_place = material->specular.place;
    return true;
}

static bool complete_file(struct text *text, struct material *out, struct error *err)
{
    struct material *partner = out->partner;
    if (out->diffuse.kind == SPECTRUM_NONE)
        return error_at(err, text_whole(text),
                        "no diffuse reflectance; a material has lines of a wavelength and one");
    if (!complete(out, err))
        return false;
    if (partner == NULL)
        return true;
    if (partner->diffuse.kind == SPECTRUM_NONE)
        return error_at(err, partner->place,
                        "the partner has no mr lines; it needs a diffuse reflectance");
    return copy_string(out->name, &partner->name, err) &&
           copy_string(out->path, &partner->path, err) && complete(partner, err);
}

/* The file's name without folder and ending. */
static char *name_of(const char *path)
{
    const char *slash = strrchr(path, '/'), *base = slash != NULL ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    return strndup(base, dot != NULL && dot > base ? (size_t)(dot - base) : strlen(base));
}

bool material_read(const char *path, struct place from, struct material *out, struct error *err)
{
    struct text text;
    bool done;
    *out = (struct material){0};
    if (!text_open(&text, path, from, err))
        return false;
    out->path = text.path; /* taken over: the places point at it */
    out->place = text_whole(&text);
    out->name = name_of(path);
    done = out->name != NULL ? read_lines(&text, out, err) && complete_file(&text, out, err)
                             : error_memory(err);
    text.path = NULL;
    text_free(&text);
    if (!done)
        material_free(out);
    return done;
}

/* ---- materials written in a scene ---- */

/* The next word, over lines. A brace that touches a word would hide in it. */
static bool block_word(struct text *text, struct word *out, const char *what, struct place open,
                       struct error *err)
{
    do {
        struct text before = *text;
        if (!text_word(text, out))
            continue;
        *text = before;
        if (!text_expect(text, out, what, err))
            return false;
        if (!out->quoted && out->length > 1 && memchr(out->start, '}', out->length) != NULL)
            return error_at(err, out->place, "a } stands alone, between blanks");
        return true;
    } while (text_next_line(text));
    return error_at(err, open, "this { is never closed by a }");
}

/* A word's argument. */
static bool block_value(struct text *text, struct word *out, const char *what, struct place open,
                        struct error *err)
{
    if (!block_word(text, out, what, open, err))
        return false;
    return !word_is(out, "}") || error_at(err, out->place, "expected %s before }", what);
}

static bool block_spectrum(struct text *text, double highest, struct spectrum *out,
                           struct place open, struct error *err)
{
    struct word word;
    return block_value(text, &word, "a spectrum", open, err) &&
           spectrum_read(&word, 0, highest, out, err);
}

static bool block_file(struct text *text, char **out, struct place open, struct error *err)
{
    struct word word;
    if (!block_value(text, &word, "a file", open, err))
        return false;
    *out = word_path(&word, err);
    return *out != NULL;
}

static bool block_texture(struct text *text, struct material *out, struct place open,
                          struct error *err)
{
    struct text before;
    struct word word;
    if (!block_file(text, &out->texture, open, err))
        return false;
    before = *text;
    if (!block_word(text, &word, "}", open, err))
        return false;
    out->texture_linear = word_is(&word, "linear");
    if (!out->texture_linear && !word_is(&word, "nearest"))
        *text = before;
    return true;
}

static bool block_gloss(struct text *text, struct material *out, struct place open,
                        struct error *err)
{
    struct word word;
    return block_value(text, &word, "a gloss", open, err) && read_gloss(&word, out, err);
}

static bool block_metamer(struct text *text, struct material *out, struct place open,
                          struct error *err)
{
    struct word word;
    if (!block_value(text, &word, "a material", open, err))
        return false;
    out->partner_name = word_copy(&word);
    return out->partner_name != NULL || error_memory(err);
}

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

static bool block_entry(struct text *text, enum block_kind kind, struct material *out,
                        struct place open, struct error *err)
{
    switch (kind) {
    case BLOCK_DIFFUSE:
        return block_spectrum(text, 1, &out->diffuse, open, err);
    case BLOCK_SPECULAR:
        return block_spectrum(text, 1, &out->specular, open, err);
    case BLOCK_GLOSS:
        return block_gloss(text, out, open, err);
    case BLOCK_FLUORESCENCE:
        return block_spectrum(text, HUGE_VAL, &out->excitation, open, err) &&
               check_excitation(&out->excitation, err) &&
               block_spectrum(text, HUGE_VAL, &out->emission, open, err);
    case BLOCK_DONALDSON:
        return block_file(text, &out->donaldson, open, err);
    case BLOCK_TEXTURE:
        return block_texture(text, out, open, err);
    case BLOCK_SPECTRAL_TEXTURE:
        return block_file(text, &out->spectral_texture, open, err);
    case BLOCK_EMISSION:
        return block_spectrum(text, HUGE_VAL, &out->glow, open, err);
    case BLOCK_METAMER:
        return block_metamer(text, out, open, err);
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

/* What shines or mirrors by itself needs no diffuse reflectance: it is 0 then. */
static bool complete_block(struct material *out, const struct place given[BLOCK_END],
                           struct place open, struct error *err)
{
    out->gloss_place = given[BLOCK_GLOSS];
    out->specular_place = given[BLOCK_SPECULAR];
    out->donaldson_place = given[BLOCK_DONALDSON];
    out->texture_place = given[BLOCK_TEXTURE];
    out->spectral_texture_place = given[BLOCK_SPECTRAL_TEXTURE];
    out->partner_place = given[BLOCK_METAMER];
    if (!exclude(given[BLOCK_FLUORESCENCE], given[BLOCK_DONALDSON], "fluorescence or donaldson",
                 err) ||
        !exclude(given[BLOCK_TEXTURE], given[BLOCK_SPECTRAL_TEXTURE], "texture or spectral-texture",
                 err))
        return false;
    if (out->diffuse.kind != SPECTRUM_NONE)
        return true;
    if (out->specular.kind == SPECTRUM_NONE && out->glow.kind == SPECTRUM_NONE)
        return error_at(err, open, "the material has none of diffuse, specular and emission");
    out->diffuse = (struct spectrum){.kind = SPECTRUM_CONSTANT, .factor = 1, .place = open};
    return copy_string("0", &out->diffuse.name, err);
}

static bool read_block(struct text *text, struct material *out, struct error *err)
{
    struct place given[BLOCK_END] = {{0}}, open = text_place(text);
    struct word word;
    open.column--; /* the cursor stands behind the { */
    for (;;) {
        int kind;
        if (!block_word(text, &word, "}", open, err))
            return false;
        kind = word_choose(&word, block_words, "word in a material", err);
        if (kind < 0)
            return false;
        if (kind == BLOCK_END)
            return complete_block(out, given, open, err);
        if (!place_once(given[kind], word.place, block_words[kind], err) ||
            !block_entry(text, (enum block_kind)kind, out, open, err))
            return false;
        given[kind] = word.place;
    }
}

bool material_read_words(struct text *text, struct material *out, struct error *err)
{
    *out = (struct material){0};
    if (read_block(text, out, err))
        return true;
    material_free(out);
    return false;
}

void material_free(struct material *material)
{
    spectrum_free(&material->diffuse);
    spectrum_free(&material->specular);
    spectrum_free(&material->excitation);
    spectrum_free(&material->emission);
    spectrum_free(&material->glow);
    if (material->partner != NULL)
        material_free(material->partner);
    free(material->partner);
    free(material->partner_name);
    free(material->donaldson);
    free(material->texture);
    free(material->spectral_texture);
    free(material->name);
    free(material->path);
    *material = (struct material){0};
}
