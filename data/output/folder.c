/* SPDX-License-Identifier: MIT */
/* A folder for files that nobody keeps. It holds a lock as long as its process lives: a later
 * process removes the folders of those that were killed. */
#define _GNU_SOURCE /* flock */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/output/output.h"
#include "data/process/process.h"

/* Names of folders are a prefix and the six characters of mkdtemp. In a folder of the user's they
 * are hidden, and no name that anybody gives. */
static const char temporary_prefix[] = "spectral.", kept_prefix[] = ".spectral-unfinished.",
                  pattern[] = "XXXXXX";

/* Opens a folder of this user. Follows no link. Returns -1: there is none. */
static int open_own(int parent, const char *name)
{
    struct stat status;
    int folder;
    UNTIL_DONE(folder, openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (folder >= 0 && fstat(folder, &status) == 0 && status.st_uid == geteuid())
        return folder;
    if (folder >= 0)
        close(folder);
    return -1;
}

/* Removes the files in a folder, which holds no folders. */
static void empty(DIR *entries)
{
    rewinddir(entries);
    for (const struct dirent *entry; (entry = readdir(entries));)
        unlinkat(dirfd(entries), entry->d_name, 0);
}

static bool is_ours(const char *name, const char *prefix)
{
    const size_t length = strlen(prefix);
    return strncmp(name, prefix, length) == 0 && strlen(name) == length + strlen(pattern);
}

/* Opens a folder of this user by its name in another one, and locks it; NULL: another process holds
 * it, or it is none. */
static DIR *lock_folder(int parent, const char *name)
{
    const int folder = open_own(parent, name);
    DIR *entries = folder >= 0 ? fdopendir(folder) : NULL;
    int locked = 0;
    if (folder >= 0 && !entries)
        close(folder);
    if (entries)
        UNTIL_DONE(locked, flock(folder, LOCK_EX | LOCK_NB));
    /* a file system without locks is swept by nobody */
    if (locked != 0 && errno == EWOULDBLOCK) {
        closedir(entries);
        entries = NULL;
    }
    return entries;
}

/* Removes the folders of processes that were killed. */
static void sweep(const char *parent, const char *prefix)
{
    DIR *entries = opendir(parent);
    if (!entries)
        return;
    for (const struct dirent *entry; (entry = readdir(entries));) {
        DIR *folder =
            is_ours(entry->d_name, prefix) ? lock_folder(dirfd(entries), entry->d_name) : NULL;
        if (!folder)
            continue;
        empty(folder);
        unlinkat(dirfd(entries), entry->d_name, AT_REMOVEDIR);
        closedir(folder);
    }
    closedir(entries);
}

/* Another process may sweep a new folder before this one has its lock: then it makes another. */
static bool make(const char *parent, const char *prefix, struct folder *out)
{
    struct stat status;
    for (int attempt = 0; attempt < 100; attempt++) {
        char path[sizeof out->path];
        snprintf(path, sizeof path, "%s/%s%s", parent, prefix, pattern);
        if (!mkdtemp(path))
            return false;
        memcpy(out->path, path, sizeof path);
        out->entries = lock_folder(AT_FDCWD, path);
        if (out->entries && fstat(dirfd(out->entries), &status) == 0 && status.st_nlink > 0)
            return true;
        folder_close(out);
    }
    return false;
}

bool folder_open(struct folder *out, struct error *err)
{
    const char *given = getenv("TMPDIR"), *parent = given && given[0] ? given : "/tmp";
    *out = (struct folder){.entries = NULL};
    sweep(parent, temporary_prefix);
    guard_hold();
    const bool done = make(parent, temporary_prefix, out) && guard_remove(out->path);
    if (!done) {
        error_system(err, "cannot make a temporary folder in %s", parent);
        folder_close(out);
    }
    guard_release();
    return done;
}

/* Writes the folder that a path lies in. */
static void find_parent(const char *path, char out[sizeof((struct folder *)0)->path])
{
    const size_t end = strlen(path), last = end > 0 && path[end - 1] == '/' ? end - 1 : end;
    size_t n = last;
    while (n > 0 && path[n - 1] != '/')
        n--;
    snprintf(out, sizeof((struct folder *)0)->path, "%.*s", n > 0 ? (int)n : 1, n > 0 ? path : ".");
}

bool folder_open_beside(const char *path, struct folder *out, struct error *err)
{
    char parent[sizeof out->path];
    const struct place place = {path, 0, 0};
    *out = (struct folder){.entries = NULL};
    if (!file_is_missing(path))
        return error_at(err, place, "this folder exists already; expected a new name");
    find_parent(path, parent);
    sweep(parent, kept_prefix);
    errno = 0;
    if (make(parent, kept_prefix, out))
        return true;
    error_cause(err, place, errno, "cannot make the folder");
    folder_close(out);
    return false;
}

/* The new name is on the disk when its own folder is. */
bool folder_keep(struct folder *folder, const char *path, struct error *err)
{
    const struct place place = {path, 0, 0};
    char parent[sizeof folder->path];
    const mode_t mask = umask(0);
    umask(mask);
    const int own = dirfd(folder->entries);
    if (fchmod(own, 0777 & ~mask) != 0 || fsync(own) != 0 ||
        rename(folder->path, path) != 0)
        return error_cause(err, place, errno, "cannot make the folder");
    folder->path[0] = '\0';
    find_parent(path, parent);
    const int above = open(parent, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (above >= 0) {
        fsync(above);
        close(above);
    }
    return true;
}

void folder_close(struct folder *folder)
{
    if (folder->path[0] && folder->entries)
        empty(folder->entries);
    if (folder->path[0])
        rmdir(folder->path);
    guard_forget(folder->path);
    if (folder->entries)
        closedir(folder->entries);
    *folder = (struct folder){.entries = NULL};
}
