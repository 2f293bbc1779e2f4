/* SPDX-License-Identifier: MIT */
/* Reads the samples of ENVI cubes, some rows of a band at a time, so that memory does not grow with
 * the cube. */
#include <errno.h>
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/envi/envi.h"

/* Rows of some pages as stored, but page after page. In a cube by pixels the bands lie side by
 * side: whoever reads one of them reads them all. */
struct envi_rows {
    int first_row, n_rows, first_page, end_page;
    size_t page_bytes;
    char *samples;
};

/* ---- opening ---- */

static size_t sample_bytes(const struct envi *envi)
{
    return (size_t)envi_type_bytes(envi->header.layout.type);
}

/* Returns the bytes of one row: of a band, or of all bands. */
static size_t row_bytes(const struct envi *envi, int bands)
{
    return (size_t)envi->header.layout.samples * (size_t)bands * sample_bytes(envi);
}

/* A double holds each size below 2^53 exactly, and no larger one makes a file long enough. */
static bool is_long_enough(const struct envi *envi, struct error *err)
{
    const struct envi_layout *layout = &envi->header.layout;
    const double needed =
        (double)layout->offset + (double)row_bytes(envi, layout->bands) * (double)layout->lines;
    return (double)envi->bytes >= needed ||
           error_at(err, (struct place){envi->path, 0, 0},
                    "the file has %" PRIu64 " bytes; its header describes %.0f: %d samples x %d"
                    " lines x %d bands of %zu bytes behind the first %" PRIu64,
                    envi->bytes, needed, layout->samples, layout->lines, layout->bands,
                    sample_bytes(envi), layout->offset);
}

static bool open_data(struct envi *out, struct error *err)
{
    const struct builtin_file *builtin;
    struct stat status;
    if (!file_open(out->path, out->from, &out->descriptor, &builtin, err))
        return false;
    if (out->descriptor < 0)
        return error_at(err, out->from, "%s: expected a file that is not compiled in", out->path);
    if (fstat(out->descriptor, &status) != 0)
        return error_system(err, "%s: cannot be examined", out->path);
    out->bytes = (uint64_t)status.st_size;
    return is_long_enough(out, err);
}

bool envi_open(const char *path, struct place from, struct envi *out, struct error *err)
{
    char header[ENVI_PATH], data[ENVI_PATH];
    *out = (struct envi){.descriptor = -1, .from = from};
    bool done = envi_files(path, from, header, data, err) &&
                envi_header_read(header, from, &out->header, err);
    if (done) {
        out->path = strdup(data);
        out->kept = calloc(1, sizeof *out->kept);
        done = ((out->path && out->kept) || error_memory(err)) && open_data(out, err);
    }
    if (!done)
        envi_close(out);
    return done;
}

void envi_close(struct envi *envi)
{
    if (envi->path && envi->descriptor >= 0)
        close(envi->descriptor);
    if (envi->kept)
        free(envi->kept->samples);
    free(envi->kept);
    free(envi->path);
    envi_header_free(&envi->header);
    *envi = (struct envi){.descriptor = -1};
}

/* ---- bytes ---- */

static bool bytes_read(const struct envi *envi, uint64_t offset, size_t length, char *out,
                       struct error *err)
{
    offset += envi->header.layout.offset;
    const ssize_t got = read_at(envi->descriptor, out, length, offset);
    if (got < 0)
        return error_system(err, "%s: byte %" PRIu64 " cannot be read", envi->path, offset);
    errno = 0;
    return (size_t)got == length ||
           error_system(err, "%s: byte %" PRIu64 " cannot be read: the file has become shorter",
                        envi->path, offset + (uint64_t)got);
}

