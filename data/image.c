/* SPDX-License-Identifier: MIT */
/* Reads TIFF files as textures, through libtiff and callbacks of our own, so that a compiled-in
 * file is read like any other. What libtiff has to say is kept for our own message. Where a page
 * tells its wavelength and scale is where data/tags.c lets a stack tell them. */
#include "spectral.h"

#include <fcntl.h>
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>
#include <unistd.h>

/* How a page's samples lie in its blocks, which are tiles, or strips as wide as the page. */
struct layout {
    uint32_t width, height, block_width, block_height;
    uint16_t bits, n_samples, n_colours;
    size_t block_bytes;
    bool tiled, separate; /* a block of each colour, instead of its samples side by side */
    bool inverted;        /* 0 is white */
};
struct image_file {
    TIFF *tiff;
    int descriptor;
    const struct builtin_file *builtin; /* NULL: the descriptor is read */
    uint64_t length, position;
    struct layout first;   /* of page 0 */
    double count_scale;    /* radiance of a count, by page 0's GDAL metadata */
    uint64_t *directories; /* where each page's lies */
    char *description;     /* of page 0; NULL: none */
    char *channel;         /* in it: the OME-XML channel of the next page; NULL: none */
    struct place from;
    bool decoding;     /* a warning then means lost samples */
    char message[256]; /* libtiff's first */
};

/* ---- the file, as libtiff sees it ---- */

static tmsize_t client_read(thandle_t handle, void *bytes, tmsize_t length)
{
    struct image_file *file = handle;
    const uint64_t left = file->position < file->length ? file->length - file->position : 0;
    if ((uint64_t)length > left)
        length = (tmsize_t)left;
    if (file->builtin != NULL)
        memcpy(bytes, file->builtin->bytes + (length > 0 ? file->position : 0), (size_t)length);
    else
        length = pread(file->descriptor, bytes, (size_t)length, (off_t)file->position);
    file->position += length > 0 ? (uint64_t)length : 0;
    return length;
}

static tmsize_t client_write(thandle_t handle, void *bytes, tmsize_t length)
{
    (void)handle;
    (void)bytes;
    (void)length;
    return -1; /* it is open for reading */
}

static toff_t client_size(thandle_t handle)
{
    const struct image_file *file = handle;
    return file->length;
}

static toff_t client_seek(thandle_t handle, toff_t offset, int whence)
{
    struct image_file *file = handle;
    const uint64_t base = whence == SEEK_CUR   ? file->position
                          : whence == SEEK_END ? file->length
                                               : 0;
    file->position = base + offset;
    return file->position;
}

static int client_close(thandle_t handle)
{
    (void)handle; /* image_close does it */
    return 0;
}

static int PRINTF_LIKE(4, 0)
    client_error(TIFF *tiff, void *data, const char *module, const char *format, va_list arguments)
{
    struct image_file *file = data;
    (void)tiff;
    (void)module;
    if (file->message[0] == '\0')
        vsnprintf(file->message, sizeof file->message, format, arguments);
    return 1; /* kept: nothing goes to standard error */
}

/* Private tags are no news. */
static int PRINTF_LIKE(4, 0) client_warning(TIFF *tiff, void *data, const char *module,
                                            const char *format, va_list arguments)
{
    const struct image_file *file = data;
    return file->decoding ? client_error(tiff, data, module, format, arguments) : 1;
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
                    "%s: %s%s; a texture is a TIFF file of grey or RGB pages of 8 or 16 bits or of"
                    " grey 32-bit float ones",
                    image->path, where, why);
}

static bool refuse_broken(const struct image *image, int page, struct error *err)
{
    const char *message = image->file->message;
    return refuse(image, page, err, "libtiff: %s",
                  message[0] != '\0' ? message : "its pages cannot be read");
}

