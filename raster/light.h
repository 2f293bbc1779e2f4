/* SPDX-License-Identifier: MIT */
/* What surface.c, which places vertices, and light.c, which lights them, share. Nobody else
 * includes this. */
#ifndef LIGHT_H
#define LIGHT_H

#include "spectral.h"

/* ---- raster/light.c: one vertex ---- */

/* What the vertices of one body have in common. */
struct body_bounds {
    double cofactor[3][3]; /* what the rounding errors of normals are relative to */
    double e_rigid;        /* how far the modelview is from rigid where OpenGL takes it for that */
};
struct body_bounds body_bounds(const struct body *body);
/* Fills the attributes of both sides of a vertex that lies at `eye` in eye space, where OpenGL may
 * be off by e_eye. */
void light_vertex(const struct plan *plan, struct surface *surface,
                  const struct body_bounds *bounds, int index, struct vector eye, double e_eye,
                  struct light_work *work);

#endif
