/* SPDX-License-Identifier: MIT */
/* What the files of the reference rasterizer share, in the order in which a triangle goes by:
 * clip.c cuts it, bound.c says how far OpenGL may be off in it, facet.c places it in a tile, edge.c
 * tells its inside, coverage.c finds the pixels that it covers, gouraud.c what they look like.
 * Nobody else includes this but a test. */
#ifndef COVERAGE_H
#define COVERAGE_H

#include "raster/raster.h"

/* ---- raster/clip.c: homogeneous clipping ---- */

enum { CLIP_PLANES = 6, CLIP_CORNERS = 3 + CLIP_PLANES };

/* A corner of a triangle, or of what clipping left of it. */
struct corner {
    double clip[4];
    double share[3];     /* barycentric coordinates in the whole triangle */
    double cut_error[3]; /* bounds on GL's errors in clip coordinates from cutting */
    int whole;           /* 0..2: which corner of the whole triangle this is; -1: made by a cut */
};
/* Inside is where normal . clip + offset >= 0. */
struct clip_plane {
    double normal[4], offset;
};
/* Cuts a triangle by planes in the given order; returns the number of corners left, in the
 * triangle's own sense of rotation (0: nothing is left). A cut edge gives the same corner whichever
 * of its two triangles is cut (Sutherland and Hodgman 1974). */
int clip_triangle(const struct corner whole[3], const struct clip_plane *planes, int n_planes,
                  struct corner out[CLIP_CORNERS]);

/* ---- raster/bound.c: how far OpenGL may be off inside a facet ---- */

/* A triangle that OpenGL sets up for interpolation: window corners relative to the tile. */
struct outline {
    double x[3], y[3], inverse_w[3];
    double slack_px[3];      /* bounds on GL's error in x and y of each corner */
    double edge_px[3];       /* the same as GL follows edges */
    double grid_px;          /* by how much that differs from where GL interpolates between */
    double slack_w;          /* relative bound on GL's error in w */
    double reach_x, reach_y; /* largest window coordinates in the tile */
};
/* Above 1: the factor by which thinness magnifies all bounds; HUGE_VAL where it leaves none. */
double bound_magnification(const struct outline *outline);
/* Bound for a value interpolated linearly in the window (depth), whose corners are off by e_values.
 */
double bound_linear(const struct outline *outline, const double values[3], double e_values);
/* Bound on OpenGL's error in D = 1 / w at a pixel: fixed + per_d D. */
struct inverse_w_bound {
    double fixed, per_d;
};
struct inverse_w_bound bound_inverse_w(const struct outline *outline);
/* Bound on OpenGL's error in a value interpolated with perspective (colours): constant + (fixed +
 * per_d D) / (D - e), where e is the bound of D, and less than it. */
struct colour_bound {
    double constant, fixed, per_d;
    double slope; /* over D a bound on the value's own change from pixel to pixel */
};
struct colour_bound bound_colour(const struct outline *outline, const double values[3]);

/* ---- raster/facet.c: a triangle as it lies in a tile ---- */

/* A triangle in front of the eye and between the near and far plane, or a piece of one. The corners
 * turn so that twice_area >= 0. */
struct facet {
    int32_t surface, triangle;
    int32_t vertex[3];             /* of the whole triangle */
    int32_t provoking;             /* the vertex that colours all of it in flat shading */
    int side;                      /* 1: seen from behind, and that matters */
    bool other_side;               /* the same place once more, for its other side */
    bool clockwise;                /* before its corners were turned; with y downwards */
    bool edge_on;                  /* OpenGL may see it turned the other way */
    bool cut;                      /* by the near or the far plane */
    bool straddles;                /* OpenGL cuts it at the tile's border */
    int32_t first_piece, n_pieces; /* that OpenGL makes of it, as its chunk keeps them */
    double x[3], y[3], z[3], inverse_w[3];
    double share[3][3]; /* of each corner: barycentric coordinates in the whole triangle */
    double twice_area;
    double slack_px;    /* bound on GL's position of a corner, as it interpolates */
    double edge_px[3];  /* of each corner the same as GL follows edges; 0: without any error */
    double slack_w;     /* relative bound on GL's w */
    double slack_depth; /* bound on GL's depth of a corner */
    double depth_error; /* bound on GL's depth at a pixel off thin pieces; HUGE_VAL: none */
};
/* Two planes cut at most two corners off; a facet seen edge-on shows either side. */
enum { FACETS_PER_TRIANGLE = 6 };
/* Facets of one triangle of surfaces[surface]; returns how many (0: nothing of it is in `rows`, the
 * part of the tile that the caller looks at). */
