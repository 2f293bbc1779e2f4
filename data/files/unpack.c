/* SPDX-License-Identifier: MIT */
/* Unpacks the built-in files of the minimal program: one piece in gzip's format (RFC 1952). */
#define ZLIB_CONST /* zlib then reads constant bytes */
#include <zlib.h>

#include "data/files/files.h"

bool builtin_unpack(struct error *err)
{
    enum { GZIP_FORMAT = 16 + MAX_WBITS };
    z_stream stream = {.next_in = builtin_packed,
                       .avail_in = (uInt)builtin_packed_length,
                       .next_out = builtin_unpacked,
                       .avail_out = (uInt)builtin_unpacked_length};
    if (!builtin_packed)
        return true;
    bool done = inflateInit2(&stream, GZIP_FORMAT) == Z_OK;
    done = done && inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.avail_out == 0;
    inflateEnd(&stream);
    return done || memory_lacks(err, 0, "unpacking the built-in files");
}
