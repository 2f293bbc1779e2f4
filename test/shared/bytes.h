/* SPDX-License-Identifier: MIT */
/* Whole files, for tests that damage them. */
#ifndef BYTES_H
#define BYTES_H

#include <unistd.h>

#include "test.h"

/* Returns the bytes of a file, and room for eight more; its length is 0 if it cannot be read. */
static inline unsigned char *bytes_read(const char *path, size_t *length)
{
    enum { MOST = 1 << 20 };
    FILE *file = fopen(path, "rb");
    unsigned char *bytes = calloc(1, MOST + 8);
    *length = file != NULL && bytes != NULL ? fread(bytes, 1, MOST, file) : 0;
    if (file != NULL)
        fclose(file);
    return bytes;
}

/* Writes a file anew: to overwrite an old one is slow. Returns `path`. */
static inline const char *bytes_write(const char *path, const void *bytes, size_t length)
{
    unlink(path);
    FILE *file = fopen(path, "wb");
    if (file == NULL || fwrite(bytes, 1, length, file) != length || fclose(file) != 0)
        CHECK(false, "%s is written", path);
    return path;
}

#endif
