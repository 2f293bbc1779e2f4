/* SPDX-License-Identifier: MIT */
/* An interactive viewer in one HTML file. */
#ifndef VIEW_H
#define VIEW_H

#include "data/options/options.h"
#include "raster/plan/plan.h"
#include "spectral.h"

/* ---- viewer.c: an interactive viewer in one HTML file ---- */

struct viewer_result {
    size_t bytes;
    int n_objects, n_lights, n_illuminants, n_detectors;
};
/* Rasterizes once and writes the page; the plan must be of exchangeable lights. */
bool viewer_write(const struct plan *plan, const char *path, struct viewer_result *out,
                  struct error *err);

/* ---- command.c: spectral view ---- */

/* Writes the page of a scene's viewer. */
bool command_view(struct options *options, struct error *err);

/* ---- inside this room ---- */

/* Browsers refuse longer texts and larger canvases. */
enum { LARGEST_SAMPLE = 65535, LARGEST_PAGE = 1 << 24 };

/* Planes of a value a pixel: constant term, then diffuse and specular of each light, then what
 * spectral textures show at their own wavelengths. Materials share them: a pixel has one material.
 */
struct planes {
    size_t n_pixels;
    int n_weights, n_pages; /* planes of weights, and of textures */
    uint16_t *surface;      /* from 1; 0: background */
    float *values;          /* [plane][pixel] */
    double *place[2];       /* in a spectral texture, in texels; NULL: there is none */
};

/* By the reference, without a check. Refuses more than LARGEST_PAGE pixels and scenes of more than
 * LARGEST_SAMPLE instances. */
bool planes_rasterize(const struct plan *plan, struct planes *out, struct error *err);
/* What sample 1 of a plane stands for: its largest value is LARGEST_SAMPLE. */
double plane_scale(const struct planes *planes, int plane);
/* The surfaces, then all planes in units of their scales, as 16-bit samples: differences between
 * neighbours, all low bytes before all high bytes, deflated (RFC 1950), in base64. Allocated and
 * not terminated; NULL: no memory. */
char *planes_text(const struct planes *planes, const double *scale, size_t *length);
void planes_free(struct planes *planes);

#endif
