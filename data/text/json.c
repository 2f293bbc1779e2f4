/* SPDX-License-Identifier: MIT */
/* Writes JSON into a text that grows. The caller is responsible for the structure. */
#include <math.h>

#include "data/text/text.h"

void json_begin(struct json *json)
{
    *json = (struct json){.separated = false};
    print_text(&json->printed, "{");
}

static void json_key(struct json *json, const char *key)
{
    print(&json->printed, "%s", json->separated ? ", " : "");
    if (key)
        print(&json->printed, "\"%s\": ", key);
    json->separated = true;
}

void json_open(struct json *json, const char *key, char bracket)
{
    json_key(json, key);
    print(&json->printed, "%c", bracket);
    json->separated = false;
}

void json_close(struct json *json, char bracket)
{
    print(&json->printed, "%c", bracket);
    json->separated = true;
}

/* Puts a character, and returns its length in bytes. The text is valid UTF-8, whatever the value is
 * (RFC 8259, section 8.1): a byte that is none becomes U+FFFD. */
static int put_character(struct printed *to, const unsigned char *at)
{
    const int length = utf8_length(at);
    if (*at == '"' || *at == '\\')
        print(to, "\\%c", *at);
    else if (*at < 0x20 || *at == 0x7f)
        print(to, "\\u%04x", (unsigned)*at);
    else if (length == 2 && at[0] == 0xc2 && at[1] < 0xa0) /* a control character of Latin 1 */
        print(to, "\\u%04x", (unsigned)at[1]);
    else if (length == 0)
        print_text(to, "\xef\xbf\xbd");
    else
        print_bytes(to, at, (size_t)length);
    return length > 0 ? length : 1;
}

void json_string(struct json *json, const char *key, const char *value)
{
    json_key(json, key);
    if (!value) {
        print(&json->printed, "null");
        return;
    }
    print_text(&json->printed, "\"");
    for (const unsigned char *at = (const unsigned char *)value; *at;)
        at += put_character(&json->printed, at);
    print_text(&json->printed, "\"");
}

void json_number(struct json *json, const char *key, double value)
{
    json_key(json, key);
    if (isfinite(value))
        print(&json->printed, "%.17g", value);
    else
        print(&json->printed, "null");
}

void json_count(struct json *json, const char *key, uint64_t value)
{
    json_key(json, key);
    print(&json->printed, "%llu", (unsigned long long)value);
}

void json_truth(struct json *json, const char *key, bool value)
{
    json_key(json, key);
    print(&json->printed, value ? "true" : "false");
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

char *json_take(struct json *json, struct error *err)
{
    print_text(&json->printed, "}\n");
    return printed_take(&json->printed, err);
}

bool json_write(struct json *json, const char *path, struct outputs *outputs, struct error *err)
{
    print_text(&json->printed, "}\n");
    return printed_write(&json->printed, path, outputs, err);
}
