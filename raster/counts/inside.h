/* SPDX-License-Identifier: MIT */
/* Only the files of the room "counts" include this. */
#ifndef RASTER_COUNTS_INSIDE_H
#define RASTER_COUNTS_INSIDE_H

#include "raster/counts/counts.h"

/* ---- noise.c ---- */

/* Returns the index of a light, if the radiance of weights `at` of a surface (a vertex and a side)
 * comes only from lights that graze it, so that it is rounding noise; otherwise -1. */
int noisy_light(const struct lit_scene *lit, int surface, size_t at);

#endif
