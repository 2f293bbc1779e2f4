/* SPDX-License-Identifier: MIT */
/* Finds the parts of a stack. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster/parts/parts.h"

/* Reads ".3-of-7.part" behind the stack's name. */
static bool read_name(const char *name, const char *stack, struct picture_part *out)
{
    const size_t length = strlen(stack);
    int end = 0;
    return strncmp(name, stack, length) == 0 &&
           sscanf(name + length, ".%6d-of-%6d.part%n", &out->number, &out->count, &end) == 2 &&
           end > 0 && name[length + (size_t)end] == '\0' && out->number >= 1 &&
           out->number <= out->count && out->count <= MOST_PARTS;
}

/* Finds how many parts the files beside a stack are of; 0: there are none. Refuses two numbers. */
static bool find_count(const char *stack, int *out, struct error *err)
{
    const char *name = path_name(stack);
    char *folder = file_relative(stack, ".");
    DIR *entries = folder ? opendir(folder) : NULL;
    bool done = folder || error_memory(err);
    if (done && !entries)
        done = error_usage(err, "%s: its folder cannot be read", stack);
    *out = 0;
    for (const struct dirent *entry; done && entries && (entry = readdir(entries));) {
        struct picture_part part;
        if (!read_name(entry->d_name, name, &part))
            continue;
        if (*out != 0 && *out != part.count)
            done = error_usage(err, "%s: there are parts of %d and of %d; remove those of one kind",
                               stack, *out < part.count ? *out : part.count,
                               *out < part.count ? part.count : *out);
        *out = part.count;
    }
    if (entries)
        closedir(entries);
    free(folder);
    return done;
}

/* Opens a part, which must record the same facts as the first one. */
static bool open_part(const char *stack, struct parts *parts, int i, struct error *err)
{
    const struct picture_part part = {i + 1, parts->n};
    char *path = part_name(stack, &part), one[FACT_LINE], other[FACT_LINE];
    bool done = path || error_memory(err);
    if (done && file_is_missing(path))
        done = error_usage(err, "%s: part %d of %d is missing; expected %s", stack, i + 1, parts->n,
                           path);
    done = done && part_open(path, &part, &parts->list[i], err);
    if (done && facts_differ(parts->list[0].text, parts->list[i].text, one, other))
        done =
            error_usage(err, "%s: part 1 has '%s', but part %d has '%s'", stack, one, i + 1, other);
    free(path);
    return done;
}

bool parts_find(const char *stack, struct parts *out, struct error *err)
{
    int n;
    *out = (struct parts){.list = NULL};
    if (!find_count(stack, &n, err))
        return false;
    if (n == 0)
        return error_usage(err, "%s: there are no parts of it, as %s.1-of-2.part", stack,
                           path_name(stack));
    out->list = calloc((size_t)n, sizeof *out->list);
    if (!out->list)
        return error_memory(err);
    out->n = n;
    for (int i = 0; i < n; i++)
        if (!open_part(stack, out, i, err))
            return false;
    return true;
}

void parts_free(struct parts *parts)
{
    for (int i = 0; i < parts->n; i++)
        part_close(&parts->list[i]);
    free(parts->list);
    *parts = (struct parts){.list = NULL};
}
