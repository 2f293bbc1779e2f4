/* SPDX-License-Identifier: MIT */
/* Opens TIFF files through libtiff, and keeps its messages for our own. GDAL writes the bands of a
 * picture as grey samples of one directory; each of these bands is a page, too. */
#include <float.h>
#include <inttypes.h>
#include <sys/stat.h>
#include <tiffio.h>
#include <unistd.h>

#include "data/images/inside.h"
#include "data/text/text.h"

/* ---- the layout of a page ---- */

bool PRINTF_LIKE(4, 5)
    image_refuse(const struct image *image, int page, struct error *err, const char *format, ...)
{
    char why[512], where[64] = "";
    va_list arguments;
    if (!source_is_sound(image, err))
        return false; /* not the file is to blame */
    va_start(arguments, format);
    vsnprintf(why, sizeof why, format, arguments);
    va_end(arguments);
    if (page >= 0 && image->wavelengths_nm != NULL && image->no_wavelengths[0] == '\0' &&
        image->wavelengths_nm[page] > 0)
        snprintf(where, sizeof where, "page %d (%.10g nm): ", page + 1,
                 image->wavelengths_nm[page]);
    else if (page >= 0)
        snprintf(where, sizeof where, "page %d: ", page + 1);
    return error_at(err, image->file->from,
                    "%s: %s%s; expected a TIFF file of grey or RGB pages of 8 or 16 bits or of"
                    " grey 32-bit float ones",
                    image->path, where, why);
}

bool image_refuse_broken(const struct image *image, int page, struct error *err)
{
    const char *message = image->file->client.message;
    if (strncmp(message, "Not a TIFF", 10) == 0)
        return image_refuse(image, page, err, "its format is not known; convert it");
    return image_refuse(image, page, err, "libtiff: %.255s",
                        message[0] != '\0' ? message : "its pages cannot be read");
}

/* Returns a number of the current directory; UINT16_MAX: it has none, and there is no default. */
static uint16_t short_tag(TIFF *tiff, uint32_t tag)
{
    uint16_t value = UINT16_MAX;
    TIFFGetFieldDefaulted(tiff, tag, &value);
    return value;
}

/* Returns whether GDAL has left out blocks that hold nothing. */
static bool is_sparse(TIFF *tiff)
{
    const uint32_t n = TIFFIsTiled(tiff) ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff);
    bool sparse = false;
    for (uint32_t i = 0; i < n && !sparse; i++)
        sparse = block_is_missing(tiff, i);
    return sparse;
}

static bool blocks_find(const struct image *image, int page, struct sample_layout *out,
                        struct error *err)
{
    TIFF *tiff = image->tiff;
    const double bytes = (double)out->width * out->height * out->n_samples * out->bits / 8;
    if (short_tag(tiff, TIFFTAG_COMPRESSION) == COMPRESSION_NONE && !is_sparse(tiff) &&
        bytes > (double)image->bytes)
        return image_refuse(image, page, err, "its pixels are %.0f bytes, the file is shorter",
                            bytes);
    if ((double)out->width * (double)out->pixel_step * out->bits / 8 > (double)PTRDIFF_MAX)
        return image_refuse(image, page, err, "its rows are too long for this computer");
    out->row_bytes = (size_t)out->width * out->pixel_step * (out->bits / 8u);
    out->tiled = TIFFIsTiled(tiff);
    out->block_width = out->width;
    if (out->tiled)
        TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &out->block_width);
    TIFFGetFieldDefaulted(tiff, out->tiled ? TIFFTAG_TILELENGTH : TIFFTAG_ROWSPERSTRIP,
                          &out->block_height);
    if (!out->tiled && out->block_height > out->height)
        out->block_height = out->height;
    out->block_bytes = out->tiled ? TIFFTileSize64(tiff) : TIFFStripSize64(tiff);
    return out->block_bytes > 0 || image_refuse_broken(image, page, err);
}

/* Finds where the rows of all planes begin if they lie one after the other, uncompressed, as in
 * most stacks: such rows are read without libtiff. Refuses a file that ends before the last row. */
