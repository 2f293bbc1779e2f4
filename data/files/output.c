/* SPDX-License-Identifier: MIT */
/* Writes files that appear whole or not at all: a long rendering must never leave half a stack, or
 * destroy an older one. */
#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/files/inside.h"

/* ---- opening ---- */

/* The reader of a pipe that has closed it expects no message: error_cause then adds none. */
static bool write_fault(struct error *err, const char *path)
{
    if (errno == EPIPE && err->status == EXIT_AGREED)
        err->status = EXIT_SYSTEM;
    return error_cause(err, NOWHERE, "cannot write %s",
                       output_is_standard(path) ? "to standard output" : path);
}

/* Opens a device, a pipe or standard output: its temporary file is created in the folder for
 * temporary files, or in memory where that folder takes none. */
static bool open_copied(struct output *out, const char *path, struct error *err)
{
    const char *folder = temporary_folder();
    char beside[PATH_MAX];
    snprintf(beside, sizeof beside, "%s/spectral", folder);
    out->copied = true;
    out->holder = folder;
    out->path = strdup(path);
    return out->path == NULL
               ? memory_lacks(err, (double)strlen(path), "the name %s", path)
               : temporary_create(out, beside, 0600) || temporary_in_memory(out) ||
                     error_system(err,
                                  "cannot create a temporary file in %s; set TMPDIR to a folder "
                                  "that takes files",
                                  folder);
}

/* Opens a regular file, or a name that is free (`existing` is NULL). Sets the mode of the replaced
 * file again, since the umask may have removed bits of it. */
static bool open_beside(struct output *out, const char *path, const struct stat *existing,
                        struct error *err)
{
    const mode_t mode = existing != NULL ? existing->st_mode & 0777 : 0666;
    out->path = existing != NULL ? realpath(path, NULL) : strdup(path);
    out->holder = out->path;
    return (out->path != NULL && temporary_create(out, out->path, mode) &&
            (existing == NULL || fchmod(out->descriptor, mode) == 0)) ||
           write_fault(err, path);
}

/* Refuses to replace a file that this process has read. */
static bool spares_inputs(const char *path, struct error *err)
{
    return !file_was_read(path) ||
           error_usage(err, "%s would replace an input; expected another file", path);
}

static bool open_target(struct output *out, const char *path, struct error *err)
{
    struct stat status;
    size_t length = strlen(path);
    if (output_is_standard(path))
        return isatty(STDOUT_FILENO)
                   ? error_usage(err, "standard output is a terminal, and a picture is no text; "
                                      "expected a file or a pipe")
                   : open_copied(out, path, err);
    if (stat(path, &status) == 0) {
        if (S_ISDIR(status.st_mode))
            return error_usage(err, "cannot write %s: it is a folder", path);
        if (access(path, W_OK) != 0)
            return write_fault(err, path);
        return !S_ISREG(status.st_mode)
                   ? open_copied(out, path, err)
                   : spares_inputs(path, err) && open_beside(out, path, &status, err);
    }
    if (errno != ENOENT)
        return write_fault(err, path);
    if (length == 0 || path[length - 1] == '/' || path_is_builtin(path))
        return error_usage(err, "cannot write '%s': it names no file", path);
    if (lstat(path, &status) == 0)
        return error_usage(err, "cannot write %s: it is a link to a missing file", path);
    return open_beside(out, path, NULL, err);
}

bool output_open(struct output *out, const char *path, struct error *err)
{
    *out = (struct output){.descriptor = -1};
    if (open_target(out, path, err))
        return true;
    output_discard(out);
    return false;
}

bool output_can_open(const char *path, struct error *err)
{
    struct output probe = {.path = NULL};
    bool able = output_is_standard(path) || output_open(&probe, path, err);
    output_discard(&probe);
    return able;
}

/* ---- the end ---- */

/* Some file systems cannot sync, and return EINVAL: that is no failure. */
static bool sync_descriptor(int descriptor)
{
    int got;
    UNTIL_DONE(got, fsync(descriptor));
    return got == 0 || errno == EINVAL;
}

void folder_sync(const char *path)
{
    char *folder = file_relative(path, ".");
    const int descriptor = folder ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (descriptor >= 0) {
        sync_descriptor(descriptor);
        close(descriptor);
    }
    free(folder);
}

