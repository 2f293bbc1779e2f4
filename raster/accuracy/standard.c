/* SPDX-License-Identifier: MIT */
/* The standard: the picture at every nm, in double.
 *
 * Its file holds CIELAB of every pixel, row by row, then a byte a pixel, 1 where an object is
 * shown, then the spectra of the lattice's pixels, row by row. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "data/colour/colour.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/terms/terms.h"
#include "raster/accuracy/accuracy.h"
#include "raster/bounds/bounds.h"
#include "raster/candidates/candidates.h"
#include "raster/driver/driver.h"
#include "raster/plan/plan.h"
#include "raster/radiance/radiance.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* The lattice has about so many points. */
static const double lattice_pixels = 2500;

uint64_t standard_pixels(const struct standard *standard)
{
    return (uint64_t)standard->width * (uint64_t)standard->height;
}

uint64_t standard_offset_of_shown(const struct standard *standard)
{
    return standard_pixels(standard) * 3 * sizeof(double);
}

uint64_t standard_offset_of_lattice(const struct standard *standard)
{
    return standard_offset_of_shown(standard) + standard_pixels(standard);
}

size_t standard_lattice_points(const struct standard *standard)
{
    return (size_t)standard->columns * (size_t)standard->rows;
}

ptrdiff_t standard_lattice_index(const struct standard *standard, int x, int y)
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

bool standard_read(int file, uint64_t offset, void *bytes, size_t length, struct error *err)
{
    for (char *at = bytes; length > 0;) {
        const ssize_t got = pread(file, at, length, (off_t)offset);
        if (got <= 0)
            return error_system(err, "cannot read the reference picture");
        at += got;
        offset += (uint64_t)got;
        length -= (size_t)got;
    }
    return true;
}

/* ---- the picture ---- */

struct renderer {
    struct plan plan;
    struct lit_scene lit;
    struct standard *standard;
    double *weights; /* of the observer, at each nm */
    int file;
    double *spectra;         /* of the lattice */
    const struct tile *tile; /* the current one, and XYZ of the pixels of its chunks */
    double (**xyz)[3];
};

static bool allocate_colours(struct renderer *renderer, struct error *err)
{
    const struct tile *tile = renderer->tile;
    renderer->xyz = calloc((size_t)tile->n_chunks, sizeof *renderer->xyz);
    for (int i = 0; renderer->xyz && i < tile->n_chunks; i++) {
        const struct rectangle *at = &tile->chunks[i].picture.at;
        const size_t n = (size_t)at->width * (size_t)at->height;
        renderer->xyz[i] = calloc(n, sizeof *renderer->xyz[i]);
        if (!renderer->xyz[i])
            return error_memory(err);
    }
    return renderer->xyz || error_memory(err);
}

/* Adds the radiances of a run of pixels in a band to XYZ of these pixels, and keeps those on the
 * lattice. */
static void add_radiances(struct renderer *renderer, int index, size_t at, size_t n, int band,
                          const double *radiance)
{
    const struct standard *standard = renderer->standard;
    const struct rectangle *rows = &renderer->tile->chunks[index].picture.at;
    const double *weight = renderer->weights + band;
    double(*xyz)[3] = renderer->xyz[index] + at;
    for (size_t i = 0; i < n; i++)
        for (int c = 0; c < 3; c++)
            xyz[i][c] += weight[c * standard->n_nm] * radiance[i];
    for (size_t i = 0; i < n; i++) {
        const int x = rows->x + (int)((at + i) % (size_t)rows->width);
        const int y = rows->y + (int)((at + i) / (size_t)rows->width);
        const ptrdiff_t point = standard_lattice_index(standard, x, y);
        if (point >= 0)
            renderer->spectra[point * standard->n_nm + band] = radiance[i];
    }
}

/* At this full scale counts are radiances. */
static void add_band(struct renderer *renderer, int index, int band)
{
    const struct chunk *chunk = &renderer->tile->chunks[index];
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
        for (int i = 0; i < renderer->tile->n_chunks; i++)
            for (int band = first; band < first + BANDS_PER_PASS && band < renderer->plan.n_bands;
                 band++)
                add_band(renderer, i, band);
    }
    return true;
}

/* Writes CIELAB of a chunk, and which of its pixels show an object. */
static bool store_chunk(struct renderer *renderer, int index)
{
    const struct standard *standard = renderer->standard;
    const struct chunk *chunk = &renderer->tile->chunks[index];
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
               write_at(renderer->file, standard_offset_of_shown(standard) + pixel, shown, width);
    }
    free(shown);
    return done;
}

static bool store_chunks(struct renderer *renderer, struct error *err)
{
    bool done = true;
#pragma omp parallel for schedule(dynamic) num_threads(renderer->plan.options.threads) \
    reduction(&& : done)
    for (int i = 0; i < renderer->tile->n_chunks; i++)
        done = store_chunk(renderer, i) && done;
    return done || error_system(err, "cannot store the reference picture");
}

static bool render_tile(void *context, const struct tile *tile, struct error *err)
{
    struct renderer *renderer = context;
    renderer->tile = tile;
    const bool done =
        allocate_colours(renderer, err) && add_bands(renderer, err) && store_chunks(renderer, err);
    for (int i = 0; renderer->xyz && i < tile->n_chunks; i++)
        free(renderer->xyz[i]);
    free(renderer->xyz);
    return done;
}

/* The white is XYZ of the lights; where the observer sees none, of a radiance of 1. */
static bool find_white(const struct scene *scene, struct renderer *renderer, struct error *err)
{
    const struct spectral_pages pages = scene_pages(scene);
    struct standard *standard = renderer->standard;
    double *white = calloc((size_t)standard->n_nm, sizeof *white);
    if (!white)
        return error_memory(err);
    const bool shines = scene_white(scene, &pages, white) > 0;
    detector_response(renderer->weights, white, standard->n_nm, standard->white);
    standard->lit =
        shines && (standard->white[0] > 0 || standard->white[1] > 0 || standard->white[2] > 0);
    if (!standard->lit)
        detector_response(renderer->weights, NULL, standard->n_nm, standard->white);
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

static bool find_weights(const struct scene *scene, const char *observer, struct renderer *renderer,
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

static bool render_picture(const struct scene *scene, const char *observer,
                           struct renderer *renderer, struct error *err)
{
    struct standard *standard = renderer->standard;
    const struct rectangle picture = plan_picture(&renderer->plan);
    struct light_work work;
    renderer->spectra = calloc(standard_lattice_points(standard) * (size_t)standard->n_nm,
                               sizeof *renderer->spectra);
    if (!renderer->spectra)
        return error_memory(err);
    errno = 0;
    return find_weights(scene, observer, renderer, err) && find_white(scene, renderer, err) &&
           lit_make(&renderer->plan, driver_of(NULL), &renderer->lit, &work, err) &&
           tiles_each(&renderer->lit, &picture, render_tile, renderer, err) &&
           (write_at(renderer->file, standard_offset_of_lattice(standard), renderer->spectra,
                     standard_lattice_points(standard) * (size_t)standard->n_nm *
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
                      render_picture(scene, observer, &renderer, err);
    close(renderer.file);
    lit_free(&renderer.lit);
    plan_free(&renderer.plan);
    free(renderer.weights);
    free(renderer.spectra);
    return done;
}
