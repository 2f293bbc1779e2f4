/* SPDX-License-Identifier: MIT */
/* The room "visibility": which points of a picture a light reaches. The segment from a point to the
 * light is asked for triangles that it meets, by signs of determinants that are exact. A user has
 * to believe this room beside the reference. It needs "reference" and "maths", and nothing else of
 * the program. Points are in eye space. */
#ifndef RASTER_VISIBILITY_VISIBILITY_H
#define RASTER_VISIBILITY_VISIBILITY_H

#include "raster/reference/reference.h"

/* A point, or where its w is 0 a direction. */
struct homogeneous {
    struct vector at;
    bool infinite; /* w is 0 */
};

/* ---- boxes.c: triangles that cast shadows ---- */

struct occluder {
    int32_t surface, triangle;
};
struct box {
    double low[3], high[3];
};
/* A node of a tree of boxes: its children are `first` and `first` + 1; or, n > 0, it has so many
 * occluders from `first` on. */
struct box_node {
    struct box box;
    int32_t first, n;
};
struct occluders {
    const struct surface *surfaces;
    struct vector **vertices; /* of each surface that casts, in eye space; otherwise NULL; owned */
    struct occluder *list;    /* owned */
    struct box_node *nodes;   /* the first is the root; owned */
    int n_surfaces, n, n_nodes;
    double size;
};
/* Lists the triangles of the surfaces that throw shadows: casts[i]. Places of all surfaces are sums
 * of numbers up to `size`. The surfaces must outlive *out. False: no memory; occluders_free accepts
 * what that left. */
bool occluders_make(const struct surface *surfaces, int n, const bool *casts, double size,
                    struct occluders *out);
void occluders_free(struct occluders *occluders);

/* ---- visibility.c: points and lights ---- */

/* Finds the parts of a triangle between the near and the far plane, as the reference draws them. */
int shown_parts(const struct view *view, const struct surface *surface, int triangle,
                struct screen_triangle out[SCREEN_TRIANGLES]);
/* A point of a triangle, as the eye sees it. */
struct seen_point {
    struct homogeneous eye;
    struct occluder of;
};
/* Finds the point with these barycentric coordinates of the triangle. */
struct seen_point seen_point(const struct surface *surfaces, const struct screen_triangle *of,
                             const double share[3]);
/* Returns the side of an occluder's plane on which a point or a direction lies: -1 or 1; 0 in the
 * plane, as far as its corners and the point are known. */
int occluder_side(const struct occluders *of, struct occluder at, const struct homogeneous *point);
/* Returns light i, from 0, of those that throw shadows. Bit 1 << i of a set stands for it. */
const struct eye_light *shadow_light(const struct view *view, int i);
/* Returns the bit of the light of a term; 0: it throws no shadows. */
uint32_t light_bit(const struct view *view, const struct term *term);
/* Returns the lights that throw shadows and have a weight that is not 0 among those of a pixel,
 * `stride` apart. The second function sets the weights of dark lights to 0. */
uint32_t lights_weighed(const struct view *view, const struct instance *instance,
                        const double *weights, size_t stride);
void lights_darken(const struct view *view, const struct instance *instance, uint32_t dark,
                   double *weights, size_t stride);
/* Returns the lights that do not reach a point, of those that are asked for. A triangle in whose
 * plane the point lies does not lie between; but the point's own triangle does, if it turns one
 * side to the light and the other to the eye. */
uint32_t lights_blocked(const struct occluders *of, const struct view *view, uint32_t asked,
                        const struct seen_point *point);
/* Sets the weights of lights that throw shadows to 0 in all pixels of a picture that they do not
 * reach. dark[pixel] gets their bits. */
void picture_shadow(const struct view *view, const struct occluders *of, struct picture *picture,
                    uint32_t *dark);

#endif
