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

/* boxes.c. Calls `visit` for each occluder whose box the segment meets, from a point to another, or
 * without end in a direction. Stops where it returns false. */
void occluders_along(const struct occluders *of, struct vector from, const struct homogeneous *to,
                     bool (*visit)(void *context, const struct occluder *met), void *context);

#endif