static bool rows_find(const struct image *image, int page, struct sample_layout *out,
                      struct error *err)
{
    TIFF *tiff = image->tiff;
    const uint32_t n = TIFFNumberOfStrips(tiff);
    const uint32_t per_plane = (out->height - 1) / out->block_height + 1;
    const uint64_t first = TIFFGetStrileOffset(tiff, 0);
    const size_t fitting = ((size_t)1 << 18) / out->row_bytes;
    uint64_t end = first;
    if (out->tiled || short_tag(tiff, TIFFTAG_COMPRESSION) != COMPRESSION_NONE ||
        short_tag(tiff, TIFFTAG_FILLORDER) != FILLORDER_MSB2LSB)
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
    out->block_height = fitting < 1 ? 1 : fitting < out->height ? (uint32_t)fitting : out->height;
    return end <= image->bytes ||
           image_refuse(image, page, err, "its pixels end beyond the end of the file");
}

/* Returns whether the current directory is another form of a page: an overview, a thumbnail or a
 * mask (TIFF 6.0, NewSubfileType). GDAL writes them behind the pages. */
static bool is_subfile(TIFF *tiff)
{
    uint32_t type = 0;
    TIFFGetField(tiff, TIFFTAG_SUBFILETYPE, &type);
    return (type & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
}

/* Returns whether only subfiles follow the first directory. */
static bool is_only_page(TIFF *tiff)
{
    bool only = true;
    if (TIFFCurrentDirectory(tiff) != 0)
        return TIFFLastDirectory(tiff);
    while (only && !TIFFLastDirectory(tiff) && TIFFReadDirectory(tiff))
        only = is_subfile(tiff);
    TIFFSetDirectory(tiff, 0);
    return only;
}

/* Returns the number of grey samples a pixel if the file has one directory and no alpha. Returns 1
 * for every other page, and for every page but the first. */
static uint16_t count_bands(const struct image *image)
{
    TIFF *tiff = image->tiff;
    const uint16_t n_samples = short_tag(tiff, TIFFTAG_SAMPLESPERPIXEL);
    uint16_t n_extra = 0, *extra = NULL;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &n_extra, &extra);
    if (image->n_pages > 0 || short_tag(tiff, TIFFTAG_PHOTOMETRIC) >= PHOTOMETRIC_RGB ||
        n_samples != n_extra + 1)
        return 1;
    for (int i = 0; i < n_extra; i++)
        if (extra[i] != EXTRASAMPLE_UNSPECIFIED)
            return 1;
    return n_samples > 1 && is_only_page(tiff) ? n_samples : 1;
}

/* Returns true if a pixel has its colours, at most one alpha behind them, and nothing else. */
static bool colours_alone(TIFF *tiff, const struct sample_layout *layout)
{
    uint16_t n_extra = 0, *extra = NULL;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &n_extra, &extra);
    return layout->n_samples == layout->n_colours + n_extra &&
           (n_extra == 0 || (n_extra == 1 && extra[0] != EXTRASAMPLE_UNSPECIFIED));
}

static bool samples_find(const struct image *image, int page, struct sample_layout *out,
                         struct error *err)
{
    TIFF *tiff = image->tiff;
    const uint16_t format = short_tag(tiff, TIFFTAG_SAMPLEFORMAT);
    const bool separate = short_tag(tiff, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_SEPARATE;
    uint16_t photometric = short_tag(tiff, TIFFTAG_PHOTOMETRIC);
    if (photometric == PHOTOMETRIC_YCBCR && !separate &&
        short_tag(tiff, TIFFTAG_COMPRESSION) == COMPRESSION_JPEG &&
        TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB))
        photometric = PHOTOMETRIC_RGB;
    if (photometric > PHOTOMETRIC_RGB) /* the two kinds of grey have smaller numbers */
        return image_refuse(image, page, err, "its colours are neither grey nor RGB");
    out->bits = short_tag(tiff, TIFFTAG_BITSPERSAMPLE);
    out->n_samples = short_tag(tiff, TIFFTAG_SAMPLESPERPIXEL);
    out->inverted = photometric == PHOTOMETRIC_MINISWHITE;
    out->n_colours = photometric == PHOTOMETRIC_RGB ? 3 : 1;
    out->n_planes = separate ? out->n_colours : 1;
    out->pixel_step = separate ? 1 : out->n_samples;
    out->n_bands = count_bands(image);
    out->largest = out->bits == 8 ? 255 : out->bits == 16 ? 65535 : 1;
    if (out->n_bands == 1 && !colours_alone(tiff, out))
        return image_refuse(image, page, err,
                            "it has %d samples a pixel instead of %d and at most an alpha; more are"
                            " bands if they are grey and in the file's only directory",
                            out->n_samples, out->n_colours);
    return (format == SAMPLEFORMAT_UINT && (out->bits == 8 || out->bits == 16)) ||
           (format == SAMPLEFORMAT_IEEEFP && out->bits == 32 &&
            photometric == PHOTOMETRIC_MINISBLACK) ||
           image_refuse(image, page, err, "its samples are %d of %d bits, %s", out->n_samples,
                        out->bits,
                        format == SAMPLEFORMAT_UINT     ? "unsigned"
                        : format == SAMPLEFORMAT_IEEEFP ? "float"
                                                        : "of another kind");
}

