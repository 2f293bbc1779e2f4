/* SPDX-License-Identifier: MIT */
/* Judges each pixel of OpenGL's picture: some candidate must explain its triangle, its depth, its
 * fragments and its radiance in every band, within bounds. This room draws nothing, and may not
 * know how bounds and candidates come about. No pixel is skipped. */
#ifndef CHECK_H
#define CHECK_H

#include "raster/candidates/candidates.h"
#include "raster/fit/fit.h"
#include "raster/renderer/renderer.h"
#include "raster/verdict/verdict.h"
#include "spectral.h"

/* ---- check.c: the verdict on each pixel ---- */

/* The state of a chunk while its bands go by. */
struct check {
    const struct check_scene *scene;
    const struct chunk *chunk;
    struct stretch *stretches; /* of pixels with a single candidate; in all, all of them */
    size_t n_stretches;
    bool tight_edges; /* fragments lost or doubled where triangles meet are failures */
    struct check_verdict verdict;
    struct hypothesis *hypotheses; /* one a candidate, then each ambiguous pixel's background */
    bool *failed;                  /* pixels that are not explained */
    /* of each pixel: the largest error that could pass in all bands alike, and in one band alone;
     * infinite: it has no bound; negative: it shows the background */
    float *floor, *band_floor;
    float *ratio;               /* the largest error / bound; NULL: no map is wanted */
    float *estimates;           /* [row][pixel]: see fit.h */
    float *candidate_estimates; /* [candidate][row] */
};
/* Opens the check of a chunk. Scene and chunk must outlive it. On failure *out is zeroed. */
bool check_open(const struct check_scene *scene, const struct chunk *chunk, struct check *out,
                struct error *err);
/* Judges triangles, depths and fragments that the renderer has identified in this tile; to be
 * called before the first pass. */
void check_identity(struct check *check, const struct renderer *renderer,
                    const struct rectangle *tile);
/* Learns from a pass with pilots; to be called for all of these before the first check_pass.
 * `pixels` is the chunk's first pixel, 4 floats each, rows `stride` pixels apart, in units of
 * full_scale. */
void check_pilots(struct check *check, int first_band, const float *pixels, size_t stride);
/* Judges the bands of a pass, with the same arguments. */
void check_pass(struct check *check, int first_band, const float *pixels, size_t stride);
/* Settles ambiguous pixels, and adds the chunk's verdict to its tile's totals. The tile has the
 * chunk and its neighbours, all of them drawn. */
void check_settle(struct check *check, const struct tile *tile, struct check_totals *totals);
/* The class of a pixel in the map; the chunk is settled. */
enum check_class { CLASS_CHECKED, CLASS_AMBIGUOUS, CLASS_NOT_CHECKED, CLASS_DIFFERS };
enum check_class check_class(const struct check *check, size_t pixel);
void check_free(struct check *check);

/* ---- inside this room ---- */

/* Pixels of one surface, or of the background, in a row: at most BLOCK. */
struct stretch {
    size_t first, n;
};
/* The hypothesis that OpenGL shows a candidate: it is alive until it fails to explain a sample. */
struct hypothesis {
    bool alive;
    struct check_samples samples;
    double floor, band_floor; /* the largest errors that could pass */
    struct check_failure failure;
    int band; /* the last one; -1: OpenGL shows another candidate */
};
size_t chunk_pixels(const struct chunk *chunk);
/* Counts the pixel as not explained. The first such pixel is kept with its failure. */
void check_fail(struct check *check, size_t pixel, const struct check_failure *failure);

#endif
