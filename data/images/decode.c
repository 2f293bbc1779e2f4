/* SPDX-License-Identifier: MIT */
/* Reads the samples of pages in two steps: first some rows as they are stored, then the values of
 * these rows. Rows that lie one after the other, as in stacks of this program, are read straight
 * from the file. libtiff decodes all other rows, strip by strip or tile by tile. */
#include <float.h>
#include <inttypes.h>
#include <tiffio.h>

#include "data/images/inside.h"

/* Some rows of a page as stored: the rows of the first plane, then those of the next. */
struct stored_rows {
    const struct image *image;
    int page;
    const struct sample_layout *layout; /* of this page */
    uint32_t first, n;
    char *samples, *tile;
};

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* ---- rows as stored ---- */

bool image_read_bytes(const struct image *image, uint64_t offset, size_t length, void *out,
                      struct error *err)
{
    errno = 0;
    return client_bytes(&image->file->client, out, length, offset) == (ssize_t)length ||
           image_refuse(image, -1, err, "its byte %" PRIu64 " cannot be read", offset);
}

/* Reads rows that lie one after the other. */
static bool rows_copy(const struct stored_rows *of, uint16_t plane, void *out, struct error *err)
{
    const struct sample_layout *layout = of->layout;
    TIFF *tiff = of->image->tiff; /* NULL: samples of another format are big-endian */
    const bool swapped = tiff ? TIFFIsByteSwapped(tiff) : !machine_is_big_endian();
    const size_t length = of->n * layout->row_bytes;
    const uint64_t before = (uint64_t)plane * layout->height + of->first;
    if (client_bytes(&of->image->file->client, out, length,
                     layout->rows_offset + before * layout->row_bytes) != (ssize_t)length)
        return image_refuse(of->image, of->page, err, "its row %" PRIu32 " cannot be read",
                            of->first);
    if (swapped && layout->bits == 16)
        TIFFSwabArrayOfShort(out, (tmsize_t)(length / 2));
    if (swapped && layout->bits == 32)
        TIFFSwabArrayOfLong(out, (tmsize_t)(length / 4));
    return true;
}

bool block_is_missing(TIFF *tiff, uint32_t block)
{
    return TIFFGetStrileOffset(tiff, block) == 0 && TIFFGetStrileByteCount(tiff, block) == 0;
}

/* Refuses a block that ends behind the file, or for which libtiff needs more memory than is left.
 */
static bool block_fits(const struct stored_rows *of, uint32_t block, struct error *err)
{
    const struct image_file *file = of->image->file;
    const uint64_t stored = TIFFGetStrileByteCount(of->image->tiff, block),
                   bytes = of->image->bytes;
    if (stored > bytes || TIFFGetStrileOffset(of->image->tiff, block) > bytes - stored)
        return image_refuse(of->image, of->page, err, "its pixels end beyond the end of the file");
    return stored < 1 << 20 ||
           memory_suffices((double)stored, file->from, err, "%s: a block of its page %d",
                           of->image->path, of->page + 1);
}

/* Decodes the first bytes of a tile or a strip. One that is missing holds zeros. Refuses the page
 * if libtiff returns a negative number or prints a message. */
static bool block_decode(const struct stored_rows *of, uint32_t block, char *out, size_t bytes,
                         struct error *err)
{
    TIFF *tiff = of->image->tiff;
    if (!block_fits(of, block, err))
        return false;
    memset(out, 0, bytes);
    if (block_is_missing(tiff, block))
        return true;
    const tmsize_t got = (of->layout->tiled ? TIFFReadEncodedTile : TIFFReadEncodedStrip)(
        tiff, block, out, (tmsize_t)bytes);
    return source_is_sound(of->image, err) &&
           ((got >= 0 && of->image->file->client.message[0] == '\0') ||
            image_refuse_broken(of->image, of->page, err));
}

/* Decodes the tiles that contain the rows, and joins them. */
static bool tiles_decode(const struct stored_rows *of, uint16_t plane, char *out, struct error *err)
{
    const struct sample_layout *layout = of->layout;
    const size_t pixel_bytes = layout->row_bytes / layout->width;
    for (uint32_t x = 0; x < layout->width; x += layout->block_width) {
        const size_t length = least(layout->width - x, layout->block_width) * pixel_bytes;
        if (!block_decode(of, TIFFComputeTile(of->image->tiff, x, of->first, 0, plane), of->tile,
                          (size_t)layout->block_bytes, err))
            return false;
        for (uint32_t row = 0; row < of->n; row++)
            memcpy(out + row * layout->row_bytes + x * pixel_bytes,
                   of->tile + row * layout->block_width * pixel_bytes, length);
    }
    return true;
}

/* Reads row y and rows below it: as many as there is room for, at most up to `end`. Reads a strip
 * or a tile as a whole. */
