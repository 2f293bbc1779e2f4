/* SPDX-License-Identifier: MIT */
/* Reads whole files, and writes files that appear whole or not at all: a long rendering must never
 * leave half a stack, or destroy an older one. The program installs no signal handlers, so that no
 * system call is interrupted. */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/base/base.h"

/* ---- compiled-in files ---- */

static const char builtin_prefix[] = "builtin:";

bool path_is_builtin(const char *path)
{
    return strncmp(path, builtin_prefix, strlen(builtin_prefix)) == 0;
}

static int compare_builtin(const void *name, const void *file)
{
    return strcmp(name, ((const struct builtin_file *)file)->name);
}

/* Finds the file of a path that starts with the prefix. NULL: there is no such file. */
static const struct builtin_file *builtin_find(const char *path)
{
    return bsearch(path + strlen(builtin_prefix), builtin_files, builtin_file_count,
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

/* Removes "./" and "a/../" in place. The folder above the root is the root. */
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
    const bool whole = base == NULL || name[0] == '/' || path_is_builtin(name);
    const char *slash = whole ? NULL : strrchr(base, '/');
    size_t folder = 0;
    char *path;
    if (slash != NULL)
        folder = (size_t)(slash + 1 - base);
    else if (!whole && path_is_builtin(base))
        folder = strlen(builtin_prefix);
    path = malloc(folder + strlen(name) + 1);
    if (path == NULL)
        return NULL;
    sprintf(path, "%.*s%s", (int)folder, folder > 0 ? base : "", name);
    if (path_is_builtin(path))
        fold(path + strlen(builtin_prefix));
    return path;
}

bool file_is_missing(const char *path)
{
    return !path_is_builtin(path) && access(path, F_OK) != 0 && errno == ENOENT;
}

/* ---- reading ---- */

/* Lines and columns are counted in int: a message could not name a place in a longer file. */
static const size_t longest_read = INT_MAX;

static bool refuse_read(struct error *err, struct place from, const char *path, const char *why)
{
    return error_at(err, from, "cannot read %s: %s", path, why);
}

/* Opens a file that is no folder. Returns its descriptor; -1: it is refused. */
static int open_readable(const char *path, struct place from, int flags, struct stat *status,
                         struct error *err)
{
    const int descriptor = open(path, O_RDONLY | O_CLOEXEC | flags);
    if (descriptor < 0 || fstat(descriptor, status) != 0)
        refuse_read(err, from, path, strerror(errno));
    else if (S_ISDIR(status->st_mode))
        refuse_read(err, from, path, "it is a folder");
    else
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
        char *zero, *more = realloc(of->bytes, capacity);
        if (more == NULL)
            return error_memory(err);
        of->bytes = more;
        got = read(descriptor, more + of->length, capacity - 1 - of->length);
        if (got < 0)
            return refuse_reading(err, of, strerror(errno));
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

static bool read_path(struct reading *of, struct error *err)
{
    struct stat status;
    const int descriptor = open_readable(of->path, of->from, 0, &status, err);
    if (descriptor < 0)
        return false;
    const off_t size = S_ISREG(status.st_mode) ? status.st_size : 0;
    /* One byte is for the NUL, and one for the read that finds the end. */
    const bool done = size > (off_t)longest_read
                          ? refuse_reading(err, of, "it is too long for a text file")
                          : read_open(of, descriptor, size > 0 ? (size_t)size + 2 : 1 << 16, err);
    close(descriptor);
    return done;
}

static bool read_builtin(struct reading *of, struct error *err)
{
    const struct builtin_file *file = builtin_find(of->path);
    if (file == NULL)
        return refuse_reading(err, of, "there is no such built-in file");
    of->bytes = calloc(file->length + 1, 1);
    if (of->bytes == NULL)
        return error_memory(err);
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
    return end_reading(&of, read_open(&of, STDIN_FILENO, 1 << 16, err), bytes, length);
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

/* ---- writing ---- */

/* Reports a path that cannot be written as bad input, and any other failure as the system's. A
 * closed pipe gets no message. */
static bool write_fault(struct error *err, const char *path)
{
    int cause = errno;
    bool first = err->status == EXIT_AGREED;
    if (cause == EPIPE)
        return error_unread(err);
    error_system(err, "cannot write %s", output_is_standard(path) ? "to standard output" : path);
    if (first && (cause == ENOENT || cause == ENOTDIR || cause == EISDIR || cause == EACCES ||
                  cause == EPERM || cause == ENAMETOOLONG || cause == ELOOP))
        err->status = EXIT_INPUT;
    return false;
}

/* These are held back while a temporary file exists: their default action would leave it behind. */
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
        /* Under nohup a blocked SIGHUP is pending although it would be ignored. */
        struct sigaction action;
        if (sigismember(&pending, held_signals[i]) == 1 &&
            sigaction(held_signals[i], NULL, &action) == 0 && action.sa_handler != SIG_IGN)
            return true;
    }
    return false;
}

/* Creates .NAME.PID.N.tmp beside the path. N is the first number that is free: an earlier process
 * of the same PID may have left a file. NAME is cut, so that the name stays below NAME_MAX. */
static bool create_temporary(struct output *out, const char *path, mode_t mode)
{
    const char *slash = strrchr(path, '/'), *name = slash != NULL ? slash + 1 : path;
    const size_t capacity = strlen(path) + 64;
    out->temporary = malloc(capacity);
    if (out->temporary == NULL)
        return false;
    for (int attempt = 0; attempt < 10000; attempt++) {
        snprintf(out->temporary, capacity, "%.*s.%.200s.%ld.%d.tmp", (int)(name - path), path, name,
                 (long)getpid(), attempt);
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

/* Opens a device, a pipe or standard output: its temporary file is created in the folder for
 * temporary files. */
static bool open_copied(struct output *out, const char *path, struct error *err)
{
    const char *folder = getenv("TMPDIR");
    char beside[PATH_MAX];
    if (folder == NULL || folder[0] == '\0')
        folder = "/tmp";
    snprintf(beside, sizeof beside, "%s/spectral", folder);
    out->copied = true;
    out->path = strdup(path);
    if (out->path == NULL)
        return error_memory(err);
    return create_temporary(out, beside, 0600) ||
           error_system(err, "cannot create a temporary file in %s", folder);
}

/* Opens a regular file, or a name that is free (`existing` is NULL). Sets the mode of the replaced
 * file again, since the umask may have removed bits of it. */
static bool open_beside(struct output *out, const char *path, const struct stat *existing,
                        struct error *err)
{
    const mode_t mode = existing != NULL ? existing->st_mode & 0777 : 0666;
    out->path = existing != NULL ? realpath(path, NULL) : strdup(path);
    return (out->path != NULL && create_temporary(out, out->path, mode) &&
            (existing == NULL || fchmod(out->descriptor, mode) == 0)) ||
           write_fault(err, path);
}

static bool open_target(struct output *out, const char *path, struct error *err)
{
    struct stat status;
    size_t length = strlen(path);
    if (output_is_standard(path))
        return open_copied(out, path, err);
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
    if (length == 0 || path[length - 1] == '/' || path_is_builtin(path))
        return error_usage(err, "cannot write '%s': it names no file", path);
    if (lstat(path, &status) == 0)
        return error_usage(err, "cannot write %s: it is a link to a missing file", path);
    return open_beside(out, path, NULL, err);
}

static bool open_output(struct output *out, const char *path, struct error *err)
{
    *out = (struct output){.descriptor = -1};
    out->held = signals_hold();
    if (out->held == NULL)
        return error_memory(err);
    if (open_target(out, path, err))
        return true;
    output_discard(out);
    return false;
}

/* Returns whether the output is a terminal. Opens no pipe, which would wait for its reader. */
static bool is_terminal(const char *path)
{
    struct stat status;
    if (output_is_standard(path))
        return isatty(STDOUT_FILENO);
    if (stat(path, &status) != 0 || !S_ISCHR(status.st_mode))
        return false;
    const int descriptor = open(path, O_WRONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    const bool found = descriptor >= 0 && isatty(descriptor);
    if (descriptor >= 0)
        close(descriptor);
    return found;
}

bool output_open(struct output *out, const char *path, struct error *err)
{
    *out = (struct output){.descriptor = -1};
    return is_terminal(path)
               ? error_usage(
                     err, "%s is a terminal, and a picture is no text; expected a file or a pipe",
                     output_is_standard(path) ? "standard output" : path)
               : open_output(out, path, err);
}

bool output_can_open(const char *path, struct error *err)
{
    struct output probe = {.path = NULL};
    bool able = !path || output_is_standard(path) || open_output(&probe, path, err);
    output_discard(&probe);
    return able;
}

bool write_all(int descriptor, const void *bytes, size_t length)
{
    const char *at = bytes;
    while (length > 0) {
        const ssize_t done = write(descriptor, at, length);
        if (done < 0)
            return false;
        at += done;
        length -= (size_t)done;
    }
    return true;
}

/* Some file systems cannot sync, and return EINVAL: that is no failure. */
static bool sync_descriptor(int descriptor)
{
    return fsync(descriptor) == 0 || errno == EINVAL;
}

/* Syncs the folder, so that the new name outlives a crash. A folder that may be written but not
 * read cannot be synced. */
static bool sync_folder(const char *path)
{
    char *folder = file_relative(path, ".");
    const int descriptor = folder != NULL ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    const bool done = descriptor >= 0 ? sync_descriptor(descriptor) : errno == EACCES;
    free(folder);
    if (descriptor >= 0)
        close(descriptor);
    return done;
}

static bool commit_rename(struct output *out, struct error *err)
{
    bool done = sync_descriptor(out->descriptor);
    done = close(out->descriptor) == 0 && done;
    out->descriptor = -1;
    if (!done || rename(out->temporary, out->path) != 0)
        return write_fault(err, out->path);
    free(out->temporary);
    out->temporary = NULL;
    return sync_folder(out->path) ||
           error_system(err, "wrote %s, but cannot sync its folder", out->path);
}

static bool copy_bytes(int from, int to)
{
    char buffer[1 << 16];
    ssize_t got = lseek(from, 0, SEEK_SET) == 0 ? 1 : -1;
    while (got > 0) {
        got = read(from, buffer, sizeof buffer);
        if (got > 0 && !write_all(to, buffer, (size_t)got))
            return false;
    }
    return got == 0;
}

static void drop_temporary(struct output *out)
{
    if (out->temporary != NULL)
        unlink(out->temporary);
    free(out->temporary);
    out->temporary = NULL;
}

/* Removes the name of the temporary file before signals are released: a signal may end the program
 * while it waits for the reader of a pipe, and then no file stays behind. */
static bool commit_copy(struct output *out, struct error *err)
{
    int target;
    bool done;
    drop_temporary(out);
    signals_release(out->held);
    out->held = NULL;
    target =
        output_is_standard(out->path) ? dup(STDOUT_FILENO) : open(out->path, O_WRONLY | O_CLOEXEC);
    done = target >= 0 && copy_bytes(out->descriptor, target);
    done = (target < 0 || close(target) == 0) && done;
    return done || write_fault(err, out->path);
}

bool output_commit(struct output *out, struct error *err)
{
    const bool done = out->copied ? commit_copy(out, err) : commit_rename(out, err);
    output_discard(out);
    return done;
}

void output_discard(struct output *out)
{
    if (out->path != NULL && out->descriptor >= 0)
        close(out->descriptor);
    drop_temporary(out);
    free(out->path);
    signals_release(out->held);
    *out = (struct output){0};
}

bool output_is_unread(void)
{
    struct pollfd output = {.fd = STDOUT_FILENO};
    return poll(&output, 1, 0) == 1 && (output.revents & POLLERR);
}

bool file_write(const char *path, const char *bytes, size_t length, struct error *err)
{
    struct output output;
    if (output_is_standard(path)) {
        errno = 0;
        return (fwrite(bytes, 1, length, stdout) == length && fflush(stdout) == 0) ||
               output_is_unread() || error_system(err, "cannot write to standard output");
    }
    if (!open_output(&output, path, err))
        return false;
    if (!write_all(output.descriptor, bytes, length)) {
        write_fault(err, path);
        output_discard(&output);
        return false;
    }
    return output_commit(&output, err);
}
