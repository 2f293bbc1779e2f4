/* SPDX-License-Identifier: MIT */
/* Decodes pictures of two other formats into memory, from where decode.c reads their rows as it
 * reads those of a TIFF: PNG (ISO/IEC 15948:2004) of grey or RGB, of 8 or 16 bits, with or without
 * alpha and without interlace; and SGI (Paul Haeberli, The SGI Image File Format, 1.00), which the
 * thesis has. */
#define ZLIB_CONST /* zlib then reads constant bytes */
#include <zlib.h>

#include "data/images/inside.h"
#include "data/text/text.h"

enum { FIRST = 1 }; /* the offset of the samples */

struct foreign {
    const struct image *image;
    unsigned char *bytes; /* of the file; owned */
    size_t length;
    struct sample_layout layout;
    struct printed description; /* of a PNG */
    unsigned char *out;         /* the samples, big-endian, from FIRST on; owned */
    size_t out_length;
};

static uint32_t number_at(const unsigned char *at, int bytes)
{
    uint32_t number = 0;
    for (int i = 0; i < bytes; i++)
        number = number << 8 | at[i];
    return number;
}

static bool refuse(const struct foreign *of, const char *why, struct error *err)
{
    return error_at(err, of->image->file->from, "%s: %s", of->image->path, why);
}

/* Completes the layout of grey or RGB, and makes room for the samples. planar: one channel comes
 * after the other. */
static bool allocate(struct foreign *of, bool planar, struct error *err)
{
    struct sample_layout *to = &of->layout;
    const double bytes = (double)to->width * to->height * to->n_samples * to->bits / 8;
    if (to->width - 1 >= LONGEST_SIDE || to->height - 1 >= LONGEST_SIDE)
        return refuse(of, "a side has 1 to 262144 pixels", err);
    if (!memory_suffices(2 * bytes, of->image->file->from, err, "%s", of->image->path))
        return false;
    to->block_width = to->width;
    to->block_height = to->height;
    to->n_colours = to->n_samples < 3 ? 1 : 3;
    to->n_planes = planar ? to->n_colours : 1;
    to->pixel_step = planar ? 1 : to->n_samples;
    to->row_bytes = to->width * to->pixel_step * (to->bits / 8u);
    to->n_bands = 1;
    to->rows_offset = FIRST;
    to->largest = to->bits == 8 ? 255 : 65535;
    of->out_length = FIRST + (size_t)bytes;
    return MAKE_ARRAY(of->out, of->out_length, err, "the pixels of %s", of->image->path);
}

/* ---- PNG ---- */

double linear_value(double gamma, double value)
{
    if (gamma > 0)
        return power(value, 1 / gamma);
    return value > 0.04045 ? power((value + 0.055) / 1.055, 2.4) : value / 12.92;
}

/* Joins the contents of all IDAT chunks in place, behind the signature. Returns false if a chunk is
 * broken or the last one is missing. */
static bool png_join(struct foreign *of, size_t *packed)
{
    size_t at = 8, length;
    *packed = 0;
    for (; at + 12 <= of->length; at += length + 12) {
        const unsigned char *chunk = of->bytes + at;
        length = number_at(chunk, 4);
        if (length > of->length - at - 12 ||
            crc32(0, chunk + 4, (uInt)length + 4) != number_at(chunk + 8 + length, 4))
            return false;
        if (memcmp(chunk + 4, "IEND", 4) == 0)
            return true;
        if (length >= 12 && memcmp(chunk + 4, "tEXtDescription", 16) == 0 && !of->description.text)
            print_bytes(&of->description, chunk + 20, length - 12);
        if (memcmp(chunk + 4, "sRGB", 4) == 0)
            of->layout.gamma = GAMMA_SRGB;
        if (length == 4 && memcmp(chunk + 4, "gAMA", 4) == 0 && of->layout.gamma == 0)
            of->layout.gamma = number_at(chunk + 8, 4) / 1e5;
        if (memcmp(chunk + 4, "IDAT", 4) == 0) {
            memmove(of->bytes + 8 + *packed, chunk + 8, length);
            *packed += length;
        }
    }
    return false;
}

