/* SPDX-License-Identifier: MIT */
/* Reads TIFF files through libtiff, whose messages are kept for our own. Where a page tells its
 * wavelength and scale is where data/tags.c lets a stack tell them. */
#include "spectral.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>
#include <unistd.h>

/* How a page's samples lie in its blocks, which are tiles, or strips as wide as the page: colour i
 * of pixel p is sample i * colour_step + p * pixel_step of the planes of a block. */
struct layout {
    uint32_t width, height, block_width, block_height;
    uint16_t bits, n_samples, n_colours, n_planes;
    size_t block_bytes, colour_step, pixel_step;
    size_t row_bytes;     /* of a plane */
    uint64_t rows_offset; /* where its rows lie one after the other, uncompressed; 0: they do not */
    double largest;       /* sample; 1 where they are float */
    bool tiled, inverted; /* 0 is white */
};
struct page {
    uint64_t directory; /* where it lies */
    struct layout layout;
};
struct image_file {
    TIFF *tiff;
    const struct builtin_file *builtin; /* NULL: libtiff reads a descriptor */
    uint64_t position;                  /* in it */
    double count_scale;                 /* radiance of a count, by page 0's GDAL metadata */
    struct page *pages;
    int page;             /* whose directory libtiff is at; -1: none of them */
    const char *channels; /* of its OME-XML, those of the pages to come */
    struct place from;
    bool decoding;     /* a warning then means lost samples */
    char message[256]; /* libtiff's first */
};

/* Nothing goes to standard error. */
static int PRINTF_LIKE(4, 0)
    keep_error(TIFF *tiff, void *data, const char *module, const char *format, va_list arguments)
{
    struct image_file *file = data;
    (void)tiff;
    (void)module;
    if (file->message[0] == '\0')
        vsnprintf(file->message, sizeof file->message, format, arguments);
    return 1;
}

/* Private tags are no news. */
static int PRINTF_LIKE(4, 0)
    keep_warning(TIFF *tiff, void *data, const char *module, const char *format, va_list arguments)
{
    const struct image_file *file = data;
    return file->decoding ? keep_error(tiff, data, module, format, arguments) : 1;
}

/* ---- what a page is ---- */

/* Blames a page (from 0; -1: the file) with its wavelength where it tells one. */
static bool PRINTF_LIKE(4, 5)
    refuse(const struct image *image, int page, struct error *err, const char *format, ...)
{
    char why[512], where[64] = "";
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why, sizeof why, format, arguments);
    va_end(arguments);
    if (page >= 0 && image->wavelengths_nm != NULL && image->wavelengths_nm[page] > 0)
        snprintf(where, sizeof where, "page %d (%.10g nm): ", page + 1,
                 image->wavelengths_nm[page]);
    else if (page >= 0)
        snprintf(where, sizeof where, "page %d: ", page + 1);
    return error_at(err, image->file->from,
                    "%s: %s%s; expected a TIFF file of grey or RGB pages of 8 or 16 bits or of"
                    " grey 32-bit float ones",
                    image->path, where, why);
}

static bool refuse_broken(const struct image *image, int page, struct error *err)
{
    const char *message = image->file->message;
    return refuse(image, page, err, "libtiff: %s",
                  message[0] != '\0' ? message : "its pages cannot be read");
}

static bool blocks_read(const struct image *image, int page, struct layout *out, struct error *err)
{
    TIFF *tiff = image->file->tiff;
    out->tiled = TIFFIsTiled(tiff);
    out->block_width = out->width;
    if (out->tiled)
        TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &out->block_width);
    TIFFGetFieldDefaulted(tiff, out->tiled ? TIFFTAG_TILELENGTH : TIFFTAG_ROWSPERSTRIP,
                          &out->block_height);
    if (!out->tiled && out->block_height > out->height)
        out->block_height = out->height;
    out->block_bytes = (size_t)(out->tiled ? TIFFTileSize(tiff) : TIFFStripSize(tiff));
    out->colour_step = out->n_planes > 1 ? out->block_bytes / (out->bits / 8u) : 1;
    return out->block_bytes > 0 || refuse_broken(image, page, err);
}

/* Whether the rows of all planes lie one after the other, uncompressed, so that they can be read as
 * they are: the usual way of stacks. Refuses a file that ends before they do. */
