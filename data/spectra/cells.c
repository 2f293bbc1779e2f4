/* SPDX-License-Identifier: MIT */
/* The cells of a line of a table, as spreadsheets and instruments write them, and their numbers. */
#include "data/spectra/inside.h"

/* Returns whether a comment begins here: a # where a cell or a word could begin. */
static bool begins_comment(const struct text *text, const char *at)
{
    return *at == '#' && (at == text->line_start || strchr(" \t,;", at[-1]));
}

/* A semicolon, if there is one outside of quotes; otherwise a comma, unless a number follows a
 * blank where no comma is: then blanks separate, and commas are decimal. Tabs separate names that
 * may have blanks. */
void line_begin(struct table *table)
{
    const struct text *text = &table->text;
    bool comma = false, blank = false, quoted = false, gap = false, tab = false;
    char last = ',';
    table->separator = ';';
    for (const char *at = text->line_start; at < text->line_end; at++) {
        if (!quoted && begins_comment(text, at))
            break;
        quoted = quoted != (*at == '"');
        if (!quoted && *at == ';')
            return;
        comma = comma || (!quoted && *at == ',');
        blank = blank || (gap && last != ',' && strchr("0123456789+-.\"", *at));
        tab = tab || *at == '\t';
        gap = *at == ' ' || *at == '\t';
        last = gap ? last : *at;
    }
    table->separator = comma && !blank ? ',' : tab ? '\t' : ' ';
}

/* Returns the end of a cell without the blanks behind it. */
static const char *cell_end(const struct text *text, const char *at, char separator)
{
    const bool quotes = *at == '"';
    const char *end = at;
    bool quoted = false;
    for (; at < text->line_end && (quoted || (*at != separator && !begins_comment(text, at)));
         at++) {
        quoted = quotes && quoted != (*at == '"');
        if (*at != ' ' && *at != '\t')
            end = at + 1;
    }
    return end;
}

/* Reads the next cell of the current line, without the blanks around it. It may be empty, or in
 * quotes. Returns false behind the last cell. */
static bool read_cell(struct text *text, char separator, struct word *out)
{
    if (separator == ' ')
        return text_word(text, out);
    text->at += strspn(text->at, " \t");
    const char *at = text->at, *end = cell_end(text, at, separator);
    if (at == text->line_end || *at == '#')
        return false;
    *out = (struct word){.start = at, .length = (size_t)(end - at), .place = text_place(text)};
    if (out->length > 1 && *at == '"') {
        out->quoted = true;
        out->start++;
        out->length -= end[-1] == '"' ? 2 : 1;
    }
    text->at = end + strspn(end, " \t");
    text->at += *text->at == separator;
    return true;
}

bool line_cell(struct table *table, struct word *out)
{
    if (!read_cell(&table->text, table->separator, out))
        return false;
    if (!out->quoted || out->start[out->length] != '"')
        return true;
    out->quoted = false;
    for (; out->length > 0 && strchr(" \t", *out->start); out->start++)
        out->length--;
    while (out->length > 0 && strchr(" \t", out->start[out->length - 1]))
        out->length--;
    return true;
}

static bool take_mark(struct table *table, const struct word *word, struct error *err)
{
    char *comma = memchr(table->text.bytes + (word->start - table->text.bytes), ',', word->length);
    const bool point = memchr(word->start, '.', word->length) != NULL;
    const char mark = comma ? ',' : point ? '.' : 0;
    const int length = word_shown(word);
    if (comma && table->separator == ',')
        return error_at(err, word->place,
                        "%.*s has a decimal comma, but commas separate the columns; write a point, "
                        "or put semicolons between columns",
                        length, word->start);
    if (mark && table->mark && mark != table->mark)
        return error_at(err, word->place,
                        "%.*s has a decimal %s, but line %d has a decimal %s; expected one of them",
                        length, word->start, comma ? "comma" : "point", table->mark_line,
                        comma ? "point" : "comma");
    if (mark && !table->mark)
        table->mark_line = word->place.line;
    table->mark = mark ? mark : table->mark;
    if (comma && !point)
        *comma = '.';
    return true;
}

bool table_number(struct table *table, const struct word *word, const char *what, double *out,
                  struct error *err)
{
    if (word->length > 0 && word->start[word->length - 1] == '%')
        return error_at(err, word->place,
                        "'%.*s' has a percent sign; remove the signs, and write the name of the "
                        "table with *0.01 behind it",
                        word_shown(word), word->start);
    return take_mark(table, word, err) && word_number(word, what, -HUGE_VAL, HUGE_VAL, out, err);
}
