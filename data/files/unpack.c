/* SPDX-License-Identifier: MIT */
/* Unpacks the built-in files of the minimal program: one piece in gzip's format (RFC 1952). */
#define ZLIB_CONST /* zlib then reads constant bytes */
#include <zlib.h>

#include "data/files/files.h"

/* Inflates the piece to exactly so many bytes. */
static bool inflate_all(unsigned char *out, size_t length)
{
    enum { GZIP_FORMAT = 16 + MAX_WBITS };
    z_stream stream = {.next_in = builtin_packed,
                       .avail_in = (uInt)builtin_packed_length,
                       .next_out = out,
                       .avail_out = (uInt)length};
    bool done = inflateInit2(&stream, GZIP_FORMAT) == Z_OK;
    done = done && inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.avail_out == 0;
    inflateEnd(&stream);
    return done;
}

bool builtin_unpack(struct error *err)
{
    size_t length = 0;
    unsigned char *bytes;
    if (!builtin_packed)
        return true;
    for (size_t i = 0; i < builtin_file_count; i++)
        length += builtin_to_unpack[i].length + 1;
    if (!MAKE_ARRAY(bytes, length, err, "the built-in files"))
        return false;
    if (!inflate_all(bytes, length)) {
        free(bytes);
        return memory_lacks(err, 0, "unpacking the built-in files");
    }
    for (size_t i = 0; i < builtin_file_count; i++) {
        builtin_to_unpack[i].bytes = bytes;
        bytes += builtin_to_unpack[i].length + 1;
    }
    return true; /* the files stay until the process ends */
}
