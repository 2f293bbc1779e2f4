/* SPDX-License-Identifier: MIT */
/* Only the files of the room "candidates" include this. */
#ifndef RASTER_CANDIDATES_INSIDE_H
#define RASTER_CANDIDATES_INSIDE_H

#include "raster/candidates/candidates.h"
#include "raster/volumes/volumes.h"

/* The bound of a value interpolated with perspective: constant + (fixed + per_d D) / (D - e). D is
 * 1 / w at the pixel; e = fixed + per_d D is D's own bound, and less than D. This error is common
 * to all bands. A band's own roundings add up to own_constant + own_fixed / (D - e) at most. */
struct colour_bound {
    double constant, fixed, per_d, own_constant, own_fixed;
    double slope; /* over D a bound on the value's own change from pixel to pixel */
};
/* How far each corner may be off in x and in y where OpenGL follows edges, and the largest of these
 * numbers. 0: without any error. */
struct edge_errors {
    double px[3][2], most[2];
};
/* A triangle as OpenGL sets it up for interpolation, after clipping. */
struct clipped_triangle {
    struct screen_triangle screen; /* its corners and their shares; the rest is of the whole */
    double slack_px[3];    /* of each corner in x and y, off the plane of interpolated values */
    double moved_px[3][2]; /* how far each may be in x and y from its place, in this plane, too */
    struct edge_errors edges; /* these, and grid_px */
    int cuts;                 /* how many made a corner, at most */
    double grid_px;           /* by how much OpenGL's edges are off its corners */
    double value_roundings;   /* of struct driver */
    double least_part; /* OpenGL may have set up a triangle in its place with so much of its area */
    struct slack slack;      /* of any corner */
    double reach_x, reach_y; /* largest coordinates of a pixel, from OpenGL's origin */
    double magnification;    /* of all bounds, by thinness; HUGE_VAL: too thin for any bound */
    struct colour_bound inverse_w_bound; /* of D; magnified */
    bool folds; /* OpenGL may set it up turned around, so that it lies upon its neighbours */
};
void bound_inverse_w(struct clipped_triangle *triangle); /* sets the last three members */
/* Bounds a value interpolated linearly in the window (depth), with corners off by e_values. */
double bound_linear(const struct clipped_triangle *triangle, const double values[3],
                    double e_values);
struct colour_bound bound_colour(const struct clipped_triangle *triangle, const double values[3]);
/* Bounds the error of the change of a value from one pixel's centre to another's; HUGE_VAL: there
 * is no bound. */
double bound_step(const struct clipped_triangle *triangle, const double values[3], double e_values,
                  const double from[2], const double to[2]);

/* ---- triangle.c: a triangle as it lies in a tile ---- */

/* A part of a triangle in front of the eye, with the bounds that hold for all of it. */
struct bounded_triangle {
    struct screen_triangle screen; /* cut by planes that single precision may reach */
    bool other_side;               /* the same place once more, for its other side */
    bool edge_on;                  /* OpenGL may see it turned the other way */
    bool cut;                      /* by the near or the far plane */
    bool straddles;                /* OpenGL cuts it at the tile's border */
    bool slides;                   /* there OpenGL may cut one of its edges anywhere */
    bool slivers; /* there it may draw triangles, along edges, that are too thin for a bound */
    int32_t first_clipped, n_clipped; /* what OpenGL sets up for it, in the list of a chunk */
    int32_t n_slivers;  /* behind these: what it sets up besides if it cuts a corner in doubt */
    struct slack slack; /* of any corner, as OpenGL interpolates */
    struct edge_errors edges;
    double depth_error; /* of the depth at a pixel, off thin triangles; HUGE_VAL: none */
};
/* A part with the n_clipped triangles that OpenGL sets up for it: itself, or what clipping at the
 * tile's border and in depth makes of its whole triangle, fanned from the first corner. */
struct triangle_part {
    struct bounded_triangle bounded;
    struct clipped_triangle clipped[2 * (CLIP_CORNERS - 2)];
};
/* Two planes cut at most two corners off; a triangle seen edge-on shows either side. */
enum { TRIANGLE_PARTS = 2 * SCREEN_TRIANGLES };
/* Finds the parts of one triangle of a surface that reach `rows`, which are a part of the tile.
 * Returns how many. */
int triangle_parts(const struct tile *tile, int surface, int triangle, const struct rectangle *rows,
                   struct triangle_part out[TRIANGLE_PARTS]);

/* ---- fragments.c: the fragments that OpenGL may have ---- */

