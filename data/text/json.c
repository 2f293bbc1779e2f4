/* SPDX-License-Identifier: MIT */
/* Writes facts into a text that grows: as JSON, or as words in lines. The caller is responsible for
 * the structure. */
#include <unistd.h>

#include "data/text/text.h"

void json_begin(struct json *json)
{
    *json = (struct json){.separated = false};
    print_text(&json->printed, "{");
}

void words_begin(struct json *json)
{
    *json = (struct json){.words = true};
}

/* ---- lines of words ---- */

/* Begins a line: "scene_sha256" becomes "scene sha256", and an entry of the list "files" a "file".
 */
static void put_name(struct json *json, const char *key)
{
    char name[32];
    const size_t length = (size_t)snprintf(name, sizeof name, "%s", key ? key : json->list);
    if (!key && name[length - 1] == 's')
        name[length - 1] = '\0';
    for (char *at = name; *at; at++)
        *at = *at == '_' ? ' ' : *at;
    print(&json->printed, "%*s%-*s ", 2 * json->depth, "", 17 - 2 * json->depth, name);
}

/* An entry of a list has all members in one line: "first: name second, name third". */
static void words_key(struct json *json, const char *key)
{
    if (json->n_row == 0)
        put_name(json, key);
    else if (json->n_row++ > 1 && key)
        print(&json->printed, "%s%s ", json->n_row == 3 ? ": " : ", ", key);
}

/* ---- either ---- */

static void json_key(struct json *json, const char *key)
{
    if (json->words)
        words_key(json, key);
    else
        print(&json->printed, "%s", json->separated ? ", " : "");
    if (!json->words && key)
        print(&json->printed, "\"%s\": ", key);
    json->separated = true;
}

/* Puts a whole value: one text for JSON, another for words. Words leave out what is "null". */
static void put_value(struct json *json, const char *key, const char *value, const char *words)
{
    if (json->words && strcmp(value, "null") == 0)
        return;
    json_key(json, key);
    print_printable(&json->printed, json->words ? words : value);
    if (json->words && json->n_row == 0)
        print_text(&json->printed, "\n");
}

void json_open(struct json *json, const char *key, char bracket)
{
    if (!json->words) {
        json_key(json, key);
        print(&json->printed, "%c", bracket);
        json->separated = false;
    } else if (bracket == '[')
        json->list = key;
    else if (json->list) {
        put_name(json, NULL);
        json->n_row = 1;
    } else {
        if (key)
            print(&json->printed, "%*s%s\n", 2 * json->depth, "", key);
        json->depth++;
    }
}

void json_close(struct json *json, char bracket)
{
    if (!json->words)
        print(&json->printed, "%c", bracket);
    else if (bracket == ']')
        json->list = NULL;
    else if (json->list) {
        print_text(&json->printed, "\n");
        json->n_row = 0;
    } else
        json->depth--;
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
    if (!value || json->words) {
        put_value(json, key, value ? "" : "null", value);
        return;
    }
    json_key(json, key);
    print_text(&json->printed, "\"");
    for (const unsigned char *at = (const unsigned char *)value; *at;)
        at += put_character(&json->printed, at);
    print_text(&json->printed, "\"");
}

void json_number(struct json *json, const char *key, double value)
{
    char exact[32], words[32];
    snprintf(exact, sizeof exact, "%.17g", value);
    snprintf(words, sizeof words, "%.6g", value);
    put_value(json, key, isfinite(value) ? exact : "null", isfinite(value) ? words : "none");
}

void json_count(struct json *json, const char *key, uint64_t value)
{
    char text[24];
    snprintf(text, sizeof text, "%llu", (unsigned long long)value);
    put_value(json, key, text, text);
}

void json_truth(struct json *json, const char *key, bool value)
{
    put_value(json, key, value ? "true" : "false", value ? "yes" : "no");
}

void json_numbers(struct json *json, const char *key, const double *values, int n)
{
    char words[64];
    if (!values || json->words) {
        if (values)
            snprintf(words, sizeof words, "%.10g to %.10g", values[0], values[n - 1]);
        put_value(json, key, values ? "" : "null", words);
        return;
    }
    json_open(json, key, '[');
    for (int i = 0; i < n; i++)
        json_number(json, NULL, values[i]);
    json_close(json, ']');
}

void json_strings(struct json *json, const char *key, const char *const *values, int n)
{
    json_open(json, key, '[');
    for (int i = 0; i < n; i++)
        json_string(json, NULL, values[i]);
    json_close(json, ']');
}

char *json_take(struct json *json, struct error *err)
{
    print_text(&json->printed, "}\n");
    return printed_take(&json->printed, err);
}

bool json_write(struct json *json, const char *path, struct outputs *outputs, struct error *err)
{
    if (json->words)
        return printed_show(&json->printed, STDOUT_FILENO, err);
    print_text(&json->printed, "}\n");
    return printed_write(&json->printed, path, outputs, err);
}

bool report_write(struct options *options, struct json *json, struct printed *text,
                  struct error *err)
{
    bool done = !options->json || json_write(json, options->json, &options->outputs, err);
    if (done && (options->output || !options->json))
        done = printed_write(text, options->output ? options->output : "-", &options->outputs, err);
    FREE_ALL(json->printed.text, text->text); /* those that were not written */
    return done;
}
