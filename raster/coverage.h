/* SPDX-License-Identifier: MIT */
/* What the two halves of the reference rasterizer share: coverage.c finds which facets cover a
 * pixel, gouraud.c what they look like there. Nobody else includes this. */
#ifndef COVERAGE_H
#define COVERAGE_H

#include "spectral.h"

/* ---- raster/coverage.c: fragments ---- */

/* A fragment kept for a pixel: a link in the pixel's list. */
struct fragment {
    int32_t facet, next;
    bool loose;     /* on a piece too thin for a bound */
    double nearest; /* lower bound on its depth in OpenGL */
};
struct pixel {
    int32_t winner; /* facet of the reference's own fragment; -1: none */
    int32_t head;   /* first fragment of the list of candidates; -1: empty */
    double winner_depth;
    double limit; /* upper bound on the depth of the nearest definite fragment; HUGE_VAL: none */
};
struct coverage {
    const struct plan *plan;
    const struct surface *surfaces;
    const struct tile *tile; /* as OpenGL draws it */
    struct tile rows;        /* this chunk's part */
    struct pixel *pixels;
    struct facet *facets;
    struct fragment *fragments;
    struct outline *thin; /* pieces of facets that are too thin for a bound */
    size_t n_facets, n_fragments, n_thin, facet_capacity, fragment_capacity, thin_capacity;
    int32_t unused; /* list of fragments to use again */
};
/* Finds the fragments of all pixels of coverage->rows; plan, surfaces, tile and rows are set.
 * False: no memory. */
bool coverage_fill(struct coverage *coverage);
void coverage_free(struct coverage *coverage);

/* Edge functions at a pixel centre; corner i is opposite to edge i. */
struct edge_values {
    double e[3];
    double slack[3];
};
/* `error` bounds OpenGL's corners in x and y. */
void edges_at(const struct facet *facet, double px, double py, double error,
              struct edge_values *out);

/* Makes room for `needed` elements of an array. False: no memory, or more than int32_t counts. */
bool array_grow(void *array, size_t *capacity, size_t needed, size_t size);

#endif
