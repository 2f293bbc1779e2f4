/* SPDX-License-Identifier: MIT */
/* How far OpenGL's single precision may be off from the reference: at a vertex, inside a triangle,
 * in a texture. The reference's values come in; bounds on absolute errors come out. They hold for
 * every order of operations, with or without fused multiply-add; "slack" bounds a position. */
#ifndef BOUNDS_H
#define BOUNDS_H

#include "data/maths/maths.h"
#include "raster/driver/driver.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- exact.c: where single precision makes no error ---- */

/* True if a sum of terms is exact in single precision in whatever order it is made: all are
 * multiples of a power of two, and the sum of their magnitudes is at most 2^24 times that. */
bool exact_sum(const double *terms, int n);
/* True if single precision holds both matrices, and their product without any rounding. */
bool exact_product(const struct matrix *a, const struct matrix *b);
/* True if a row of a matrix times a vector is exact in single precision. */
bool exact_row(const double row[4], const double v[4]);

/* ---- vertex.c, light.c: vertices ---- */

enum { CLIP_XY, CLIP_Z, CLIP_W };
struct vertex_bounds {
    float slack_px;    /* of x and of y in the window, before a driver moves them to its grid */
    float slack_depth; /* of z in the window */
    float slack_w;     /* relative, of w */
    float e_clip[3];   /* of clip coordinates: CLIP_XY, CLIP_Z, CLIP_W */
    bool exact;        /* x and y have no error, and lie on a grid of 1/256 pixel */
};
struct surface_bounds {
    const struct shaded_material *shaded;
    const struct placed_instance *placed;
    struct vertex_bounds *vertices;
    float *errors;                   /* of surface.weights, in the same order */
    double left, top, right, bottom; /* in the window; everything where a vertex is not in front */
};
/* A scene with all of its vertices in the window and lit, by the reference and with bounds. */
struct lit_scene {
    const struct plan *plan;
    const struct driver *driver;
    struct surface *surfaces; /* one an instance, in drawing order */
    struct surface_bounds *bounds;
};
/* Refuses NaN and infinity, by object. The plan must outlive *out; lit_free accepts what a failure
 * left. Without a check the errors of weights are not bounded. */
bool lit_make(const struct plan *plan, const struct driver *driver, struct lit_scene *out,
              struct light_work *work, struct error *err);
void lit_free(struct lit_scene *lit);
/* False where nothing of a surface can be in the rectangle. */
bool surface_reaches(const struct surface_bounds *surface, const struct rectangle *at);

/* True if any term of the instance belongs to this light. */
bool reflects(const struct instance *instance, const struct eye_light *light);
/* Errors that all normals of one instance share. */
struct normal_bounds {
    double cofactor[3][3]; /* what their rounding errors are relative to */
    double e_rigid;        /* distance of model_view from a rigid one that OpenGL takes it for */
};
struct normal_bounds normal_bounds(const struct instance *instance);
/* Adds to the surface's errors the bounds on all attributes of a vertex, where e_eye bounds its
 * place in eye space. They are infinite where a weight has no bound. */
void light_bounds(const struct lit_scene *lit, int surface, int index,
                  const struct normal_bounds *normals, double e_eye, struct light_work *work);

/* ---- plane.c: inside a triangle that OpenGL sets up ---- */

/* Bound on the error in D = 1 / w at a pixel: fixed + per_d D. */
struct inverse_w_bound {
    double fixed, per_d;
};
/* A triangle as OpenGL sets it up for interpolation, after clipping. */
struct clipped_triangle {
    double x[3], y[3], z[3], inverse_w[3], share[3][3]; /* as of struct screen_triangle */
    double slack_px[3];                                 /* of each corner in x and y */
    double edge_px[3];                                  /* the same as OpenGL follows edges */
    double grid_px;          /* by how much that differs from where OpenGL interpolates between */
    double slack_w;          /* relative, of w */
    double slack_depth;      /* of a corner */
    double reach_x, reach_y; /* largest window coordinates in the tile */
    double magnification;    /* bound_magnification; HUGE_VAL: too thin for any bound */
    struct inverse_w_bound inverse_w_bound; /* magnified */
};
/* Above 1: the factor by which thinness magnifies all bounds; HUGE_VAL where it leaves none. */
double bound_magnification(const struct clipped_triangle *triangle);
/* Bounds a value interpolated linearly in the window (depth), with corners off by e_values. */
double bound_linear(const struct clipped_triangle *triangle, const double values[3],
                    double e_values);
struct inverse_w_bound bound_inverse_w(const struct clipped_triangle *triangle);
/* The bound of a value interpolated with perspective (weights): constant + (fixed + per_d D) /
 * (D - e), where e is the bound of D, and less than it. */
struct colour_bound {
    double constant, fixed, per_d;
    double slope; /* over D a bound on the value's own change from pixel to pixel */
};
struct colour_bound bound_colour(const struct clipped_triangle *triangle, const double values[3]);

/* ---- triangle.c: a triangle as it lies in a tile ---- */

/* A part of a triangle in front of the eye, with the bounds that hold for all of it. */
struct bounded_triangle {
    struct screen_triangle screen;    /* cut by planes that single precision may reach */
    bool other_side;                  /* the same place once more, for its other side */
    bool edge_on;                     /* OpenGL may see it turned the other way */
    bool cut;                         /* by the near or the far plane */
    bool straddles;                   /* OpenGL cuts it at the tile's border */
    int32_t first_clipped, n_clipped; /* triangles that OpenGL sets up, in the list of a chunk */
    double slack_px;                  /* of a corner, as OpenGL interpolates */
    double edge_px[3];  /* of each corner as OpenGL follows edges; 0: without any error */
    double slack_w;     /* relative, of w */
    double slack_depth; /* of a corner */
    double depth_error; /* of the depth at a pixel, off thin triangles; HUGE_VAL: none */
};
const struct surface_bounds *bounds_of(const struct lit_scene *lit,
                                       const struct screen_triangle *screen);
/* Two planes cut at most two corners off; a triangle seen edge-on shows either side. */
enum { BOUNDED_TRIANGLES = 2 * SCREEN_TRIANGLES };
/* The parts of one triangle of a surface; returns how many (0: nothing of it is in `rows`, the part
 * of the tile that the caller looks at). */
int bounded_triangles(const struct lit_scene *lit, int surface, int triangle,
                      const struct rectangle *tile, const struct rectangle *rows,
                      struct bounded_triangle out[BOUNDED_TRIANGLES]);
/* The triangles that OpenGL sets up for one: itself, or what clipping at the tile's border and in
 * depth makes of its whole triangle, fanned from the first corner. Returns how many. */
int clipped_triangles(const struct lit_scene *lit, const struct rectangle *tile,
                      const struct bounded_triangle *triangle,
                      struct clipped_triangle out[CLIP_CORNERS - 2]);

/* ---- texel.c: a texture at a point ---- */

/* In texels, with bounds. */
struct texel_point {
    double place[2];
    float e_place[2];
};
/* The point in texels for texture coordinates and their bounds. */
struct texel_point texel_point(const struct texels *texels, const double s_t[2],
                               const float e_s_t[2]);
/* The places that OpenGL may take for this one: the nearest texels, if several lie within the
 * bounds, each at its centre without error; otherwise the place itself. Returns how many. */
enum { TEXEL_CHOICES = 4 };
int texel_choices(const struct texels *texels, const struct texel_point *at,
                  struct texel_point out[TEXEL_CHOICES]);
/* A bound on the error of the value there; `largest` is the largest value of the texture. */
double texel_error(const struct texels *texels, const struct texel_point *at, double largest);

#endif
