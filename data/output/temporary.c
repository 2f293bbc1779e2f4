/* SPDX-License-Identifier: MIT */
/* Files that are being written. Linux keeps a file without a name (O_TMPFILE), which vanishes with
 * its process. File systems that cannot do so get a temporary name, and a lock by which a later run
 * sees whether the file's process still lives. */
#define _GNU_SOURCE /* O_TMPFILE */
#include <ctype.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/output/output.h"

/* The longest name in /proc, or what a temporary name adds; the most names that are tried. */
enum { NAME_ROOM = 64, MOST_NAMES = 10000 };

/* ---- files without a name ---- */

#ifdef O_TMPFILE
static void write_link(char out[NAME_ROOM], int descriptor)
{
    snprintf(out, NAME_ROOM, "/proc/self/fd/%d", descriptor);
}

/* Without /proc such a file cannot get a name later. */
static bool create_nameless(struct output *out, const char *folder, mode_t mode)
{
    UNTIL_DONE(out->descriptor, open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, mode));
    if (out->descriptor < 0)
        return false;
    write_link(out->temporary, out->descriptor);
    if (access(out->temporary, F_OK) == 0)
        return true;
    close(out->descriptor);
    out->descriptor = -1;
    return false;
}

static bool link_nameless(int descriptor, const char *path)
{
    char name[NAME_ROOM];
    write_link(name, descriptor);
    return linkat(AT_FDCWD, name, AT_FDCWD, path, AT_SYMLINK_FOLLOW) == 0;
}
#else
static bool create_nameless(struct output *out, const char *folder, mode_t mode)
{
    (void)out;
    (void)folder;
    (void)mode;
    return false;
}

static bool link_nameless(int descriptor, const char *path)
{
    (void)descriptor;
    (void)path;
    return false;
}
#endif

/* ---- files with a temporary name ---- */

/* The lock of an open file ends with its process, on any kernel or machine that shares the folder.
 * Returns false with errno. */
static bool lock(int descriptor, int how)
{
    int got;
    UNTIL_DONE(got, flock(descriptor, how));
    return got == 0;
}

/* Writes .NAME.PID.N.tmp beside the path. NAME is cut, so that the name stays below NAME_MAX. */
static void write_name(char *out, const char *path, int attempt)
{
    const char *name = path_name(path);
    sprintf(out, "%.*s.%.200s.%ld.%d.tmp", (int)(name - path), path, name, (long)getpid(), attempt);
}

/* Returns whether this is a temporary name for the path: see write_name. */
static bool is_temporary(const char *name, const char *path)
{
    const char *own = path_name(path), *at = name + 1;
    const size_t length = strnlen(own, 200);
    if (name[0] != '.' || strncmp(at, own, length) != 0 || at[length] != '.')
        return false;
    at += length;
    for (int i = 0; i < 2; i++) {
        if (at[0] != '.' || !isdigit((unsigned char)at[1]))
            return false;
        at += 1 + strspn(at + 1, "0123456789");
    }
    return strcmp(at, ".tmp") == 0;
}

/* Removes a file that nobody holds. Follows no link, and waits for no pipe. */
static void remove_abandoned(int folder, const char *name)
{
    const int descriptor =
        openat(folder, name, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    struct stat status;
    if (descriptor < 0)
        return;
    if (fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) &&
        lock(descriptor, LOCK_EX | LOCK_NB))
        unlinkat(folder, name, 0);
    close(descriptor);
}

/* Removes what killed processes left of earlier outputs of this path. A folder that cannot be read
 * keeps it. */
static void sweep(const char *folder, const char *path)
{
    DIR *entries = opendir(folder);
    if (!entries)
        return;
    for (const struct dirent *entry; (entry = readdir(entries));)
        if (is_temporary(entry->d_name, path))
            remove_abandoned(dirfd(entries), entry->d_name);
    closedir(entries);
}

/* Opens a new file under its temporary name. Another process may sweep it before it has its lock:
 * then the next name is tried. */
static bool create_named(struct output *out, const char *path, mode_t mode)
{
    struct stat status;
    for (int attempt = 0; attempt < MOST_NAMES; attempt++) {
        write_name(out->temporary, path, attempt);
        UNTIL_DONE(out->descriptor,
                   open(out->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode));
        if (out->descriptor < 0 && errno == EEXIST)
            continue;
        if (out->descriptor < 0)
            return false;
        /* a file system without locks is swept by nobody */
        if (!lock(out->descriptor, LOCK_EX) || fstat(out->descriptor, &status) != 0 ||
            status.st_nlink > 0) {
            out->named = true;
            return true;
        }
        close(out->descriptor);
    }
    out->descriptor = -1;
    return false;
}

/* ---- both ---- */

/* The names may be as long as the path and NAME_ROOM twice: PID and N are numbers of 20 digits at
 * most. */
static bool create_in(const char *folder, struct output *out, const char *path, mode_t mode)
{
    out->temporary = malloc(strlen(path) + 2 * NAME_ROOM);
    if (!out->temporary)
        return false;
    if (create_nameless(out, folder, mode))
        return true;
    sweep(folder, path);
    if (create_named(out, path, mode))
        return true;
    free(out->temporary);
    out->temporary = NULL;
    return false;
}

bool temporary_create(struct output *out, const char *path, mode_t mode)
{
    char *folder = file_relative(path, ".");
    const bool done = folder && create_in(folder, out, path, mode);
    const int cause = errno;
    free(folder);
    errno = cause;
    return done;
}

/* Gives a file without a name a temporary one, by which it can replace another file. */
static bool name_temporarily(struct output *out, const char *path)
{
    char *folder = file_relative(path, ".");
    if (folder)
        sweep(folder, path);
    free(folder);
    lock(out->descriptor, LOCK_EX);
    for (int attempt = 0; attempt < MOST_NAMES && !out->named; attempt++) {
        write_name(out->temporary, path, attempt);
        out->named = link_nameless(out->descriptor, out->temporary);
        if (!out->named && errno != EEXIST)
            return false;
    }
    return out->named;
}

bool temporary_name(struct output *out, const char *path)
{
    if (!out->named && link_nameless(out->descriptor, path))
        return true;
    if (!out->named && (errno != EEXIST || !name_temporarily(out, path)))
        return false;
    if (rename(out->temporary, path) != 0)
        return false;
    out->named = false;
    return true;
}

void temporary_remove(struct output *out)
{
    const int cause = errno;
    if (out->temporary && out->named)
        unlink(out->temporary);
    free(out->temporary);
    out->temporary = NULL;
    out->named = false;
    errno = cause;
}
