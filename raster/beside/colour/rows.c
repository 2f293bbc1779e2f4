/* SPDX-License-Identifier: MIT */
/* Small tables with three numbers a row: a matrix, the numbers of a display. */
#include "raster/beside/colour/colour.h"

/* A line without any number is a heading. */
static bool is_heading(struct text text)
{
    struct word word;
    while (text_word(&text, &word))
        if (word_begins_number(&word))
            return false;
    return true;
}

static bool read_row(struct text *text, const char *name, double out[3], struct error *err)
{
    struct word word;
    if (text_peek(*text, &word) && !word_begins_number(&word) && text_word(text, &word) &&
        !word_equals(&word, name))
        return error_at(err, word.place, "expected the row of '%s', found '%.*s'", name,
                        word_shown(&word), word.start);
    for (int i = 0; i < 3; i++)
        if (!text_number(text, "a value of the row", -1e30, 1e30, &out[i], err))
            return false;
    return text_end(text, "a row of three numbers", err);
}

bool rows_of_three(const char *path, const char *const *names, int n, double (*out)[3],
                   struct error *err)
{
    struct text text;
    int n_read = 0;
    bool done = text_open(&text, path, NOWHERE, 0, err);
    if (!done)
        return false;
    text.separators = ",;";
    while (done && text_next_line(&text))
        if (!is_heading(text)) {
            done = n_read < n ? read_row(&text, names[n_read], out[n_read], err)
                              : error_at(err, text_place(&text), "expected %d rows, no more", n);
            n_read++;
        }
    if (done && n_read < n)
        done = error_at(err, text_whole(&text), "expected %d rows of three numbers, found %d", n,
                        n_read);
    text_free(&text);
    return done;
}
