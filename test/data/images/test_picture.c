/* SPDX-License-Identifier: MIT */
/* Pictures have the same bytes however their rows come. develop.py compares their samples, texts
 * and profiles with other programs, and writes to pipes. */

#include "data/files/files.h"
#include "data/images/images.h"
#include "spectral.h"
#include "test.h"
#include "tiff.h"

static const unsigned char profile[] = "a profile of an odd number of bytes!!";

static struct picture_options options_of(int bits, int width, int height)
{
    return (struct picture_options){.width = width,
                                    .height = height,
                                    .bits = bits,
                                    .channels = {"X", "Y", "Z"},
                                    .profile = bits == 32 ? NULL : profile,
                                    .profile_length = sizeof profile,
                                    .description = "two\nlines"};
}

/* A different number for every sample of a small picture. */
static unsigned sample_at(int width, int x, int y, int channel)
{
    const unsigned pixel = (unsigned)y * (unsigned)width + (unsigned)x;
    return (3 * pixel + (unsigned)channel) * 7 % 65521;
}

/* Fills row i of n rows, which is row y of the picture. */
static void fill_row(const struct picture_options *options, int y, int i, int n, void *rows)
{
    const int width = options->width;
    for (int k = 0; k < 3 * width; k++) {
        const int x = k / 3, channel = k % 3, at = 3 * i * width + k;
        const unsigned sample = sample_at(width, x, y, channel);
        if (options->bits == 8)
            ((uint8_t *)rows)[at] = (uint8_t)sample;
        else if (options->bits == 16)
            ((uint16_t *)rows)[at] = (uint16_t)sample;
        else
            ((float *)rows)[(channel * n + i) * width + x] = (float)sample / -7;
    }
}

/* Writes the picture, `step` rows at a time. */
static bool write_rows(struct picture_writer *writer, int step, struct error *err)
{
    const struct picture_options *options = &writer->options;
    const size_t size = (size_t)options->bits / 8;
    const size_t pitch = 3 * (size_t)options->width * size;
    char *rows = malloc(pitch * (size_t)step);
    bool done = rows != NULL;
    while (done && writer->row < options->height) {
        const int left = options->height - writer->row, n = left < step ? left : step;
        for (int i = 0; i < n; i++)
            fill_row(options, writer->row + i, i, n, rows);
        done = picture_write(writer, rows, n, err);
    }
    free(rows);
    return done;
}

static bool write_picture(const char *path, const struct picture_options *options, int step,
                          struct error *err)
{
    struct picture_writer writer;
    if (!picture_open(&writer, path, options, err))
        return false;
    const bool done = write_rows(&writer, step, err) && picture_commit(&writer, NULL, err);
    picture_discard(&writer);
    return done;
}

static bool same_files(const char *one, const char *other)
{
    char a[65], b[65];
    struct error err = {0};
    return digest_file(one, a, &err) && digest_file(other, b, &err) && strcmp(a, b) == 0;
}

static double read_sample(const struct picture_options *options, const void *row, size_t at)
{
    if (options->bits == 8)
        return ((const uint8_t *)row)[at];
    return options->bits == 16 ? ((const uint16_t *)row)[at]
                               : -7 * (double)((const float *)row)[at];
}

/* The bytes of a picture are the same, however many rows come at once. */
static void test_rows(void)
{
    static const struct {
        int bits;
        const char *whole, *some;
    } kinds[] = {{8, "rows.tif", "some.tif"},
                 {16, "rows.tif", "some.tif"},
                 {32, "rows.tif", "some.tif"},
                 {8, "rows.png", "some.PNG"},
                 {16, "rows.png", "some.PNG"}};
    static const int sizes[][2] = {{7, 5}, {1, 1}, {700, 301}, {30000, 3}};
    for (size_t i = 0; i < 4 * sizeof kinds / sizeof kinds[0]; i++) {
        const char *whole = kinds[i / 4].whole, *some = kinds[i / 4].some;
        const struct picture_options options =
            options_of(kinds[i / 4].bits, sizes[i % 4][0], sizes[i % 4][1]);
        struct error err = {0};
        CHECK(write_picture(whole, &options, options.height, &err), "%s of %d bits is written %s",
              whole, options.bits, err.text);
        for (int step = 1; step < options.height; step *= step < 2 ? 2 : 7)
            CHECK(write_picture(some, &options, step, &err) && same_files(whole, some),
                  "%d x %d pixels, written %d rows at a time, have the same bytes", options.width,
                  options.height, step);
        unlink(some);
        unlink(whole);
    }
}

