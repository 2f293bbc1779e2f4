/* SPDX-License-Identifier: MIT */
/* Strict words and numbers for all readers: a number is read whole or refused, and every word has
 * its line and column. A word is a slice of the file, so that millions of numbers need no
 * allocation. The bytes end in a NUL past `length`, and there is none before it (file_read). So it
 * is safe to read one character past a word. */
#include <ctype.h>
#include <float.h>
#include <limits.h>

#include "data/text/text.h"

enum { LONGEST_NUMBER = 1024 }; /* a double's exact decimal expansion has at most 767 digits */

/* ---- lines ---- */

/* Refuses a text that is too long, or that has a line that is. */
static bool check_lengths(const struct text *text, size_t longest, struct error *err)
{
    const char *at = text->bytes, *end = at + text->length, *next;
    struct place place = {text->path, 1, 1};
    if (text->length > longest)
        return error_at(err, text_whole(text), "the file has %zu MB; a text file has at most %d MB",
                        (text->length >> 20) + 1, LONGEST_TEXT >> 20);
    for (; (size_t)(end - at) > LONGEST_LINE; at = next + 1, place.line++) {
        next = memchr(at, '\n', (size_t)(end - at));
        next = next != NULL ? next : end;
        if ((size_t)(next - at) > LONGEST_LINE)
            return error_at(err, place, "the line has %zu MB; a line has at most %d MB",
                            ((size_t)(next - at) >> 20) + 1, LONGEST_LINE >> 20);
    }
    return true;
}

/* Refuses what is text, too, but has a form that none of our readers takes. */
static bool check_format(const struct text *text, bool xml, struct error *err)
{
    const char *format = format_of(text->at, text->length - (size_t)(text->at - text->bytes));
    return strcmp(format, "text") == 0 || format[0] == '\0' ||
           (xml && strcmp(format, "XML") == 0) ||
           error_at(err, text_whole(text), "the file is %s; expected plain text, as %s", format,
                    strcmp(format, "JCAMP-DX") == 0 ? "data/samples/to_csv.py writes"
                                                    : "scenes, tables and OBJ meshes are");
}

/* Starts to read bytes, which it owns from now on. Fails if they are NULL: no memory. The caller
 * frees *text, also after a failure. */
static bool start(struct text *text, const char *name, char *bytes, size_t longest,
                  struct error *err)
{
    *text = (struct text){.bytes = bytes, .separators = ""};
    if (!string_copy(name, &text->path, err) ||
        (bytes == NULL && !memory_lacks(err, 0, "the text of %s", name)))
        return false;
    text->length = strlen(bytes);
    /* Spreadsheets begin UTF-8 files with a byte order mark. It is not part of the first word. */
    text->at = bytes + (strncmp(bytes, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0);
    text->line_start = text->line_end = text->at;
    /* Lines of classic Macs, and of Excel there, end in \r alone. They become \n. */
    if (strchr(bytes, '\n') == NULL)
        while ((bytes = strchr(bytes, '\r')) != NULL)
            *bytes++ = '\n';
    return check_lengths(text, longest, err);
}

bool text_open(struct text *out, const char *path, struct place from, int may, struct error *err)
{
    const size_t longest = may & TEXT_LARGE ? SIZE_MAX : LONGEST_TEXT;
    char *bytes = file_read(path, from, err);
    const bool noted = bytes && digest_note(path, bytes, strlen(bytes), err);
    const bool done = start(out, path, bytes, longest, err) && noted &&
                      check_format(out, (may & TEXT_XML) != 0, err);
    if (!done)
        text_free(out);
    return done;
}

bool text_open_string(struct text *out, const char *name, const char *string, struct error *err)
{
    const bool done = start(out, name, strdup(string), LONGEST_TEXT, err);
    if (!done)
        text_free(out);
    return done;
}

void text_free(struct text *text)
{
    FREE_ALL(text->path, text->bytes);
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
    return (struct place){text->path, text->line, (int)(at - text->line_start) + 1};
}

struct place text_place(const struct text *text)
{
    return text->line > 0 ? place_of(text, text->at) : text_whole(text);
}

struct place text_whole(const struct text *text)
{
    return (struct place){text->path, 0, 0};
}

/* ---- words ---- */

static bool separates(const struct text *text, char c)
{
    return c == ' ' || c == '\t' ||
           (text->separators[0] != '\0' && strchr(text->separators, c) != NULL);
}

/* Finds the closing quote. It must end the word: in "a"b and "a""b" a blank is missing. Such a
 * word, and one without a closing quote, gets the rest of the line; start[length] is then the end
 * of the line, and not a quote. */
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
    out->tables = text->tables;
    out->quoted = *at == '"';
    out->start = at + out->quoted;
    if (out->quoted)
        at = quoted_end(text, out->start);
    else
        while (at < end && !separates(text, *at))
            at++;
    text->at = at + (out->quoted && at < end); /* behind the quote that closes */
    out->length = (size_t)(at - out->start);
    return true;
}

bool text_rest(struct text *text, struct word *out)
{
    struct word next;
    if (!text_word(text, out))
        return false;
    while (text_word(text, &next)) {
        out->start -= out->quoted;
        out->quoted = false;
        out->length = (size_t)(text->at - out->start);
    }
    return true;
}

int word_shown(const struct word *word)
{
    const size_t most = 40;
    size_t length = word->length < most ? word->length : most;
    while (length > 0 && length < word->length && (word->start[length] & 0xC0) == 0x80)
        length--; /* cuts between characters of UTF-8 */
    return (int)length;
}

static bool word_check(const struct word *word, struct error *err)
{
    return !word->quoted || word->start[word->length] == '"' ||
           error_at(err, word->place,
                    "the quote before '%.*s' must be closed on its line and a blank follow it",
                    word_shown(word), word->start);
}

