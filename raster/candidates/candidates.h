/* SPDX-License-Identifier: MIT */
/* The candidates of each pixel: the triangle that the reference shows, every other triangle that
 * OpenGL may show there, with weights and bounds, and how many fragments OpenGL may draw. After the
 * reference has drawn, the triangles are walked a second time for that. */
#ifndef CANDIDATES_H
#define CANDIDATES_H

#include "raster/setup/setup.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- presence.c: how sure it is that OpenGL has a fragment at a point ---- */

enum presence { IMPOSSIBLE, POSSIBLE, DEFINITE };
/* Bounds OpenGL's errors in the edge functions at a point, where corners are off by `errors`. */
void edge_slack(const struct edge_functions *edges, const double errors[3], double slack[3]);
/* The largest of these at any pixel that scan_triangle visits. */
double most_slack(const struct bounded_triangle *triangle);
enum presence triangle_presence(const struct bounded_triangle *triangle,
                                const struct edge_functions *edges, double most);
enum presence clipped_presence(const struct clipped_triangle *triangle, double px, double py);

/* ---- fragments.c: the fragments that OpenGL may have ---- */

/* A fragment that may be seen at a pixel: a link in the pixel's list. */
struct fragment {
    int32_t triangle, next;
    bool loose; /* its colour has no bound */
    double depth, depth_error;
};
struct fragment_list {               /* of a pixel; 32 bytes, since every fragment touches it */
    int32_t head;                    /* first possible fragment; -1: none */
    int32_t n_candidates, n_pruned;  /* in the list; when it was last rid of hidden ones */
    uint32_t n_definite, n_possible; /* fragments, hidden ones too */
    double limit; /* upper bound on the depth of the nearest definite fragment; HUGE_VAL: none */
};
/* Edges that run by within their slack. */
struct seam {
    /* Each such edge, a random number for one direction and its negative for the other, adds to one
     * of these, by how its triangle turns. Both are 0 where all have a triangle on either side. */
    uint64_t edge_sum[2];
    uint32_t n_covered; /* fragments of the reference that are not definite */
    bool open;          /* some possible fragment is not counted in the sums */
};
struct fragments {
    const struct lit_scene *lit;
    const struct rectangle *tile; /* as OpenGL draws it */
    struct rectangle rows;        /* this chunk's part */
    struct fragment_list *pixels;
    struct seam *seams; /* of each pixel */
    struct bounded_triangle *triangles;
    struct fragment *fragments;
    struct clipped_triangle *clipped;
    size_t n_triangles, n_fragments, n_clipped, triangle_capacity, fragment_capacity,
        clipped_capacity;
    int32_t unused; /* list of fragments to use again */
};
/* Finds the fragments of all pixels of out->rows; lit, tile and rows are set. False: no memory. */
bool fragments_find(struct fragments *out);
void fragments_free(struct fragments *fragments);
/* Finds the clipped triangles that OpenGL may have at a point: bit i stands for number i. Beyond
 * the near and the far plane all are possible. */
unsigned clipped_at(const struct fragments *fragments, const struct bounded_triangle *triangle,
                    double px, double py);
/* True if an edge near the centre always has a triangle on either side. */
bool is_closed(const struct seam *seam);
/* Makes room for `needed` elements. False: no memory, or more than int32_t counts. */
bool array_grow(void *array, size_t *capacity, size_t needed, size_t size);

/* ---- pixel.c: a triangle at a pixel ---- */

struct bounded_pixel; /* attributes with bounds on OpenGL's errors */
/* NULL: no memory. The fragments must outlive it. */
struct bounded_pixel *pixel_open(const struct fragments *fragments);
void pixel_close(struct bounded_pixel *pixel);
/* Computes attributes and their bounds; without a texture, weights only if weights_matter. */
void pixel_bound(struct bounded_pixel *pixel, const struct bounded_triangle *triangle, int x, int y,
                 bool weights_matter);
/* Finds the places in the texture that OpenGL may sample: 1 without a texture. Take one of them. */
int pixel_choices(const struct bounded_pixel *pixel, struct texel_point out[TEXEL_CHOICES]);
void pixel_take_place(struct bounded_pixel *pixel, const struct texel_point *place);
void pixel_weights(const struct bounded_pixel *pixel, double *rows); /* see put_rows */
/* Writes bounds on their errors, and on the part that each band rounds by itself, `stride` apart.
 */
void pixel_errors(const struct bounded_pixel *pixel, const double *rows, size_t stride,
                  float *errors, float *own);
/* Bounds the change of radiance within a pixel's width, at any wavelength. */
double pixel_steepness(const struct bounded_pixel *pixel);

/* ---- chunk.c: a part of a tile, with its candidates ---- */

/* A triangle that OpenGL may show at a pixel, with one place of its texture. */
struct candidate {
    int32_t surface, triangle;
    float depth, depth_error;
    bool loose;   /* its error has no bound here */
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
    float *depth_error; /* of picture.depth */
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
/* Calls `work` for each tile of a region of the plan's picture, row by row. Its chunks are drawn
 * before the call, by the plan's threads, and freed after it. Stops at the first failure. */
bool tiles_each(const struct lit_scene *lit, const struct rectangle *region,
                bool (*work)(void *context, const struct tile *tile, struct error *err),
                void *context, struct error *err);

#endif
