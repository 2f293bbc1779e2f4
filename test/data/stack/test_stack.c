/* SPDX-License-Identifier: MIT */
/* Stacks have the same bytes in whatever order their pixels come, any size up to 64 bits, and
 * appear whole or not at all. tags.py reads their tags, and where each page lies. */
#include <fcntl.h>

#include "bytes.h"
#include "data/base/inside.h"
#include "data/files/files.h"
#include "data/images/images.h"
#include "data/stack/stack.h"
#include "spectral.h"

enum { WIDTH = 7, HEIGHT = 5, PAGES = 4 };
static const double wavelengths[PAGES] = {300, 305, 452.5, 760};

static struct stack_options small_options(void)
{
    return (struct stack_options){.width = WIDTH,
                                  .height = HEIGHT,
                                  .n_wavelengths = PAGES,
                                  .wavelengths_nm = wavelengths,
                                  .full_scale = 2.5,
                                  .scene = "a<b>&\"c\".scene",
                                  .provenance = "renderer: test\n"};
}

/* A different count for every sample of the stack. */
static uint16_t count_at(int page, int x, int y)
{
    return (uint16_t)(1 + x + WIDTH * (y + HEIGHT * page) + 257 * page);
}

static bool write_rectangle(struct stack_writer *writer, int page, int x, int y, int width,
                            int height, struct error *err)
{
    uint16_t counts[WIDTH * HEIGHT];
    for (int i = 0; i < width * height; i++)
        counts[i] = count_at(page, x + i % width, y + i / width);
    return pages_write(&writer->pages, &(struct page_rectangle){page, x, y, width, height}, counts,
                       err);
}

static bool finish(struct stack_writer *writer, const char *verdict, struct error *err)
{
    return stack_finish(writer, verdict, err) && output_pass(&writer->pages.output, NULL, err);
}

/* Writes every page in rectangles of at most tile x tile pixels, the last page and the last row
 * first. */
static bool write_small(const char *path, int tile, const char *verdict, struct error *err)
{
    const struct stack_options options = small_options();
    struct stack_writer writer;
    if (!stack_open(&writer, path, &options, err))
        return false;
    for (int page = PAGES - 1; page >= 0; page--)
        for (int y = (HEIGHT - 1) / tile * tile; y >= 0; y -= tile)
            for (int x = 0; x < WIDTH; x += tile) {
                int width = WIDTH - x < tile ? WIDTH - x : tile;
                int height = HEIGHT - y < tile ? HEIGHT - y : tile;
                if (!write_rectangle(&writer, page, x, y, width, height, err)) {
                    stack_discard(&writer);
                    return false;
                }
            }
    return finish(&writer, verdict, err);
}

static uint64_t number_at(const unsigned char *bytes, int size)
{
    uint64_t number = 0;
    for (int i = size - 1; i >= 0; i--)
        number = number << 8 | bytes[i];
    return number;
}

static bool same_files(const char *a, const char *b)
{
    char one[65], other[65];
    struct error err = {0};
    return digest_file(a, one, &err) && digest_file(b, other, &err) && strcmp(one, other) == 0;
}

static void test_small(void)
{
    const char *whole = "stack_whole.tif", *tiles = "stack_tiles.tif", *other = "stack_other.tif";
    struct error err = {0};
    CHECK(write_small(whole, WIDTH, "check: agreed", &err), "a stack is written %s", err.text);
    CHECK(write_small(tiles, 3, "check: agreed", &err), "a stack is written in tiles");
    CHECK(same_files(whole, tiles), "tiles in any order give the same bytes as whole pages");
    CHECK(write_small(whole, WIDTH, "check: agreed", &err) && same_files(whole, tiles),
          "writing over the old file gives the same bytes");
    char verdict[2 * STACK_VERDICT];
    memset(verdict, 'v', sizeof verdict - 1);
    verdict[sizeof verdict - 1] = '\0';
    CHECK(write_small(other, WIDTH, verdict, &err), "a verdict that is too long loses its tail");
    struct stat usual, longer;
    CHECK(stat(whole, &usual) == 0 && stat(other, &longer) == 0 && usual.st_size == longer.st_size,
          "the verdict does not change the file's size");
    unlink(whole);
    unlink(tiles);
    unlink(other);
}

