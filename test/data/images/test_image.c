/* SPDX-License-Identifier: MIT */
/* level: full; packages: python3-numpy python3-tifffile python3-gdal */
/* Reads one picture back to the same radiances from every variant of TIFF. The picture has a closed
 * form; libtiff writes it here, tifffile writes it in test/data/images/images.py, and the program
 * writes it itself. Files that are broken, cut short or of another kind are refused. */
#include <fcntl.h>

#include "bytes.h"
#include "data/base/inside.h"
#include "data/images/images.h"
#include "data/stack/stack.h"
#include "spectral.h"
#include "tiff.h"

enum { WIDTH = 37, HEIGHT = 29, PAGES = 3, PIXELS = WIDTH * HEIGHT };

static const struct place from = {"a.scene", 3, 7};
static const char *const path = "image.tif";
static const TIFFFieldInfo gdal_field[] = {
    {TIFFTAG_GDAL_METADATA, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, (char[]){"GDALMetadata"}}};

/* The picture: neighbours, samples and pages all differ. */
static uint32_t count_at(int page, int x, int y, int sample, int bits)
{
    const uint32_t count = (uint32_t)(7 * x + 131 * y + 1009 * sample + 4099 * page + 1);
    return bits == 8 ? count % 256 : count;
}

/* A variant of a page; zeros are defaults. */
struct variant {
    const char *name, *mode;
    int bits, n_samples, photometric, compression, predictor;
    int tile, rows; /* sides of tiles, rows of a strip */
    int width, height;
    bool separate;
    int format, extra, orientation, fill_order;
    const char *page_name, *gdal, *description;
    double odd; /* instead of the last float sample */
};

static void set_tags(TIFF *tiff, const struct variant *v)
{
    const uint16_t extra = (uint16_t)v->extra, colours[256] = {0};
    const bool ycbcr = v->photometric == PHOTOMETRIC_YCBCR;
    const int n_colours = v->photometric == PHOTOMETRIC_RGB || ycbcr ? 3 : 1;
    TIFFMergeFieldInfo(tiff, gdal_field, 1);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, v->width > 0 ? v->width : WIDTH);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, v->height > 0 ? v->height : HEIGHT);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, v->bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, v->n_samples);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, v->photometric);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, v->compression > 0 ? v->compression : COMPRESSION_NONE);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG,
                 v->separate ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, v->format > 0 ? v->format : SAMPLEFORMAT_UINT);
    if (v->predictor > 0)
        TIFFSetField(tiff, TIFFTAG_PREDICTOR, v->predictor);
    if (ycbcr && v->separate)
        TIFFSetField(tiff, TIFFTAG_YCBCRSUBSAMPLING, 1, 1);
    if (ycbcr && !v->separate)
        TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    if (v->compression == COMPRESSION_WEBP)
        TIFFSetField(tiff, TIFFTAG_WEBP_LOSSLESS, 1);
    if (v->n_samples == n_colours + 1)
        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &extra);
    if (v->photometric == PHOTOMETRIC_PALETTE)
        TIFFSetField(tiff, TIFFTAG_COLORMAP, colours, colours, colours);
    if (v->fill_order > 0)
        TIFFSetField(tiff, TIFFTAG_FILLORDER, v->fill_order);
    if (v->orientation > 0)
        TIFFSetField(tiff, TIFFTAG_ORIENTATION, v->orientation);
    if (v->tile > 0) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, v->tile);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, v->tile);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, v->rows > 0 ? v->rows : HEIGHT);
    }
    if (v->page_name != NULL)
        TIFFSetField(tiff, TIFFTAG_PAGENAME, v->page_name);
    if (v->gdal != NULL)
        TIFFSetField(tiff, TIFFTAG_GDAL_METADATA, v->gdal);
    if (v->description != NULL)
        TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, v->description);
}

/* A row, or of a tiled file a row of a tile, from x on. */
static void fill(unsigned char *out, const struct variant *v, int page, int x, int width, int y,
                 int plane)
{
    const int step = v->separate ? 1 : v->n_samples;
    for (int i = 0; i < width * step; i++) {
        const int sample = v->separate ? plane : i % step, column = x + i / step;
        const uint32_t count = count_at(page, column, y, sample, v->bits);
        const bool odd = v->odd != 0 && column == WIDTH - 1 && y == HEIGHT - 1;
        if (v->bits == 32)
            ((float *)(void *)out)[i] = odd ? (float)v->odd : (float)count / 64;
        else if (v->bits == 16)
            ((uint16_t *)(void *)out)[i] = (uint16_t)count;
        else
            out[i] = (unsigned char)count;
    }
}

