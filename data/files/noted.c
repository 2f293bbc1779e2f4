/* SPDX-License-Identifier: MIT */
/* The digests of the files that this process has read, each of the bytes as they were read: a stack
 * records them, however its files change while it is drawn. Whoever reads a file need not know who
 * records it: so the list is kept by the process, and not passed along. */
#include <pthread.h>
#include <string.h>

#include "data/files/inside.h"

struct sha256 {
    char text[65];
};
static struct {
    pthread_mutex_t lock;
    struct index paths;
    struct sha256 *list;
    int n;
} were_read = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* Keeps the last digest of a path. */
static bool note(const char *path, const struct sha256 *sha256, struct error *err)
{
    pthread_mutex_lock(&were_read.lock);
    const size_t length = strlen(path);
    const int known = index_find(&were_read.paths, path, length);
    bool done = known >= 0;
    if (done)
        were_read.list[known] = *sha256;
    else
        done = array_add(&were_read.list, &were_read.n, sha256, sizeof *sha256, err) &&
               index_add(&were_read.paths, path, length, were_read.n - 1, err);
    pthread_mutex_unlock(&were_read.lock);
    return done;
}

bool digest_note(const char *path, const void *bytes, size_t length, struct error *err)
{
    struct sha256 sha256;
    digest_bytes(bytes, length, sha256.text);
    return path_is_builtin(path) || note(path, &sha256, err);
}

bool digest_note_open(const char *path, int descriptor, struct error *err)
{
    struct sha256 sha256;
    return path_is_builtin(path) ||
           (digest_descriptor(path, descriptor, sha256.text, err) && note(path, &sha256, err));
}

bool digest_was_read(const char *path, char out[65])
{
    pthread_mutex_lock(&were_read.lock);
    const int known = index_find(&were_read.paths, path, strlen(path));
    if (known >= 0)
        memcpy(out, were_read.list[known].text, sizeof were_read.list[known].text);
    pthread_mutex_unlock(&were_read.lock);
    return known >= 0;
}
