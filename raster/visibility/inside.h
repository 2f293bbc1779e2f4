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

/* boxes.c. Calls `visit` for each occluder whose box the segment meets, from a point to another, or
 * without end in a direction. Stops where it returns false. */
void occluders_along(const struct occluders *of, struct vector from, const struct homogeneous *to,
                     bool (*visit)(void *context, const struct occluder *met), void *context);

#endif
