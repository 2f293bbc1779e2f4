/* SPDX-License-Identifier: MIT */
/* What a stack says of how it was made, so that it can be made again: lines in the description of
 * its first page, behind those of its scale. */
#include "spectral.h"

#include <ctype.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

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

/* The lights, then the ambient lights, each ended by a NUL; allocated. NULL: no memory. */
static char *source_texts(const struct scene *scene)
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

static double white_at(const struct scene *scene, double nm, double illumination)
{
    double sum = 0;
    for (int i = 0; i < scene->n_lights; i++)
        sum +=
            scene->lights[i].intensity * spectrum_at(&scene->lights[i].spectrum, nm, SPECTRUM_ZERO);
    for (int i = 0; i < scene->n_ambients; i++)
        sum += scene->ambients[i].intensity *
               spectrum_at(&scene->ambients[i].spectrum, nm, SPECTRUM_ZERO);
    return sum / illumination;
}

double scene_white(const struct scene *scene, double *out)
{
    double illumination = 0, largest = 0;
    bool finite = true;
    for (int i = 0; i < scene->n_lights; i++)
        illumination += scene->lights[i].intensity;
    for (int i = 0; i < scene->n_ambients; i++)
        illumination += scene->ambients[i].intensity;
    for (int i = 0; i < scene->n_wavelengths; i++) {
        out[i] = white_at(scene, scene->wavelengths_nm[i], illumination);
        largest = fmax(largest, out[i]);
        finite = finite && out[i] <= DBL_MAX;
    }
    return finite && largest > 0 && illumination <= DBL_MAX ? illumination : 0;
}

bool record_scene(const struct scene *scene, struct record *out, struct error *err)
{
    *out = (struct record){.scene = scene->path,
                           .scene_sha256 = scene->sha256,
                           .n_lights = scene->n_lights,
                           .n_ambients = scene->n_ambients,
                           .text = source_texts(scene)};
    const char *at = out->text;
    out->white = calloc((size_t)scene->n_wavelengths, sizeof *out->white);
    if (at != NULL) {
        out->lights = list_texts(&at, scene->n_lights);
        out->ambients = list_texts(&at, scene->n_ambients);
    }
    if (out->white == NULL || out->lights == NULL || out->ambients == NULL) {
        record_free(out);
        return error_memory(err);
    }
    out->illumination = scene_white(scene, out->white);
    out->n_white = out->illumination > 0 ? scene->n_wavelengths : 0;
    return true;
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
    if (record->n_white > 0) {
        put_numbers(stream, "illumination", &record->illumination, 1);
        put_numbers(stream, "white", record->white, record->n_white);
    }
    put_lines(stream, "object", record->objects, record->n_objects);
    if (fclose(stream) == 0)
        return text;
    free(text);
    return NULL;
}

/* ---- reading ---- */

/* Of the five entities that XML predefines, those that data/tags.c writes. In place. */
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

/* Numbers that are finite and not negative, with one blank between them. */
static bool keep_numbers(double **numbers, int *n, const char *value, struct error *err)
{
    struct error ignored = {0};
    for (const char *at = value, *end; *at != '\0'; at = *end != '\0' ? end + 1 : end) {
        end = at + strcspn(at, " ");
        const struct word word = {.start = at, .length = (size_t)(end - at)};
        double *more = array_more(*numbers, *n, sizeof *more, err);
        if (more == NULL)
            return false;
        *numbers = more;
        if (!word_number(&word, "it", 0, HUGE_VAL, &more[(*n)++], &ignored))
            return false;
    }
    return true;
}

static bool keep_number(double *out, const char *value)
{
    const struct word word = {.start = value, .length = strlen(value)};
    struct error ignored = {0};
    return word_number(&word, "it", 0, HUGE_VAL, out, &ignored);
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

/* False where it is malformed, or one too many. Keys that are not known belong to others. */
static bool keep_line(struct record *record, const char *key, char *value, struct error *err)
{
    const struct {
        const char *key, **place;
    } places[] = {{"program", &record->program},           {"scene", &record->scene},
                  {"scene_sha256", &record->scene_sha256}, {"renderer", &record->renderer},
                  {"full_scale", &record->full_scale},     {"scale", &record->scale}};
    const struct {
        const char *key;
        const char ***list;
        int *n;
    } lists[] = {{"light", &record->lights, &record->n_lights},
                 {"ambient", &record->ambients, &record->n_ambients},
                 {"object", &record->objects, &record->n_objects}};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++)
        if (strcmp(key, places[i].key) == 0)
            *places[i].place = value;
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++)
        if (strcmp(key, lists[i].key) == 0)
            return keep_value(lists[i].list, lists[i].n, value, err);
    if (strcmp(key, "white") == 0)
        return keep_numbers(&record->white, &record->n_white, value, err);
    if (strcmp(key, "illumination") == 0)
        return keep_number(&record->illumination, value);
    if (strcmp(key, "object_map") == 0)
        return keep_map(record, value);
    if (strcmp(key, "option") != 0)
        return true;
    if (record->n_options == MAX_RECORD_OPTIONS)
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

bool record_read(const struct image *image, struct record *out, struct error *err)
{
    *out = (struct record){.text = description_text(image->description)};
    if (out->text != NULL && keep_lines(out, err) &&
        (out->n_white == 0 || (out->n_white == image->n_pages && out->illumination > 0)))
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
    *record = (struct record){.text = NULL};
}
