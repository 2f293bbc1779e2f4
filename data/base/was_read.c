/* SPDX-License-Identifier: MIT */
/* The files that this process has opened for reading. No output may replace one of them. Whoever
 * opens a file need not know which outputs follow, nor the other way round: so the list is kept by
 * the process, and not passed along. */
#include <stdlib.h>
#include <sys/stat.h>

#include "data/base/inside.h"

static struct {
    pthread_mutex_t lock;
    struct file_identity *list;
    int n;
} were_read = {.lock = PTHREAD_MUTEX_INITIALIZER};

bool files_read_add(const struct file_identity *file, struct error *err)
{
    pthread_mutex_lock(&were_read.lock);
    const bool done = array_add(&were_read.list, &were_read.n, file, sizeof *file, err);
    pthread_mutex_unlock(&were_read.lock);
    return done;
}

bool file_note_read(int descriptor, struct error *err)
{
    struct stat status;
    if (fstat(descriptor, &status) != 0)
        return error_system(err, "cannot examine an open file");
    const struct file_identity file = {(uint64_t)status.st_dev, (uint64_t)status.st_ino};
    return !S_ISREG(status.st_mode) || files_read_add(&file, err);
}

const struct file_identity *files_read(int *n)
{
    *n = were_read.n;
    return were_read.list;
}

void files_read_forget(void)
{
    free(were_read.list);
    were_read.list = NULL;
    were_read.n = 0;
}

bool file_was_read(const char *path)
{
    struct stat status;
    if (stat(path, &status) != 0)
        return false;
    for (int i = 0; i < were_read.n; i++)
        if (were_read.list[i].device == (uint64_t)status.st_dev &&
            were_read.list[i].inode == (uint64_t)status.st_ino)
            return true;
    return false;
}
