/* SPDX-License-Identifier: MIT */
/* A stack's record of how it was made, so that it can be made again: lines in the description of
 * its first page, behind those of its scale. */
#include <ctype.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/record/record.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/terms/terms.h"
#include "data/text/text.h"
#include "spectral.h"

/* ---- of a scene ---- */

int exact_digits(double number)
{
    char text[32];
    for (int digits = 15; digits < 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, number);
        if (strtod(text, NULL) == number)
            return digits;
    }
    return 17;
}

static void put_source(FILE *stream, const struct spectrum *spectrum, double intensity)
{
    fprintf(stream, "%s*%.*g%c", spectrum->name, exact_digits(intensity), intensity, '\0');
}

/* The lights, then the ambient lights, then the name of the sampling, each ended by a NUL;
 * allocated. NULL: no memory. */
static char *source_texts(const struct scene *scene, const char *sampling)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (stream == NULL)
        return NULL;
    for (int i = 0; i < scene->n_lights; i++)
        put_source(stream, &scene->lights[i].spectrum, scene->lights[i].intensity);
    for (int i = 0; i < scene->n_ambients; i++)
        put_source(stream, &scene->ambients[i].spectrum, scene->ambients[i].intensity);
    fprintf(stream, "%s%c", sampling, '\0');
    if (fclose(stream) == 0)
        return text;
    free(text);
    return NULL;
}

/* An array of the next n texts; *at moves behind them. */
static const char **list_texts(const char **at, int n)
{
    const char **list = calloc((size_t)n + 1, sizeof *list);
    for (int i = 0; list != NULL && i < n; i++) {
        list[i] = *at;
        *at += strlen(*at) + 1;
    }
    return list;
}

/* The white's response where the response of the pages is fixed. */
static bool record_white_response(const struct scene *scene, const struct sampling *sampling,
                                  struct record *out, struct error *err)
{
    double illumination;
    if (!sampling_white(sampling, scene, out->white_response, &illumination, err))
        return false;
    out->has_white_response = illumination > 0;
    if (out->has_white_response)
        out->illumination = illumination;
    return true;
}

static bool copy_numbers(double **out, const double *numbers, size_t n, struct error *err)
{
    *out = calloc(n, sizeof **out);
    if (*out == NULL)
        return error_memory(err);
    memcpy(*out, numbers, n * sizeof **out);
    return true;
}

static bool record_sampling(const struct sampling_description *sampling, struct record *out,
                            struct error *err)
{
    const size_t n = (size_t)sampling->n;
    out->sampling_detector = sampling->detector;
    out->components = sampling->components;
    if (sampling->response != NULL) {
        memcpy(out->range_nm, sampling->range_nm, sizeof out->range_nm);
        out->n_response = 3 * sampling->n;
        return copy_numbers(&out->response, sampling->response, 3 * n, err);
    }
    if (sampling->segment_nm == NULL)
        return true;
    out->n_segments = 2 * sampling->n;
    return copy_numbers(&out->segments, sampling->segment_nm[0], 2 * n, err);
}

/* The white of the pages; components have none. */
static bool record_white(const struct scene *scene, const struct sampling *sampling,
                         struct record *out, struct error *err)
{
    const struct spectral_pages pages =
        sampling != NULL ? sampling_pages(sampling) : scene_pages(scene);
    out->white = calloc((size_t)pages.n, sizeof *out->white);
    if (out->white == NULL)
        return error_memory(err);
    out->illumination = scene_white(scene, &pages, out->white);
    out->n_white = out->illumination > 0 ? pages.n : 0;
    return true;
}

/* `sampling` is a name; "": none. */
static bool record_sources(const struct scene *scene, const char *sampling, struct record *out,
                           struct error *err)
{
    const char *at = out->text = source_texts(scene, sampling);
    if (at == NULL)
        return error_memory(err);
    out->lights = list_texts(&at, scene->n_lights);
    out->ambients = list_texts(&at, scene->n_ambients);
    out->sampling = *at != '\0' ? at : NULL;
    return (out->lights != NULL && out->ambients != NULL) || error_memory(err);
}