static bool rows_read(struct stored_rows *of, uint32_t y, uint32_t end, struct error *err)
{
    const struct sample_layout *layout = of->layout;
    const bool plain = layout->rows_offset > 0;
    bool good = true;
    of->first = plain ? y : y - y % layout->block_height;
    of->n = (uint32_t)least((plain ? end : layout->height) - of->first, layout->block_height);
    for (uint16_t i = 0; good && i < layout->n_planes; i++) {
        const uint16_t plane = (uint16_t)(layout->plane + i);
        char *out = of->samples + i * of->n * layout->row_bytes;
        good = plain ? rows_copy(of, plane, out, err)
               : layout->tiled
                   ? tiles_decode(of, plane, out, err)
                   : block_decode(of, TIFFComputeStrip(of->image->tiff, of->first, plane), out,
                                  of->n * layout->row_bytes, err);
    }
    return good;
}

/* Goes to the page's directory, if libtiff decodes its rows, and sets again how it decodes. */
static bool page_turn(const struct image *image, int page, struct error *err)
{
    struct image_file *file = image->file;
    const struct sample_layout *known = &file->pages[page];
    struct sample_layout found;
    if (known->rows_offset > 0 || file->directory == known->directory)
        return true;
    file->directory = 0;
    if (!TIFFSetSubDirectory(image->tiff, known->directory))
        return image_refuse_broken(image, page, err);
    if (!image_layout(image, page, &found, err))
        return false;
    if (found.width != known->width || found.height != known->height || found.bits != known->bits ||
        found.n_samples != known->n_samples || found.block_bytes != known->block_bytes ||
        found.rows_offset > 0)
        return image_refuse(image, page, err, "it has changed since the file was opened");
    file->directory = known->directory;
    return true;
}

/* ---- values ---- */

/* Returns a linear sample. */
static double sample_at(const struct sample_layout *layout, const void *samples, size_t at)
{
    const double stored = layout->bits == 8    ? ((const uint8_t *)samples)[at]
                          : layout->bits == 16 ? ((const uint16_t *)samples)[at]
                                               : (double)((const float *)samples)[at];
    const double largest = layout->largest;
    return layout->gamma == 0 ? stored : largest * linear_value(layout->gamma, stored / largest);
}

/* Returns a value from 0 to 1, or a float sample. The sum of RGB is a whole number, so that three
 * equal samples give exactly the value of one. */
static double pixel_value(const struct stored_rows *of, const struct sample_layout *layout,
                          size_t pixel)
{
    static const int grey[] = {1};
    static const int colours[][3] = {
        /* ITU-R BT.709-6, item 3.2, in 1/10000; one colour alone; all */
        {2126, 7152, 722},
        {1, 0, 0},
        {0, 1, 0},
        {0, 0, 1},
        [MEAN_COLOUR] = {1, 1, 1}};
    const size_t at = pixel * layout->pixel_step + layout->sample;
    const double first = sample_at(layout, of->samples, at);
    if (layout->has_nodata && (first == layout->nodata || (isnan(first) && isnan(layout->nodata))))
        return 0;
    const int *parts = layout->n_colours == 1 ? grey : colours[layout->colour];
    const size_t colour_step = layout->n_planes > 1 ? (size_t)of->n * layout->width : 1;
    double sum = 0, white = 0;
    for (size_t i = 0; i < layout->n_colours; i++) {
        sum += parts[i] * sample_at(layout, of->samples, at + i * colour_step);
        white += parts[i] * layout->largest;
    }
    return (layout->inverted ? white - sum : sum) / white;
}

/* Writes pixel_value times the scale for grey counts of 16 bits. The loop is simple enough for the
 * compiler to convert several at once. */
static void counts_place(const uint16_t *counts, size_t n, double scale, float *restrict out)
{
    for (size_t i = 0; i < n; i++)
        out[i] = (float)(counts[i] / 65535.0 * scale);
}

/* Writes the values of n rows from row y on, which have been read. The page may be another band of
 * these rows. */
static void values_place(const struct stored_rows *of, int page, uint32_t y, uint32_t n, float *out)
{
    const struct sample_layout *layout = &of->image->file->pages[page];
    const size_t width = layout->width, before = (y - of->first) * width;
    const double scale = of->image->scale;
    if (layout->bits == 16 && layout->n_colours == 1 && layout->pixel_step == 1 &&
        !layout->inverted && !layout->has_nodata && layout->gamma == 0)
        counts_place((const uint16_t *)(const void *)of->samples + before, n * width, scale, out);
    else
        for (size_t i = 0; i < n * width; i++)
            out[i] = (float)(pixel_value(of, layout, before + i) * scale);
}

static bool values_check(const struct image *image, const struct page_rows *of, struct error *err)
{
    const size_t width = image->file->pages->width;
    if (image->file->pages->bits < 32 && image->scale <= (double)FLT_MAX)
        return true; /* whole numbers are neither negative nor too large */
    for (size_t i = 0; i < of->n * width; i++)
        if (!(of->values[i] >= 0 && of->values[i] <= FLT_MAX))
            return image_refuse(
                image, of->page, err,
                "the value at column %zu, row %zu is %g; expected a finite number that"
                " is not negative",
                i % width, of->y + i / width, (double)of->values[i]);
    return true;
}

/* ---- reading ---- */

