/* SPDX-License-Identifier: MIT */
/* What the files behind plan_make share: finish.c decides which lights and terms there are, body.c
 * which meshes are drawn. Nobody else includes this. */
#ifndef PLAN_H
#define PLAN_H

#include "spectral.h"

/* Distances in eye space are below this: their squares are numbers in single precision. */
#define FARTHEST 1e18

/* ---- raster/finish.c: materials and lights become terms ---- */

/* Lists all lights that may shine; finishes then use those that matter to them. */
bool lights_list(struct plan *plan, struct error *err);
/* The finish of a material, made when it is first asked for; its index into the plan. */
bool finish_find(struct plan *plan, const struct material *material, int *out, struct error *err);
/* Forgets the lights that no finish uses; to be called when all finishes are made. */
bool lights_drop_idle(struct plan *plan, struct error *err);

/* ---- raster/body.c: objects become meshes in their places ---- */

bool bodies_make(struct plan *plan, struct error *err);

#endif
