/* SPDX-License-Identifier: MIT */
/* Reads ENVI cubes in rows of any number and order, as textures and commands may. The cube is
 * larger than the blocks in which the program reads it. test/run/envi.py covers types, headers and
 * commands. */
#include <unistd.h>

#include "data/envi/envi.h"
#include "data/tiff/tiff.h"
#include "spectral.h"
#include "test.h"

enum { WIDTH = 40, HEIGHT = 3000, BANDS = 4 };
static const struct place from = {"a.scene", 3, 7};

static double radiance_at(int band, int x, int y)
{
    return 1e6 * band + 100.0 * y + x;
}

/* Writes the radiances as little-endian doubles behind three bytes. Band 1 is bad. `broken` becomes
 * the radiance at column 7, row 2500 of band 2. */
static bool write_cube(enum envi_interleave interleave, double broken)
{
    char header[512];
    FILE *file = fopen("cube.raw", "wb");
    if (!file)
        return false;
    fputs("abc", file);
    for (int i = 0; i < WIDTH * HEIGHT * BANDS; i++) {
        const int along = interleave == ENVI_BSQ ? i % (WIDTH * HEIGHT) : i / BANDS;
        const int band = interleave == ENVI_BSQ   ? i / (WIDTH * HEIGHT)
                         : interleave == ENVI_BIL ? i / WIDTH % BANDS
                                                  : i % BANDS;
        const int x = interleave == ENVI_BIP ? along % WIDTH : i % WIDTH;
        const int y = interleave == ENVI_BSQ ? along / WIDTH : i / (WIDTH * BANDS);
        const double radiance = band == 2 && x == 7 && y == 2500 ? broken : radiance_at(band, x, y);
        fwrite(&radiance, sizeof radiance, 1, file);
    }
    snprintf(header, sizeof header,
             "ENVI\nsamples = %d\nlines = %d\nbands = %d\nheader offset = 3\ndata type = 5\n"
             "interleave = %s\nbyte order = 0\nbbl = {1, 0, 1, 1}\n",
             WIDTH, HEIGHT, BANDS, envi_interleave_name(interleave));
    test_write("cube.hdr", header);
    return fclose(file) == 0;
}

/* Returns whether these rows of a page are right. */
static bool is_read(struct image *image, int page, int y, int rows)
{
    static float seen[WIDTH * HEIGHT];
    struct error err = {.status = EXIT_AGREED};
    const int band = page + (page > 0);
    bool same = image_read(image, page, y, rows, seen, &err);
    for (int i = 0; same && i < rows * WIDTH; i++)
        same = (double)seen[i] == (double)(float)radiance_at(band, i % WIDTH, y + i / WIDTH);
    return same;
}

static void test_rows(enum envi_interleave interleave)
{
    const char *name = envi_interleave_name(interleave);
    struct image image;
    struct error err = {.status = EXIT_AGREED};
    CHECK(write_cube(interleave, radiance_at(2, 7, 2500)) &&
              image_open("cube.raw", from, &image, &err) && image.n_pages == BANDS - 1,
          "%s: opens, without the bad band %s", name, err.text);
    bool same = true;
    for (int page = 0; page < image.n_pages; page++)
        same = same && is_read(&image, page, 0, HEIGHT);
    CHECK(same, "%s: whole pages are right", name);
    /* rows that lie in the rows read before, overlap them, or do not */
    unsigned random = 1;
    for (int i = 0; i < 300; i++) {
        random = random * 1664525u + 1013904223u;
        const int y = (int)(random >> 8) % HEIGHT, page = (int)(random >> 24) % (BANDS - 1);
        const int most = i % 3 == 0 ? HEIGHT : 20, left = HEIGHT - y;
        same =
            same && is_read(&image, page, y, 1 + (int)(random >> 4) % (left < most ? left : most));
        same = same && is_read(&image, (page + 1) % (BANDS - 1), y, 1);
    }
    CHECK(same, "%s: rows of any number and order are right", name);
    image_close(&image);
}

static void test_broken(enum envi_interleave interleave)
{
    static float seen[WIDTH * HEIGHT];
    struct image image;
    struct error err = {.status = EXIT_AGREED};
    CHECK(write_cube(interleave, -1) && image_open("cube.hdr", from, &image, &err) &&
              image_read(&image, 0, 0, HEIGHT, seen, &err),
          "opens %s", err.text);
    CHECK(!image_read(&image, 1, 100, HEIGHT - 100, seen, &err) && err.status == EXIT_INPUT &&
              strstr(err.text, "a.scene:3:7: error: cube.raw: band 3: the radiance at column 7, row"
                               " 2500 is -1; "),
          "%s: a negative radiance has its place: %s", envi_interleave_name(interleave), err.text);
    image_close(&image);
}

int main(void)
{
    const char *folder = test_folder();
    if (!CHECK(chdir(folder) == 0, "the folder for temporary files exists"))
        return test_end();
    for (int interleave = ENVI_BSQ; interleave <= ENVI_BIP; interleave++) {
        test_rows((enum envi_interleave)interleave);
        test_broken((enum envi_interleave)interleave);
    }
    unlink("cube.raw");
    unlink("cube.hdr");
    return test_end();
}
