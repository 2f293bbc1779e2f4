/* SPDX-License-Identifier: MIT */
/* A failure is one line of text and an exit status. The text needs no allocation, so that it works
 * when memory has run out. Nothing is printed here: the command line decides what the user sees. */
#include <limits.h>
#include <stdarg.h>
#include <string.h>

#include "data/base/base.h"

/* Cuts a message that is too long before `ending`, which is the cause. */
static bool fail(struct error *err, enum exit_status status, const char *prefix, const char *format,
                 va_list arguments, const char *ending)
{
    size_t room = sizeof err->text - strlen(ending), used;
    if (err->status != EXIT_AGREED)
        return false;
    err->status = status;
    snprintf(err->text, room, "%serror: ", prefix);
    used = strlen(err->text);
    vsnprintf(err->text + used, room - used, format, arguments);
    strcat(err->text, ending);
    hide_unprintable(err->text, "");
    return false;
}

/* Room for a place. The path gets half of the text at most: the message matters more. */
enum { LONGEST_PATH = sizeof((struct error *)NULL)->text / 2, PLACE_SIZE = LONGEST_PATH + 32 };

static void write_place(struct place place, char out[PLACE_SIZE])
{
    out[0] = '\0';
    if (place.path != NULL && place.line > 0)
        snprintf(out, PLACE_SIZE, "%.*s:%d:%d: ", LONGEST_PATH, place.path, place.line,
                 place.column);
    else if (place.path != NULL)
        snprintf(out, PLACE_SIZE, "%.*s: ", LONGEST_PATH, place.path);
}

bool error_at(struct error *err, struct place place, const char *format, ...)
{
    char prefix[PLACE_SIZE];
    va_list arguments;
    write_place(place, prefix);
    va_start(arguments, format);
    fail(err, EXIT_INPUT, prefix, format, arguments, "");
    va_end(arguments);
    return false;
}

bool error_usage(struct error *err, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(err, EXIT_INPUT, "", format, arguments, "");
    va_end(arguments);
    return false;
}

bool error_different(struct error *err, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(err, EXIT_DIFFERENT, "", format, arguments, "");
    va_end(arguments);
    return false;
}

bool error_failed(struct error *err, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(err, EXIT_SYSTEM, "", format, arguments, "");
    va_end(arguments);
    return false;
}

bool error_unsupported(struct error *err, const char *format, ...)
{
    va_list arguments;
    if (err->status != EXIT_AGREED)
        return false;
    va_start(arguments, format);
    fail(err, EXIT_SYSTEM, "", format, arguments, "");
    va_end(arguments);
    err->unsupported = true;
    return false;
}

bool error_system(struct error *err, const char *format, ...)
{
    char ending[256] = "";
    int cause = errno;
    va_list arguments;
    if (cause != 0)
        snprintf(ending, sizeof ending, ": %s", strerror(cause));
    va_start(arguments, format);
    fail(err, EXIT_SYSTEM, "", format, arguments, ending);
    va_end(arguments);
    return false;
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

bool error_cause(struct error *err, struct place place, int cause, const char *format, ...)
{
    char prefix[PLACE_SIZE], ending[256];
    va_list arguments;
    write_place(place, prefix);
    snprintf(ending, sizeof ending, ": %s", strerror(cause));
    va_start(arguments, format);
    fail(err, is_of_path(cause) ? EXIT_INPUT : EXIT_SYSTEM, prefix, format, arguments, ending);
    va_end(arguments);
    return false;
}

bool error_unread(struct error *err)
{
    if (err->status == EXIT_AGREED)
        err->status = EXIT_SYSTEM;
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