static bool blocks_read(const struct image *image, int page, struct layout *layout,
                        struct error *err)
{
    TIFF *tiff = image->file->tiff;
    uint32_t rows = layout->height;
    layout->tiled = TIFFIsTiled(tiff);
    layout->block_width = layout->width;
    if (layout->tiled) {
        TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &layout->block_width);
        TIFFGetField(tiff, TIFFTAG_TILELENGTH, &layout->block_height);
    } else {
        TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows);
        layout->block_height = rows < layout->height ? rows : layout->height;
    }
    if (layout->block_width - 1 >= LONGEST_IMAGE || layout->block_height - 1 >= LONGEST_IMAGE)
        return refuse(image, page, err, "its tiles have %" PRIu32 "x%" PRIu32 " pixels",
                      layout->block_width, layout->block_height);
    layout->block_bytes = (size_t)(layout->tiled ? TIFFTileSize(tiff) : TIFFStripSize(tiff));
    return layout->block_bytes > 0 || refuse_broken(image, page, err);
}

static bool samples_read(const struct image *image, int page, struct layout *layout,
                         struct error *err)
{
    TIFF *tiff = image->file->tiff;
    uint16_t photometric = UINT16_MAX, compression = 0, format = 0, planar = 0, n_extra = 0;
    uint16_t *extra = NULL;
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &layout->bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &layout->n_samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &n_extra, &extra);
    if (photometric == PHOTOMETRIC_YCBCR && compression == COMPRESSION_JPEG &&
        planar == PLANARCONFIG_CONTIG &&
        TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB))
        photometric = PHOTOMETRIC_RGB;
    layout->inverted = photometric == PHOTOMETRIC_MINISWHITE;
    layout->n_colours = photometric == PHOTOMETRIC_RGB ? 3 : 1;
    layout->separate = planar == PLANARCONFIG_SEPARATE;
    if (photometric > PHOTOMETRIC_RGB) /* which comes after the two kinds of grey */
        return refuse(image, page, err, "its colours are neither grey nor RGB");
    if (layout->n_samples != layout->n_colours + n_extra || n_extra > 1 ||
        (n_extra == 1 && extra[0] == EXTRASAMPLE_UNSPECIFIED))
        return refuse(image, page, err, "it has %d samples a pixel, not %d and perhaps an alpha",
                      layout->n_samples, layout->n_colours);
    if (!(format == SAMPLEFORMAT_UINT && (layout->bits == 8 || layout->bits == 16)) &&
        !(format == SAMPLEFORMAT_IEEEFP && layout->bits == 32 &&
          photometric == PHOTOMETRIC_MINISBLACK))
        return refuse(image, page, err, "its samples are %d of %d bits, %s", layout->n_samples,
                      layout->bits,
                      format == SAMPLEFORMAT_UINT     ? "unsigned"
                      : format == SAMPLEFORMAT_IEEEFP ? "float"
                                                      : "of another kind");
    const uint64_t bytes =
        (uint64_t)layout->width * layout->height * layout->n_samples * layout->bits / 8;
    return compression != COMPRESSION_NONE || bytes <= image->file->length ||
           refuse(image, page, err, "its pixels are %" PRIu64 " bytes, the file is shorter", bytes);
}

/* Of the current directory. */
static bool layout_read(const struct image *image, int page, struct layout *out, struct error *err)
{
    TIFF *tiff = image->file->tiff;
    uint16_t orientation = ORIENTATION_TOPLEFT;
    uint32_t depth = 1;
    *out = (struct layout){0};
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &out->width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &out->height);
    TIFFGetField(tiff, TIFFTAG_IMAGEDEPTH, &depth);
    TIFFGetField(tiff, TIFFTAG_ORIENTATION, &orientation);
    if (out->width - 1 >= LONGEST_IMAGE || out->height - 1 >= LONGEST_IMAGE || depth != 1)
        return refuse(image, page, err,
                      "it has %" PRIu32 "x%" PRIu32 "x%" PRIu32 " pixels, not 1 to %d a side",
                      out->width, out->height, depth, LONGEST_IMAGE);
    if (orientation != ORIENTATION_TOPLEFT)
        return refuse(image, page, err, "its orientation is %d, not 1 (the top row first)",
                      orientation);
    return samples_read(image, page, out, err) && blocks_read(image, page, out, err);
}

