/* SPDX-License-Identifier: MIT */
/* Strict words and numbers for all readers: a number is read whole or refused, and every word knows
 * its line and column. Words are slices, so that a file with millions of numbers costs no
 * allocation. The bytes end in a NUL past `length` and hold none before it (file_read), so looking
 * one character past a word is safe. */
#include "spectral.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    SHOWN_WORD = 40,    /* bytes of a word that a message repeats */
    LONGEST_NUMBER = 1024 /* a double's exact decimal expansion has at most 767 digits */
};

/* ---- lines ---- */

static void start(struct text *text)
{
    /* Spreadsheets begin UTF-8 files with a byte order mark; it is no part of the first word. */
    const char *first = text->bytes;
    if (strncmp(first, "\xEF\xBB\xBF", 3) == 0)
        first += 3;
    text->at = text->line_start = text->line_end = first;
    text->line = 0;
    text->separators = "";
}

bool text_open(struct text *out, const char *path, struct place from, struct error *err)
{
    *out = (struct text){0};
    if (!file_read(path, from, &out->bytes, &out->length, err))
        return false;
    out->path = strdup(path);
    if (out->path == NULL) {
        text_free(out);
        return error_memory(err);
    }
    start(out);
    return true;
}

bool text_open_string(struct text *out, const char *name, const char *string, struct error *err)
{
    *out = (struct text){0};
    out->path = strdup(name);
    out->bytes = strdup(string);
    if (out->path == NULL || out->bytes == NULL) {
        text_free(out);
        return error_memory(err);
    }
    out->length = strlen(string);
    start(out);
    return true;
}

void text_free(struct text *text)
{
    free(text->path);
    free(text->bytes);
    *text = (struct text){0};
}

bool text_next_line(struct text *text)
{
    const char *end = text->bytes + text->length, *next = text->line_end, *newline;
    text->at = next;
    if (text->line > 0) {
        next += *next == '\r';
        next += *next == '\n';
    }
    if (next == end)
        return false;
    newline = memchr(next, '\n', (size_t)(end - next));
    text->line_end = newline != NULL ? newline : end;
    if (newline != NULL && newline > next && newline[-1] == '\r')
        text->line_end--;
    text->at = text->line_start = next;
    text->line++;
    return true;
}

static struct place place_of(const struct text *text, const char *at)
{
    struct place place = {text->path, text->line, (int)(at - text->line_start) + 1};
    return place;
}

struct place text_place(const struct text *text)
{
    return text->line > 0 ? place_of(text, text->at) : text_whole(text);
}

struct place text_whole(const struct text *text)
{
    struct place place = {text->path, 0, 0};
    return place;
}

/* ---- words ---- */

static bool separates(const struct text *text, char c)
{
    return c == ' ' || c == '\t' ||
           (text->separators[0] != '\0' && strchr(text->separators, c) != NULL);
}

/* A closing quote must end the word: "a"b and "a""b" hide a missing blank. Such a word, like an
 * unclosed one, gets the rest of the line; start[length] is then the line's end, never a quote. */
static const char *quoted_end(const struct text *text, const char *first)
{
    const char *quote = memchr(first, '"', (size_t)(text->line_end - first));
    if (quote == NULL)
        return text->line_end;
    if (quote + 1 == text->line_end || quote[1] == '#' || separates(text, quote[1]))
        return quote;
    return text->line_end;
}

bool text_word(struct text *text, struct word *out)
{
    const char *at = text->at, *end = text->line_end;
    while (at < end && separates(text, *at))
        at++;
    text->at = at;
    if (at == end || *at == '#')
        return false;
    out->place = place_of(text, at);
    out->quoted = *at == '"';
    if (out->quoted) {
        out->start = at + 1;
        at = quoted_end(text, at + 1);
        text->at = at + (at < end);
    } else {
        out->start = at;
        while (at < end && *at != '#' && !separates(text, *at))
            at++;
        text->at = at;
    }
    out->length = (size_t)(at - out->start);
    return true;
}