static bool write_page(TIFF *tiff, const struct variant *v, int page)
{
    static unsigned char bytes[64 * 64 * 4 * 8];
    const int n_planes = v->separate ? v->n_samples : 1, width = v->width > 0 ? v->width : WIDTH;
    const size_t pixel = (size_t)(v->separate ? 1 : v->n_samples) * (size_t)v->bits / 8;
    bool good = true;
    set_tags(tiff, v);
    for (int plane = 0; plane < n_planes; plane++)
        if (v->tile == 0)
            for (int y = 0; y < HEIGHT; y++) {
                fill(bytes, v, page, 0, width, y, plane);
                good = TIFFWriteScanline(tiff, bytes, (uint32_t)y, (uint16_t)plane) == 1 && good;
            }
        else
            for (int y = 0; y < HEIGHT; y += v->tile)
                for (int x = 0; x < width; x += v->tile) {
                    for (int row = 0; row < v->tile; row++)
                        fill(bytes + (size_t)(row * v->tile) * pixel, v, page, x, v->tile, y + row,
                             plane);
                    good = TIFFWriteTile(tiff, bytes, (uint32_t)x, (uint32_t)y, 0,
                                         (uint16_t)plane) > 0 &&
                           good;
                }
    return TIFFWriteDirectory(tiff) == 1 && good;
}

static bool write_pages(const struct variant *variants, int n)
{
    unlink(path);
    TIFF *tiff = tiff_open(path, variants[0].mode != NULL ? variants[0].mode : "w");
    bool good = tiff != NULL;
    for (int page = 0; good && page < n; page++)
        good = write_page(tiff, &variants[page], page);
    if (tiff != NULL)
        TIFFClose(tiff);
    return good;
}

/* Returns the expected value of a pixel, with ITU-R BT.709's luma. */
static double radiance_at(const struct variant *v, int page, int x, int y, double scale)
{
    const double largest = v->bits == 8 ? 255 : v->bits == 16 ? 65535 : 64;
    double sample[3] = {0};
    for (int i = 0; i < 3; i++)
        sample[i] = count_at(page, x, y, i, v->bits) / largest;
    if (v->photometric == PHOTOMETRIC_MINISWHITE)
        return (1 - sample[0]) * scale;
    return (v->photometric == PHOTOMETRIC_RGB
                ? 0.2126 * sample[0] + 0.7152 * sample[1] + 0.0722 * sample[2]
                : sample[0]) *
           scale;
}

/* Grey is exact: the nearest float. A sum of three may be a unit in the last place off. */
static void check_page(struct image *image, const struct variant *v, int page, double scale)
{
    float seen[PIXELS];
    struct error err = {0};
    double furthest = 0;
    for (int i = 0; i < PIXELS; i++)
        seen[i] = -1;
    if (!CHECK(image_read(image, page, 0, image->height, seen, &err), "%s: page %d is read %s",
               v->name, page, err.text))
        return;
    for (int i = 0; i < PIXELS; i++) {
        const double expected = radiance_at(v, page, i % WIDTH, i / WIDTH, scale);
        const double allowed = v->photometric == PHOTOMETRIC_MINISBLACK ? 0 : expected * 1.2e-7;
        const double off = fabs((double)seen[i] - (double)(float)expected) - allowed;
        furthest = off > furthest ? off : furthest;
    }
    CHECK_NEAR(furthest, 0, 0, "%s: every value of page %d is right", v->name, page);
}

/* Any number of rows, from any place, in any order of pages and rows, equals the rows of whole
 * pages. */
static void check_rows(struct image *image, const char *name)
{
    static float whole[PAGES][PIXELS], some[PIXELS];
    const int sizes[] = {1, 4, 7, HEIGHT - 1};
    struct error err = {0};
    bool same = true;
    for (int page = 0; page < image->n_pages; page++)
        same = same && image_read(image, page, 0, HEIGHT, whole[page], &err);
    for (int i = 0; i < 4; i++)
        for (int y = HEIGHT - sizes[i]; y >= 0; y -= sizes[i] > 7 ? 1 : 3)
            for (int k = 0; k < image->n_pages; k++) {
                const int page = (y + k) % image->n_pages;
                const size_t n = (size_t)sizes[i] * WIDTH;
                same = same && image_read(image, page, y, sizes[i], some, &err) &&
                       memcmp(some, whole[page] + (size_t)y * WIDTH, n * sizeof *some) == 0;
            }
    CHECK(same, "%s: rows read alone equal those of the whole page %s", name, err.text);
}

