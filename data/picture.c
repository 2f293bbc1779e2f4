/* SPDX-License-Identifier: MIT */
/* Writes colour pictures as TIFF 6.0 or BigTIFF: all directories first, then all pixels without
 * gaps, so that every row has a place that is known before the first one comes. RGB is one page of
 * three samples a pixel; floats are three grey pages, since ImageJ and Pillow open no other. */
#include "spectral.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>
#include <unistd.h>

/* ---- sizes ---- */

static int pages(const struct picture_options *options)
{
    return options->samples == PICTURE_FLOAT ? 3 : 1;
}

static uint64_t row_bytes(const struct picture_options *options)
{
    static const unsigned bytes[] = {[PICTURE_8] = 3, [PICTURE_16] = 6, [PICTURE_FLOAT] = 4};
    return bytes[options->samples] * (uint64_t)options->width;
}

static uint64_t page_bytes(const struct picture_options *options)
{
    return row_bytes(options) * (uint64_t)options->height;
}

/* In strips of 64 KiB, or of one longer row. */
static uint32_t rows_per_strip(const struct picture_options *options)
{
    const uint64_t rows = 65536 / row_bytes(options), all = (uint64_t)options->height;
    return (uint32_t)(rows == 0 ? 1 : rows < all ? rows : all);
}

/* ---- directories ---- */

/* Values that do not fit into their entries lie behind all directories. */
struct layout {
    const struct picture_options *options;
    uint64_t pixels_at;
    bool big;
    FILE *entries, *values;
    uint64_t values_at; /* where the next value lies in the file */
    bool failed;        /* no memory */
};

/* Entries are in the order of their tags. */
static int entry_count(const struct picture_options *options)
{
    return 14 + (options->samples == PICTURE_FLOAT ? 2 : 0) + (options->profile != NULL ? 1 : 0);
}

static size_t header_bytes(bool big)
{
    return big ? 16 : 8;
}

static size_t directory_bytes(const struct layout *layout)
{
    const size_t n = (size_t)entry_count(layout->options);
    return layout->big ? 8 + 20 * n + 8 : 2 + 12 * n + 4;
}

/* Multiples of 8, as all values are padded: a float page may be mapped into memory as it is. */
static size_t values_at(const struct layout *layout)
{
    const size_t n = (size_t)pages(layout->options);
    return (header_bytes(layout->big) + n * directory_bytes(layout) + 7) / 8 * 8;
}

static const char zeros[8];

static void put_entry(struct layout *layout, uint16_t tag, TIFFDataType type, uint64_t count,
                      const void *value)
{
    const size_t word = layout->big ? 8 : 4, size = (size_t)TIFFDataWidth(type) * (size_t)count;
    const uint16_t type_number = (uint16_t)type;
    char field[8] = {0};
    memcpy(field, size > word ? (const void *)&layout->values_at : value,
           size > word ? word : size);
    fwrite(&tag, sizeof tag, 1, layout->entries);
    fwrite(&type_number, sizeof type_number, 1, layout->entries);
    fwrite(&count, word, 1, layout->entries);
    fwrite(field, word, 1, layout->entries);
    if (size > word) {
        const size_t padding = (8 - size % 8) % 8;
        fwrite(value, size, 1, layout->values);
        fwrite(zeros, padding, 1, layout->values);
        layout->values_at += size + padding;
    }
}

static void put_short(struct layout *layout, uint16_t tag, uint16_t value)
{
    put_entry(layout, tag, TIFF_SHORT, 1, &value);
}

static void put_long(struct layout *layout, uint16_t tag, uint32_t value)
{
    put_entry(layout, tag, TIFF_LONG, 1, &value);
}

static void put_text(struct layout *layout, uint16_t tag, const char *text)
{
    put_entry(layout, tag, TIFF_ASCII, strlen(text) + 1, text);
}

