/* SPDX-License-Identifier: MIT */
/* The room "develop": a stack as a detector sees it. */
#ifndef DEVELOP_H
#define DEVELOP_H

#include "data/colour/colour.h"
#include "data/method/method.h"
#include "data/options/options.h"
#include "data/spectra/spectra.h"
#include "data/stack/stack.h"
#include "spectral.h"

enum develop_values { DEVELOP_RGB, DEVELOP_XYZ, DEVELOP_LAB };
struct develop_options {
    const char *detector; /* name or file */
    struct adaptation adaptation;
    enum display_kind display;
    const char *white; /* SPECTRUM; NULL: what the stack records */
    double exposure;   /* factor of all radiances; 0: the one that brings the largest displayed
                          value (or Y) of the picture to just 1 (or 100) */
    enum develop_values values;
    struct outputs *outputs;                /* get the picture; NULL: it appears at once */
    int bits;                               /* of RGB: 8 or 16 */
    int threads;                            /* 0: one a processor */
    const struct sampling_method *sampling; /* samples the stack's spectra, linear between pages,
                                               before they are developed; NULL: no. Refused for
                                               stacks that were sampled, and for basis, rgb and
                                               xyz, which need lights and reflectances apart */
};
struct develop_result {
    int width, height, n_pages;
    double first_nm, last_nm; /* of pages, or of the range of components */
    char sampling[512];       /* of the stack, or by options.sampling, in a line; "": none */
    bool components, observer;
    struct adaptation adaptation; /* as used: with its luminance */
    double lost[3];               /* detector_lost */
    bool has_white;
    double white[3];       /* the white in the detector's channels, before adaptation */
    double exposure;       /* as used */
    uint64_t out_of_gamut; /* pixels with a channel clipped by more than 1e-6; 0 of XYZ and Lab */
};
/* Reads a stack and writes a picture of it, whose format follows from the ending of its name; a PNG
 * has no XYZ and no Lab. The channels of cameras and films are balanced: each is
 * divided by the white's. Refuses adaptation, XYZ and Lab for them. */
bool develop(const char *stack, const char *output, const struct develop_options *options,
             struct develop_result *out, struct error *err);
void develop_print(const struct develop_options *options, const struct develop_result *result,
                   struct printed *to);
/* Begins a text with one JSON object. output: the name of the picture. */
void develop_json(const struct develop_options *options, const struct develop_result *result,
                  const char *output, struct json *json);

/* ---- command.c: spectral develop ---- */

/* Writes the picture of a stack that a detector sees. */
bool command_develop(struct options *options, struct error *err);
/* Refuse a value that --adaptation, --display or --exposure cannot use. Messages name `option`. */
bool develop_accepts_adaptation(const char *option, const char *value, struct error *err);
bool develop_accepts_display(const char *option, const char *value, struct error *err);
bool develop_accepts_exposure(const char *option, const char *value, struct error *err);

/* ---- Inside this room ---- */

/* A stack that is being developed. */
struct development {
    const struct develop_options *options;
    struct develop_result *result;
    struct cube cube;
    struct detector detector;
    double *weights;  /* of the stack's pages: [channel * n_pages + page]; owned */
    double *of_white; /* of the white's pages, if they differ from those; owned */
    double equal[3];  /* the detector's response to a radiance of 1 everywhere */
    double white[3];  /* to which an observer has adapted */
    int rows;         /* of a chunk */
    int threads;
    size_t n_pixels; /* of a chunk */
    float *radiance; /* [page of the batch][pixel]; owned */
    double *sums;    /* [channel][pixel]; owned */
    void *samples;   /* as picture_write takes them; owned */
};
/* Finds the weights that take the pages of the cube to linear display channels, or to XYZ (also for
 * CIELAB), at exposure 1. Fills in the white, and all members of the result that pixels do
 * not decide. Refuses a detector that sees none of the wavelengths. In weights.c. */
bool develop_weights(struct development *of, struct error *err);

#endif