/* Reads n rows of a page that lie by bands (one piece) or by rows (a piece for each row). */
static bool rows_read(const struct envi *envi, int page, int y, int n, char *out, struct error *err)
{
    const struct envi_layout *layout = &envi->header.layout;
    const uint64_t row = row_bytes(envi, 1), band = (uint64_t)envi->header.band[page];
    if (layout->interleave == ENVI_BSQ)
        return bytes_read(envi, (band * (uint64_t)layout->lines + (uint64_t)y) * row,
                          (size_t)(row * (uint64_t)n), out, err);
    for (uint64_t i = 0; i < (uint64_t)n; i++)
        if (!bytes_read(envi, (((uint64_t)y + i) * (uint64_t)layout->bands + band) * row,
                        (size_t)row, out + i * row, err))
            return false;
    return true;
}

/* ---- bands side by side ---- */

static char *kept_page(const struct envi_rows *kept, int page)
{
    return kept->samples + (size_t)(page - kept->first_page) * kept->page_bytes;
}

/* Copies the samples of n pixels, which hold all bands, into each page that is kept. */
static void pages_part(const struct envi *envi, const char *pixels, size_t n, size_t before)
{
    const struct envi_rows *kept = envi->kept;
    const size_t bytes = sample_bytes(envi), step = row_bytes(envi, envi->header.layout.bands) /
                                                    (size_t)envi->header.layout.samples;
    for (int page = kept->first_page; page < kept->end_page; page++) {
        char *out = kept_page(kept, page) + before * bytes;
        const char *in = pixels + (size_t)envi->header.band[page] * bytes;
        for (size_t i = 0; i < n; i++)
            memcpy(out + i * bytes, in + i * step, bytes);
    }
}

/* Fills the kept pages, in blocks of rows. */
static bool kept_fill(const struct envi *envi, struct error *err)
{
    const struct envi_rows *kept = envi->kept;
    const size_t row = row_bytes(envi, envi->header.layout.bands),
                 fitting = ((size_t)1 << 20) / row;
    const size_t n_rows = (size_t)kept->n_rows, width = (size_t)envi->header.layout.samples;
    const size_t most = fitting < 1 ? 1 : fitting < n_rows ? fitting : n_rows;
    if (!memory_suffices((double)row * (double)most, envi->from, err,
                         "%s: a row of %d samples in %d bands", envi->path,
                         envi->header.layout.samples, envi->header.layout.bands))
        return false;
    char *block = malloc(most * row);
    bool done = block != NULL || error_memory(err);
    for (size_t y = 0, n; done && y < n_rows; y += n) {
        n = n_rows - y < most ? n_rows - y : most;
        done = bytes_read(envi, ((uint64_t)kept->first_row + y) * row, n * row, block, err);
        if (done)
            pages_part(envi, block, n * width, y * width);
    }
    free(block);
    return done;
}

/* Keeps n rows from row y on of a page, and of as many pages behind it as there is room for. */
static bool pages_keep(const struct envi *envi, int page, int y, int n, struct error *err)
{
    const size_t room = (size_t)1 << 28; /* or one page, if that is larger */
    struct envi_rows *kept = envi->kept;
    const size_t bytes = (size_t)n * row_bytes(envi, 1), fitting = room / bytes;
    const size_t left = (size_t)(envi->header.n - page);
    const size_t pages = fitting < 1 ? 1 : fitting < left ? fitting : left;
    if (page >= kept->first_page && page < kept->end_page && y >= kept->first_row &&
        y + n <= kept->first_row + kept->n_rows)
        return true;
    free(kept->samples);
    *kept = (struct envi_rows){y, n, page, page + (int)pages, bytes, malloc(pages * bytes)};
    if ((kept->samples != NULL || error_memory(err)) && kept_fill(envi, err))
        return true;
    free(kept->samples);
    *kept = (struct envi_rows){.samples = NULL};
    return false;
}

/* ---- values ---- */

/* Returns the bits of a sample, whose bytes lie in either order. */
static uint64_t bits_at(const unsigned char *at, size_t bytes, bool big_endian)
{
    uint64_t bits = 0;
    for (size_t i = 0; i < bytes; i++)
        bits |= (uint64_t)at[i] << 8 * (big_endian ? bytes - 1 - i : i);
    return bits;
}

static double float_of(uint64_t bits)
{
    const uint32_t half = (uint32_t)bits;
    float value;
    memcpy(&value, &half, sizeof value);
    return (double)value;
}

