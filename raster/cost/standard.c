/* SPDX-License-Identifier: MIT */
/* The picture as it should be, at every nm and in double, and how far others are off.
 *
 * The file holds CIELAB of every pixel, row by row, then a byte a pixel, 1 where an object is
 * shown, then the spectra of the lattice's pixels, row by row. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "data/base/base.h"
#include "data/colour/colour.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/stack/stack.h"
#include "data/terms/terms.h"
#include "data/tiff/tiff.h"
#include "raster/bounds/bounds.h"
#include "raster/candidates/candidates.h"
#include "raster/cost/cost.h"
#include "raster/driver/driver.h"
#include "raster/plan/plan.h"
#include "raster/radiance/radiance.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* About as many pixels' spectra are compared. */
static const double lattice_pixels = 2500;

static uint64_t n_pixels_of(const struct standard *standard)
{
    return (uint64_t)standard->width * (uint64_t)standard->height;
}

static uint64_t offset_of_shown(const struct standard *standard)
{
    return n_pixels_of(standard) * 3 * sizeof(double);
}

static uint64_t offset_of_lattice(const struct standard *standard)
{
    return offset_of_shown(standard) + n_pixels_of(standard);
}

static size_t lattice_points(const struct standard *standard)
{
    return (size_t)standard->columns * (size_t)standard->rows;
}

/* The number of a pixel on the lattice; -1: it is not. */
static ptrdiff_t lattice_index(const struct standard *standard, int x, int y)
{
    return x % standard->step != 0 || y % standard->step != 0
               ? -1
               : (ptrdiff_t)(y / standard->step) * standard->columns + x / standard->step;
}

static bool write_at(int file, uint64_t offset, const void *bytes, size_t length)
{
    for (const char *at = bytes; length > 0;) {
        const ssize_t written = pwrite(file, at, length, (off_t)offset);
        if (written <= 0)
            return false;
        at += written;
        offset += (uint64_t)written;
        length -= (size_t)written;
    }
    return true;
}

static bool read_at(int file, uint64_t offset, void *bytes, size_t length)
{
    for (char *at = bytes; length > 0;) {
        const ssize_t got = pread(file, at, length, (off_t)offset);
        if (got <= 0)
            return false;
        at += got;
        offset += (uint64_t)got;
        length -= (size_t)got;
    }
    return true;
}

/* ---- the reference ---- */

struct renderer {
    struct plan plan;
    struct lit_scene lit;
    struct standard *standard;
    double *weights; /* the observer's, at each nm */
    int file;
    double *spectra;      /* of the lattice */
    struct chunk *chunks; /* of the current tile, and XYZ of each pixel */
    double (**xyz)[3];
    int n_chunks;
};

static bool rasterize_chunk(void *context, const struct rectangle *tile, int index,
                            struct error *err)
{
    struct renderer *renderer = context;
    struct chunk *chunk = &renderer->chunks[index];
    if (!chunk_draw(&renderer->lit, tile, index, chunk, err))
        return false;
    const size_t n = (size_t)chunk->picture.at.width * (size_t)chunk->picture.at.height;
    renderer->xyz[index] = calloc(n, sizeof *renderer->xyz[index]);
    return renderer->xyz[index] || error_memory(err);
}

static bool rasterize_tile(struct renderer *renderer, const struct rectangle *tile,
                           struct error *err)
{
    renderer->n_chunks = chunk_count(tile);
    renderer->chunks = calloc((size_t)renderer->n_chunks, sizeof *renderer->chunks);
    renderer->xyz = calloc((size_t)renderer->n_chunks, sizeof *renderer->xyz);
    if (!renderer->chunks || !renderer->xyz)
        return error_memory(err);
    return chunks_each(tile, renderer->plan.options.threads, rasterize_chunk, renderer, err);
}

/* Adds radiances of a run of pixels in a band to what the observer sees of them. */
static void add_radiances(struct renderer *renderer, int index, size_t at, size_t n, int band,
                          const double *radiance)
{
    const struct standard *standard = renderer->standard;
    const struct rectangle *rows = &renderer->chunks[index].picture.at;
    const double *weight = renderer->weights + band;
    double(*xyz)[3] = renderer->xyz[index] + at;
    for (size_t i = 0; i < n; i++)
        for (int c = 0; c < 3; c++)
            xyz[i][c] += weight[c * standard->n_nm] * radiance[i];
    for (size_t i = 0; i < n; i++) {
        const int x = rows->x + (int)((at + i) % (size_t)rows->width);
        const int y = rows->y + (int)((at + i) / (size_t)rows->width);
        const ptrdiff_t point = lattice_index(standard, x, y);
        if (point >= 0)
            renderer->spectra[point * standard->n_nm + band] = radiance[i];
    }
}