static bool rows_find(const struct image *image, int page, struct layout *out, struct error *err)
{
    TIFF *tiff = image->file->tiff;
    const uint32_t n = TIFFNumberOfStrips(tiff);
    const uint32_t per_plane = (out->height - 1) / out->block_height + 1;
    const uint64_t first = TIFFGetStrileOffset(tiff, 0);
    uint16_t compression = 0, fill_order = 0;
    uint64_t end = first;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_FILLORDER, &fill_order);
    out->row_bytes = (size_t)out->width * out->pixel_step * (out->bits / 8u);
    if (out->tiled || compression != COMPRESSION_NONE || fill_order != FILLORDER_MSB2LSB)
        return true;
    for (uint32_t strip = 0; strip < n && end <= image->bytes; strip++) {
        const uint32_t left = out->height - strip % per_plane * out->block_height;
        const uint32_t rows = left < out->block_height ? left : out->block_height;
        const uint64_t bytes = (uint64_t)rows * out->row_bytes;
        if (TIFFGetStrileOffset(tiff, strip) != end || TIFFGetStrileByteCount(tiff, strip) < bytes)
            return true;
        end += bytes;
    }
    out->rows_offset = first;
    return end <= image->bytes ||
           refuse(image, page, err, "its pixels end behind the end of the file");
}

static bool samples_read(const struct image *image, int page, struct layout *out, struct error *err)
{
    TIFF *tiff = image->file->tiff;
    uint16_t photometric = UINT16_MAX, compression = 0, format = 0, planar = 0, n_extra = 0;
    uint16_t *extra = NULL;
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &out->bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &out->n_samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &n_extra, &extra);
    if (photometric == PHOTOMETRIC_YCBCR && compression == COMPRESSION_JPEG &&
        planar == PLANARCONFIG_CONTIG &&
        TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB))
        photometric = PHOTOMETRIC_RGB;
    out->inverted = photometric == PHOTOMETRIC_MINISWHITE;
    out->n_colours = photometric == PHOTOMETRIC_RGB ? 3 : 1;
    out->n_planes = planar == PLANARCONFIG_SEPARATE ? out->n_colours : 1;
    out->pixel_step = planar == PLANARCONFIG_SEPARATE ? 1 : out->n_samples;
    out->largest = out->bits == 8 ? 255 : out->bits == 16 ? 65535 : 1;
    if (photometric > PHOTOMETRIC_RGB) /* which comes after the two kinds of grey */
        return refuse(image, page, err, "its colours are neither grey nor RGB");
    if (out->n_samples != out->n_colours + n_extra || n_extra > 1 ||
        (n_extra == 1 && extra[0] == EXTRASAMPLE_UNSPECIFIED))
        return refuse(image, page, err, "it has %d samples a pixel, not %d and perhaps an alpha",
                      out->n_samples, out->n_colours);
    if (!(format == SAMPLEFORMAT_UINT && (out->bits == 8 || out->bits == 16)) &&
        !(format == SAMPLEFORMAT_IEEEFP && out->bits == 32 &&
          photometric == PHOTOMETRIC_MINISBLACK))
        return refuse(image, page, err, "its samples are %d of %d bits, %s", out->n_samples,
                      out->bits,
                      format == SAMPLEFORMAT_UINT     ? "unsigned"
                      : format == SAMPLEFORMAT_IEEEFP ? "float"
                                                      : "of another kind");
    const uint64_t bytes = (uint64_t)out->width * out->height * out->n_samples * out->bits / 8;
    return compression != COMPRESSION_NONE || bytes <= image->bytes ||
           refuse(image, page, err, "its pixels are %" PRIu64 " bytes, the file is shorter", bytes);
}

/* Of the current directory. */
static bool layout_read(const struct image *image, int page, struct layout *out, struct error *err)
{
    TIFF *tiff = image->file->tiff;
    uint16_t orientation = ORIENTATION_TOPLEFT, compression = 0;
    uint32_t depth = 1;
    *out = (struct layout){0};
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &out->width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &out->height);
    TIFFGetField(tiff, TIFFTAG_IMAGEDEPTH, &depth);
    TIFFGetField(tiff, TIFFTAG_ORIENTATION, &orientation);
    if (out->width - 1 >= INT32_MAX || out->height - 1 >= INT32_MAX || depth != 1)
        return refuse(image, page, err, "it has %" PRIu32 "x%" PRIu32 "x%" PRIu32 " pixels",
                      out->width, out->height, depth);
    if (orientation != ORIENTATION_TOPLEFT)
        return refuse(image, page, err, "its orientation is %d, not 1 (the top row first)",
                      orientation);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    /* JBIG is for 1 bit a pixel; build.sh leaves its library out of the static program. */
    if (compression == COMPRESSION_JBIG || !TIFFIsCODECConfigured(compression))
        return refuse(image, page, err, "its compression (%d) is none that can be read here",
                      compression);
    return samples_read(image, page, out, err) && blocks_read(image, page, out, err) &&
           rows_find(image, page, out, err);
}