/* Writes only the last row, so that the file is sparse and takes no room. */
static void test_big(int bits, int size)
{
    const char *path = "picture_big.tif";
    const struct picture_options options = options_of(bits, size, size);
    struct picture_writer writer;
    struct error err = {0};
    bool done = picture_open(&writer, path, &options, &err);
    writer.row = size - 1;
    done = done && write_rows(&writer, 1, &err) && picture_commit(&writer, NULL, &err);
    CHECK(done, "a picture above 4 GiB is written %s", err.text);
    TIFF *tiff = done ? tiff_open(path, "r") : NULL;
    CHECK(tiff != NULL && TIFFIsBigTIFF(tiff), "it is a BigTIFF");
    float *row = tiff != NULL ? malloc((size_t)TIFFScanlineSize64(tiff)) : NULL;
    for (int page = 0; row != NULL && page < (bits == 32 ? 3 : 1); page++) {
        const unsigned expected = sample_at(size, 0, size - 1, page);
        CHECK(TIFFSetDirectory(tiff, (uint16_t)page) &&
                  TIFFReadScanline(tiff, row, (uint32_t)size - 1, 0) == 1 &&
                  fabs(read_sample(&options, row, 0) - (bits == 8 ? expected & 255 : expected)) <
                      0.01,
              "its last row is in its place, on page %d", page + 1);
    }
    free(row);
    if (tiff != NULL)
        TIFFClose(tiff);
    unlink(path);
}

static void test_damage(void)
{
    const struct picture_options options = options_of(32, 7, 5);
    const char *path = "picture_damaged.tif";
    struct picture_writer writer;
    struct stat status;
    struct error err = {0};
    CHECK(picture_open(&writer, path, &options, &err) && write_rows(&writer, 5, &err) &&
              fstat(writer.pages.output.descriptor, &status) == 0 &&
              ftruncate(writer.pages.output.descriptor, status.st_size - 1) == 0,
          "a picture loses its last byte");
    CHECK(!picture_commit(&writer, NULL, &err) && err.status == EXIT_SYSTEM &&
              access(path, F_OK) != 0,
          "the damaged picture does not appear: %s", err.text);
}

/* ---- rectangles ---- */

/* Copies a rectangle of a picture of 8 bits and this width. */
static void copy_rectangle(const uint8_t *picture, int width, const struct page_rectangle *at,
                           uint8_t *out)
{
    const size_t n = 3 * (size_t)at->width;
    for (int row = 0; row < at->height; row++)
        memcpy(out + (size_t)row * n, picture + 3 * ((at->y + row) * width + at->x), n);
}

/* Writes tiles of 30 x 20 pixels, each in rectangles of 8 rows or fewer. */
static bool put_tiles(struct picture_writer *writer, const uint8_t *picture, struct error *err)
{
    static uint8_t part[3 * 30 * 8];
    const int width = writer->options.width, height = writer->options.height;
    for (int y = 0; y < height; y += 20)
        for (int x = 0; x < width; x += 30)
            for (int row = y; row < y + 20 && row < height; row += 8) {
                const int end = y + 20 < height ? y + 20 : height;
                const struct page_rectangle at = {0, x, row, width - x < 30 ? width - x : 30,
                                                  end - row < 8 ? end - row : 8};
                copy_rectangle(picture, width, &at, part);
                if (!picture_put(writer, &at, part, err))
                    return false;
            }
    return true;
}

/* A picture of rectangles has the bytes of a picture of rows. */
static void test_rectangles(void)
{
    static uint8_t picture[3 * 100 * 70];
    for (int width = 29; width <= 100; width += 71) {
        const struct picture_options options = options_of(8, width, 70);
        struct picture_writer writer;
        struct error err = {0};
        for (int y = 0; y < options.height; y++)
            fill_row(&options, y, y, options.height, picture);
        const bool done = picture_open(&writer, "tiles.png", &options, &err) &&
                          put_tiles(&writer, picture, &err) && picture_commit(&writer, NULL, &err);
        CHECK(done && write_picture("rows.png", &options, 9, &err) &&
                  same_files("tiles.png", "rows.png"),
              "%d pixels wide: tiles give the bytes that rows give %s", width, err.text);
        picture_discard(&writer);
    }
    unlink("tiles.png");
    unlink("rows.png");
}

/* ---- the scale ---- */

static bool same_colour(double one, double other)
{
    uint8_t a[3], b[3];
    scale_colour(one, 0.25, a);
    scale_colour(other, 0.25, b);
    return memcmp(a, b, 3) == 0;
}

/* compare.py finds a colour for each power of two. */
static void test_scale(void)
{
    CHECK(same_colour(1025, HUGE_VAL) && same_colour(1025, (double)NAN) && !same_colour(1024, 1025),
          "numbers above the largest step and NaN share the last colour");
}

int main(void)
{
    test_enter();
    test_rows();
    test_big(8, 40000);
    test_big(32, 20000);
    test_damage();
    test_rectangles();
    test_scale();
    return test_end();
}
