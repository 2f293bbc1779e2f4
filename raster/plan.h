/* SPDX-License-Identifier: MIT */
/* What the files behind plan_make share: plan_lights.c places the lights, shaded_material.c makes
 * the materials, body.c the meshes that are drawn. Nobody else includes this. */
#ifndef PLAN_H
#define PLAN_H

#include "raster/raster.h"

/* Distances in eye space are below this: their squares are numbers in single precision. */
#define FARTHEST 1e18

/* ---- raster/plan_lights.c: lights in eye space ---- */

/* Lists all lights that shine; shaded materials then use those that matter to them. */
bool lights_list(struct plan *plan, struct error *err);
/* Forgets the lights that light nothing; to be called when all shaded materials are made. */
bool lights_drop_idle(struct plan *plan, struct error *err);

/* ---- raster/shaded_material.c: materials under lights ---- */

/* The shaded material of a material, made when it is first asked for; its index into the plan. */
bool shaded_material_find(struct plan *plan, const struct material *material, int *out,
                          struct error *err);

/* ---- raster/body.c: objects become meshes in their places ---- */

bool bodies_make(struct plan *plan, struct error *err);

#endif
