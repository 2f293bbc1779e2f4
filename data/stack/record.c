/* SPDX-License-Identifier: MIT */
/* Writes and reads a stack's record of how it was made, by which it can be made again: lines in the
 * description of its first page, behind the lines of its scale. */
#include <ctype.h>
#include <float.h>

#include "data/stack/inside.h"

/* ---- the fields ---- */

/* A field is a line "KEY: VALUE"; of texts, a line each. Lines of full_scale, scale and
 * object_map are written by data/stack/tags.c. */
enum field_kind {
    FIELD_TEXT,   /* const char *; NULL: none */
    FIELD_TEXTS,  /* struct texts */
    FIELD_NUMBERS /* struct numbers */
};
struct field {
    const char *key;
    enum field_kind kind;
    size_t offset; /* in struct record */
    double lowest; /* of numbers */
    int count;     /* of numbers; 0: any */
};
#define AT(member) offsetof(struct record, member)
static const struct field fields[] = {
    {"program", FIELD_TEXT, AT(program), 0, 0},
    {"scene", FIELD_TEXT, AT(scene), 0, 0},
    {"scene_sha256", FIELD_TEXT, AT(scene_sha256), 0, 0},
    {"file", FIELD_TEXTS, AT(files), 0, 0},
    {"option", FIELD_TEXTS, AT(options), 0, 0},
    {"renderer", FIELD_TEXT, AT(renderer), 0, 0},
    {"mipmaps", FIELD_TEXT, AT(mipmaps), 0, 0},
    {"light", FIELD_TEXTS, AT(lights), 0, 0},
    {"ambient", FIELD_TEXTS, AT(ambients), 0, 0},
    {"unit", FIELD_TEXT, AT(unit), 0, 0},
    {"illumination", FIELD_NUMBERS, AT(illumination), 0, 1},
    {"white", FIELD_NUMBERS, AT(white), 0, 0},
    {"sampling", FIELD_TEXT, AT(sampling), 0, 0},
    {"sampling_detector", FIELD_TEXT, AT(sampling_detector), 0, 0},
    {"components", FIELD_TEXT, AT(components), 0, 0},
    {"segments", FIELD_NUMBERS, AT(segments), -HUGE_VAL, 0},
    {"response_range", FIELD_NUMBERS, AT(range_nm), -HUGE_VAL, 2},
    {"response", FIELD_NUMBERS, AT(response), -HUGE_VAL, 0},
    {"white_response", FIELD_NUMBERS, AT(white_response), -HUGE_VAL, 3},
    {"object", FIELD_TEXTS, AT(objects), 0, 0},
    {"rows", FIELD_NUMBERS, AT(rows), 0, 3},
    {"wavelengths", FIELD_NUMBERS, AT(wavelengths), 0, 0},
    {"full_scale", FIELD_TEXT, AT(full_scale), 0, 0},
    {"scale", FIELD_TEXT, AT(scale), 0, 0},
    {"object_map", FIELD_TEXT, AT(object_map), 0, 0}};
enum { FIELDS = sizeof fields / sizeof fields[0] };

/* ---- lines ---- */

/* Prints a value, in which control characters, bytes that are no UTF-8, and '%' become %XX. */
static void put_value(struct printed *to, const char *value)
{
    for (const unsigned char *at = (const unsigned char *)value; *at != '\0';) {
        const int length = utf8_length(at);
        if (length == 0 || iscntrl(*at) || *at == '%')
            print(to, "%%%02X", *at++);
        else {
            print_bytes(to, at, (size_t)length);
            at += length;
        }
    }
}

void record_put(struct printed *to, const char *key, const char *value)
{
    print(to, "%s: ", key);
    put_value(to, value);
    print_text(to, "\n");
}

static void put_numbers(struct printed *to, const char *key, const double *numbers, int n)
{
    if (n > 0)
        print(to, "%s:", key);
    for (int i = 0; i < n; i++)
        print(to, " %.*g%s", exact_digits(numbers[i]), numbers[i], i == n - 1 ? "\n" : "");
}

/* Replaces each %XX by its byte, in place. */
static void decode(char *text)
{
    char *to = text;
    for (const char *from = text; *from != '\0'; to++) {
        unsigned byte;
        if (*from == '%' && isxdigit((unsigned char)from[1]) && isxdigit((unsigned char)from[2]) &&
            sscanf(from + 1, "%2x", &byte) == 1) {
            *to = (char)byte;
            from += 3;
        } else
            *to = *from++;
    }
    *to = '\0';
}

/* Reads finite numbers, one blank between them, and adds them to those of earlier lines. A field of
 * a fixed count begins anew. */
