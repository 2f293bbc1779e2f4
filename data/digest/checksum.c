/* SPDX-License-Identifier: MIT */
/* A checksum that finds what goes wrong by chance. */
#include <zlib.h>

#include "data/digest/digest.h"

uint32_t checksum_add(uint32_t sum, const void *bytes, size_t length)
{
    const size_t most = 1 << 30; /* zlib takes an unsigned int */
    const unsigned char *at = bytes;
    while (length > 0) {
        const size_t n = length < most ? length : most;
        sum = (uint32_t)crc32(sum, at, (uInt)n);
        at += n;
        length -= n;
    }
    return sum;
}
