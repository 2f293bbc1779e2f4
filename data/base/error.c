/* SPDX-License-Identifier: MIT */
/* A failure is one line of text and an exit status. The text needs no allocation, so that it works
 * when memory has run out. Nothing is printed here: the command line decides what the user sees. */
#include <limits.h>
#include <stdarg.h>

#include "data/base/base.h"

/* The path of a place gets half of the text at most: the message matters more. */
enum { LONGEST_PATH = sizeof((struct error *)NULL)->text / 2 };

/* Returns the length of the words before a message. */
static size_t write_place(struct place place, char *out, size_t room)
{
    const char *path = place.path;
    if (path != NULL && place.line > 0)
        return (size_t)snprintf(out, room, "%.*s:%d:%d: error: ", LONGEST_PATH, path, place.line,
                                place.column);
    return (size_t)snprintf(out, room, "%.*s%serror: ", LONGEST_PATH, path ? path : "",
                            path ? ": " : "");
}

/* Returns whether a path is at fault: another path, or another right to it, would do. */
static bool is_of_path(int cause)
{
    static const int causes[] = {ENOENT,       ENOTDIR, EISDIR, EACCES, EPERM, ELOOP,
                                 ENAMETOOLONG, ENXIO,   ENODEV, EINVAL, EBADF};
    for (size_t i = 0; i < sizeof causes / sizeof causes[0]; i++)
        if (cause == causes[i])
            return true;
    return false;
}

/* Cuts a message that is too long before its end, which is the description of the cause; 0 is
 * none. */
bool error_of(struct error *err, enum error_kind kind, struct place place, const char *format, ...)
{
    const int cause = kind == ERROR_SYSTEM || kind == ERROR_CAUSE ? errno : 0;
    const bool input = kind == ERROR_INPUT || (kind == ERROR_CAUSE && is_of_path(cause));
    char ending[256] = "";
    va_list arguments;
    if (err->status != EXIT_AGREED)
        return false;
    err->status = input ? EXIT_INPUT : kind == ERROR_DIFFERENT ? EXIT_DIFFERENT : EXIT_SYSTEM;
    err->unsupported = kind == ERROR_UNSUPPORTED;
    if (cause != 0)
        snprintf(ending, sizeof ending, ": %s", strerror(cause));
    const size_t room = sizeof err->text - strlen(ending),
                 used = write_place(place, err->text, room);
    va_start(arguments, format);
    vsnprintf(err->text + used, room - used, format, arguments);
    va_end(arguments);
    strcat(err->text, ending);
    hide_unprintable(err->text, "");
    return false;
}

/* An array is full when its count is a power of two. It then doubles. */
bool array_add(void *array, int *count, const void *item, size_t size, struct error *err)
{
    const size_t n = (size_t)*count, room = n > 0 ? 2 * n : 1;
    char *items;
    if (*count > INT_MAX / 2 || ((n & (n - 1)) == 0 && !memory_resize(array, room, size)))
        return memory_lacks(err, (double)room * (double)size, "a list of %zu items", room);
    memcpy(&items, array, sizeof items);
    if (item)
        memcpy(items + n * size, item, size);
    else
        memset(items + n * size, 0, size);
    ++*count;
    return true;
}

const char *error_words(const struct error *err)
{
    static const char prefix[] = "error: ";
    const size_t length = sizeof prefix - 1;
    return err->text + (strncmp(err->text, prefix, length) == 0 ? length : 0);
}