static bool copy_bytes(int from, int to)
{
    char buffer[1 << 16];
    uint64_t at = 0;
    for (;;) {
        const ssize_t got = read_at(from, buffer, sizeof buffer, at);
        if (got <= 0)
            return got == 0;
        if (!write_all(to, buffer, (size_t)got))
            return false;
        at += (uint64_t)got;
    }
}

/* Removes the name of the temporary file first: the program may be killed while it waits for the
 * reader of a pipe. */
static bool commit_copy(struct output *out, struct error *err)
{
    int target;
    temporary_remove(out);
    if (output_is_standard(out->path))
        target = dup(STDOUT_FILENO);
    else
        UNTIL_DONE(target, open(out->path, O_WRONLY | O_CLOEXEC));
    const bool done = target >= 0 && copy_bytes(out->descriptor, target);
    return ((target < 0 || close(target) == 0 || errno == EINTR) && done) ||
           write_fault(err, out->path);
}

static bool commit(struct output *out, struct error *err)
{
    const bool done = out->copied ? commit_copy(out, err)
                                  : temporary_name(out, out->path) || write_fault(err, out->path);
    if (done && !out->copied)
        folder_sync(out->path);
    output_discard(out);
    return done;
}

void output_discard(struct output *out)
{
    if (out->path && out->descriptor >= 0)
        close(out->descriptor);
    temporary_remove(out);
    free(out->path);
    *out = (struct output){0};
}

/* ---- outputs ---- */

/* Syncs at once: a file system may report a failed write as late as then, and no output may have
 * appeared. */
bool output_pass(struct output *output, struct outputs *outputs, struct error *err)
{
    const bool synced =
        output->copied || sync_descriptor(output->descriptor) || write_fault(err, output->path);
    if (synced && (!outputs || output->copied))
        return commit(output, err);
    const bool done = synced && array_add(&outputs->list, &outputs->n, output, sizeof *output, err);
    if (done)
        *output = (struct output){.path = NULL};
    else
        output_discard(output);
    return done;
}

bool outputs_readable(const struct outputs *outputs, int n, const char *path, const char **out,
                      struct error *err)
{
    *out = NULL;
    for (int i = 0; i < n; i++) {
        bool same;
        if (!file_is_same(outputs->list[i].path, path, &same, err))
            return false;
        if (same)
            *out = outputs->list[i].temporary;
    }
    return true;
}

/* Refuses two outputs of one name: the later would replace the earlier. */
bool outputs_commit(struct outputs *outputs, struct error *err)
{
    bool done = true;
    for (int i = 0; done && i < outputs->n; i++) {
        const char *path = outputs->list[i].path, *other;
        done = spares_inputs(path, err) && outputs_readable(outputs, i, path, &other, err) &&
               (!other || error_usage(err, "%s would be written twice; expected two files", path));
    }
    guard_hold();
    for (int i = 0; done && i < outputs->n; i++)
        done = commit(&outputs->list[i], err);
    outputs_discard(outputs);
    guard_release();
    return done;
}

void outputs_discard(struct outputs *outputs)
{
    for (int i = 0; i < outputs->n; i++)
        output_discard(&outputs->list[i]);
    free(outputs->list);
    *outputs = (struct outputs){.list = NULL};
}

/* ---- small files ---- */

bool file_write(const char *path, const char *bytes, size_t length, struct outputs *outputs,
                struct error *err)
{
    struct output output;
    if (output_is_standard(path))
        return write_all(STDOUT_FILENO, bytes, length) || errno == EPIPE ||
               error_system(err, "cannot write to standard output");
    if (!output_open(&output, path, err))
        return false;
    const bool done =
        (write_all(output.descriptor, bytes, length) || write_fault(err, output.holder)) &&
        output_pass(&output, outputs, err);
    output_discard(&output);
    return done;
}

bool printed_write(struct printed *printed, const char *path, struct outputs *outputs,
                   struct error *err)
{
    const size_t length = printed->length;
    char *text = printed_take(printed, err);
    const bool done = text && file_write(path, text, length, outputs, err);
    free(text);
    return done;
}
