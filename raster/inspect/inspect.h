/* SPDX-License-Identifier: MIT */
/* Says how the spectrum of a pixel comes about: draws a region of a scene by the reference, and
 * lists the spectra that make it. It may not know OpenGL, nor how the result is printed
 * (data/probe). */
#ifndef INSPECT_H
#define INSPECT_H

#include "data/options/options.h"
#include "data/probe/probe.h"
#include "raster/plan/plan.h"
#include "spectral.h"

/* ---- inspect.c: how a pixel's spectrum comes about ---- */

/* Computes the mean radiance of a region by the reference, and lists its curves: lights, ambient
 * lights, and, if the region shows one object, its reflectance, specular reflectance, excitation,
 * emission and own light. The options name a region in pixels of the plan's picture; one that is
 * not within it is refused. The caller frees *out, also after a failure. */
bool probe_scene(const struct plan *plan, const struct probe_options *options, struct probe *out,
                 struct error *err);

/* ---- command.c: spectral probe ---- */

/* Prints the spectrum of a region of a stack or of a scene, as text, CSV or SVG. */
bool command_probe(struct options *options, struct error *err);

#endif
