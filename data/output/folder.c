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

/* Names of folders are a prefix and the six characters of mkdtemp. In a folder of the user's they
 * are hidden, and no name that anybody gives. */
static const char temporary_prefix[] = "spectral.", kept_prefix[] = ".spectral-unfinished.",
                  pattern[] = "XXXXXX";

/* Opens a folder of this user. Follows no link. Returns NULL where there is none. */
static DIR *open_own(int parent, const char *name)
{
    const int folder = openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    struct stat status;
    DIR *entries = NULL;
    if (folder >= 0 && fstat(folder, &status) == 0 && status.st_uid == geteuid())
        entries = fdopendir(folder);
    if (folder >= 0 && !entries)
        close(folder);
    return entries;
}

/* Removes the files in a folder, which holds no folders. Needs no memory. */
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

/* Removes the folders of processes that were killed. */
static void sweep(const char *parent, const char *prefix)
{
    DIR *entries = opendir(parent);
    if (!entries)
        return;
    for (const struct dirent *entry; (entry = readdir(entries));) {
        if (!is_ours(entry->d_name, prefix))
            continue;
        DIR *folder = open_own(dirfd(entries), entry->d_name);
        if (!folder)
            continue;
        if (flock(dirfd(folder), LOCK_EX | LOCK_NB) == 0) {
            empty(folder);
            unlinkat(dirfd(entries), entry->d_name, AT_REMOVEDIR);
        }
        closedir(folder);
    }
    closedir(entries);
}

/* Another process may sweep a new folder before this one has its lock: then it makes another. A
 * file system without locks is swept by nobody. */
static bool make(const char *parent, const char *prefix, struct folder *out)
{
    struct stat status;
    for (int attempt = 0; attempt < 100; attempt++) {
        char path[sizeof out->path];
        snprintf(path, sizeof path, "%s/%s%s", parent, prefix, pattern);
        if (!mkdtemp(path))
            return false;
        memcpy(out->path, path, sizeof path);
        out->entries = open_own(AT_FDCWD, path);
        const int lock = out->entries ? dirfd(out->entries) : -1;
        if (lock >= 0 && (flock(lock, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) &&
            fstat(lock, &status) == 0 && status.st_nlink > 0)
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
    if (!make(parent, temporary_prefix, out)) {
        error_system(err, "cannot make a temporary folder in %s", parent);
        folder_close(out);
        return false;
    }
    return true;
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
    const int lock = dirfd(folder->entries);
    if (fchmod(lock, 0777 & ~mask) != 0 || fsync(lock) != 0 || rename(folder->path, path) != 0)
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
    if (folder->path[0] && rmdir(folder->path) != 0 && folder->entries) {
        empty(folder->entries);
        rmdir(folder->path);
    }
    if (folder->entries)
        closedir(folder->entries);
    *folder = (struct folder){.entries = NULL};
}
