/* SPDX-License-Identifier: MIT */
/* The room "passes": which bands OpenGL draws together, in which colours, and which it need not
 * draw. */
#ifndef PASSES_H
#define PASSES_H

#include "raster/plan/plan.h"
#include "spectral.h"

/* ---- passes.c ---- */

/* A pass holds BANDS_PER_PASS consecutive bands. A frame is the pixels that OpenGL draws for a
 * pass, or for several that follow each other and have the same products of spectra. A pass whose
 * products are 0 has no frame: its pixels are 0. Where another program draws (plan_options), each
 * pass has a frame of its own. */
enum { DARK = -1 };
struct passes {
    int n_frames, n_dark; /* n_dark: passes without a frame */
    int *frame;           /* of each pass, ascending; or DARK; owned */
    int *first_pass;      /* of each frame; owned */
};
/* The plan is made. passes_free accepts what a failure left. */
bool passes_make(const struct plan *plan, struct passes *out, struct error *err);
void passes_free(struct passes *passes);

/* ---- colours.c ---- */

/* The colours of a material in a pass under one group of lights: products of the spectra of lights
 * and material in parts of full scale, red, green and blue for three bands, and 1. Where there is
 * no such term, or no such band, a colour is black. */
struct pass_colours {
    float constant[4], diffuse[LIGHTS_PER_PASS][4], specular[LIGHTS_PER_PASS][4];
    int n_lights; /* of this group */
    bool shines;  /* there is a specular term */
};
/* group: lights group * LIGHTS_PER_PASS and on; group 0 has the constant term. */
void pass_colours(const struct plan *plan, const struct shaded_material *shaded, int group,
                  int first_band, double full_scale, struct pass_colours *out);

/* ---- texels.c ---- */

/* Reads the texels of a spectral texture for the bands of a pass: red, green and blue of each, rows
 * from the bottom. Those of bands that do not exist are 0. out has room for all. */
bool pass_texels(const struct plan *plan, struct texture *texture, int first_band, float *out,
                 struct error *err);

/* ---- tile.c ---- */

/* The projection that makes a tile of the picture fill clip space; mirrored: y is turned around. */
struct matrix pass_projection(const struct plan *plan, const struct rectangle *tile, bool mirrored);
/* For the pixels of a tile of the plan's size, 4 numbers each: converts the steps of a colour
 * buffer to parts of full scale; adds what one group of lights adds to the others. */
void pass_convert(const struct plan *plan, const void *steps, float *pixels);
void pass_add(const struct plan *plan, const float *part, float *sum);

#endif