int facets_of(const struct plan *plan, const struct surface *surfaces, int surface, int triangle,
              const struct tile *tile, const struct tile *rows,
              struct facet out[FACETS_PER_TRIANGLE]);
/* The triangles that OpenGL sets up for a facet: itself, or what clipping at the tile's border and
 * in depth makes of its whole triangle, fanned from the first corner. Returns how many. */
struct piece {
    struct outline outline;
    double slack_depth, z[3], share[3][3];
    double magnification; /* of its bounds; HUGE_VAL: too thin for any */
    struct inverse_w_bound inverse_w_bound;
};
int facet_pieces(const struct plan *plan, const struct surface *surfaces, const struct tile *tile,
                 const struct facet *facet, struct piece out[CLIP_CORNERS - 2]);

/* ---- raster/edge.c: on which side of its edges a pixel centre lies ---- */

/* Edge functions at a point; corner i is opposite to edge i. */
struct edge_values {
    double dx[3], dy[3]; /* from the point to the corners */
    double e[3];
    double slack[3];
};
/* Of a triangle; errors bound OpenGL's corners in x and y. */
void edges_at(const double x[3], const double y[3], double px, double py, const double errors[3],
              struct edge_values *out);
/* Whether the reference has a fragment there, decided without rounding. */
bool edges_cover(const struct facet *facet, const struct edge_values *edges);
/* How sure it is that OpenGL has one; edges are those of the facet's edge_px. */
enum presence { IMPOSSIBLE, POSSIBLE, DEFINITE };
enum presence edges_presence(const struct facet *facet, const struct edge_values *edges);
/* The same of a piece at a point. */
enum presence outline_presence(const struct outline *outline, double px, double py);
double least_of(const double v[3]);
double most_of(const double v[3]);

/* ---- raster/coverage.c: fragments ---- */

/* A fragment kept for a pixel: a link in the pixel's list. */
struct fragment {
    int32_t facet, next;
    bool loose; /* its colour has no bound */
    double depth, depth_error;
};
struct pixel {
    int32_t winner;                 /* facet of the reference's own fragment; -1: none */
    int32_t head;                   /* first fragment of the list of candidates; -1: empty */
    int32_t n_candidates, n_pruned; /* in the list; when it was last rid of hidden ones */
    double winner_depth;
    double limit; /* upper bound on the depth of the nearest definite fragment; HUGE_VAL: none */
    /* fragments, hidden ones too: those that there must be, may be, and the reference has of these
     */
    uint32_t n_definite, n_possible, n_covered;
    /* Each edge that runs by within its slack, one of a random number for one direction and its
     * negative for the other, adds to one of these; by how its facet turns. Both are 0 where all
     * these edges have a facet on either side. */
    uint64_t edge_sum[2];
    bool open; /* there are possible fragments of which that says nothing */
};
struct coverage {
    const struct plan *plan;
    const struct surface *surfaces;
    const struct tile *tile; /* as OpenGL draws it */
    struct tile rows;        /* this chunk's part */
    struct pixel *pixels;
    struct facet *facets;
    struct fragment *fragments;
    struct piece *pieces;
    size_t n_facets, n_fragments, n_pieces, facet_capacity, fragment_capacity, piece_capacity;
    int32_t unused; /* list of fragments to use again */
};
/* Finds the fragments of all pixels of coverage->rows; plan, surfaces, tile and rows are set.
 * False: no memory. */
bool coverage_fill(struct coverage *coverage);
void coverage_free(struct coverage *coverage);

/* Which pieces of a facet OpenGL may have at a point: bit i stands for piece i. Beyond the near and
 * the far plane there may be any: pieces end there, but single precision does not know where. */
unsigned pieces_at(const struct coverage *coverage, const struct facet *facet, double px,
                   double py);

/* Makes room for `needed` elements of an array. False: no memory, or more than int32_t counts. */
bool array_grow(void *array, size_t *capacity, size_t needed, size_t size);

#endif
