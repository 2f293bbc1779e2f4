/* SPDX-License-Identifier: MIT */
/* Reads entries of MTL files, the materials that come with OBJ models. A colour is three numbers,
 * which say nothing about single wavelengths. This file spreads them over the spectrum so that grey
 * is constant. It reads Kd, Ks, Ns and Ke, and skips all else, since the format has many dialects.
 * An entry is read only if a scene uses it. */
#include "data/scene/inside.h"

enum statement { KD, KS, KE, NS, STATEMENTS };
static const char *const statements[STATEMENTS] = {"Kd", "Ks", "Ke", "Ns"};

/* Makes a spectrum of a colour: blue up to 480 nm, green from 500 to 570 nm, red from 600 nm on. It
 * begins and ends beyond all light, so that nobody reads past its ends. */
static bool spread(const double colour[3], struct place place, const char *name,
                   struct spectrum *out, struct error *err)
{
    static const struct {
        double nm;
        int part;
    } knots[] = {{1, 2}, {480, 2}, {500, 1}, {570, 1}, {600, 0}, {999999, 0}};
    for (size_t i = 0; i < sizeof knots / sizeof knots[0]; i++)
        if (!spectrum_append(out, knots[i].nm, colour[knots[i].part], place, err))
            return false;
    return string_copy(name, &out->name, err);
}

/* Reads a colour into its spectrum, which stays absent where the colour is black. */
static bool read_colour(struct text *text, enum statement statement, struct place place,
                        struct material *out, struct error *err)
{
    static const char *const parts[] = {"red", "green", "blue"};
    struct spectrum *const spectra[] = {&out->diffuse, &out->specular, &out->glow};
    double colour[3];
    for (int i = 0; i < 3; i++) {
        char what[16];
        snprintf(what, sizeof what, "%s of %s", parts[i], statements[statement]);
        if (!text_number(text, what, 0, statement == KE ? HUGE_VAL : 1, &colour[i], err))
            return false;
    }
    return (colour[0] == 0 && colour[1] == 0 && colour[2] == 0) ||
           spread(colour, place, out->name, spectra[statement], err);
}

static bool read_statement(struct text *text, const struct word *first,
                           struct place given[STATEMENTS], struct material *out, struct error *err)
{
    int i = 0;
    while (i < STATEMENTS && !word_is(first, statements[i]))
        i++;
    if (i == STATEMENTS)
        return true;
    return place_once(&given[i], first->place, statements[i], err) &&
           (i == NS ? text_number(text, statements[i], 0, 1000, &out->gloss, err)
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

static bool find_entries(struct mtl *mtl, struct error *err)
{
    struct word word;
    while (text_next_line(&mtl->text))
        if (text_word(&mtl->text, &word) && word_is(&word, "newmtl") &&
            (!text_expect(&mtl->text, &word, "a name", err) || !add_entry(mtl, &word, err)))
            return false;
    return true;
}

bool mtl_open(const char *path, struct place from, struct mtl *out, struct error *err)
{
    *out = (struct mtl){.n_entries = 0};
    return text_open(&out->text, path, from, false, err) && find_entries(out, err);
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

/* An entry with Ks or Ke needs no Kd, which is 0 then. A highlight needs both Ks and Ns. Shininess
 * above 128, the largest of OpenGL, becomes 128. */
static bool complete(const struct place given[STATEMENTS], struct material *out, struct error *err)
{
    static const double black[3] = {0, 0, 0};
    if (given[KD].line == 0 && given[KS].line == 0 && given[KE].line == 0)
        return error_at(err, out->place, "the entry has none of Kd, Ks and Ke");
    out->from_rgb = true;
    out->gloss = out->specular.kind != SPECTRUM_NONE ? fmin(out->gloss, HIGHEST_GLOSS) : 0;
    out->gloss_place = given[NS];
    if (out->gloss == 0)
        spectrum_free(&out->specular);
    return out->diffuse.kind != SPECTRUM_NONE ||
           spread(black, given[KD].line > 0 ? given[KD] : out->place, out->name, &out->diffuse,
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
