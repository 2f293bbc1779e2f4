/* SPDX-License-Identifier: MIT */
/* The room "text": strict words and numbers in, JSON out. */
#ifndef TEXT_H
#define TEXT_H

#include "data/base/base.h"
#include "data/output/output.h"
#include "data/maths/maths.h"
#include "spectral.h"

/* ---- text.c: a text file, word by word ---- */

/* A text file that is being read. Lines end in \n or \r\n. '#' outside quotes starts a comment.
 * Blanks, tabs and the characters in `separators` separate words. "..." is one word. */
struct text {
    char *path;  /* owned */
    char *bytes; /* owned */
    size_t length;
    const char *at, *line_start, *line_end; /* cursor, current line */
    int line;
    const char *separators; /* more separators, e.g. ",;"; never NULL after text_open */
};

/* A word is a slice of its text, not terminated. It is valid while the text is open. */
struct word {
    const char *start;
    size_t length;
    bool quoted;
    struct place place;
};

/* Opens a file. `from` is the place that names it. No line is current yet. Refuses a line of more
 * than 64 MiB, and a file of more than 256 MiB; text_open_large opens files of up to 2 GiB. */
bool text_open(struct text *out, const char *path, struct place from, struct error *err);
bool text_open_large(struct text *out, const char *path, struct place from, struct error *err);
/* Opens standard input, which is read to its end. `name` takes the place of the path. */
bool text_open_input(struct text *out, const char *name, struct error *err);
/* Opens a string as a text. `name` takes the place of the path in messages. Both are copied. */
bool text_open_string(struct text *out, const char *name, const char *string, struct error *err);
/* Opens a string of one line, which becomes the current line. Refuses any other string. */
bool text_open_line(struct text *out, const char *name, const char *line, struct error *err);
void text_free(struct text *text);

/* Goes to the next line, blank or not. Returns false at the end of the file. */
bool text_next_line(struct text *text);
/* Reads the next word of the current line. Returns false at its end. An unclosed quote yields the
 * rest of the line as a word with `quoted` set and start[length] != '"'; text_expect, text_end and
 * the functions for numbers refuse it. */
bool text_word(struct text *text, struct word *out);
/* Reads the word that text_word would read. The cursor of the caller's text stays. */
bool text_peek(struct text text, struct word *out);
/* Like text_word, but refuses the end of the line: "expected WHAT". */
bool text_expect(struct text *text, struct word *out, const char *what, struct error *err);
/* Refuses a further word on this line: "WORD is too much: WHAT takes no more". */
bool text_end(struct text *text, const char *what, struct error *err);
/* Return the cursor as a place, as for "expected ..." at the end of a line, and the whole file. */
struct place text_place(const struct text *text);
struct place text_whole(const struct text *text);

/* Returns how many bytes of a word a message shows: the precision of %.*s. */
int word_shown(const struct word *word);
bool word_is(const struct word *word, const char *literal);    /* false for quoted words */
bool word_equals(const struct word *word, const char *string); /* quoted or not */
char *word_copy(const struct word *word, struct error *err);   /* allocated; NULL: no memory */
/* Read a whole number or refuse it: 1.5abc, 1e999, nan, inf and 0x10 are errors. `what` names the
 * number in messages. Ranges are inclusive; -HUGE_VAL and HUGE_VAL set no limit. */
bool word_number(const struct word *word, const char *what, double lowest, double highest,
                 double *out, struct error *err);
bool word_integer(const struct word *word, const char *what, long lowest, long highest, long *out,
                  struct error *err);
/* Read the next word likewise. */
bool text_number(struct text *text, const char *what, double lowest, double highest, double *out,
                 struct error *err);
bool text_integer(struct text *text, const char *what, long lowest, long highest, long *out,
                  struct error *err);

/* ---- suggest.c: "did you mean ...?" ---- */

