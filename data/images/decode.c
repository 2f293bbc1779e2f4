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
    struct sample_layout layout;
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
    const struct sample_layout *layout = &of->layout;
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

/* Refuses the page if libtiff returned a negative number or printed a message. */
static bool is_decoded(const struct stored_rows *of, tmsize_t got, struct error *err)
{
    return source_is_sound(of->image, err) &&
           ((got >= 0 && of->image->file->client.message[0] == '\0') ||
            image_refuse_broken(of->image, of->page, err));
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

/* Decodes the first bytes of a tile or a strip. One that is missing holds zeros. */
static bool block_decode(const struct stored_rows *of, uint32_t block, char *out, size_t bytes,
                         struct error *err)
{
    TIFF *tiff = of->image->tiff;
    if (!block_fits(of, block, err))
        return false;
    memset(out, 0, bytes);
    return block_is_missing(tiff, block) ||
           is_decoded(of,
                      (of->layout.tiled ? TIFFReadEncodedTile
                                        : TIFFReadEncodedStrip)(tiff, block, out, (tmsize_t)bytes),
                      err);
}

/* Decodes the tiles that contain the rows, and joins them. */
static bool tiles_decode(const struct stored_rows *of, uint16_t plane, char *out, struct error *err)
{
    const struct sample_layout *layout = &of->layout;
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
    const struct sample_layout *layout = &of->layout;
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

static double stored_at(const struct sample_layout *layout, const void *samples, size_t at)
{
    if (layout->bits == 8)
        return ((const uint8_t *)samples)[at];
    return layout->bits == 16 ? ((const uint16_t *)samples)[at]
                              : (double)((const float *)samples)[at];
}

/* Returns a linear sample. */
static double sample_at(const struct sample_layout *layout, const void *samples, size_t at)
{
    const double stored = stored_at(layout, samples, at), largest = layout->largest;
    return layout->gamma == 0 ? stored : largest * linear_value(layout->gamma, stored / largest);
}

/* Returns a value from 0 to 1, or a float sample. The sum of RGB is a whole number, so that three
 * equal samples give exactly the value of one. */
static double pixel_value(const struct stored_rows *of, size_t pixel)
{
    static const int grey[] = {1};
    static const int colours[][3] = {/* ITU-R BT.709-6, item 3.2, in 1/10000; one colour alone */
                                     {2126, 7152, 722},
                                     {1, 0, 0},
                                     {0, 1, 0},
                                     {0, 0, 1}};
    const struct sample_layout *layout = &of->layout;
    const double first = sample_at(layout, of->samples, pixel * layout->pixel_step);
    if (layout->has_nodata && (first == layout->nodata || (isnan(first) && isnan(layout->nodata))))
        return 0;
    const int *parts = layout->n_colours == 1 ? grey : colours[layout->colour];
    const size_t colour_step = layout->n_planes > 1 ? (size_t)of->n * layout->width : 1;
    double sum = 0, white = 0;
    for (size_t i = 0; i < layout->n_colours; i++) {
        sum +=
            parts[i] * sample_at(layout, of->samples, i * colour_step + pixel * layout->pixel_step);
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

/* Writes the values of n rows from row y on. These rows have been read. */
static bool values_place(const struct stored_rows *of, uint32_t y, uint32_t n, float *out,
                         struct error *err)
{
    const struct sample_layout *layout = &of->layout;
    const size_t width = layout->width, before = (y - of->first) * width;
    const double scale = of->image->scale;
    if (layout->bits == 16 && layout->n_colours == 1 && layout->pixel_step == 1 &&
        !layout->inverted && !layout->has_nodata && layout->gamma == 0 &&
        scale <= (double)FLT_MAX) {
        counts_place((const uint16_t *)(const void *)of->samples + before, n * width, scale, out);
        return true;
    }
    for (size_t i = 0; i < n * width; i++) {
        const double value = pixel_value(of, before + i) * scale;
        if (!(value >= 0 && value <= (double)FLT_MAX))
            return image_refuse(
                of->image, of->page, err,
                "the radiance at column %zu, row %zu is %g; expected a finite number that"
                " is not negative",
                i % width, y + i / width, value);
        out[i] = (float)value;
    }
    return true;
}

/* ---- bands side by side ---- */

static char *band_at(const struct kept_bands *kept, int band)
{
    return kept->samples + (size_t)(band - kept->first_page) * kept->band_bytes;
}

/* Copies n rows from row y on, which have been read, into each band that is kept. */
static void bands_place(const struct stored_rows *of, uint32_t y, uint32_t n)
{
    const struct kept_bands *kept = &of->image->file->kept;
    const size_t width = of->layout.width, step = of->layout.pixel_step;
    const size_t bytes = of->layout.bits / 8u;
    for (uint32_t row = y; row < y + n; row++)
        for (int band = kept->first_page; band < kept->end_page; band++) {
            const char *in =
                of->samples + ((row - of->first) * width * step + (size_t)band) * bytes;
            char *out = band_at(kept, band) + (row - kept->first_row) * width * bytes;
            for (size_t i = 0; i < width; i++)
                memcpy(out + i * bytes, in + i * step * bytes, bytes);
        }
}

/* ---- reading ---- */

/* Allocates room for stored rows, if n are wanted, and for a tile. */
static bool rows_allocate(struct stored_rows *of, uint32_t n, struct error *err)
{
    const struct sample_layout *layout = &of->layout;
    const size_t rows = least(layout->block_height, layout->rows_offset > 0 ? n : layout->height);
    const double bytes = (double)layout->row_bytes * (double)rows * layout->n_planes;
    return memory_suffices(bytes + (layout->tiled ? (double)layout->block_bytes : 0),
                           of->image->file->from, err, "%s: a block of its page %d",
                           of->image->path, of->page + 1) &&
           MAKE_ARRAY(of->samples, bytes, err, "rows of %s", of->image->path) &&
           (!layout->tiled ||
            MAKE_ARRAY(of->tile, layout->block_bytes, err, "a tile of %s", of->image->path));
}

/* Reads n rows of a page from row y on into `out`, or, if that is NULL, into the kept bands. */
static bool page_read(struct stored_rows *of, uint32_t y, uint32_t n, float *out, struct error *err)
{
    const struct sample_layout *layout = &of->layout;
    struct image_file *file = of->image->file;
    const uint32_t first = y, end = y + n;
    errno = 0;
    bool good = page_turn(of->image, of->page, err) && rows_allocate(of, n, err);
    file->client.message[0] = '\0';
    file->client.decoding = true;
    for (; good && y < end; y += n) {
        good = rows_read(of, y, end, err);
        n = (uint32_t)least(of->first + of->n, end) - y;
        if (good && out == NULL)
            bands_place(of, y, n);
        else if (good)
            good = values_place(of, y, n, out + (y - first) * (size_t)layout->width, err);
    }
    file->client.decoding = false;
    FREE_ALL(of->samples, of->tile);
    return good;
}

/* Keeps n rows from row y on of a band, and of as many bands behind it as there is room for. */
static bool bands_keep(struct stored_rows of, uint32_t y, uint32_t n, struct error *err)
{
    const size_t room = (size_t)1 << 28; /* or one band, if that is larger */
    struct kept_bands *kept = &of.image->file->kept;
    const size_t bytes = (size_t)n * of.layout.width * (of.layout.bits / 8);
    const size_t bands =
        least(bytes < room ? room / bytes : 1, (size_t)(of.image->n_pages - of.page));
    if (of.page >= kept->first_page && of.page < kept->end_page && y >= kept->first_row &&
        y + n <= kept->first_row + kept->n_rows)
        return true;
    free(kept->samples);
    *kept = (struct kept_bands){y, n, of.page, of.page + (int)bands, bytes, NULL};
    if (MAKE_ARRAY(kept->samples, (uint64_t)bands * bytes, err, "bands of %s", of.image->path) &&
        page_read(&of, y, n, NULL, err))
        return true;
    free(kept->samples);
    *kept = (struct kept_bands){.samples = NULL};
    return false;
}

bool image_read(struct image *image, int page, int y, int rows, float *out, struct error *err)
{
    const struct kept_bands *kept = &image->file->kept;
    const uint32_t first = (uint32_t)y, n = (uint32_t)rows;
    struct stored_rows of = {.image = image, .page = page, .layout = image->file->pages[page]};
    if (of.layout.n_bands == 1 || of.layout.pixel_step == 1)
        return page_read(&of, first, n, out, err);
    if (!bands_keep(of, first, n, err))
        return false;
    of.layout.pixel_step = 1;
    of.first = kept->first_row;
    of.n = kept->n_rows;
    of.samples = band_at(kept, page);
    return values_place(&of, first, n, out, err);
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