bool record_scene(const struct scene *scene, const struct sampling *sampling, struct record *out,
                  struct error *err)
{
    *out = (struct record){.scene = scene->path,
                           .scene_sha256 = scene->sha256,
                           .n_lights = scene->n_lights,
                           .n_ambients = scene->n_ambients};
    struct sampling_description description = {.method = ""};
    if (sampling != NULL)
        sampling_describe(sampling, &description);
    const bool done = record_sources(scene, description.method, out, err) &&
                      record_white(scene, sampling, out, err) &&
                      record_sampling(&description, out, err) &&
                      (out->n_response == 0 || record_white_response(scene, sampling, out, err));
    if (out->components)
        out->n_white = 0;
    if (!done)
        record_free(out);
    return done;
}

/* ---- writing ---- */

static void put_line(FILE *stream, const char *key, const char *value)
{
    const unsigned char *at = (const unsigned char *)value;
    fprintf(stream, "%s: ", key);
    while (*at != '\0') {
        const int length = utf8_length(at);
        if (length == 0 || iscntrl(*at) || *at == '%')
            fprintf(stream, "%%%02X", *at++);
        else {
            fwrite(at, 1, (size_t)length, stream);
            at += length;
        }
    }
    putc('\n', stream);
}

static void put_numbers(FILE *stream, const char *key, const double *numbers, int n)
{
    fprintf(stream, "%s:", key);
    for (int i = 0; i < n; i++)
        fprintf(stream, " %.*g", exact_digits(numbers[i]), numbers[i]);
    putc('\n', stream);
}

static void put_lines(FILE *stream, const char *key, const char **values, int n)
{
    for (int i = 0; i < n; i++)
        put_line(stream, key, values[i]);
}

static void put_sampling(FILE *stream, const struct record *record)
{
    put_line(stream, "sampling", record->sampling);
    put_line(stream, "sampling_detector", record->sampling_detector);
    if (record->components)
        put_line(stream, "components", "yes");
    if (record->n_segments > 0)
        put_numbers(stream, "segments", record->segments, record->n_segments);
    if (record->n_response > 0) {
        put_numbers(stream, "response_range", record->range_nm, 2);
        put_numbers(stream, "response", record->response, record->n_response);
    }
    if (record->has_white_response)
        put_numbers(stream, "white_response", record->white_response, 3);
}

char *record_text(const struct record *record)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (stream == NULL)
        return NULL;
    put_line(stream, "program", record->program);
    put_line(stream, "scene", record->scene);
    put_line(stream, "scene_sha256", record->scene_sha256);
    for (int i = 0; i < record->n_options; i++)
        put_line(stream, "option", record->options[i]);
    put_line(stream, "renderer", record->renderer);
    put_lines(stream, "light", record->lights, record->n_lights);
    put_lines(stream, "ambient", record->ambients, record->n_ambients);
    if (record->n_white > 0 || record->has_white_response)
        put_numbers(stream, "illumination", &record->illumination, 1);
    if (record->n_white > 0)
        put_numbers(stream, "white", record->white, record->n_white);
    if (record->sampling != NULL)
        put_sampling(stream, record);
    put_lines(stream, "object", record->objects, record->n_objects);
    if (fclose(stream) == 0)
        return text;
    free(text);
    return NULL;
}

/* ---- reading ---- */

/* Replaces, in place, those of XML's five predefined entities that data/stack/tags.c writes. */
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

/* The text of the OME-XML's element Description, unescaped; allocated. NULL: none, or no memory. */
static char *description_text(const char *xml)
{
    static const char begin[] = "<Description>";
    const char *from = strstr(xml, begin), *to = from != NULL ? strstr(from, "</") : NULL;
    if (to == NULL)
        return NULL;
    from += strlen(begin);
    char *text = strndup(from, (size_t)(to - from));
    if (text != NULL)
        unescape(text);
    return text;
}

