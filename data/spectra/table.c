/* SPDX-License-Identifier: MIT */
/* Reads tables of wavelengths and values, of all forms, and takes samples of them. */
#include "data/spectra/inside.h"

/* ---- samples ---- */

bool table_add_sample(struct table *table, struct error *err)
{
    return array_add(&table->sample, &table->n_samples, NULL, sizeof *table->sample, err);
}

bool table_add_name(struct table *table, int sample, const struct word *name, bool own,
                    struct error *err)
{
    const struct label label = {*name, sample};
    struct word *first = &table->sample[sample].name;
    if (first->length == 0 || (own && name->length > 0))
        *first = *name;
    return name->length == 0 ||
           array_add(&table->label, &table->n_labels, &label, sizeof label, err);
}

/* The second wavelength decides on the order. */
bool table_add(struct table *table, int sample, const struct reading *at, const struct word *value,
               struct error *err)
{
    struct sample *to = &table->sample[sample];
    const double last_nm = to->n > 0 ? to->reading[to->n - 1].nm : 0;
    const bool falls = to->n > 1 && to->reading[1].nm < to->reading[0].nm;
    struct reading added = {at->nm, 0, value->place.line, at->nm_column, value->place.column};
    if (to->n > 0 && (at->nm == last_nm || (to->n > 1 && (at->nm < last_nm) != falls)))
        return error_at(err, (struct place){table->text.path, added.line, added.nm_column},
                        "wavelength %.15g nm follows %.15g nm; wavelengths must %s", at->nm,
                        last_nm, falls ? "decrease, as in the first two rows" : "increase");
    if (!table_number(table, value, "value", &added.value, err))
        return false;
    added.value /= table->norm;
    return array_add(&to->reading, &to->n, &added, sizeof added, err);
}

static void table_free(struct table *table)
{
    for (int i = 0; i < table->n_samples; i++)
        free(table->sample[i].reading);
    FREE_ALL(table->sample, table->label, table->field);
}

typedef bool table_reader(struct table *table, struct error *err);

/* Returns the reader of a text's format, before its first line. */
static table_reader *reader_of(const struct text *text)
{
    const char *mark = strstr(text->at, "BEGIN_DATA");
    if (strncmp(text->at, "<?xml", 5) == 0)
        return spdx_read;
    return mark && (mark == text->at || mark[-1] == '\n') ? cgats_read : columns_read;
}

static bool read_text(struct table *table, struct error *err)
{
    struct text *text = &table->text;
    for (char *at = text->bytes; (at = strstr(at, "\xC2\xA0"));) /* no-break spaces */
        at[0] = at[1] = ' ';
    return reader_of(text)(table, err) &&
           (table->n_samples > 0 ||
            error_at(err, text_whole(text),
                     "no line begins with a wavelength; expected rows such as 400,0.1, or a "
                     "heading of wavelengths such as 400 or 400 nm"));
}

/* ---- which sample ---- */

static bool refuse_choice(const struct table *table, const struct wanted *wanted, struct error *err)
{
    const struct word *sample = &wanted->sample, *file = &wanted->table;
    const int n = table->n_samples, length = word_shown(file);
    struct suggestion suggestion = {.distance = 0};
    if (wanted->first == 0 && sample->length == 0)
        return error_at(
            err, file->place,
            "'%.*s' has %d samples; write one as '%.*s:NAME', or by its number: spectral "
            "list %.*s%s",
            length, file->start, n, length, file->start, length, file->start,
            table->separator == ',' ? "; if its commas are decimal, put semicolons between columns"
                                    : "");
    for (int i = 0; i < table->n_labels; i++)
        suggestion_add(&suggestion, sample, table->label[i].word.start,
                       table->label[i].word.length);
    return wanted->first > 0
               ? error_at(err, file->place, "'%.*s' has no sample %ld; its last is %d", length,
                          file->start, wanted->first, n)
               : error_at(err, sample->place, "%.200s has no sample '%.*s'; %s", table->text.path,
                          word_shown(sample), sample->start,
                          suggestion_end(&suggestion, "its samples are"));
}