bool image_layout(const struct image *image, int page, struct sample_layout *out, struct error *err)
{
    TIFF *tiff = image->tiff;
    const uint16_t orientation = short_tag(tiff, TIFFTAG_ORIENTATION);
    const uint16_t compression = short_tag(tiff, TIFFTAG_COMPRESSION);
    uint32_t depth = 1;
    *out = (struct sample_layout){.directory = TIFFCurrentDirOffset(tiff)};
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &out->width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &out->height);
    TIFFGetField(tiff, TIFFTAG_IMAGEDEPTH, &depth);
    if (out->width - 1 >= LONGEST_SIDE || out->height - 1 >= LONGEST_SIDE || depth != 1)
        return image_refuse(image, page, err,
                            "it has %" PRIu32 "x%" PRIu32 "x%" PRIu32
                            " pixels; a side has 1 to %d, and the depth is 1",
                            out->width, out->height, depth, LONGEST_SIDE);
    if (orientation != ORIENTATION_TOPLEFT)
        return image_refuse(image, page, err, "its orientation is %d, not 1 (the top row first)",
                            orientation);
    /* JBIG stores 1 bit a pixel. raster/gl/static.sh leaves its library out. */
    if (compression == COMPRESSION_JBIG || !TIFFIsCODECConfigured(compression))
        return image_refuse(image, page, err, "its compression (%d) cannot be read", compression);
    return samples_find(image, page, out, err) && blocks_find(image, page, out, err) &&
           rows_find(image, page, out, err);
}

/* ---- opening ---- */

/* Finds the scale. Float samples are radiances themselves. Counts have the same scale in all pages.
 */
static bool find_scale(struct image *image, int page, const struct page_record *record,
                       struct error *err)
{
    const struct sample_layout *layout = &image->file->pages[page];
    const double plain = 1 / layout->largest;
    const double count_scale = record->count_scale < 0 ? plain : record->count_scale;
    if (layout->bits == 32)
        return true;
    if (record->offset != 0)
        return image_refuse(image, page, err, "its samples have an offset");
    if (page == 0) {
        image->file->count_scale = count_scale;
        image->scale = !(record->full_scale < 0) ? record->full_scale
                       : count_scale == plain    ? 1
                                                 : count_scale * layout->largest;
    }
    return (image->scale > 0 && image->scale <= DBL_MAX &&
            count_scale == image->file->count_scale) ||
           image_refuse(image, page, err,
                        "its scale is not positive, or not that of the first page");
}

/* Notes why the wavelengths cannot be used, if the page added last is the reason. */
static void check_wavelength(struct image *image, const char *unit)
{
    const int page = image->n_pages;
    const double nm = image->wavelengths_nm[page - 1];
    const double before = page > 1 ? image->wavelengths_nm[page - 2] : 0;
    char *why = image->no_wavelengths;
    const size_t room = sizeof image->no_wavelengths;
    if (why[0] != '\0' || nm > before)
        return;
    if (nm > 0)
        snprintf(why, room, "its wavelengths %s: page %d records %.10g nm after %.10g nm",
                 nm < before ? "decrease" : "repeat", page, nm, before);
    else if (nm == 0)
        snprintf(why, room,
                 "page %d records its wavelength in '%s'; expected a unit such as nm or um", page,
                 unit);
    else
        snprintf(why, room, "page %d records no wavelength", page);
}

