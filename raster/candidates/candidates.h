/* SPDX-License-Identifier: MIT */
/* The candidates of each pixel: the triangle that the reference shows, and every other triangle
 * that OpenGL may show there, with weights and bounds. */
#ifndef CANDIDATES_H
#define CANDIDATES_H

#include "raster/fragments/fragments.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- pixel.c: a triangle at a pixel ---- */

struct bounded_pixel; /* attributes with bounds on OpenGL's errors */
/* The cause of a bound: the light at the vertices; positions, where radiance changes within
 * a pixel; the place in a texture. Or there is none: the triangle has hardly any area in the
 * window, or the roundings of 1 / w are as large as it is. */
enum bound_cause {
    CAUSE_LIGHT,
    CAUSE_POSITION,
    CAUSE_TEXTURE,
    CAUSE_THIN,
    CAUSE_FAR,
    BOUND_CAUSES
};
/* A bound in the mean of all bands, in parts of shaded_brightest: the part that follows from the
 * vertices and may be the same at all pixels of an object, and the rest, which changes from
 * triangle to triangle. */
struct mean_bound {
    float shared, varying;
    enum bound_cause cause; /* of most of it */
};
/* NULL: no memory. The fragments must outlive it. */
struct bounded_pixel *pixel_open(const struct fragments *fragments);
void pixel_close(struct bounded_pixel *pixel);
/* Computes attributes and their bounds; without a texture, weights only if weights_matter. */
void pixel_bound(struct bounded_pixel *pixel, const struct bounded_triangle *triangle, int x, int y,
                 bool weights_matter);
/* Finds the places in the texture that OpenGL may sample: 1 without a texture. Take one of them. */
int pixel_choices(const struct bounded_pixel *pixel, struct texel_point out[TEXEL_CHOICES]);
void pixel_take_place(struct bounded_pixel *pixel, const struct texel_point *place);
/* Counts the outcomes of unclear gates at the triangle's vertices, the reference's first, at
 * most 8. Turn to one of them, after pixel_bound. */
int pixel_gates(const struct bounded_pixel *pixel);
void pixel_turn_gates(struct bounded_pixel *pixel, unsigned gates);
void pixel_weights(const struct bounded_pixel *pixel, double *rows); /* see put_rows */
/* Writes bounds on their errors, and on the part that each band rounds by itself, `stride` apart.
 */
struct mean_bound pixel_errors(const struct bounded_pixel *pixel, const double *rows, size_t stride,
                               float *errors, float *own);
/* Bounds the change of radiance within a pixel's width, at any wavelength. */
double pixel_steepness(const struct bounded_pixel *pixel);

/* ---- chunk.c: a part of a tile, with its candidates ---- */

/* A triangle that OpenGL may show at a pixel, with one place of its texture. */
struct candidate {
    int32_t surface, triangle;
    float depth, depth_error;
    bool loose; /* its error has no bound here */
    struct mean_bound mean;
    size_t first; /* index of its pixel_rows numbers in candidate_rows and candidate_errors */
};
/* How many fragments OpenGL may draw at a pixel, with hidden ones; it counts modulo 256. */
struct overdraw {
    uint8_t least, spread; /* least .. least + spread; a spread above 255 is stored as 255 */
    uint8_t meant;         /* the number that the reference draws */
    bool closed;           /* see is_closed */
};
/* A pixel with more than one candidate, or a loose one. */
struct ambiguous_pixel {
    int32_t pixel;        /* within the chunk, row by row */
    int32_t first, count; /* candidates */
    bool background;      /* OpenGL may also show the background */
};
/* Some rows of a tile, which one thread draws: the reference's picture, and for a check the rest:
 */
struct chunk {
    struct picture picture;
    float *errors; /* of picture.rows: bounds on OpenGL's error; NULL without a check */
    float *own;    /* of the same: bounds on what each band rounds by itself, a part of errors */
    struct mean_bound *mean; /* of each pixel that is not ambiguous */
    float *depth_error;      /* of picture.depth */
    struct overdraw *overdraw;
    float *steepness; /* bound on the change of radiance within a pixel's width, in any band */
    bool *is_ambiguous;
    struct ambiguous_pixel *ambiguous;
    struct candidate *candidates;
    double *candidate_rows;
    float *candidate_errors, *candidate_own;
    size_t n_ambiguous, n_candidates, n_numbers;
};
/* Draws chunk `index`, counted from the top, of a tile: CHUNK_ROWS rows, fewer in the last chunk.
 * Finds its candidates if the plan asks for a check. A plan that neither checks nor stores the
 * reference's pixels gets no picture: only picture.at is set. Results do not depend on how a
 * picture is cut into chunks. False: no memory. chunk_free accepts what a failure left. */
bool chunk_draw(const struct lit_scene *lit, const struct rectangle *tile, int index,
                struct chunk *out);
void chunk_free(struct chunk *chunk);

/* ---- tiles.c: the loop over tiles ---- */

/* A tile of a region of the picture. */
struct tile {
    const struct lit_scene *lit;
    struct rectangle at;
    struct chunk *chunks; /* from the top */
    int n_chunks;
};
/* Draws the chunks of a tile, by the plan's threads, calls `work`, and frees the chunks. */
bool tile_draw(const struct lit_scene *lit, const struct rectangle *at,
               bool (*work)(void *context, const struct tile *tile, struct error *err),
               void *context, struct error *err);
/* Does so with each tile of a region of the plan's picture, row by row. Stops at the first failure.
 */
bool tiles_each(const struct lit_scene *lit, const struct rectangle *region,
                bool (*work)(void *context, const struct tile *tile, struct error *err),
                void *context, struct error *err);

#endif
