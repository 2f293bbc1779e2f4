/* SPDX-License-Identifier: MIT */
/* A folder for files that nobody keeps, or that nobody keeps yet. */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/files/inside.h"

/* Makes a folder whose name is a prefix and the six characters of mkdtemp. */
static bool make(const char *parent, const char *prefix, struct folder *out)
{
    char path[sizeof out->path];
    if (snprintf(path, sizeof path, "%s/%sXXXXXX", parent, prefix) >= (int)sizeof path) {
        errno = ENAMETOOLONG;
        return false;
    }
    if (!mkdtemp(path))
        return false;
    memcpy(out->path, path, sizeof path);
    do
        out->entries = opendir(path);
    while (!out->entries && errno == EINTR);
    return out->entries;
}

/* Removes the files in a folder, which holds no folders. */
static void empty(DIR *entries)
{
    rewinddir(entries);
    for (const struct dirent *entry; (entry = readdir(entries));)
        unlinkat(dirfd(entries), entry->d_name, 0);
}

bool folder_open(struct folder *out, struct error *err)
{
    const char *given = getenv("TMPDIR"), *parent = given && given[0] ? given : "/tmp";
    *out = (struct folder){.entries = NULL};
    guard_hold();
    const bool done = make(parent, "spectral.", out) && guard_remove(out->path);
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
    errno = 0;
    if (make(parent, ".spectral-unfinished.", out))
        return true;
    error_cause(err, place, errno, "cannot make the folder");
    folder_close(out);
    return false;
}

/* The new name is on the disk when its own folder is. */
bool folder_keep(struct folder *folder, const char *path, struct error *err)
{
    const struct place place = {path, 0, 0};
    const mode_t mask = umask(0);
    umask(mask);
    const int own = dirfd(folder->entries);
    if (fchmod(own, 0777 & ~mask) != 0 || fsync(own) != 0 || rename(folder->path, path) != 0)
        return error_cause(err, place, errno, "cannot make the folder");
    folder->path[0] = '\0';
    folder_sync(path);
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