static double double_of(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double sample_of(uint64_t bits, enum envi_type type)
{
    switch (type) {
    case ENVI_INT16:
        return (int16_t)bits;
    case ENVI_INT32:
        return (int32_t)bits;
    case ENVI_INT64:
        return (double)(int64_t)bits;
    case ENVI_FLOAT:
        return float_of(bits);
    case ENVI_DOUBLE:
        return double_of(bits);
    default:
        return (double)bits;
    }
}

/* Returns whether the sample stands for none. NaN, too, equals itself here. */
static bool is_ignored(const struct envi_header *header, double sample)
{
    return header->has_ignored &&
           (sample == header->ignored || (isnan(sample) && isnan(header->ignored)));
}

/* Returns the value of a stored sample. */
static double value_at(const struct envi_header *header, int page, const unsigned char *at)
{
    const struct envi_layout *layout = &header->layout;
    const size_t bytes = (size_t)envi_type_bytes(layout->type);
    const double sample = sample_of(bits_at(at, bytes, layout->big_endian), layout->type);
    return is_ignored(header, sample) ? 0 : header->gain[page] * sample + header->offset[page];
}

/* Some rows of a page as stored. */
struct stored_rows {
    int page, y, n;
    const char *samples;
};

static bool refuse_value(const struct envi *envi, const struct stored_rows *of, size_t at,
                         double value, struct error *err)
{
    const struct envi_header *header = &envi->header;
    const size_t width = (size_t)header->layout.samples;
    char where[64] = "";
    if (header->wavelengths_nm)
        snprintf(where, sizeof where, " (%.10g nm)", header->wavelengths_nm[of->page]);
    return error_at(err, envi->from,
                    "%s: band %d%s: the radiance at column %zu, row %zu is %g; expected a finite"
                    " number that is not negative, or the header's data ignore value",
                    envi->path, header->band[of->page] + 1, where, at % width,
                    (size_t)of->y + at / width, value);
}

static bool values_place(const struct envi *envi, const struct stored_rows *of, float *out,
                         struct error *err)
{
    const size_t bytes = sample_bytes(envi),
                 n = (size_t)of->n * (size_t)envi->header.layout.samples;
    const unsigned char *at = (const unsigned char *)of->samples;
    for (size_t i = 0; i < n; i++, at += bytes) {
        const double value = value_at(&envi->header, of->page, at);
        if (!(value >= 0 && value <= (double)FLT_MAX))
            return refuse_value(envi, of, i, value, err);
        out[i] = (float)value;
    }
    return true;
}

/* Reads rows of a cube by bands or by rows, in blocks that stay in the processor's cache. */
static bool blocks_read(const struct envi *envi, struct stored_rows of, float *out,
                        struct error *err)
{
    const size_t row = row_bytes(envi, 1), fitting = ((size_t)1 << 18) / row;
    const int end = of.y + of.n;
    const int most = fitting < 1 ? 1 : fitting < (size_t)of.n ? (int)fitting : of.n;
    char *block = malloc((size_t)most * row);
    bool done = block || error_memory(err);
    for (of.samples = block; done && of.y < end; of.y += of.n) {
        of.n = end - of.y < most ? end - of.y : most;
        done =
            rows_read(envi, of.page, of.y, of.n, block, err) && values_place(envi, &of, out, err);
        out += (size_t)of.n * (size_t)envi->header.layout.samples;
    }
    free(block);
    return done;
}

bool envi_read(struct envi *envi, int page, int y, int rows, float *out, struct error *err)
{
    struct stored_rows of = {.page = page, .y = y, .n = rows};
    if (envi->header.layout.interleave != ENVI_BIP)
        return blocks_read(envi, of, out, err);
    if (!pages_keep(envi, page, y, rows, err))
        return false;
    of.samples =
        kept_page(envi->kept, page) + (size_t)(y - envi->kept->first_row) * row_bytes(envi, 1);
    return values_place(envi, &of, out, err);
}