/* ---- what a page says of itself ---- */

/* NaN: there is none. */
static double number_at(const char *at)
{
    const struct word word = {.start = at, .length = strcspn(at, " \t\r\n<\"")};
    struct error ignored = {0};
    double number;
    return word_number(&word, "it", 0, HUGE_VAL, &number, &ignored) ? number : (double)NAN;
}

/* The number right behind the first `then` behind `mark`, NaN where no number is there, and
 * `otherwise` without a mark. `text` may be NULL. */
static double number_after(const char *text, const char *mark, const char *then, double otherwise)
{
    const char *at = text != NULL ? strstr(text, mark) : NULL;
    at = at != NULL ? strstr(at, then) : NULL;
    return at != NULL ? number_at(at + strlen(then)) : otherwise;
}

/* A tag's text; NULL: none. libtiff does not know these tags and promises no NUL. */
static const char *private_text(TIFF *tiff, uint32_t tag)
{
    uint32_t length = 0;
    const char *text = NULL;
    return TIFFGetField(tiff, tag, &length, &text) && length > 0 &&
                   memchr(text, '\0', length) != NULL
               ? text
               : NULL;
}

/* In nm; NaN: the page tells none. OME-XML tells them in the order of pages. */
static double page_wavelength(struct image_file *file)
{
    static const char emission[] = "EmissionWavelength=\"";
    const char *name = "", *gdal = private_text(file->tiff, TIFFTAG_GDAL_METADATA);
    const char *channel = strstr(file->channels, emission);
    double nm = (double)NAN;
    if (channel != NULL)
        file->channels = channel + strlen(emission);
    TIFFGetField(file->tiff, TIFFTAG_PAGENAME, &name);
    if (strcmp(name + strcspn(name, " "), " nm") == 0)
        nm = number_at(name);
    if (isnan(nm) && gdal != NULL && strstr(gdal, ">Nanometers<") != NULL)
        nm = number_after(gdal, "name=\"wavelength\"", ">", nm);
    if (isnan(nm))
        nm = 1000 * number_after(gdal, "name=\"CENTRAL_WAVELENGTH_UM\"", ">", nm);
    return isnan(nm) && channel != NULL ? number_at(file->channels) : nm;
}

/* Float samples are radiances themselves. Counts have one scale in all pages; page 0's description
 * tells it exactly in a stack of our own. */
static bool scale_read(struct image *image, int page, const struct layout *layout,
                       struct error *err)
{
    const char *gdal = private_text(image->file->tiff, TIFFTAG_GDAL_METADATA);
    const char *own = strstr(image->description, "<Description>"); /* names come before it */
    const double count_scale = number_after(gdal, "role=\"scale\"", ">", 1 / layout->largest);
    if (layout->bits == 32)
        return true;
    if (number_after(gdal, "role=\"offset\"", ">", 0) != 0)
        return refuse(image, page, err, "its samples have an offset");
    if (page == 0) {
        image->file->count_scale = count_scale;
        image->scale =
            number_after(own != NULL ? own : image->description, "full_scale:", " ",
                         count_scale == 1 / layout->largest ? 1 : count_scale * layout->largest);
    }
    return (image->scale > 0 && image->scale <= DBL_MAX &&
            count_scale == image->file->count_scale) ||
           refuse(image, page, err, "its scale is not positive, or not that of the first page");
}

/* Channels are in nm where they name no unit. */
static bool description_read(struct image *image, struct error *err)
{
    static const char unit[] = "EmissionWavelengthUnit=\"";
    struct image_file *file = image->file;
    const char *text = "", *verdict = private_text(file->tiff, TAG_VERDICT);
    size_t length = verdict != NULL ? strlen(verdict) : 0;
    while (length > 0 && verdict[length - 1] == ' ')
        length--;
    TIFFGetField(file->tiff, TIFFTAG_IMAGEDESCRIPTION, &text);
    file->channels = image->description = strdup(text);
    image->verdict = strndup(verdict != NULL ? verdict : "", length);
    if (image->description == NULL || image->verdict == NULL)
        return error_memory(err);
    for (const char *at = text; (at = strstr(at, unit)) != NULL; at += strlen(unit))
        if (strncmp(at + strlen(unit), "nm\"", 3) != 0)
            file->channels = "";
    return true;
}

