/* SPDX-License-Identifier: MIT */
/* What a stack says of how it was made, so that it can be made again: lines in the description of
 * its first page, behind those of its scale. */
#include "spectral.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

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

/* False where there are too many options. Keys that are not known belong to others. */
static bool keep_line(struct record *record, const char *key, char *value)
{
    const struct {
        const char *key, **place;
    } places[] = {{"program", &record->program},           {"scene", &record->scene},
                  {"scene_sha256", &record->scene_sha256}, {"renderer", &record->renderer},
                  {"full_scale", &record->full_scale},     {"scale", &record->scale}};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++)
        if (strcmp(key, places[i].key) == 0)
            *places[i].place = value;
    if (strcmp(key, "option") != 0)
        return true;
    if (record->n_options == MAX_RECORD_OPTIONS)
        return false;
    record->options[record->n_options++] = value;
    return true;
}

/* Cuts the text into lines, and each into key and value. */
static bool keep_lines(struct record *record)
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
        good = keep_line(record, line, colon + 2);
    }
    return good && record->program != NULL && record->scene != NULL &&
           record->scene_sha256 != NULL && record->renderer != NULL && record->full_scale != NULL &&
           record->scale != NULL;
}

bool record_read(const struct image *image, struct record *out, struct error *err)
{
    *out = (struct record){.text = description_text(image->description)};
    if (out->text != NULL && keep_lines(out))
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
    *record = (struct record){.text = NULL};
}
