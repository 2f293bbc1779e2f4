/* SPDX-License-Identifier: MIT */
/* Reads the samples of pages, some rows at a time. */
#include <float.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>

#include "data/tiff/tiff.h"
#include "spectral.h"

/* Those of a page that are asked for. */
struct rows {
    uint32_t first, end;
    float *out; /* NULL: their samples are kept as they are, of several bands */
};

/* A sample as stored. */
static double sample_at(const struct sample_layout *layout, const void *samples, size_t at)
{
    if (layout->bits == 8)
        return ((const uint8_t *)samples)[at];
    return layout->bits == 16 ? ((const uint16_t *)samples)[at]
                              : (double)((const float *)samples)[at];
}

/* 0 to 1, or a float sample. The sum of RGB is a whole number: grey of the three gives the grey. */
static double pixel_value(const struct sample_layout *layout, const char *blocks, size_t pixel)
{
    static const int grey[] = {1};
    static const int luma[] = {2126, 7152, 722}; /* ITU-R BT.709-6, item 3.2, in 1/10000 */
    const int *parts = layout->n_colours == 1 ? grey : luma;
    double sum = 0, white = 0;
    for (size_t i = 0; i < layout->n_colours; i++) {
        const size_t at = i * layout->colour_step + pixel * layout->pixel_step;
        sum += parts[i] * sample_at(layout, blocks, at);
        white += parts[i] * layout->largest;
    }
    return (layout->inverted ? white - sum : sum) / white;
}

static bool bytes_read(const struct image *image, uint64_t offset, size_t length, void *out)
{
    TIFF *tiff = image->file->tiff;
    const thandle_t data = TIFFClientdata(tiff);
    return TIFFGetSeekProc(tiff)(data, offset, SEEK_SET) == offset &&
           TIFFGetReadProc(tiff)(data, out, (tmsize_t)length) == (tmsize_t)length;
}

bool image_read_bytes(const struct image *image, uint64_t offset, size_t length, void *out,
                      struct error *err)
{
    return bytes_read(image, offset, length, out) ||
           image_refuse(image, -1, err, "its byte %" PRIu64 " cannot be read", offset);
}

/* Reads rows top .. end - 1 as they lie in the file, of each plane that is needed. */
static bool rows_copy(const struct image *image, int page, const struct sample_layout *layout,
                      uint32_t top, uint32_t end, char *blocks, struct error *err)
{
    const bool swapped = TIFFIsByteSwapped(image->file->tiff);
    const size_t length = (end - top) * layout->row_bytes;
    for (uint16_t plane = 0; plane < layout->n_planes; plane++) {
        void *block = blocks + plane * layout->block_bytes;
        const uint64_t row = (uint64_t)(layout->plane + plane) * layout->height + top;
        if (!bytes_read(image, layout->rows_offset + row * layout->row_bytes, length, block))
            return image_refuse(image, page, err, "its row %" PRIu32 " cannot be read", top);
        if (swapped && layout->bits == 16)
            TIFFSwabArrayOfShort(block, (tmsize_t)(length / 2));
        if (swapped && layout->bits == 32)
            TIFFSwabArrayOfLong(block, (tmsize_t)(length / 4));
    }
    return true;
}

/* Decodes the block at column x and row y, of each plane that is needed. */
static bool block_decode(const struct image *image, int page, const struct sample_layout *layout,
                         uint32_t x, uint32_t y, char *blocks, struct error *err)
{
    TIFF *tiff = image->file->tiff;
    for (uint16_t i = 0; i < layout->n_planes; i++) {
        char *block = blocks + i * layout->block_bytes;
        const uint16_t plane = (uint16_t)(layout->plane + i);
        const tmsize_t got =
            layout->tiled ? TIFFReadTile(tiff, block, x, y, 0, plane)
                          : TIFFReadEncodedStrip(tiff, TIFFComputeStrip(tiff, y, plane), block, -1);
        if (got < 0 || image->file->message[0] != '\0')
            return image_refuse_broken(image, page, err);
    }
    return true;
}

/* Counts of 16 bits, as in a stack of our own, several at once: pixel_value times the scale. */
static void counts_place(const uint16_t *counts, uint32_t n, double scale, float *restrict out)
{
    for (uint32_t i = 0; i < n; i++)
        out[i] = (float)(counts[i] / 65535.0 * scale);
}

