/* SPDX-License-Identifier: MIT */
/* Whole reads, and outputs that appear whole or not at all: a long rendering must never leave a
 * half-written stack or destroy the one that stood there before. */
#include "spectral.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- compiled-in files ---- */

static const char builtin_prefix[] = "builtin:";

static bool is_builtin(const char *path)
{
    return strncmp(path, builtin_prefix, strlen(builtin_prefix)) == 0;
}

static int compare_builtin(const void *name, const void *file)
{
    return strcmp(name, ((const struct builtin_file *)file)->name);
}

/* `path` starts with the prefix. NULL: no such file. */
static const struct builtin_file *builtin_find(const char *path)
{
    return bsearch(path + strlen(builtin_prefix), builtin_files, builtin_file_count,
                   sizeof builtin_files[0], compare_builtin);
}

bool builtin_path(const char *folder, const char *name, const char *ending, char *out,
                  size_t capacity)
{
    int length = snprintf(out, capacity, "%s%s%s%s", builtin_prefix, folder, name, ending);
    return length >= 0 && (size_t)length < capacity && builtin_find(out) != NULL;
}

/* Drops "./" and "a/../" in place; above the root there is only the root. */
static void fold(char *path)
{
    char *out = path;
    const char *in = path;
    while (*in != '\0') {
        size_t length = strcspn(in, "/");
        bool folder = in[length] == '/';
        if (folder && length == 2 && strncmp(in, "..", 2) == 0) {
            out -= out > path;
            while (out > path && out[-1] != '/')
                out--;
        } else if (!folder || length != 1 || in[0] != '.') {
            memmove(out, in, length + folder);
            out += length + folder;
        }
        in += length + folder;
    }
    *out = '\0';
}

char *file_relative(const char *base, const char *name)
{
    bool whole = base == NULL || name[0] == '/' || is_builtin(name);
    const char *slash = whole ? NULL : strrchr(base, '/');
    size_t folder = 0, length = strlen(name);
    char *path;
    if (slash != NULL)
        folder = (size_t)(slash + 1 - base);
    else if (!whole && is_builtin(base))
        folder = strlen(builtin_prefix);
    path = malloc(folder + length + 1);
    if (path == NULL)
        return NULL;
    if (folder > 0)
        memcpy(path, base, folder);
    memcpy(path + folder, name, length + 1);
    if (is_builtin(path))
        fold(path + strlen(builtin_prefix));
    return path;
}

/* ---- reading ---- */

/* A place counts lines and columns in int; a longer file could not be blamed. */
static const size_t longest_read = INT_MAX;

static bool read_fault(struct error *err, struct place from, const char *path)
{
    return error_at(err, from, "cannot read %s: %s", path, strerror(errno));
}

static bool refuse_long(struct error *err, struct place from, const char *path)
{
    return error_at(err, from, "%s is too long; text files end at %zu bytes", path, longest_read);
}

static bool grow(char **bytes, size_t *capacity)
{
    size_t larger = *capacity <= longest_read / 2 ? 2 * *capacity : longest_read + 2;
    char *grown = realloc(*bytes, larger);
    if (grown == NULL)
        return false;
    *bytes = grown;
    *capacity = larger;
    return true;
}

/* Looks for NUL bytes while it reads, so that /dev/zero ends at once. */
static bool read_open(int descriptor, size_t capacity, const char *path, struct place from,
                      char **bytes, size_t *length, struct error *err)
{
    struct place whole = {path, 0, 0};
    *bytes = malloc(capacity);
    if (*bytes == NULL)
        return error_memory(err);
    for (;;) {
        char *zero;
        ssize_t got = read(descriptor, *bytes + *length, capacity - 1 - *length);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return read_fault(err, from, path);
        if (got == 0)
            break;
        zero = memchr(*bytes + *length, '\0', (size_t)got);
        if (zero != NULL)
            return error_at(err, whole, "byte %zu is NUL, so this is no text file",
                            (size_t)(zero - *bytes) + 1);
        *length += (size_t)got;
        if (*length > longest_read)
            return refuse_long(err, from, path);
        if (*length + 1 == capacity && !grow(bytes, &capacity))
            return error_memory(err);
    }
    (*bytes)[*length] = '\0';
    return true;
}

static bool read_path(const char *path, struct place from, char **bytes, size_t *length,
                      struct error *err)
{
    size_t capacity = 1 << 16;
    struct stat status;
    bool done;
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0)
        return read_fault(err, from, path);
    if (fstat(descriptor, &status) != 0)
        done = read_fault(err, from, path);
    else if (S_ISDIR(status.st_mode))
        done = error_at(err, from, "cannot read %s: it is a folder", path);
    else if (S_ISREG(status.st_mode) && status.st_size > (off_t)longest_read)
        done = refuse_long(err, from, path);
    else {
        /* One byte for the NUL, and one so that the read that meets the end has room. */
        if (S_ISREG(status.st_mode) && status.st_size > 0)
            capacity = (size_t)status.st_size + 2;
        done = read_open(descriptor, capacity, path, from, bytes, length, err);
    }
    close(descriptor);
    return done;
}

