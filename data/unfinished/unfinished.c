/* SPDX-License-Identifier: MIT */
/* A stack in progress. Processes store samples at their places. */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/unfinished/unfinished.h"

/* ---- the file ---- */

static char *name_of(const char *stack)
{
    static const char ending[] = ".unfinished";
    char *name = malloc(strlen(stack) + sizeof ending);
    if (name)
        sprintf(name, "%s%s", stack, ending);
    return name;
}

static bool open_file(const char *name, int flags, int *descriptor, uint64_t *length,
                      struct error *err)
{
    const struct place nowhere = {NULL, 0, 0};
    struct stat status;
    UNTIL_DONE(*descriptor, open(name, flags | O_CLOEXEC | O_NOCTTY, 0666));
    if (*descriptor < 0 || fstat(*descriptor, &status) != 0)
        return error_cause(err, nowhere, errno, "cannot open %s", name);
    *length = (uint64_t)status.st_size;
    return S_ISREG(status.st_mode) || error_usage(err, "%s: is no regular file", name);
}

/* Copies the directories from the file where they were laid out. Each process writes the same
 * bytes.
 */
static bool copy_head(const struct pages *pages, int to, struct error *err)
{
    char bytes[65536];
    for (uint64_t at = 0; at < pages->first;) {
        const uint64_t left = pages->first - at;
        const ssize_t got = read_at(pages->output.descriptor, bytes,
                                    left < sizeof bytes ? (size_t)left : sizeof bytes, at);
        if (got <= 0 || !write_at(to, bytes, (size_t)got, at))
            return error_system(err, "%s: cannot be written", pages->output.path);
        at += (uint64_t)got;
    }
    return true;
}

/* Makes the file as long as the stack, on a disk that has room for it. */
static bool extend(struct pages *pages, uint64_t length, struct error *err)
{
    const uint64_t end = pages_end(pages);
    int got = 0;
    if (length < end &&
        !output_fits(pages->output.descriptor, pages->output.path, end - length, err))
        return false;
    if (length < end)
        UNTIL_DONE(got, ftruncate(pages->output.descriptor, (off_t)end));
    return (got == 0 && output_reserve(&pages->output, end)) ||
           error_system(err, "%s: cannot be made so long", pages->output.path);
}

/* Opens the file, and refuses one of another length. A file may be shorter if no process has stored
 * samples. */
static bool open_unfinished(const struct pages *pages, const char *name, int flags, int *descriptor,
                            uint64_t *length, struct error *err)
{
    const struct place place = {name, 0, 0};
    const bool begun = !(flags & O_CREAT);
    if (begun && file_is_missing(name))
        return error_at(err, place,
                        "is missing, and parts say that it has samples; remove them, to "
                        "begin again");
    return open_file(name, flags, descriptor, length, err) &&
           (*length == pages_end(pages) || (*length < pages_end(pages) && !begun) ||
            error_at(err, place,
                     "is not as long as this stack; remove it and its parts, to begin "
                     "again"));
}

bool unfinished_open(struct stack_writer *writer, enum unfinished_use use, bool begun,
                     struct error *err)
{
    struct pages *pages = &writer->pages;
    const int flags = (use == UNFINISHED_SHARED ? O_WRONLY : O_RDWR) | (begun ? 0 : O_CREAT);
    char *name = name_of(pages->output.path);
    int descriptor = -1;
    uint64_t length = 0;
    if (!name)
        return error_memory(err);
    if (!open_unfinished(pages, name, flags, &descriptor, &length, err) ||
        !copy_head(pages, descriptor, err)) {
        if (descriptor >= 0)
            close(descriptor);
        free(name);
        return false;
    }
    close(pages->output.descriptor);
    free(pages->output.temporary);
    pages->output.descriptor = descriptor;
    pages->output.temporary = name;
    pages->output.named = false;
    return extend(pages, length, err);
}

bool unfinished_sync(const struct stack_writer *writer, struct error *err)
{
    return output_sync(&writer->pages.output, err);
}

void unfinished_end(struct stack_writer *writer)
{
    writer->pages.output.named = true;
}
