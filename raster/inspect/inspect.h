/* SPDX-License-Identifier: MIT */
/* Explains the spectrum of a pixel: draws a region of a scene by the reference, and lists the
 * spectra that contribute to it. This room depends neither on OpenGL nor on how the result is
 * printed (data/probe). */
#ifndef INSPECT_H
#define INSPECT_H

#include "data/options/options.h"
#include "data/probe/probe.h"
#include "raster/plan/plan.h"
#include "spectral.h"

/* ---- inspect.c: the spectrum of a region of a scene ---- */

/* Computes the mean radiance of a region by the reference, and lists its curves: the lights and the
 * ambient lights; if the region shows one object only, also its reflectance, specular reflectance,
 * excitation, emission and own light. The options give the region in pixels of the plan's picture.
 * Refuses a region that is not within the picture. The caller frees *out, also after a failure. */
bool probe_scene(const struct plan *plan, const struct probe_options *options, struct probe *out,
                 struct error *err);

/* ---- command.c: spectral probe ---- */

/* Prints the spectrum of a region of a stack or of a scene, as text, CSV or SVG. */
bool command_probe(struct options *options, struct error *err);

#endif