/* Counts at this full scale are radiances. */
static void add_band(struct renderer *renderer, int index, int band)
{
    const struct chunk *chunk = &renderer->chunks[index];
    const size_t n_pixels = (size_t)chunk->picture.at.width * (size_t)chunk->picture.at.height;
    double radiance[BLOCK];
    for (size_t at = 0, n; at < n_pixels; at += n) {
        const int surface = chunk->picture.surface[at];
        n = run_length(chunk->picture.surface, at, n_pixels);
        if (surface < 0)
            continue;
        const struct run run = {renderer->lit.bounds[surface].shaded, chunk->picture.rows + at,
                                NULL, n_pixels, n};
        expect_counts(&renderer->plan, &run, band, FULL_COUNT, radiance, NULL);
        add_radiances(renderer, index, at, n, band, radiance);
    }
}

static bool add_bands(struct renderer *renderer, struct error *err)
{
    for (int first = 0; first < renderer->plan.n_bands; first += BANDS_PER_PASS) {
        if (!plan_load_textures(&renderer->plan, first, err))
            return false;
#pragma omp parallel for schedule(dynamic) num_threads(renderer->plan.options.threads)
        for (int i = 0; i < renderer->n_chunks; i++)
            for (int band = first; band < first + BANDS_PER_PASS && band < renderer->plan.n_bands;
                 band++)
                add_band(renderer, i, band);
    }
    return true;
}

/* XYZ of a chunk becomes CIELAB in the file. */
static bool store_chunk(struct renderer *renderer, int index)
{
    const struct standard *standard = renderer->standard;
    const struct chunk *chunk = &renderer->chunks[index];
    const size_t width = (size_t)chunk->picture.at.width;
    unsigned char *shown = calloc(width, 1);
    bool done = shown != NULL;
    for (int y = 0; done && y < chunk->picture.at.height; y++) {
        const uint64_t pixel = (uint64_t)(chunk->picture.at.y + y) * (uint64_t)standard->width +
                               (uint64_t)chunk->picture.at.x;
        double(*colour)[3] = renderer->xyz[index] + (size_t)y * width;
        for (size_t x = 0; x < width; x++) {
            double xyz[3];
            memcpy(xyz, colour[x], sizeof xyz);
            cielab(xyz, standard->white, colour[x]);
            shown[x] = chunk->picture.surface[(size_t)y * width + x] >= 0;
        }
        done = write_at(renderer->file, pixel * sizeof *colour, colour, width * sizeof *colour) &&
               write_at(renderer->file, offset_of_shown(standard) + pixel, shown, width);
    }
    free(shown);
    return done;
}

static bool store_chunks(struct renderer *renderer, struct error *err)
{
    bool done = true;
#pragma omp parallel for schedule(dynamic) num_threads(renderer->plan.options.threads) \
    reduction(&& : done)
    for (int i = 0; i < renderer->n_chunks; i++)
        done = store_chunk(renderer, i) && done;
    return done || error_system(err, "cannot store the reference picture");
}

static void free_tile(struct renderer *renderer)
{
    for (int i = 0; i < renderer->n_chunks; i++) {
        if (renderer->chunks)
            chunk_free(&renderer->chunks[i]);
        if (renderer->xyz)
            free(renderer->xyz[i]);
    }
    free(renderer->chunks);
    free(renderer->xyz);
    renderer->chunks = NULL;
    renderer->xyz = NULL;
    renderer->n_chunks = 0;
}

static bool render_tiles(struct renderer *renderer, struct error *err)
{
    const struct rectangle picture = plan_picture(&renderer->plan);
    bool done = true;
    for (int i = 0; done && i < plan_tiles(&renderer->plan, &picture); i++) {
        const struct rectangle tile = plan_tile(&renderer->plan, &picture, i);
        done = rasterize_tile(renderer, &tile, err) && add_bands(renderer, err) &&
               store_chunks(renderer, err);
        free_tile(renderer);
    }
    return done;
}

/* The lights as the observer sees them; where none shines, a radiance of 1. */
static bool find_white(const struct scene *scene, struct renderer *renderer, struct error *err)
{
    const struct spectral_pages pages = scene_pages(scene);
    struct standard *standard = renderer->standard;
    double *white = calloc((size_t)standard->n_nm, sizeof *white);
    if (!white)
        return error_memory(err);
    standard->lit = scene_white(scene, &pages, white) > 0;
    detector_response(renderer->weights, standard->lit ? white : NULL, standard->n_nm,
                      standard->white);
    if (standard->lit &&
        !(standard->white[0] > 0 || standard->white[1] > 0 || standard->white[2] > 0)) {
        standard->lit = false;
        detector_response(renderer->weights, NULL, standard->n_nm, standard->white);
    }
    free(white);
    return true;
}

