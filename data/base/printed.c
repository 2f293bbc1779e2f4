/* SPDX-License-Identifier: MIT */
/* A text that is printed into memory. Only a whole text is returned. */
#include <stdarg.h>
#include <unistd.h>

#include "data/base/base.h"

/* ---- numbers in files: their lowest byte comes first; some machines have the highest one first in
 * memory ---- */

bool machine_is_big_endian(void)
{
    const uint16_t one = 1;
    return *(const unsigned char *)&one == 0;
}

void store_numbers(void *out, const void *numbers, size_t size, size_t length)
{
    const char *from = numbers;
    char *to = out;
    if (!machine_is_big_endian())
        memcpy(out, numbers, length);
    else
        for (size_t i = 0; i < length; i++)
            to[i] = from[i ^ (size - 1)];
}

/* ---- a text ---- */

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

void print_stored(struct printed *to, const void *numbers, size_t size, size_t length)
{
    if (!make_room(to, length))
        return;
    if (length > 0)
        store_numbers(to->text + to->length, numbers, size, length);
    to->length += length;
    to->text[to->length] = '\0';
}

void print_bytes(struct printed *to, const void *bytes, size_t length)
{
    print_stored(to, bytes, 1, length);
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
    va_list arguments;
    va_start(arguments, format);
    const size_t room = to->failed ? 0 : to->capacity - to->length;
    const int length = vsnprintf(room > 0 ? to->text + to->length : NULL, room, format, arguments);
    va_end(arguments);
    if (length < 0)
        to->failed = true;
    else if (make_room(to, (size_t)length)) {
        va_start(arguments, format);
        if ((size_t)length >= room)
            vsnprintf(to->text + to->length, (size_t)length + 1, format, arguments);
        va_end(arguments);
        to->length += (size_t)length;
    }
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

/* memory_lacks leaves an earlier failure as it is. */
char *printed_take(struct printed *printed, struct error *err)
{
    print_bytes(printed, "", 0);
    printed->failed = printed->failed || err->status > EXIT_DIFFERENT;
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