/* ---- what a page says of itself ---- */

/* NaN: there is none. */
static double number_at(const char *at, size_t *length)
{
    const struct word word = {.start = at, .length = strcspn(at, " \t\r\n<\"")};
    struct error ignored = {0};
    double number;
    *length = word.length;
    return word_number(&word, "it", 0, HUGE_VAL, &number, &ignored) ? number : (double)NAN;
}

/* The number right behind the first `then` behind `mark`, NaN where no number is there, and
 * `otherwise` without a mark. `text` may be NULL. */
static double number_after(const char *text, const char *mark, const char *then, double otherwise)
{
    const char *at = text != NULL ? strstr(text, mark) : NULL;
    size_t length;
    at = at != NULL ? strstr(at, then) : NULL;
    return at != NULL ? number_at(at + strlen(then), &length) : otherwise;
}

/* The page's GDAL_METADATA; NULL: none. libtiff does not know this tag and promises no NUL. */
static const char *gdal_metadata(TIFF *tiff)
{
    uint32_t length = 0;
    const char *text = NULL;
    return TIFFGetField(tiff, TIFFTAG_GDAL_METADATA, &length, &text) && length > 0 &&
                   memchr(text, '\0', length) != NULL
               ? text
               : NULL;
}

/* That of the next OME-XML channel, in nm; NaN: none. */
static double channel_wavelength(struct image_file *file)
{
    char *channel = file->channel != NULL ? strstr(file->channel, "<Channel ") : NULL;
    char *end = channel != NULL ? strchr(channel, '>') : NULL;
    double nm;
    file->channel = end;
    if (end == NULL)
        return (double)NAN;
    *end = '\0';
    nm = strstr(channel, "EmissionWavelengthUnit=") != NULL &&
                 strstr(channel, "EmissionWavelengthUnit=\"nm\"") == NULL
             ? (double)NAN
             : number_after(channel, "EmissionWavelength=", "\"", (double)NAN);
    *end = '>';
    return nm;
}

/* In nm; NaN: the page tells none. */
static double page_wavelength(struct image_file *file)
{
    const char *name = "", *gdal = gdal_metadata(file->tiff);
    const double channel = channel_wavelength(file);
    size_t length;
    TIFFGetField(file->tiff, TIFFTAG_PAGENAME, &name);
    double nm = number_at(name, &length);
    if (!isnan(nm) && strcmp(name + length, " nm") == 0)
        return nm;
    nm = 1000 * number_after(gdal, "name=\"CENTRAL_WAVELENGTH_UM\"", ">", (double)NAN);
    if (gdal != NULL && strstr(gdal, ">Nanometers<") != NULL)
        nm = number_after(gdal, "name=\"wavelength\"", ">", nm);
    return isnan(nm) ? channel : nm;
}

/* Float samples are radiances themselves. Counts have one scale in all pages; page 0's description
 * tells it exactly in a stack of our own. */
static bool scale_read(struct image *image, int page, const struct layout *layout,
                       struct error *err)
{
    const char *gdal = gdal_metadata(image->file->tiff);
    const double largest = layout->bits == 8 ? 255 : 65535;
    const double count_scale = number_after(gdal, "role=\"scale\"", ">", 1 / largest);
    if (layout->bits == 32)
        return true;
    if (number_after(gdal, "role=\"offset\"", ">", 0) != 0)
        return refuse(image, page, err, "its samples have an offset");
    if (page == 0) {
        image->file->count_scale = count_scale;
        image->scale = number_after(image->file->description, "full_scale:", " ",
                                    count_scale == 1 / largest ? 1 : count_scale * largest);
    }
    return (image->scale > 0 && image->scale <= DBL_MAX &&
            count_scale == image->file->count_scale) ||
           refuse(image, page, err, "its scale is not positive, or not that of the first page");
}

