/* SPDX-License-Identifier: MIT */
/* Files and folders that are being written, and their room on the disk. Linux keeps a file without
 * a name (O_TMPFILE), which vanishes with its process. On a file system that cannot, the file has a
 * temporary name, which is removed when the process ends, unless the process is killed. */
#define _GNU_SOURCE /* O_TMPFILE, fallocate, memfd_create */
#include <fcntl.h>
#include <libgen.h>
#ifdef __linux__
#include <sys/mman.h>
#endif
#include <sys/stat.h>
#include <unistd.h>

#include "data/files/inside.h"

enum { MOST_NAMES = 10000 }; /* that are tried */

/* ---- files without a name ---- */

#ifndef O_TMPFILE
#define O_TMPFILE O_DIRECTORY /* no folder opens for writing: each file then has a name */
#endif

/* Without /proc such a file cannot get a name later. */
static bool create_nameless(struct output *out, const char *folder, mode_t mode)
{
    UNTIL_DONE(out->descriptor, open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, mode));
    if (out->descriptor < 0)
        return false;
    snprintf(out->temporary, sizeof out->temporary, "/proc/self/fd/%d", out->descriptor);
    if (access(out->temporary, F_OK) == 0)
        return true;
    close(out->descriptor);
    out->descriptor = -1;
    return false;
}

static bool link_nameless(int descriptor, const char *path)
{
    char name[64];
    snprintf(name, sizeof name, "/proc/self/fd/%d", descriptor);
    return linkat(AT_FDCWD, name, AT_FDCWD, path, AT_SYMLINK_FOLLOW) == 0;
}

/* ---- files with a temporary name ---- */

/* Writes .NAME.PID.N.tmp beside the path. NAME is cut, so that the name stays below NAME_MAX. */
static bool write_name(struct output *out, const char *path, int attempt)
{
    const char *name = path_name(path);
    errno = ENAMETOOLONG;
    return snprintf(out->temporary, sizeof out->temporary, "%.*s.%.200s.%ld.%d.tmp",
                    (int)(name - path), path, name, (long)getpid(),
                    attempt) < (int)sizeof out->temporary;
}

/* Gives a temporary name to the file without a name, or else to a new file. The guard knows the
 * name first, so that no moment is left in which a signal leaves the file behind. */
static bool name_temporarily(struct output *out, const char *path, mode_t mode)
{
    const bool nameless = out->descriptor >= 0;
    for (int attempt = 0; attempt < MOST_NAMES; attempt++) {
        if (!write_name(out, path, attempt) || !guard_remove(out->temporary))
            return false;
        if (!nameless)
            UNTIL_DONE(out->descriptor,
                       open(out->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode));
        out->named =
            nameless ? link_nameless(out->descriptor, out->temporary) : out->descriptor >= 0;
        if (out->named)
            return true;
        guard_forget(out->temporary);
        if (errno != EEXIST)
            return false;
    }
    return false;
}

/* ---- both ---- */

bool temporary_create(struct output *out, const char *path, mode_t mode)
{
    char *folder = file_relative(path, ".");
    const bool done =
        folder && (create_nameless(out, folder, mode) || name_temporarily(out, path, mode));
    const int cause = errno;
    if (!done)
        out->temporary[0] = '\0';
    free(folder);
    errno = cause;
    return done;
}

bool temporary_in_memory(struct output *out)
{
#ifdef MFD_CLOEXEC
    const int cause = errno;
    out->descriptor = memfd_create("spectral", MFD_CLOEXEC);
    errno = cause;
#endif
    return out->descriptor >= 0;
}

bool temporary_name(struct output *out, const char *path)
{
    if (!out->named && link_nameless(out->descriptor, path))
        return true;
    if ((!out->named && (errno != EEXIST || !name_temporarily(out, path, 0))) ||
        rename(out->temporary, path) != 0)
        return false;
    guard_forget(out->temporary);
    out->named = false;
    return true;
}

void temporary_remove(struct output *out)
{
    const int cause = errno;
    if (out->named) {
        unlink(out->temporary);
        guard_forget(out->temporary);
    }
    out->temporary[0] = '\0';
    out->named = false;
    errno = cause;
}

/* ---- room on the disk: a full disk shows before the work begins ---- */

/* C libraries make up for a file system that cannot reserve by writing every block: so this asks
 * Linux itself. */
bool output_reserve(const struct output *output, uint64_t length)
{
#ifdef __linux__
    const uint64_t large = (uint64_t)32 << 20;
    int got;
    if (length <= large)
        return true;
    UNTIL_DONE(got, fallocate(output->descriptor, 0, 0, (off_t)length));
    return got == 0 || errno == EOPNOTSUPP || errno == ENOSYS || errno == EINVAL;
#else
    (void)output, (void)length;
    return true;
#endif
}

/* ---- folders for files that nobody keeps, or that nobody keeps yet ---- */

const char *temporary_folder(void)
{
    const char *given = getenv("TMPDIR");
    return given && given[0] ? given : "/tmp";
}

/* Makes a folder whose name begins so, and ends in the six characters of mkdtemp. */
static bool make(const char *parent, const char *prefix, struct folder *out)
{
    errno = ENAMETOOLONG;
    if (snprintf(out->path, sizeof out->path, "%s/%sXXXXXX", parent, prefix) >=
            (int)sizeof out->path ||
        !mkdtemp(out->path)) {
        out->path[0] = '\0';
        return false;
    }
    do
        out->entries = opendir(out->path);
    while (!out->entries && errno == EINTR);
    return out->entries;
}

bool folder_open(struct folder *out, struct error *err)
{
    const char *parent = temporary_folder();
    *out = (struct folder){.entries = NULL};
    guard_hold();
    const bool done = make(parent, "spectral.", out) && guard_remove(out->path);
    if (!done) {
        error_system(err, "cannot make a temporary folder in %s; set TMPDIR to another", parent);
        folder_close(out);
    }
    guard_release();
    return done;
}

bool folder_open_beside(const char *path, struct folder *out, struct error *err)
{
    char below[sizeof out->path]; /* dirname changes it */
    const struct place place = {path, 0, 0};
    *out = (struct folder){.entries = NULL};
    if (output_is_standard(path))
        return error_usage(err, "standard output is no folder; expected the name of a new folder");
    if (!file_is_missing(path))
        return error_at(err, place, "this folder exists already; expected a new name");
    snprintf(below, sizeof below, "%s", path);
    if (make(dirname(below), ".spectral-unfinished.", out) && guard_remove(out->path))
        return true;
    error_cause(err, place, "cannot make the folder");
    folder_close(out);
    return false;
}

bool folder_keep(struct folder *folder, const char *path, struct error *err)
{
    const mode_t mask = umask(0);
    umask(mask);
    if (fchmod(dirfd(folder->entries), 0777 & ~mask) != 0 || rename(folder->path, path) != 0)
        return error_cause(err, (struct place){path, 0, 0}, "cannot make the folder");
    guard_forget(folder->path);
    folder->path[0] = '\0';
    folder_sync(path); /* the new name is on the disk when its own folder is */
    return true;
}

/* A folder holds no folders. */
void folder_close(struct folder *folder)
{
    if (folder->path[0] && folder->entries) {
        rewinddir(folder->entries);
        for (const struct dirent *entry; (entry = readdir(folder->entries));)
            unlinkat(dirfd(folder->entries), entry->d_name, 0);
    }
    if (folder->path[0])
        rmdir(folder->path);
    guard_forget(folder->path);
    if (folder->entries)
        closedir(folder->entries);
    *folder = (struct folder){.entries = NULL};
}
