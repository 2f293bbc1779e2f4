/* SPDX-License-Identifier: MIT */
/* The room "context": OpenGL without a window, by OSMesa's library or by EGL's. Either is opened at
 * run time, so that the program starts without both. The static program has an OSMesa of its own,
 * and no EGL. */
#ifndef CONTEXT_H
#define CONTEXT_H

#include "raster/library/library.h"
#include "raster/renderer/renderer.h"
#include "spectral.h"

/* ---- context.c: a library in use, and what it draws on ---- */

/* The choice of --gl: see driver_accepts_library. "auto" (NULL too) takes the first of osmesa and
 * egl that is there. driver: Mesa's; NULL: any. threads: of llvmpipe. */
struct context_wish {
    const char *library, *driver;
    int threads;
    enum gl_way way; /* by shaders: EGL only */
};
/* A library in use. */
struct contexts {
    const char *name; /* "OSMesa" or "EGL" */
    enum gl_way way;
    struct gl_functions call;
    bool flipped;  /* the first row that OpenGL draws is the top of the picture */
    bool mirrored; /* the projection must turn y around for this, so that fronts go round with the
                      clock; known when a canvas is open */
    struct canvas *current;
    /* what the library does for a canvas; by osmesa.c or egl.c */
    const struct context_kind {
        bool (*open)(struct canvas *canvas, struct error *err);
        bool (*use)(struct canvas *canvas, struct error *err);
        void (*fill)(const struct canvas *canvas);
        void (*close)(struct canvas *canvas);
        void (*end)(struct contexts *contexts);
    } * kind;
    void *own; /* of osmesa.c or egl.c; owned */
};
/* Opens a library. Fails with EXIT_SYSTEM, and names the packages, where it is missing. One process
 * opens one of them. contexts_close frees *out, also after a failure. */
bool contexts_open(const struct context_wish *wish, struct contexts **out, struct error *err);
void contexts_close(struct contexts *contexts); /* NULL is fine; after all of its canvases */

/* A context with a buffer of colours, RGBA, 24 bits of depth and 8 of stencil. It has state of its
 * own, and shares no objects. */
struct canvas;
struct canvas_size {
    int bits, width, height; /* bits: of a channel, 8, 16, or 32 of floats */
    int n_colours;           /* buffers of colours, where shaders draw; otherwise 1 */
};
/* The caller closes *out, also after a failure. */
bool canvas_open(struct contexts *contexts, const struct canvas_size *size, struct canvas **out,
                 struct error *err);
void canvas_close(struct canvas *canvas); /* NULL is fine */
/* Makes OpenGL draw on the canvas, whose pixels go to the caller's memory: rows from the top. */
bool canvas_use(struct canvas *canvas, void *pixels, struct error *err);
/* Waits until all is drawn, and has filled the caller's pixels. */
void canvas_fill(const struct canvas *canvas);
/* Waits, and reads one of the buffers of colours of a canvas of EGL. */
void canvas_read(const struct canvas *canvas, int colour, void *pixels);
/* Returns whether OpenGL has an extension; a canvas is open. */
bool contexts_have(const struct contexts *contexts, const char *extension);

/* ---- describe.c: what can be used ---- */

/* Finds the names of what draws; a canvas is in use. Refuses a size that is too large for OpenGL,
 * and another driver than the wanted one, which was chosen before the first canvas. wanted: NULL:
 * any. */
bool contexts_accept(const struct contexts *contexts, const struct rectangle *size,
                     const char *wanted, struct renderer_names *out, struct error *err);
struct context_description {
    struct renderer_names names;
    char vendor[128];
    int largest_viewport[2], largest_texture; /* pixels, texels, a side */
};
/* Opens a library and closes it. For a process of its own, which opens no other one. */
bool contexts_describe(const struct context_wish *wish, struct context_description *out,
                       struct error *err);
/* Writes name, version and driver of the library that is used by default. */
void contexts_print(char *out, size_t capacity);
/* Finds how many devices EGL lists; 0 without EGL. For a process of its own. */
bool contexts_devices(int *out, struct error *err);

/* ---- inside this room ---- */

struct canvas {
    struct contexts *contexts;
    struct canvas_size size;
    void *context; /* the library's; NULL: none */
    void *pixels;
};
bool has_extension(const char *list, const char *name); /* list: words; NULL: none */
GLenum canvas_type(const struct canvas *canvas);        /* of a channel */
/* Open a library; *found: its file is there, otherwise nothing is opened. device: EGL's; -1: none
 * is asked for. */
bool osmesa_open(struct contexts *contexts, bool *found, struct error *err);
bool egl_open(struct contexts *contexts, int device, bool *found, struct error *err);

#endif