/* ---- opening ---- */

static bool page_add(struct image *image, struct error *err)
{
    struct image_file *file = image->file;
    const int page = image->n_pages;
    struct page *pages = array_more(file->pages, page, sizeof *pages, err);
    if (pages == NULL)
        return false;
    file->pages = pages;
    double *nm = array_more(image->wavelengths_nm, page, sizeof *nm, err);
    if (nm == NULL)
        return false;
    image->wavelengths_nm = nm;
    pages[page].directory = TIFFCurrentDirOffset(file->tiff);
    nm[page] = page_wavelength(file);
    const struct layout *layout = &pages[page].layout, *first = &pages[0].layout;
    if (!layout_read(image, page, &pages[page].layout, err))
        return false;
    if (layout->width != first->width || layout->height != first->height ||
        layout->bits != first->bits)
        return refuse(
            image, page, err,
            "it has %" PRIu32 "x%" PRIu32 "x%d bits, the first page %" PRIu32 "x%" PRIu32 "x%d",
            layout->width, layout->height, layout->bits, first->width, first->height, first->bits);
    image->coloured = image->coloured || layout->n_colours > 1;
    file->page = page;
    image->n_pages++;
    return scale_read(image, page, layout, err);
}

static bool pages_read(struct image *image, struct error *err)
{
    TIFF *tiff = image->file->tiff;
    double before = 0;
    bool rising = true;
    if (!description_read(image, err))
        return false;
    do {
        if (image->n_pages > 0 && !TIFFReadDirectory(tiff))
            return refuse_broken(image, -1, err);
        if (!page_add(image, err))
            return false;
        rising = rising && image->wavelengths_nm[image->n_pages - 1] > before;
        before = image->wavelengths_nm[image->n_pages - 1];
    } while (!TIFFLastDirectory(tiff));
    if (!rising) {
        free(image->wavelengths_nm);
        image->wavelengths_nm = NULL;
    }
    image->width = (int)image->file->pages[0].layout.width;
    image->height = (int)image->file->pages[0].layout.height;
    return true;
}

/* ---- a compiled-in file, as libtiff sees it ---- */

static tmsize_t builtin_read(thandle_t handle, void *bytes, tmsize_t length)
{
    struct image_file *file = handle;
    size_t at = (size_t)file->position, left = 0;
    if (file->position < file->builtin->length)
        left = file->builtin->length - at;
    if (left < (size_t)length)
        length = (tmsize_t)left;
    memcpy(bytes, file->builtin->bytes + (left > 0 ? at : 0), (size_t)length);
    file->position += (uint64_t)length;
    return length;
}

static tmsize_t builtin_write(thandle_t handle, void *bytes, tmsize_t length)
{
    (void)handle;
    (void)bytes;
    (void)length;
    return -1;
}

static toff_t builtin_size(thandle_t handle)
{
    const struct image_file *file = handle;
    return file->builtin->length;
}

static toff_t builtin_seek(thandle_t handle, toff_t offset, int whence)
{
    struct image_file *file = handle;
    file->position = offset + (whence == SEEK_CUR   ? file->position
                               : whence == SEEK_END ? file->builtin->length
                                                    : 0);
    return file->position;
}

static int builtin_close(thandle_t handle)
{
    (void)handle;
    return 0;
}

static bool tiff_open(struct image *image, struct error *err)
{
    const tmsize_t most_bytes = 1 << 30; /* of one allocation, whatever a broken file asks for */
    struct image_file *file = image->file;
    int descriptor;
    if (!file_open(image->path, file->from, &descriptor, &file->builtin, err))
        return false;
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (options != NULL) {
        TIFFOpenOptionsSetMaxSingleMemAlloc(options, most_bytes);
        TIFFOpenOptionsSetErrorHandlerExtR(options, keep_error, file);
        TIFFOpenOptionsSetWarningHandlerExtR(options, keep_warning, file);
        /* m: not mapped into memory, where a file cut short while it is open would end us; c: a
         * large strip is not shown as many small ones. */
        file->tiff =
            file->builtin == NULL
                ? TIFFFdOpenExt(descriptor, image->path, "rmc", options)
                : TIFFClientOpenExt(image->path, "rmc", file, builtin_read, builtin_write,
                                    builtin_seek, builtin_close, builtin_size, NULL, NULL, options);
        TIFFOpenOptionsFree(options);
    }
    if (file->tiff == NULL && descriptor >= 0)
        close(descriptor);
    if (file->tiff != NULL)
        image->bytes = TIFFGetSizeProc(file->tiff)(TIFFClientdata(file->tiff));
    return file->tiff != NULL ||
           (options == NULL ? error_memory(err) : refuse_broken(image, -1, err));
}