/* Returns the neighbour that is nearest to left + above - corner. */
static int paeth(int left, int above, int corner)
{
    const int to_left = abs(above - corner), to_above = abs(left - corner);
    const int to_corner = abs(left + above - 2 * corner);
    return to_left <= to_above && to_left <= to_corner ? left
           : to_above <= to_corner                     ? above
                                                       : corner;
}

/* Writes the samples of filtered rows. Each byte is its difference plus what its filter predicts.
 */
static bool png_unfilter(const struct foreign *of, const unsigned char *raw)
{
    const size_t row = of->layout.row_bytes, pixel = row / of->layout.width;
    unsigned char *to = of->out + FIRST;
    const unsigned char *last = NULL; /* the row above */
    for (uint32_t y = 0; y < of->layout.height; y++, last = to, to += row, raw += row + 1) {
        if (raw[0] >= FILTERS)
            return false;
        for (size_t i = 0; i < row; i++) {
            const int left = i < pixel ? 0 : to[i - pixel], above = last ? last[i] : 0;
            const int corner = i < pixel || !last ? 0 : last[i - pixel];
            const int predicted[FILTERS] = {[FILTER_SUB] = left,
                                            [FILTER_UP] = above,
                                            [FILTER_AVERAGE] = (left + above) / 2,
                                            [FILTER_PAETH] = paeth(left, above, corner)};
            to[i] = (unsigned char)(raw[i + 1] + predicted[raw[0]]);
        }
    }
    return true;
}

static bool read_png(struct foreign *of, struct error *err)
{
    static const uint16_t channels[7] = {1, 0, 3, 0, 2, 0, 4}; /* of each type of colour; 0: none */
    const unsigned char *head = of->bytes + 8;
    struct sample_layout *to = &of->layout;
    size_t packed;
    if (of->length < 33 || memcmp(head + 4, "IHDR", 4) != 0)
        return refuse(of, "the PNG file has no header", err);
    to->width = number_at(head + 8, 4);
    to->height = number_at(head + 12, 4);
    to->n_samples = head[17] < 7 ? channels[head[17]] : 0;
    to->bits = head[16];
    if (to->n_samples == 0 || (to->bits != 8 && to->bits != 16) || head[20] != 0)
        return refuse(of,
                      "expected a PNG file of grey or RGB, of 8 or 16 bits, not interlaced; "
                      "'convert' of ImageMagick writes one with PNG48:NAME",
                      err);
    if (!allocate(of, false, err))
        return false;
    const uLong length = (uLong)(of->out_length - FIRST + to->height);
    uLongf got = length;
    unsigned char *raw;
    if (!MAKE_ARRAY(raw, length, err, "the pixels of %s", of->image->path))
        return false;
    const int status =
        png_join(of, &packed) ? uncompress(raw, &got, of->bytes + 8, (uLong)packed) : Z_DATA_ERROR;
    const bool good = status == Z_OK && got == length && png_unfilter(of, raw);
    free(raw);
    if (status == Z_MEM_ERROR)
        return memory_lacks(err, (double)length, "the pixels of %s", of->image->path);
    return good || refuse(of, "the PNG file is damaged or was cut", err);
}

/* ---- SGI ---- */

enum { SGI_HEAD = 512 };

/* Unpacks a row: a count of samples and one sample to repeat, or, with bit 7, so many samples. */
static bool sgi_unpack(const struct foreign *of, size_t from, size_t length, unsigned char *to)
{
    const size_t size = of->layout.bits / 8u;
    size_t left = of->layout.width;
    if (from > of->length || length > of->length - from)
        return false;
    const unsigned char *at = of->bytes + from, *end = at + length;
    while (left > 0) {
        if ((size_t)(end - at) < size)
            return false;
        const size_t word = at[size - 1], n = word & 127, step = word & 128 ? size : 0;
        const size_t bytes = step ? n * size : size;
        at += size;
        if (n == 0 || n > left || bytes > (size_t)(end - at))
            return false;
        for (size_t i = 0; i < n; i++, to += size)
            memcpy(to, at + i * step, size);
        at += bytes;
        left -= n;
    }
    return true;
}