/* Adds the next band of the current directory as a page. The first band decides the layout. */
static bool page_add(struct image *image, int band, const struct page_record *record,
                     struct error *err)
{
    struct image_file *file = image->file;
    const int page = image->n_pages;
    int n_layouts = page, n_nm = page;
    if (!array_add(&file->pages, &n_layouts, NULL, sizeof *file->pages, err) ||
        !array_add(&image->wavelengths_nm, &n_nm, &record->wavelength_nm, sizeof(double), err))
        return false;
    struct sample_layout *pages = file->pages, *layout = &pages[page];
    if (band > 0) {
        *layout = pages[0];
        *(layout->pixel_step == 1 ? &layout->plane : &layout->sample) = (uint16_t)band;
    } else if (!image_layout(image, page, layout, err)) {
        return false;
    }
    if (layout->width != pages->width || layout->height != pages->height ||
        layout->bits != pages->bits)
        return image_refuse(
            image, page, err,
            "it has %" PRIu32 "x%" PRIu32 "x%d bits, the first page %" PRIu32 "x%" PRIu32 "x%d",
            layout->width, layout->height, layout->bits, pages->width, pages->height, pages->bits);
    layout->has_nodata = record->has_nodata && layout->n_colours == 1;
    layout->nodata = layout->bits == 32 ? round_to_single(record->nodata) : record->nodata;
    image->coloured = image->coloured || layout->n_colours > 1;
    file->directory = layout->directory;
    image->n_pages++;
    if (!find_scale(image, page, record, err))
        return false;
    check_wavelength(image, record->unit);
    return true;
}

static bool directory_add(struct image *image, image_tags *read_tags, struct error *err)
{
    const int n_bands = count_bands(image);
    struct page_record *records;
    bool good = MAKE_ARRAY(records, n_bands, err, "the bands of %s", image->path) &&
                read_tags(image, n_bands, records, err);
    for (int band = 0; good && band < n_bands; band++)
        good = page_add(image, band, &records[band], err);
    free(records);
    return good && source_is_sound(image, err);
}

/* Drops the wavelengths where they cannot be used. */
static bool wavelengths_keep(struct image *image, struct error *err)
{
    const struct sample_layout *first = image->file->pages;
    bool recorded = false;
    for (int page = 0; page < image->n_pages; page++)
        recorded = recorded || !isnan(image->wavelengths_nm[page]);
    if (!recorded && first->n_bands > 1)
        return image_refuse(image, -1, err,
                            "it has %d samples a pixel and records no wavelengths for them",
                            first->n_samples);
    if (!recorded)
        snprintf(image->no_wavelengths, sizeof image->no_wavelengths, "records no wavelengths");
    if (image->no_wavelengths[0] != '\0') {
        free(image->wavelengths_nm);
        image->wavelengths_nm = NULL;
    }
    return true;
}

/* Refuses another number of pages than the recorded one: for libtiff a damaged link to the next
 * page is the end. */
static bool pages_read(struct image *image, image_tags *read_tags, struct error *err)
{
    struct image_file *file = image->file;
    for (bool more = true; more;) {
        if (!source_is_sound(image, err) ||
            (!is_subfile(image->tiff) && !directory_add(image, read_tags, err)))
            return false;
        more = !TIFFLastDirectory(image->tiff);
        if (more && !TIFFReadDirectory(image->tiff))
            return image_refuse_broken(image, -1, err);
    }
    if (image->n_pages == 0)
        return image_refuse(image, -1, err, "it has only overviews or masks");
    if (image->n_recorded != 0 && image->n_recorded != image->n_pages)
        return image_refuse(image, -1, err,
                            "it has %d pages, but records %d; it was cut or damaged",
                            image->n_pages, image->n_recorded);
    image->width = (int)file->pages->width;
    image->height = (int)file->pages->height;
    return wavelengths_keep(image, err);
}

/* ---- colours as wavelengths ---- */

const double rgb_knot_nm[RGB_KNOTS] = {1, 480, 500, 570, 600, 999999};
const int rgb_knot_colour[RGB_KNOTS] = {2, 2, 1, 1, 0, 0};

bool image_spread(struct image *image, struct error *err)
{
    struct sample_layout page = image->file->pages[0];
    int n_nm = 0;
    if (image->n_pages != 1)
        return image_refuse(image, -1, err, "it has %d pages; a picture has one", image->n_pages);
    image->n_pages = 0;
    for (int i = 0; i < RGB_KNOTS; i++) {
        page.colour = (uint16_t)(rgb_knot_colour[i] + 1);
        if (!array_add(&image->file->pages, &image->n_pages, &page, sizeof page, err) ||
            !array_add(&image->wavelengths_nm, &n_nm, &rgb_knot_nm[i], sizeof(double), err))
            return false;
    }
    return true;
}

/* ---- the file ---- */

bool image_is(const char *path, bool *out, struct error *err)
{
    const char *format;
    const bool done = file_format(path, &format, err);
    *out = done && (strcmp(format, "TIFF") == 0 || strcmp(format, "ENVI") == 0);
    return done;
}

/* Refuses a picture of another format, with the command that converts it. GDAL's options write a
 * cube's samples of any type, times their gains, as floats. */
