/* SPDX-License-Identifier: MIT */
/* Reads tables of wavelengths and values, of all forms. */
#include <float.h>

#include "data/spectra/inside.h"

/* ---- values ---- */

const char *table_label(const struct table *table, char out[LABEL_SIZE])
{
    const struct word *name = &table->wanted->table;
    const bool fits = name->length <= LONGEST_NAME;
    const int length = snprintf(out, LABEL_SIZE, "%.*s", fits ? (int)name->length : 4,
                                fits ? name->start : "FILE");
    if (table->first > 0)
        snprintf(out + length, LABEL_SIZE - (size_t)length, ":%ld", table->first);
    return out;
}

bool table_value(const struct table *table, const struct word *word, double norm, double *out,
                 struct error *err)
{
    const struct columns *wanted = table->wanted;
    char name[LABEL_SIZE], times[48] = "";
    double raw;
    if (word->length > 0 && word->start[word->length - 1] == '%')
        return error_at(err, word->place,
                        "'%.*s' has a percent sign; remove the signs, and write '%s*0.01'",
                        word_shown(word), word->start, table_label(table, name));
    if (!word_number(word, "value", -HUGE_VAL, HUGE_VAL, &raw, err))
        return false;
    *out = raw / norm;
    if (*out < wanted->lowest)
        return error_at(err, word->place,
                        "value %.*s is below %.15g; write %.15g in its place if it is noise",
                        word_shown(word), word->start, wanted->lowest, wanted->lowest);
    if (*out * wanted->factor <= wanted->highest)
        return true;
    if (wanted->scaled)
        snprintf(times, sizeof times, " times %.15g", wanted->factor);
    return error_at(err, word->place,
                    "reflectance %.15g%s is above %.15g; write '%s*0.01' if the values are in "
                    "percent, or another factor",
                    *out, times, wanted->highest, table_label(table, name));
}

/* ---- files ---- */

/* Puts the rows into n spectra, in the order of wavelengths. */
static bool take_rows(const struct table *table, int n, struct spectrum *out, struct error *err)
{
    for (int k = 0; k < table->n_rows; k++) {
        const int at = table->decreasing ? table->n_rows - 1 - k : k;
        const struct row *row = &table->row[at];
        for (int i = 0; i < n; i++)
            if (!spectrum_append(
                    &out[i], row->nm,
                    table->value[table->by_samples ? i * table->n_rows + at : at * n + i],
                    row->place, err))
                return false;
    }
    return spectrum_is_in_nm(out, err);
}

/* Makes the channels of a detector; three that are named x, y and z are an observer's. */
static bool take_channels(struct table *table, struct detector *out, struct error *err)
{
    const int n = table->n_values / table->n_rows;
    if (!MAKE_ARRAY(out->sensitivity, n, err, "%d channels", n))
        return false;
    out->n = n;
    out->observer = n == 3;
    for (int i = 0; i < n && i < 3; i++) {
        const char *name = table->names.name[i];
        const struct word word = {.start = name, .length = strlen(name)};
        out->observer = out->observer && name_is_tristimulus(&word, "xyz"[i]);
    }
    out->channel = table->names.name;
    table->names = (struct set_names){0};
    return take_rows(table, n, out->sensitivity, err);
}

/* Makes a spectrum of each sample. */
static bool take_samples(const struct table *table, struct spectrum **out, struct error *err)
{
    const int n = table->n_values / table->n_rows;
    return MAKE_ARRAY(*out, n, err, "%d samples", n) && take_rows(table, n, *out, err);
}

typedef bool table_reader(struct table *table, struct error *err);

/* Returns the reader of a text's format, before its first line; NULL: columns, or no table. */
static table_reader *reader_of(const struct text *text)
{
    const char *mark = strstr(text->at, "BEGIN_DATA");
    if (strncmp(text->at, "<?xml", 5) == 0)
        return spdx_read;
    return mark && (mark == text->at || mark[-1] == '\n') ? cgats_read : NULL;
}

