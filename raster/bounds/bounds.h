/* SPDX-License-Identifier: MIT */
/* Bounds OpenGL's errors in single precision: at a vertex, and in a texture. Values of the
 * reference come in, bounds on absolute errors come out. They hold for every order of operations,
 * with or without fused multiply-add. "slack" bounds a position. */
#ifndef RASTER_BOUNDS_BOUNDS_H
#define RASTER_BOUNDS_BOUNDS_H

#include "raster/plan/plan.h"
#include "raster/visibility/visibility.h"

/* A value of the reference; OpenGL's value is off from it by at most the error. */
struct bounded {
    double value, error;
};

/* ---- vertex.c, light_bound.c: vertices ---- */

/* Bounds on the errors of a corner in the window, before a driver moves it to its grid. */
struct slack {
    double px, depth, w; /* of x and of y; of z; relative, of w */
};
enum { CLIP_X, CLIP_Y, CLIP_Z, CLIP_W };
/* From clip coordinates, with w above 0, and bounds on their errors. */
struct slack clip_slack(const struct plan *plan, const double clip[4], const double e_clip[4]);
struct vertex_bounds {
    struct slack slack;
    float e_clip[4]; /* of clip coordinates, CLIP_X to CLIP_W */
    bool exact;      /* x and y have no error, and lie on a grid of 1/256 pixel */
    bool gated[2]; /* of each side: single precision does not know whether some light reaches it */
};
struct surface_bounds {
    const struct shaded_material *shaded;
    const struct placed_instance *placed;
    struct cofactors cofactors; /* of model_view */
    double e_rigid;             /* distance_from_rigid of model_view */
    struct vertex_bounds *vertices;
    float *errors;        /* of surface.weights, in the same order */
    float *jumps;         /* at gated sides: the other outcome minus surface.weights */
    float *group_weights; /* [light group][weight]: what each adds to them; NULL: there is one */
    double left, top, right, bottom; /* in the window; everything where a vertex is not in front */
    bool *hidden; /* of each triangle: OpenGL need not draw it; NULL: all are drawn; owned */
    int n_hidden;
};
/* The weights that one group of lights adds to surface.weights; NULL: there is one group. */
float *group_weights(const struct surface *surface, const struct surface_bounds *bounds, int group);
struct volumes;
/* A scene with all of its vertices in the window and lit, by the reference and with bounds; or its
 * shadow volumes, in the window without light. */
struct lit_scene {
    const struct plan *plan;
    const struct driver *driver;
    const struct placed_instance *instances; /* those of the plan, or the volumes */
    int n;                                   /* of them */
    bool are_volumes; /* the near and the far plane cut nothing of them, and none is hidden */
    struct surface *surfaces; /* one an instance, in drawing order */
    struct surface_bounds *bounds;
    struct occluders occluders;    /* none, where no light throws shadows into view */
    const struct volumes *volumes; /* that OpenGL draws for them: see raster/volumes; NULL: none */
    struct light_work work;        /* of all vertices */
    double full_scale;             /* the radiance of the largest count; 1 until find_full_scale */
    bool clips;                    /* a vertex is brighter than that */
};
/* Refuses NaN and infinity, by object. The plan must outlive *out; lit_free accepts what a failure
 * left. Without a check no errors of weights are bounded. */
bool lit_make(const struct plan *plan, const struct driver *driver, struct lit_scene *out,
              struct error *err);
/* Places shadow volumes in the window. Refuses infinity. Both must outlive *out; lit_free accepts
 * what a failure left. */
bool lit_place_volumes(const struct lit_scene *scene, const struct placed_instance *volumes, int n,
                       struct lit_scene *out, struct error *err);
void lit_free(struct lit_scene *lit);
void light_work_add(struct light_work *to, const struct light_work *from);
const struct surface_bounds *bounds_of(const struct lit_scene *lit,
                                       const struct screen_triangle *screen);
/* False where nothing of a surface can be in the rectangle. */
bool surface_reaches(const struct surface_bounds *surface, const struct rectangle *at);

/* ---- facing.c: on which side a triangle is seen ---- */

/* The error with which OpenGL follows an edge, in pixels, in a tile of this size. It may move the
 * ends to its grid. */
double edge_error(const struct driver *driver, int width, int height);
/* True if the triangle may turn the other way, where its corners may each be off by e pixels. */
bool may_turn(const struct screen_triangle *triangle, const double e[3]);

/* ---- texel_bound.c: a texture at a point ---- */

struct texel_point { /* in texels, with bounds */
    double place[TEXEL_PLACE];
    float e_place[TEXEL_PLACE];
    float e_weights; /* texel_weights_error */
    double other; /* OpenGL may take this level of detail instead; or it is place[PLACE_DETAIL] */
};
/* Bounds the errors of the weights of four texels, in all. They are products of two weights, and
 * round to the same steps as these. Errors that add up to 0 move a mix by half of this times the
 * range of the texels. */
float texel_weights_error(const struct texels *texels, const struct driver *driver);
struct texel_point texel_point(const struct texels *texels, const struct driver *driver,
                               const double s_t[2],
                               const float e_s_t[2]); /* from texture coordinates */
/* Finds the level of detail of a texture with mipmaps, whose steps from pixel to pixel are off by
 * at most e_steps; infinite: it may be any. */
void texel_detail(const struct texels *texels, const struct driver *driver, double steps[2][2],
                  double e_steps[2][2], struct texel_point *at);
/* The places that OpenGL may take for this one: the nearest texels, if several lie within the
 * bounds, each at its centre without error; two levels of detail, next to each other in a table; or
 * the place itself. Returns how many. */
enum { TEXEL_CHOICES = 4 };
int texel_choices(const struct texels *texels, const struct texel_point *at,
                  struct texel_point out[TEXEL_CHOICES]);
/* The texture there, with a bound on the error of its value. Where it is straight within the bounds
 * of the place, it changes by so much per texel across and up, and per level of detail; from that
 * it is off by at most `rest`. Where it is not, the last two are not set. */
struct texel_value {
    double value, error;
    bool is_straight;
    double slope[TEXEL_PLACE], rest;
};
/* `largest` is the largest value of the texture. */
void texel_value(const struct texels *texels, const struct texel_point *at, double largest,
                 struct texel_value *out);

#endif