static bool keep_numbers(struct numbers *out, const struct field *field, const char *value,
                         struct error *err)
{
    if (field->count > 0)
        out->n = 0;
    for (const char *at = value, *end; *at != '\0'; at = *end != '\0' ? end + 1 : end) {
        end = at + strcspn(at, " ");
        const struct word word = {.start = at, .length = (size_t)(end - at)};
        double number;
        if (!word_is_number(&word, field->lowest, &number) ||
            !array_add(&out->value, &out->n, &number, sizeof number, err))
            return false;
    }
    return field->count == 0 || out->n == field->count;
}

/* Keeps a value. Returns false if it is malformed. */
static bool keep_value(struct record *record, const struct field *field, char *value,
                       struct error *err)
{
    void *member = (char *)record + field->offset;
    struct texts *texts = member;
    if (field->kind == FIELD_NUMBERS)
        return keep_numbers(member, field, value, err);
    if (field->kind == FIELD_TEXTS)
        return array_add(&texts->text, &texts->n, &value, sizeof value, err);
    *(const char **)member = value;
    return true;
}

/* Cuts record->text into lines, and each into key and value. Other programs may add lines: an
 * unknown key is not an error. */
static bool keep_lines(struct record *record, struct error *err)
{
    bool good = true;
    for (char *line = record->text, *next; good && *line != '\0'; line = next) {
        next = line + strcspn(line, "\n");
        if (*next != '\0')
            *next++ = '\0';
        char *colon = strstr(line, ": ");
        if (!colon)
            continue;
        *colon = '\0';
        decode(colon + 2);
        for (int i = 0; good && i < FIELDS; i++)
            if (strcmp(line, fields[i].key) == 0)
                good = keep_value(record, &fields[i], colon + 2, err);
    }
    return good;
}

/* ---- of a scene ---- */

static void put_lights(struct printed *to, const char *key, const struct light *lights, int n)
{
    for (int i = 0; i < n; i++) {
        print(to, "%s: ", key);
        put_value(to, lights[i].spectrum.name);
        print(to, "*%.*g\n", exact_digits(lights[i].intensity), lights[i].intensity);
    }
}

/* Finds how a detector at every nm responds to the white. Returns the sum of the lights'
 * intensities; 0: nothing shines there, or the detector does not see it. */
static double respond(const struct scene *scene, const struct fine_detector *fine, double *white,
                      double out[3])
{
    const struct spectral_pages every_nm = {.n = fine->n, .wavelength_nm = fine->nm};
    const double illumination = scene_white(scene, &every_nm, white);
    bool seen = false, finite = true;
    detector_response(fine->weights, white, fine->n, out);
    for (int channel = 0; channel < 3; channel++) {
        seen = seen || out[channel] > 0;
        finite = finite && fabs(out[channel]) <= DBL_MAX;
    }
    return seen && finite ? illumination : 0;
}

/* Prints how the pages become channels. */
static void put_sampling(struct printed *to, const struct sampling *sampling)
{
    const double first_nm = sampling->pages.first_nm,
                 range_nm[] = {first_nm - 0.5, first_nm + sampling->fine.n - 0.5};
    const int n = sampling->pages.n;
    char name[SAMPLING_NAME];
    sampling_name(&sampling->method, name);
    record_put(to, "sampling", name);
    record_put(to, "sampling_detector", sampling->detector);
    if (!sampling->spectral)
        record_put(to, "components", "yes");
    if (sampling->fixed) {
        put_numbers(to, "response_range", range_nm, 2);
        put_numbers(to, "response", sampling->weights, 3 * n);
    } else if (sampling->segment_nm)
        put_numbers(to, "segments", sampling->segment_nm[0], 2 * n);
}

/* Prints the white of the pages, if something shines there, how they became pages, and, for a
 * detector at every nm, how it responds to the white. */
static bool put_light(struct printed *to, const struct scene *scene,
                      const struct sampling *sampling, struct error *err)
{
    const struct spectral_pages pages = sampling ? sampling->pages : scene_pages(scene);
    const bool fixed = sampling && sampling->fixed;
    const int n_fine = fixed ? sampling->fine.n : 0;
    double *white, response[3], finely = 0, illumination = 0;
    if (!MAKE_ARRAY(white, n_fine > pages.n ? n_fine : pages.n, err, "a white"))
        return false;
    if (fixed)
        finely = respond(scene, &sampling->fine, white, response);
    if (!sampling || sampling->spectral)
        illumination = scene_white(scene, &pages, white);
    if (illumination > 0 || finely > 0)
        put_numbers(to, "illumination", illumination > 0 ? &illumination : &finely, 1);
    if (illumination > 0)
        put_numbers(to, "white", white, pages.n);
    if (sampling)
        put_sampling(to, sampling);
    if (finely > 0)
        put_numbers(to, "white_response", response, 3);
    free(white);
    return true;
}

