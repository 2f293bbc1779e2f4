/* SPDX-License-Identifier: MIT */
/* Reads tables of columns, as spreadsheets and instruments write them: a wavelength and its values
 * a row. A file that can be read in two ways is refused, with the words that decide. */
#include "data/spectra/inside.h"

/* Returns whether a comment begins here: a # where a field or a word could begin. */
static bool begins_comment(const struct text *text, const char *at)
{
    return *at == '#' && (at == text->line_start || strchr(" \t,;", at[-1]));
}

/* Returns the character that separates the columns of the current line: a semicolon, if there is
 * one outside of quotes; otherwise a comma, unless a number follows a blank where no comma is: then
 * blanks separate, and commas are decimal. */
static char find_separator(const struct text *text)
{
    bool comma = false, blank = false, quoted = false, gap = false;
    char last = ',';
    for (const char *at = text->line_start; at < text->line_end; at++) {
        if (!quoted && begins_comment(text, at))
            break;
        quoted = quoted != (*at == '"');
        if (!quoted && *at == ';')
            return ';';
        comma = comma || (!quoted && *at == ',');
        blank = blank || (gap && last != ',' && strchr("0123456789+-.\"", *at));
        gap = *at == ' ' || *at == '\t';
        last = gap ? last : *at;
    }
    return comma && !blank ? ',' : ' ';
}

/* Returns the end of a field without the blanks behind it. */
static const char *field_end(const struct text *text, const char *at, char separator)
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

/* Reads the next field of the current line, without the blanks around it. It may be empty, or in
 * quotes. Returns false behind the last field. */