/* Allocates room for stored rows, if n are wanted, and for a tile. */
static bool rows_allocate(struct stored_rows *of, uint32_t n, struct error *err)
{
    const struct sample_layout *layout = of->layout;
    const size_t rows = least(layout->block_height, layout->rows_offset > 0 ? n : layout->height);
    const double bytes = (double)layout->row_bytes * (double)rows * layout->n_planes;
    return memory_suffices(bytes + (layout->tiled ? (double)layout->block_bytes : 0),
                           of->image->file->from, err, "%s: a block of its page %d",
                           of->image->path, of->page + 1) &&
           MAKE_ARRAY(of->samples, bytes, err, "rows of %s", of->image->path) &&
           (!layout->tiled ||
            MAKE_ARRAY(of->tile, layout->block_bytes, err, "a tile of %s", of->image->path));
}

/* Reads rows of pages, which have the same samples: they are bands of the same rows, or one page.
 */
static bool values_read(const struct image *image, const struct page_rows *to, struct error *err)
{
    struct image_file *file = image->file;
    struct stored_rows of = {.image = image, .page = to->page, .layout = &file->pages[to->page]};
    const size_t width = of.layout->width;
    const uint32_t end = to->y + to->n;
    errno = 0;
    bool good = page_turn(image, to->page, err) && rows_allocate(&of, to->n, err);
    file->client.message[0] = '\0';
    file->client.decoding = true;
    for (uint32_t y = to->y, n; good && y < end; y += n) {
        float *out = to->values + (y - to->y) * width;
        good = rows_read(&of, y, end, err);
        n = (uint32_t)least(of.first + of.n, end) - y;
        for (int page = to->page; good && page < to->end_page; page++, out += to->n * width)
            values_place(&of, page, y, n, out);
    }
    file->client.decoding = false;
    FREE_ALL(of.samples, of.tile);
    return good;
}

/* Reads rows of a band, and keeps those of as many bands behind it as there is room for: in the
 * file the bands lie side by side. */
static bool band_read(const struct image *image, const struct page_rows *to, struct error *err)
{
    const size_t room = (size_t)1 << 28; /* or one band, if that is larger */
    struct page_rows *kept = &image->file->kept;
    const size_t size = to->n * (size_t)image->width, bytes = size * sizeof(float);
    if (to->page < kept->page || to->page >= kept->end_page || to->y != kept->y ||
        to->n != kept->n) {
        const size_t bands =
            least(bytes < room ? room / bytes : 1, (size_t)(image->n_pages - to->page));
        free(kept->values);
        *kept = (struct page_rows){to->y, to->n, to->page, to->page + (int)bands, NULL};
        if (!MAKE_ARRAY(kept->values, bands * size, err, "bands of %s", image->path) ||
            !values_read(image, kept, err)) {
            kept->end_page = to->page;
            return false;
        }
    }
    memcpy(to->values, kept->values + (size_t)(to->page - kept->page) * size, bytes);
    return true;
}

bool image_read(struct image *image, int page, int y, int rows, float *out, struct error *err)
{
    const struct sample_layout *layout = &image->file->pages[page];
    const struct page_rows to = {(uint32_t)y, (uint32_t)rows, page, page + 1, out};
    const bool side_by_side = layout->n_bands > 1 && layout->pixel_step > 1;
    return (side_by_side ? band_read : values_read)(image, &to, err) &&
           values_check(image, &to, err);
}

/* ---- raw samples ---- */

/* Refuses a page whose samples cannot be described by themselves. */
static bool page_is_raw(const struct image *image, int page, struct error *err)
{
    const struct sample_layout *layout = &image->file->pages[page];
    const char *why = layout->n_colours > 1      ? "is coloured"
                      : layout->inverted         ? "stores white as 0"
                      : layout->rows_offset == 0 ? "is compressed, in tiles, or in strips with gaps"
                      : layout->pixel_step > layout->n_bands ? "has an alpha"
                                                             : NULL;
    return !why || error_usage(err,
                               "%s: page %d %s; an ENVI header describes raw grey samples without"
                               " gaps, as spectral render writes them",
                               image->path, page + 1, why);
}

bool image_describe(const struct image *image, struct raw_samples *out, struct error *err)
{
    const struct sample_layout *first = image->file->pages;
    const bool by_pages = first->n_bands == 1;
    uint64_t expected = first->rows_offset;
    for (int page = 0; page < image->n_pages; page++) {
        const struct sample_layout *layout = &image->file->pages[page];
        if (!page_is_raw(image, page, err))
            return false;
        if (by_pages && layout->rows_offset != expected)
            return error_usage(err,
                               "%s: page %d begins at byte %" PRIu64 "; an ENVI header needs pages"
                               " without gaps, and so expects it at byte %" PRIu64,
                               image->path, page + 1, layout->rows_offset, expected);
        expected += (uint64_t)layout->row_bytes * layout->height;
    }
    *out = (struct raw_samples){first->rows_offset, first->bits, first->pixel_step > 1,
                                TIFFIsBigEndian(image->tiff) != 0};
    return true;
}
