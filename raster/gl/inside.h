/* SPDX-License-Identifier: MIT */
/* Only the files of the room "gl" include this. */
#ifndef RASTER_GL_INSIDE_H
#define RASTER_GL_INSIDE_H

#include "raster/gl/gl.h"

/* ---- library.c: files of libraries ---- */

typedef void any_function(void);
/* Opens the first of the files that is there; NULL ends the list. *out is NULL if none is. The
 * library stays open as long as the program runs: Mesa's may not be closed. */
bool library_open(const char *const *files, void **out, struct error *err);
/* Finds n functions of an open library, or those of that name that were loaded before it, for a
 * struct that begins with as many pointers, which all have one size in POSIX. Returns whether all
 * are there. */
bool library_find_all(void *library, const char *const *names, size_t n, void *out);

/* A context with buffers of colours, RGBA, 24 bits of depth and 8 of stencil. It has state of its
 * own, and shares no objects. */
struct canvas {
    struct contexts *contexts;
    int bits; /* of a channel: 8, 10 (EGL), 16, or 32 of floats */
    int width, height;
    void *context; /* the library's; NULL: none */
    bool is_stale; /* it has colours of another tile; its user keeps this */
};
enum { MOST_CANVASES = 2 };

/* A library in use. */
struct contexts {
    enum gl_way way;
    struct gl_functions call;
    bool mirrored; /* the projection must turn y around, so that the first row that OpenGL draws is
                      the top, and fronts go round with the clock; known when a canvas is open */
    int n_colours; /* buffers of colours that a canvas has; at most MOST_AT_ONCE */
    struct canvas canvases[MOST_CANVASES]; /* n_canvases: in the order of their opening */
    int n_canvases;
    struct canvas *current;          /* one of them; NULL: none */
    const struct context_kind *kind; /* NULL: no library was found */
    void *own;                       /* of osmesa.c or egl.c; owned */
};
/* Finds the functions of the way of *to, in the library or by its own function for that; all others
 * are NULL. Fails with EXIT_SYSTEM if one is missing. */
bool functions_find(struct contexts *to, void *library, struct error *err);
/* Returns false after any error of OpenGL since the last call. */
bool functions_succeeded(const struct gl_functions *call, struct error *err);

/* ---- context.c ---- */

/* Opens the library that gl_library (see driver_accepts_library) and gl_way choose: "auto" (NULL
 * too) is the first of osmesa and egl that is there; shaders take EGL. Chooses gl_driver, with so
 * many threads. Fails with EXIT_SYSTEM, and names the packages, where the library is missing. One
 * process opens one of them. contexts_close frees *out, also after a failure. */
bool contexts_open(const struct plan_options *wish, struct contexts **out, struct error *err);
void contexts_close(struct contexts *contexts); /* with all of its canvases; NULL is fine */
/* Returns whether OpenGL has an extension; a canvas is open. */
bool contexts_have(const struct contexts *contexts, const char *extension);

/* Opens one of MOST_CANVASES. */
bool canvas_open(struct contexts *contexts, int bits, int width, int height, struct canvas **out,
                 struct error *err);
/* Makes OpenGL draw on the canvas. `pixels`: where `fill` puts buffer 0 of its colours. */
bool canvas_use(struct canvas *canvas, void *pixels, struct error *err);
GLenum canvas_type(const struct canvas *canvas); /* of a channel */

/* A library: all in which OSMesa and EGL differ. */
struct context_kind {
    const char *name;             /* "OSMesa" or "EGL" */
    bool flipped;                 /* the first row that OpenGL draws is the top of the picture */
    const char *const *files;     /* names of the library, then NULL */
    const char *const *functions; /* `own` of struct contexts begins with them */
    size_t n_functions, own_size; /* own_size: in bytes */
    const char *too_old;          /* the message where a function is missing */
    /* Completes `own`. device: EGL's; -1: none is asked for. NULL: it is complete. */
    bool (*begin)(struct contexts *contexts, int device, struct error *err);
    void (*end)(struct contexts *contexts); /* NULL: there is nothing to end */
    /* of a canvas */
    bool (*open)(struct canvas *canvas, struct error *err);
    bool (*use)(struct canvas *canvas, void *pixels, struct error *err);
    /* Waits until all is drawn, and puts a buffer of colours into the caller's memory: rows from
     * the top. For buffer 0, `use` gets the same memory. */
    void (*fill)(const struct canvas *canvas, int colours, void *pixels);
    void (*close)(struct canvas *canvas);
};
extern const struct context_kind osmesa_kind, egl_kind;
/* `own` begins with the library's own function for finding others. */
struct library_functions {
    any_function *(*get)(const char *name);
};

bool has_extension(const char *list, const char *name); /* list: words; NULL: none */

/* ---- opened.c ---- */

/* As struct renderer_kind says. Uploads all but the texels of spectral textures. */
bool drawing_take_scene(struct renderer *renderer, const struct lit_scene *lit, struct error *err);
/* Uploads the texels of spectral textures for the bands of a batch. */
bool textures_upload_bands(struct drawing *of, const struct frame_batch *batch, struct error *err);
/* Triangles given to draw_corners at once: few enough to stay in the second-level cache. */
enum { BATCH = 4096 };
/* Gives the triangles of all instances that reach the tile, and are not hidden, to draw_corners. */
bool numbers_draw(struct drawing *of, struct error *err);

/* ---- frame.c ---- */

/* Lets OpenGL draw into these floats from now on, or into steps; `numbers`: not colours. */
bool frame_begin(struct drawing *of, float *floats, bool numbers, struct error *err);
/* The next draw calls have fronts that turn as those of a mirrored instance, or of another one. */
void turn_fronts(struct drawing *of, bool mirrored);
extern const struct renderer_kind drawing_renderer;

/* ---- shadows.c ---- */

/* Refuses a driver that cannot draw the shadows of the plan. */
bool shadows_can_draw(const struct drawing *of, struct error *err);
/* Finds the pixels of the tile that each light with shadows reaches. Colours stay what they are. */
bool shadows_draw(struct drawing *of, struct error *err);
/* Returns whether the light of a group reaches each pixel of the tile; NULL: the group has no
 * shadows. */
const uint8_t *shadows_of(const struct drawing *of, int group);

#endif