/* A fragment that may be seen at a pixel: a link in the pixel's list. */
struct fragment {
    int32_t triangle, next;
    unsigned clipped; /* bit i: OpenGL may show clipped triangle i of its triangle there */
    bool loose;       /* its colour has no bound */
    bool sliver;      /* or may have none: see keep_doubtful */
    bool vanishes;    /* perhaps, by depth alone: see struct ambiguous_pixel */
    bool is_definite;
    bool covers;        /* see struct candidate */
    bool has_no_shadow; /* too many lights are in doubt */
    double depth, depth_error;
    uint32_t in_doubt; /* bit i: OpenGL may count a shadow of light i otherwise */
};
/* Edges that run by within their slack. */
struct seam {
    /* Each such edge, a random number for one direction and its negative for the other, adds to one
     * of these, by how its triangle turns. Both are 0 where all have a triangle on either side. */
    uint64_t edge_sum[2];
    uint32_t n_covered; /* fragments of the reference that are not definite */
    bool open;          /* some possible fragment is not counted in the sums */
};
struct fragment_list {               /* of a pixel */
    int32_t head;                    /* first possible fragment; -1: none */
    uint32_t n_definite, n_possible; /* fragments, hidden ones too */
    double limit; /* upper bound on the depth of the nearest definite fragment; HUGE_VAL: none */
    struct seam seam;
};
struct fragments {
    const struct tile *tile; /* as OpenGL draws it */
    struct rectangle rows;   /* this chunk's part */
    struct fragment_list *pixels;
    struct bounded_triangle *triangles;
    struct fragment *fragments;
    struct clipped_triangle *clipped;
    size_t n_triangles, n_fragments, n_clipped;
    int32_t unused; /* list of fragments to use again */
};
/* Finds the fragments of all pixels of out->rows; tile and rows are set. False: no memory. */
bool fragments_find(struct fragments *out);
void fragments_free(struct fragments *fragments);
unsigned count_bits(unsigned bits); /* those that are 1 */
/* Returns whether two triangles have a corner of the same numbers. */
bool share_corner(const struct surface *a, int32_t of_a, const struct surface *b, int32_t of_b);
/* True if an edge near the centre always has a triangle on either side. */
bool is_closed(const struct seam *seam);
/* Makes room for `more` elements behind n, in an array that had room for n by this function. False:
 * no memory, or more than int32_t counts. */
bool array_grow(void *array, size_t n, size_t more, size_t size);

/* ---- pixel.c: a triangle at a pixel ---- */

/* The steps of a place in a texture from pixel to pixel, in texels, with bounds. */
struct bounded_steps {
    const struct bounded_triangle *triangle;
    unsigned clipped; /* of its fragment */
    struct detail_pixels at;
    double steps[2][2], errors[2][2]; /* as detail_steps has them */
};
struct bounded_pixel {
    const struct fragments *fragments;
    const struct lit_scene *lit;
    bool flat; /* one vertex of a triangle counts */
    const struct bounded_triangle *triangle;
    const struct surface *surface;
    const struct shaded_material *shaded;
    const float *corner[3], *provoking; /* errors of the triangle's vertices */
    const float *jumps[3]; /* of its gated vertices: see struct surface_bounds; of others NULL */
    int n_gated;
    uint32_t dark;                 /* bit i: light i of those with shadows does not reach it */
    double share[3];               /* barycentric coordinates */
    double brightest;              /* shaded_brightest */
    double rounding;               /* of a colour, relative to it */
    double *attributes;            /* these five arrays have room for any surface */
    float *common, *interpolation; /* errors that bands have in common; their second part */
    float *own, *slopes;           /* of a band by itself; change within a pixel's width */
    struct bounded_steps steps;    /* those that were asked for last; only of mipmaps */
    struct texel_point place; /* in its texture, and the value there unless the texture is varied */
    double value;
    struct colour_bound *bounds; /* [clipped triangle][max_attributes], computed when needed */
    bool *bounded;               /* [clipped triangle] */
    size_t max_attributes;       /* of any surface */
};
/* False: no memory. The fragments must outlive *out; pixel_close accepts what a failure left. */
bool pixel_open(const struct fragments *fragments, struct bounded_pixel *out);
void pixel_close(struct bounded_pixel *pixel);
/* Computes attributes of a fragment and their bounds; without a texture, weights only if
 * weights_matter. */
void pixel_bound(struct bounded_pixel *pixel, const struct fragment *fragment, int x, int y,
                 bool weights_matter);
/* Finds the places in the texture that OpenGL may sample: 1 without a texture. Take one of them. */
int pixel_choices(const struct bounded_pixel *pixel, struct texel_point out[TEXEL_CHOICES]);
void pixel_take_place(struct bounded_pixel *pixel, const struct texel_point *place);
/* Turns to one of the 1 << n_gated outcomes of unclear gates at the triangle's vertices, the
 * reference's first, after pixel_bound. */
void pixel_turn_gates(struct bounded_pixel *pixel, unsigned gates);
/* Writes the pixel_rows numbers that the pixel keeps, by the lights that reach it, `stride` apart.
 */
void pixel_put(const struct bounded_pixel *pixel, double *rows, size_t stride);
/* Writes bounds on their errors, and on the part that each band rounds by itself, `stride` apart.
 */
struct mean_bound pixel_errors(const struct bounded_pixel *pixel, const double *rows, size_t stride,
                               float *errors, float *own);
/* Bounds the change of radiance within a pixel's width, at any wavelength. */
double pixel_steepness(const struct bounded_pixel *pixel);

#endif
