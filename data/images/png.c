/* SPDX-License-Identifier: MIT */
/* Writes PNG files: ISO/IEC 15948:2004, "the specification" below. zlib compresses the rows as they
 * come, as differences between neighbours. Choosing one of the five filters for each row, as
 * section 12.8 recommends, makes rendered pictures no smaller. zlib gets a row at a time, so that
 * its output does not depend on how many rows come at once. */
#define ZLIB_CONST /* zlib then reads constant bytes */
#include <zlib.h>

#include "data/images/inside.h"

enum { CHUNK_BYTES = 1 << 16, LEVEL = 6, CHANNELS = 3 };
struct png {
    struct output *output;  /* the picture writer's */
    struct printed *memory; /* takes the bytes in its place; NULL: none */
    z_stream stream;
    size_t pixel_bytes, row_bytes;
    unsigned char *row; /* filtered, behind the number of the filter; owned */
    unsigned char packed[CHUNK_BYTES];
};

/* ---- chunks ---- */

static void put_number(uint32_t number, unsigned char *out)
{
    for (int i = 0; i < 4; i++)
        out[i] = (unsigned char)(number >> (24 - 8 * i));
}

static bool put_bytes(struct png *png, const void *bytes, size_t length, struct error *err)
{
    if (png->memory) {
        print_bytes(png->memory, bytes, length);
        return true; /* printed_take reports a lack of memory */
    }
    return write_all(png->output->descriptor, bytes, length) ||
           error_system(err, "%s: cannot be written", png->output->holder);
}

/* Writes a chunk of fewer than 2^31 bytes. */
static bool put_chunk(struct png *png, const char *type, const void *bytes, size_t length,
                      struct error *err)
{
    unsigned char head[8], check[4];
    uLong sum = crc32(0, (const Bytef *)type, 4);
    if (length > 0)
        sum = crc32(sum, bytes, (uInt)length);
    put_number((uint32_t)length, head);
    memcpy(head + 4, type, 4);
    put_number((uint32_t)sum, check);
    return put_bytes(png, head, sizeof head, err) && put_bytes(png, bytes, length, err) &&
           put_bytes(png, check, sizeof check, err);
}

/* ---- before the pixels ---- */

/* Writes a chunk of what has been printed, and frees it. */
static bool put_printed(struct png *png, const char *type, struct printed *printed,
                        struct error *err)
{
    char *bytes = printed_take(printed, err);
    const bool done = bytes && put_chunk(png, type, bytes, printed->length, err);
    free(bytes);
    return done;
}

/* Writes the profile, compressed, behind its name and the number of the compression. */
static bool put_profile(struct png *png, const struct picture_options *options, struct error *err)
{
    uLongf length = compressBound((uLong)options->profile_length);
    struct printed chunk = {.text = NULL};
    unsigned char *packed;
    if (!MAKE_ARRAY(packed, length, err, "the profile of a PNG file"))
        return false;
    const bool done = compress2(packed, &length, options->profile, (uLong)options->profile_length,
                                Z_BEST_COMPRESSION) == Z_OK ||
                      memory_lacks(err, (double)length, "the profile of a PNG file");
    print(&chunk, "display%c%c", 0, 0); /* deflate is 0 */
    print_bytes(&chunk, packed, length);
    free(packed);
    return put_printed(png, "iCCP", &chunk, err) && done;
}

/* Writes a text chunk: a keyword, a NUL, and Latin-1 text. */
static bool put_text(struct png *png, const char *keyword, const char *text, struct error *err)
{
    struct printed chunk = {.text = NULL};
    print(&chunk, "%s%c%s", keyword, 0, text);
    return put_printed(png, "tEXt", &chunk, err);
}

static bool put_head(struct png *png, const struct picture_options *options, struct error *err)
{
    static const unsigned char signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    unsigned char header[13] = {0};
    put_number((uint32_t)options->width, header);
    put_number((uint32_t)options->height, header + 4);
    header[8] = (unsigned char)(8 * png->pixel_bytes / CHANNELS);
    header[9] = 2; /* RGB; compression, filters and interlacing are 0, the usual ones */
    return put_bytes(png, signature, sizeof signature, err) &&
           put_chunk(png, "IHDR", header, sizeof header, err) &&
           (options->srgb      ? put_chunk(png, "sRGB", "", 1, err) /* 0: the perceptual intent */
            : options->profile ? put_profile(png, options, err)
                               : true) &&
           put_text(png, "Software", PROGRAM, err) &&
           put_text(png, "Description", options->description, err);
}

