/* SPDX-License-Identifier: MIT */
/* SHA-256 (FIPS 180-4). Reports and records identify files by it. */
#include <fcntl.h>
#include <unistd.h>

#include "data/files/files.h"

enum { BLOCK = sizeof((struct digest *)0)->block };

/* 4.2.2: the first 32 bits of the fractions of the cube roots of the first 64 primes. */
static const uint32_t round_constants[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2,
};

static uint32_t rotate(uint32_t word, int right)
{
    return word >> right | word << (32 - right);
}

/* 6.2.2 step 1. The names a to h and w are those of the standard. */
static void schedule(const unsigned char *block, uint32_t w[64])
{
    for (int t = 0; t < 16; t++, block += 4)
        w[t] = (uint32_t)block[0] << 24 | (uint32_t)block[1] << 16 | (uint32_t)block[2] << 8 |
               (uint32_t)block[3];
    for (int t = 16; t < 64; t++) {
        uint32_t s0 = rotate(w[t - 15], 7) ^ rotate(w[t - 15], 18) ^ w[t - 15] >> 3;
        uint32_t s1 = rotate(w[t - 2], 17) ^ rotate(w[t - 2], 19) ^ w[t - 2] >> 10;
        w[t] = w[t - 16] + s0 + w[t - 7] + s1;
    }
}

static void add_block(uint32_t hash[8], const unsigned char *block)
{
    uint32_t w[64];
    uint32_t a = hash[0], b = hash[1], c = hash[2], d = hash[3];
    uint32_t e = hash[4], f = hash[5], g = hash[6], h = hash[7];
    schedule(block, w);
    for (int t = 0; t < 64; t++) {
        uint32_t choice = (e & f) ^ (~e & g), majority = (a & b) ^ (a & c) ^ (b & c);
        uint32_t t1 =
            h + (rotate(e, 6) ^ rotate(e, 11) ^ rotate(e, 25)) + choice + round_constants[t] + w[t];
        uint32_t t2 = (rotate(a, 2) ^ rotate(a, 13) ^ rotate(a, 22)) + majority;
        h = g;
        g = f;
        f = e;
        e = d + t1;
        d = c;
        c = b;
        b = a;
        a = t1 + t2;
    }
    const uint32_t after[8] = {a, b, c, d, e, f, g, h};
    for (int i = 0; i < 8; i++)
        hash[i] += after[i];
}

/* 5.3.3: the fractions of the square roots of the first eight primes. */
void digest_start(struct digest *out)
{
    *out = (struct digest){.hash = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f,
                                    0x9b05688c, 0x1f83d9ab, 0x5be0cd19}};
}

void digest_add(struct digest *digest, const void *bytes, size_t length)
{
    const unsigned char *at = bytes;
    size_t kept = (size_t)(digest->total % BLOCK), fill;
    digest->total += length;
    for (; length > 0; at += fill, length -= fill, kept = 0) {
        fill = length < BLOCK - kept ? length : BLOCK - kept;
        if (fill < BLOCK)
            memcpy(digest->block + kept, at, fill);
        if (kept + fill == BLOCK)
            add_block(digest->hash, fill < BLOCK ? digest->block : at);
    }
}

/* 5.1.1: after the last byte a one bit, zeros, and the number of bits in the last eight bytes. */
void digest_end(struct digest *digest, char out[65])
{
    unsigned char last[BLOCK + 8] = {0x80}, *bits;
    const uint64_t total = digest->total;
    const size_t zeros = (2 * BLOCK - 9 - (size_t)(total % BLOCK)) % BLOCK;
    bits = last + 1 + zeros;
    for (int i = 0; i < 8; i++)
        bits[i] = (unsigned char)(8 * total >> (56 - 8 * i) & 0xff);
    digest_add(digest, last, 1 + zeros + 8);
    for (int i = 0; i < 8; i++)
        snprintf(out + 8 * i, 9, "%08lx", (unsigned long)digest->hash[i]);
}

void digest_bytes(const void *bytes, size_t length, char out[65])
{
    struct digest digest;
    digest_start(&digest);
    digest_add(&digest, bytes, length);
    digest_end(&digest, out);
}

/* ---- the files that were read ---- */

/* The digests of the texts that this process has read, each of the bytes as they were read: a stack
 * records them, however its files change while it is drawn. Whoever reads a file need not know who
 * records it: so the list is kept by the process, and not passed along. */
static struct {
    pthread_mutex_t lock;
    struct index paths;
    char (*list)[65];
    int n;
} were_read = {.lock = PTHREAD_MUTEX_INITIALIZER};

bool digest_note(const char *path, const void *bytes, size_t length, struct error *err)
{
    char sha256[65];
    if (path_is_builtin(path))
        return true;
    digest_bytes(bytes, length, sha256);
    pthread_mutex_lock(&were_read.lock);
    const int known = index_find(&were_read.paths, path, strlen(path));
    const bool done =
        known >= 0 || (array_add(&were_read.list, &were_read.n, sha256, sizeof sha256, err) &&
                       index_add(&were_read.paths, path, strlen(path), were_read.n - 1, err));
    if (known >= 0)
        memcpy(were_read.list[known], sha256, sizeof sha256); /* the last one */
    pthread_mutex_unlock(&were_read.lock);
    return done;
}

/* Digests a file as it is now. */
static bool digest_now(const char *path, char out[65], struct error *err)
{
    unsigned char buffer[1024 * BLOCK];
    struct digest digest;
    ssize_t got = 1;
    int file;
    digest_start(&digest);
    UNTIL_DONE(file, open(path, O_RDONLY | O_CLOEXEC));
    while (file >= 0 && got > 0) {
        got = read_at(file, buffer, sizeof buffer, OWN_PLACE);
        digest_add(&digest, buffer, got > 0 ? (size_t)got : 0);
    }
    if (file < 0 || got < 0)
        error_system(err, "cannot read %s", path);
    digest_end(&digest, out);
    if (file >= 0)
        close(file);
    return file >= 0 && got == 0;
}

bool digest_file(const char *path, char out[65], struct error *err)
{
    pthread_mutex_lock(&were_read.lock);
    const int known = index_find(&were_read.paths, path, strlen(path));
    if (known >= 0)
        memcpy(out, were_read.list[known], sizeof *were_read.list);
    pthread_mutex_unlock(&were_read.lock);
    return known >= 0 || digest_now(path, out, err);
}