/* Finds the first sample that is wanted: by its name, or else by its number. */
static bool choose(const struct table *table, const struct wanted *wanted, int *out,
                   struct error *err)
{
    const struct word *sample = &wanted->sample;
    int n = 0;
    for (int i = 0; i < table->n_labels; i++) {
        const struct label *label = &table->label[i];
        if (label->word.length == sample->length &&
            memcmp(label->word.start, sample->start, sample->length) == 0) {
            n += n == 0 || label->sample != *out;
            *out = label->sample;
        }
    }
    if (n > 1)
        return error_at(err, sample->place,
                        "%d samples are named '%.*s'; write the number of one, from 1 to %d", n,
                        word_shown(sample), sample->start, table->n_samples);
    if (n == 1)
        return true;
    *out = wanted->first > 0 ? (int)wanted->first - 1 : 0;
    const bool only = sample->length == 0 && (table->n_samples == 1 || wanted->count > 1);
    return (wanted->first > 0 ? *out < table->n_samples : only) ||
           refuse_choice(table, wanted, err);
}

/* ---- its values ---- */

/* Returns the table and the sample as a scene names them, without a factor. */
static struct word label_of(const struct wanted *wanted)
{
    struct word label = wanted->table;
    if (wanted->sample.length > 0)
        label.length = (size_t)(wanted->sample.start + wanted->sample.length - label.start);
    return label;
}

/* Refuses percent, and another quantity than is wanted. Lights are relative. */
static bool check_quantity(const struct table *table, const struct sample *sample,
                           const struct wanted *wanted, struct error *err)
{
    const struct word *says = sample->says.length > 0 ? &sample->says : &table->above;
    const bool reflectance = wanted->highest < HUGE_VAL;
    const struct word label = label_of(wanted);
    struct meaning meaning;
    heading_read(says, &meaning);
    if (reflectance && !wanted->scaled && meaning.says & SAYS_PERCENT)
        return error_at(err, says->place,
                        wanted->count > 0
                            ? "'%.*s' says percent; write '%.*s*0.01', or '%.*s*1' if "
                              "the values are fractions of 1"
                            : "'%.*s' says percent; divide the values of %.*s by 100",
                        word_shown(says), says->start, (int)label.length, label.start,
                        (int)label.length, label.start);
    if (reflectance && meaning.says & (SAYS_LIGHT | SAYS_OTHER))
        return error_at(err, says->place,
                        "'%.*s' is no reflectance; expected values from 0 to 1, or another word",
                        word_shown(says), says->start);
    return wanted->lowest < 0 || reflectance || !(meaning.says & SAYS_REFLECTANCE) ||
           error_at(err, says->place, "'%.*s' is no light; expected its spectrum, or another word",
                    word_shown(says), says->start);
}

/* Noise of instruments, and rounding of reflectances: outside of 380 to 780 nm, at most 0.5 % of
 * the largest value below 0, or at most 0.01 beyond a limit of reflectances. */
static bool is_noise(double nm, double beyond, double largest, bool reflectance)
{
    return nm < 380 || nm > 780 || beyond <= 0.005 * largest || (reflectance && beyond <= 0.01);
}

/* Takes a value within the limits. Counts what is noise, which becomes the limit. */
static bool take_value(const struct reading *reading, const struct wanted *wanted, double largest,
                       struct spectrum *out, struct error *err)
{
    const struct place place = {out->place.path, reading->line, reading->column};
    const bool reflectance = wanted->highest < HUGE_VAL;
    const double value = reading->value, product = value * wanted->factor;
    double kept = fmax(value, wanted->lowest);
    const struct word label = label_of(wanted);
    if (value < wanted->lowest &&
        !is_noise(reading->nm, (wanted->lowest - value) * (reflectance ? wanted->factor : 1),
                  largest, reflectance))
        return error_at(err, place,
                        "value %.15g is below %.15g; write %.15g in its place if it is noise",
                        value, wanted->lowest, wanted->lowest);
    if (product > wanted->highest && !is_noise(reading->nm, product - wanted->highest, 0, true))
        return wanted->scaled
                   ? error_at(err, place, "reflectance %.15g times %.15g is above %.15g", value,
                              wanted->factor, wanted->highest)
                   : error_at(
                         err, place,
                         "reflectance %.15g is above %.15g; write '%.*s*0.01' if the values are "
                         "in percent, or another factor",
                         value, wanted->highest, (int)label.length, label.start);
    if (product > wanted->highest)
        for (kept = wanted->highest / wanted->factor; kept * wanted->factor > wanted->highest;)
            kept = nextafter(kept, 0);
    if (kept != value && out->n_limited++ == 0)
        out->limited_nm = reading->nm;
    return spectrum_append(out, reading->nm, kept,
                           (struct place){place.path, reading->line, reading->nm_column}, err);
}

