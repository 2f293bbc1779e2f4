/* SPDX-License-Identifier: MIT */
/* The room "candidates": after the reference has drawn, triangles are walked a second time as
 * OpenGL sets them up: clipped at the tile's border and in depth, fanned, and interpolated through
 * planes. The candidates of a pixel are the triangle that the reference shows and every other one
 * that OpenGL may show there, with weights and bounds; and how many fragments it may draw, hidden
 * ones included. "slack" bounds a position. */
#ifndef RASTER_CANDIDATES_CANDIDATES_H
#define RASTER_CANDIDATES_CANDIDATES_H

#include "raster/bounds/bounds.h"

/* ---- pixel.c: a triangle at a pixel ---- */

/* The cause of a bound: the light at the vertices; positions, where radiance changes within
 * a pixel; the place in a texture. Or there is none: the triangle has hardly any area in the
 * window, or the roundings of 1 / w are as large as it is. */
enum bound_cause {
    CAUSE_LIGHT,
    CAUSE_POSITION,
    CAUSE_TEXTURE,
    CAUSE_THIN,
    CAUSE_FAR,
    CAUSE_DEPTH,
    CAUSE_SHADOW,
    CAUSE_UPON, /* several surfaces have one depth */
    CAUSE_EDGE, /* the place of an edge, by a rounding: see is_between */
    BOUND_CAUSES
};
/* A bound in the mean of all bands, in parts of shaded_brightest: the part that follows from the
 * vertices and may be the same at all pixels of an object, and the rest, which changes from
 * triangle to triangle. */
struct mean_bound {
    float shared, varying;
    enum bound_cause cause; /* of most of it */
};

/* ---- chunk.c: a part of a tile, with its candidates ---- */

/* A triangle that OpenGL may show at a pixel, with one place of its texture. */
struct candidate {
    int32_t surface, triangle;
    float depth, depth_error;
    bool loose;     /* its error has no bound here */
    bool covers;    /* OpenGL has it there for sure, however it rounds edges */
    bool vanishes;  /* its depth may round to that of the near or the far plane */
    unsigned gates; /* see pixel_turn_gates */
    uint32_t dark;  /* lights that do not reach it */
    float open;     /* OpenGL may show a rival, so far apart in some band: see are_rivals */
    enum bound_cause open_cause;
    struct mean_bound mean;
    size_t first; /* index of its pixel_rows numbers in candidate_rows and candidate_errors */
};
/* How many fragments OpenGL may draw at a pixel, with hidden ones; it counts modulo 256. */
struct overdraw {
    uint8_t least, spread; /* least .. least + spread; a spread above 255 is stored as 255 */
    uint8_t meant;         /* the number that the reference draws */
    bool closed;           /* see is_closed */
};
struct pixel_bounds {
    struct mean_bound mean;
    float depth_error; /* of picture.depth */
    float steepness;   /* bound on the change of radiance within a pixel's width, in any band */
    float open;        /* the largest of its candidates; infinite if one of them has no bound */
    struct overdraw overdraw;
};
/* A pixel with more than one candidate, or a loose one. */
struct ambiguous_pixel {
    int32_t pixel;        /* within the chunk, row by row */
    int32_t first, count; /* candidates */
    bool background;      /* OpenGL may also show the background */
    /* OpenGL may lose the triangle that the reference shows: its depth may round to that of the
     * near or the far plane */
    bool may_vanish;
};
/* Some rows of a tile, which one thread draws: the reference's picture, and for a check the rest:
 */
struct chunk {
    struct picture picture;
    /* picture.rows as they are checked: with the driver's levels of detail. Owned where the picture
     * is stored and these differ; NULL without a check */
    double *rows;
    float *errors; /* of rows: bounds on OpenGL's error; NULL without a check */
    float *own;    /* of the same: bounds on what each band rounds by itself, a part of errors */
    struct pixel_bounds *pixels; /* of each pixel; but for overdraw, unless it is ambiguous */
    bool *is_ambiguous;
    uint32_t *dark; /* of each pixel: lights that do not reach it: see picture_shadow; NULL: none */
    struct ambiguous_pixel *ambiguous;
    struct candidate *candidates;
    double *candidate_rows;
    float *candidate_errors, *candidate_own;
    size_t n_ambiguous, n_candidates, n_numbers;
};

size_t chunk_pixels(const struct chunk *chunk);

/* ---- chunk.c: the loop over tiles ---- */

/* A tile of a region of the picture. */
struct tile {
    const struct lit_scene *lit;
    struct rectangle at;
    struct chunk *chunks; /* from the top */
    int n_chunks;
    struct counter failures; /* chunks that lacked memory; such a tile is not worked with */
};
/* Draws each tile of a region of the plan's picture, row by row, in chunks that the plan's threads
 * share; calls `work` with it, and frees it. Stops at the first failure. */
typedef bool tile_work(void *context, const struct tile *tile, struct error *err);
bool tiles_each(const struct lit_scene *lit, const struct rectangle *region, tile_work *work,
                void *context, struct error *err);

#endif