/* Opens a file and checks all that it records; nm: NULL if it records no wavelengths. All pages are
 * like v, or each like its own if there are several variants. */
static void check_file(const char *file, const char *name, const struct variant *v, int n_variants,
                       int n_pages, const double *nm, double scale)
{
    struct image image;
    struct error err = {0};
    if (CHECK(image_open(file, from, tags_read, &image, &err), "%s: opens %s", name, err.text) &&
        CHECK(image.width == WIDTH && image.height == HEIGHT && image.n_pages == n_pages,
              "%s: it has %dx%d pixels and %d pages", name, image.width, image.height,
              image.n_pages)) {
        CHECK((image.wavelengths_nm != NULL) == (nm != NULL), "%s: wavelengths are %s", name,
              nm != NULL ? "recorded" : "not recorded");
        for (int page = 0; page < n_pages && nm != NULL && image.wavelengths_nm != NULL; page++)
            CHECK_NEAR(image.wavelengths_nm[page], nm[page], 1e-12, "%s: the wavelength of page %d",
                       name, page);
        CHECK_NEAR(image.scale, scale, 0, "%s: the scale", name);
        for (int page = n_pages - 1; page >= 0; page--)
            check_page(&image, &v[page % n_variants], page, scale);
        check_rows(&image, name);
    }
    image_close(&image);
    image_close(&image);
}

static void check_written(const char *name, const struct variant *pages, int n, const double *nm,
                          double scale)
{
    if (CHECK(write_pages(pages, n), "%s: is written", name))
        check_file(path, name, pages, n, n, nm, scale);
}

static void test_variants(void)
{
    const struct variant variants[] = {
        {"grey 8", NULL, 8, 1, .photometric = 1},
        {"grey 16, strips of 5 rows", NULL, 16, 1, .photometric = 1, .rows = 5},
        {"grey 16, big-endian strips", "wb", 16, 1, .photometric = 1, .rows = 5},
        {"float, big-endian", "wb", 32, 1, .photometric = 1, .format = SAMPLEFORMAT_IEEEFP},
        {"RGB 16 apart, big-endian", "wb", 16, 3, .photometric = 2, .separate = true, .rows = 4},
        {"RGB 8 apart, one strip each", NULL, 8, 3, .photometric = 2, .separate = true},
        {"bits in the other order", NULL, 16, 1, .photometric = 1, .fill_order = FILLORDER_LSB2MSB},
        {"white is 0", NULL, 8, 1, .photometric = 0},
        {"white is 0 of 16 bits", NULL, 16, 1, .photometric = 0},
        {"float", NULL, 32, 1, .photometric = 1, .format = SAMPLEFORMAT_IEEEFP},
        {"float, big-endian, tiles", "wb", 32, 1, .photometric = 1, .format = SAMPLEFORMAT_IEEEFP,
         .tile = 16},
        {"float, predicted", NULL, 32, 1, .photometric = 1, COMPRESSION_ADOBE_DEFLATE, 3,
         .format = SAMPLEFORMAT_IEEEFP},
        {"grey and alpha", NULL, 16, 2, .photometric = 1, .extra = EXTRASAMPLE_UNASSALPHA},
        {"grey and alpha apart", NULL, 8, 2, .photometric = 1, .extra = EXTRASAMPLE_ASSOCALPHA,
         .separate = true},
        {"RGB 16 in tiles", NULL, 16, 3, .photometric = 2, .tile = 16},
        {"RGB 16 apart", NULL, 16, 3, .photometric = 2, .separate = true, .rows = 4},
        {"RGB 16 apart in tiles", NULL, 16, 3, .photometric = 2, .separate = true, .tile = 32},
        {"RGBA 8", NULL, 8, 4, .photometric = 2, .extra = EXTRASAMPLE_ASSOCALPHA},
        {"RGBA 16 apart", NULL, 16, 4, .photometric = 2, .extra = EXTRASAMPLE_UNASSALPHA,
         .separate = true},
        {"LZW, predicted", NULL, 16, 3, .photometric = 2, COMPRESSION_LZW, .predictor = 2,
         .rows = 7},
        {"deflate in tiles", NULL, 16, 1, .photometric = 1, COMPRESSION_DEFLATE, .tile = 48},
        {"PackBits", NULL, 8, 1, .photometric = 1, COMPRESSION_PACKBITS, .rows = 3},
        {"Zstandard, predicted", NULL, 16, 1, .photometric = 1, COMPRESSION_ZSTD, .predictor = 2},
        {"LERC", NULL, 32, 1, .photometric = 1, COMPRESSION_LERC, .format = SAMPLEFORMAT_IEEEFP},
        {"WebP", NULL, 8, 3, .photometric = 2, .compression = COMPRESSION_WEBP},
    };
    for (size_t i = 0; i < sizeof variants / sizeof variants[0]; i++)
        check_written(variants[i].name, &variants[i], 1, NULL, 1);
}