bool record_put_scene(struct printed *to, const struct recorded *made, struct error *err)
{
    const struct scene *scene = made->scene;
    struct inputs inputs;
    const bool done = inputs_list(scene, made->options->detector, false, &inputs, err);
    record_put(to, "program", PROGRAM);
    record_put(to, "scene", scene->path);
    record_put(to, "scene_sha256", scene->sha256);
    for (int i = 0; i < inputs.n; i++)
        record_put(to, "file", inputs.file[i]);
    inputs_free(&inputs);
    for (int i = 0; i < made->options->n_recorded; i++)
        record_put(to, "option", made->options->recorded[i]);
    record_put(to, "renderer", made->renderer);
    if (made->mipmaps)
        record_put(to, "mipmaps", made->mipmaps);
    put_lights(to, "light", scene->lights, scene->n_lights);
    put_lights(to, "ambient", scene->ambients, scene->n_ambients);
    if (scene_is_absolute(scene))
        record_put(to, "unit", ABSOLUTE_UNIT);
    return done && put_light(to, scene, made->sampling, err);
}

void record_put_beside(struct printed *to, const char *what, const struct scene *scene,
                       const struct options *options)
{
    record_put(to, "program", PROGRAM);
    record_put(to, what, scene->path);
    record_put(to, "SHA-256 of the scene", scene->sha256);
    for (int i = 0; i < options->n_recorded; i++)
        record_put(to, "option", options->recorded[i]);
}

void record_put_part(struct printed *to, const struct part_rows *rows, int height,
                     const double *wavelengths_nm, int n)
{
    put_numbers(to, "rows", (const double[]){rows->first, rows->count, height}, 3);
    put_numbers(to, "wavelengths", wavelengths_nm, n);
}

/* ---- files ---- */

/* Refuses a difference between two such texts, in lists that are sorted by paths. NULL: the list
 * has ended. */
static bool refuse_change(const char *recorded, const char *now, struct error *err)
{
    const int order = !recorded ? 1 : !now ? -1 : strcmp(input_path(recorded), input_path(now));
    if (order == 0)
        return error_usage(err,
                           "%.700s has changed since the stack was made: expected SHA-256 %.64s, "
                           "found %.64s",
                           input_path(now), recorded, now);
    return error_usage(err, "%.700s was %s file of the scene when the stack was made",
                       input_path(order < 0 ? recorded : now), order < 0 ? "a" : "no");
}

bool record_has_files(const struct record *record, const struct scene *scene, const char *detector,
                      struct error *err)
{
    struct inputs inputs;
    const int n = record->files.n;
    bool same = inputs_list(scene, detector, false, &inputs, err);
    for (int i = 0; same && (i < n || i < inputs.n); i++) {
        const char *recorded = i < n ? record->files.text[i] : NULL;
        const char *now = i < inputs.n ? inputs.file[i] : NULL;
        same = (recorded && now && strcmp(recorded, now) == 0) || refuse_change(recorded, now, err);
    }
    inputs_free(&inputs);
    return same;
}

/* ---- reading ---- */

/* Replaces, in place, the entities of XML that data/stack/tags.c writes. */
static void unescape(char *text)
{
    static const struct {
        const char *entity;
        char character;
    } known[] = {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}};
    char *to = text;
    for (const char *from = text; *from != '\0'; to++) {
        size_t length = 1;
        *to = *from;
        for (size_t i = 0; *from == '&' && i < sizeof known / sizeof known[0]; i++)
            if (strncmp(from, known[i].entity, strlen(known[i].entity)) == 0) {
                length = strlen(known[i].entity);
                *to = known[i].character;
                break;
            }
        from += length;
    }
    *to = '\0';
}

char *description_text(const char *xml, struct error *err)
{
    static const char begin[] = "<Description>";
    const char *from = strstr(xml, begin), *to = from != NULL ? strstr(from, "</") : NULL;
    if (!to)
        return NULL;
    from += strlen(begin);
    char *text = strndup(from, (size_t)(to - from));
    if (text != NULL)
        unescape(text);
    else
        memory_lacks(err, (double)(to - from), "a record");
    return text;
}