enum { LIST_SIZE = 512 };
/* The known words beside an unknown one. Zero it before use. */
struct suggestion {
    char known[LIST_SIZE], nearest[64], text[LIST_SIZE + 64];
    int distance; /* of the nearest one from the typed word */
};
/* Adds a known word, and compares it with the typed one. */
void suggestion_add(struct suggestion *suggestion, const struct word *typed, const char *known,
                    size_t length);
/* Returns "did you mean NEAREST?" if a known word is near, or else the list behind the words
 * `otherwise`: "known are A, B". Valid as long as *suggestion. */
const char *suggestion_end(struct suggestion *suggestion, const char *otherwise);

/* ---- words.c: tools for statements of all kinds, so that all refuse a mistake alike ---- */

/* Returns the index of the word in `known`, which ends with NULL; ignores case where no word is the
 * same. Returns -1 for any other word, with an error that proposes the nearest known one. `what`
 * names the word in the message. */
int word_choose(const struct word *word, const char *const *known, const char *what,
                struct error *err);
/* Finds the next word among the known ones. Without a word the error is "expected EXPECTED". */
int text_choose(struct text *text, const char *expected, const char *const *known, const char *what,
                struct error *err);
/* Sets *first to `again` if it has no line yet. Otherwise refuses: "WHAT is given twice". */
bool place_once(struct place *first, struct place again, const char *what, struct error *err);
/* Like word_choose; then notes the place in given[index], and refuses a word that has one there. */
int word_choose_once(const struct word *word, const char *const *known, const char *what,
                     struct place *given, struct error *err);
/* Returns whether the word, which is not empty, begins with a digit, a sign or a point and has no
 * quotes. */
bool word_begins_number(const struct word *word);
/* Copies a string into an allocated one. A NULL stays NULL. */
bool string_copy(const char *from, char **out, struct error *err);
/* Returns the place of the next word, or of the line's end. */
struct place text_next_place(struct text text);
/* Reads three numbers; text_direction refuses 0 0 0. */
bool text_vector(struct text *text, const char *what, struct vector *out, struct error *err);
bool text_direction(struct text *text, const char *what, struct vector *out, struct error *err);

/* Prints a text within a quoted field of CSV (RFC 4180): doubles its quotation marks. */
void csv_text(const char *text, struct printed *to);

/* ---- json.c: facts out, as JSON (RFC 8259) or in words ---- */

/* A text that grows as it is written. */
struct json {
    struct printed printed;
    bool separated;   /* the next member needs a comma before it */
    bool words;       /* lines for a reader in place of JSON */
    int depth;        /* of words: objects around the next line */
    const char *list; /* of words: the key of the list whose entries are written; NULL: none */
    int n_row;        /* of words: 1 and the members of the entry so far; 0: no entry is open */
};
/* Begins a text, which is an object. When memory runs out, here or later, only json_take reports
 * it. */
void json_begin(struct json *json);
/* Begins a text in words: the member "scene_sha256" becomes a line "scene sha256   VALUE", and each
 * entry of the list "files" a line "file   VALUE". A value that is null gets no line. */
void words_begin(struct json *json);
/* Each writes one member of an object, or of an array, whose members have no key: key NULL.
 * Brackets are '{' or '[' to open, '}' or ']' to close. */
void json_open(struct json *json, const char *key, char bracket);
void json_close(struct json *json, char bracket);
void json_string(struct json *json, const char *key, const char *value); /* NULL: null */
/* Infinity and NaN become null: JSON has neither. */
void json_number(struct json *json, const char *key, double value);
void json_count(struct json *json, const char *key, uint64_t value);
void json_truth(struct json *json, const char *key, bool value);
/* An array; null where values is NULL. Words name the first and the last number. */
void json_numbers(struct json *json, const char *key, const double *values, int n);
/* Ends the object and the text. Returns it, and it then belongs to the caller; NULL: no memory. */
char *json_take(struct json *json, struct error *err);
/* Ends both and writes the text to a file, as file_write; words appear on standard output. */
bool json_write(struct json *json, const char *path, struct outputs *outputs, struct error *err);

#endif