/* Writes a page whose rows are all the same, and reads it. */
static void read_rows(const struct variant *v, void *row, float *seen)
{
    struct image image;
    struct error err = {0};
    TIFF *tiff = tiff_open(path, "w");
    set_tags(tiff, v);
    for (int y = 0; y < v->height; y++)
        TIFFWriteScanline(tiff, row, (uint32_t)y, 0);
    TIFFClose(tiff);
    CHECK(image_open(path, from, tags_read, &image, &err) &&
              image_read(&image, 0, 0, v->height, seen, &err),
          "%s: is read %s", v->name, err.text);
    image_close(&image);
}

/* A uniform colour survives JPEG but for rounding. The file holds ITU-R BT.601's luma; the reader
 * computes BT.709's. */
static void test_jpeg(void)
{
    enum { SIDE = 32 };
    const struct variant v = {
        "JPEG",        NULL,          8, 3, PHOTOMETRIC_YCBCR, COMPRESSION_JPEG, .rows = 16,
        .width = SIDE, .height = SIDE};
    const unsigned char colour[3] = {200, 100, 50};
    const double luma = (0.2126 * 200 + 0.7152 * 100 + 0.0722 * 50) / 255;
    unsigned char row[SIDE * 3];
    float seen[SIDE * SIDE];
    double furthest = 0;
    for (int i = 0; i < SIDE * 3; i++)
        row[i] = colour[i % 3];
    read_rows(&v, row, seen);
    for (int i = 0; i < SIDE * SIDE; i++)
        furthest = fmax(furthest, fabs((double)seen[i] - luma));
    CHECK_NEAR(furthest, 0, 1.5 / 255, "JPEG is read as RGB and reduced to its luma");
}

/* Three equal samples give the same grey as one, to the bit; white is 1. */
static void test_luma(void)
{
    enum { GREYS = 65536 };
    const struct variant one = {"grey", NULL, 16, 1, .photometric = 1, .width = GREYS, .height = 1};
    const struct variant three = {"RGB",          NULL,       16, 3, .photometric = 2,
                                  .width = GREYS, .height = 1};
    static uint16_t grey[GREYS], colour[GREYS * 3];
    static float seen[2][GREYS];
    bool right = true;
    for (int i = 0; i < GREYS; i++)
        grey[i] = colour[3 * i] = colour[3 * i + 1] = colour[3 * i + 2] = (uint16_t)i;
    read_rows(&one, grey, seen[0]);
    read_rows(&three, colour, seen[1]);
    for (int i = 0; i < GREYS; i++)
        right = right && (double)seen[1][i] == (double)(float)(i / 65535.0);
    CHECK(right, "all 65536 greys are right");
    CHECK(memcmp(seen[0], seen[1], sizeof seen[0]) == 0,
          "they are equal from one sample and three");
}

/* ---- wavelengths and scale ---- */

#define PAGE NULL, NULL, 16, 1, .photometric = 1
#define ITEM(name, rest, value) "<Item name=\"" name "\" sample=\"0\"" rest ">" value "</Item>"
#define NANOMETERS(value) ITEM("wavelength", "", value) ITEM("wavelength_units", "", "Nanometers")
#define MICROMETRES(value) ITEM("CENTRAL_WAVELENGTH_UM", " domain=\"IMAGERY\"", value)
#define SCALE(value) ITEM("SCALE", " role=\"scale\"", value)
#define OFFSET(value) ITEM("OFFSET", " role=\"offset\"", value)