bool image_open(const char *path, struct place from, struct image *out, struct error *err)
{
    *out = (struct image){.scale = 1, .path = strdup(path), .file = calloc(1, sizeof *out->file)};
    if (out->file != NULL)
        out->file->from = from;
    if (((out->path != NULL && out->file != NULL) || error_memory(err)) && tiff_open(out, err) &&
        pages_read(out, err))
        return true;
    image_close(out);
    return false;
}

void image_close(struct image *image)
{
    if (image->file != NULL) {
        if (image->file->tiff != NULL)
            TIFFClose(image->file->tiff);
        free(image->file->pages);
    }
    free(image->file);
    free(image->path);
    free(image->description);
    free(image->verdict);
    free(image->wavelengths_nm);
    *image = (struct image){0};
}

/* ---- samples ---- */

/* Those of a page that are asked for. */
struct rows {
    uint32_t first, end;
    float *out;
};

/* A sample as stored. */
static double sample_at(const struct layout *layout, const void *samples, size_t at)
{
    if (layout->bits == 8)
        return ((const uint8_t *)samples)[at];
    return layout->bits == 16 ? ((const uint16_t *)samples)[at]
                              : (double)((const float *)samples)[at];
}

/* 0 to 1, or a float sample. The sum of RGB is a whole number: grey of the three gives the grey. */
static double pixel_value(const struct layout *layout, const char *blocks, size_t pixel)
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
           refuse(image, -1, err, "its byte %" PRIu64 " cannot be read", offset);
}

/* Reads rows top .. end - 1 as they lie in the file, of each plane that is needed. */
static bool rows_copy(const struct image *image, int page, const struct layout *layout,
                      uint32_t top, uint32_t end, char *blocks, struct error *err)
{
    const bool swapped = TIFFIsByteSwapped(image->file->tiff);
    const size_t length = (end - top) * layout->row_bytes;
    for (uint16_t plane = 0; plane < layout->n_planes; plane++) {
        void *block = blocks + plane * layout->block_bytes;
        const uint64_t row = (uint64_t)plane * layout->height + top;
        if (!bytes_read(image, layout->rows_offset + row * layout->row_bytes, length, block))
            return refuse(image, page, err, "its row %" PRIu32 " cannot be read", top);
        if (swapped && layout->bits == 16)
            TIFFSwabArrayOfShort(block, (tmsize_t)(length / 2));
        if (swapped && layout->bits == 32)
            TIFFSwabArrayOfLong(block, (tmsize_t)(length / 4));
    }
    return true;
}

/* Decodes the block at column x and row y, of each plane that is needed. */
static bool block_decode(const struct image *image, int page, const struct layout *layout,
                         uint32_t x, uint32_t y, char *blocks, struct error *err)
{
    TIFF *tiff = image->file->tiff;
    for (uint16_t plane = 0; plane < layout->n_planes; plane++) {
        char *block = blocks + plane * layout->block_bytes;
        const tmsize_t got =
            layout->tiled ? TIFFReadTile(tiff, block, x, y, 0, plane)
                          : TIFFReadEncodedStrip(tiff, TIFFComputeStrip(tiff, y, plane), block, -1);
        if (got < 0 || image->file->message[0] != '\0')
            return refuse_broken(image, page, err);
    }
    return true;
}

/* Counts of 16 bits, as in a stack of our own, several at once: pixel_value times the scale. */
static void counts_place(const uint16_t *counts, uint32_t n, double scale, float *restrict out)
{
    for (uint32_t i = 0; i < n; i++)
        out[i] = (float)(counts[i] / 65535.0 * scale);
}

static bool row_place(const struct image *image, int page, const struct layout *layout,
                      const char *blocks, size_t first, uint32_t x, uint32_t y, uint32_t n,
                      float *out, struct error *err)
{
    for (uint32_t i = 0; i < n; i++) {
        const double value = pixel_value(layout, blocks, first + i) * image->scale;
        if (!(value >= 0 && value <= (double)FLT_MAX))
            return refuse(image, page, err,
                          "the radiance at column %" PRIu32 ", row %" PRIu32
                          " is %g; it is finite and not negative",
                          x + i, y, value);
        out[i] = (float)value;
    }
    return true;
}