static bool description_read(struct image_file *file, struct error *err)
{
    const char *text;
    if (!TIFFGetField(file->tiff, TIFFTAG_IMAGEDESCRIPTION, &text))
        return true;
    file->channel = file->description = strdup(text);
    return file->description != NULL || error_memory(err);
}

/* ---- opening ---- */

static bool page_add(struct image *image, struct error *err)
{
    struct image_file *file = image->file;
    const int page = image->n_pages;
    struct layout layout;
    void *grown = array_more(file->directories, page, sizeof *file->directories, err);
    if (grown == NULL)
        return false;
    file->directories = grown;
    file->directories[page] = TIFFCurrentDirOffset(file->tiff);
    grown = array_more(image->wavelengths_nm, page, sizeof *image->wavelengths_nm, err);
    if (grown == NULL)
        return false;
    image->wavelengths_nm = grown;
    if (page == 0 && !description_read(file, err))
        return false;
    image->wavelengths_nm[page] = page_wavelength(file);
    if (!layout_read(image, page, &layout, err))
        return false;
    if (page == 0)
        file->first = layout;
    if (layout.width != file->first.width || layout.height != file->first.height ||
        layout.bits != file->first.bits)
        return refuse(image, page, err,
                      "it has %" PRIu32 "x%" PRIu32 "x%d bits, the first page %" PRIu32 "x%" PRIu32
                      "x%d",
                      layout.width, layout.height, layout.bits, file->first.width,
                      file->first.height, file->first.bits);
    image->n_pages++;
    return scale_read(image, page, &layout, err);
}

static bool pages_read(struct image *image, struct error *err)
{
    enum { MOST_PAGES = 65535 }; /* as in a stack of our own */
    TIFF *tiff = image->file->tiff;
    double before = 0;
    bool rising = true;
    do {
        if (image->n_pages == MOST_PAGES)
            return refuse(image, -1, err, "it has more than %d pages", MOST_PAGES);
        if (image->n_pages > 0 && !TIFFReadDirectory(tiff))
            return refuse_broken(image, -1, err);
        if (!page_add(image, err))
            return false;
    } while (!TIFFLastDirectory(tiff));
    for (int page = 0; page < image->n_pages; page++) {
        rising = rising && image->wavelengths_nm[page] > before;
        before = image->wavelengths_nm[page];
    }
    if (!rising) {
        free(image->wavelengths_nm);
        image->wavelengths_nm = NULL;
    }
    image->width = (int)image->file->first.width;
    image->height = (int)image->file->first.height;
    return true;
}

static bool tiff_open(struct image *image, struct error *err)
{
    const tmsize_t most_bytes = 1 << 30; /* of one allocation, whatever a broken file asks for */
    struct image_file *file = image->file;
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    file->length = file->builtin != NULL ? file->builtin->length
                                         : (uint64_t)lseek(file->descriptor, 0, SEEK_END);
    if (options == NULL)
        return error_memory(err);
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, most_bytes);
    TIFFOpenOptionsSetErrorHandlerExtR(options, client_error, file);
    TIFFOpenOptionsSetWarningHandlerExtR(options, client_warning, file);
    file->tiff = TIFFClientOpenExt(image->path, "r", file, client_read, client_write, client_seek,
                                   client_close, client_size, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    return file->tiff != NULL || refuse_broken(image, -1, err);
}

bool image_open(const char *path, struct place from, struct image *out, struct error *err)
{
    *out = (struct image){.scale = 1, .path = strdup(path), .file = calloc(1, sizeof *out->file)};
    if (out->file != NULL)
        *out->file = (struct image_file){.descriptor = -1, .from = from};
    if (((out->path != NULL && out->file != NULL) || error_memory(err)) &&
        file_open(path, from, &out->file->descriptor, &out->file->builtin, err) &&
        tiff_open(out, err) && pages_read(out, err))
        return true;
    image_close(out);
    return false;
}