/* test_cube.c has wavelengths that repeat, decrease or are missing. */
static void test_told(void)
{
    const double nm[] = {400.5, 500, 700}, close[] = {500, 500.0000001};
    const struct variant
        mixed[] = {{PAGE, .page_name = "4005e-1 nm", .gdal = MICROMETRES("0.3")},
                   {PAGE, .page_name = "500", .gdal = NANOMETERS("500") MICROMETRES("0.3")},
                   {PAGE, .page_name = "Page 3", .gdal = MICROMETRES("0.7")}},
        zero[] = {{PAGE, .page_name = "0 nm"}, {PAGE, .page_name = "400 nm"}},
        near[] = {{PAGE, .page_name = "500 nm"}, {PAGE, .page_name = "500.0000001 nm"}},
        metres[] = {{PAGE, .gdal = ITEM("wavelength", "", "0.5")}},
        scaled[] = {{PAGE, .gdal = SCALE("0.001") OFFSET("0")}, {PAGE, .gdal = SCALE("0.001")}},
        bytes[] = {{NULL, NULL, 8, 1, .photometric = 1, .gdal = SCALE("2")}},
        exact[] = {{PAGE, .gdal = SCALE("3.8e-05"), .description = "a\nfull_scale: 2.5\nscale: x"}},
        floating[] = {{NULL, NULL, 32, 1, .photometric = 1, .format = SAMPLEFORMAT_IEEEFP,
                       .gdal = SCALE("1"), .description = "full_scale: 7\n"}};
    check_written("names, GDAL's nanometers and its micrometres", mixed, 3, nm, 1);
    check_written("wavelength 0", zero, 2, NULL, 1);
    check_written("names of ten digits", near, 2, close, 1);
    check_written("a wavelength in an unknown unit", metres, 1, NULL, 1);
    check_written("GDAL's scale", scaled, 2, NULL, 0.001 * 65535);
    check_written("GDAL's scale of bytes", bytes, 1, NULL, 510);
    check_written("an exact full scale", exact, 1, NULL, 2.5);
    check_written("float pages", floating, 1, NULL, 1);
}

/* Writes a stack of floats by the program; all are 0. */
static void write_stack(void)
{
    static const float radiance[PIXELS];
    const struct stack_options options = {.width = WIDTH,
                                          .height = HEIGHT,
                                          .n_wavelengths = PAGES,
                                          .wavelengths_nm = (const double[]){400, 500, 600},
                                          .full_scale = 1,
                                          .bits = 32,
                                          .scene = "x",
                                          .provenance = "y"};
    struct stack_writer writer;
    struct error err = {0};
    files_read_forget();
    bool good = stack_open(&writer, path, &options, &err);
    for (int page = 0; good && page < PAGES; page++)
        good = pages_write(&writer.pages, &(struct page_rectangle){page, 0, 0, WIDTH, HEIGHT},
                           radiance, &err);
    CHECK(good && stack_finish(&writer, "check: agreed", &err) &&
              output_pass(&writer.pages.output, NULL, &err),
          "a stack is written %s", err.text);
}

/* ---- written by tifffile ---- */