/* Makes a spectrum of a sample, in the order of wavelengths. */
static bool take(const struct table *table, const struct sample *sample,
                 const struct wanted *wanted, struct spectrum *out, struct error *err)
{
    const bool falls = sample->n > 1 && sample->reading[1].nm < sample->reading[0].nm;
    double largest = 0;
    out->place.path = table->text.path;
    if (!check_quantity(table, sample, wanted, err))
        return false;
    for (int k = 0; k < sample->n; k++)
        largest = fmax(largest, sample->reading[k].value);
    for (int k = 0; k < sample->n; k++)
        if (!take_value(&sample->reading[falls ? sample->n - 1 - k : k], wanted, largest, out, err))
            return false;
    return spectrum_is_in_nm(out, err);
}

/* Does the same for sample i, and names the spectrum: by its number, where it has no name. */
static bool take_named(const struct table *table, int i, const struct wanted *wanted,
                       struct spectrum *out, struct error *err)
{
    const struct word *name = &table->sample[i].name;
    struct printed printed = {.text = NULL};
    if (!take(table, &table->sample[i], wanted, out, err))
        return false;
    if (name->length > 0)
        print_bytes(&printed, name->start, name->length);
    else
        print(&printed, "%d", i + 1);
    out->name = printed_take(&printed, err);
    return out->name != NULL;
}

/* ---- detectors ---- */

/* Finds the order in which three channels stand, if each letter begins the name of one. */
static bool find_channels(const struct table *table, const char *letters, int order[3])
{
    int found[3] = {-1, -1, -1};
    for (int i = 0; i < 3; i++) {
        const char *letter = heading_channel(&table->sample[i].name, letters);
        if (letter)
            found[letter - letters] = i;
    }
    if (found[0] < 0 || found[1] < 0 || found[2] < 0)
        return false;
    memcpy(order, found, sizeof found);
    return true;
}

/* Makes the channels of a detector: X, Y and Z, and R, G and B, in this order; others in the
 * file's.
 */
static bool take_channels(const struct table *table, const struct wanted *wanted,
                          struct detector *out, struct error *err)
{
    const int n = table->n_samples;
    const struct sample *sample = table->sample;
    int order[3] = {0, 1, 2};
    if (n == 3 && !(sample[0].name.length && sample[1].name.length && sample[2].name.length))
        return error_at(err, (struct place){table->text.path, sample->reading->line, 1},
                        "the columns have no names; write a heading, 'wavelength,x,y,z' for an "
                        "observer or 'wavelength,r,g,b' for a camera");
    if (!MAKE_ARRAY(out->sensitivity, n, err, "%d channels", n) ||
        !MAKE_ARRAY(out->channel, n, err, "%d channels", n))
        return false;
    out->n = n;
    out->observer = n == 3 && find_channels(table, "xyz", order);
    out->named = out->observer || (n == 3 && find_channels(table, "rgb", order));
    for (int i = 0; i < n; i++) {
        if (!take_named(table, n == 3 ? order[i] : i, wanted, &out->sensitivity[i], err))
            return false;
        out->channel[i] = out->sensitivity[i].name;
    }
    return true;
}

/* ---- files ---- */

/* Finds a table among those that words of a text have named, or reads it. */
static bool find_table(struct tables *tables, const char *path, struct place from,
                       const struct table **out, struct error *err)
{
    int found = index_find(&tables->paths, path, strlen(path));
    if (found < 0) {
        const struct table table = {.to_nm = 1, .norm = 1};
        found = tables->n;
        if (!array_add(&tables->list, &tables->n, &table, sizeof table, err) ||
            !text_open(&tables->list[found].text, path, from, TEXT_XML, err) ||
            !read_text(&tables->list[found], err) ||
            !index_add(&tables->paths, path, strlen(path), found, err))
            return false;
    }
    *out = &tables->list[found];
    return true;
}

void tables_free(struct tables *tables)
{
    for (int i = 0; i < tables->n; i++) {
        table_free(&tables->list[i]);
        text_free(&tables->list[i].text);
    }
    free(tables->list);
    index_free(&tables->paths);
    *tables = (struct tables){.n = 0};
}

