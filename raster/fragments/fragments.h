/* SPDX-License-Identifier: MIT */
/* The fragments that OpenGL may have at each pixel: those that it may show, and how many it may
 * draw, hidden ones included. After the reference has drawn, the triangles are walked a second
 * time. */
#ifndef FRAGMENTS_H
#define FRAGMENTS_H

#include "raster/bounds/bounds.h"
#include "raster/reference/reference.h"
#include "raster/setup/setup.h"
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

#endif
