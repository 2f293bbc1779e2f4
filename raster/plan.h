/* SPDX-License-Identifier: MIT */
/* What the files behind plan_make share: finish.c decides which lights and terms there are, body.c
 * which meshes are drawn. Nobody else includes this. */
#ifndef PLAN_H
#define PLAN_H

#include "raster/raster.h"

/* Distances in eye space are below this: their squares are numbers in single precision. */
#define FARTHEST 1e18

/* ---- raster/plan.c: what a scene calls for ---- */

/* Room for all finishes and textures of the plan's scene. */
bool plan_allocate(struct plan *plan, struct error *err);

/* ---- raster/finish.c: materials and lights become terms ---- */

/* The wavelengths that spectra are looked at: those of the pages, but every nm for pages that are
 * means over wavelengths, or components. */
int looked_at(const struct scene *scene);
double looked_at_nm(const struct scene *scene, int i);
/* Whether a light is above 0 at any of them. */
bool is_seen(const struct scene *scene, const struct spectrum *light);
/* Under rgb and xyz a scene is lights times reflectances, which no fluorescence is. */
bool shows_luminescence(const struct scene *scene);

/* Lists all lights that may shine; finishes then use those that matter to them. */
bool lights_list(struct plan *plan, struct error *err);
/* The finish of a material, made when it is first asked for; its index into the plan. */
bool finish_find(struct plan *plan, const struct material *material, int *out, struct error *err);
/* The same, but its texture is not opened. */
bool finish_terms(struct plan *plan, const struct material *material, int *out, struct error *err);
/* Forgets the lights that no finish uses; to be called when all finishes are made. */
bool lights_drop_idle(struct plan *plan, struct error *err);

/* ---- raster/body.c: objects become meshes in their places ---- */

bool bodies_make(struct plan *plan, struct error *err);

#endif
