/* SPDX-License-Identifier: MIT */
/* How far a stack is from the standard: the differences of colours over all pixels, and the errors
 * of radiances on the lattice. */
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "data/base/base.h"
#include "data/colour/colour.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/stack/stack.h"
#include "data/tiff/tiff.h"
#include "raster/accuracy/accuracy.h"
#include "spectral.h"

/* ---- colours of a stack ---- */

struct comparer {
    const struct standard *standard;
    int file, threads;
    struct cube cube;
    double *weights;
    int rows;       /* read at once */
    float *samples; /* [page][pixel of the rows] */
    double (*lab)[3];
    unsigned char *shown;
    float *differences; /* of the pixels so far in which either picture shows an object */
    size_t n_differences;
    float *lattice; /* [point][page] */
};

static size_t n_pages_of(const struct comparer *comparer)
{
    return (size_t)comparer->cube.image.n_pages;
}

static bool read_rows(struct comparer *comparer, int y, int rows, struct error *err)
{
    const struct standard *standard = comparer->standard;
    const uint64_t pixel = (uint64_t)y * (uint64_t)standard->width;
    const size_t n = (size_t)rows * (size_t)standard->width;
    if (!standard_read(comparer->file, pixel * sizeof *comparer->lab, comparer->lab,
                       n * sizeof *comparer->lab, err) ||
        !standard_read(comparer->file, standard_offset_of_shown(standard) + pixel, comparer->shown,
                       n, err))
        return false;
    for (int page = 0; page < comparer->cube.image.n_pages; page++)
        if (!image_read(&comparer->cube.image, page, y, rows, comparer->samples + (size_t)page * n,
                        err))
            return false;
    return true;
}

/* Returns CIEDE2000 at one of the n pixels of these rows; -1: neither picture shows an object. */
static float difference_at(const struct comparer *comparer, size_t pixel, size_t n)
{
    const size_t n_pages = n_pages_of(comparer);
    double xyz[3] = {0, 0, 0}, lab[3];
    for (size_t page = 0; page < n_pages; page++)
        for (size_t c = 0; c < 3; c++)
            xyz[c] +=
                comparer->weights[c * n_pages + page] * (double)comparer->samples[page * n + pixel];
    if (!comparer->shown[pixel] && !(fabs(xyz[0]) > 0 || fabs(xyz[1]) > 0 || fabs(xyz[2]) > 0))
        return -1;
    cielab(xyz, comparer->standard->white, lab);
    return (float)ciede2000_difference(comparer->lab[pixel], lab);
}

static void keep_lattice(struct comparer *comparer, int y, int rows)
{
    const struct standard *standard = comparer->standard;
    const size_t n = (size_t)rows * (size_t)standard->width, n_pages = n_pages_of(comparer);
    for (int row = 0; row < rows; row++)
        for (int x = 0; (y + row) % standard->step == 0 && x < standard->width;
             x += standard->step) {
            float *at =
                comparer->lattice + (size_t)standard_lattice_index(standard, x, y + row) * n_pages;
            for (size_t page = 0; page < n_pages; page++)
                at[page] =
                    comparer->samples[page * n + (size_t)row * (size_t)standard->width + (size_t)x];
        }
}

/* Only the differences of pixels that show an object are kept. */
static bool compare_rows(struct comparer *comparer, int y, int rows, struct error *err)
{
    const int n_pixels = rows * comparer->standard->width;
    float *differences = comparer->differences + comparer->n_differences;
    size_t n = 0;
    if (!read_rows(comparer, y, rows, err))
        return false;
#pragma omp parallel for num_threads(comparer->threads)
    for (int i = 0; i < n_pixels; i++)
        differences[i] = difference_at(comparer, (size_t)i, (size_t)n_pixels);
    for (int i = 0; i < n_pixels; i++)
        if (differences[i] >= 0)
            differences[n++] = differences[i];
    comparer->n_differences += n;
    keep_lattice(comparer, y, rows);
    return true;
}

static int by_size(const void *a, const void *b)
{
    const float one = *(const float *)a, two = *(const float *)b;
    return (one > two) - (one < two);
}

static void conclude(struct comparer *comparer, struct accuracy *out)
{
    const size_t n = comparer->n_differences;
    double sum = 0;
    qsort(comparer->differences, n, sizeof *comparer->differences, by_size);
    for (size_t i = 0; i < n; i++)
        sum += (double)comparer->differences[i];
    if (n == 0)
        return;
    out->mean = sum / (double)n;
    out->quantile_95 = (double)comparer->differences[n - n / 20 - 1];
    out->largest = (double)comparer->differences[n - 1];
}

/* ---- radiances of a stack ---- */

/* Adds to squares[0] the squares of a pixel's errors, and to squares[1] those of its radiances. */
static void add_squares(const double *synthesis, int n_pages, const float *pages,
                        const double *spectrum, int n_nm, double squares[2])
{
    for (int j = 0; j < n_nm; j++, synthesis += n_pages) {
        double radiance = 0;
        for (int page = 0; page < n_pages; page++)
            radiance += synthesis[page] * (double)pages[page];
        squares[0] += (radiance - spectrum[j]) * (radiance - spectrum[j]);
        squares[1] += spectrum[j] * spectrum[j];
    }
}

/* Each point has sums of its own, so that any number of threads adds them up in one order. They are
 * 0 where neither picture shows an object. */
