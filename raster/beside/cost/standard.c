/* SPDX-License-Identifier: MIT */
/* Summaries of stacks, and the difference of a configuration's from the standard's.
 *
 * render draws the standard as it draws any configuration: a stack of floats with a page at every
 * nm. That stack is too large to be read again for each measurement, so a summary is kept: a struct
 * seen_pixel of each pixel, row by row; and all pages of a lattice of pixels, again row by row. The
 * lattice is every step-th pixel of every step-th row.
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

void summary_free(struct summary *summary)
{
    FREE_ALL(summary->pixels, summary->lattice);
    *summary = (struct summary){.pixels = NULL};
}

static size_t count_pixels(const struct summary *summary)
{
    return (size_t)summary->width * (size_t)summary->height;
}

/* ---- a summary ---- */

/* Reads a stack, and summarizes it. */
struct walk {
    struct summary *out;
    const struct summary *standard; /* NULL: the stack is the standard's */
    struct stack_rows rows;
    struct sight sight;
    struct seen_pixel *pixels; /* those of the current rows */
};

static void close_walk(struct walk *walk)
{
    rows_close(&walk->rows);
    sight_free(&walk->sight);
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

/* Finds which pixels of the chunk show an object, by the map of the stack. */
static bool find_shown(const struct walk *walk, struct error *err)
{
    struct seen_pixel *pixel = walk->pixels;
    const int width = walk->out->width;
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

static void see_pixels(void *context, size_t first, size_t end)
{
    const struct walk *walk = context;
    for (size_t i = first; i < end; i++) {
        struct seen_pixel *pixel = &walk->pixels[i];
        double xyz[3];
        pixel->shown = find_xyz(walk, i, xyz) || pixel->shown;
        cielab(xyz, walk->out->white, pixel->lab);
    }
}

static bool walk_rows(struct walk *walk, struct error *err)
{
    const struct summary *out = walk->out;
    const int threads = threads_count(out->threads);
    float *lattice = out->lattice;
    walk->pixels = out->pixels;
    for (int y = 0; y < out->height; y += walk->rows.most) {
        if (!rows_read(&walk->rows, y, err) || (!walk->standard && !find_shown(walk, err)))
            return false;
        const size_t n_pixels = (size_t)walk->rows.n * (size_t)out->width;
        threads_blocks(threads, n_pixels, BLOCK_PIXELS, see_pixels, walk);
        walk->pixels += n_pixels;
        for (size_t at = 0; at < n_pixels; at++)
            if ((y + (int)(at / (size_t)out->width)) % out->step == 0 &&
                (int)(at % (size_t)out->width) % out->step == 0)
                for (int page = 0; page < out->n_pages; page++)
                    *lattice++ = walk->rows.samples[(size_t)page * walk->rows.stride + at];
    }
    return true;
}

/* Describes the stack, and makes room for its summary. */
static bool describe(struct walk *walk, struct error *err)
{
    const struct image *image = &walk->rows.cube.image;
    const double *white = walk->sight.white;
    struct summary *out = walk->out;
    out->width = image->width;
    out->height = image->height;
    out->n_pages = image->n_pages;
    out->first_nm = image->wavelengths_nm ? image->wavelengths_nm[0] : 0;
    const int step = (int)ceil(sqrt((double)count_pixels(out) / lattice_pixels));
    out->step = step;
    out->n_points = ((image->width + step - 1) / step) * ((image->height + step - 1) / step);
    out->lit = walk->sight.has_white && (white[0] > 0 || white[1] > 0 || white[2] > 0);
    detector_response(walk->sight.weights, NULL, image->n_pages, out->white);
    if (walk->standard || out->lit)
        memcpy(out->white, walk->standard ? walk->standard->white : white, sizeof out->white);
    return MAKE_ARRAY(out->pixels, count_pixels(out), err, "the pixels of a stack") &&
           MAKE_ARRAY(out->lattice, (size_t)out->n_points * (size_t)out->n_pages, err,
                      "the radiances of a stack");
}

static bool summarize(struct walk *walk, const char *stack, struct error *err)
{
    const struct white_request white = {NULL, false};
    return cube_open(stack, &walk->rows.cube, err) &&
           rows_allocate(&walk->rows, chunk_samples, err) &&
           sight_make(&walk->rows.cube, walk->out->observer, &white, &walk->sight, err) &&
           describe(walk, err) && walk_rows(walk, err);
}

bool standard_summarize(const char *stack, struct summary *out, struct error *err)
{
    struct walk walk = {.out = out};
    const bool done = summarize(&walk, stack, err);
    close_walk(&walk);
    return done;
}

/* ---- the difference of a stack ---- */

struct comparison {
    const struct summary *standard, *seen;
    float *differences;      /* of each pixel; -1: neither picture shows an object; owned */
    const double *synthesis; /* radiances at every nm from pages, [nm][page]; NULL: there is none */
    double (*squares)[2];    /* of each point: of errors of radiances, and of radiances; owned */
};

static void compare_pixels(void *context, size_t first, size_t end)
{
    const struct comparison *of = context;
    for (size_t i = first; i < end; i++) {
        const struct seen_pixel *a = &of->standard->pixels[i], *b = &of->seen->pixels[i];
        of->differences[i] =
            a->shown || b->shown ? (float)ciede2000_difference(a->lab, b->lab) : -1;
    }
}

/* Sums up squares at a point of the lattice, over every nm. */
static void square(void *context, int point)
{
    const struct comparison *of = context;
    const int n_pages = of->seen->n_pages, n_nm = of->standard->n_pages;
    const double *synthesis = of->synthesis;
    const float *pages = of->seen->lattice + (size_t)point * (size_t)n_pages;
    const float *expected = of->standard->lattice + (size_t)point * (size_t)n_nm;
    double *squares = of->squares[point];
    for (int j = 0; j < n_nm; j++, synthesis += n_pages) {
        double radiance = 0;
        for (int page = 0; page < n_pages; page++)
            radiance += synthesis[page] * (double)pages[page];
        const double error = radiance - (double)expected[j];
        squares[0] += error * error;
        squares[1] += (double)expected[j] * (double)expected[j];
    }
}

/* Finds the relative error of radiances. Adds the sums in the order of the points, so that the
 * number of threads does not matter. A black picture of a black scene has no error. */
static double radiance_error(struct comparison *of)
{
    double error = 0, all = 0;
    if (!of->synthesis)
        return (double)NAN;
    threads_each(threads_count(of->seen->threads), of->seen->n_points, square, of);
    for (int i = 0; i < of->seen->n_points; i++) {
        error += of->squares[i][0];
        all += of->squares[i][1];
    }
    return error > 0 ? sqrt(error / all) : 0;
}

static int by_size(const void *a, const void *b)
{
    const float one = *(const float *)a, two = *(const float *)b;
    return (one > two) - (one < two);
}

/* Finds the mean and the quantile of the pixels that show an object: the last n, once sorted. */
static void colour_errors(struct comparison *of, struct accuracy *out)
{
    const size_t n_pixels = count_pixels(of->seen);
    const float *shown = of->differences;
    double sum = 0;
    threads_blocks(threads_count(of->seen->threads), n_pixels, BLOCK_PIXELS, compare_pixels, of);
    qsort(of->differences, n_pixels, sizeof *of->differences, by_size);
    while (shown < of->differences + n_pixels && *shown < 0)
        shown++;
    const size_t n = (size_t)(of->differences + n_pixels - shown);
    for (size_t i = 0; i < n; i++)
        sum += (double)shown[i];
    if (n > 0) {
        out->mean = sum / (double)n;
        out->quantile_95 = (double)shown[n - n / 20 - 1];
        out->largest = (double)shown[n - 1];
    }
}

/* Without a sampling, radiances are linear between the wavelengths of the stack. */
bool standard_compare(const char *stack, const struct sampling *sampling,
                      const struct summary *standard, struct accuracy *out, struct error *err)
{
    struct summary seen = {.observer = standard->observer, .threads = standard->threads};
    struct walk walk = {.out = &seen, .standard = standard};
    struct comparison of = {.standard = standard, .seen = &seen, .synthesis = sampling->synthesis};
    double *linear = NULL;
    bool done =
        summarize(&walk, stack, err) &&
        MAKE_ARRAY(of.differences, count_pixels(&seen), err, "differences from the standard") &&
        MAKE_ARRAY(of.squares, seen.n_points, err, "differences from the standard");
    if (done && !sampling_or_none(sampling)) {
        of.synthesis = linear = linear_synthesis(walk.rows.cube.image.wavelengths_nm, seen.n_pages,
                                                 standard->first_nm, standard->n_pages, err);
        done = linear != NULL;
    }
    if (done) {
        *out = (struct accuracy){.n_pages = seen.n_pages,
                                 .spectral = !walk.rows.cube.components,
                                 .radiance = radiance_error(&of),
                                 .n_peaks = sampling->n_peaks,
                                 .rank = sampling->rank};
        colour_errors(&of, out);
    }
    FREE_ALL(of.differences, of.squares, linear);
    close_walk(&walk);
    summary_free(&seen);
    return done;
}