/* Where the strips of a page lie, or how long they are. */
static void put_strips(struct layout *layout, uint16_t tag, int page)
{
    const struct picture_options *options = layout->options;
    const uint64_t height = (uint64_t)options->height, rows = rows_per_strip(options);
    const uint64_t n = (height + rows - 1) / rows;
    const size_t word = layout->big ? 8 : 4;
    char *strips = calloc((size_t)n, word);
    layout->failed = layout->failed || strips == NULL;
    for (uint64_t i = 0; strips != NULL && i < n; i++) {
        const uint64_t first = i * rows, left = height - first;
        const uint64_t offset =
            layout->pixels_at + (uint64_t)page * page_bytes(options) + first * row_bytes(options);
        const uint64_t length = (left < rows ? left : rows) * row_bytes(options);
        memcpy(strips + i * word, tag == TIFFTAG_STRIPOFFSETS ? &offset : &length, word);
    }
    if (strips != NULL)
        put_entry(layout, tag, layout->big ? TIFF_LONG8 : TIFF_LONG, n, strips);
    free(strips);
}

static void put_directory(struct layout *layout, int page)
{
    const struct picture_options *options = layout->options;
    const bool floating = options->samples == PICTURE_FLOAT;
    const uint16_t bits = floating ? 32 : options->samples == PICTURE_16 ? 16 : 8;
    const uint16_t format = floating ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT;
    const uint16_t n = floating ? 1 : 3, number[2] = {(uint16_t)page, (uint16_t)pages(options)};
    const uint64_t n_entries = (uint64_t)entry_count(options);
    const uint64_t next =
        header_bytes(layout->big) + (uint64_t)(page + 1) * directory_bytes(layout);
    fwrite(&n_entries, layout->big ? 8 : 2, 1, layout->entries);
    put_long(layout, TIFFTAG_SUBFILETYPE, floating ? FILETYPE_PAGE : 0);
    put_long(layout, TIFFTAG_IMAGEWIDTH, (uint32_t)options->width);
    put_long(layout, TIFFTAG_IMAGELENGTH, (uint32_t)options->height);
    put_entry(layout, TIFFTAG_BITSPERSAMPLE, TIFF_SHORT, n, (uint16_t[]){bits, bits, bits});
    put_short(layout, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
    put_short(layout, TIFFTAG_PHOTOMETRIC, floating ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
    put_text(layout, TIFFTAG_IMAGEDESCRIPTION, options->description);
    put_strips(layout, TIFFTAG_STRIPOFFSETS, page);
    put_short(layout, TIFFTAG_SAMPLESPERPIXEL, n);
    put_long(layout, TIFFTAG_ROWSPERSTRIP, rows_per_strip(options));
    put_strips(layout, TIFFTAG_STRIPBYTECOUNTS, page);
    put_short(layout, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    if (floating) {
        put_text(layout, TIFFTAG_PAGENAME, options->channels[page]);
        put_entry(layout, TIFFTAG_PAGENUMBER, TIFF_SHORT, 2, number);
    }
    put_text(layout, TIFFTAG_SOFTWARE, PROGRAM);
    put_entry(layout, TIFFTAG_SAMPLEFORMAT, TIFF_SHORT, n, (uint16_t[]){format, format, format});
    if (options->profile != NULL)
        put_entry(layout, TIFFTAG_ICCPROFILE, TIFF_UNDEFINED, options->profile_length,
                  options->profile);
    fwrite(page + 1 < pages(options) ? &next : &(uint64_t){0}, layout->big ? 8 : 4, 1,
           layout->entries);
}

static void put_header(struct layout *layout)
{
    static const unsigned char classic[8] = {'I', 'I', 42, 0, 8};
    static const unsigned char big[16] = {'I', 'I', 43, 0, 8, 0, 0, 0, 16};
    fwrite(layout->big ? big : classic, header_bytes(layout->big), 1, layout->entries);
}

/* All that comes before the pixels, allocated; NULL: no memory. */
static char *directories(const struct picture_writer *writer, size_t *length)
{
    struct layout layout = {
        .options = &writer->options, .pixels_at = writer->pixels_at, .big = writer->big};
    char *entries = NULL, *values = NULL, *whole = NULL;
    size_t n_entries = 0, n_values = 0;
    layout.entries = open_memstream(&entries, &n_entries);
    layout.values = open_memstream(&values, &n_values);
    layout.values_at = values_at(&layout);
    layout.failed = layout.entries == NULL || layout.values == NULL;
    if (!layout.failed) {
        put_header(&layout);
        for (int page = 0; page < pages(&writer->options); page++)
            put_directory(&layout, page);
        fwrite(zeros, values_at(&layout) - (size_t)ftell(layout.entries), 1, layout.entries);
    }
    layout.failed = (layout.entries != NULL && fclose(layout.entries) != 0) || layout.failed;
    layout.failed = (layout.values != NULL && fclose(layout.values) != 0) || layout.failed;
    *length = n_entries + n_values;
    if (!layout.failed)
        whole = malloc(*length);
    if (whole != NULL) {
        memcpy(whole, entries, n_entries);
        memcpy(whole + n_entries, values, n_values);
    }
    free(entries);
    free(values);
    return whole;
}

/* ---- the file ---- */

/* A long write may be cut short. */
static bool write_at(struct picture_writer *writer, const void *bytes, size_t length,
                     uint64_t offset, struct error *err)
{
    const char *at = bytes;
    while (length > 0) {
        const ssize_t written = pwrite(writer->output.descriptor, at, length, (off_t)offset);
        if (written < 0)
            return error_system(err, "%s: cannot write the picture", writer->output.path);
        at += written;
        length -= (size_t)written;
        offset += (uint64_t)written;
    }
    return true;
}

/* How long the directories are depends on their form, and what they tell on how long they are; the
 * third try at the latest is right. */
static bool lay_out(struct picture_writer *writer, struct error *err)
{
    const uint64_t pixels = (uint64_t)pages(&writer->options) * page_bytes(&writer->options);
    for (;;) {
        size_t length;
        char *bytes = directories(writer, &length);
        if (bytes == NULL)
            return error_memory(err);
        const bool big = writer->big || length + pixels > UINT32_MAX;
        const bool right = writer->pixels_at == length && writer->big == big;
        const bool done = right && write_at(writer, bytes, length, 0, err);
        free(bytes);
        if (right)
            return done;
        writer->pixels_at = length;
        writer->big = big;
    }
}

bool picture_open(struct picture_writer *out, const char *path,
                  const struct picture_options *options, struct error *err)
{
    const uint64_t most_bytes = UINT64_C(1) << 61; /* room for three pages in 63 bits */
    *out = (struct picture_writer){.options = *options};
    assert(options->width > 0 && options->height > 0);
    if (row_bytes(options) > most_bytes / (uint64_t)options->height)
        return error_usage(err, "%dx%d pixels are too many for one picture", options->width,
                           options->height);
    if (output_open(&out->output, path, err) && lay_out(out, err))
        return true;
    picture_discard(out);
    return false;
}

/* One channel of some rows becomes rows of its page. */
static bool write_plane(struct picture_writer *writer, const float *samples, int rows, int channel,
                        float *plane, struct error *err)
{
    const struct picture_options *options = &writer->options;
    const size_t n = (size_t)rows * (size_t)options->width;
    for (size_t i = 0; i < n; i++)
        plane[i] = samples[3 * i + (size_t)channel];
    return write_at(writer, plane, n * sizeof *plane,
                    writer->pixels_at + (uint64_t)channel * page_bytes(options) +
                        (uint64_t)writer->row * row_bytes(options),
                    err);
}

bool picture_write(struct picture_writer *writer, const void *samples, int rows, struct error *err)
{
    const struct picture_options *options = &writer->options;
    const size_t length = (size_t)rows * (size_t)row_bytes(options);
    bool done = true;
    assert(rows >= 0 && rows <= options->height - writer->row);
    if (options->samples == PICTURE_FLOAT) {
        float *plane = malloc(length);
        done = plane != NULL || error_memory(err);
        for (int channel = 0; done && channel < 3; channel++)
            done = write_plane(writer, samples, rows, channel, plane, err);
        free(plane);
    } else
        done = write_at(writer, samples, length,
                        writer->pixels_at + (uint64_t)writer->row * row_bytes(options), err);
    writer->row += rows;
    return done;
}

bool picture_commit(struct picture_writer *writer, struct error *err)
{
    assert(writer->row == writer->options.height);
    const bool done = output_commit(&writer->output, err);
    picture_discard(writer);
    return done;
}

void picture_discard(struct picture_writer *writer)
{
    output_discard(&writer->output);
    *writer = (struct picture_writer){.row = 0};
}
