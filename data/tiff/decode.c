/* SPDX-License-Identifier: MIT */
/* Reads the samples of pages, some rows at a time. */
#include <float.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>

#include "data/tiff/tiff.h"
#include "spectral.h"

/* Rows of a page that are being read, block by block. */
struct page_rows {
    const struct image *image;
    int page;
    struct sample_layout layout;
    uint32_t first, end; /* the rows */
    float *out;          /* NULL: samples of several bands are kept as they are */
    char *blocks;        /* the block that was read last, of each plane that is needed */
};
/* Pixels of a row that lie in one block. */
struct run {
    uint32_t x, y, n;
    size_t in_block; /* the index of the first of them there */
    size_t in_rows;  /* and among the pixels of all rows that are read */
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

/* Reads the block that begins with row `top` as it lies in the file. */
static bool block_copy(const struct page_rows *of, uint32_t top, struct error *err)
{
    const struct sample_layout *layout = &of->layout;
    const bool swapped = TIFFIsByteSwapped(of->image->file->tiff);
    const uint32_t left = of->end - top;
    const size_t rows = left < layout->block_height ? left : layout->block_height;
    const size_t length = rows * layout->row_bytes;
    for (uint16_t plane = 0; plane < layout->n_planes; plane++) {
        void *block = of->blocks + plane * layout->block_bytes;
        const uint64_t row = (uint64_t)(layout->plane + plane) * layout->height + top;
        if (!bytes_read(of->image, layout->rows_offset + row * layout->row_bytes, length, block))
            return image_refuse(of->image, of->page, err, "its row %" PRIu32 " cannot be read",
                                top);
        if (swapped && layout->bits == 16)
            TIFFSwabArrayOfShort(block, (tmsize_t)(length / 2));
        if (swapped && layout->bits == 32)
            TIFFSwabArrayOfLong(block, (tmsize_t)(length / 4));
    }
    return true;
}

/* Decodes the block at column x and row y. */
static bool block_decode(const struct page_rows *of, uint32_t x, uint32_t y, struct error *err)
{
    TIFF *tiff = of->image->file->tiff;
    for (uint16_t i = 0; i < of->layout.n_planes; i++) {
        char *block = of->blocks + i * of->layout.block_bytes;
        const uint16_t plane = (uint16_t)(of->layout.plane + i);
        const tmsize_t got =
            of->layout.tiled
                ? TIFFReadTile(tiff, block, x, y, 0, plane)
                : TIFFReadEncodedStrip(tiff, TIFFComputeStrip(tiff, y, plane), block, -1);
        if (got < 0 || of->image->file->message[0] != '\0')
            return image_refuse_broken(of->image, of->page, err);
    }
    return true;
}

/* Counts of 16 bits, as in a stack of our own, several at once: pixel_value times the scale. */
static void counts_place(const uint16_t *counts, uint32_t n, double scale, float *restrict out)
{
    for (uint32_t i = 0; i < n; i++)
        out[i] = (float)(counts[i] / 65535.0 * scale);
}

static bool run_place(const struct page_rows *of, const struct run *run, struct error *err)
{
    float *out = of->out + run->in_rows;
    for (uint32_t i = 0; i < run->n; i++) {
        const double value =
            pixel_value(&of->layout, of->blocks, run->in_block + i) * of->image->scale;
        if (!(value >= 0 && value <= (double)FLT_MAX))
            return image_refuse(of->image, of->page, err,
                                "the radiance at column %" PRIu32 ", row %" PRIu32
                                " is %g; it is finite and not negative",
                                run->x + i, run->y, value);
        out[i] = (float)value;
    }
    return true;
}

static void pick(char *out, const char *in, uint32_t n, size_t step, size_t bytes)
{
    for (uint32_t i = 0; i < n; i++)
        memcpy(out + i * bytes, in + i * step * bytes, bytes);
}

/* Copies the samples of each band that is kept. */
static void run_keep(const struct page_rows *of, const struct run *run)
{
    const struct kept_bands *kept = &of->image->file->kept;
    const size_t plane = (size_t)(kept->end_row - kept->first_row) * of->layout.width;
    const size_t step = of->layout.pixel_step, bytes = of->layout.bits / 8u;
    for (int page = kept->first_page; page < kept->end_page; page++) {
        const char *in = of->blocks + (run->in_block * step + (size_t)page) * bytes;
        char *out =
            kept->samples + ((size_t)(page - kept->first_page) * plane + run->in_rows) * bytes;
        if (bytes == 1) /* known sizes are copied without a call */
            pick(out, in, run->n, step, 1);
        else if (bytes == 2)
            pick(out, in, run->n, step, 2);
        else
            pick(out, in, run->n, step, 4);
    }
}

/* Writes the pixels of the block at column x and row `top`, as far as they are asked for. */
static bool block_place(const struct page_rows *of, uint32_t x, uint32_t top, struct error *err)
{
    const struct sample_layout *layout = &of->layout;
    const double scale = of->image->scale;
    const bool counts = layout->bits == 16 && layout->n_colours == 1 && layout->pixel_step == 1 &&
                        !layout->inverted && scale <= (double)FLT_MAX;
    const uint32_t left = layout->width - x, below = of->end - top;
    const uint32_t end = top + (below < layout->block_height ? below : layout->block_height);
    struct run run = {.x = x, .n = left < layout->block_width ? left : layout->block_width};
    for (run.y = top > of->first ? top : of->first; run.y < end; run.y++) {
        run.in_block = (size_t)(run.y - top) * layout->block_width;
        run.in_rows = (size_t)(run.y - of->first) * layout->width + x;
        if (of->out == NULL)
            run_keep(of, &run);
        else if (counts)
            counts_place((const uint16_t *)(const void *)of->blocks + run.in_block, run.n, scale,
                         of->out + run.in_rows);
        else if (!run_place(of, &run, err))
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
static void fit_blocks(struct sample_layout *layout, uint32_t rows)
{
    const size_t most = (size_t)1 << 18, fitting = most / layout->row_bytes;
    layout->block_height = fitting < 1 ? 1 : fitting < rows ? (uint32_t)fitting : rows;
    layout->block_bytes = layout->block_height * layout->row_bytes;
    if (layout->n_planes > 1)
        layout->colour_step = layout->block_bytes / (layout->bits / 8u);
}

/* Reads from the block at row `top` on, block by block. */
static bool blocks_read(const struct page_rows *of, uint32_t top, struct error *err)
{
    const struct sample_layout *layout = &of->layout;
    bool good = true;
    for (; good && top < of->end; top += layout->block_height)
        for (uint32_t x = 0; good && x < layout->width; x += layout->block_width)
            good = (layout->rows_offset > 0 ? block_copy(of, top, err)
                                            : block_decode(of, x, top, err)) &&
                   block_place(of, x, top, err);
    return good;
}

static bool rows_read(struct page_rows *of, struct error *err)
{
    struct image_file *file = of->image->file;
    if (!page_turn(of->image, of->page, err))
        return false;
    uint32_t top = of->first / of->layout.block_height * of->layout.block_height;
    if (of->layout.rows_offset > 0) {
        fit_blocks(&of->layout, of->end - of->first);
        top = of->first;
    }
    of->blocks = calloc(of->layout.n_planes, of->layout.block_bytes);
    if (of->blocks == NULL)
        return error_memory(err);
    file->message[0] = '\0';
    file->decoding = true;
    const bool good = blocks_read(of, top, err);
    file->decoding = false;
    free(of->blocks);
    return good;
}

/* Keeps the wanted rows of the page, a band, and of as many that follow as there is room for. */
static bool bands_keep(const struct page_rows *wanted, struct error *err)
{
    const size_t room = (size_t)1 << 28; /* but for one band of them */
    const struct sample_layout *layout = &wanted->layout;
    struct kept_bands *kept = &wanted->image->file->kept;
    const int page = wanted->page;
    const size_t bytes = (size_t)(wanted->end - wanted->first) * layout->width * (layout->bits / 8);
    const size_t fitting = bytes < room ? room / bytes : 1;
    const size_t left = (size_t)(wanted->image->n_pages - page);
    const size_t n = fitting < left ? fitting : left;
    struct page_rows all = *wanted;
    if (page >= kept->first_page && page < kept->end_page && wanted->first >= kept->first_row &&
        wanted->end <= kept->end_row)
        return true;
    free(kept->samples);
    *kept = (struct kept_bands){wanted->first, wanted->end, page, page + (int)n, malloc(n * bytes)};
    all.out = NULL;
    if ((kept->samples != NULL || error_memory(err)) && rows_read(&all, err))
        return true;
    free(kept->samples);
    *kept = (struct kept_bands){.samples = NULL};
    return false;
}

/* Kept samples are a block of one band. */
static bool kept_place(struct page_rows *of, struct error *err)
{
    const struct kept_bands *kept = &of->image->file->kept;
    struct sample_layout *layout = &of->layout;
    const size_t rows = (size_t)(of->page - kept->first_page) * (kept->end_row - kept->first_row) +
                        of->first - kept->first_row;
    layout->block_width = layout->width;
    layout->block_height = of->end - of->first;
    layout->pixel_step = 1;
    of->blocks = kept->samples + rows * layout->width * (layout->bits / 8);
    return block_place(of, 0, of->first, err);
}

bool image_read(struct image *image, int page, int y, int rows, float *out, struct error *err)
{
    struct page_rows of = {.image = image,
                           .page = page,
                           .layout = image->file->pages[page].layout,
                           .first = (uint32_t)y,
                           .end = (uint32_t)(y + rows),
                           .out = out};
    if (of.layout.n_bands == 1 || of.layout.pixel_step == 1)
        return rows_read(&of, err);
    return bands_keep(&of, err) && kept_place(&of, err);
}