/* Writes only the last sample of a page of one row, so that the file stays sparse. */
static void check_large(int width, int map_bytes, bool big)
{
    const double wavelength = 555;
    const uint16_t last = 4711;
    struct stack_options options = {.width = width,
                                    .height = 1,
                                    .n_wavelengths = 1,
                                    .wavelengths_nm = &wavelength,
                                    .full_scale = 1,
                                    .map_bytes = map_bytes};
    struct stack_writer writer;
    struct error err = {0};
    unsigned char head[4] = {0}, tail[2] = {0};
    const char *path = "stack_large.tif";
    if (!CHECK(stack_open(&writer, path, &options, &err), "%d pixels: opens %s", width, err.text))
        return;
    CHECK(writer.pages.big == big, "%d pixels: %s", width, big ? "BigTIFF" : "classic");
    uint64_t end = pages_offset(&writer.pages, 0) + (uint64_t)width * 2;
    uint64_t whole = end + (uint64_t)width * (uint64_t)map_bytes;
    CHECK(big ? whole > UINT32_MAX : whole <= UINT32_MAX,
          "%d pixels: it is a BigTIFF if it exceeds 4 GiB", width);
    CHECK(map_bytes == 0 || pages_offset(&writer.pages, 1) == end, "%d pixels: the map is written",
          width);
    CHECK(
        pages_write(&writer.pages, &(struct page_rectangle){0, width - 1, 0, 1, 1}, &last, &err) &&
            finish(&writer, "", &err),
        "%d pixels: commits %s", width, err.text);
    int file = open(path, O_RDONLY);
    CHECK(pread(file, head, 4, 0) == 4 && head[2] == (big ? 43 : 42),
          "%d pixels: the magic number is right", width);
    CHECK(pread(file, tail, 2, (off_t)end - 2) == 2 && number_at(tail, 2) == last,
          "%d pixels: the last sample is in its place", width);
    close(file);
    unlink(path);
}

static void test_large(void)
{
    check_large(INT32_MAX - 8192, 0, false); /* 16 KiB below 4 GiB: room for the directory */
    check_large(INT32_MAX, 0, true);         /* 4 GiB - 2 of pixels: no room */
    check_large(INT32_MAX / 3 * 2 - 8192, 1, false);
    check_large(INT32_MAX / 3 * 2, 1, true); /* the map passes 4 GiB */
}

static void check_refusal(struct stack_options options, const char *what)
{
    struct stack_writer writer;
    struct error err = {0};
    const char *path = "stack_refused.tif";
    CHECK(!stack_open(&writer, path, &options, &err) && err.status == EXIT_INPUT &&
              err.text[0] != '\0' && access(path, F_OK) != 0,
          "%s is refused: %s", what, err.text);
}

static void test_refusals(void)
{
    const double bad[][2] = {{500, 500}, {500, 400},         {500, 500 + 1e-9},
                             {0, 500},   {(double)NAN, 500}, {500, HUGE_VAL}};
    const struct {
        const char *what;
        int n_pages, width, height;
        double full_scale;
    } worse[] = {{"no page", 0, WIDTH, HEIGHT, 1},
                 {"one page too many", 65536, WIDTH, HEIGHT, 1},
                 {"an empty page", PAGES, 0, HEIGHT, 1},
                 {"a page without rows", PAGES, WIDTH, 0, 1},
                 {"full scale 0", PAGES, WIDTH, HEIGHT, 0},
                 {"full scale NaN", PAGES, WIDTH, HEIGHT, (double)NAN}};
    struct stack_options options = small_options();
    options.n_wavelengths = 2;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        options.wavelengths_nm = bad[i];
        check_refusal(options, "a last wavelength that is not finite");
    }
    for (size_t i = 0; i < sizeof worse / sizeof worse[0]; i++) {
        options = small_options();
        options.bits = 32;
        options.n_wavelengths = worse[i].n_pages;
        options.width = worse[i].width;
        options.height = worse[i].height;
        options.full_scale = worse[i].full_scale;
        check_refusal(options, worse[i].what);
    }
}

