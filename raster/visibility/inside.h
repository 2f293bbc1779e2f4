/* SPDX-License-Identifier: MIT */
/* Only the files of the room "visibility" include this. */
#ifndef RASTER_VISIBILITY_INSIDE_H
#define RASTER_VISIBILITY_INSIDE_H

#include "raster/visibility/visibility.h"

/* signs.c. Returns the sign, -1, 0 or 1, of the determinant of four rows (x, y, z, w); exact for
 * numbers from 1e-70 to 1e70 and 0. With three points a, b, c it is the side of their plane on
 * which d lies (Shewchuk 1997: Adaptive Precision Floating-Point Arithmetic and Fast Robust
 * Geometric Predicates). */
int side_of(const struct homogeneous rows[4]);

/* A place in eye space is off by at most this part of occluders.size: the point of a pixel by 10
 * roundings of its shares, 3 of their sum and 4 of the matrix; corners and lights by 4; matrices of
 * two objects differ by 4 for each of the products that they are. */
#define PLACE_ERROR (32 * DOUBLE_ROUNDOFF)

/* boxes.c. Returns corner i of an occluder. */
struct vector occluder_corner(const struct occluders *of, struct occluder at, int i);
/* Calls `visit` for each occluder whose box a segment may meet, from one of some points to
 * an end, or without end in a direction. Bit i stands for the segment from point i. Stops where it
 * returns false. */
typedef bool occluder_visitor(void *context, const struct occluder *met, uint32_t segments);
void occluders_along(const struct occluders *of, struct seen_point *const points[], int n,
                     const struct homogeneous *to, occluder_visitor *visit, void *context);

#endif
