/* SPDX-License-Identifier: MIT */
/* Reads tables of samples: a sample a row, with the wavelengths in the heading; CGATS files
 * (CGATS.5, ISO 28178), as instruments and ArgyllCMS write them; spectra of IES TM-27. */
#include <float.h>

#include "data/spectra/inside.h"

/* ---- samples ---- */

/* Takes the heading of the next field. named: letters may stand before a wavelength. The first
 * field is a label, too. */
static bool add_field(struct table *table, const struct word *heading, bool named,
                      struct error *err)
{
    struct meaning meaning;
    heading_read(heading, &meaning);
    const struct field field = {heading_nm(heading, named),
                                meaning.says | (table->n_fields == 0 ? SAYS_LABEL : 0U)};
    if (field.says & SAYS_NAME &&
        !(table->n_fields > 0 && table->field[table->name_field].says & SAYS_NAME))
        table->name_field = table->n_fields;
    if (table->above.length == 0 && field.says & (SAYS_PERCENT | SAYS_QUANTITY))
        table->above = *heading;
    return array_add(&table->field, &table->n_fields, &field, sizeof field, err);
}

/* Adds the word of field i to the latest sample, which the first field begins. */
static bool add_word(struct table *table, int i, const struct word *word, struct error *err)
{
    const struct field *field = &table->field[i];
    const struct reading at = {.nm = field->nm, .nm_column = word->place.column};
    if (i == 0 && !table_add_sample(table, err))
        return false;
    if (field->nm > 0)
        return table_add(table, table->n_samples - 1, &at, word, err);
    return !(field->says & SAYS_LABEL) ||
           table_add_name(table, table->n_samples - 1, word, i == table->name_field, err);
}

/* ---- a sample a row ---- */

/* Reads the current line, unless it has nothing but one empty field. */
static bool read_line(struct table *table, struct error *err)
{
    struct table ahead = *table;
    struct word word;
    int n = 0;
    bool done = true;
    while (line_cell(&ahead, &word))
        n++;
    if (n == 0 || (n == 1 && word.length == 0))
        return true;
    if (n != table->n_fields)
        return error_at(err, text_place(&ahead.text), "this row has %d fields, the heading has %d",
                        n, table->n_fields);
    for (int i = 0; done && line_cell(table, &word); i++)
        done = add_word(table, i, &word, err);
    return done;
}

bool samples_read(struct table *table, struct error *err)
{
    struct word word;
    bool done = true;
    while (done && line_cell(table, &word))
        done = add_field(table, &word, false, err);
    while (done && text_next_line(&table->text))
        done = read_line(table, err);
    return done;
}

/* ---- CGATS ---- */

/* Tabs alone separate the words of a line that has some: names may then have blanks without quotes.
 */
static void cgats_line(struct table *table)
{
    const struct text *text = &table->text;
    const size_t length = (size_t)(text->line_end - text->line_start);
    table->separator = memchr(text->line_start, '\t', length) ? '\t' : ' ';
}

/* Reads the next word of the file, on this line or a later one. */
static bool next_word(struct table *table, struct word *out)
{
    while (!line_cell(table, out)) {
        if (!text_next_line(&table->text))
            return false;
        cgats_line(table);
    }
    return true;
}

/* Reads the next word outside of the data. */
static bool head_word(struct text *text, struct word *out)
{
    while (!text_word(text, out))
        if (!text_next_line(text))
            return false;
    return true;
}

/* The words of a CGATS file that describe its data. */
enum { BANDS, START_NM, END_NM, NORM, CGATS_WORDS };
static const char *const cgats_words[] = {"SPECTRAL_BANDS", "SPECTRAL_START_NM", "SPECTRAL_END_NM",
                                          "SPECTRAL_NORM", NULL};

static bool check_cgats(const double *head, struct place place, struct error *err)
{
    for (int i = BANDS; i <= END_NM; i++)
        if (head[i] == 0)
            return error_at(err, place, "%s is missing before the data", cgats_words[i]);
    if (head[BANDS] > MOST_BANDS)
        return error_at(err, place, "%.15g bands; expected at most %d", head[BANDS], MOST_BANDS);
    return (head[BANDS] > 1 ? head[START_NM] < head[END_NM] : head[START_NM] == head[END_NM]) ||
           error_at(err, place, "%.15g bands from %.15g to %.15g nm; they must increase",
                    head[BANDS], head[START_NM], head[END_NM]);
}

/* Finds the wavelengths: without a format each value is one. The names of fields may be rounded, so
 * that the range of as many bands goes before them. */
static bool find_bands(struct table *table, const double *head, struct place place,
                       struct error *err)
{
    const struct word band = {.start = "nm100", .length = 5};
    const double span = head[END_NM] - head[START_NM], steps = fmax(head[BANDS] - 1, 1);
    int n_bands = 0;
    if (table->n_fields == 0 && !check_cgats(head, place, err))
        return false;
    for (int i = 0, n = table->n_fields == 0 ? (int)head[BANDS] : 0; i < n; i++)
        if (!add_field(table, &band, true, err))
            return false;
    for (int i = 0; i < table->n_fields; i++)
        n_bands += table->field[i].nm > 0;
    if (n_bands == 0)
        return error_at(err, place, "no field of the data is named as a wavelength, as SPEC_400");
    const bool ranged = n_bands == head[BANDS] && head[START_NM] > 0 && span >= 0;
    for (int i = 0, k = 0; i < table->n_fields && ranged; i++)
        if (table->field[i].nm > 0)
            table->field[i].nm = head[START_NM] + span * k++ / steps;
    table->norm = head[NORM];
    return true;
}

