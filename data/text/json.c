/* SPDX-License-Identifier: MIT */
/* Writes JSON into a text that grows. The caller is responsible for the structure. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "data/text/text.h"

static void json_text(struct json *json, const char *format, ...) PRINTF_LIKE(2, 3);

static void json_text(struct json *json, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    if (json->printed.to)
        vfprintf(json->printed.to, format, arguments);
    va_end(arguments);
}

void json_begin(struct json *json)
{
    *json = (struct json){.separated = false};
    printed_begin(&json->printed);
}

static void json_key(struct json *json, const char *key)
{
    json_text(json, "%s", json->separated ? ", " : "");
    if (key)
        json_text(json, "\"%s\": ", key);
    json->separated = true;
}

void json_open(struct json *json, const char *key, char bracket)
{
    json_key(json, key);
    json_text(json, "%c", bracket);
    json->separated = false;
}

void json_close(struct json *json, char bracket)
{
    json_text(json, "%c", bracket);
    json->separated = true;
}

void json_string(struct json *json, const char *key, const char *value)
{
    json_key(json, key);
    if (!value) {
        json_text(json, "null");
        return;
    }
    json_text(json, "\"");
    for (const char *c = value; *c; c++)
        if (*c == '"' || *c == '\\')
            json_text(json, "\\%c", *c);
        else if ((unsigned char)*c < 0x20)
            json_text(json, "\\u%04x", (unsigned)*c);
        else
            json_text(json, "%c", *c);
    json_text(json, "\"");
}

void json_number(struct json *json, const char *key, double value)
{
    json_key(json, key);
    if (isfinite(value))
        json_text(json, "%.17g", value);
    else
        json_text(json, "null");
}

void json_count(struct json *json, const char *key, uint64_t value)
{
    json_key(json, key);
    json_text(json, "%llu", (unsigned long long)value);
}

void json_truth(struct json *json, const char *key, bool value)
{
    json_key(json, key);
    json_text(json, value ? "true" : "false");
}

void json_numbers(struct json *json, const char *key, const double *values, int n)
{
    if (!values) {
        json_string(json, key, NULL);
        return;
    }
    json_open(json, key, '[');
    for (int i = 0; i < n; i++)
        json_number(json, NULL, values[i]);
    json_close(json, ']');
}

char *json_end(struct json *json)
{
    json_text(json, "\n");
    return printed_end(&json->printed);
}

bool json_write(struct json *json, const char *path, struct error *err)
{
    char *text = json_end(json);
    const bool done = text ? file_write(path, text, strlen(text), err) : error_memory(err);
    free(text);
    return done;
}
