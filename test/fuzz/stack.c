/* SPDX-License-Identifier: MIT */
/* Fuzz targets: pictures in. A stack of this program or of others, a texture. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "data/base/base.h"
#include "data/images/images.h"
#include "data/stack/stack.h"
#include "data/text/text.h"
#include "raster/beside/colour/colour.h"
#include "raster/beside/see/inside.h"
#include "test/fuzz/fuzz.h"

/* Good input may have any number of pixels; more of them reach no other code. */
static bool is_small(const struct image *image)
{
    return (double)image->width * image->height * image->n_pages <= 1 << 16;
}

/* Reads all rows of all pages, a few at a time, and the numbers of the objects. */
static bool read_rows(struct cube *cube, struct error *err)
{
    struct image *image = &cube->image;
    const size_t width = (size_t)image->width;
    float *row = malloc(3 * width * sizeof *row);
    int *objects = malloc(width * sizeof *objects);
    bool done = (row != NULL && objects != NULL) || memory_lacks(err, 0, "a row");
    for (int y = 0; done && y < image->height; y += 3)
        for (int page = 0; done && page < image->n_pages; page++) {
            const int rows = image->height - y < 3 ? image->height - y : 3;
            done = image_read(image, page, y, rows, row, err);
            for (size_t i = 0; done && i < (size_t)rows * width; i++)
                fuzz_holds(isfinite(row[i]) && row[i] >= 0,
                           "a radiance is finite, and not negative");
        }
    for (int y = 0; done && y < image->height; y++) {
        done = cube_objects(cube, 0, y, image->width, objects, err);
        for (int x = 0; done && x < image->width; x++)
            fuzz_holds(objects[x] >= -1 && objects[x] <= cube->record.objects.n,
                       "an object has a name");
    }
    free(row);
    free(objects);
    return done;
}

static void develop_stack(const char *path, struct development of, const char *ending)
{
    struct error err = {.status = EXIT_AGREED};
    char picture[FUZZ_PATH];
    fuzz_write(ending, "", 0, picture);
    of.options->operand = path;
    of.options->output = picture;
    of.options->threads = 1;
    fuzz_ends(develop(&of, &err) && outputs_commit(&of.options->outputs, &err), &err);
    outputs_discard(&of.options->outputs);
    develop_free(&of);
}

/* Runs a command, whose output nobody reads. */
static void run_command(const struct command *command, char *const *words, int n)
{
    struct error err = {.status = EXIT_AGREED};
    struct options options = {.operand = NULL};
    const bool done = options_read(command, false, (const char *const *)words, n, &options, &err) &&
                      command->run(&options, &err);
    if (err.status != EXIT_DIFFERENT)
        fuzz_ends(done, &err);
    options_free(&options);
}

static void probe_pixel(const char *path)
{
    char output[] = "-o/dev/null", x[] = "0", y[] = "0", *stack = strdup(path);
    char *const words[] = {output, stack, x, y};
    if (stack)
        run_command(&probe_command, words, 4);
    free(stack);
}

static void compare_with_itself(const char *path)
{
    struct error err = {.status = EXIT_AGREED};
    struct options options = {.operands = {path, path}, .threads = 1};
    struct comparison comparison = {.options = &options};
    if (fuzz_ends(compare(&comparison, &err), &err))
        fuzz_holds(comparison.all.peak.largest == 0, "a stack does not differ from itself");
    comparison_free(&comparison);
}

static void join_part(const char *path)
{
    char quiet[] = "-q", output[] = "-o/dev/null", *part = strdup(path);
    char *const words[] = {quiet, output, part};
    if (part)
        run_command(&join_command, words, 3);
    free(part);
}

static void develop_colour(const char *path)
{
    struct options options = {.detector = "cie1931", .exposure = "auto"};
    const struct development of = {.options = &options, .bits = 16};
    develop_stack(path, of, ".png");
}

