/* SPDX-License-Identifier: MIT */
/* How the spectrum of a pixel of a scene comes about. */
#ifndef INSPECT_H
#define INSPECT_H

#include "data/options/options.h"
#include "data/probe/probe.h"
#include "raster/plan/plan.h"
#include "spectral.h"

/* ---- inspect.c: how a pixel's spectrum comes about ---- */

/* The reference's radiance of a region, and the curves that make it: the lights, ambient lights,
 * and, if the region shows one object, its reflectance, specular reflectance, excitation, emission,
 * and glow. The plan's picture is what x and y refer to. */
bool probe_scene(const struct plan *plan, const struct probe_options *options, struct probe *out,
                 struct error *err);

/* ---- command.c: spectral probe ---- */

/* Prints the spectrum of a region, of a stack or of a scene. */
bool command_probe(struct options *options, struct error *err);

#endif
