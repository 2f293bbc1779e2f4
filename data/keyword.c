/* SPDX-License-Identifier: MIT */
/* Words that mean something, and the small things that all statements of a scene need: so that
 * every statement refuses a mistake in the same manner. */
#include "scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int word_choose(const struct word *word, const char *const *known, const char *what,
                struct error *err)
{
    char list[512] = "";
    size_t used = 0;
    for (int i = 0; known[i] != NULL; i++)
        if (word_is(word, known[i]))
            return i;
    for (int i = 0; known[i] != NULL && used < sizeof list; i++)
        used +=
            (size_t)snprintf(list + used, sizeof list - used, "%s%s", i > 0 ? ", " : "", known[i]);
    error_at(err, word->place, "unknown %s '%.*s'; known are %s", what, word_shown(word),
             word->start, list);
    return -1;
}

bool place_once(struct place first, struct place again, const char *what, struct error *err)
{
    if (first.line == 0)
        return true;
    return error_at(err, again, "%s is given twice; the first is in line %d of %.200s", what,
                    first.line, first.path);
}

char *word_path(const struct word *word, struct error *err)
{
    char *name, *path;
    if (word->length == 0) {
        error_at(err, word->place, "a file name must not be empty");
        return NULL;
    }
    name = word_copy(word);
    path = name != NULL ? file_relative(word->place.path, name) : NULL;
    free(name);
    if (path == NULL)
        error_memory(err);
    return path;
}

bool text_vector(struct text *text, const char *what, struct vector *out, struct place *place,
                 struct error *err)
{
    double *parts[] = {&out->x, &out->y, &out->z};
    for (int i = 0; i < 3; i++) {
        char name[64];
        struct word word;
        snprintf(name, sizeof name, "%c of %s", "xyz"[i], what);
        if (!text_expect(text, &word, name, err) ||
            !word_number(&word, name, -HUGE_VAL, HUGE_VAL, parts[i], err))
            return false;
        if (i == 0 && place != NULL)
            *place = word.place;
    }
    return true;
}

bool text_direction(struct text *text, const char *what, struct vector *out, struct error *err)
{
    struct place place;
    if (!text_vector(text, what, out, &place, err))
        return false;
    return out->x != 0 || out->y != 0 || out->z != 0 ||
           error_at(err, place, "%s 0 0 0 points nowhere; one of its numbers must not be 0", what);
}