static void develop_adapted(const char *path)
{
    struct options options = {.detector = "cie1964", .white = "d65"};
    const struct development of = {.options = &options,
                                   .adaptation = {ADAPTATION_CAT16, 0},
                                   .values = DEVELOP_LAB,
                                   .bits = 32};
    develop_stack(path, of, ".developed.tif");
}

/* Reads everything, and then does what one of the commands does, which the last byte chooses: all
 * of them would take five times as long. */
void fuzz_stack(const struct fuzz_input *input)
{
    void (*const readers[])(const char *) = {develop_colour, develop_adapted, probe_pixel,
                                             compare_with_itself, join_part};
    const unsigned char last =
        (unsigned char)input->bytes[input->length > 0 ? input->length - 1 : 0];
    struct error err = {.status = EXIT_AGREED};
    struct cube cube = {.components = false};
    const bool opened = cube_open(input->path, &cube, &err),
               small = opened && is_small(&cube.image);
    fuzz_ends(opened && (!small || read_rows(&cube, &err)), &err);
    cube_close(&cube);
    if (small)
        readers[last % 5](input->path);
}

static void read_texture(const char *path, bool spectral)
{
    static const double nm[] = {300, 500.5, 9000};
    struct error err = {.status = EXIT_AGREED};
    struct texture texture = {.spectral = spectral, .linear = spectral};
    if (fuzz_ends(texture_read(path, (struct place){0}, tags_read, &texture, &err), &err) &&
        fuzz_ends(texture_load(&texture, nm, 3, &err), &err)) {
        const size_t n = (size_t)texture.image.width * (size_t)texture.image.height;
        for (size_t i = 0; texture.plane[0] != NULL && i < n; i++)
            fuzz_holds(texture.plane[0][i] >= 0 && (double)texture.plane[0][i] <= texture.largest,
                       "a texel lies from 0 to the largest");
    }
    texture_free(&texture);
}

void fuzz_texture(const struct fuzz_input *input)
{
    read_texture(input->path, false);
    read_texture(input->path, true);
}

/* Puts a chunk of a PNG file with its length and checksum. Returns the place behind it. */
static unsigned char *put_chunk(unsigned char *to, const char *kind, const void *bytes, size_t n)
{
    memcpy(to + 4, kind, 4);
    memcpy(to + 8, bytes, n);
    const uint32_t sum = (uint32_t)crc32(0, to + 4, (uInt)n + 4);
    for (int i = 0; i < 4; i++) {
        to[i] = (unsigned char)(n >> (24 - 8 * i) & 255);
        to[8 + n + (size_t)i] = (unsigned char)(sum >> (24 - 8 * i) & 255);
    }
    return to + 12 + n;
}

/* Reads bytes as the filtered rows of a PNG file: its checksums and its compression are right, so
 * that inputs reach the filters. The first four bytes are width, height, depth and kind of colour.
 */
void fuzz_png(const struct fuzz_input *input)
{
    const unsigned char *from = (const unsigned char *)input->bytes;
    if (input->length < 5)
        return;
    const uLong n = (uLong)input->length - 4;
    uLongf packed = compressBound(n);
    unsigned char *file = malloc(packed + 128), *rows = malloc(packed);
    unsigned char head[13] = {0, 0, 0, from[0], 0, 0, 0, from[1], from[2], from[3]};
    char path[FUZZ_PATH];
    if (file && rows && compress(rows, &packed, from + 4, n) == Z_OK) {
        memcpy(file, "\x89PNG\r\n\x1a\n", 8);
        unsigned char *end = put_chunk(file + 8, "IHDR", head, sizeof head);
        end = put_chunk(end, "IDAT", rows, packed);
        end = put_chunk(end, "IEND", "", 0);
        fuzz_write(".png", (const char *)file, (size_t)(end - file), path);
        read_texture(path, false);
    }
    free(file);
    free(rows);
}
