/* SPDX-License-Identifier: MIT */
/* Reads whole files, from disk or compiled in. Reads and writes go on after a signal. */
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/files/files.h"

/* ---- compiled-in files ---- */

static int compare_builtin(const void *name, const void *file)
{
    return strcmp(name, ((const struct builtin_file *)file)->name);
}

/* Finds the file of a path that starts with the prefix. NULL: there is no such file. */
static const struct builtin_file *builtin_find(const char *path)
{
    return bsearch(path + strlen(BUILTIN_PREFIX), builtin_files, builtin_file_count,
                   sizeof builtin_files[0], compare_builtin);
}

bool builtin_name(const struct builtin_file *file, const char *folder, const char *ending,
                  char out[BUILTIN_NAME])
{
    const size_t before = strlen(folder), after = strlen(ending), length = strlen(file->name);
    if (length <= before + after || strncmp(file->name, folder, before) != 0 ||
        strcmp(file->name + length - after, ending) != 0)
        return false;
    snprintf(out, BUILTIN_NAME, "%.*s", (int)(length - before - after), file->name + before);
    return true;
}

/* ---- reading ---- */

/* Lines and columns are counted in int: a message could not name a place in a longer file. */
static const size_t longest_read = INT_MAX;

static bool refuse_read(struct error *err, struct place from, const char *path, const char *why)
{
    return error_at(err, from, "cannot read %s: %s", path, why);
}

/* Reports a failed call by errno. */
static bool fail_read(struct error *err, struct place from, const char *path)
{
    return error_cause(err, from, errno, "cannot read %s", path);
}

/* Opens a file, and looks at it. Returns -1 on failure. */
static int open_file(const char *path, int flags, struct stat *status)
{
    int descriptor, got;
    UNTIL_DONE(descriptor, open(path, O_RDONLY | O_CLOEXEC | flags));
    if (descriptor < 0)
        return -1;
    UNTIL_DONE(got, fstat(descriptor, status));
    if (got == 0)
        return descriptor;
    close(descriptor);
    return -1;
}

/* Opens a file that is no folder. Returns its descriptor; -1: it is refused. */
static int open_readable(const char *path, struct place from, int flags, struct stat *status,
                         struct error *err)
{
    const int descriptor = open_file(path, flags, status);
    if (descriptor < 0)
        fail_read(err, from, path);
    else if (S_ISDIR(status->st_mode))
        refuse_read(err, from, path, "it is a folder");
    else if (file_note_read(descriptor, err))
        return descriptor;
    if (descriptor >= 0)
        close(descriptor);
    return -1;
}

/* A file being read: its name, the place that names it, and its bytes so far. */
struct reading {
    const char *path;
    struct place from;
    char *bytes; /* owned */
    size_t length;
};

static bool refuse_reading(struct error *err, const struct reading *of, const char *why)
{
    return refuse_read(err, of->from, of->path, why);
}

/* Reads to the end. Looks for NUL bytes while it reads, so that /dev/zero ends at once. Keeps room
 * for a NUL at the end. */
static bool read_open(struct reading *of, int descriptor, size_t capacity, struct error *err)
{
    for (ssize_t got = 1; got != 0;) {
        if (!memory_resize(&of->bytes, capacity, 1))
            return memory_lacks(err, (double)capacity, "the text of %s", of->path);
        char *zero, *more = of->bytes;
        UNTIL_DONE(got, read(descriptor, more + of->length, capacity - 1 - of->length));
        if (got < 0)
            return fail_read(err, of->from, of->path);
        zero = memchr(more + of->length, '\0', (size_t)got);
        if (zero != NULL)
            return error_at(err, (struct place){of->path, 0, 0},
                            "byte %zu is NUL, so this is no text file", (size_t)(zero - more) + 1);
        of->length += (size_t)got;
        if (of->length > longest_read)
            return refuse_reading(err, of, "it is too long for a text file");
        if (of->length + 1 == capacity)
            capacity += capacity / 2;
    }
    of->bytes[of->length] = '\0';
    return true;
}

/* The command line may name a pipe, which the shell has opened: a file may not. The place of an
 * option's value begins with its dashes. */
static bool read_path(struct reading *of, struct error *err)
{
    struct stat status;
    const bool named = of->from.path != NULL && of->from.path[0] != '-';
    const int descriptor = open_readable(of->path, of->from, named ? O_NONBLOCK : 0, &status, err);
    if (descriptor < 0)
        return false;
    const off_t size = S_ISREG(status.st_mode) ? status.st_size : 0;
    /* One byte is for the NUL, and one for the read that finds the end. */
    const bool done =
        named && !S_ISREG(status.st_mode) ? refuse_reading(err, of, "it is no regular file")
        : size > (off_t)longest_read ? refuse_reading(err, of, "it is too long for a text file")
        : !memory_suffices((double)size, of->from, err, "the text of %s", of->path)
            ? false
            : read_open(of, descriptor, size > 0 ? (size_t)size + 2 : 1 << 16, err);
    close(descriptor);
    return done;
}

static bool read_builtin(struct reading *of, struct error *err)
{
    const struct builtin_file *file = builtin_find(of->path);
    if (file == NULL)
        return refuse_reading(err, of, "there is no such built-in file");
    if (!MAKE_ARRAY(of->bytes, file->length + 1, err, "the text of %s", of->path))
        return false;
    memcpy(of->bytes, file->bytes, file->length);
    of->length = file->length;
    return true;
}

/* Hands the bytes over, or frees those of a failure. */
static bool end_reading(struct reading *of, bool done, char **bytes, size_t *length)
{
    if (!done)
        free(of->bytes);
    *bytes = done ? of->bytes : NULL;
    *length = done ? of->length : 0;
    return done;
}

bool file_read(const char *path, struct place from, char **bytes, size_t *length, struct error *err)
{
    struct reading of = {.path = path, .from = from};
    const bool done = path_is_builtin(path) ? read_builtin(&of, err) : read_path(&of, err);
    return end_reading(&of, done, bytes, length);
}

bool input_read(const char *name, char **bytes, size_t *length, struct error *err)
{
    struct reading of = {.path = name};
    const bool done =
        file_note_read(STDIN_FILENO, err) && read_open(&of, STDIN_FILENO, 1 << 16, err);
    return end_reading(&of, done, bytes, length);
}

bool file_open(const char *path, struct place from, int *descriptor,
               const struct builtin_file **builtin, struct error *err)
{
    struct stat status;
    *descriptor = -1;
    *builtin = path_is_builtin(path) ? builtin_find(path) : NULL;
    if (path_is_builtin(path))
        return *builtin != NULL || refuse_read(err, from, path, "there is no such built-in file");
    const int opened =
        open_readable(path, from, O_NONBLOCK, &status, err); /* does not wait for a pipe */
    if (opened >= 0 && !S_ISREG(status.st_mode)) {
        refuse_read(err, from, path, "it is no regular file");
        close(opened);
    } else {
        *descriptor = opened;
    }
    return *descriptor >= 0;
}
