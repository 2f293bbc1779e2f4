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
/* A node of a tree of boxes: its children are `first` and `first` + 1; or, n > 0, it has n
 * occluders from `first` on; once the tree is made, one. */
struct box_node {
    double side[6]; /* greatest x, y, z, then least */
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

/* A point of a triangle, as the eye sees it. */
struct seen_point {
    struct homogeneous eye;
    struct occluder of;
    uint32_t asked, dark; /* lights that are asked for; of these, those that do not reach it */
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
/* Finds the lights that do not reach some points, of those that are asked for: at most TOGETHER
 * points, faster where they lie near each other. A triangle in whose plane a point lies does not
 * lie between; but the point's own triangle does, if it turns one side to the light and the other
 * to the eye. */
enum { TOGETHER = 8 };
void lights_block(const struct occluders *of, const struct view *view, struct seen_point points[],
                  int n);
/* Sets the weights of lights that throw shadows to 0 in all pixels of a picture that they do not
 * reach. dark[pixel] gets their bits. */
void picture_shadow(const struct view *view, const struct occluders *of, struct picture *picture,
                    uint32_t *dark);

#endif