bool text_expect(struct text *text, struct word *out, const char *what, struct error *err)
{
    if (!text_word(text, out))
        return error_at(err, text_place(text), "expected %s", what);
    return word_check(out, err);
}

bool text_end(struct text *text, const char *what, struct error *err)
{
    struct word word;
    if (!text_word(text, &word))
        return true;
    return word_check(&word, err) &&
           error_at(err, word.place, "'%.*s' is too much: %s takes no more", word_shown(&word),
                    word.start, what);
}

bool word_equals(const struct word *word, const char *string)
{
    return strlen(string) == word->length && memcmp(word->start, string, word->length) == 0;
}

bool word_is(const struct word *word, const char *literal)
{
    return !word->quoted && word_equals(word, literal);
}

char *word_copy(const struct word *word, struct error *err)
{
    struct printed printed = {.text = NULL};
    print_bytes(&printed, word->start, word->length);
    return printed_take(&printed, err);
}

/* ---- numbers ---- */

/* Reads a decimal number: digits with one point or none, and perhaps an exponent. strtod also takes
 * blanks, hexadecimal digits, "nan" and "inf". A word is not terminated, and what follows could be
 * read as a part of a number. */
static bool read_number(const struct word *word, double *out)
{
    char copy[LONGEST_NUMBER], *end;
    if (word->quoted || word->length == 0 || word->length >= LONGEST_NUMBER)
        return false;
    memcpy(copy, word->start, word->length);
    copy[word->length] = '\0';
    *out = strtod(copy, &end);
    return *end == '\0' && !isspace((unsigned char)copy[0]) && !strpbrk(copy, "xXnN");
}

bool word_is_number(const struct word *word, double lowest, double *out)
{
    return read_number(word, out) && isfinite(*out) && *out >= lowest;
}

/* Names the range that was expected. A caller asks for "above 0" by the smallest positive number as
 * the lowest value. */
static bool refuse_range(const struct word *word, const char *what, bool above, double lowest,
                         double highest, struct error *err)
{
    const bool positive = lowest > 0 && lowest <= DBL_MIN;
    const double low = positive ? 0 : lowest;
    const char *side = above ? "above" : positive ? "not above" : "below";
    char asked[128];
    if (positive && !above && highest == HUGE_VAL)
        return error_at(err, word->place, "%s %.*s must be above 0", what, word_shown(word),
                        word->start);
    if (lowest == -HUGE_VAL)
        snprintf(asked, sizeof asked, "is at most %.15g", highest);
    else if (highest == HUGE_VAL)
        snprintf(asked, sizeof asked, "is at least %.15g", low);
    else
        snprintf(asked, sizeof asked, "lies between %.15g and %.15g", low, highest);
    return error_at(err, word->place, "%s %.*s is %s %.15g; it %s", what, word_shown(word),
                    word->start, side, above ? highest : low, asked);
}

/* Refuses a word that is no number. Names the number that it may stand for: 400 for 400nm, 0.5 for
 * 50% and 0,5, 1 for <1,0,0>. */
static bool refuse_word(const struct word *word, const char *what, struct error *err)
{
    char copy[64], example[32] = "2.5 or 1e-3", *end;
    snprintf(copy, sizeof copy, "%.*s", word_shown(word), word->start);
    char *start = copy + (copy[0] == '<'), *comma = strchr(copy, ',');
    if (comma && !strchr(comma + 1, ','))
        *comma = '.';
    const double value = strtod(start, &end), meant = *end == '%' ? value / 100 : value;
    if (end > start && *end != '.' && isfinite(meant) && !word->quoted)
        snprintf(example, sizeof example, "%.15g", meant);
    return error_at(err, word->place, "%s must be a number such as %s, not '%.*s'", what, example,
                    word_shown(word), word->start);
}

bool word_number(const struct word *word, const char *what, double lowest, double highest,
                 double *out, struct error *err)
{
    double value;
    if (!word_check(word, err))
        return false;
    if (!read_number(word, &value))
        return refuse_word(word, what, err);
    if (!isfinite(value))
        return error_at(err, word->place, "%s %.*s is too large; numbers end at %.2g", what,
                        word_shown(word), word->start, DBL_MAX);
    if (value < lowest || value > highest)
        return refuse_range(word, what, value > highest, lowest, highest, err);
    *out = value;
    return true;
}

bool word_integer(const struct word *word, const char *what, long lowest, long highest, long *out,
                  struct error *err)
{
    char *end;
    if (!word_check(word, err))
        return false;
    errno = 0;
    *out = strtol(word->start, &end, 10);
    if (word->quoted || word->length == 0 || end != word->start + word->length ||
        isspace((unsigned char)word->start[0]))
        return error_at(err, word->place, "%s must be a whole number, not '%.*s'", what,
                        word_shown(word), word->start);
    return (errno == 0 && *out >= lowest && *out <= highest) ||
           error_at(err, word->place, "%s %.*s is out of range; it lies between %ld and %ld", what,
                    word_shown(word), word->start, lowest, highest);
}

static bool expect_number(struct text *text, struct word *out, const char *what, struct error *err)
{
    char expected[128];
    snprintf(expected, sizeof expected, "a number: %s", what);
    return text_expect(text, out, expected, err);
}

bool text_number(struct text *text, const char *what, double lowest, double highest, double *out,
                 struct error *err)
{
    struct word word;
    return expect_number(text, &word, what, err) &&
           word_number(&word, what, lowest, highest, out, err);
}

bool text_integer(struct text *text, const char *what, long lowest, long highest, long *out,
                  struct error *err)
{
    struct word word;
    return expect_number(text, &word, what, err) &&
           word_integer(&word, what, lowest, highest, out, err);
}
