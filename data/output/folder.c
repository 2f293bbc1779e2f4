/* SPDX-License-Identifier: MIT */
/* A folder for files that nobody keeps. It holds a lock as long as its process lives: a later
 * process removes the folders of those that were killed. */
#define _GNU_SOURCE /* flock */
#include <dirent.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/output/output.h"

static const char prefix[] = "spectral.";

/* Opens a folder of this user. Follows no link. Returns -1 where there is none. */
static int open_own(int parent, const char *name)
{
    const int folder = openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    struct stat status;
    if (folder >= 0 && fstat(folder, &status) == 0 && status.st_uid == geteuid())
        return folder;
    if (folder >= 0)
        close(folder);
    return -1;
}

/* Removes the files in a folder, which holds no folders. */
static void empty(int folder)
{
    const int copy = dup(folder);
    DIR *entries = copy >= 0 ? fdopendir(copy) : NULL;
    if (!entries) {
        if (copy >= 0)
            close(copy);
        return;
    }
    for (const struct dirent *entry; (entry = readdir(entries));)
        unlinkat(folder, entry->d_name, 0);
    closedir(entries);
}

/* Removes the folders of processes that were killed. */
static void sweep(const char *parent)
{
    DIR *entries = opendir(parent);
    if (!entries)
        return;
    for (const struct dirent *entry; (entry = readdir(entries));) {
        if (strncmp(entry->d_name, prefix, strlen(prefix)) != 0)
            continue;
        const int folder = open_own(dirfd(entries), entry->d_name);
        if (folder < 0)
            continue;
        if (flock(folder, LOCK_EX | LOCK_NB) == 0) {
            empty(folder);
            unlinkat(dirfd(entries), entry->d_name, AT_REMOVEDIR);
        }
        close(folder);
    }
    closedir(entries);
}

/* Another process may sweep a new folder before this one has its lock: then it makes another. A
 * file system without locks is swept by nobody. */
static bool make(const char *parent, struct folder *out)
{
    struct stat status;
    for (int attempt = 0; attempt < 100; attempt++) {
        char path[sizeof out->path];
        snprintf(path, sizeof path, "%s/%sXXXXXX", parent, prefix);
        if (!mkdtemp(path))
            return false;
        memcpy(out->path, path, sizeof path);
        out->lock = open_own(AT_FDCWD, path);
        if (out->lock >= 0 && (flock(out->lock, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) &&
            fstat(out->lock, &status) == 0 && status.st_nlink > 0)
            return true;
        folder_close(out);
    }
    return false;
}

bool folder_open(struct folder *out, struct error *err)
{
    const char *given = getenv("TMPDIR"), *parent = given && given[0] ? given : "/tmp";
    *out = (struct folder){.lock = -1};
    sweep(parent);
    if (!make(parent, out)) {
        error_system(err, "cannot make a temporary folder in %s", parent);
        folder_close(out);
        return false;
    }
    return true;
}

void folder_close(struct folder *folder)
{
    if (folder->path[0] && rmdir(folder->path) != 0 && folder->lock >= 0) {
        empty(folder->lock);
        rmdir(folder->path);
    }
    if (folder->lock >= 0)
        close(folder->lock);
    *folder = (struct folder){.lock = -1};
}
