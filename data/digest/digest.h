/* SPDX-License-Identifier: MIT */
/* The room "digest": SHA-256 (FIPS 180-4). */
#ifndef DIGEST_H
#define DIGEST_H

#include "data/base/base.h"

struct digest {
    uint32_t hash[8];
    unsigned char block[64]; /* bytes that do not fill a block yet */
    uint64_t total;          /* bytes */
};
void digest_start(struct digest *out);
void digest_add(struct digest *digest, const void *bytes, size_t length);
void digest_end(struct digest *digest, char out[65]); /* 64 hexadecimal digits and a NUL */
void digest_bytes(const void *bytes, size_t length, char out[65]);
bool digest_file(const char *path, char out[65], struct error *err);
/* Reads an open file for it; messages name the path. */
bool digest_descriptor(const char *path, int descriptor, char out[65], struct error *err);

/* ---- noted.c: digests of the files that this process has read ---- */

/* Notes the digest of a file as its bytes were read, or as it lies open. A built-in file has none.
 */
bool digest_note(const char *path, const void *bytes, size_t length, struct error *err);
bool digest_note_open(const char *path, int descriptor, struct error *err);
/* Finds the digest of a file that was read. Returns false for any other file. */
bool digest_was_read(const char *path, char out[65]);

#endif