/* Each %XX becomes its byte. In place. */
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

/* Adds finite numbers from `lowest` on, with one blank between them. */
static bool keep_numbers(double **numbers, int *n, double lowest, const char *value,
                         struct error *err)
{
    struct error ignored = {0};
    for (const char *at = value, *end; *at != '\0'; at = *end != '\0' ? end + 1 : end) {
        end = at + strcspn(at, " ");
        const struct word word = {.start = at, .length = (size_t)(end - at)};
        double *more = array_more(*numbers, *n, sizeof *more, err);
        if (more == NULL)
            return false;
        *numbers = more;
        if (!word_number(&word, "it", lowest, HUGE_VAL, &more[(*n)++], &ignored))
            return false;
    }
    return true;
}

/* As many numbers as there is room for. */
static bool keep_few(double *out, int room, double lowest, const char *value, struct error *err)
{
    double *numbers = NULL;
    int n = 0;
    const bool good = keep_numbers(&numbers, &n, lowest, value, err) && n == room;
    if (good)
        memcpy(out, numbers, (size_t)n * sizeof *out);
    free(numbers);
    return good;
}

/* "OFFSET BYTES_PER_PIXEL" */
static bool keep_map(struct record *record, const char *value)
{
    const size_t length = strcspn(value, " ");
    const struct word offset = {.start = value, .length = length};
    const char *bytes = value + length;
    struct error ignored = {0};
    long at;
    if (!word_integer(&offset, "it", 1, LONG_MAX, &at, &ignored) ||
        (strcmp(bytes, " 1") != 0 && strcmp(bytes, " 2") != 0))
        return false;
    record->map_offset = (uint64_t)at;
    record->map_bytes = bytes[1] - '0';
    return true;
}

static bool keep_value(const char ***list, int *n, const char *value, struct error *err)
{
    const char **more = array_more(*list, *n, sizeof *more, err);
    if (more == NULL)
        return false;
    *list = more;
    more[(*n)++] = value;
    return true;
}

/* Texts of which there is one. */
static void keep_text(struct record *record, const char *key, const char *value)
{
    const struct {
        const char *key, **place;
    } texts[] = {
        {"program", &record->program},           {"scene", &record->scene},
        {"scene_sha256", &record->scene_sha256}, {"renderer", &record->renderer},
        {"full_scale", &record->full_scale},     {"scale", &record->scale},
        {"sampling", &record->sampling},         {"sampling_detector", &record->sampling_detector}};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        if (strcmp(key, texts[i].key) == 0)
            *texts[i].place = value;
}

/* Texts and numbers of which there are any number. Returns false where they are malformed. */
static bool keep_list(struct record *record, const char *key, const char *value, struct error *err)
{
    const struct {
        const char *key;
        const char ***texts;
        int *n;
    } lists[] = {{"light", &record->lights, &record->n_lights},
                 {"ambient", &record->ambients, &record->n_ambients},
                 {"object", &record->objects, &record->n_objects}};
    const struct {
        const char *key;
        double **numbers;
        int *n;
        double lowest;
    } arrays[] = {{"white", &record->white, &record->n_white, 0},
                  {"segments", &record->segments, &record->n_segments, -HUGE_VAL},
                  {"response", &record->response, &record->n_response, -HUGE_VAL}};
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++)
        if (strcmp(key, lists[i].key) == 0)
            return keep_value(lists[i].texts, lists[i].n, value, err);
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        if (strcmp(key, arrays[i].key) == 0)
            return keep_numbers(arrays[i].numbers, arrays[i].n, arrays[i].lowest, value, err);
    return true;
}

/* Returns false where the value is malformed, or one too many. Other programs may add lines: a key
 * that is unknown is no fault. */