static bool refuse_foreign(const struct image *image, const char *format, struct error *err)
{
    const char *path = image->path;
    const struct place from = image->file->from;
    if (format[0] == '\0' || strcmp(format, "TIFF") == 0 || image_converts(format))
        return true;
    if (strcmp(format, "text") == 0)
        return error_at(err, from, "%s is a text file; expected TIFF", path);
    if (!format_is_picture(format))
        return error_at(err, from, "%s has the format %s; expected TIFF", path, format);
    const bool is_cube = strcmp(format, "ENVI") == 0;
    char *data = is_cube ? envi_data(path) : strdup(path), *names = NULL;
    char *converted = data ? output_name(data, ".tif", err) : NULL;
    struct printed shell = {.text = NULL};
    if (converted) {
        print_shell(&shell, data);
        print_shell(&shell, converted);
        names = printed_take(&shell, err);
    }
    if (!names)
        memory_lacks(err, (double)strlen(path), "the name of %s", path);
    else if (is_cube && !file_format(data, &format, err))
        ;
    else if (strcmp(format, "TIFF") == 0)
        error_at(err, from, "%s is the ENVI header of %s; expected the name of that file", path,
                 data);
    else if (is_cube)
        error_at(err, from,
                 "%s is an ENVI cube; expected TIFF, as GDAL writes by: gdal_translate -unscale"
                 " -ot Float32%s",
                 path, names);
    else
        error_at(err, from, "%s is a %s file; expected TIFF, as 'convert%s' of ImageMagick writes",
                 path, format, names);
    FREE_ALL(data, converted, names);
    return false;
}

/* The C library sets errno where it has no memory. Nothing sets it to 0 again but client_open. */
bool source_is_sound(const struct image *image, struct error *err)
{
    struct client *client = &image->file->client;
    if (client->cause == 0 && errno == ENOMEM)
        client->cause = ENOMEM;
    errno = client->cause;
    return client->cause == 0 ||
           (client->cause == ENOMEM ? memory_lacks(err, 0, "libtiff, which reads %s", image->path)
                                    : error_system(err, "cannot read %s", image->path));
}

/* Opens the file with libtiff, and finds its size. */
static bool open_source(struct image *image, const char *format, struct error *err)
{
    struct image_file *file = image->file;
    struct client *client = &file->client;
    struct stat status = {.st_size = 0};
    if (!file_open(image->path, file->from, &client->descriptor, &client->builtin, err))
        return false;
    if (!client->builtin && fstat(client->descriptor, &status) != 0)
        return error_cause(err, file->from, "cannot read %s", image->path);
    client->bytes = client->builtin ? client->builtin->length : (uint64_t)status.st_size;
    image->bytes = client->bytes;
    if (image_converts(format))
        return foreign_read(image, format, err);
    image->tiff = client_open(client, image->path, "rmc");
    return source_is_sound(image, err) &&
           (image->tiff != NULL || image_refuse_broken(image, -1, err));
}

bool image_open(const char *path, struct place from, image_tags *read_tags, struct image *out,
                struct error *err)
{
    const char *format;
    *out = (struct image){.scale = 1};
    if (!string_copy(path, &out->path, err) ||
        !MAKE_ARRAY(out->file, 1, err, "the pages of %s", path))
        return false;
    out->file->from = from;
    out->file->client.descriptor = -1;
    return file_format(path, &format, err) && refuse_foreign(out, format, err) &&
           open_source(out, format, err) &&
           (image_converts(format) || pages_read(out, read_tags, err));
}

bool image_has_alpha(const struct image *image)
{
    const struct sample_layout *layout = image->file->pages;
    return layout->n_bands == 1 && layout->n_samples > layout->n_colours;
}

bool image_is_float(const struct image *image)
{
    return image->file->pages->bits == 32; /* as all pages: floats are grey */
}

double image_rounding(const struct image *image, double value)
{
    const double float_rounding = 0x1p-24;
    if (!image->file)
        return 0;
    return image_is_float(image) ? fabs(value) * float_rounding
                                 : image->scale / (ldexp(1, image->file->pages->bits) - 1) / 2;
}

void image_close(struct image *image)
{
    struct image_file *file = image->file;
    if (file != NULL) {
        if (image->tiff != NULL)
            TIFFClose(image->tiff);
        if (file->client.descriptor >= 0)
            close(file->client.descriptor);
        FREE_ALL(file->pixels, file->pages, file->kept.values, file);
    }
    FREE_ALL(image->path, image->description, image->verdict, image->wavelengths_nm);
    *image = (struct image){0};
}
