/* SPDX-License-Identifier: MIT */
/* Finds the known word that a mistyped word stands for, so that a message can propose it. */
#include <ctype.h>
#include <string.h>
#include <strings.h>

#include "data/text/text.h"

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
        return 1;
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

/* Adds a name to a list in a message. Cuts the list where its room ends. */
static void list_add(char list[LIST_SIZE], const char *name, size_t length)
{
    size_t used = strlen(list);
    snprintf(list + used, LIST_SIZE - used, "%s%.*s", used > 0 ? ", " : "", (int)length, name);
}

void suggestion_add(struct suggestion *out, const struct word *typed, const char *known,
                    size_t length)
{
    const int found = nearness(typed, known, length);
    if (out->nearest[0] == '\0' ? found < FAR : found < out->distance) {
        out->distance = found;
        snprintf(out->nearest, sizeof out->nearest, "%.*s", (int)length, known);
    }
    list_add(out->known, known, length);
}

const char *suggestion_end(struct suggestion *suggestion, const char *otherwise)
{
    const bool found = suggestion->nearest[0] != '\0';
    snprintf(suggestion->text, sizeof suggestion->text, "%s%s%s%s",
             found ? "did you mean" : otherwise, found || suggestion->known[0] != '\0' ? " " : "",
             found ? suggestion->nearest : suggestion->known, found ? "?" : "");
    return suggestion->text;
}