static bool read_builtin(const char *path, struct place from, char **bytes, size_t *length,
                         struct error *err)
{
    const struct builtin_file *file = builtin_find(path);
    if (file == NULL)
        return error_at(err, from, "cannot read %s: there is no such built-in file", path);
    *bytes = malloc(file->length + 1);
    if (*bytes == NULL)
        return error_memory(err);
    memcpy(*bytes, file->bytes, file->length);
    (*bytes)[file->length] = '\0';
    *length = file->length;
    return true;
}

bool file_read(const char *path, struct place from, char **bytes, size_t *length,
               struct error *err)
{
    bool done;
    *bytes = NULL;
    *length = 0;
    done = is_builtin(path) ? read_builtin(path, from, bytes, length, err)
                            : read_path(path, from, bytes, length, err);
    if (!done) {
        free(*bytes);
        *bytes = NULL;
        *length = 0;
    }
    return done;
}

/* ---- writing ---- */

/* A path that cannot be written is bad input; a disk that cannot take the bytes is not. */
static bool write_fault(struct error *err, const char *path)
{
    int cause = errno;
    bool first = err->status == EXIT_AGREED;
    error_system(err, "cannot write %s", path);
    if (first && (cause == ENOENT || cause == ENOTDIR || cause == EISDIR || cause == EACCES ||
                  cause == EPERM || cause == ENAMETOOLONG || cause == ELOOP))
        err->status = EXIT_INPUT;
    return false;
}

/* Held back while a temporary file exists: their default action would leave it behind. */
static const int held_signals[] = {SIGINT, SIGTERM, SIGHUP};
enum { HELD_SIGNALS = sizeof held_signals / sizeof held_signals[0] };

void *signals_hold(void)
{
    sigset_t set, *before = malloc(sizeof *before);
    if (before == NULL)
        return NULL;
    sigemptyset(&set);
    for (int i = 0; i < HELD_SIGNALS; i++)
        sigaddset(&set, held_signals[i]);
    pthread_sigmask(SIG_BLOCK, &set, before);
    return before;
}

void signals_release(void *held)
{
    if (held != NULL)
        pthread_sigmask(SIG_SETMASK, held, NULL);
    free(held);
}

bool output_interrupted(void)
{
    sigset_t pending;
    sigemptyset(&pending);
    sigpending(&pending);
    for (int i = 0; i < HELD_SIGNALS; i++) {
        /* Under nohup a blocked SIGHUP waits although it would be ignored. */
        struct sigaction action;
        if (sigismember(&pending, held_signals[i]) == 1 &&
            sigaction(held_signals[i], NULL, &action) == 0 && action.sa_handler != SIG_IGN)
            return true;
    }
    return false;
}

/* Creates .NAME.PID.N.tmp in `folder` (with its slash, or empty); a leftover of an earlier process
 * with this number is stepped over. NAME is cut so that the whole stays below NAME_MAX. */
