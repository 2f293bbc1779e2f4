/* SPDX-License-Identifier: MIT */
/* The standard, and the difference of a configuration's stack from it.
 *
 * render draws the standard as it draws any configuration: a stack of floats with a page at every
 * nm. That stack is too large to be read again for each measurement, so a summary is kept: a struct
 * standard_pixel of each pixel, row by row; and the radiances at every nm of a lattice of pixels,
 * again row by row. The lattice is every step-th pixel of every step-th row.
 *
 * A float is off by up to 6e-8 of a radiance, which moves L*, a* and b* by some 1e-6. Only errors
 * of that size, of stacks of floats, are measured less exactly by this. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/images/images.h"
#include "raster/beside/colour/colour.h"
#include "raster/beside/cost/inside.h"

/* The lattice has about so many points. */
static const double lattice_pixels = 2500;

enum { BLOCK_PIXELS = 1024 }; /* that a thread takes at a time */

/* Samples of a chunk of rows: 8 MiB. */
static const size_t chunk_samples = (size_t)1 << 21;

/* Reads a stack, and makes the summary or compares with it. */
struct walk {
    struct standard *standard;
    struct stack_rows rows;
    struct sight sight;
    int threads;
    struct standard_pixel *pixels; /* those of the current rows in the standard */
    float *lattice;                /* [column][nm]: the next row of the lattice in the standard */
    /* While a stack is compared: */
    float *pages;            /* [column][page]: a row of the lattice of the stack */
    double *linear;          /* synthesis of a stack without sampling */
    const double *synthesis; /* radiances at every nm from pages, [nm][page]; NULL: there is none */
    double (*squares)[2];    /* [column]: of the errors of radiances, and of radiances */
    double error, all;       /* the sums of these squares */
    float *differences;      /* of the pixels so far in which either picture shows an object */
    size_t n_differences;
};

static bool open_walk(struct walk *walk, const char *stack, struct error *err)
{
    const struct white_request white = {NULL, false};
    walk->threads = threads_count(walk->standard->threads);
    return cube_open(stack, &walk->rows.cube, err) &&
           rows_allocate(&walk->rows, chunk_samples, err) &&
           sight_make(&walk->rows.cube, walk->standard->observer, &white, &walk->sight, err);
}

static size_t pixels_at_hand(const struct walk *walk)
{
    return (size_t)walk->rows.n * (size_t)walk->standard->width;
}

static size_t lattice_samples(const struct walk *walk)
{
    return (size_t)walk->standard->columns * (size_t)walk->standard->n_nm;
}

static void close_walk(struct walk *walk)
{
    rows_close(&walk->rows);
    sight_free(&walk->sight);
    FREE_ALL(walk->pages, walk->linear, walk->squares, walk->differences);
}

/* Calls a function for each chunk of rows, and another for each of its rows in the lattice. */
static bool walk_rows(struct walk *walk, bool (*chunk)(struct walk *walk, struct error *err),
                      void (*lattice_row)(struct walk *walk, int row), struct error *err)
{
    walk->pixels = walk->standard->pixels;
    walk->lattice = walk->standard->lattice;
    for (int y = 0; y < walk->standard->height; y += walk->rows.most) {
        if (!rows_read(&walk->rows, y, err) || !chunk(walk, err))
            return false;
        walk->pixels += pixels_at_hand(walk);
        for (int row = 0; row < walk->rows.n; row++)
            if ((y + row) % walk->standard->step == 0) {
                lattice_row(walk, row);
                walk->lattice += lattice_samples(walk);
            }
    }
    return true;
}

/* Finds XYZ of a pixel of the chunk. Returns whether any of X, Y and Z is not 0. */
static bool find_xyz(const struct walk *walk, size_t pixel, double xyz[3])
{
    const size_t n_pages = (size_t)walk->rows.cube.image.n_pages;
    const float *sample = walk->rows.samples + pixel;
    xyz[0] = xyz[1] = xyz[2] = 0;
    for (size_t page = 0; page < n_pages; page++, sample += walk->rows.stride)
        for (size_t c = 0; c < 3; c++)
            xyz[c] += walk->sight.weights[c * n_pages + page] * (double)*sample;
    return fabs(xyz[0]) > 0 || fabs(xyz[1]) > 0 || fabs(xyz[2]) > 0;
}

