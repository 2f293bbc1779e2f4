/* SPDX-License-Identifier: MIT */
/* Only the files of the room "bounds" include this. */
#ifndef RASTER_BOUNDS_INSIDE_H
#define RASTER_BOUNDS_INSIDE_H

#include "raster/bounds/bounds.h"

/* ---- exact.c: where single precision makes no error ---- */

/* True where single precision rounds nothing: in a sum of terms, in whatever order it is made; in
 * the dot product of two vectors that it holds; in the product of two matrices that it holds. */
bool exact_sum(const double *terms, int n);
bool exact_row(const double row[4], const double v[4]);
bool exact_product(const struct matrix *a, const struct matrix *b);

/* ---- vertex.c, light_bound.c: vertices ---- */

/* The distance of the upper 3x3 from the rigid matrix that OpenGL takes it for; 0: for none. */
double distance_from_rigid(const struct matrix *m);
/* Adds a vertex's bounds to the surface's errors; e_eye bounds its place in eye space. They are
 * infinite where a weight has no bound. */
void light_bounds(const struct lit_scene *lit, const struct surface *of, int index, double e_eye,
                  struct light_work *work);

/* ---- facing.c: on which side a triangle is seen ---- */

/* Fills in the hidden triangles of a surface whose vertices have bounds: those that OpenGL sees
 * from behind for sure, on a solid, one-sided surface between the near and the far plane. */
bool find_hidden(const struct lit_scene *lit, int surface, struct error *err);

#endif