/* Reads "OFFSET BYTES_PER_PIXEL". Returns true for a record without a map. */
static bool read_map(struct record *record)
{
    const char *map = record->object_map;
    if (!map)
        return true;
    char *bytes;
    record->map_offset = strtoull(map, &bytes, 10); /* larger numbers become ULLONG_MAX */
    if (!isdigit((unsigned char)map[0]) || record->map_offset > INT64_MAX ||
        (strcmp(bytes, " 1") != 0 && strcmp(bytes, " 2") != 0))
        return false;
    record->map_bytes = bytes[1] - '0';
    return true;
}

/* Returns whether these are two limits that a sum over cells of 1 nm can take: at most the scene
 * language's longest wavelength. */
static bool is_range(const double limits[2])
{
    return limits[0] >= -1 && limits[1] > limits[0] && limits[1] <= 1e6 + 1;
}

/* Pages of one segment follow each other, no more than a quadrature has; each lies in its segment,
 * but for the digits in which pages record their wavelengths. */
static bool segments_agree(const struct record *record, const struct image *image)
{
    const double slack = 1e-9, *nm = image->wavelengths_nm, *own = record->segments.value;
    int together = 0;
    for (int i = 0; nm && i < image->n_pages; i++, own += 2) {
        const bool joins = i > 0 && own[0] == own[-2] && own[1] == own[-1];
        together = joins ? together + 1 : 1;
        if (!is_range(own) || together > LARGEST_QUADRATURE ||
            (i > 0 && !joins && own[0] < own[-1]) || nm[i] < own[0] * (1 - slack) ||
            nm[i] > own[1] * (1 + slack))
            return false;
    }
    return nm != NULL;
}

/* Returns whether the record describes in one way, and for all pages, how they become channels. */
static bool sampling_agrees(const struct record *record, const struct image *image)
{
    const int n_segments = record->segments.n, n_response = record->response.n;
    if (!record->sampling != !record->sampling_detector)
        return false;
    if (n_response == 0 && (record->components || record->white_response.n > 0))
        return false;
    if (n_segments + n_response > 0 && (!record->sampling || (n_segments > 0 && n_response > 0)))
        return false;
    if (n_segments > 0 && !(n_segments == 2 * image->n_pages && segments_agree(record, image)))
        return false;
    if (n_response > 0 && !(n_response == 3 * image->n_pages && record->range_nm.n == 2 &&
                            is_range(record->range_nm.value)))
        return false;
    return !record->components || (strcmp(record->components, "yes") == 0 &&
                                   !image->wavelengths_nm && record->white.n == 0);
}

/* Returns whether the record has no rows, or those of the image, which lie in their picture, and a
 * wavelength for each page. */
static bool rows_agree(const struct record *record, const struct image *image)
{
    const double *rows = record->rows.value;
    return record->rows.n == 0 ||
           (rows[0] == floor(rows[0]) && rows[1] == image->height && rows[2] == floor(rows[2]) &&
            rows[0] + rows[1] <= rows[2] && rows[2] <= LONGEST_SIDE &&
            record->wavelengths.n == (record->components ? 0 : image->n_pages));
}

double record_illumination(const struct record *record)
{
    return record->illumination.n > 0 ? record->illumination.value[0] : 0;
}

bool record_is_there(const struct image *image)
{
    return strstr(image->description, "scene_sha256: ") != NULL;
}

bool record_read(const struct image *image, struct record *out, struct error *err)
{
    *out = (struct record){.text = description_text(image->description, err)};
    if (out->text != NULL && keep_lines(out, err) && out->program && out->scene &&
        out->scene_sha256 && out->renderer && out->full_scale != NULL && out->scale != NULL &&
        read_map(out) && (out->white.n == 0 || out->white.n == image->n_pages) &&
        rows_agree(out, image) &&
        (record_illumination(out) > 0 || out->white.n + out->white_response.n == 0) &&
        sampling_agrees(out, image))
        return true;
    record_free(out);
    if (record_is_there(image))
        return error_usage(err,
                           "%s: its record of how it was made is damaged, or does not fit its %d"
                           " pages; render it again, or remove its ImageDescription",
                           image->path, image->n_pages);
    return error_usage(err,
                       "%s: has no record of how it was made; expected a stack of spectral 0.2.0"
                       " or later",
                       image->path);
}

void record_free(struct record *record)
{
    free(record->text);
    for (int i = 0; i < FIELDS; i++) {
        void *member = (char *)record + fields[i].offset;
        if (fields[i].kind == FIELD_TEXTS)
            free(((struct texts *)member)->text);
        if (fields[i].kind == FIELD_NUMBERS)
            free(((struct numbers *)member)->value);
    }
    *record = (struct record){.text = NULL};
}