/* ---- pixels ---- */

/* Writes what zlib has packed since the last chunk. */
static bool put_packed(struct png *png, struct error *err)
{
    const size_t length = sizeof png->packed - png->stream.avail_out;
    png->stream.next_out = png->packed;
    png->stream.avail_out = sizeof png->packed;
    return length == 0 || put_chunk(png, "IDAT", png->packed, length, err);
}

/* Packs bytes; `flush` is Z_FINISH after the last row, otherwise Z_NO_FLUSH. */
static bool pack(struct png *png, const unsigned char *bytes, size_t length, int flush,
                 struct error *err)
{
    int status = Z_OK;
    png->stream.next_in = bytes;
    png->stream.avail_in = (uInt)length;
    while (flush == Z_FINISH ? status != Z_STREAM_END : png->stream.avail_in > 0) {
        status = deflate(&png->stream, flush);
        if (status == Z_STREAM_ERROR)
            return error_failed(err, "%s: zlib cannot compress the picture", png->output->path);
        if (png->stream.avail_out == 0 && !put_packed(png, err))
            return false;
    }
    return flush != Z_FINISH || put_packed(png, err);
}

/* Turns the samples of a row into bytes, since a PNG is big-endian, and these into their
 * differences from the pixel to the left. */
static void filter_row(const struct png *png, const void *samples)
{
    const uint16_t *wide = samples;
    unsigned char *row = png->row + 1;
    if (png->pixel_bytes == CHANNELS)
        memcpy(row, samples, png->row_bytes);
    else
        for (size_t i = 0; i < png->row_bytes / 2; i++) {
            row[2 * i] = (unsigned char)(wide[i] >> 8);
            row[2 * i + 1] = (unsigned char)(wide[i] & 0xff);
        }
    for (size_t i = png->row_bytes; i-- > png->pixel_bytes;)
        row[i] = (unsigned char)(row[i] - row[i - png->pixel_bytes]);
}

bool png_write(struct png *png, const void *samples, int rows, struct error *err)
{
    const unsigned char *from = samples;
    for (int y = 0; y < rows; y++, from += png->row_bytes) {
        filter_row(png, from);
        if (!pack(png, png->row, png->row_bytes + 1, Z_NO_FLUSH, err))
            return false;
    }
    return true;
}

/* ---- the file ---- */

bool png_open(struct png **out, struct output *output, const char *path,
              const struct picture_options *options, struct error *err)
{
    struct png *png;
    if (!MAKE_ARRAY(*out, 1, err, "a PNG file"))
        return false;
    png = *out;
    png->output = output;
    png->memory = options->memory;
    png->pixel_bytes = (size_t)CHANNELS * ((size_t)options->bits / 8);
    png->row_bytes = png->pixel_bytes * (size_t)options->width;
    png->stream.next_out = png->packed;
    png->stream.avail_out = sizeof png->packed;
    if ((deflateInit(&png->stream, LEVEL) == Z_OK ||
         memory_lacks(err, 0, "zlib, which writes %s", path)) &&
        MAKE_ARRAY(png->row, png->row_bytes + 1, err, "a row of a PNG file") &&
        (options->memory || output_open(output, path, err)) && put_head(png, options, err)) {
        png->row[0] = FILTER_SUB;
        return true;
    }
    output_discard(output);
    png_free(png);
    *out = NULL;
    return false;
}

bool png_finish(struct png *png, struct error *err)
{
    return pack(png, NULL, 0, Z_FINISH, err) && put_chunk(png, "IEND", NULL, 0, err);
}

void png_free(struct png *png)
{
    if (!png)
        return;
    deflateEnd(&png->stream); /* does nothing to a stream that did not open */
    FREE_ALL(png->row, png);
}