static bool row_place(const struct image *image, int page, const struct sample_layout *layout,
                      const char *blocks, size_t first, uint32_t x, uint32_t y, uint32_t n,
                      float *out, struct error *err)
{
    for (uint32_t i = 0; i < n; i++) {
        const double value = pixel_value(layout, blocks, first + i) * image->scale;
        if (!(value >= 0 && value <= (double)FLT_MAX))
            return image_refuse(image, page, err,
                                "the radiance at column %" PRIu32 ", row %" PRIu32
                                " is %g; it is finite and not negative",
                                x + i, y, value);
        out[i] = (float)value;
    }
    return true;
}

static void pick(char *out, const char *in, uint32_t n, size_t step, size_t bytes)
{
    for (uint32_t i = 0; i < n; i++)
        memcpy(out + i * bytes, in + i * step * bytes, bytes);
}

/* n pixels of each band that is kept, from `first` on in the block; they are `at` in the rows. */
static void row_keep(const struct kept_bands *kept, const struct sample_layout *layout,
                     const char *blocks, size_t first, size_t at, uint32_t n)
{
    const size_t plane = (size_t)(kept->end_row - kept->first_row) * layout->width;
    const size_t step = layout->pixel_step, bytes = layout->bits / 8u;
    for (int page = kept->first_page; page < kept->end_page; page++) {
        const char *in = blocks + (first * step + (size_t)page) * bytes;
        char *out = kept->samples + ((size_t)(page - kept->first_page) * plane + at) * bytes;
        if (bytes == 1) /* known sizes are copied without a call */
            pick(out, in, n, step, 1);
        else if (bytes == 2)
            pick(out, in, n, step, 2);
        else
            pick(out, in, n, step, 4);
    }
}

/* Writes the pixels of the block at column x and row `top`, as far as they are asked for. */
static bool block_place(const struct image *image, int page, const struct sample_layout *layout,
                        uint32_t x, uint32_t top, const char *blocks, const struct rows *wanted,
                        struct error *err)
{
    const bool counts = layout->bits == 16 && layout->n_colours == 1 && layout->pixel_step == 1 &&
                        !layout->inverted && image->scale <= (double)FLT_MAX;
    const uint32_t left = layout->width - x, below = wanted->end - top;
    const uint32_t n = left < layout->block_width ? left : layout->block_width;
    const uint32_t end = top + (below < layout->block_height ? below : layout->block_height);
    for (uint32_t y = top > wanted->first ? top : wanted->first; y < end; y++) {
        const size_t first = (size_t)(y - top) * layout->block_width;
        const size_t at = (size_t)(y - wanted->first) * layout->width + x;
        if (wanted->out == NULL)
            row_keep(&image->file->kept, layout, blocks, first, at, n);
        else if (counts)
            counts_place((const uint16_t *)(const void *)blocks + first, n, image->scale,
                         wanted->out + at);
        else if (!row_place(image, page, layout, blocks, first, x, y, n, wanted->out + at, err))
            return false;
    }
    return true;
}

/* Goes to the page's directory, if libtiff is to decode its blocks, and lets it know how. */
static bool page_turn(const struct image *image, int page, struct error *err)
{
    struct image_file *file = image->file;
    const struct sample_layout *known = &file->pages[page].layout;
    struct sample_layout found;
    if (known->rows_offset > 0 || file->directory == file->pages[page].directory)
        return true;
    file->directory = 0;
    if (!TIFFSetSubDirectory(file->tiff, file->pages[page].directory))
        return image_refuse_broken(image, page, err);
    if (!image_layout(image, page, &found, err))
        return false;
    if (found.width != known->width || found.height != known->height || found.bits != known->bits ||
        found.n_samples != known->n_samples || found.block_bytes != known->block_bytes ||
        found.rows_offset != known->rows_offset)
        return image_refuse(image, page, err, "it has changed since the file was opened");
    file->directory = file->pages[page].directory;
    return true;
}

