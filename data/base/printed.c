/* SPDX-License-Identifier: MIT */
/* A text that is printed into memory. Only a whole text is returned. */
#define _GNU_SOURCE /* vasprintf */
#include <stdarg.h>
#include <unistd.h>

#include "data/base/base.h"

/* Makes room for more bytes and a NUL. */
static bool make_room(struct printed *to, size_t more)
{
    const size_t least = 256, most = SIZE_MAX / 4;
    size_t capacity = to->capacity > 0 ? to->capacity : least;
    to->failed = to->failed || more >= most || to->length >= most;
    while (!to->failed && capacity <= to->length + more)
        capacity *= 2;
    to->failed = to->failed || (capacity > to->capacity && !memory_resize(&to->text, capacity, 1));
    to->capacity = capacity;
    return !to->failed;
}

void print_bytes(struct printed *to, const void *bytes, size_t length)
{
    if (!make_room(to, length))
        return;
    if (length > 0)
        memcpy(to->text + to->length, bytes, length);
    to->length += length;
    to->text[to->length] = '\0';
}

void print_text(struct printed *to, const char *text)
{
    print_bytes(to, text, strlen(text));
}

void print_shell(struct printed *to, const char *word)
{
    const bool plain =
        *word && word[strspn(word, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                   "0123456789%+,-./:=@_")] == '\0';
    print_text(to, plain ? " " : " '");
    for (; *word; word++)
        if (*word == '\'')
            print_text(to, "'\\''");
        else
            print_bytes(to, word, 1);
    print_text(to, plain ? "" : "'");
}

void print(struct printed *to, const char *format, ...)
{
    char *text;
    va_list arguments;
    va_start(arguments, format);
    const int length = vasprintf(&text, format, arguments);
    va_end(arguments);
    to->failed = to->failed || length < 0;
    if (length < 0)
        return;
    print_bytes(to, text, (size_t)length);
    free(text);
}

void print_printable(struct printed *to, const char *text)
{
    const size_t start = to->length;
    print_text(to, text);
    if (to->failed)
        return;
    hide_unprintable(to->text + start, "");
    to->length = start + strlen(to->text + start);
}

void print_fact(struct printed *to, const char *name, const char *value)
{
    print(to, "%-17s ", name);
    print_printable(to, value);
    print_text(to, "\n");
}

/* XML 1.0, production 2, excludes control characters, surrogates, U+FFFE and U+FFFF. */
void print_xml(struct printed *to, const char *text)
{
    static const char *const entities['>' + 1] = {
        ['&'] = "&amp;", ['<'] = "&lt;", ['>'] = "&gt;", ['"'] = "&quot;"};
    const unsigned char *at = (const unsigned char *)(text ? text : "");
    while (*at != '\0') {
        const int length = utf8_length(at);
        const bool is_control = *at == 0x7f || (*at < ' ' && *at != '\n' && *at != '\t');
        const bool is_last = *at == 0xef && at[1] == 0xbf && at[2] >= 0xbe;
        if (*at <= '>' && entities[*at])
            print_text(to, entities[*at]);
        else if (length == 0 || is_control || is_last)
            print_text(to, "?");
        else
            print_bytes(to, at, (size_t)length);
        at += length > 0 ? length : 1;
    }
}

char *printed_end(struct printed *printed)
{
    print_bytes(printed, "", 0);
    char *text = printed->text;
    const bool whole = !printed->failed;
    *printed = (struct printed){.length = printed->length, .failed = true};
    if (whole)
        return text;
    free(text);
    return NULL;
}

char *printed_take(struct printed *printed, struct error *err)
{
    print_bytes(printed, "", 0);
    if (printed->failed)
        memory_lacks(err, 2 * (double)printed->length + 1, "the text that begins with '%.40s'",
                     printed->text ? printed->text : "");
    return printed_end(printed);
}

bool printed_show(struct printed *printed, int to, struct error *err)
{
    char *text = printed_take(printed, err);
    if (!text)
        return false;
    hide_unprintable(text, "\n");
    const bool done = write_all(to, text, strlen(text)) || errno == EPIPE || to == STDERR_FILENO ||
                      error_system(err, "cannot write to standard output");
    free(text);
    return done;
}
