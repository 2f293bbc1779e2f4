/* SPDX-License-Identifier: MIT */
/* Reads entries of MTL files, the materials that come with OBJ models. A colour is three numbers,
 * which say nothing about single wavelengths. This file spreads them over the spectrum so that grey
 * is constant. It reads Kd, Ks, Ns, Ke and the picture of map_Kd, notes what else would change a
 * picture, and skips the rest, since the format has many dialects. An entry is read only if a scene
 * uses it. */
#include <strings.h>

#include "data/images/images.h"
#include "data/scene/inside.h"

enum statement { KD, KS, KE, NS, MAP_KD, STATEMENTS };
static const char *const statements[] = {"Kd", "Ks", "Ke", "Ns", "map_Kd", NULL};

/* Makes a spectrum of a colour: blue up to 480 nm, green from 500 to 570 nm, red from 600 nm on. */
static bool spread(const double colour[3], struct place place, const char *name,
                   struct spectrum *out, struct error *err)
{
    for (int i = 0; i < RGB_KNOTS; i++)
        if (!spectrum_append(out, rgb_knot_nm[i], colour[rgb_knot_colour[i]], place, err))
            return false;
    return string_copy(name, &out->name, err);
}

/* Reads the numbers of a colour: one is grey. */
static bool read_numbers(struct text *text, enum statement statement, double colour[3],
                         struct error *err)
{
    static const char *const parts[] = {"red", "green", "blue"};
    struct word word;
    for (int i = 0; i < 3; i++) {
        char what[16];
        if (i == 1 && !text_peek(*text, &word)) {
            colour[1] = colour[2] = colour[0];
            return true;
        }
        snprintf(what, sizeof what, "%s of %s", parts[i], statements[statement]);
        if (!text_number(text, what, 0, statement == KD ? 1 : HUGE_VAL, &colour[i], err))
            return false;
    }
    return true;
}

/* Reads a colour into its spectrum, which stays absent where the colour is black. */
static bool read_colour(struct text *text, enum statement statement, struct place place,
                        struct material *out, struct error *err)
{
    struct spectrum *const spectra[] = {&out->diffuse, &out->specular, &out->glow};
    double colour[3];
    struct word word;
    if (text_peek(*text, &word) && (word_is(&word, "xyz") || word_is(&word, "spectral")))
        return error_at(err, word.place,
                        "%s %.*s is not read; give this usemtl a material in a material map",
                        statements[statement], (int)word.length, word.start);
    if (!read_numbers(text, statement, colour, err))
        return false;
    for (int i = 0; i < 3 && statement == KS; i++) {
        out->lost |= colour[i] > 1 ? LOST_SPECULAR : 0;
        colour[i] = fmin(colour[i], 1);
    }
    return (colour[0] == 0 && colour[1] == 0 && colour[2] == 0) ||
           spread(colour, place, out->name, spectra[statement], err);
}

enum { ILLUM_1 = 1 << LOST_KINDS }; /* it has no highlight */

/* Skips options such as `-s 1 1 1` and `-clamp off`. Returns whether one changes the picture: -s by
 * another number than 1, -o or -t by another one than 0, -mm by others than 0 and 1, or -clamp on.
 */
static bool skip_options(struct text *text)
{
    struct word option = {.length = 0}, word;
    bool changes = false;
    double value;
    int i = 0; /* numbers of the option */
    while (text_peek(*text, &word)) {
        const bool number = word_is_number(&word, -HUGE_VAL, &value);
        if (!number && word.start[0] != '-' && !word_is(&word, "on") && !word_is(&word, "off"))
            break;
        text_word(text, &word);
        const bool gain = word_is(&option, "-mm");
        if (!number && word.start[0] == '-') {
            option = word;
            i = 0;
        } else if (number && (option.length == 2 || gain)) {
            changes = changes || value != (word_is(&option, "-s") || (gain && i == 1) ? 1 : 0);
            i++;
        }
        changes = changes || (word_is(&option, "-clamp") && word_is(&word, "on"));
    }
    return changes;
}

/* Reads the file of map_Kd, which programs for Windows write with backslashes. It becomes the
 * texture if it is there and of a format that textures have. */
static bool read_map(struct text *text, struct place place, struct material *out, struct error *err)
{
    struct word word = {.place = place};
    const char *format;
    const bool changed = skip_options(text);
    char *path = text_rest(text, &word) ? word_copy(&word, err) : NULL;
    for (char *at = path; at && (at = strchr(at, '\\'));)
        *at = '/';
    if (!path || err->status != EXIT_AGREED)
        return err->status == EXIT_AGREED;
    out->texture = file_relative(out->path, path);
    free(path);
    if (!out->texture)
        return memory_lacks(err, (double)word.length, "the name of a picture");
    if (!file_format(out->texture, &format, err))
        return false;
    out->texture_place = place;
    out->texture_filter = TEXTURE_LINEAR;
    out->spectral_texture = true;
    const bool read = strcmp(format, "TIFF") == 0 || image_converts(format);
    out->lost |= read && !changed ? 0 : LOST_MAP_KD;
    if (!read) {
        free(out->texture);
        out->texture = NULL;
        out->spectral_texture = false;
    }
    return true;
}

/* Notes other statements that change a picture: maps; d or Tf below 1, Tr above 0; illum 0 or 1. */
static void note_lost(struct text *text, const struct word *first, struct material *out)
{
    static const char *const maps[] = {"bump", "disp", "decal", "refl", NULL};
    const bool is_map = word_find(first, maps) >= 0 ||
                        (first->length > 4 && strncasecmp(first->start, "map_", 4) == 0);
    double last = word_is(first, "Tr") ? 0 : 1, value;
    out->lost |= is_map ? LOST_MAPS : 0;
    for (struct word word; text_word(text, &word);)
        last = word_is_number(&word, -HUGE_VAL, &value) ? value : last;
    if (((word_is(first, "d") || word_is(first, "Tf")) && last < 1) ||
        (word_is(first, "Tr") && last > 0))
        out->lost |= LOST_TRANSPARENCY;
    if (word_is(first, "illum") && last <= 1)
        out->lost |= last < 1 ? LOST_ILLUM : ILLUM_1;
}

