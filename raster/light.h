/* SPDX-License-Identifier: MIT */
/* What surface.c, which places vertices, and light.c, which lights them, share. Nobody else
 * includes this. */
#ifndef LIGHT_H
#define LIGHT_H

#include "raster/raster.h"

/* ---- raster/light.c: one vertex, or one point between vertices ---- */

/* What the vertices of one body have in common. */
struct body_bounds {
    double cofactor[3][3]; /* what the rounding errors of normals are relative to */
    double e_rigid;        /* how far the modelview is from rigid where OpenGL takes it for that */
};
struct body_bounds body_bounds(const struct body *body);
/* Fills the attributes of both sides of a vertex that lies at `eye` in eye space, where OpenGL may
 * be off by e_eye. In phong shading it has no weights: points between vertices are lit instead. */
void light_vertex(const struct plan *plan, struct surface *surface,
                  const struct body_bounds *bounds, int index, struct vector eye, double e_eye,
                  struct light_work *work);
/* The same of one side of a point of phong shading, which no OpenGL lights and no bound is for:
 * what `errors` has of weights means nothing. */
void light_point(const struct plan *plan, const struct surface *surface, const struct vertex *point,
                 int side, double *weights, float *errors, struct light_work *work);
/* An upper bound on each term's weight at whatever point of the surface phong shading lights;
 * infinite where a light that weakens with distance may be too near, whose index is left in *light.
 */
void light_limits(const struct plan *plan, const struct surface *surface, double *limits,
                  int *light);

#endif
