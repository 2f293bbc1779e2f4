/* SPDX-License-Identifier: MIT */
/* Reads entries of MTL files, the materials that come with OBJ models. A colour is three numbers,
 * which say nothing about single wavelengths. This file spreads them over the spectrum so that grey
 * is constant. It reads Kd, Ks, Ns and Ke, and skips all else, since the format has many dialects.
 * An entry is read only if a scene uses it. */
#include <math.h>
#include <string.h>

#include "data/material/material.h"

enum statement { KD, KS, KE, NS, STATEMENTS };
static const char *const statements[STATEMENTS] = {"Kd", "Ks", "Ke", "Ns"};

struct entry {
    double colour[NS][3]; /* red, green, blue */
    double shininess;     /* Ns: 0..1000 */
    struct place place, given[STATEMENTS];
};

static bool read_colour(struct text *text, enum statement statement, double out[3],
                        struct error *err)
{
    static const char *const parts[] = {"red", "green", "blue"};
    for (int i = 0; i < 3; i++) {
        char what[16];
        snprintf(what, sizeof what, "%s of %s", parts[i], statements[statement]);
        if (!text_number(text, what, 0, statement == KE ? HUGE_VAL : 1, &out[i], err))
            return false;
    }
    return true;
}

static bool read_statement(struct text *text, const struct word *first, struct entry *out,
                           struct error *err)
{
    int i = 0;
    while (i < STATEMENTS && !word_is(first, statements[i]))
        i++;
    if (i == STATEMENTS)
        return true;
    return place_once(&out->given[i], first->place, statements[i], err) &&
           (i == NS ? text_number(text, statements[i], 0, 1000, &out->shininess, err)
                    : read_colour(text, (enum statement)i, out->colour[i], err)) &&
           text_end(text, statements[i], err);
}

/* Reads the statements between the newmtl of the entry and the next newmtl. */
static bool read_entry(struct text *text, const struct word *name, struct place from,
                       struct entry *out, struct error *err)
{
    struct suggestion suggestion = {.distance = 0};
    struct word word;
    bool inside = false;
    while (text_next_line(text)) {
        if (!text_word(text, &word))
            continue;
        if (word_is(&word, "newmtl")) {
            if (!text_expect(text, &word, "a name", err))
                return false;
            suggestion_add(&suggestion, name, word.start, word.length);
            inside =
                word.length == name->length && memcmp(word.start, name->start, word.length) == 0;
            if (inside && !place_once(&out->place, word.place, "this entry", err))
                return false;
        } else if (inside && !read_statement(text, &word, out, err)) {
            return false;
        }
    }
    return out->place.line > 0 ||
           error_at(err, from, "no entry '%.*s' in %.200s; %s", word_shown(name), name->start,
                    text->path, suggestion_end(&suggestion, "its entries are"));
}

/* Makes a spectrum of a colour: blue up to 480 nm, green from 500 to 570 nm, red from 600 nm on. It
 * begins and ends beyond all light, so that nobody reads past its ends. */
static bool spread(const struct entry *entry, enum statement statement, const char *name,
                   struct spectrum *out, struct error *err)
{
    static const struct {
        double nm;
        int part;
    } knots[] = {{1, 2}, {480, 2}, {500, 1}, {570, 1}, {600, 0}, {999999, 0}};
    for (size_t i = 0; i < sizeof knots / sizeof knots[0]; i++)
        if (!spectrum_append(out, knots[i].nm, entry->colour[statement][knots[i].part],
                             entry->given[statement], err))
            return false;
    return string_copy(name, &out->name, err);
}

/* An entry with Ks or Ke needs no Kd, which is 0 then. A highlight needs both Ks and Ns. Shininess
 * above 128, the largest of OpenGL, becomes 128. */
static bool make_material(struct entry *entry, struct material *out, struct error *err)
{
    bool present[NS];
    struct place *given = entry->given;
    if (given[KD].line == 0) {
        if (given[KS].line == 0 && given[KE].line == 0)
            return error_at(err, entry->place, "the entry has none of Kd, Ks and Ke");
        given[KD] = entry->place;
    }
    for (int i = 0; i < NS; i++)
        present[i] = entry->colour[i][0] > 0 || entry->colour[i][1] > 0 || entry->colour[i][2] > 0;
    out->place = entry->place;
    out->from_rgb = true;
    out->gloss = present[KS] ? fmin(entry->shininess, HIGHEST_GLOSS) : 0;
    out->gloss_place = given[NS];
    return spread(entry, KD, out->name, &out->diffuse, err) &&
           (out->gloss == 0 || spread(entry, KS, out->name, &out->specular, err)) &&
           (!present[KE] || spread(entry, KE, out->name, &out->glow, err));
}

bool mtl_read(const char *path, struct place from, const struct word *name, struct material *out,
              struct error *err)
{
    struct entry entry = {.shininess = 0};
    struct text text;
    bool done;
    *out = (struct material){0};
    if (!text_open(&text, path, from, err))
        return false;
    out->path = text.path; /* taken over: the places point at it */
    out->name = word_copy(name);
    done = out->name ? read_entry(&text, name, from, &entry, err) && make_material(&entry, out, err)
                     : error_memory(err);
    text.path = NULL;
    text_free(&text);
    return done;
}