static bool create_temporary(struct output *out, const char *folder, size_t folder_length,
                             const char *name, mode_t mode)
{
    size_t capacity = folder_length + 256;
    out->temporary = malloc(capacity);
    if (out->temporary == NULL)
        return false;
    for (int attempt = 0; attempt < 10000; attempt++) {
        snprintf(out->temporary, capacity, "%.*s.%.200s.%ld.%d.tmp", (int)folder_length, folder,
                 name, (long)getpid(), attempt);
        out->descriptor = open(out->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (out->descriptor >= 0)
            return true;
        if (errno != EEXIST)
            break;
    }
    free(out->temporary);
    out->temporary = NULL;
    return false;
}

/* A device or a pipe: the temporary lies where temporary files lie. */
static bool open_copied(struct output *out, const char *path, struct error *err)
{
    const char *folder = getenv("TMPDIR");
    char *inside;
    bool created;
    if (folder == NULL || folder[0] == '\0')
        folder = "/tmp";
    out->copied = true;
    out->path = strdup(path);
    inside = malloc(strlen(folder) + 2);
    if (out->path == NULL || inside == NULL) {
        free(inside);
        return error_memory(err);
    }
    strcpy(inside, folder);
    strcat(inside, "/");
    created = create_temporary(out, inside, strlen(inside), "spectral", 0600);
    free(inside);
    return created || error_system(err, "cannot create a temporary file in %s", folder);
}

/* A regular file or a name that is still free. `existing` NULL: free. */
static bool open_beside(struct output *out, const char *path, const struct stat *existing,
                        struct error *err)
{
    mode_t mode = existing != NULL ? existing->st_mode & 0777 : 0666;
    const char *slash;
    size_t folder;
    out->path = existing != NULL ? realpath(path, NULL) : strdup(path);
    if (out->path == NULL)
        return write_fault(err, path);
    slash = strrchr(out->path, '/');
    folder = slash != NULL ? (size_t)(slash + 1 - out->path) : 0;
    if (!create_temporary(out, out->path, folder, out->path + folder, mode))
        return write_fault(err, path);
    /* The umask has taken bits that the replaced file had. */
    if (existing != NULL && fchmod(out->descriptor, mode) != 0)
        return write_fault(err, path);
    return true;
}

static bool open_target(struct output *out, const char *path, struct error *err)
{
    struct stat status;
    size_t length = strlen(path);
    if (stat(path, &status) == 0) {
        if (S_ISDIR(status.st_mode))
            return error_usage(err, "cannot write %s: it is a folder", path);
        if (access(path, W_OK) != 0)
            return write_fault(err, path);
        return S_ISREG(status.st_mode) ? open_beside(out, path, &status, err)
                                       : open_copied(out, path, err);
    }
    if (errno != ENOENT)
        return write_fault(err, path);
    if (length == 0 || path[length - 1] == '/' || is_builtin(path))
        return error_usage(err, "cannot write '%s': it names no file", path);
    if (lstat(path, &status) == 0)
        return error_usage(err, "cannot write %s: it is a link to a missing file", path);
    return open_beside(out, path, NULL, err);
}

bool output_open(struct output *out, const char *path, struct error *err)
{
    *out = (struct output){0};
    out->held = signals_hold();
    if (out->held == NULL)
        return error_memory(err);
    if (open_target(out, path, err))
        return true;
    output_discard(out);
    return false;
}

static bool write_all(int descriptor, const char *bytes, size_t length)
{
    while (length > 0) {
        ssize_t done = write(descriptor, bytes, length);
        if (done < 0 && errno == EINTR)
            continue;
        if (done < 0)
            return false;
        bytes += done;
        length -= (size_t)done;
    }
    return true;
}

/* Some file systems cannot sync and say EINVAL; there is no more to be done on them. */
static bool sync_descriptor(int descriptor)
{
    while (fsync(descriptor) != 0)
        if (errno != EINTR)
            return errno == EINVAL;
    return true;
}

/* A closed descriptor must not be closed again, and Linux closes it even on EINTR. */
static bool close_descriptor(int *descriptor)
{
    int status = close(*descriptor);
    *descriptor = -1;
    return status == 0 || errno == EINTR;
}

/* Makes the rename last. A folder that may be written but not read cannot be synced. */
static bool sync_folder(const char *path)
{
    char *folder = file_relative(path, ".");
    int descriptor;
    bool done;
    if (folder == NULL)
        return false;
    descriptor = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    free(folder);
    if (descriptor < 0)
        return errno == EACCES;
    done = sync_descriptor(descriptor);
    return close_descriptor(&descriptor) && done;
}

static bool commit_rename(struct output *out, struct error *err)
{
    if (!sync_descriptor(out->descriptor) || !close_descriptor(&out->descriptor) ||
        rename(out->temporary, out->path) != 0)
        return write_fault(err, out->path);
    free(out->temporary);
    out->temporary = NULL;
    return sync_folder(out->path) ||
           error_system(err, "wrote %s, but cannot make its folder entry last", out->path);
}

static bool copy_bytes(int from, int to)
{
    char buffer[1 << 16];
    if (lseek(from, 0, SEEK_SET) < 0)
        return false;
    for (;;) {
        ssize_t got = read(from, buffer, sizeof buffer);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return got == 0;
        if (!write_all(to, buffer, (size_t)got))
            return false;
    }
}

/* The temporary loses its name first. So nothing stays behind when a signal, free to come again,
 * ends the wait for a pipe's reader. */
static bool commit_copy(struct output *out, struct error *err)
{
    int target;
    bool done;
    unlink(out->temporary);
    free(out->temporary);
    out->temporary = NULL;
    signals_release(out->held);
    out->held = NULL;
    do
        target = open(out->path, O_WRONLY | O_CLOEXEC);
    while (target < 0 && errno == EINTR);
    done = target >= 0 && copy_bytes(out->descriptor, target);
    if (!done)
        write_fault(err, out->path);
    if (target >= 0 && !close_descriptor(&target) && done)
        done = write_fault(err, out->path);
    close_descriptor(&out->descriptor);
    return done;
}

bool output_commit(struct output *out, struct error *err)
{
    bool done = out->copied ? commit_copy(out, err) : commit_rename(out, err);
    output_discard(out);
    return done;
}

void output_discard(struct output *out)
{
    if (out->temporary != NULL) {
        if (out->descriptor >= 0)
            close_descriptor(&out->descriptor);
        unlink(out->temporary);
    }
    free(out->temporary);
    free(out->path);
    signals_release(out->held);
    out->held = NULL;
    *out = (struct output){0};
}

bool file_write(const char *path, const char *bytes, size_t length, struct error *err)
{
    struct output output;
    if (strcmp(path, "-") == 0) {
        errno = 0;
        if (fwrite(bytes, 1, length, stdout) != length || fflush(stdout) != 0)
            return error_system(err, "cannot write to standard output");
        return true;
    }
    if (!output_open(&output, path, err))
        return false;
    if (!write_all(output.descriptor, bytes, length)) {
        write_fault(err, path);
        output_discard(&output);
        return false;
    }
    return output_commit(&output, err);
}