static bool read_statement(struct text *text, const struct word *first,
                           struct place given[STATEMENTS], struct material *out, struct error *err)
{
    const int i = word_find(first, statements);
    if (i < 0) {
        note_lost(text, first, out);
        return true;
    }
    if (!place_once(&given[i], first->place, statements[i], err))
        return false;
    return (i == MAP_KD ? read_map(text, given[i], out, err)
            : i == NS   ? text_number(text, statements[i], 0, HUGE_VAL, &out->gloss, err)
                        : read_colour(text, (enum statement)i, given[i], out, err)) &&
           text_end(text, statements[i], err);
}

/* ---- finding the entries ---- */

/* Adds the entry of a newmtl. A second entry of one name is refused only if a scene uses it. */
static bool add_entry(struct mtl *mtl, const struct word *name, struct error *err)
{
    const int first = index_find(&mtl->names, name->start, name->length);
    const struct mtl_entry entry = {.behind = mtl->text, .name = *name};
    if (first >= 0) {
        if (mtl->entries[first].again.line == 0)
            mtl->entries[first].again = name->place;
        return true;
    }
    return index_add(&mtl->names, name->start, name->length, mtl->n_entries, err) &&
           array_add(&mtl->entries, &mtl->n_entries, &entry, sizeof entry, err);
}

bool mtl_open(const char *path, struct place from, struct mtl *out, struct error *err)
{
    struct word word;
    *out = (struct mtl){.n_entries = 0};
    bool done = text_open(&out->text, path, from, 0, err);
    while (done && text_next_line(&out->text))
        if (text_word(&out->text, &word) && word_is(&word, "newmtl"))
            done = text_rest(&out->text, &word)
                       ? add_entry(out, &word, err)
                       : error_at(err, text_place(&out->text), "expected a name");
    return done;
}

void mtl_free(struct mtl *mtl)
{
    text_free(&mtl->text);
    index_free(&mtl->names);
    free(mtl->entries);
    *mtl = (struct mtl){.n_entries = 0};
}

/* ---- reading an entry ---- */

struct mtl_entry *mtl_find(const struct mtl *mtl, struct place from, const struct word *name,
                           struct error *err)
{
    struct suggestion suggestion = {.distance = 0};
    const int found = index_find(&mtl->names, name->start, name->length);
    if (found >= 0)
        return &mtl->entries[found];
    for (int i = 0; i < mtl->n_entries; i++)
        suggestion_add(&suggestion, name, mtl->entries[i].name.start, mtl->entries[i].name.length);
    error_at(err, from, "no entry '%.*s' in %.200s; %s", word_shown(name), name->start,
             mtl->text.path, suggestion_end(&suggestion, "its entries are"));
    return NULL;
}

/* Reads the statements of the entry up to the next newmtl. Their places name the material's path.
 */
static bool read_entry(const struct mtl_entry *found, struct place given[STATEMENTS],
                       struct material *out, struct error *err)
{
    struct text text = found->behind;
    struct word word;
    text.path = out->path;
    while (text_next_line(&text)) {
        if (!text_word(&text, &word))
            continue;
        if (word_is(&word, "newmtl"))
            break;
        if (!read_statement(&text, &word, given, out, err))
            return false;
    }
    return found->again.line == 0 || place_once(&out->place, found->again, "this entry", err);
}

/* An entry with Ks or Ke needs no Kd, which is 0 then, or 1 below a picture. A highlight needs both
 * Ks and Ns. Shininess above 128, the largest of OpenGL, becomes 128. */
static bool complete(const struct place given[STATEMENTS], struct material *out, struct error *err)
{
    const double plain = out->texture != NULL && given[KD].line == 0;
    const double colour[3] = {plain, plain, plain};
    if (given[KD].line == 0 && given[KS].line == 0 && given[KE].line == 0 && !out->texture)
        return error_at(
            err, out->place,
            "the entry has none of Kd, Ks and Ke%s; give this usemtl a material in a "
            "material map",
            given[MAP_KD].line > 0 ? ", and map_Kd has no picture in TIFF, PNG or SGI format" : "");
    out->from_rgb = true;
    out->lost |= out->specular.kind != SPECTRUM_NONE && out->gloss > HIGHEST_GLOSS ? LOST_GLOSS : 0;
    out->gloss = out->specular.kind != SPECTRUM_NONE ? fmin(out->gloss, HIGHEST_GLOSS) : 0;
    if (out->gloss == 0) {
        out->lost |= out->specular.kind != SPECTRUM_NONE ? LOST_HIGHLIGHT : 0;
        spectrum_free(&out->specular);
    }
    out->lost |= out->gloss > 0 && (out->lost & ILLUM_1) ? LOST_ILLUM : 0;
    out->lost &= ~ILLUM_1;
    return out->diffuse.kind != SPECTRUM_NONE ||
           spread(colour, given[KD].line > 0 ? given[KD] : out->place, out->name, &out->diffuse,
                  err);
}

bool mtl_read(const struct mtl_entry *found, struct material *out, struct error *err)
{
    struct place given[STATEMENTS] = {{0}};
    *out = (struct material){.name = word_copy(&found->name, err), .place = found->name.place};
    if (!out->name || !string_copy(found->behind.path, &out->path, err))
        return false;
    out->place.path = out->path;
    return read_entry(found, given, out, err) && complete(given, out, err);
}