/* The word for a message, cut between characters of UTF-8. */
static const char *shown(const struct word *word, char out[SHOWN_WORD + 4])
{
    size_t length = word->length;
    if (length > SHOWN_WORD) {
        length = SHOWN_WORD;
        while (length > 0 && ((unsigned char)word->start[length] & 0xC0) == 0x80)
            length--;
    }
    memcpy(out, word->start, length);
    strcpy(out + length, length < word->length ? "..." : "");
    return out;
}

static bool word_check(const struct word *word, struct error *err)
{
    char buffer[SHOWN_WORD + 4];
    if (!word->quoted || word->start[word->length] == '"')
        return true;
    return error_at(err, word->place,
                    "the quote before '%s' must be closed on its line and a blank follow it",
                    shown(word, buffer));
}

bool text_expect(struct text *text, struct word *out, const char *what, struct error *err)
{
    if (!text_word(text, out))
        return error_at(err, text_place(text), "expected %s", what);
    return word_check(out, err);
}

bool text_end(struct text *text, const char *what, struct error *err)
{
    char buffer[SHOWN_WORD + 4];
    struct word word;
    if (!text_word(text, &word))
        return true;
    if (!word_check(&word, err))
        return false;
    return error_at(err, word.place, "'%s' is too much: %s takes no more", shown(&word, buffer),
                    what);
}

bool word_is(const struct word *word, const char *literal)
{
    return !word->quoted && strlen(literal) == word->length &&
           memcmp(word->start, literal, word->length) == 0;
}

char *word_copy(const struct word *word)
{
    return strndup(word->start, word->length);
}

/* ---- numbers ---- */

/* A decimal number as written: (-1)^negative * digits * 10^exponent, unless digits were dropped. */
struct decimal {
    uint64_t digits;
    long exponent;
    bool negative, dropped;
};

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static const char *scan_sign(const char *at, const char *end, bool *negative)
{
    *negative = at < end && *at == '-';
    return at + (at < end && (*at == '-' || *at == '+'));
}

/* [+-] digits with at most one point among them, at least one digit. NULL: not so. */
static const char *scan_digits(const char *at, const char *end, struct decimal *out)
{
    bool any = false, point = false;
    for (; at < end && (is_digit(*at) || (*at == '.' && !point)); at++) {
        if (*at == '.') {
            point = true;
            continue;
        }
        any = true;
        if (out->digits > UINT64_MAX / 10 - 1) {
            out->dropped = true;
            continue;
        }
        out->digits = 10 * out->digits + (uint64_t)(*at - '0');
        out->exponent -= point;
    }
    return any ? at : NULL;
}

/* e or E, a sign, digits. NULL: no digit. Exponents stop growing where they decide nothing more. */
static const char *scan_exponent(const char *at, const char *end, struct decimal *out)
{
    bool negative;
    long exponent = 0;
    at = scan_sign(at + 1, end, &negative);
    if (at == end || !is_digit(*at))
        return NULL;
    for (; at < end && is_digit(*at); at++)
        if (exponent < 1000000)
            exponent = 10 * exponent + (*at - '0');
    out->exponent += negative ? -exponent : exponent;
    return at;
}

static bool scan_number(const struct word *word, struct decimal *out)
{
    const char *at = word->start, *end = at + word->length;
    *out = (struct decimal){0};
    if (word->quoted || word->length >= LONGEST_NUMBER)
        return false;
    at = scan_digits(scan_sign(at, end, &out->negative), end, out);
    if (at != NULL && at < end && (*at == 'e' || *at == 'E'))
        at = scan_exponent(at, end, out);
    return at == end;
}

/* Up to 2^53 the digits are exact in a double, and so is 10^22 = 2^22 5^22 < 2^22 2^53; then one
 * multiplication or division, rounded once as IEEE 754 asks, is the correctly rounded value
 * (Clinger 1990). Wider evaluation would round twice. All else goes the slow way, equally exact. */
