/* SPDX-License-Identifier: MIT */
/* Reads tables of samples: a sample a row, with the wavelengths in the heading; CGATS files
 * (CGATS.5, ISO 28178), as instruments and ArgyllCMS write them; spectra of IES TM-27. */
#include <float.h>
#include <strings.h>

#include "data/spectra/inside.h"

/* ---- names ---- */

bool names_add(struct table *table, const struct word *name, struct error *err)
{
    char *copy;
    struct printed number = {.text = NULL};
    print(&number, "%d", table->names.n + 1);
    if (name && name->length > 0) {
        free(printed_end(&number));
        copy = word_copy(name, err);
    } else {
        copy = printed_take(&number, err);
    }
    if (copy && array_add(&table->names.name, &table->names.n, &copy, sizeof copy, err))
        return true;
    free(copy);
    return false;
}

void set_names_free(struct set_names *names)
{
    for (int i = 0; i < names->n; i++)
        free(names->name[i]);
    free(names->name);
}

bool is_sample(const struct table *table, const struct word *name)
{
    const struct word *sample = &table->wanted->sample;
    return sample->length > 0 && sample->length == name->length &&
           memcmp(sample->start, name->start, name->length) == 0;
}

bool sample_unknown(const struct table *table, struct error *err)
{
    const struct word *sample = &table->wanted->sample;
    struct suggestion suggestion = {.distance = 0};
    for (int i = 0; i < table->names.n; i++)
        suggestion_add(&suggestion, sample, table->names.name[i], strlen(table->names.name[i]));
    return error_at(err, sample->place, "%.200s has no sample '%.*s'; %s", table->text.path,
                    word_shown(sample), sample->start,
                    suggestion_end(&suggestion, "its samples are"));
}

/* ---- samples ---- */

/* A field of each sample: the radiance of a wavelength, or, with 0 nm, something else. */
struct field {
    double nm;
    bool is_name; /* its heading says so */
    bool
        is_label; /* a name, a number or a place of the sample, as its heading says; or the first */
};
struct fields {
    struct field *field; /* owned */
    struct word *word;   /* of a sample that is read; owned */
    int n;
    int n_bands; /* fields with a wavelength */
    double norm; /* divides values */
};

static void fields_free(struct fields *fields)
{
    FREE_ALL(fields->field, fields->word);
}

/* Returns whether a heading has a part, in capitals or not. */
static bool says(const struct word *heading, const char *part)
{
    const size_t length = strlen(part);
    bool found = false;
    for (size_t i = 0; i + length <= heading->length; i++)
        found = found || strncasecmp(heading->start + i, part, length) == 0;
    return found;
}

static bool add_field(struct fields *fields, const struct word *heading, struct error *err)
{
    const struct field field = {.nm = name_wavelength(heading),
                                .is_name = says(heading, "name"),
                                .is_label = fields->n == 0 || says(heading, "name") ||
                                            says(heading, "id") || says(heading, "sample") ||
                                            says(heading, "loc") || says(heading, "patch")};
    fields->n_bands += field.nm > 0;
    return array_add(&fields->field, &fields->n, &field, sizeof field, err);
}

/* Keeps the values of the sample, in place of those of another, unless all are wanted. */
static bool keep_sample(struct table *table, const struct fields *fields, struct error *err)
{
    const bool more = table->wanted->count == 0 && table->n_rows > 0;
    if (!more)
        table->n_rows = table->n_values = 0;
    for (int i = 0; i < fields->n; i++) {
        const struct row row = {.nm = fields->field[i].nm, .place = fields->word[i].place};
        double value;
        if (row.nm == 0)
            continue;
        if (table->n_rows == 1)
            table->decreasing = row.nm < table->row[0].nm;
        if (!table_mark(table, &fields->word[i], err) ||
            !table_value(table, &fields->word[i], fields->norm, &value, err) ||
            !array_add(&table->value, &table->n_values, &value, sizeof value, err) ||
            !(more || array_add(&table->row, &table->n_rows, &row, sizeof row, err)))
            return false;
    }
    return true;
}

/* Takes the next sample, and keeps it if it is wanted: by one of its names, or else by its number.
 */
static bool add_sample(struct table *table, const struct fields *fields, struct error *err)
{
    const struct columns *wanted = table->wanted;
    const struct word *name = NULL;
    bool found = false, named = false;
    for (int i = 0; i < fields->n; i++) {
        const struct field *field = &fields->field[i];
        if (field->nm > 0 || !field->is_label)
            continue;
        if (!name || (field->is_name && !named))
            name = &fields->word[i];
        named = named || field->is_name;
        found = found || is_sample(table, &fields->word[i]);
    }
    table->n_named += found;
    if (!names_add(table, name, err))
        return false;
    const bool all = wanted->count == 0, only = wanted->sample.length == 0 && wanted->first == 0;
    const bool numbered = wanted->first == table->names.n && table->n_named == 0;
    return wanted->all || !(all || found || numbered || (only && table->names.n == 1)) ||
           keep_sample(table, fields, err);
}

