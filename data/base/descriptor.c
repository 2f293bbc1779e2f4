/* SPDX-License-Identifier: MIT */
/* Reads and writes all bytes of an open file, although a signal or a pipe divides a call. */
#include <unistd.h>

#include "data/base/base.h"

bool write_all(int descriptor, const void *bytes, size_t length)
{
    const char *at = bytes;
    while (length > 0) {
        ssize_t done;
        UNTIL_DONE(done, write(descriptor, at, length));
        if (done < 0)
            return false;
        at += done;
        length -= (size_t)done;
    }
    return true;
}

ssize_t read_at(int descriptor, void *bytes, size_t length, uint64_t offset)
{
    size_t got = 0;
    while (got < length) {
        ssize_t more;
        UNTIL_DONE(more,
                   pread(descriptor, (char *)bytes + got, length - got, (off_t)(offset + got)));
        if (more < 0)
            return -1;
        if (more == 0)
            break;
        got += (size_t)more;
    }
    return (ssize_t)got;
}

bool write_at(int descriptor, const void *bytes, size_t length, uint64_t offset)
{
    const char *at = bytes;
    while (length > 0) {
        ssize_t done;
        UNTIL_DONE(done, pwrite(descriptor, at, length, (off_t)offset));
        if (done < 0)
            return false;
        at += done;
        length -= (size_t)done;
        offset += (uint64_t)done;
    }
    return true;
}