/* Writes the pixels of the block at column x and row `top`, as far as they are asked for. */
static bool block_place(const struct image *image, int page, const struct layout *layout,
                        uint32_t x, uint32_t top, const char *blocks, const struct rows *wanted,
                        struct error *err)
{
    const bool counts = layout->bits == 16 && layout->n_samples == 1 && !layout->inverted &&
                        image->scale <= (double)FLT_MAX;
    const uint32_t left = layout->width - x, below = wanted->end - top;
    const uint32_t n = left < layout->block_width ? left : layout->block_width;
    const uint32_t end = top + (below < layout->block_height ? below : layout->block_height);
    for (uint32_t y = top > wanted->first ? top : wanted->first; y < end; y++) {
        const size_t first = (size_t)(y - top) * layout->block_width;
        float *out = wanted->out + (size_t)(y - wanted->first) * layout->width + x;
        if (counts)
            counts_place((const uint16_t *)(const void *)blocks + first, n, image->scale, out);
        else if (!row_place(image, page, layout, blocks, first, x, y, n, out, err))
            return false;
    }
    return true;
}

/* Goes to the page's directory, if libtiff is to decode its blocks, and lets it know how. */
static bool page_turn(const struct image *image, int page, struct error *err)
{
    struct image_file *file = image->file;
    const struct layout *known = &file->pages[page].layout;
    struct layout found;
    if (known->rows_offset > 0 || file->page == page)
        return true;
    file->page = -1;
    if (!TIFFSetSubDirectory(file->tiff, file->pages[page].directory))
        return refuse_broken(image, page, err);
    if (!layout_read(image, page, &found, err))
        return false;
    if (found.width != known->width || found.height != known->height || found.bits != known->bits ||
        found.n_samples != known->n_samples || found.block_bytes != known->block_bytes ||
        found.rows_offset != known->rows_offset)
        return refuse(image, page, err, "it has changed since the file was opened");
    file->page = page;
    return true;
}

/* Rows that are read as they lie in the file come in blocks that stay in the processor's cache. */
static struct layout rows_layout(const struct layout *page, uint32_t rows)
{
    const size_t most = (size_t)1 << 18, fitting = most / page->row_bytes;
    struct layout layout = *page;
    layout.block_height = fitting < 1 ? 1 : fitting < rows ? (uint32_t)fitting : rows;
    layout.block_bytes = layout.block_height * layout.row_bytes;
    if (layout.n_planes > 1)
        layout.colour_step = layout.block_bytes / (layout.bits / 8u);
    return layout;
}

/* Reads the block at column x and row y in whichever way it lies. */
static bool block_read(const struct image *image, int page, const struct layout *layout, uint32_t x,
                       uint32_t y, const struct rows *wanted, char *blocks, struct error *err)
{
    const uint32_t left = wanted->end - y;
    const uint32_t rows = left < layout->block_height ? left : layout->block_height;
    return layout->rows_offset > 0 ? rows_copy(image, page, layout, y, y + rows, blocks, err)
                                   : block_decode(image, page, layout, x, y, blocks, err);
}

bool image_read(struct image *image, int page, int y, int rows, float *out, struct error *err)
{
    struct image_file *file = image->file;
    const struct rows wanted = {(uint32_t)y, (uint32_t)(y + rows), out};
    bool good = true;
    if (!page_turn(image, page, err))
        return false;
    struct layout layout = file->pages[page].layout;
    uint32_t top = wanted.first / layout.block_height * layout.block_height;
    if (layout.rows_offset > 0) {
        layout = rows_layout(&layout, (uint32_t)rows);
        top = wanted.first;
    }
    char *blocks = calloc(layout.n_planes, layout.block_bytes);
    if (blocks == NULL)
        return error_memory(err);
    file->message[0] = '\0';
    file->decoding = true;
    for (; good && top < wanted.end; top += layout.block_height)
        for (uint32_t x = 0; good && x < layout.width; x += layout.block_width)
            good = block_read(image, page, &layout, x, top, &wanted, blocks, err) &&
                   block_place(image, page, &layout, x, top, blocks, &wanted, err);
    file->decoding = false;
    free(blocks);
    return good;
}