static bool read_field(struct text *text, char separator, struct word *out)
{
    const char *at = text->at, *end = text->line_end;
    if (separator == ' ')
        return text_word(text, out);
    while (at < end && (*at == ' ' || *at == '\t'))
        at++;
    text->at = at;
    if (at == end || *at == '#')
        return false;
    end = field_end(text, at, separator);
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

bool table_field(struct table *table, struct word *out)
{
    if (!read_field(&table->text, table->separator, out))
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

bool table_mark(struct table *table, const struct word *word, struct error *err)
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

static bool refuse_row(const struct word *word, struct error *err)
{
    return error_at(err, word->place,
                    "expected a wavelength in nm, found '%.*s'; put # before a line that is no row "
                    "of the table",
                    word_shown(word), word->start);
}

/* Reads a wavelength, which may have its unit nm. */
static bool read_wavelength(struct table *table, struct word *word, double *out, struct error *err)
{
    const size_t length = word->length;
    struct text ahead = table->text;
    struct word unit;
    if (!word_begins_wavelength(word) && !word->quoted)
        return refuse_row(word, err);
    if (length > 2 && strncmp(word->start + length - 2, "nm", 2) == 0)
        for (word->length -= 2; strchr(" \t", word->start[word->length - 1]);)
            word->length--;
    else if (table->separator == ' ' && text_word(&ahead, &unit) && word_is(&unit, "nm"))
        table->text = ahead;
    return table_mark(table, word, err) &&
           word_number(word, "wavelength", -HUGE_VAL, HUGE_VAL, out, err);
}

/* Drops names of a heading that do not fit the columns, and numbers columns without a name. */
static bool name_columns(struct table *table, long n_columns, struct error *err)
{
    if (table->names.n > n_columns) {
        set_names_free(&table->names);
        table->names = (struct set_names){0};
    }
    while (table->names.n < n_columns)
        if (!names_add(table, NULL, err))
            return false;
    return true;
}

/* Keeps the number of columns, or refuses it. */
static bool check_columns(struct table *table, long n_columns, struct place place,
                          struct error *err)
{
    const struct columns *wanted = table->wanted;
    const bool named = table->names.n == n_columns;
    const char *advice = table->separator == ',' && n_columns > 1
                             ? "; if its commas are decimal, put semicolons between columns"
                             : "";
    char name[LABEL_SIZE];
    table->n_columns = n_columns;
    if (!name_columns(table, n_columns, err))
        return false;
    if (wanted->sample.length > 0 && table->first == 0)
        return sample_unknown(table, err);
    if (table->first > n_columns)
        return error_at(err, wanted->table.place, "'%.*s' has no value column %ld; its last is %ld",
                        word_shown(&wanted->table), wanted->table.start, table->first, n_columns);
    if (wanted->all || wanted->is_set)
        return true;
    if (wanted->count == 0 && n_columns == 3 && !named)
        return error_at(err, place,
                        "the columns have no names; write a heading, 'wavelength,x,y,z' for an "
                        "observer or 'wavelength,r,g,b' for a camera");
    return wanted->count != 1 || table->first > 0 || n_columns == 1 ||
           error_at(err, wanted->table.place,
                    "'%s' has %ld value columns; write '%s:1' for the first of them, or its name%s",
                    table_label(table, name), n_columns, name, advice);
}

/* Reads the values of a row. Empty fields may only stand behind the last value. */
static bool read_values(struct table *table, long *n_values, struct error *err)
{
    const struct columns *wanted = table->wanted;
    const long first = table->first > 0 ? table->first : 1;
    struct place empty = {0};
    struct word word;
    double value;
    *n_values = 0;
    while (table_field(table, &word)) {
        if (word.length == 0 && !word.quoted) {
            empty = empty.line > 0 ? empty : word.place;
            continue;
        }
        if (empty.line > 0)
            return error_at(err, empty, "expected a value; this column is empty");
        const long i = ++*n_values - first;
        const bool kept = i >= 0 && (wanted->count == 0 || i < wanted->count);
        if (!table_mark(table, &word, err) ||
            !(kept ? table_value(table, &word, 1, &value, err) &&
                         array_add(&table->value, &table->n_values, &value, sizeof value, err)
                   : word_number(&word, "value", -HUGE_VAL, HUGE_VAL, &value, err)))
            return false;
    }
    return true;
}

/* Refuses a wavelength out of order. The second one decides which order that is. */
static bool check_order(struct table *table, const struct row *row, struct error *err)
{
    const double last = table->n_rows > 0 ? table->row[table->n_rows - 1].nm : -HUGE_VAL;
    if (table->n_rows == 1)
        table->decreasing = row->nm < last;
    return (table->decreasing ? row->nm < last : row->nm > last) ||
           error_at(err, row->place, "wavelength %.15g nm follows %.15g nm; wavelengths must %s",
                    row->nm, last,
                    table->decreasing ? "decrease, as in the first two rows" : "increase");
}

/* Reads the current line: a wavelength and one or more values. Skips a line of empty fields. */
static bool read_row(struct table *table, struct error *err)
{
    struct row row = {0};
    struct word word;
    long n;
    if (!table_field(table, &word))
        return true;
    row.place = word.place;
    if (word.length == 0) {
        while (word.length == 0 && table_field(table, &word))
            ;
        return word.length == 0 || error_at(err, row.place, "expected a wavelength");
    }
    if (!read_wavelength(table, &word, &row.nm, err) || !read_values(table, &n, err))
        return false;
    if (n == 0)
        return error_at(err, text_place(&table->text), "expected a value after the wavelength");
    if (table->n_rows == 0 && !check_columns(table, n, row.place, err))
        return false;
    if (n != table->n_columns)
        return error_at(err, row.place, "this row has %ld values, the first row has %ld", n,
                        table->n_columns);
    return check_order(table, &row, err) &&
           array_add(&table->row, &table->n_rows, &row, sizeof row, err);
}

/* Reads the first field of a line, which may have a separator of its own. */
static bool first_field(struct table *line, struct word *out)
{
    line->separator = find_separator(&line->text);
    return table_field(line, out);
}

/* Returns whether all fields of a line but the first are numbers, as in a row with a mistake. */
static bool has_numbers(struct table line, struct word *first)
{
    struct word word;
    long n = 0;
    if (!table_field(&line, first))
        return false;
    for (; table_field(&line, &word); n += word.length > 0)
        if (word.length > 0 && !word_is_numeric(&word, "0123456789+-.,%eE")) /* in some country */
            return false;
    return n > 0;
}

static bool refuse_percent(const struct table *table, const struct word *word, struct error *err)
{
    char name[LABEL_SIZE];
    return error_at(err, word->place,
                    "'%.*s' says percent; write '%s*0.01', or '%s*1' if the values are "
                    "fractions of 1",
                    word_shown(word), word->start, table_label(table, name), name);
}

/* Returns whether names in a heading are wavelengths, two or more that increase: then each row is a
 * sample. */
static bool is_of_rows(struct table line)
{
    struct word word;
    double last = 0, nm;
    int n = 0;
    for (; table_field(&line, &word); n += nm > 0, last = nm > 0 ? nm : last) {
        nm = name_wavelength(&word);
        if ((nm == 0 && name_says_wavelength(&word)) || (n > 0 && !(nm > last)))
            return false;
    }
    return n > 1;
}

static bool wants_fractions(const struct table *table)
{
    return table->wanted->highest < HUGE_VAL && !table->wanted->scaled;
}

/* Refuses a line above the names of the columns that says percent of all of them. */
static bool check_above(const struct table *table, struct table line, struct error *err)
{
    struct word word;
    while (wants_fractions(table) && table_field(&line, &word))
        if (name_says_percent(&word))
            return refuse_percent(table, &word, err);
    return true;
}

/* Reads the names of the columns, which other characters than those of the rows may separate. A
 * reflectance in percent needs a factor: whether 0.9 is 0.9 % or nearly white cannot be guessed. */
static bool read_heading(struct table *table, struct text heading, struct error *err)
{
    const long first = table->first > 0 ? table->first : 1;
    const size_t length = (size_t)(heading.line_end - heading.at);
    struct table line = *table;
    struct word word, name = {0};
    int n = 0;
    line.text = heading;
    if (table->separator == ' ' || !memchr(heading.at, table->separator, length))
        line.separator = find_separator(&heading);
    for (; table_field(&line, &word); n++) {
        name = n == 0 ? word : name;
        if (n > 0 && !names_add(table, &word, err))
            return false;
        if (n > 0 && is_sample(table, &word))
            table->first = n;
        if ((n == 0 || line.separator == ' ') && !name_check_unit(&word, err))
            return false;
        if (n > 0 && name_says_wavelength(&word) && !name_says_wavelength(&name) &&
            line.separator != ' ')
            return error_at(err, name.place,
                            "the first column must hold the wavelengths; it is named '%.*s'",
                            word_shown(&name), name.start);
        if (wants_fractions(table) && name_says_percent(&word) &&
            (n == first ||
             (n > 0 && (table->wanted->is_set || (table->first == 0 && line.separator == ' ')))))
            return refuse_percent(table, &word, err);
    }
    return true;
}

/* Reads the lines above the first row as headings. The last one names the columns. It is refused as
 * a row if it has numbers behind its first field. */
static bool read_headings(struct table *table, struct error *err)
{
    struct table line = *table, heading = {0};
    struct word word;
    while (!first_field(&line, &word) || !word_begins_wavelength(&word)) {
        if (text_peek(table->text, &word)) {
            if (heading.text.line > 0 && !check_above(table, heading, err))
                return false;
            heading = *table;
            heading.separator = line.separator;
            table->of_rows = is_of_rows(heading);
            if (table->of_rows) {
                table->separator = heading.separator;
                return true;
            }
        }
        if (!text_next_line(&table->text))
            return true;
        line.text = table->text;
    }
    table->separator = line.separator;
    if (table->separator != ' ' && heading.text.line > 0 &&
        memchr(heading.text.at, table->separator,
               (size_t)(heading.text.line_end - heading.text.at)))
        heading.separator = table->separator;
    if (heading.text.line > 0 && heading.text.line == table->text.line - 1 &&
        has_numbers(heading, &word))
        return refuse_row(&word, err);
    return heading.text.line == 0 || read_heading(table, heading.text, err);
}

bool columns_read(struct table *table, struct error *err)
{
    if (!read_headings(table, err))
        return false;
    if (table->of_rows)
        return samples_read(table, err);
    do
        if (!read_row(table, err))
            return false;
    while (text_next_line(&table->text));
    return true;
}

bool columns_found(struct text text)
{
    struct table table = {.wanted = NULL, .text = text};
    struct word word, first;
    while (text_next_line(&table.text)) {
        struct table line = table;
        line.separator = find_separator(&line.text);
        if (is_of_rows(line) || (text_peek(table.text, &word) && word_begins_wavelength(&word) &&
                                 has_numbers(line, &first)))
            return true;
    }
    return false;
}