static struct standard standard_of(const struct scene *scene)
{
    const double pixels = (double)scene->width * (double)scene->height;
    const int step = (int)ceil(sqrt(pixels / lattice_pixels));
    return (struct standard){.width = scene->width,
                             .height = scene->height,
                             .first_nm = scene->wavelengths_nm[0],
                             .n_nm = scene->n_wavelengths,
                             .step = step,
                             .columns = (scene->width + step - 1) / step,
                             .rows = (scene->height + step - 1) / step};
}

static bool weigh_nm(const struct scene *scene, const char *observer, struct renderer *renderer,
                     struct error *err)
{
    struct detector detector = {.name = NULL};
    const int n = renderer->standard->n_nm;
    renderer->weights = calloc(3 * (size_t)n, sizeof *renderer->weights);
    const bool done =
        renderer->weights ? observer_read(observer, &detector, err) : error_memory(err);
    if (done)
        detector_weights(&detector, scene->wavelengths_nm, n, renderer->weights);
    detector_free(&detector);
    return done;
}

static bool render_truth(const struct scene *scene, const char *observer, struct renderer *renderer,
                         struct error *err)
{
    struct standard *standard = renderer->standard;
    struct light_work work;
    renderer->spectra =
        calloc(lattice_points(standard) * (size_t)standard->n_nm, sizeof *renderer->spectra);
    if (!renderer->spectra)
        return error_memory(err);
    errno = 0;
    return weigh_nm(scene, observer, renderer, err) && find_white(scene, renderer, err) &&
           lit_make(&renderer->plan, driver_of(NULL), &renderer->lit, &work, err) &&
           render_tiles(renderer, err) &&
           (write_at(renderer->file, offset_of_lattice(standard), renderer->spectra,
                     lattice_points(standard) * (size_t)standard->n_nm *
                         sizeof *renderer->spectra) ||
            error_system(err, "cannot store the reference picture"));
}

bool standard_render(const struct scene *scene, const char *observer, int threads, const char *path,
                     struct standard *out, struct error *err)
{
    const struct plan_options options = {.store_raster = true, .bits = 32, .threads = threads};
    struct renderer renderer = {.standard = out,
                                .file = open(path, O_RDWR | O_CREAT | O_EXCL, 0600)};
    *out = standard_of(scene);
    if (renderer.file < 0)
        return error_system(err, "cannot write %s", path);
    const bool done = plan_make(scene, NULL, &options, &renderer.plan, err) &&
                      render_truth(scene, observer, &renderer, err);
    close(renderer.file);
    lit_free(&renderer.lit);
    plan_free(&renderer.plan);
    free(renderer.weights);
    free(renderer.spectra);
    return done;
}

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
    if (!read_at(comparer->file, pixel * sizeof *comparer->lab, comparer->lab,
                 n * sizeof *comparer->lab) ||
        !read_at(comparer->file, offset_of_shown(standard) + pixel, comparer->shown, n))
        return error_system(err, "cannot read the reference picture");
    for (int page = 0; page < comparer->cube.image.n_pages; page++)
        if (!image_read(&comparer->cube.image, page, y, rows, comparer->samples + (size_t)page * n,
                        err))
            return false;
    return true;
}

/* Of a pixel of n; -1 where neither picture shows an object. */
static float difference_of(const struct comparer *comparer, size_t pixel, size_t n)
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
            float *at = comparer->lattice + (size_t)lattice_index(standard, x, y + row) * n_pages;
            for (size_t page = 0; page < n_pages; page++)
                at[page] =
                    comparer->samples[page * n + (size_t)row * (size_t)standard->width + (size_t)x];
        }
}

