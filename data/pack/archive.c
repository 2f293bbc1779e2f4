/* SPDX-License-Identifier: MIT */
/* Writes tar archives (POSIX.1-2017, pax): a block of 512 bytes before each file, which names it
 * and its length, then its bytes, filled up to whole blocks. A record of pax before it has what the
 * block cannot hold: a name of more than 100 bytes or of other characters than ASCII, and a length
 * of 8 GiB or more. */
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/pack/pack.h"

enum { BLOCK = 512, NAME = 100, LENGTH_DIGITS = 11 };
static const uint64_t longest_octal = ((uint64_t)1 << (3 * LENGTH_DIGITS)) - 1;

/* Offsets in a block, and the kinds of what follows. */
enum {
    AT_MODE = 100,
    AT_OWNER = 108,
    AT_GROUP = 116,
    AT_LENGTH = 124,
    AT_DATE = 136,
    AT_SUM = 148,
    AT_KIND = 156,
    AT_MAGIC = 257
};
enum { KIND_FILE = '0', KIND_PAX = 'x' };

static bool put(const struct output *to, const void *bytes, size_t length, struct error *err)
{
    return write_all(to->descriptor, bytes, length) ||
           error_cause(err, (struct place){NULL, 0, 0}, errno, "cannot write %s", to->path);
}

/* The sum of a block counts its own eight bytes as blanks. */
static bool put_block(const struct output *to, const char *name, uint64_t length, char kind,
                      struct error *err)
{
    char block[BLOCK + 1] = {0};
    unsigned sum = 0;
    memcpy(block, name, strnlen(name, NAME));
    sprintf(block + AT_MODE, "%07o", 0644);
    sprintf(block + AT_OWNER, "%07o", 0);
    sprintf(block + AT_GROUP, "%07o", 0);
    sprintf(block + AT_LENGTH, "%011llo",
            (unsigned long long)(length <= longest_octal ? length : 0));
    sprintf(block + AT_DATE, "%011o", 0);
    memset(block + AT_SUM, ' ', 8);
    block[AT_KIND] = kind;
    memcpy(block + AT_MAGIC,
           "ustar\0"
           "00",
           8);
    for (int i = 0; i < BLOCK; i++)
        sum += (unsigned char)block[i];
    sprintf(block + AT_SUM, "%06o", sum);
    return put(to, block, BLOCK, err);
}

static bool fill_block(const struct output *to, uint64_t length, struct error *err)
{
    static const char zeros[BLOCK];
    return length % BLOCK == 0 || put(to, zeros, BLOCK - (size_t)(length % BLOCK), err);
}

/* Prints a record "LENGTH KEY=VALUE\n", whose length counts its own digits. */
static void print_record(struct printed *to, const char *key, const char *value)
{
    const size_t rest = strlen(key) + strlen(value) + 3;
    size_t length = rest + 1;
    char digits[32];
    while (rest + (size_t)snprintf(digits, sizeof digits, "%zu", length) != length)
        length++;
    print(to, "%zu %s=%s\n", length, key, value);
}

static bool is_plain(const char *name)
{
    const char *at = name;
    while (*at > 0 && at - name <= NAME)
        at++;
    return *at == '\0' && at - name <= NAME;
}

/* Writes the record of pax, if one is needed. */
static bool put_extra(const struct output *to, const char *name, uint64_t length, struct error *err)
{
    struct printed printed = {.text = NULL};
    char number[32];
    snprintf(number, sizeof number, "%llu", (unsigned long long)length);
    if (!is_plain(name))
        print_record(&printed, "path", name);
    if (length > longest_octal)
        print_record(&printed, "size", number);
    char *text = printed_end(&printed);
    const size_t bytes = printed.length;
    const bool done = text ? bytes == 0 || (put_block(to, "pax", bytes, KIND_PAX, err) &&
                                            put(to, text, bytes, err) && fill_block(to, bytes, err))
                           : error_memory(err);
    free(text);
    return done;
}

static bool put_head(const struct output *to, const char *name, uint64_t length, struct error *err)
{
    return put_extra(to, name, length, err) && put_block(to, name, length, KIND_FILE, err);
}

/* Copies so many bytes of an open file. Refuses a file that has become shorter meanwhile. */
static bool copy(const struct output *to, int from, const char *path, uint64_t length,
                 struct error *err)
{
    char bytes[65536];
    for (uint64_t at = 0; at < length;) {
        const uint64_t left = length - at;
        const ssize_t got =
            read_at(from, bytes, left < sizeof bytes ? (size_t)left : sizeof bytes, at);
        if (got <= 0)
            return error_system(err, "%s: cannot be read, or has become shorter", path);
        if (!put(to, bytes, (size_t)got, err))
            return false;
        at += (uint64_t)got;
    }
    return true;
}

bool archive_add(const struct output *to, const char *name, const char *path, struct error *err)
{
    const struct place nowhere = {NULL, 0, 0};
    const struct builtin_file *builtin;
    struct stat status;
    int from;
    if (!file_open(path, nowhere, &from, &builtin, err))
        return false;
    bool done = fstat(from, &status) == 0 || error_system(err, "%s: cannot be read", path);
    const uint64_t length = done ? (uint64_t)status.st_size : 0;
    done = done && put_head(to, name, length, err) && copy(to, from, path, length, err) &&
           fill_block(to, length, err);
    close(from);
    return done;
}

/* Two blocks of zeros end an archive. */
bool archive_end(const struct output *to, struct error *err)
{
    static const char zeros[2 * BLOCK];
    return put(to, zeros, sizeof zeros, err);
}
