/* SPDX-License-Identifier: MIT */
/* Bounds OpenGL's errors in single precision: at a vertex, inside a triangle, in a texture. Values
 * of the reference come in, bounds on absolute errors come out. They hold for every order of
 * operations, with or without fused multiply-add. "slack" bounds a position. */
#ifndef BOUNDS_H
#define BOUNDS_H

#include "data/maths/maths.h"
#include "raster/driver/driver.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- bounded.c: values with bounds on their errors ---- */

/* A value of the reference; OpenGL's value is off from it by at most the error. */
struct bounded {
    double value, error;
};
struct bounded bounded_product(struct bounded a, struct bounded b);
/* To first order in the error of b. The value of b is not 0. */
struct bounded bounded_quotient(struct bounded a, struct bounded b);

/* ---- exact.c: where single precision makes no error ---- */

/* True where single precision rounds nothing: in a sum of terms, in whatever order it is made; in
 * the dot product of two vectors that it holds; in the product of two matrices that it holds. */
bool exact_sum(const double *terms, int n);
bool exact_row(const double row[4], const double v[4]);
bool exact_product(const struct matrix *a, const struct matrix *b);

/* ---- vertex.c, light.c: vertices ---- */

/* Bounds on the errors of a corner in the window, before a driver moves it to its grid. */
struct slack {
    double px, depth, w; /* of x and of y; of z; relative, of w */
};
/* From bounds on clip coordinates, in a picture of twice half_width and half_height pixels. */
struct slack window_slack(const struct bounded clip[4], double half_width, double half_height);
enum { CLIP_XY, CLIP_Z, CLIP_W };
struct vertex_bounds {
    float slack_px, slack_depth, slack_w; /* struct slack */
    float e_clip[3];                      /* of clip coordinates: CLIP_XY, CLIP_Z, CLIP_W */
    bool exact; /* x and y have no error, and lie on a grid of 1/256 pixel */
};
struct surface_bounds {
    const struct shaded_material *shaded;
    const struct placed_instance *placed;
    struct cofactors cofactors; /* of model_view */
    double e_rigid;             /* distance_from_rigid of model_view */
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
/* The distance of the upper 3x3 from the rigid matrix that OpenGL takes it for; 0: for none. */
double distance_from_rigid(const struct matrix *m);
/* Adds to the surface's errors the bounds on all attributes of a vertex, where e_eye bounds its
 * place in eye space. They are infinite where a weight has no bound. */
void light_bounds(const struct lit_scene *lit, int surface, int index, double e_eye,
                  struct light_work *work);

/* ---- plane.c: inside a triangle that OpenGL sets up ---- */

/* The bound of a value interpolated with perspective (weights): constant + (fixed + per_d D) /
 * (D - e). D is 1 / w at the pixel; e = fixed + per_d D is D's own bound, and less than D. */
struct colour_bound {
    double constant, fixed, per_d;
    double slope; /* over D a bound on the value's own change from pixel to pixel */
};
/* A triangle as OpenGL sets it up for interpolation, after clipping. */
struct clipped_triangle {
    double x[3], y[3], z[3], inverse_w[3], share[3][3]; /* as of struct screen_triangle */
    double slack_px[3];                                 /* of each corner in x and y */
    double edge_px[3];                                  /* the same as OpenGL follows edges */
    double grid_px;          /* by how much that differs from where OpenGL interpolates between */
    struct slack slack;      /* of any corner */
    double reach_x, reach_y; /* largest window coordinates in the tile */
    double magnification;    /* of all bounds, by thinness; HUGE_VAL: too thin for any bound */
    struct colour_bound inverse_w_bound; /* of D; magnified */
};
/* Fills in magnification and inverse_w_bound from the other members. */
void bound_inverse_w(struct clipped_triangle *triangle);
/* Bounds a value interpolated linearly in the window (depth), with corners off by e_values. */
double bound_linear(const struct clipped_triangle *triangle, const double values[3],
                    double e_values);
struct colour_bound bound_colour(const struct clipped_triangle *triangle, const double values[3]);

/* ---- triangle.c: a triangle as it lies in a tile ---- */

/* A part of a triangle in front of the eye, with the bounds that hold for all of it. */
struct bounded_triangle {
    struct screen_triangle screen;    /* cut by planes that single precision may reach */
    bool other_side;                  /* the same place once more, for its other side */
    bool edge_on;                     /* OpenGL may see it turned the other way */
    bool cut;                         /* by the near or the far plane */
    bool straddles;                   /* OpenGL cuts it at the tile's border */
    int32_t first_clipped, n_clipped; /* what OpenGL sets up for it, in the list of a chunk */
    struct slack slack;               /* of any corner, as OpenGL interpolates */
    double edge_px[3];  /* of each corner as OpenGL follows edges; 0: without any error */
    double depth_error; /* of the depth at a pixel, off thin triangles; HUGE_VAL: none */
};
const struct surface_bounds *bounds_of(const struct lit_scene *lit,
                                       const struct screen_triangle *screen);
/* A part with the n_clipped triangles that OpenGL sets up for it: itself, or what clipping at the
 * tile's border and in depth makes of its whole triangle, fanned from the first corner. */
struct triangle_part {
    struct bounded_triangle bounded;
    struct clipped_triangle clipped[CLIP_CORNERS - 2];
};
/* Two planes cut at most two corners off; a triangle seen edge-on shows either side. */
enum { TRIANGLE_PARTS = 2 * SCREEN_TRIANGLES };
/* Finds the parts of one triangle of a surface that reach `rows`, which are a part of the tile.
 * Returns how many. */
int triangle_parts(const struct lit_scene *lit, int surface, int triangle,
                   const struct rectangle *tile, const struct rectangle *rows,
                   struct triangle_part out[TRIANGLE_PARTS]);

/* ---- texel.c: a texture at a point ---- */

struct texel_point { /* in texels, with bounds */
    double place[2];
    float e_place[2];
};
struct texel_point texel_point(const struct texels *texels, const double s_t[2],
                               const float e_s_t[2]); /* from texture coordinates */
/* The places that OpenGL may take for this one: the nearest texels, if several lie within the
 * bounds, each at its centre without error; otherwise the place itself. Returns how many. */
enum { TEXEL_CHOICES = 4 };
int texel_choices(const struct texels *texels, const struct texel_point *at,
                  struct texel_point out[TEXEL_CHOICES]);
/* A bound on the error of the value there; `largest` is the largest value of the texture. */
double texel_error(const struct texels *texels, const struct texel_point *at, double largest);

#endif