/* Reads the samples up to END_DATA, on any number of lines. */
static bool read_data(struct table *table, struct place begin, struct error *err)
{
    struct word word;
    int n = 0;
    cgats_line(table);
    for (; next_word(table, &word); n = (n + 1) % table->n_fields)
        if (word_is(&word, "END_DATA"))
            return n == 0 || error_at(err, word.place, "%d values, but a sample has %d fields", n,
                                      table->n_fields);
        else if (!add_word(table, n, &word, err))
            return false;
    return error_at(err, begin, "BEGIN_DATA without END_DATA");
}

static bool read_format(struct table *table, struct error *err)
{
    struct word word;
    table->n_fields = table->name_field = 0;
    cgats_line(table);
    while (next_word(table, &word) && !word_is(&word, "END_DATA_FORMAT"))
        if (!add_field(table, &word, true, err))
            return false;
    return true;
}

/* Reads the number of a word of the head. Some programs write it in quotes. */
static bool read_head(struct table *table, const struct word *name, double *head, struct error *err)
{
    const int i = word_find(name, cgats_words);
    struct word word;
    if (i < 0)
        return true;
    if (!text_expect(&table->text, &word, cgats_words[i], err))
        return false;
    word.quoted = false;
    return word_number(&word, cgats_words[i], DBL_MIN, HUGE_VAL, &head[i], err) &&
           text_end(&table->text, cgats_words[i], err);
}

bool cgats_read(struct table *table, struct error *err)
{
    double head[CGATS_WORDS] = {[NORM] = 1}; /* 0: missing */
    struct word word;
    bool done = true;
    while (done && head_word(&table->text, &word)) {
        if (word_is(&word, "BEGIN_DATA"))
            return find_bands(table, head, word.place, err) && read_data(table, word.place, err);
        done = word_is(&word, "BEGIN_DATA_FORMAT") ? read_format(table, err)
                                                   : read_head(table, &word, head, err);
    }
    return done;
}

/* ---- IES TM-27 ---- */

/* Leaves blanks between the words of an XML file: "<NAME" of a tag, the names and the values of its
 * attributes, text, and "/NAME". Comments become blanks, too. */
static void spread_words(char *at)
{
    for (bool comment = false; *at; at++) {
        if (strncmp(at, comment ? "-->" : "<!--", comment ? 3 : 4) == 0) {
            comment = !comment;
            memset(at, ' ', 3);
        }
        if (comment ? !strchr("\r\n", *at) : strchr("=\"'#>", *at) || strncmp(at, "</", 2) == 0)
            *at = ' ';
    }
}

/* Returns whether a word begins an element of this name, which may have a prefix. */
static bool begins_element(const struct word *word, const char *name)
{
    const char *colon = memchr(word->start, ':', word->length);
    struct word own = *word;
    own.start = (colon ? colon : word->start) + 1;
    own.length -= (size_t)(own.start - word->start);
    return *word->start == '<' && word_equals(&own, name);
}

/* Reads the next word of an element. Returns false at its end. */
static bool element_word(struct text *text, struct word *out)
{
    return head_word(text, out) && *out->start != '/';
}

/* Reads an element such as <SpectralData wavelength="400">0.5</SpectralData>. */
static bool read_datum(struct table *table, struct word value, struct error *err)
{
    const struct place place = value.place;
    struct word nm = {.length = 0}, word;
    struct reading at;
    value.length = 0;
    while (element_word(&table->text, &word))
        if (!word_is(&word, "wavelength"))
            value = word;
        else if (!element_word(&table->text, &nm))
            break;
    at.nm_column = nm.place.column;
    return (nm.length > 0 || error_at(err, place, "SpectralData needs a wavelength")) &&
           word_number(&nm, "wavelength", DBL_MIN, HUGE_VAL, &at.nm, err) &&
           table_add(table, 0, &at, &value, err);
}

bool spdx_read(struct table *table, struct error *err)
{
    struct text *text = &table->text;
    struct word word, *above = &table->above;
    bool done = table_add_sample(table, err);
    spread_words(text->bytes);
    while (done && head_word(text, &word))
        if (begins_element(&word, "SpectralData"))
            done = read_datum(table, word, err);
        else if (begins_element(&word, "SpectralQuantity") && element_word(text, above))
            while (element_word(text, &word))
                above->length = (size_t)(word.start + word.length - above->start);
    return done && (table->sample[0].n > 0 ||
                    error_at(err, text_whole(text),
                             "the file is XML, but has no SpectralData of IES TM-27; "
                             "data/samples/to_csv.py reads CxF"));
}