/* Rows that are read as they lie in the file come in blocks that stay in the processor's cache. */
static struct sample_layout rows_layout(const struct sample_layout *page, uint32_t rows)
{
    const size_t most = (size_t)1 << 18, fitting = most / page->row_bytes;
    struct sample_layout layout = *page;
    layout.block_height = fitting < 1 ? 1 : fitting < rows ? (uint32_t)fitting : rows;
    layout.block_bytes = layout.block_height * layout.row_bytes;
    if (layout.n_planes > 1)
        layout.colour_step = layout.block_bytes / (layout.bits / 8u);
    return layout;
}

/* Reads the block at column x and row y in whichever way it lies. */
static bool block_read(const struct image *image, int page, const struct sample_layout *layout,
                       uint32_t x, uint32_t y, const struct rows *wanted, char *blocks,
                       struct error *err)
{
    const uint32_t left = wanted->end - y;
    const uint32_t rows = left < layout->block_height ? left : layout->block_height;
    return layout->rows_offset > 0 ? rows_copy(image, page, layout, y, y + rows, blocks, err)
                                   : block_decode(image, page, layout, x, y, blocks, err);
}

static bool rows_read(struct image *image, int page, const struct rows *wanted, struct error *err)
{
    struct image_file *file = image->file;
    bool good = true;
    if (!page_turn(image, page, err))
        return false;
    struct sample_layout layout = file->pages[page].layout;
    uint32_t top = wanted->first / layout.block_height * layout.block_height;
    if (layout.rows_offset > 0) {
        layout = rows_layout(&layout, wanted->end - wanted->first);
        top = wanted->first;
    }
    char *blocks = calloc(layout.n_planes, layout.block_bytes);
    if (blocks == NULL)
        return error_memory(err);
    file->message[0] = '\0';
    file->decoding = true;
    for (; good && top < wanted->end; top += layout.block_height)
        for (uint32_t x = 0; good && x < layout.width; x += layout.block_width)
            good = block_read(image, page, &layout, x, top, wanted, blocks, err) &&
                   block_place(image, page, &layout, x, top, blocks, wanted, err);
    file->decoding = false;
    free(blocks);
    return good;
}

/* Keeps the wanted rows of the page, a band, and of as many that follow as there is room for. */
static bool bands_keep(struct image *image, int page, const struct rows *wanted, struct error *err)
{
    const size_t room = (size_t)1 << 28; /* but for one band of them */
    const struct sample_layout *layout = &image->file->pages[page].layout;
    struct kept_bands *kept = &image->file->kept;
    const size_t bytes = (size_t)(wanted->end - wanted->first) * layout->width * (layout->bits / 8);
    const size_t fitting = bytes < room ? room / bytes : 1, left = (size_t)(image->n_pages - page);
    const size_t n = fitting < left ? fitting : left;
    const struct rows all = {wanted->first, wanted->end, NULL};
    if (page >= kept->first_page && page < kept->end_page && wanted->first >= kept->first_row &&
        wanted->end <= kept->end_row)
        return true;
    free(kept->samples);
    *kept = (struct kept_bands){wanted->first, wanted->end, page, page + (int)n, malloc(n * bytes)};
    if ((kept->samples != NULL || error_memory(err)) && rows_read(image, page, &all, err))
        return true;
    free(kept->samples);
    *kept = (struct kept_bands){.samples = NULL};
    return false;
}

/* Kept samples are a block of one band. */
static bool kept_place(const struct image *image, int page, const struct rows *wanted,
                       struct error *err)
{
    const struct kept_bands *kept = &image->file->kept;
    struct sample_layout layout = image->file->pages[page].layout;
    const size_t rows = (size_t)(page - kept->first_page) * (kept->end_row - kept->first_row) +
                        wanted->first - kept->first_row;
    layout.block_width = layout.width;
    layout.block_height = wanted->end - wanted->first;
    layout.pixel_step = 1;
    return block_place(image, page, &layout, 0, wanted->first,
                       kept->samples + rows * layout.width * (layout.bits / 8), wanted, err);
}

bool image_read(struct image *image, int page, int y, int rows, float *out, struct error *err)
{
    const struct sample_layout *layout = &image->file->pages[page].layout;
    const struct rows wanted = {(uint32_t)y, (uint32_t)(y + rows), out};
    if (layout->n_bands == 1 || layout->pixel_step == 1)
        return rows_read(image, page, &wanted, err);
    return bands_keep(image, page, &wanted, err) && kept_place(image, page, &wanted, err);
}