/* Writes the rows of all channels. The file has the bottom row first. */
static bool sgi_rows(const struct foreign *of)
{
    const size_t row = of->layout.row_bytes, height = of->layout.height,
                 n = height * of->layout.n_samples;
    const bool packed = of->bytes[2] == 1;
    if (of->length < SGI_HEAD + n * (packed ? 8 : row))
        return false;
    for (size_t i = 0; i < n; i++) {
        const size_t channel = i / height, y = height - 1 - i % height;
        unsigned char *to = of->out + FIRST + (channel * height + y) * row;
        const unsigned char *starts = of->bytes + SGI_HEAD + 4 * i;
        if (!packed)
            memcpy(to, of->bytes + SGI_HEAD + i * row, row);
        else if (!sgi_unpack(of, number_at(starts, 4), number_at(starts + 4 * n, 4), to))
            return false;
    }
    return true;
}

static bool read_sgi(struct foreign *of, struct error *err)
{
    const unsigned char *head = of->bytes;
    struct sample_layout *to = &of->layout;
    if (of->length < SGI_HEAD)
        return refuse(of, "the SGI file is shorter than its header", err);
    const uint32_t dimensions = number_at(head + 4, 2);
    to->bits = (uint16_t)(8 * head[3]);
    to->width = number_at(head + 6, 2);
    to->height = dimensions < 2 ? 1 : number_at(head + 8, 2);
    to->n_samples = dimensions < 3 ? 1 : (uint16_t)number_at(head + 10, 2);
    if (head[2] > 1 || head[3] - 1u > 1 || dimensions - 1 > 2 || to->n_samples - 1u > 3 ||
        number_at(head + 104, 4) != 0)
        return refuse(of,
                      "expected an SGI file of grey or RGB, of 8 or 16 bits, without a colour "
                      "map",
                      err);
    return allocate(of, true, err) &&
           (sgi_rows(of) || refuse(of, "the SGI file is damaged or was cut", err));
}

/* ---- both ---- */

bool image_converts(const char *format)
{
    return strcmp(format, "PNG") == 0 || strcmp(format, "SGI") == 0;
}

/* Describes the picture as the only page of the image. */
static bool describe(struct image *image, struct foreign *of, struct error *err)
{
    struct sample_layout *layout = &of->layout;
    layout->gamma = layout->gamma == 1 ? 0 : layout->gamma;
    image->width = (int)layout->width;
    image->height = (int)layout->height;
    image->coloured = layout->n_colours > 1;
    snprintf(image->no_wavelengths, sizeof image->no_wavelengths, "records no wavelengths");
    image->description = printed_take(&of->description, err);
    return image->description && string_copy("", &image->verdict, err) &&
           array_add(&image->file->pages, &image->n_pages, layout, sizeof *layout, err);
}

bool foreign_read(struct image *image, const char *format, struct error *err)
{
    struct image_file *file = image->file;
    struct foreign of = {.image = image, .length = (size_t)image->bytes};
    const bool done = MAKE_ARRAY(of.bytes, image->bytes + 1, err, "the bytes of %s", image->path) &&
                      (client_bytes(&file->client, of.bytes, of.length, 0) == (ssize_t)of.length ||
                       error_system(err, "cannot read %s", image->path)) &&
                      (strcmp(format, "PNG") == 0 ? read_png(&of, err) : read_sgi(&of, err)) &&
                      describe(image, &of, err);
    file->pixels = of.out;
    file->converted = (struct builtin_file){image->path, of.out, of.out_length};
    file->client.builtin = &file->converted;
    FREE_ALL(of.bytes, of.description.text);
    return done;
}