/* Differences that count move to the front. */
static bool compare_rows(struct comparer *comparer, int y, int rows, struct error *err)
{
    const int n_pixels = rows * comparer->standard->width;
    float *differences = comparer->differences + comparer->n_differences;
    size_t n = 0;
    if (!read_rows(comparer, y, rows, err))
        return false;
#pragma omp parallel for num_threads(comparer->threads)
    for (int i = 0; i < n_pixels; i++)
        differences[i] = difference_of(comparer, (size_t)i, (size_t)n_pixels);
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

static void conclude(struct comparer *comparer, struct standard_errors *out)
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

/* What a stack of a scene without sampling tells of the radiance at each nm: linear between its
 * wavelengths, and held at the ends. [nm][page], allocated; NULL: no memory. */
static double *interpolation(const struct scene *scene, const struct standard *standard)
{
    const int n = scene->n_wavelengths;
    double *out = calloc((size_t)standard->n_nm * (size_t)n, sizeof *out);
    for (int j = 0, page = 0; out && j < standard->n_nm; j++) {
        const double nm = standard->first_nm + j, *at = scene->wavelengths_nm;
        double *row = out + (size_t)j * (size_t)n;
        while (page + 1 < n && at[page + 1] <= nm)
            page++;
        const double part =
            page + 1 < n && nm > at[page] ? (nm - at[page]) / (at[page + 1] - at[page]) : 0;
        row[page] = 1 - part;
        if (part > 0)
            row[page + 1] = part;
    }
    return out;
}

/* The sum of squares of a pixel's error, which is added to *error; and of its radiances. */
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

/* Each pixel's own, so that they are added up in one order. Where neither shows an object both are
 * 0. */
static void square_points(const struct comparer *comparer, const double *synthesis,
                          const double *spectra, double (*squares)[2])
{
    const int n_points = (int)lattice_points(comparer->standard), n_nm = comparer->standard->n_nm;
#pragma omp parallel for num_threads(comparer->threads)
    for (int i = 0; i < n_points; i++)
        add_squares(synthesis, comparer->cube.image.n_pages,
                    comparer->lattice + (size_t)i * n_pages_of(comparer),
                    spectra + (size_t)i * (size_t)n_nm, n_nm, squares[i]);
}

/* 0 of a black scene that is black. */
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
    const size_t n = lattice_points(standard), n_numbers = n * (size_t)standard->n_nm;
    double *spectra = calloc(n_numbers, sizeof *spectra),
           (*squares)[2] = calloc(n, sizeof *squares);
    bool done = spectra && squares ? true : error_memory(err);
    if (done &&
        !read_at(comparer->file, offset_of_lattice(standard), spectra, n_numbers * sizeof *spectra))
        done = error_system(err, "cannot read the reference picture");
    if (done) {
        square_points(comparer, synthesis, spectra, squares);
        *out = relative_error(squares, n);
    }
    free(spectra);
    free(squares);
    return done;
}

/* Pages that tell no radiances are NaN off. */
static bool compare_spectra(struct comparer *comparer, const struct standard_stack *stack,
                            double *out, struct error *err)
{
    *out = (double)NAN;
    if (stack->sampling)
        return !stack->sampling->synthesis ||
               compare_radiances(comparer, stack->sampling->synthesis, out, err);
    double *synthesis = interpolation(stack->scene, comparer->standard);
    const bool done =
        synthesis ? compare_radiances(comparer, synthesis, out, err) : error_memory(err);
    free(synthesis);
    return done;
}

/* ---- a stack ---- */

static bool weigh(struct comparer *comparer, const char *observer, struct error *err)
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

/* Rows of about two million samples: 8 MiB. */
static bool allocate(struct comparer *comparer, struct error *err)
{
    const struct standard *standard = comparer->standard;
    const size_t rows = ((size_t)1 << 21) / ((size_t)standard->width * n_pages_of(comparer));
    comparer->rows = rows < 1 ? 1 : rows < (size_t)standard->height ? (int)rows : standard->height;
    const size_t n = (size_t)comparer->rows * (size_t)standard->width;
    comparer->samples = calloc(n * n_pages_of(comparer), sizeof *comparer->samples);
    comparer->lab = calloc(n, sizeof *comparer->lab);
    comparer->shown = calloc(n, 1);
    comparer->differences = calloc((size_t)n_pixels_of(standard), sizeof *comparer->differences);
    comparer->lattice =
        calloc(lattice_points(standard) * n_pages_of(comparer), sizeof *comparer->lattice);
    return (comparer->samples && comparer->lab && comparer->shown && comparer->differences &&
            comparer->lattice) ||
           error_memory(err);
}

static bool compare_stack(struct comparer *comparer, const struct standard_stack *stack,
                          struct standard_errors *out, struct error *err)
{
    const int height = comparer->standard->height;
    if (!weigh(comparer, stack->observer, err) || !allocate(comparer, err))
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

bool standard_compare(const struct standard *standard, const char *path,
                      const struct standard_stack *stack, int threads, struct standard_errors *out,
                      struct error *err)
{
    struct comparer comparer = {
        .standard = standard, .file = open(path, O_RDONLY), .threads = threads_start(threads)};
    *out = (struct standard_errors){.mean = 0};
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