static double decimal_value(const struct word *word, const struct decimal *decimal)
{
    static const double power_of_ten[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                          1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                          1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const uint64_t exact = (uint64_t)1 << 53;
    char copy[LONGEST_NUMBER];
    if (FLT_EVAL_METHOD == 0 && !decimal->dropped && decimal->digits <= exact &&
        decimal->exponent >= -22 && decimal->exponent <= 22) {
        double value = (double)decimal->digits;
        if (decimal->exponent < 0)
            value /= power_of_ten[-decimal->exponent];
        else
            value *= power_of_ten[decimal->exponent];
        return decimal->negative ? -value : value;
    }
    memcpy(copy, word->start, word->length);
    copy[word->length] = '\0';
    return strtod(copy, NULL);
}

/* What the range asks for, in words; readers say "above 0" by a lowest value that is the smallest
 * positive number. */
static bool refuse_range(const struct word *word, const char *what, bool above, double lowest,
                         double highest, struct error *err)
{
    char buffer[SHOWN_WORD + 4], low[64], high[64];
    bool positive = lowest > 0 && lowest <= DBL_MIN;
    snprintf(low, sizeof low, "%.15g", positive ? 0 : lowest);
    snprintf(high, sizeof high, "%.15g", highest);
    shown(word, buffer);
    if (lowest == -HUGE_VAL)
        return error_at(err, word->place, "%s %s is above %s; it is at most %s", what, buffer,
                        high, high);
    if (highest == HUGE_VAL)
        return error_at(err, word->place, "%s %s is %s %s; it is %s %s", what, buffer,
                        positive ? "not above" : "below", low,
                        positive ? "always above" : "at least", low);
    return error_at(err, word->place, "%s %s is %s %s; it lies between %s and %s", what, buffer,
                    above ? "above" : (positive ? "not above" : "below"), above ? high : low, low,
                    high);
}

bool word_number(const struct word *word, const char *what, double lowest, double highest,
                 double *out, struct error *err)
{
    char buffer[SHOWN_WORD + 4];
    struct decimal decimal;
    double value;
    if (!word_check(word, err))
        return false;
    if (!scan_number(word, &decimal))
        return error_at(err, word->place, "%s must be a number such as 2.5 or 1e-3, not '%s'",
                        what, shown(word, buffer));
    value = decimal_value(word, &decimal);
    if (!isfinite(value))
        return error_at(err, word->place, "%s %s is too large; numbers end at %.2g", what,
                        shown(word, buffer), DBL_MAX);
    if (value < lowest || value > highest)
        return refuse_range(word, what, value > highest, lowest, highest, err);
    *out = value;
    return true;
}

bool word_integer(const struct word *word, const char *what, long lowest, long highest, long *out,
                  struct error *err)
{
    char buffer[SHOWN_WORD + 4];
    const char *end = word->start + word->length, *at;
    bool negative, fits = true;
    long value = 0;
    if (!word_check(word, err))
        return false;
    at = scan_sign(word->start, end, &negative);
    if (word->quoted || at == end || strspn(at, "0123456789") < (size_t)(end - at))
        return error_at(err, word->place, "%s must be a whole number, not '%s'", what,
                        shown(word, buffer));
    for (; at < end; at++) {
        fits = fits && value <= (LONG_MAX - (*at - '0')) / 10;
        value = fits ? 10 * value + (*at - '0') : LONG_MAX;
    }
    value = negative ? -value : value;
    if (!fits || value < lowest || value > highest)
        return error_at(err, word->place, "%s %s is out of range; it lies between %ld and %ld",
                        what, shown(word, buffer), lowest, highest);
    *out = value;
    return true;
}

bool text_number(struct text *text, const char *what, double lowest, double highest, double *out,
                 struct error *err)
{
    struct word word;
    return text_expect(text, &word, what, err) &&
           word_number(&word, what, lowest, highest, out, err);
}

bool text_integer(struct text *text, const char *what, long lowest, long highest, long *out,
                  struct error *err)
{
    struct word word;
    return text_expect(text, &word, what, err) &&
           word_integer(&word, what, lowest, highest, out, err);
}