static bool read_file(const char *path, const struct wanted *wanted, struct spectrum *out,
                      struct detector *detector, struct error *err)
{
    struct tables own = {.n = 0}, *tables = wanted->table.tables ? wanted->table.tables : &own;
    const struct table *table = NULL;
    int first = 0;
    bool done = find_table(tables, path, wanted->table.place, &table, err) &&
                (detector ? take_channels(table, wanted, detector, err)
                          : choose(table, wanted, &first, err));
    for (int i = 0; done && i < wanted->count; i++)
        done = take(table, &table->sample[first + i], wanted, &out[i], err);
    tables_free(&own);
    return done;
}

/* ---- whole sets ---- */

bool set_is(struct text text)
{
    return reader_of(&text) != columns_read || columns_found(text);
}

bool set_read(struct text text, double highest, struct spectrum **out, int *n, struct error *err)
{
    const char *name = path_name(text.path);
    const struct wanted wanted = {
        .table = {.start = name, .length = strlen(name), .place = text_whole(&text)},
        .lowest = highest < HUGE_VAL ? 0 : -HUGE_VAL,
        .highest = highest,
        .factor = 1};
    struct table table = {.text = text, .to_nm = 1, .norm = 1};
    *out = NULL;
    *n = 0;
    bool done = read_text(&table, err) &&
                MAKE_ARRAY(*out, table.n_samples, err, "%d samples", table.n_samples);
    for (; done && *n < table.n_samples; ++*n)
        done = take_named(&table, *n, &wanted, &(*out)[*n], err);
    table_free(&table);
    return done;
}

void set_free(struct spectrum *samples, int n)
{
    for (int i = 0; i < n; i++)
        spectrum_free(&samples[i]);
    free(samples);
}

bool table_is_detector(const struct builtin_file *file)
{
    return strncmp(file->name, "tables/", 7) == 0 &&
           (strstr((const char *)file->bytes, "\nwavelength_nm,x,y,z\n") != NULL ||
            strstr((const char *)file->bytes, "\nwavelength_nm,r,g,b\n") != NULL);
}

/* Refuses a number, a temperature or a factor that is written in another way. */
static bool check_writing(const struct word *word, struct error *err)
{
    const int length = (int)word->length, mark = (int)strcspn(word->start, ":, "), next = mark + 1;
    const int digits = (int)strspn(word->start, "0123456789.");
    double value;
    if (digits > 0 && digits + 1 == length && strchr("kK", word->start[digits]))
        return error_at(err, word->place, "for a temperature write daylight:%.*s or blackbody:%.*s",
                        digits, word->start, digits, word->start);
    if (word_is_numeric(word, "0123456789+-.,%"))
        return word_number(word, "spectrum", 0, HUGE_VAL, &value, err);
    return next >= length || word->start[mark] == ':' ||
           (int)strspn(word->start + next, "0123456789.") < length - next ||
           error_at(err, word->place, "a factor stands behind a *: %.*s*%.*s", mark, word->start,
                    length - next, word->start + next);
}

static bool refuse_unknown(const struct wanted *wanted, const char *path, struct error *err)
{
    const bool detector = wanted->count == 0;
    const struct word *word = &wanted->table;
    struct suggestion suggestion = {.distance = 0};
    char known[BUILTIN_NAME];
    if (!detector && !check_writing(word, err))
        return false;
    suggestion_add_files(&suggestion, path, FILE_TABLE);
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

bool table_read(const struct wanted *wanted, struct spectrum *out, struct detector *detector,
                struct error *err)
{
    char *path;
    bool done = word_file(&wanted->table, FILE_TABLE, &path, err) &&
                (file_is_missing(path) ? refuse_unknown(wanted, path, err)
                                       : read_file(path, wanted, out, detector, err));
    if (done && !path_is_builtin(path))
        (detector ? detector->sensitivity : out)->path = path;
    else
        free(path);
    return done;
}

bool spectra_read(const char *name, int n, struct spectrum *out, struct detector *detector,
                  struct error *err)
{
    const struct wanted wanted = {.table = {.start = name, .length = strlen(name)},
                                  .count = n,
                                  .lowest = -HUGE_VAL,
                                  .highest = HUGE_VAL,
                                  .factor = 1};
    return table_read(&wanted, out, detector, err);
}
