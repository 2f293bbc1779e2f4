/* SPDX-License-Identifier: MIT */
/* Only the files of the room "shader" include this. */
#ifndef RASTER_BESIDE_SHADER_INSIDE_H
#define RASTER_BESIDE_SHADER_INSIDE_H

#include "raster/beside/shader/shader.h"

/* ---- shader_program.c ---- */

enum { VARIANTS = 12 }; /* of the programs of a group: shines, two_sided, texture */
/* The effects that a program has; it has no others. */
struct program_effects {
    int group; /* of lights */
    bool shines, two_sided;
    enum { UNTEXTURED, GREY_TEXTURE, SPECTRAL_TEXTURE } texture;
};
struct shader;
/* Makes the program of some effects, or with NULL the one that draws the numbers of triangles,
 * unless there is one, and uses it. Returns its name; 0: a failure. */
unsigned program_use(struct shader *shader, const struct program_effects *effects,
                     struct error *err);

/* ---- shared ---- */

struct shader {
    struct drawing base; /* the first member */
    unsigned *programs; /* names; 0: not made yet: the one that draws numbers, then VARIANTS of each
                           group; owned */
    unsigned stream;    /* the buffer of numbered vertices */
};

#endif
