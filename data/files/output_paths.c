/* SPDX-License-Identifier: MIT */
/* Default names of the files that a command writes, and checks of these names before the work
 * begins. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "data/files/files.h"

char *output_name(const char *path, const char *ending, struct error *err)
{
    const char *name = path_name(path), *dot = strrchr(name, '.');
    size_t length = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    struct printed printed = {.text = NULL};
    print(&printed, "%.*s%s", (int)length, name, ending);
    return printed_take(&printed, err);
}

/* Writes "A, B or C" into out, as far as it has room. */
static void list_endings(const char *const *endings, char *out, size_t capacity)
{
    size_t used = 0;
    *out = '\0';
    for (int i = 0; endings[i] && used < capacity; i++) {
        const char *before = i == 0 ? "" : endings[i + 1] ? ", " : " or ";
        used += (size_t)snprintf(out + used, capacity - used, "%s%s", before, endings[i]);
    }
}

bool output_ending(const char *path, const char *const *endings, int *out, struct error *err)
{
    const char *name = path_name(path), *dot = strrchr(name, '.');
    char list[128];
    *out = -1;
    if (!dot || dot == name || !dot[1])
        return true;
    for (int i = 0; endings[i]; i++)
        if (strcasecmp(dot, endings[i]) == 0) {
            *out = i;
            return true;
        }
    list_endings(endings, list, sizeof list);
    return error_at(err, (struct place){path, 0, 0}, "the ending %s is unknown; expected %s", dot,
                    list);
}

bool output_is_standard(const char *path)
{
    return strcmp(path, "-") == 0;
}

bool output_is_stream(const char *path)
{
    struct stat status;
    return output_is_standard(path) || (stat(path, &status) == 0 && !S_ISREG(status.st_mode));
}