static void square_points(const struct comparer *comparer, const double *synthesis,
                          const double *spectra, double (*squares)[2])
{
    const int n_points = (int)standard_lattice_points(comparer->standard),
              n_nm = comparer->standard->n_nm;
#pragma omp parallel for num_threads(comparer->threads)
    for (int i = 0; i < n_points; i++)
        add_squares(synthesis, comparer->cube.image.n_pages,
                    comparer->lattice + (size_t)i * n_pages_of(comparer),
                    spectra + (size_t)i * (size_t)n_nm, n_nm, squares[i]);
}

/* A black picture of a black scene has no error. */
static double relative_error(double (*squares)[2], size_t n)
{
    double error = 0, all = 0;
    for (size_t i = 0; i < n; i++) {
        error += squares[i][0];
        all += squares[i][1];
    }
    return error > 0 ? sqrt(error / all) : 0;
}

static bool compare_radiances(struct comparer *comparer, const double *synthesis, double *out,
                              struct error *err)
{
    const struct standard *standard = comparer->standard;
    const size_t n = standard_lattice_points(standard), n_numbers = n * (size_t)standard->n_nm;
    double *spectra = calloc(n_numbers, sizeof *spectra),
           (*squares)[2] = calloc(n, sizeof *squares);
    bool done = spectra && squares ? true : error_memory(err);
    done = done && standard_read(comparer->file, standard_offset_of_lattice(standard), spectra,
                                 n_numbers * sizeof *spectra, err);
    if (done) {
        square_points(comparer, synthesis, spectra, squares);
        *out = relative_error(squares, n);
    }
    free(spectra);
    free(squares);
    return done;
}

/* *out becomes NaN where the pages determine no radiances. */
static bool compare_spectra(struct comparer *comparer, const struct accuracy_stack *stack,
                            double *out, struct error *err)
{
    *out = (double)NAN;
    if (stack->sampling)
        return !stack->sampling->synthesis ||
               compare_radiances(comparer, stack->sampling->synthesis, out, err);
    const struct scene *scene = stack->scene;
    const struct standard *standard = comparer->standard;
    double *synthesis = linear_synthesis(scene->wavelengths_nm, scene->n_wavelengths,
                                         standard->first_nm, standard->n_nm, err);
    const bool done = synthesis && compare_radiances(comparer, synthesis, out, err);
    free(synthesis);
    return done;
}

/* ---- a stack ---- */

static bool find_weights(struct comparer *comparer, const char *observer, struct error *err)
{
    struct detector detector = {.name = NULL};
    comparer->weights = calloc(3 * n_pages_of(comparer), sizeof *comparer->weights);
    const bool done = comparer->weights
                          ? detector_read(observer, &detector, err) &&
                                cube_weights(&comparer->cube, &detector, comparer->weights, err)
                          : error_memory(err);
    detector_free(&detector);
    return done;
}

/* About two million samples are read at once: 8 MiB. */
static bool allocate(struct comparer *comparer, struct error *err)
{
    const struct standard *standard = comparer->standard;
    const size_t rows = ((size_t)1 << 21) / ((size_t)standard->width * n_pages_of(comparer));
    comparer->rows = rows < 1 ? 1 : rows < (size_t)standard->height ? (int)rows : standard->height;
    const size_t n = (size_t)comparer->rows * (size_t)standard->width;
    comparer->samples = calloc(n * n_pages_of(comparer), sizeof *comparer->samples);
    comparer->lab = calloc(n, sizeof *comparer->lab);
    comparer->shown = calloc(n, 1);
    comparer->differences =
        calloc((size_t)standard_pixels(standard), sizeof *comparer->differences);
    comparer->lattice =
        calloc(standard_lattice_points(standard) * n_pages_of(comparer), sizeof *comparer->lattice);
    return (comparer->samples && comparer->lab && comparer->shown && comparer->differences &&
            comparer->lattice) ||
           error_memory(err);
}

static bool compare_stack(struct comparer *comparer, const struct accuracy_stack *stack,
                          struct accuracy *out, struct error *err)
{
    const int height = comparer->standard->height;
    if (!find_weights(comparer, stack->observer, err) || !allocate(comparer, err))
        return false;
    for (int y = 0; y < height; y += comparer->rows) {
        const int left = height - y;
        if (!compare_rows(comparer, y, left < comparer->rows ? left : comparer->rows, err))
            return false;
    }
    conclude(comparer, out);
    out->n_pages = comparer->cube.image.n_pages;
    out->spectral = !stack->sampling || stack->sampling->spectral;
    return compare_spectra(comparer, stack, &out->radiance, err);
}

bool accuracy_measure(const struct standard *standard, const char *path,
                      const struct accuracy_stack *stack, int threads, struct accuracy *out,
                      struct error *err)
{
    struct comparer comparer = {
        .standard = standard, .file = open(path, O_RDONLY), .threads = threads_start(threads)};
    *out = (struct accuracy){.mean = 0};
    const bool done = comparer.file < 0 ? error_system(err, "cannot read %s", path)
                                        : cube_open(stack->path, &comparer.cube, err) &&
                                              compare_stack(&comparer, stack, out, err);
    if (comparer.file >= 0)
        close(comparer.file);
    cube_close(&comparer.cube);
    free(comparer.weights);
    free(comparer.samples);
    free(comparer.lab);
    free(comparer.shown);
    free(comparer.differences);
    free(comparer.lattice);
    return done;
}
