/* SPDX-License-Identifier: MIT */
/* Default names of the files that a command writes, and checks of these names before the work
 * begins. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "data/base/base.h"

static const char *last_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

char *output_name(const char *path, const char *ending)
{
    const char *name = last_name(path), *dot = strrchr(name, '.');
    size_t length = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    size_t capacity = length + strlen(ending) + 1;
    char *out = malloc(capacity);
    if (out)
        snprintf(out, capacity, "%.*s%s", (int)length, name, ending);
    return out;
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
    const char *name = last_name(path), *dot = strrchr(name, '.');
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

bool file_is_regular(const char *path)
{
    struct stat status;
    return !output_is_standard(path) && stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

/* Finds the folder of a path. Returns false if there is none. */
static bool stat_folder(const char *path, struct stat *out)
{
    char *folder = file_relative(path, ".");
    const bool found = folder && stat(folder, out) == 0;
    free(folder);
    return found;
}

/* Files that do not exist yet are one if they have one name in one folder. */
bool file_is_same(const char *a, const char *b)
{
    struct stat one, other;
    const bool a_is = stat(a, &one) == 0, b_is = stat(b, &other) == 0;
    if (strcmp(a, b) == 0)
        return true;
    if (a_is != b_is || (!a_is && (strcmp(last_name(a), last_name(b)) != 0 ||
                                   !stat_folder(a, &one) || !stat_folder(b, &other))))
        return false;
    return one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

bool output_spares(const char *output, const char *input, struct error *err)
{
    return !output || !input || output_is_standard(output) || !file_is_regular(input) ||
           !file_is_same(output, input) ||
           error_usage(err, "%s would replace the input; expected another file", output);
}
