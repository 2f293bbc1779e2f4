/* SPDX-License-Identifier: MIT */
/* Reads tables of samples: a sample a row, with the wavelengths in the heading; CGATS files
 * (CGATS.5, ISO 28178), as instruments and ArgyllCMS write them; spectra of IES TM-27. */
#include <float.h>
#include <strings.h>

#include "data/spectra/inside.h"

/* ---- samples ---- */

/* A field of each sample: a value at a wavelength, or, with 0 nm, something else. */
struct field {
    double nm;
    bool is_name, is_label; /* its heading says so; is_label: of a name, a number or a place */
};
struct fields {
    struct field *field; /* owned */
    struct word *word;   /* of a sample that is read; owned */
    int n, n_bands;      /* n_bands: fields with a wavelength */
    double norm;         /* divides values */
    struct word says;    /* see struct sample */
};
static void fields_free(struct fields *fields)
{
    FREE_ALL(fields->field, fields->word);
}

/* named: letters may stand before a wavelength. */
static bool add_field(struct fields *fields, const struct word *heading, bool named,
                      struct error *err)
{
    struct field field = {.nm = heading_nm(heading, named)};
    struct meaning meaning;
    heading_read(heading, &meaning);
    field.is_name = meaning.says & SAYS_NAME;
    field.is_label = fields->n == 0 || meaning.says & SAYS_LABEL;
    fields->n_bands += field.nm > 0;
    if (fields->says.length == 0 && (meaning.says & SAYS_PERCENT || meaning.quantity))
        fields->says = *heading;
    return array_add(&fields->field, &fields->n, &field, sizeof field, err);
}

/* Takes the next sample, with all of its names: one that the heading calls so comes first. */
static bool add_sample(struct table *table, const struct fields *fields, struct error *err)
{
    const int index = table->n_samples;
    bool done = table_add_sample(table, err);
    for (int pass = 0; done && pass < 2; pass++)
        for (int i = 0; done && i < fields->n; i++)
            if (fields->field[i].nm == 0 && fields->field[i].is_label &&
                fields->field[i].is_name == (pass == 0))
                done = table_add_name(table, index, &fields->word[i], err);
    for (int i = 0; done && i < fields->n; i++)
        if (fields->field[i].nm > 0) {
            const struct reading at = {.nm = fields->field[i].nm,
                                       .nm_column = fields->word[i].place.column};
            done = table_add(table, index, &at, &fields->word[i], fields->norm, err);
        }
    if (done)
        table->sample[index].says = fields->says;
    return done;
}

/* ---- a sample a row ---- */

/* Reads the fields of the current line; *n: how many there are. Returns false for a blank line. */
static bool read_line(struct table *table, struct fields *fields, int *n)
{
    *n = 0;
    for (struct word word; line_cell(table, &word); ++*n)
        if (*n < fields->n)
            fields->word[*n] = word;
    return *n > 0 && !(*n == 1 && fields->word[0].length == 0);
}

bool samples_read(struct table *table, struct error *err)
{
    struct fields fields = {.norm = 1};
    struct word word;
    int n;
    bool done = true;
    while (done && line_cell(table, &word))
        done = add_field(&fields, &word, false, err);
    done = done && MAKE_ARRAY(fields.word, fields.n, err, "the fields of %s", table->text.path);
    while (done && text_next_line(&table->text))
        if (read_line(table, &fields, &n))
            done = n == fields.n
                       ? add_sample(table, &fields, err)
                       : error_at(err, text_place(&table->text),
                                  "this row has %d fields, the heading has %d", n, fields.n);
    fields_free(&fields);
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
                                          "SPECTRAL_NORM"};

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
static bool find_bands(struct fields *fields, const double *head, struct place place,
                       struct error *err)
{
    const struct word band = {.start = "nm100", .length = 5};
    const double span = head[END_NM] - head[START_NM], steps = fmax(head[BANDS] - 1, 1);
    if (fields->n == 0 && !check_cgats(head, place, err))
        return false;
    for (int i = 0, n = fields->n == 0 ? (int)head[BANDS] : 0; i < n; i++)
        if (!add_field(fields, &band, true, err))
            return false;
    if (fields->n_bands == 0)
        return error_at(err, place, "no field of the data is named as a wavelength, as SPEC_400");
    const bool ranged = fields->n_bands == head[BANDS] && head[START_NM] > 0 && span >= 0;
    for (int i = 0, k = 0; i < fields->n && ranged; i++)
        if (fields->field[i].nm > 0)
            fields->field[i].nm = head[START_NM] + span * k++ / steps;
    fields->norm = head[NORM];
    return MAKE_ARRAY(fields->word, fields->n, err, "the fields of a sample");
}

/* Reads the samples up to END_DATA, on any number of lines. */
static bool read_data(struct table *table, struct fields *fields, struct place begin,
                      struct error *err)
{
    struct word word;
    int n = 0;
    cgats_line(table);
    while (next_word(table, &word)) {
        if (word_is(&word, "END_DATA"))
            return n == 0 ||
                   error_at(err, word.place, "%d values, but a sample has %d fields", n, fields->n);
        fields->word[n++] = word;
        if (n == fields->n && !add_sample(table, fields, err))
            return false;
        n %= fields->n;
    }
    return error_at(err, begin, "BEGIN_DATA without END_DATA");
}

static bool read_format(struct table *table, struct fields *fields, struct error *err)
{
    struct word word;
    fields->n = fields->n_bands = 0;
    cgats_line(table);
    while (next_word(table, &word) && !word_is(&word, "END_DATA_FORMAT"))
        if (!add_field(fields, &word, true, err))
            return false;
    return true;
}

/* Reads the number of a word of the head. Some programs write it in quotes. */
static bool read_head(struct table *table, const struct word *name, double *head, struct error *err)
{
    struct word word;
    int i = 0;
    while (i < CGATS_WORDS && !word_is(name, cgats_words[i]))
        i++;
    if (i == CGATS_WORDS)
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
    struct fields fields = {.n = 0};
    struct word word;
    bool done = text_next_line(&table->text), read = false;
    while (done && !read && head_word(&table->text, &word)) {
        read = word_is(&word, "BEGIN_DATA");
        done = read ? find_bands(&fields, head, word.place, err) &&
                          read_data(table, &fields, word.place, err)
               : word_is(&word, "BEGIN_DATA_FORMAT") ? read_format(table, &fields, err)
                                                     : read_head(table, &word, head, err);
    }
    fields_free(&fields);
    return done;
}

/* ---- IES TM-27 ---- */

/* Leaves blanks between the words of an XML file: "<NAME" of a tag, the names and the values of its
 * attributes, text, and "/NAME". Comments become blanks, too. */
static void spread_words(char *at)
{
    for (bool comment = false; *at; at++) {
        comment = comment ? strncmp(at - 2, "-->", 3) != 0 : strncmp(at, "<!--", 4) == 0;
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
           table_add(table, 0, &at, &value, 1, err);
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
