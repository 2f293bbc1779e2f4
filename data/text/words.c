/* SPDX-License-Identifier: MIT */
/* Words with a meaning, and small tools for all statements of a scene, so that all of them refuse a
 * mistake in the same way, and propose the known word that a mistyped one stands for. */
#include <ctype.h>
#include <strings.h>

#include "data/text/text.h"

/* ---- "did you mean ...?" ---- */

/* Longer words are compared by their first bytes. */
enum { COMPARED = 64, FAR = 2 * COMPARED };

static int lower(char c)
{
    return tolower((unsigned char)c);
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

/* Returns the least number of letters to insert, delete, replace or exchange with a neighbour that
 * makes b of a (Damerau 1964, each place edited once). Ignores case. Rows of the table are those of
 * the letters of a; three of them are kept. */
static int distance(const char *a, size_t n_a, const char *b, size_t n_b)
{
    int rows[3][COMPARED + 1];
    for (size_t j = 0; j <= n_b; j++)
        rows[0][j] = (int)j;
    for (size_t i = 1; i <= n_a; i++) {
        int *row = rows[i % 3], *above = rows[(i + 2) % 3], *second = rows[(i + 1) % 3];
        row[0] = (int)i;
        for (size_t j = 1; j <= n_b; j++) {
            const int replaced = above[j - 1] + (lower(a[i - 1]) != lower(b[j - 1]));
            row[j] = smaller(replaced, smaller(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
                lower(a[i - 2]) == lower(b[j - 1]))
                row[j] = smaller(row[j], second[j - 2] + 1);
        }
    }
    return rows[n_a % 3][n_b];
}

/* Returns how far a known word is from the typed one; FAR: it is another word. A third of the
 * letters may differ. One of them may be the beginning of the other, of three letters or more. */
static int distance_of(struct word typed, const char *known, size_t length)
{
    const size_t n_a = typed.length < COMPARED ? typed.length : COMPARED;
    const size_t n_b = length < COMPARED ? length : COMPARED;
    const size_t longer = n_a > n_b ? n_a : n_b;
    const size_t shorter = n_a < n_b ? n_a : n_b;
    if (shorter >= 3 && shorter < longer && strncasecmp(typed.start, known, shorter) == 0)
        return 0;
    const size_t found = (size_t)distance(typed.start, n_a, known, n_b);
    return 3 * found <= longer && found < longer ? (int)found : FAR;
}

/* Returns how many bytes of a name its folders have, with the last slash. */
static size_t folders(const char *name, size_t length)
{
    while (length > 0 && name[length - 1] != '/')
        length--;
    return length;
}

/* Compares the names, and the names without their folders. */
static int nearness(const struct word *typed, const char *known, size_t length)
{
    const size_t in_known = folders(known, length), in_typed = folders(typed->start, typed->length);
    const struct word last = {.start = typed->start + in_typed, .length = typed->length - in_typed};
    const int whole = distance_of(*typed, known, length);
    return in_known == 0
               ? whole
               : smaller(whole, distance_of(last, known + in_known, length - in_known) + 1);
}

/* Words of other programs, and what to write here in their place where the known word could stand.
 */
static const struct habit {
    const char *words, *known, *meant;
} habits[] = {
    {" // /* ; % ", "wavelengths", "# before a comment"},
    {" color colour rgb pigment albedo kd Kd ", "diffuse", "diffuse SPECTRUM (there is no RGB)"},
    {" red green blue black white ", "d65", "a number or a spectrum (there is no RGB)"},
    {" position direction ", "d65", "SPECTRUM INTENSITY before it"},
    {" daylight blackbody ", "d65", "daylight:6504 or blackbody:6504, in K"},
    {" shininess roughness phong Ns ", "gloss", "gloss, from 0 to 128"},
    {" location from position origin ", "eye", "eye"},
    {" at to target center ", "look", "look"},
    {" lookat look_at gluLookAt gluPerspective glOrtho ", "camera", "camera"},
    {" sphere torus box plane cylinder cone disk teapot mesh ", "object", "object before it"},
    {" cube cuboid ", "box", "box"},
    {" quad rectangle square ", "plane", "plane"},
    {" position move at ", "translate", "translate"},
    {" resolution image film ", "size", "size"},
};

/* Returns what is meant by a typed word where a known one could stand; NULL: it is no habit. */
static const char *meant_by(const struct word *typed, const char *known, size_t length)
{
    const struct word word = {.start = known, .length = length};
    char blank[32];
    snprintf(blank, sizeof blank, " %.*s ", (int)typed->length, typed->start);
    for (size_t i = 0; i < sizeof habits / sizeof *habits; i++)
        if (word_equals(&word, habits[i].known) && strstr(habits[i].words, blank))
            return habits[i].meant;
    return NULL;
}

void suggestion_add(struct suggestion *out, const struct word *typed, const char *known,
                    size_t length)
{
    const char *meant = meant_by(typed, known, length);
    const int found = meant ? 0 : nearness(typed, known, length);
    const size_t used = strlen(out->known);
    if (out->nearest[0] == '\0' ? found < FAR : found < out->distance) {
        out->distance = found;
        snprintf(out->nearest, sizeof out->nearest, "%.*s", meant ? 64 : (int)length,
                 meant ? meant : known);
    }
    /* the list is cut where its room ends */
    snprintf(out->known + used, LIST_SIZE - used, "%s%.*s", used > 0 ? ", " : "", (int)length,
             known);
}

const char *suggestion_end(struct suggestion *suggestion, const char *otherwise)
{
    const bool found = suggestion->nearest[0] != '\0';
    snprintf(suggestion->text, sizeof suggestion->text, "%s%s%s%s",
             found ? "did you mean" : otherwise, found || suggestion->known[0] != '\0' ? " " : "",
             found ? suggestion->nearest : suggestion->known, found ? "?" : "");
    return suggestion->text;
}

/* ---- words with a meaning ---- */

int word_find(const struct word *word, const char *const *known)
{
    for (int i = 0; known[i]; i++)
        if (word_is(word, known[i]))
            return i;
    return -1;
}

int word_choose(const struct word *word, const char *const *known, const char *what,
                struct error *err)
{
    struct suggestion suggestion = {.distance = 0};
    for (int i = 0; known[i]; i++)
        if (strlen(known[i]) == word->length &&
            strncasecmp(word->start, known[i], word->length) == 0) {
            if (word->quoted)
                error_at(err, word->place, "'%s' is a word; write it without quotes", known[i]);
            return word->quoted ? -1 : i;
        }
    for (int i = 0; known[i]; i++)
        suggestion_add(&suggestion, word, known[i], strlen(known[i]));
    error_at(err, word->place, "unknown %s '%.*s'; %s", what, word_shown(word), word->start,
             suggestion_end(&suggestion, "known are"));
    return -1;
}

int text_choose(struct text *text, const char *expected, const char *const *known, const char *what,
                struct error *err)
{
    struct word word;
    return text_expect(text, &word, expected, err) ? word_choose(&word, known, what, err) : -1;
}

bool path_ending(const char *path, const char *const *known, int *out, struct error *err)
{
    const char *name = path_name(path), *dot = strrchr(name, '.');
    *out = -1;
    if (!dot || dot == name || !dot[1])
        return true;
    const struct word word = {.start = dot, .length = strlen(dot), .place = {path, 0, 0}};
    *out = word_choose(&word, known, "ending", err);
    return *out >= 0;
}

bool place_once(struct place *first, struct place again, const char *what, struct error *err)
{
    if (first->line > 0)
        return error_at(err, again, "%s is given twice; the first is in line %d of %.200s", what,
                        first->line, first->path);
    *first = again;
    return true;
}

int word_choose_once(const struct word *word, const char *const *known, const char *what,
                     struct place *given, struct error *err)
{
    const int i = word_choose(word, known, what, err);
    return i >= 0 && place_once(&given[i], word->place, known[i], err) ? i : -1;
}

bool word_begins_number(const struct word *word)
{
    return !word->quoted && strchr("0123456789+-.", word->start[0]);
}

bool string_copy(const char *from, char **out, struct error *err)
{
    *out = from ? strdup(from) : NULL;
    return !from || *out || memory_lacks(err, (double)strlen(from) + 1, "the text '%.40s'", from);
}

bool text_peek(struct text text, struct word *out)
{
    return text_word(&text, out);
}

struct place text_next_place(struct text text)
{
    struct word word;
    return text_word(&text, &word) ? word.place : text_place(&text);
}

bool text_vector(struct text *text, const char *what, struct vector *out, struct error *err)
{
    double *parts[] = {&out->x, &out->y, &out->z};
    for (int i = 0; i < 3; i++) {
        char name[64];
        snprintf(name, sizeof name, "%c of %s", "xyz"[i], what);
        if (!text_number(text, name, -HUGE_VAL, HUGE_VAL, parts[i], err))
            return false;
    }
    return true;
}

bool text_direction(struct text *text, const char *what, struct vector *out, struct error *err)
{
    const struct place first = text_next_place(*text);
    if (!text_vector(text, what, out, err))
        return false;
    return out->x != 0 || out->y != 0 || out->z != 0 ||
           error_at(err, first, "%s 0 0 0 points nowhere; one of its numbers must not be 0", what);
}

void csv_text(const char *text, struct printed *to)
{
    for (; *text != '\0'; text++)
        print(to, *text == '"' ? "\"\"" : "%c", *text);
}
