/* SPDX-License-Identifier: MIT */
/* Textures from stacks that the program writes: their orientation, and their values between and
 * beyond their wavelengths. test/cases/bad has the textures that are refused. */
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/base/inside.h"
#include "data/images/images.h"
#include "data/stack/stack.h"
#include "spectral.h"
#include "test.h"

enum { WIDTH = 5, HEIGHT = 3, PIXELS = WIDTH * HEIGHT, PAGES = 3 };
static const double page_nm[PAGES] = {400, 500, 700};
static const struct place from = {"a.scene", 3, 7};
static const char *const path = "texture.tif";

/* Returns the radiance of a pixel, with x to the right and t upwards. Page 1 is so bright that any
 * part of it in page 2 would destroy the digits of page 2. */
static float radiance_at(int page, int x, int t)
{
    static const float base[PAGES] = {0, 0x1p60f, 2};
    return base[page] + (float)x + 0.125f * (float)t;
}

/* Writes a stack of floats with this many pages; every value is `times` the radiance above. */
static bool write_stack(int n_pages, float times)
{
    const struct stack_options options = {.width = WIDTH,
                                          .height = HEIGHT,
                                          .n_wavelengths = n_pages,
                                          .wavelengths_nm = page_nm,
                                          .full_scale = 1,
                                          .bits = 32};
    struct stack_writer writer;
    struct error err = {0};
    files_read_forget();
    bool good = stack_open(&writer, path, &options, &err);
    for (int page = 0; good && page < n_pages; page++)
        for (int i = 0; good && i < PIXELS; i++) {
            const float value = times * radiance_at(page, i % WIDTH, HEIGHT - 1 - i / WIDTH);
            good = pages_write(&writer.pages,
                               &(struct page_rectangle){page, i % WIDTH, i / WIDTH, 1, 1}, &value,
                               &err);
        }
    return CHECK(good && stack_finish(&writer, "", &err) && stack_commit(&writer, NULL, NULL, &err),
                 "a stack is written %s", err.text);
}

static bool read_stack(bool spectral, bool linear, struct texture *out, struct error *err)
{
    *out = (struct texture){.spectral = spectral, .linear = linear};
    return texture_read(path, from, tags_read, out, err);
}

static bool plane_is(const float *plane, int page)
{
    for (int i = 0; i < PIXELS; i++)
        if (plane == NULL || plane[i] < radiance_at(page, i % WIDTH, i / WIDTH) ||
            plane[i] > radiance_at(page, i % WIDTH, i / WIDTH))
            return false;
    return true;
}

static void test_grey(void)
{
    struct texture texture;
    struct error err = {0};
    if (!write_stack(1, 1) ||
        !CHECK(read_stack(false, true, &texture, &err), "a grey texture is read %s", err.text))
        return;
    CHECK(!texture.spectral && texture.linear,
          "it is not spectral, and its filter is linear as requested");
    CHECK(texture.image.width == WIDTH && texture.image.height == HEIGHT, "it has the page's size");
    CHECK(plane_is(texture.plane[0], 0), "its bottom row comes first");
    CHECK(texture.plane[1] == NULL, "it has one plane");
    CHECK_NEAR(texture.largest, 4.25, 0, "its largest value is found");
    CHECK(texture_load(&texture, page_nm, PAGES, &err) && plane_is(texture.plane[0], 0),
          "it is the same at all wavelengths");
    texture_free(&texture);
    texture_free(&texture);
    CHECK(texture.plane[0] == NULL && texture.image.file == NULL, "a freed texture is empty");
    CHECK(write_stack(1, 0) && read_stack(false, false, &texture, &err),
          "a black texture is read %s", err.text);
    CHECK_NEAR(texture.largest, 0, 0, "its largest value is 0");
    CHECK(!texture.linear, "its filter is nearest as requested");
    texture_free(&texture);
}

/* Loads one wavelength, together with another that must not matter. Expects the interpolation
 * between `page` and the next page at `share`, rounded to the nearest float. */
static void check_between(struct texture *texture, double nm, int page, double share)
{
    const double asked[] = {620, nm};
    struct error err = {0};
    double furthest = 0;
    if (!CHECK(texture_load(texture, asked, 2, &err), "%g nm is loaded %s", nm, err.text))
        return;
    for (int i = 0; i < PIXELS; i++) {
        const double low = (double)radiance_at(page, i % WIDTH, i / WIDTH);
        const double high = share > 0 ? (double)radiance_at(page + 1, i % WIDTH, i / WIDTH) : low;
        const float expected = (float)(low + share * (high - low));
        furthest = fmax(furthest, fabs((double)texture->plane[1][i] - (double)expected));
    }
    CHECK_NEAR(furthest, 0, 0, "%g nm lies %g of a step after page %d", nm, share, page);
}

static void test_spectral(void)
{
    struct texture texture;
    struct error err = {0};
    if (!write_stack(PAGES, 1) ||
        !CHECK(read_stack(true, false, &texture, &err), "a spectral texture is read %s", err.text))
        return;
    CHECK(texture.spectral && !texture.linear,
          "it is spectral, and its filter is nearest as requested");
    CHECK_NEAR(texture.largest, 0x1p60, 0, "its largest value is found, in a page between others");
    CHECK(texture_load(&texture, page_nm, PAGES, &err), "three planes are loaded at once %s",
          err.text);
    for (int page = 0; page < PAGES; page++)
        CHECK(plane_is(texture.plane[page], page), "the plane of %g nm is that page",
              page_nm[page]);
    check_between(&texture, 400, 0, 0);
    check_between(&texture, 425, 0, 0.25);
    check_between(&texture, 500, 1, 0);
    check_between(&texture, 600, 1, 0.5);
    check_between(&texture, 660, 1, 0.8);
    check_between(&texture, 700, 2, 0);
    check_between(&texture, 300, 0, 0);
    check_between(&texture, 2500, 2, 0);
    texture_free(&texture);
    CHECK(write_stack(1, 1) && read_stack(true, true, &texture, &err),
          "a stack of one page is read as a spectral texture %s", err.text);
    CHECK(texture_load(&texture, page_nm, PAGES, &err) && plane_is(texture.plane[2], 0),
          "it is equal at all wavelengths %s", err.text);
    texture_free(&texture);
}

/* A file is cut short while it is open: its planes fail, and the message says where. */
static void test_cut(void)
{
    struct texture texture;
    struct error err = {0};
    struct stat status;
    if (!write_stack(PAGES, 1) || !read_stack(true, true, &texture, &err) ||
        stat(path, &status) != 0 || truncate(path, status.st_size - 1) != 0) {
        CHECK(false, "a stack is read, then cut %s", err.text);
        return;
    }
    CHECK(texture_load(&texture, page_nm, 2, &err), "a remaining page can be loaded %s", err.text);
    CHECK(!texture_load(&texture, page_nm, 3, &err) && strstr(err.text, "page 3 (700 nm)") != NULL,
          "a lost page cannot be loaded: %s", err.text);
    texture_free(&texture);
}

int main(void)
{
    test_enter();
    test_grey();
    test_spectral();
    test_cut();
    unlink(path);
    return test_end();
}
