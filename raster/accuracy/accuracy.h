/* SPDX-License-Identifier: MIT */
/* Measures how far a stack is from the picture of its scene at every nm: in colour, as an observer
 * sees it, and in radiance. The reference draws that picture, which is called the standard. This
 * room may not know how a stack was rendered, nor how long that took. */
#ifndef ACCURACY_H
#define ACCURACY_H

#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "spectral.h"

/* ---- standard.c: the picture at every nm ---- */

/* The picture lies in a file: CIELAB of each pixel, whether it shows an object, and the spectra of
 * a lattice of pixels. */
struct standard {
    int width, height;
    double white[3]; /* XYZ of the lights, or of a radiance of 1 where the observer sees none */
    bool lit;        /* the observer sees some light */
    double first_nm;
    int n_nm;
    int step, columns, rows; /* of the lattice: every step-th pixel of every step-th row */
};
/* Renders a scene of which every nm is a wavelength, as an observer sees it, into a new file. */
bool standard_render(const struct scene *scene, const char *observer, int threads, const char *path,
                     struct standard *out, struct error *err);

/* ---- accuracy.c: how far a stack is from it ---- */

struct accuracy {
    int n_pages;
    bool spectral;                     /* pages are radiances at wavelengths */
    double mean, quantile_95, largest; /* CIEDE2000 over the pixels in which either picture shows
                                          an object; 0 where there are none */
    double radiance; /* rms of the error of radiances at every nm, relative to their rms; NaN: the
                        pages determine no radiances */
};
struct accuracy_stack {
    const char *path;
    const struct scene *scene;       /* as it was rendered */
    const struct sampling *sampling; /* NULL: at the scene's own wavelengths */
    const char *observer;
};
/* Measures a stack of the standard's size. path: the file of the standard. */
bool accuracy_measure(const struct standard *standard, const char *path,
                      const struct accuracy_stack *stack, int threads, struct accuracy *out,
                      struct error *err);

/* ---- inside this room: the file of a standard ---- */

uint64_t standard_pixels(const struct standard *standard);
size_t standard_lattice_points(const struct standard *standard);
/* Returns the number of a pixel on the lattice; -1: it is not on it. */
ptrdiff_t standard_lattice_index(const struct standard *standard, int x, int y);
/* The offsets in bytes behind CIELAB, which begins at 0: of a byte a pixel, 1 where it shows an
 * object, and of n_nm radiances a point of the lattice. */
uint64_t standard_offset_of_shown(const struct standard *standard);
uint64_t standard_offset_of_lattice(const struct standard *standard);
bool standard_read(int file, uint64_t offset, void *bytes, size_t length, struct error *err);

#endif