void image_close(struct image *image)
{
    struct image_file *file = image->file;
    if (file != NULL) {
        if (file->tiff != NULL)
            TIFFClose(file->tiff);
        if (file->descriptor >= 0)
            close(file->descriptor);
        free(file->directories);
        free(file->description);
    }
    free(file);
    free(image->path);
    free(image->wavelengths_nm);
    *image = (struct image){0};
}

/* ---- samples ---- */

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
    static const int luma[] = {2126, 7152, 722}; /* ITU-R BT.709-6, item 3.2, in 1/10000 */
    const double largest = layout->bits == 8 ? 255 : layout->bits == 16 ? 65535 : 1;
    double sum, white = largest;
    if (layout->n_colours == 1) {
        sum = sample_at(layout, blocks, layout->separate ? pixel : pixel * layout->n_samples);
    } else {
        sum = 0;
        white = 10000 * largest;
        for (size_t i = 0; i < 3; i++)
            sum += luma[i] * (layout->separate
                                  ? sample_at(layout, blocks + i * layout->block_bytes, pixel)
                                  : sample_at(layout, blocks, pixel * layout->n_samples + i));
    }
    return (layout->inverted ? white - sum : sum) / white;
}

/* Decodes the block at column x and row y, of each plane that is needed. */
static bool block_decode(const struct image *image, int page, const struct layout *layout,
                         uint32_t x, uint32_t y, char *blocks, struct error *err)
{
    TIFF *tiff = image->file->tiff;
    const uint16_t n_planes = layout->separate ? layout->n_colours : 1;
    for (uint16_t plane = 0; plane < n_planes; plane++) {
        char *block = blocks + plane * layout->block_bytes;
        const tmsize_t got =
            layout->tiled
                ? TIFFReadEncodedTile(tiff, TIFFComputeTile(tiff, x, y, 0, plane), block, -1)
                : TIFFReadEncodedStrip(tiff, TIFFComputeStrip(tiff, y, plane), block, -1);
        if (got < 0 || image->file->message[0] != '\0')
            return refuse_broken(image, page, err);
    }
    return true;
}

/* Writes the pixels of the block at x, y to their places in the picture. */
static bool block_place(const struct image *image, int page, const struct layout *layout,
                        uint32_t x, uint32_t y, const char *blocks, float *out, struct error *err)
{
    const uint32_t right = layout->width - x, below = layout->height - y;
    const uint32_t width = layout->block_width < right ? layout->block_width : right;
    const uint32_t height = layout->block_height < below ? layout->block_height : below;
    for (uint32_t row = 0; row < height; row++)
        for (uint32_t column = 0; column < width; column++) {
            const size_t pixel = (size_t)row * layout->block_width + column;
            const double value = pixel_value(layout, blocks, pixel) * image->scale;
            if (!(value >= 0 && value <= (double)FLT_MAX))
                return refuse(image, page, err,
                              "the radiance at column %" PRIu32 ", row %" PRIu32
                              " is %g; it is finite and not negative",
                              x + column, y + row, value);
            out[(size_t)(y + row) * layout->width + x + column] = (float)value;
        }
    return true;
}

bool image_read(struct image *image, int page, float *out, struct error *err)
{
    struct image_file *file = image->file;
    struct layout layout;
    bool good = true;
    file->message[0] = '\0';
    if (!TIFFSetSubDirectory(file->tiff, file->directories[page]))
        return refuse_broken(image, page, err);
    if (!layout_read(image, page, &layout, err))
        return false;
    char *blocks = calloc(layout.separate ? layout.n_colours : 1, layout.block_bytes);
    if (blocks == NULL)
        return error_memory(err);
    file->message[0] = '\0';
    file->decoding = true;
    for (uint32_t y = 0; good && y < layout.height; y += layout.block_height)
        for (uint32_t x = 0; good && x < layout.width; x += layout.block_width)
            good = block_decode(image, page, &layout, x, y, blocks, err) &&
                   block_place(image, page, &layout, x, y, blocks, out, err);
    file->decoding = false;
    free(blocks);
    return good;
}
