/* SPDX-License-Identifier: MIT */
/* Only the files of the room "plan" include this. */
#ifndef RASTER_PLAN_INSIDE_H
#define RASTER_PLAN_INSIDE_H

#include "raster/plan/plan.h"

/* ---- reach.c: what reaches the picture ---- */

/* Returns the planes that a vertex of an instance lies outside of for sure: a set of 1 << plane. */
unsigned planes_outside(const struct plan *plan, const struct instance *instance, int vertex);
/* casters.c: counts the lights that throw shadows into view, and their groups. Refuses too many. */
bool casters_find(struct plan *plan, struct error *err);

bool reach_find(struct plan *plan, struct error *err);  /* reach.c: fills what it says in */
bool passes_make(struct plan *plan, struct error *err); /* passes.c: all else is made */
void plan_effects(struct plan *plan);                   /* effects.c: fills plan->effects */
/* plan_lights.c. Lists the lights that shine and that a material of the plan reflects. */
bool lights_list(struct plan *plan, struct error *err);
/* Makes the shaded material of a material when it is first asked for; *out is its index. */
bool shaded_material_find(struct plan *plan, const struct material *material, int *out,
                          struct error *err);
/* reliefs.c: displaces the whole mesh of a shape by its relief, and sets what flat triangles miss
 * of it. */
bool relief_apply(struct plan_mesh *whole, struct error *err);
bool instances_make(struct plan *plan, struct error *err); /* instances.c: their meshes, too */

#endif
