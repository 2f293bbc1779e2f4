/* SPDX-License-Identifier: MIT */
/* Reads and writes all bytes of an open file, although a signal or a pipe divides a call. Keeps a
 * list of the files that this process has opened for reading: no output may replace one of them.
 * Whoever opens a file need not know which outputs follow, nor the other way round: so the list is
 * kept by the process, and not passed along. */
#include <sys/stat.h>
#include <unistd.h>

#include "data/base/inside.h"

ssize_t read_at(int descriptor, void *bytes, size_t length, uint64_t offset)
{
    size_t got = 0;
    for (ssize_t more = 1; got < length && more > 0; got += (size_t)more) {
        char *to = (char *)bytes + got;
        if (offset == OWN_PLACE)
            UNTIL_DONE(more, read(descriptor, to, length - got));
        else
            UNTIL_DONE(more, pread(descriptor, to, length - got, (off_t)(offset + got)));
        if (more < 0)
            return -1;
    }
    return (ssize_t)got;
}

bool write_at(int descriptor, const void *bytes, size_t length, uint64_t offset)
{
    size_t done = 0;
    for (ssize_t more; done < length; done += (size_t)more) {
        const char *from = (const char *)bytes + done;
        if (offset == OWN_PLACE)
            UNTIL_DONE(more, write(descriptor, from, length - done));
        else
            UNTIL_DONE(more, pwrite(descriptor, from, length - done, (off_t)(offset + done)));
        if (more < 0)
            return false;
    }
    return true;
}

bool write_all(int descriptor, const void *bytes, size_t length)
{
    return write_at(descriptor, bytes, length, OWN_PLACE);
}

/* ---- files that were read ---- */

static struct {
    pthread_mutex_t lock;
    struct file_identity {
        dev_t device;
        ino_t inode;
    } * list;
    int n;
} were_read = {.lock = PTHREAD_MUTEX_INITIALIZER};

bool file_note_read(int descriptor, struct error *err)
{
    struct stat status;
    if (fstat(descriptor, &status) != 0)
        return error_system(err, "cannot examine an open file");
    const struct file_identity file = {status.st_dev, status.st_ino};
    if (!S_ISREG(status.st_mode))
        return true;
    pthread_mutex_lock(&were_read.lock);
    const bool done = array_add(&were_read.list, &were_read.n, &file, sizeof file, err);
    pthread_mutex_unlock(&were_read.lock);
    return done;
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
        if (were_read.list[i].device == status.st_dev && were_read.list[i].inode == status.st_ino)
            return true;
    return false;
}