/* Copies the samples of the lattice's pixels in a row of the chunk: out[column * n_pages + page].
 */
static void copy_lattice(const struct walk *walk, int row, float *out)
{
    const int width = walk->standard->width;
    const float *samples = walk->rows.samples + (size_t)row * (size_t)width;
    for (int x = 0; x < width; x += walk->standard->step)
        for (int page = 0; page < walk->rows.cube.image.n_pages; page++)
            *out++ = samples[(size_t)page * walk->rows.stride + (size_t)x];
}

/* ---- the summary ---- */

static bool find_shown(struct walk *walk, struct error *err)
{
    struct standard_pixel *pixel = walk->pixels;
    const int width = walk->standard->width;
    int *objects;
    bool done = MAKE_ARRAY(objects, (size_t)width, err, "a row of objects");
    for (int row = 0; done && row < walk->rows.n; row++) {
        done = cube_objects(&walk->rows.cube, 0, walk->rows.first + row, width, objects, err);
        for (int x = 0; x < width; x++, pixel++)
            pixel->shown = objects[x] > 0;
    }
    free(objects);
    return done;
}

static void summarize_pixels(void *context, size_t first, size_t end)
{
    const struct walk *walk = context;
    for (size_t i = first; i < end; i++) {
        struct standard_pixel *pixel = &walk->pixels[i];
        double xyz[3];
        pixel->shown = find_xyz(walk, i, xyz) || pixel->shown;
        cielab(xyz, walk->standard->white, pixel->lab);
    }
}

static bool summarize_chunk(struct walk *walk, struct error *err)
{
    if (!find_shown(walk, err))
        return false;
    threads_blocks(walk->threads, pixels_at_hand(walk), BLOCK_PIXELS, summarize_pixels, walk);
    return true;
}

static void summarize_lattice(struct walk *walk, int row)
{
    copy_lattice(walk, row, walk->lattice);
}

/* Describes the standard, and makes room for it. */
static bool describe(struct walk *walk, struct error *err)
{
    const struct image *image = &walk->rows.cube.image;
    const size_t n_pixels = (size_t)image->width * (size_t)image->height;
    const int step = (int)ceil(sqrt((double)n_pixels / lattice_pixels));
    const double *white = walk->sight.white;
    struct standard *out = walk->standard;
    out->width = image->width;
    out->height = image->height;
    out->lit = walk->sight.has_white && (white[0] > 0 || white[1] > 0 || white[2] > 0);
    out->first_nm = image->wavelengths_nm[0];
    out->n_nm = image->n_pages;
    out->step = step;
    out->columns = (image->width + step - 1) / step;
    detector_response(walk->sight.weights, NULL, image->n_pages, out->white);
    if (out->lit)
        memcpy(out->white, white, sizeof out->white);
    const size_t rows = (size_t)((image->height + step - 1) / step);
    return MAKE_ARRAY(out->pixels, n_pixels, err, "the pixels of the standard") &&
           MAKE_ARRAY(out->lattice, rows * lattice_samples(walk), err,
                      "the radiances of the standard");
}

bool standard_summarize(const char *stack, struct standard *out, struct error *err)
{
    struct walk walk = {.standard = out};
    const bool done = open_walk(&walk, stack, err) && describe(&walk, err) &&
                      walk_rows(&walk, summarize_chunk, summarize_lattice, err);
    close_walk(&walk);
    return done;
}

/* ---- the difference of a stack ---- */

/* Returns CIEDE2000 at a pixel of the chunk; -1: neither picture shows an object. */
static float difference_at(const struct walk *walk, size_t pixel)
{
    double xyz[3], lab[3];
    if (!find_xyz(walk, pixel, xyz) && !walk->pixels[pixel].shown)
        return -1;
    cielab(xyz, walk->standard->white, lab);
    return (float)ciede2000_difference(walk->pixels[pixel].lab, lab);
}

static void compare_pixels(void *context, size_t first, size_t end)
{
    const struct walk *walk = context;
    for (size_t i = first; i < end; i++)
        walk->differences[walk->n_differences + i] = difference_at(walk, i);
}