/* Refuses a name that several samples have or none, and no name where there are several. */
static bool check_choice(const struct table *table, struct error *err)
{
    const struct columns *wanted = table->wanted;
    char name[LABEL_SIZE];
    if (wanted->all || wanted->count == 0 || table->names.n == 0 ||
        (table->n_rows > 0 && table->n_named == 1))
        return true;
    if (table->n_named > 1)
        return error_at(err, wanted->sample.place,
                        "%d samples are named '%.*s'; write the number of one, from 1 to %d",
                        table->n_named, word_shown(&wanted->sample), wanted->sample.start,
                        table->names.n);
    if (wanted->sample.length > 0 || wanted->first > 0)
        return table->n_rows > 0 || sample_unknown(table, err);
    return table->names.n == 1 ||
           error_at(err, wanted->table.place,
                    "'%s' has %d samples, each in a row; write one as '%s:NAME' or by its number: "
                    "spectral list %s",
                    table_label(table, name), table->names.n, name, name);
}

/* ---- a sample a row ---- */

/* Reads the fields of the current line; *n: how many there are. Returns false for a blank line. */
static bool read_line(struct table *table, struct fields *fields, int *n)
{
    *n = 0;
    for (struct word word; table_field(table, &word); ++*n)
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
    table->by_samples = true;
    while (done && table_field(table, &word))
        done = add_field(&fields, &word, err);
    done = done && MAKE_ARRAY(fields.word, fields.n, err, "the fields of %s", table->text.path);
    while (done && text_next_line(&table->text))
        if (read_line(table, &fields, &n))
            done = n == fields.n
                       ? add_sample(table, &fields, err)
                       : error_at(err, text_place(&table->text),
                                  "this row has %d fields, the heading has %d", n, fields.n);
    fields_free(&fields);
    return done && check_choice(table, err);
}

/* ---- CGATS ---- */

/* Tabs alone separate the words of a line that has some: names may then have blanks without quotes.
 */
static void begin_line(struct table *table)
{
    const struct text *text = &table->text;
    const size_t length = (size_t)(text->line_end - text->line_start);
    table->separator = memchr(text->line_start, '\t', length) ? '\t' : ' ';
}

/* Reads the next word of the file, on this line or a later one. */
static bool next_word(struct table *table, struct word *out)
{
    while (!table_field(table, out)) {
        if (!text_next_line(&table->text))
            return false;
        begin_line(table);
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
        if (!add_field(fields, &band, err))
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
    begin_line(table);
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
    begin_line(table);
    while (next_word(table, &word) && !word_is(&word, "END_DATA_FORMAT"))
        if (!add_field(fields, &word, err))
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
    table->by_samples = true;
    while (done && !read && head_word(&table->text, &word)) {
        read = word_is(&word, "BEGIN_DATA");
        done = read ? find_bands(&fields, head, word.place, err) &&
                          read_data(table, &fields, word.place, err)
               : word_is(&word, "BEGIN_DATA_FORMAT") ? read_format(table, &fields, err)
                                                     : read_head(table, &word, head, err);
    }
    fields_free(&fields);
    return done && check_choice(table, err);
}

/* ---- IES TM-27 ---- */

/* Reads elements such as <SpectralData wavelength="400">0.5</SpectralData>. */
bool spdx_read(struct table *table, struct error *err)
{
    static const char mark[] = "SpectralData wavelength=\"";
    struct text *text = &table->text;
    bool done = names_add(table, NULL, err);
    while (done && text_next_line(text))
        for (const char *at = text->at; done && (at = strstr(at, mark)) && at < text->line_end;) {
            struct row row = {.place = text_place(text)};
            struct word word = {.start = at + strlen(mark), .place = row.place};
            double value;
            word.length = strcspn(word.start, "\"");
            done = word_number(&word, "wavelength", DBL_MIN, HUGE_VAL, &row.nm, err);
            at = word.start + word.length + strcspn(word.start + word.length, ">\n");
            word.start = at + (*at == '>');
            word.length = strcspn(word.start, "<\n");
            done = done && table_value(table, &word, 1, &value, err) &&
                   array_add(&table->value, &table->n_values, &value, sizeof value, err) &&
                   array_add(&table->row, &table->n_rows, &row, sizeof row, err);
        }
    return done;
}