static void test_foreign(void)
{
    const double nm[] = {400.5, 500, 700};
    const struct {
        const char *file;
        int bits, photometric;
        bool spectral;
        double scale;
    } files[] = {{"plain.tif", 16, PHOTOMETRIC_MINISBLACK, false, 1},
                 {"big.tif", 16, PHOTOMETRIC_MINISBLACK, false, 1},
                 {"deflated.tif", 16, PHOTOMETRIC_MINISBLACK, false, 1},
                 {"lzma.tif", 16, PHOTOMETRIC_MINISBLACK, false, 1},
                 {"rgb.tif", 8, PHOTOMETRIC_RGB, false, 1},
                 {"planes.tif", 8, PHOTOMETRIC_RGB, false, 1},
                 {"named.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"micrometres.tif", 16, PHOTOMETRIC_MINISBLACK, true, 0.0001 * 65535},
                 {"nanometers.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"ome.ome.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"ome_um.ome.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"ome_angstrom.ome.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"ome_m.ome.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"bands.tif", 16, PHOTOMETRIC_MINISBLACK, true, 0.001 * 65535},
                 {"bands_apart.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"bands_um.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"bands_bytes.tif", 8, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"bands_float.tif", 32, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"bands_big_endian.tif", 32, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"bands_overviews.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"bands_deflated.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"bands_tiles.tif", 16, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"bands_tiles_apart.tif", 32, PHOTOMETRIC_MINISBLACK, true, 1},
                 {"bands_lzw_apart.tif", 8, PHOTOMETRIC_MINISBLACK, true, 1}};
    const struct {
        const char *file, *what;
    } untold[] = {{"ome_furlong.ome.tif", "page 1 records its wavelength in 'furlong'; expected"},
                  {"ome_lacking.ome.tif", "page 2 records no wavelength"},
                  {"bands_lacking.tif", "page 3 records no wavelength"},
                  {"bands_furlong.tif", "page 1 records its wavelength in 'Furlongs'; expected"},
                  {"bands_falling.tif", "decrease: page 2 records 500 nm after 700 nm"}};
    struct image image;
    struct error err = {0};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        check_file(files[i].file, files[i].file,
                   &(struct variant){.bits = files[i].bits, .photometric = files[i].photometric}, 1,
                   files[i].spectral ? PAGES : 1, files[i].spectral ? nm : NULL, files[i].scale);
    for (size_t i = 0; i < sizeof untold / sizeof untold[0]; i++) {
        if (CHECK(image_open(untold[i].file, from, tags_read, &image, &err), "%s opens %s",
                  untold[i].file, err.text))
            CHECK(image.wavelengths_nm == NULL &&
                      strstr(image.no_wavelengths, untold[i].what) != NULL,
                  "its wavelengths are refused: %s", image.no_wavelengths);
        image_close(&image);
    }
    CHECK(image_open("bands_rgb.tif", from, tags_read, &image, &err) && image.coloured &&
              image.n_pages == 1,
          "bands that are RGB are read as one page %s", err.text);
    image_close(&image);
}

/* ---- refusals ---- */

/* Checks that the file is refused in one line that begins with the place, names the file and
 * contains `what`. */
static void check_refusal(const char *file, const char *what)
{
    static float seen[PIXELS];
    struct image image;
    struct error err = {0};
    bool read = image_open(file, from, tags_read, &image, &err);
    for (int page = 0; read && page < image.n_pages; page++)
        read = image_read(&image, page, 0, image.height, seen, &err);
    CHECK(!read && err.status == EXIT_INPUT && strncmp(err.text, "a.scene:3:7: error: ", 20) == 0 &&
              strstr(err.text, file) != NULL && strstr(err.text, what) != NULL,
          "%s is refused with '%s': %s", file, what, err.text);
    image_close(&image);
}

static void test_refused_pages(void)
{
    const int floating = SAMPLEFORMAT_IEEEFP;
    const struct variant variants[] = {
        {"neither grey", NULL, 8, 1, .photometric = PHOTOMETRIC_PALETTE},
        {"neither grey", NULL, 8, 4, .photometric = PHOTOMETRIC_SEPARATED},
        {"neither grey", NULL, 8, 3, .photometric = PHOTOMETRIC_CIELAB},
        {"neither grey", NULL, 8, 3, PHOTOMETRIC_YCBCR, COMPRESSION_JPEG, .rows = 16,
         .separate = true},
        {"1 of 16 bits, of another kind", NULL, 16, 1, .photometric = 1,
         .format = SAMPLEFORMAT_INT},
        {"1 of 32 bits, unsigned", NULL, 32, 1, .photometric = 1},
        {"3 of 32 bits, float", NULL, 32, 3, .photometric = 2, .format = floating},
        {"1 of 32 bits, float", NULL, 32, 1, .photometric = 0, .format = floating},
        {"5 samples", NULL, 8, 5, .photometric = 2},
        {"2 samples a pixel and records no", NULL, 8, 2, .photometric = 1,
         .extra = EXTRASAMPLE_UNSPECIFIED},
        {"orientation is 4", NULL, 8, 1, .photometric = 1, .orientation = ORIENTATION_BOTLEFT},
        {"page 1 (305 nm): the radiance at column 36, row 28 is nan", NULL, 32, 1, .photometric = 1,
         .format = floating, .page_name = "305 nm", .odd = (double)NAN},
        {"page 1: the radiance at column 36, row 28 is inf", NULL, 32, 1, .photometric = 1,
         .format = floating, .odd = HUGE_VAL},
        {"is -0.5; expected", NULL, 32, 1, .photometric = 1, .format = floating, .odd = -0.5},
        {"scale is not positive", NULL, 16, 1, .photometric = 1, .gdal = SCALE("0")},
        {"scale is not positive", NULL, 16, 1, .photometric = 1, .gdal = SCALE("-1")},
        {"scale is not positive", NULL, 16, 1, .photometric = 1, .gdal = SCALE("2x")},
        {"scale is not positive", NULL, 16, 1, .photometric = 1,
         .description = "full_scale: nan\n"},
        {"is inf; expected a finite number", NULL, 8, 1, .photometric = 0,
         .description = "full_scale: 1e300 \n"},
        {"an offset", NULL, 16, 1, .photometric = 1, .gdal = OFFSET("-1")},
    };
    const struct variant wide[] = {{PAGE}, {NULL, NULL, 8, 1, .photometric = 1}},
                         narrow[] = {{PAGE}, {PAGE, .width = WIDTH - 1}},
                         scaled[] = {{PAGE, .gdal = SCALE("1")}, {PAGE, .gdal = SCALE("2")}};
    for (size_t i = 0; i < sizeof variants / sizeof variants[0]; i++) {
        CHECK(write_pages(&variants[i], 1), "'%s' is written", variants[i].name);
        check_refusal(path, variants[i].name);
    }
    CHECK(write_pages(wide, 2), "pages of 16 and 8 bits are written");
    check_refusal(path, "page 2: it has 37x29x8 bits, the first page 37x29x16");
    CHECK(write_pages(scaled, 2), "pages of scales 1 and 2 are written");
    check_refusal(path, "page 2: its scale is not positive, or not that");
    CHECK(write_pages(narrow, 2), "pages of two widths are written");
    check_refusal(path, "page 2: it has 36x29x16 bits");
}

/* test/cases/bad/textures has more: files of other kinds, and false claims of size. */
static void test_refused_files(void)
{
    static const struct {
        const char *file, *what;
    } files[] = {
        /* pages whose samples are not bands */
        {"bands_untold.tif", "it has 3 samples a pixel and records no wavelengths for them"},
        {"bands_alpha.tif", "it has 4 samples a pixel instead of 1 and at most an alpha"},
        {"bands_scales.tif", "page 2 (500 nm): its scale is not positive, or not that"},
        {"bands_offset.tif", "page 3 (700 nm): its samples have an offset"},
        {"volume.tif", "37x29x3"},
        {"empty.tif", "libtiff: "},
        {"head.tif", "libtiff: "},
        {"builtin:tables/d65.csv", "is a text file; expected TIFF"},
        {"pipe.tif", "cannot read pipe.tif: it is no regular file"},
        {"missing.tif", "cannot read missing.tif: No such file"},
        {"builtin:no.tif", "no such built-in file"}};
    bytes_write("empty.tif", "", 0);
    bytes_write("head.tif", "II*\0\0\0\0\0", 8);
    mkfifo("pipe.tif", 0666);
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        check_refusal(files[i].file, files[i].what);
    unlink("pipe.tif");
}

/* libtiff only warns about a JPEG stream that ends early, and invents the missing pixels. */
static void test_short_jpeg(void)
{
    const struct variant v = {"JPEG", NULL, 8, 1, 1, .compression = COMPRESSION_JPEG};
    size_t length;
    CHECK(write_pages(&v, 1), "a grey JPEG is written");
    unsigned char *bytes = bytes_read(path, &length);
    unsigned char *entry = bytes + (bytes[4] | bytes[5] << 8 | bytes[6] << 16) + 2;
    while ((entry[0] | entry[1] << 8) != TIFFTAG_STRIPBYTECOUNTS)
        entry += 12;
    memcpy(entry + 2, "\4\0\1\0\0\0\x90\1\0\0", 10); /* one number of four bytes: 400 */
    bytes_write(path, bytes, length);
    free(bytes);
    check_refusal(path, "page 1: libtiff: Premature end of JPEG");
}

/* Exchanges the places of two strips, so that they do not follow each other. */
static void test_swapped_strips(void)
{
    enum { FIRST = 15 * WIDTH * 2, SECOND = (HEIGHT - 15) * WIDTH * 2 };
    const struct variant v = {PAGE, .rows = 15};
    unsigned char kept[FIRST];
    size_t length;
    CHECK(write_pages(&v, 1), "two strips are written");
    unsigned char *bytes = bytes_read(path, &length);
    TIFF *tiff = tiff_open(path, "r");
    const uint64_t at[2] = {TIFFGetStrileOffset(tiff, 0), TIFFGetStrileOffset(tiff, 1)};
    CHECK(at[1] == at[0] + FIRST && length > 0, "the second strip follows the first");
    TIFFClose(tiff);
    memcpy(kept, bytes + at[0], FIRST);
    memmove(bytes + at[0], bytes + at[1], SECOND);
    memcpy(bytes + at[0] + SECOND, kept, FIRST);
    /* the array of their two offsets lies in the file */
    for (size_t i = 0; i + 8 <= length; i++) {
        uint32_t pair[2];
        memcpy(pair, bytes + i, sizeof pair);
        if (pair[0] != at[0] || pair[1] != at[1])
            continue;
        pair[0] = (uint32_t)(at[0] + SECOND);
        pair[1] = (uint32_t)at[0];
        memcpy(bytes + i, pair, sizeof pair);
    }
    bytes_write(path, bytes, length);
    free(bytes);
    check_file(path, "strips in another order", &v, 1, 1, NULL, 1);
}

/* A file without its end is refused, wherever it is cut. */
static void check_cuts(const char *file, const char *name)
{
    static float seen[PIXELS];
    size_t length, passed = 0;
    unsigned char *bytes = bytes_read(file, &length);
    for (size_t cut = 0; cut < length; cut += cut % 64 == 63 ? 13 : 1) {
        struct image image;
        struct error err = {0};
        bytes_write("cut.tif", bytes, cut);
        bool read = image_open("cut.tif", from, tags_read, &image, &err);
        for (int page = 0; read && page < PAGES; page++)
            read = page < image.n_pages && image_read(&image, page, 0, image.height, seen, &err);
        passed += read || (err.status == EXIT_AGREED && image.n_pages == PAGES);
        image_close(&image);
    }
    CHECK(length > 0 && passed == 0, "%s: every shorter file is refused", name);
    unlink("cut.tif");
    free(bytes);
}

static void test_cuts(void)
{
    const int kinds[] = {COMPRESSION_NONE,     COMPRESSION_LZW,  COMPRESSION_ADOBE_DEFLATE,
                         COMPRESSION_PACKBITS, COMPRESSION_ZSTD, COMPRESSION_LZMA};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        const struct variant page = {PAGE, kinds[i], .rows = 6};
        const struct variant pages[PAGES] = {page, page, page};
        char name[32];
        snprintf(name, sizeof name, "compression %d", kinds[i]);
        CHECK(write_pages(pages, PAGES), "%s: is written", name);
        check_cuts(path, name);
    }
    write_stack();
    check_cuts(path, "a stack of floats");
    const char *const bands[] = {"bands.tif", "bands_apart.tif", "bands_deflated.tif",
                                 "bands_tiles_apart.tif"};
    for (size_t i = 0; i < sizeof bands / sizeof bands[0]; i++)
        check_cuts(bands[i], bands[i]);
}

/* A texture's file is cut short while it is open: its planes fail, and the message says where. */
static void test_cut_texture(void)
{
    const double nm[PAGES] = {400, 500, 600};
    struct texture texture = {.spectral = true};
    struct error err = {0};
    struct stat status;
    write_stack();
    CHECK(texture_read(path, from, tags_read, &texture, &err) && stat(path, &status) == 0 &&
              truncate(path, status.st_size - 1) == 0,
          "a stack is read as a texture, then cut %s", err.text);
    CHECK_NEAR(texture.largest, 0, 0, "the largest value of a black texture is 0");
    CHECK(texture_load(&texture, nm, 2, &err), "a remaining page can be loaded %s", err.text);
    CHECK(!texture_load(&texture, nm, 3, &err) && strstr(err.text, "page 3 (600 nm)") != NULL,
          "a lost page cannot be loaded: %s", err.text);
    texture_free(&texture);
    texture_free(&texture);
}

int main(void)
{
    char command[512], folder[200];
    snprintf(folder, sizeof folder, "%s/test_image.c", test_folder()); /* see test_enter */
    mkdir(folder, 0777);
    snprintf(command, sizeof command, "/usr/bin/python3 test/data/images/images.py '%s'", folder);
    test_need(system(command) == 0, "tifffile writes no pictures");
    test_enter();
    TIFFSetWarningHandler(NULL); /* the writer in this test */
    test_variants();
    test_jpeg();
    test_luma();
    test_told();
    test_foreign();
    test_refused_pages();
    test_refused_files();
    test_short_jpeg();
    test_swapped_strips();
    test_cuts();
    test_cut_texture();
    unlink(path);
    return test_end();
}