/* Opens a small stack over an old file, calls `damage` on it, and checks that the commit is
 * refused. */
static void check_damage(const char *what, void (*damage)(const struct stack_writer *writer))
{
    struct stack_options options = small_options();
    struct stack_writer writer;
    struct error err = {0};
    const char *path = "stack_damaged.tif";
    files_read_forget();
    FILE *old = fopen(path, "w");
    if (!CHECK(old != NULL && fputs("old", old) >= 0 && fclose(old) == 0, "an old file exists"))
        return;
    CHECK(stack_open(&writer, path, &options, &err), "%s: the stack opens", what);
    damage(&writer);
    CHECK(!finish(&writer, "", &err) && err.status == EXIT_SYSTEM, "%s: the commit is refused: %s",
          what, err.text);
    stack_discard(&writer);
    CHECK(writer.pages.output.temporary[0] == '\0', "%s: the writer is freed", what);
    size_t length;
    unsigned char *bytes = bytes_read(path, &length);
    CHECK(length == 3 && memcmp(bytes, "old", 3) == 0, "%s: the old file is as it was", what);
    free(bytes);
    unlink(path);
}

static void cut_off(const struct stack_writer *writer)
{
    off_t last = (off_t)pages_offset(&writer->pages, PAGES - 1) + WIDTH * HEIGHT * 2 - 1;
    CHECK(ftruncate(writer->pages.output.descriptor, last) == 0, "one byte is cut off");
}

/* Clears the link from the last directory but one, as if a page were missing. */
static void unlink_page(const struct stack_writer *writer)
{
    unsigned char bytes[4] = {0};
    uint64_t at, next = 4;
    for (int page = 0; page < PAGES - 1; page++) {
        CHECK(pread(writer->pages.output.descriptor, bytes, 4, (off_t)next) == 4,
              "a directory's link");
        at = number_at(bytes, 4);
        CHECK(pread(writer->pages.output.descriptor, bytes, 2, (off_t)at) == 2, "a directory");
        next = at + 2 + 12 * number_at(bytes, 2);
    }
    CHECK(pwrite(writer->pages.output.descriptor, "\0\0\0\0", 4, (off_t)next) == 4,
          "a link is cleared");
}

static void test_damage(void)
{
    check_damage("a file that was cut", cut_off);
    check_damage("a chain that ends early", unlink_page);
}

/* Unchecked pixels along edges decide only where they are more than 25 times the share. */
static void edges_decide(void)
{
    static const struct {
        uint64_t unchecked, edges;
        double most;
        uint64_t decide;
    } cases[] = {{40, 30, 0.01, 10},    {260, 250, 0.01, 10}, {261, 251, 0.01, 261},
                 {5, 5, 0, 5},          {5, 0, 0, 5},         {0, 0, 0, 0},
                 {1000, 1000, 0.04, 0}, {1000, 1000, 1, 0},   {9, 3, 0.0001, 9}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const struct stack_verdict sums = {
            .unchecked = cases[i].unchecked, .edges = cases[i].edges, .objects = 1000};
        CHECK(stack_unchecked(&sums, cases[i].most) == cases[i].decide,
              "of %d unchecked pixels, %d along edges, %d decide with a share of %g",
              (int)cases[i].unchecked, (int)cases[i].edges, (int)cases[i].decide, cases[i].most);
    }
}

int main(void)
{
    edges_decide();
    test_enter();
    test_small();
    test_large();
    test_refusals();
    test_damage();
    return test_end();
}
