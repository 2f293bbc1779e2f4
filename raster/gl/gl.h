/* SPDX-License-Identifier: MIT */
/* The same picture through OpenGL. No other room includes a GL header. */
#ifndef GL_H
#define GL_H

#include "data/maths/maths.h"
#include "raster/bounds/bounds.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- mesa.c: the same picture through OSMesa ---- */

struct gl;
struct gl_work {
    long passes, draw_calls;
};
/* Uploads the geometry once. EXIT_SYSTEM when there is no usable OpenGL. */
bool gl_open(const struct plan *plan, struct gl **out, struct error *err);
const char *gl_renderer(const struct gl *gl);
const char *gl_version(const struct gl *gl);
/* Aims at a tile of the picture; surfaces that do not reach it will not be drawn. */
void gl_aim(struct gl *gl, const struct lit_scene *lit, const struct rectangle *tile);
/* Draws bands first .. first + BANDS_PER_PASS - 1 (those that exist) of the aimed tile, radiances
 * divided by full_scale, and brought by a colour buffer of counts to the nearest one. Returns 4
 * floats a pixel, row by row from the top, rows of tile_width. */
bool gl_draw(struct gl *gl, int first_band, double full_scale, const float **pixels,
             struct error *err);
/* False in a program without OpenGL, of which no picture can be asked. */
bool gl_is_built(void);
/* Name, version and driver of the OSMesa in use. */
void gl_library(char *out, size_t capacity);
struct gl_work gl_work(const struct gl *gl);
void gl_close(struct gl *gl);

/* ---- identify.c: which triangle OpenGL shows ---- */

/* What OpenGL shows at a pixel. */
struct shown {
    int32_t surface, triangle; /* -1: background */
    uint32_t depth;            /* in steps of 1 / (2^24 - 1) */
    uint8_t fragments;         /* drawn there, hidden ones too, modulo 256 */
};
/* Draws the numbers of surfaces and triangles of the aimed tile instead of their colours. */
bool gl_identify(struct gl *gl, struct error *err);
/* Of the last gl_identify, before the next gl_draw; x and y within the tile. */
struct shown gl_shown(const struct gl *gl, int x, int y);

/* ---- inside this room ---- */

struct gl {
    const struct plan *plan;
    const struct lit_scene *lit;
    struct osmesa_context *context;
    struct osmesa_context *numbers; /* that draws into floats where `context` draws into steps;
                              NULL: the same */
    float *pixels; /* tile_height rows of tile_width pixels of 4 floats, from the top */
    void *steps;   /* the same of 4 uint8_t or uint16_t, which colours are drawn into; NULL: pixels
                      are */
    const void *current; /* which of the two is drawn into */
    float *sum;          /* the same, of all passes; NULL where there is one */
    uint32_t
        *depths; /* the same from the bottom: 24 bits of depth, 8 of stencil; NULL: unchecked */
    unsigned *buffers;  /* BUFFERS of each mesh */
    unsigned *textures; /* of each texture */
    struct rectangle tile;
    struct gl_work work;
};

/* ---- mesa.c ---- */

/* Draws into floats from now on, or into what colours are drawn into. */
bool gl_draw_into(struct gl *gl, bool floats, struct error *err);

/* Empties the aimed tile, and leaves lighting and textures switched off. */
void gl_blacken(void);
void gl_load_matrix(const struct matrix *m);
/* False after any error since the last call. */
bool gl_succeeded(struct error *err);

#endif
