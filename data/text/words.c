/* SPDX-License-Identifier: MIT */
/* Words with a meaning, and small tools for all statements of a scene, so that all of them refuse a
 * mistake in the same way. */
#include <math.h>
#include <string.h>
#include <strings.h>

#include "data/text/text.h"

/* Returns the index of a word in a list; -1: it is not there. */
static int find_word(const struct word *word, const char *const *known, bool exact)
{
    for (int i = 0; known[i] && !word->quoted; i++)
        if (exact ? word_equals(word, known[i])
                  : strlen(known[i]) == word->length &&
                        strncasecmp(word->start, known[i], word->length) == 0)
            return i;
    return -1;
}

int word_choose(const struct word *word, const char *const *known, const char *what,
                struct error *err)
{
    struct suggestion suggestion = {.distance = 0};
    int found = find_word(word, known, true);
    if (found < 0)
        found = find_word(word, known, false);
    if (found >= 0)
        return found;
    for (int i = 0; known[i] && word->quoted; i++)
        if (word_equals(word, known[i])) {
            error_at(err, word->place, "'%s' is a word; write it without quotes", known[i]);
            return -1;
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
