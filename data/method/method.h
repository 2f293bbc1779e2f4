/* SPDX-License-Identifier: MIT */
/* The room "method": ways to sample a spectrum, as words. */
#ifndef METHOD_H
#define METHOD_H

#include "spectral.h"

/* ---- method.c: names of samplings ---- */

enum sampling_kind {
    SAMPLING_BOX,      /* box:N - N boxes of equal area under the detector's functions (Hall) */
    SAMPLING_RIEMANN,  /* riemann:STEP - a value every STEP nm */
    SAMPLING_GAUSS,    /* gauss:N[,FUNCTIONS] - quadrature weighted by functions of the detector */
    SAMPLING_ADAPTIVE, /* adaptive:TOL - segments, peaks found, quadrature between (Deville) */
    SAMPLING_BASIS,    /* basis:K - principal components of the scene's lights x reflectances */
    SAMPLING_RGB,      /* rgb - linear sRGB of lights times linear sRGB of reflectances */
    SAMPLING_XYZ       /* xyz - tristimulus values of lights times those of reflectances */
};
/* The functions that weigh the quadrature of gauss. Each of the three functions of XYZ, LMS and ACC
 * has nodes of its own. */
enum sampling_functions {
    FUNCTIONS_DETECTOR, /* the sum of the magnitudes of the detector's three */
    FUNCTIONS_OPEN,     /* the constant 1: any detector can be used afterwards */
    FUNCTIONS_XYZ,      /* the observer's own */
    FUNCTIONS_LMS,      /* Hunt-Pointer-Estevez cone responses, linear in those */
    FUNCTIONS_ACC       /* opponent A, C1, C2: the principal axes of the cones' overlaps, linear in
                           those; C1 and C2 change sign */
};
struct sampling_method {
    enum sampling_kind kind;
    int count;        /* N or K; gauss: 1 to LARGEST_QUADRATURE */
    double step_nm;   /* STEP */
    double tolerance; /* TOL: of a channel's response to a light, in parts of that */
    enum sampling_functions functions;
};
/* Reads a method as written above. Messages name `option`. */
bool sampling_read(const char *option, const char *text, struct sampling_method *out,
                   struct error *err);
/* Writes a method as sampling_read takes it, with the fewest digits that are exact. */
enum { SAMPLING_NAME = 48 };
void sampling_name(const struct sampling_method *method, char out[SAMPLING_NAME]);
/* Returns whether pages of the method of this name are means over segments, not values in them. */
bool sampling_takes_means(const char *name);

#endif
