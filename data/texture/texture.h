/* SPDX-License-Identifier: MIT */
/* The room "texture": pictures on surfaces. */
#ifndef TEXTURE_H
#define TEXTURE_H

#include <pthread.h>

#include "data/tiff/tiff.h"

enum { TEXTURE_PLANES = 3 };
/* Planes have rows from t = 0 (the picture's bottom row) upwards, width values each. */
struct texture {
    struct image image; /* open as long as planes are to be loaded */
    bool spectral;
    bool linear;                  /* between texel centres; otherwise the nearest texel */
    double smallest, largest;     /* of all values of all pages */
    float *plane[TEXTURE_PLANES]; /* grey: the first; spectral: those loaded; owned */
    pthread_mutex_t *reading;     /* held while the image is read; owned */
};
/* Reads a texture; the caller chooses `linear` and `spectral` of *out. A grey texture is one page
 * with values that hold for every wavelength. A spectral texture is a stack of pages with
 * wavelengths; all of them are read once, to find their smallest and largest value. Refuses a side
 * of more than 16384 texels, since OpenGL's textures have a limit, too. */
bool texture_read(const char *path, struct place from, struct texture *out, struct error *err);
/* Fills the planes for n wavelengths, at most TEXTURE_PLANES: linear between pages, and the end
 * page beyond the first and the last one. Does nothing for a grey texture. */
bool texture_load(struct texture *texture, const double *wavelengths_nm, int n, struct error *err);
/* Does the same with planes of the caller's, which have room for a page each. Several threads may
 * call it. */
bool texture_fill(struct texture *texture, const double *wavelengths_nm, int n,
                  float *const planes[TEXTURE_PLANES], struct error *err);
void texture_free(struct texture *texture);

#endif