static bool read_text(struct table *table, struct error *err)
{
    table_reader *reader = reader_of(&table->text);
    table->first = table->wanted->first;
    const bool done =
        reader ? reader(table, err) : !text_next_line(&table->text) || columns_read(table, err);
    return done && (table->n_rows > 0 || table->wanted->all ||
                    error_at(err, text_whole(&table->text),
                             "no line begins with a wavelength; expected rows such as 400,0.1"));
}

static bool read_file(const char *path, struct table *table, struct spectrum *out,
                      struct detector *detector, struct error *err)
{
    const bool done = text_open(&table->text, path, table->wanted->table.place, TEXT_XML, err) &&
                      read_text(table, err) &&
                      (detector ? take_channels(table, detector, err)
                                : take_rows(table, table->wanted->count, out, err));
    FREE_ALL(table->row, table->value);
    set_names_free(&table->names);
    text_free(&table->text);
    return done;
}

/* ---- whole sets ---- */

bool set_is(struct text text)
{
    return reader_of(&text) || columns_found(text);
}

bool set_read(struct text text, double highest, struct spectrum **out, struct set_names *names,
              struct error *err)
{
    const struct columns columns = {.table = {.start = path_name(text.path),
                                              .length = strlen(path_name(text.path)),
                                              .place = text_whole(&text)},
                                    .lowest = highest < HUGE_VAL ? 0 : -HUGE_VAL,
                                    .highest = highest,
                                    .factor = 1,
                                    .all = out == NULL,
                                    .is_set = true};
    struct table table = {.wanted = &columns, .text = text};
    const bool done = read_text(&table, err) && (!out || take_samples(&table, out, err));
    *names = table.names;
    FREE_ALL(table.row, table.value);
    return done;
}

void set_free(struct spectrum *samples, struct set_names *names)
{
    for (int i = 0; samples && i < names->n; i++)
        spectrum_free(&samples[i]);
    free(samples);
    set_names_free(names);
}

bool table_is_detector(const struct builtin_file *file)
{
    return strncmp(file->name, "tables/", 7) == 0 &&
           (strstr((const char *)file->bytes, "\nwavelength_nm,x,y,z\n") != NULL ||
            strstr((const char *)file->bytes, "\nwavelength_nm,r,g,b\n") != NULL);
}

static bool refuse_unknown(const struct columns *wanted, struct error *err)
{
    const bool detector = wanted->count == 0;
    const struct word *word = &wanted->table;
    struct suggestion suggestion = {.distance = 0};
    char known[BUILTIN_NAME];
    if (word_equals(word, "daylight") || word_equals(word, "blackbody"))
        return error_at(err, word->place, "%.*s needs a temperature in K, as %.*s:6504",
                        word_shown(word), word->start, word_shown(word), word->start);
    for (size_t i = 0; i < builtin_file_count; i++)
        if (builtin_is(&builtin_files[i], FILE_TABLE, known) &&
            table_is_detector(&builtin_files[i]) == detector && !strchr(known, '/'))
            suggestion_add(&suggestion, word, known, strlen(known));
    return error_at(err, word->place, "no built-in %s and no file '%.*s'; %s",
                    detector ? "detector" : "spectrum", word_shown(word), word->start,
                    suggestion_end(&suggestion,
                                   detector ? "it is a file of a wavelength and values a line, "
                                              "or one of"
                                            : "it is a number, a file, blackbody:KELVIN, "
                                              "daylight:KELVIN, gaussian:CENTRE,WIDTH, or one of"));
}

bool table_read(const struct columns *columns, struct spectrum *out, struct detector *detector,
                struct error *err)
{
    struct table table = {.wanted = columns};
    char *path;
    bool done = word_file(&columns->table, FILE_TABLE, &path, err) &&
                (file_is_missing(path) ? refuse_unknown(columns, err)
                                       : read_file(path, &table, out, detector, err));
    if (done && !path_is_builtin(path))
        (detector ? detector->sensitivity : out)->path = path;
    else
        free(path);
    return done;
}

bool spectra_read(const char *name, int n, struct spectrum *out, struct detector *detector,
                  struct error *err)
{
    const struct columns columns = {.table = {.start = name, .length = strlen(name)},
                                    .count = n,
                                    .lowest = -HUGE_VAL,
                                    .highest = HUGE_VAL,
                                    .factor = 1};
    return table_read(&columns, out, detector, err);
}
