/* SPDX-License-Identifier: MIT */
/* The channels of pixels: sums of weighted pages. A stack is read in chunks of rows, a few pages at
 * a time. Each pixel is summed in the order of the pages, so that chunks and threads do not change
 * its bits. */
#include <stdlib.h>
#include <string.h>

#include "raster/beside/see/inside.h"

enum {
    BATCH = 8,              /* pages that are read before they are added up */
    CHUNK_BYTES = 56 << 21, /* at most, or one row */
    BLOCK_PIXELS = 1 << 13  /* that a thread takes at a time */
};

bool rows_make_room(struct development *of, struct error *err)
{
    const struct image *image = &of->cube.image;
    const size_t n = (size_t)of->sight.detector.n,
                 pixel = BATCH * sizeof(float) + n * sizeof(double);
    const int rows = (int)(CHUNK_BYTES / pixel / (size_t)image->width);
    of->most = rows < 1 ? 1 : rows < image->height ? rows : image->height;
    of->stride = (size_t)of->most * (size_t)image->width;
    of->threads = threads_count(of->threads);
    return (of->lit ||
            MAKE_ARRAY(of->radiance, BATCH * of->stride, err, "rows of %s", image->path)) &&
           MAKE_ARRAY(of->sums, n * of->stride, err, "rows of the picture") &&
           (memory_make(&of->samples, n * of->stride, (size_t)of->bits / 8) ||
            memory_lacks(err, (double)(n * of->stride) * of->bits / 8, "rows of the picture"));
}

/* Pages that are added to a chunk, from the first one on. */
struct batch {
    const struct development *of;
    int first;
};

/* Adds them to some pixels, page after page. Pages missing in the last batch have weight 0. */
static void add_pixels(void *context, size_t first, size_t end)
{
    const struct batch *batch = context;
    const struct development *of = batch->of;
    const int n_pages = of->cube.image.n_pages;
    const float *restrict radiance = of->radiance;
    for (int channel = 0; channel < of->sight.detector.n; channel++) {
        double *restrict sums = of->sums + (size_t)channel * of->stride;
        double weights[BATCH] = {0};
        for (int page = 0; page < BATCH && batch->first + page < n_pages; page++)
            weights[page] = of->sight.weights[channel * n_pages + batch->first + page];
        for (size_t i = first; i < end; i++) {
            double sum = sums[i];
            for (size_t page = 0; page < BATCH; page++)
                sum += weights[page] * (double)radiance[page * of->stride + i];
            sums[i] = sum;
        }
    }
}

/* Adds a band of some rows of a scene. */
static void add_band(void *context, const struct drawn_band *drawn)
{
    const struct development *of = context;
    const struct rectangle *at = &drawn->pixels;
    const int n_pages = of->cube.image.n_pages, width = of->cube.image.width;
    const float *radiance = drawn->radiance;
    for (int y = 0; y < at->height; y++, radiance += at->width)
        for (int channel = 0; channel < of->sight.detector.n; channel++) {
            const double weight = of->sight.weights[channel * n_pages + drawn->band];
            double *sums = of->sums + (size_t)channel * of->stride +
                           (size_t)(at->y + y - of->first) * (size_t)width + at->x;
            for (int x = 0; x < at->width; x++)
                sums[x] += weight * (double)radiance[x];
        }
}

bool rows_sum(struct development *of, int y, struct error *err)
{
    struct image *image = &of->cube.image;
    const struct rectangle at = {0, y, image->width,
                                 of->most < image->height - y ? of->most : image->height - y};
    struct radiances scene = {of->threads, add_band, of};
    struct batch batch = {.of = of};
    memset(of->sums, 0, (size_t)of->sight.detector.n * of->stride * sizeof *of->sums);
    of->first = y;
    of->n = (size_t)at.width * (size_t)at.height;
    if (of->lit)
        return radiances_each(of->lit, &at, &scene, err);
    for (int page = 0; page < image->n_pages; page++) {
        batch.first = page / BATCH * BATCH;
        if (!image_read(image, page, y, at.height,
                        of->radiance + (size_t)(page - batch.first) * of->stride, err))
            return false;
        if (page - batch.first == BATCH - 1 || page == image->n_pages - 1)
            threads_blocks(of->threads, of->n, BLOCK_PIXELS, add_pixels, &batch);
    }
    return true;
}