static bool keep_line(struct record *record, const char *key, char *value, struct error *err)
{
    keep_text(record, key, value);
    if (strcmp(key, "illumination") == 0)
        return keep_few(&record->illumination, 1, 0, value, err);
    if (strcmp(key, "response_range") == 0)
        return keep_few(record->range_nm, 2, -HUGE_VAL, value, err);
    if (strcmp(key, "white_response") == 0)
        return record->has_white_response =
                   keep_few(record->white_response, 3, -HUGE_VAL, value, err);
    if (strcmp(key, "components") == 0)
        return record->components = strcmp(value, "yes") == 0;
    if (strcmp(key, "object_map") == 0)
        return keep_map(record, value);
    if (strcmp(key, "option") != 0)
        return keep_list(record, key, value, err);
    if (record->n_options == MAX_RECORDED)
        return false;
    record->options[record->n_options++] = value;
    return true;
}

/* Cuts the text into lines, and each into key and value. */
static bool keep_lines(struct record *record, struct error *err)
{
    bool good = true;
    for (char *line = record->text, *next; good && *line != '\0'; line = next) {
        char *colon = strstr(line, ": ");
        next = line + strcspn(line, "\n");
        if (*next != '\0')
            *next++ = '\0';
        if (colon == NULL || colon >= next)
            continue;
        *colon = '\0';
        decode(colon + 2);
        good = keep_line(record, line, colon + 2, err);
    }
    return good && record->program != NULL && record->scene != NULL &&
           record->scene_sha256 != NULL && record->renderer != NULL && record->full_scale != NULL &&
           record->scale != NULL;
}

/* Limits of what a sum over cells of 1 nm takes: the scene language's longest wavelength. */
static bool is_range(const double limits[2])
{
    return limits[0] >= -1 && limits[1] > limits[0] && limits[1] <= 1e6 + 1;
}

/* Those of one segment follow each other, no more than a quadrature has; each lies in its own, but
 * for the digits in which pages tell their wavelengths. */
static bool segments_agree(const struct record *record, const struct image *image)
{
    const double slack = 1e-9, *nm = image->wavelengths_nm, *own = record->segments;
    int together = 0;
    for (int i = 0; nm != NULL && i < image->n_pages; i++, own += 2) {
        const bool joins = i > 0 && own[0] == own[-2] && own[1] == own[-1];
        together = joins ? together + 1 : 1;
        if (!is_range(own) || together > LARGEST_QUADRATURE ||
            (i > 0 && !joins && own[0] < own[-1]) || nm[i] < own[0] * (1 - slack) ||
            nm[i] > own[1] * (1 + slack))
            return false;
    }
    return nm != NULL;
}

/* How pages become channels is told in one way, and of all pages. */
static bool sampling_agrees(const struct record *record, const struct image *image)
{
    const int n = image->n_pages;
    const bool agrees =
        (record->sampling != NULL) == (record->sampling_detector != NULL) &&
        (record->n_segments == 0 ||
         (record->n_segments == 2 * n && segments_agree(record, image))) &&
        (record->n_response == 0 || (record->n_response == 3 * n && is_range(record->range_nm))) &&
        (record->n_response == 0 || record->n_segments == 0) &&
        (record->sampling != NULL || record->n_segments + record->n_response == 0);
    return agrees &&
           (record->n_response > 0 || !(record->components || record->has_white_response)) &&
           !(record->components && (image->wavelengths_nm != NULL || record->n_white > 0));
}

bool record_read(const struct image *image, struct record *out, struct error *err)
{
    *out = (struct record){.text = description_text(image->description)};
    if (out->text != NULL && keep_lines(out, err) &&
        (out->n_white == 0 || out->n_white == image->n_pages) &&
        (out->illumination > 0 || (out->n_white == 0 && !out->has_white_response)) &&
        sampling_agrees(out, image))
        return true;
    record_free(out);
    return error_usage(err,
                       "%s: does not tell how it was made; only stacks of spectral 0.2.0 or later"
                       " do",
                       image->path);
}

void record_free(struct record *record)
{
    free(record->text);
    free(record->lights);
    free(record->ambients);
    free(record->objects);
    free(record->white);
    free(record->segments);
    free(record->response);
    *record = (struct record){.text = NULL};
}
