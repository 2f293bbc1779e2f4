/* SPDX-License-Identifier: MIT */
/* The room "accuracy": by how much a picture differs from one that lights every point of the true
 * surfaces, before it is drawn; and finer triangles, until it differs by less. */
#ifndef RASTER_BESIDE_ACCURACY_ACCURACY_H
#define RASTER_BESIDE_ACCURACY_ACCURACY_H

#include "raster/render/render.h"

/* ---- refine.c ---- */

/* See raster/render/render.h. It refines a plan if the options ask for it: divides all objects
 * alike, again and again, until 95 % of the pixels of each have at most the wanted error.
 * Built-in shapes get twice as many slices, stacks, ..., and edges of mesh files are halved. Flat
 * shading stays as it is. */
extern const struct shading_judge accuracy_judge;

#endif
