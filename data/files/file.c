/* SPDX-License-Identifier: MIT */
/* Reads whole files, from disk or compiled in. Reads and writes go on after a signal. */
#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/files/files.h"

/* ---- compiled-in files ---- */

static int compare_builtin(const void *name, const void *file)
{
    return strcmp(name, ((const struct builtin_file *)file)->name);
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

const char standard_input[] = "<stdin>";

/* Lines and columns are counted in int: a message could not name a place in a longer file. */
static const size_t longest_read = INT_MAX;

static bool refuse_read(struct error *err, struct place from, const char *path, const char *why)
{
    return error_at(err, from, "cannot read %s: %s", path, why);
}

/* Opens a file that is no folder, and looks at it. Returns its descriptor; -1: it is refused. */
static int open_readable(const char *path, struct place from, int flags, struct stat *status,
                         struct error *err)
{
    int descriptor, got = 0;
    UNTIL_DONE(descriptor, open(path, O_RDONLY | O_CLOEXEC | flags));
    if (descriptor >= 0)
        UNTIL_DONE(got, fstat(descriptor, status));
    if (descriptor < 0 || got < 0)
        error_cause(err, from, "cannot read %s", path);
    else if (S_ISDIR(status->st_mode))
        refuse_read(err, from, path, "it is a folder");
    else if (file_note_read(descriptor, err))
        return descriptor;
    if (descriptor >= 0)
        close(descriptor);
    return -1;
}

/* Names the format of a file that has a NUL among its first bytes. */
static bool refuse_binary(const char *path, const char *bytes, size_t zero, size_t length,
                          struct error *err)
{
    const char *format = format_of(bytes, length);
    const struct place whole = {path, 0, 0};
    const bool without_mark =
        length > 3 && zero < 2 && bytes[zero + 1] != '\0' && bytes[zero + 2] == '\0';
    if (strcmp(format, "UTF-16") == 0 || (format[0] == '\0' && without_mark))
        return error_at(err, whole, "the text is UTF-16; save it as UTF-8");
    return error_at(err, whole, "byte %zu is NUL, so this is no text file%s%s", zero + 1,
                    format[0] != '\0' ? "; it looks like " : "", format);
}

/* Instruments fill the ends of lines with NUL bytes. They become blanks. Returns the first other
 * NUL before `end`; NULL: there is none. */
static char *fill_lines(char *at, char *end)
{
    while ((at = memchr(at, '\0', (size_t)(end - at)))) {
        char *line = memchr(at, '\n', (size_t)(end - at)), *to = at;
        while (line && to < line && (*to == '\0' || *to == '\r'))
            to++;
        if (!line || to < line)
            return at;
        memset(at, ' ', (size_t)(line - at));
    }
    return NULL;
}

/* Reads to the end. Looks for NUL bytes while it reads, so that /dev/zero ends at once. Keeps room
 * for a NUL at the end. */
static bool read_open(const char *path, struct place from, int descriptor, size_t capacity,
                      char **bytes, struct error *err)
{
    size_t length = 0;
    for (ssize_t got = 1; got != 0;) {
        if (!memory_resize(bytes, capacity, 1))
            return memory_lacks(err, (double)capacity, "the text of %s", path);
        char *more = *bytes + length;
        UNTIL_DONE(got, read(descriptor, more, capacity - 1 - length));
        if (got < 0)
            return error_cause(err, from, "cannot read %s", path);
        const char *zero = fill_lines(more, more + got);
        if (zero != NULL)
            return refuse_binary(path, *bytes, (size_t)(zero - *bytes), length + (size_t)got, err);
        length += (size_t)got;
        if (length > longest_read)
            return refuse_read(err, from, path, "it is too long for a text file");
        if (length + 1 == capacity)
            capacity += capacity / 2;
    }
    (*bytes)[length] = '\0';
    return true;
}

/* The command line may name a pipe, which the shell has opened: a file may not. The place of an
 * option's value begins with its dashes. */
static bool read_path(const char *path, struct place from, char **bytes, struct error *err)
{
    struct stat status;
    const bool named = from.path != NULL && from.path[0] != '-';
    const int descriptor = open_readable(path, from, named ? O_NONBLOCK : 0, &status, err);
    if (descriptor < 0)
        return false;
    const off_t size = S_ISREG(status.st_mode) ? status.st_size : 0;
    /* One byte is for the NUL, and one for the read that finds the end. */
    const bool done =
        named && !S_ISREG(status.st_mode) ? refuse_read(err, from, path, "it is no regular file")
        : size > (off_t)longest_read
            ? refuse_read(err, from, path, "it is too long for a text file")
        : !memory_suffices((double)size, from, err, "the text of %s", path)
            ? false
            : read_open(path, from, descriptor, size > 0 ? (size_t)size + 2 : 1 << 16, bytes, err);
    close(descriptor);
    return done;
}

/* Finds the built-in file of a path, or refuses it. */
static bool find_builtin(const char *path, struct place from, const struct builtin_file **out,
                         struct error *err)
{
    *out = bsearch(path + strlen(BUILTIN_PREFIX), builtin_files, builtin_file_count,
                   sizeof builtin_files[0], compare_builtin);
    return *out != NULL || refuse_read(err, from, path, "there is no such built-in file");
}

static bool read_builtin(const char *path, struct place from, char **bytes, struct error *err)
{
    const struct builtin_file *file;
    if (!find_builtin(path, from, &file, err) ||
        !MAKE_ARRAY(*bytes, file->length + 1, err, "the text of %s", path))
        return false;
    memcpy(*bytes, file->bytes, file->length);
    return true;
}

char *file_read(const char *path, struct place from, struct error *err)
{
    char *bytes = NULL;
    const bool done = path == standard_input
                          ? file_note_read(STDIN_FILENO, err) &&
                                read_open(path, from, STDIN_FILENO, 1 << 16, &bytes, err)
                      : path_is_builtin(path) ? read_builtin(path, from, &bytes, err)
                                              : read_path(path, from, &bytes, err);
    if (done)
        return bytes;
    free(bytes);
    return NULL;
}

bool file_open(const char *path, struct place from, int *descriptor,
               const struct builtin_file **builtin, struct error *err)
{
    struct stat status;
    *descriptor = -1;
    *builtin = NULL;
    if (path_is_builtin(path))
        return find_builtin(path, from, builtin, err);
    *descriptor = open_readable(path, from, O_NONBLOCK, &status, err); /* waits for no pipe */
    if (*descriptor < 0 || S_ISREG(status.st_mode))
        return *descriptor >= 0;
    close(*descriptor);
    *descriptor = -1;
    return refuse_read(err, from, path, "it is no regular file");
}