/* Keeps the differences of pixels that show an object. */
static bool compare_chunk(struct walk *walk, struct error *err)
{
    const size_t n_pixels = pixels_at_hand(walk);
    float *differences = walk->differences + walk->n_differences;
    size_t n = 0;
    (void)err;
    threads_blocks(walk->threads, n_pixels, BLOCK_PIXELS, compare_pixels, walk);
    for (size_t i = 0; i < n_pixels; i++)
        if (differences[i] >= 0)
            differences[n++] = differences[i];
    walk->n_differences += n;
    return true;
}

/* Sums up squares at a pixel of the lattice, over every nm. */
static void square(void *context, int column)
{
    const struct walk *walk = context;
    const int n_pages = walk->rows.cube.image.n_pages, n_nm = walk->standard->n_nm;
    const double *synthesis = walk->synthesis;
    const float *pages = walk->pages + (size_t)column * (size_t)n_pages;
    const float *expected = walk->lattice + (size_t)column * (size_t)n_nm;
    double *squares = walk->squares[column];
    squares[0] = squares[1] = 0;
    for (int j = 0; j < n_nm; j++, synthesis += n_pages) {
        double radiance = 0;
        for (int page = 0; page < n_pages; page++)
            radiance += synthesis[page] * (double)pages[page];
        const double error = radiance - (double)expected[j];
        squares[0] += error * error;
        squares[1] += (double)expected[j] * (double)expected[j];
    }
}

/* Adds the sums in the order of the columns, so that the number of threads does not matter. */
static void compare_lattice(struct walk *walk, int row)
{
    const int columns = walk->standard->columns;
    if (!walk->synthesis)
        return;
    copy_lattice(walk, row, walk->pages);
    threads_each(walk->threads, columns, square, walk);
    for (int column = 0; column < columns; column++) {
        walk->error += walk->squares[column][0];
        walk->all += walk->squares[column][1];
    }
}

/* Without a sampling, radiances are linear between the wavelengths of the stack. */
static bool find_synthesis(struct walk *walk, const struct sampling *sampling, struct error *err)
{
    const struct image *image = &walk->rows.cube.image;
    if (!sampling)
        walk->linear = linear_synthesis(image->wavelengths_nm, image->n_pages,
                                        walk->standard->first_nm, walk->standard->n_nm, err);
    walk->synthesis = sampling ? sampling->synthesis : walk->linear;
    return sampling || walk->linear;
}

static int by_size(const void *a, const void *b)
{
    const float one = *(const float *)a, two = *(const float *)b;
    return (one > two) - (one < two);
}

/* Computes the mean, the quantile and the errors. A black picture of a black scene has no error. */
static void conclude(const struct walk *walk, struct accuracy *out)
{
    const struct cube *cube = &walk->rows.cube;
    const size_t n = walk->n_differences;
    double sum = 0;
    qsort(walk->differences, n, sizeof *walk->differences, by_size);
    for (size_t i = 0; i < n; i++)
        sum += (double)walk->differences[i];
    *out = (struct accuracy){.n_pages = cube->image.n_pages, .spectral = !cube->components};
    if (n > 0) {
        out->mean = sum / (double)n;
        out->quantile_95 = (double)walk->differences[n - n / 20 - 1];
        out->largest = (double)walk->differences[n - 1];
    }
    out->radiance = !walk->synthesis  ? (double)NAN
                    : walk->error > 0 ? sqrt(walk->error / walk->all)
                                      : 0;
}

static bool allocate(struct walk *walk, struct error *err)
{
    const struct standard *standard = walk->standard;
    const size_t columns = (size_t)standard->columns,
                 n_pages = (size_t)walk->rows.cube.image.n_pages,
                 n_pixels = (size_t)standard->width * (size_t)standard->height;
    return MAKE_ARRAY(walk->pages, columns * n_pages, err, "a row of radiances") &&
           MAKE_ARRAY(walk->squares, columns, err, "a row of radiances") &&
           MAKE_ARRAY(walk->differences, n_pixels, err, "differences from the standard");
}

bool standard_compare(const char *stack, const struct sampling *sampling, struct standard *standard,
                      struct accuracy *out, struct error *err)
{
    struct walk walk = {.standard = standard};
    const bool done = open_walk(&walk, stack, err) && allocate(&walk, err) &&
                      find_synthesis(&walk, sampling_or_none(sampling), err) &&
                      walk_rows(&walk, compare_chunk, compare_lattice, err);
    if (done)
        conclude(&walk, out);
    close_walk(&walk);
    return done;
}
