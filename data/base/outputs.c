/* SPDX-License-Identifier: MIT */
/* Default names of the files that a command writes, and checks of these names before the work
 * begins. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "data/base/base.h"

char *output_name(const char *path, const char *ending)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    size_t length = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    size_t capacity = length + strlen(ending) + 1;
    char *out = malloc(capacity);
    if (out)
        snprintf(out, capacity, "%.*s%s", (int)length, name, ending);
    return out;
}

bool file_is_regular(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

bool file_is_same(const char *a, const char *b)
{
    struct stat one, other;
    return strcmp(a, b) == 0 || (stat(a, &one) == 0 && stat(b, &other) == 0 &&
                                 one.st_dev == other.st_dev && one.st_ino == other.st_ino);
}

bool output_spares(const char *output, const char *input, struct error *err)
{
    return !output || !input || !file_is_regular(input) || !file_is_same(output, input) ||
           error_usage(err, "%s would replace the input; expected another file", output);
}

bool output_can_open(const char *path, struct error *err)
{
    struct output probe = {.path = NULL};
    bool able = !path || strcmp(path, "-") == 0 || output_open(&probe, path, err);
    output_discard(&probe);
    return able;
}
