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

/* Finds the functions of the way of *to, in the library or by its own function for that; all others
 * are NULL. Fails with EXIT_SYSTEM if one is missing. */
bool functions_find(struct contexts *to, void *library, struct error *err);

/* ---- context.c ---- */

/* Opens a library. Fails with EXIT_SYSTEM, and names the packages, where it is missing. One process
 * opens one of them. contexts_close frees *out, also after a failure. */
bool contexts_open(const struct context_wish *wish, struct contexts **out, struct error *err);
void contexts_close(struct contexts *contexts); /* NULL is fine; after all of its canvases */
/* The caller closes *out, also after a failure. */
bool canvas_open(struct contexts *contexts, const struct canvas_size *size, struct canvas **out,
                 struct error *err);
/* Waits until all is drawn, and has filled the caller's pixels. */
void canvas_fill(const struct canvas *canvas);

/* A library: all in which OSMesa and EGL differ. */
struct context_kind {
    const char *name;
    bool flipped;                 /* as in struct contexts */
    const char *const *files;     /* names of the library, then NULL */
    const char *const *functions; /* `own` of struct contexts begins with them */
    size_t n_functions, own_size; /* own_size: in bytes */
    const char *too_old;          /* the message where a function is missing */
    /* Completes `own`. device: EGL's; -1: none is asked for. NULL: it is complete. */
    bool (*begin)(struct contexts *contexts, int device, struct error *err);
    void (*end)(struct contexts *contexts); /* NULL: there is nothing to end */
    /* of a canvas */
    bool (*open)(struct canvas *canvas, struct error *err);
    bool (*use)(struct canvas *canvas, struct error *err);
    void (*fill)(const struct canvas *canvas);
    void (*close)(struct canvas *canvas);
};
extern const struct context_kind osmesa_kind, egl_kind;
/* `own` begins with the library's own function for finding others. */
struct library_functions {
    any_function *(*get)(const char *name);
};

bool has_extension(const char *list, const char *name); /* list: words; NULL: none */

GLenum canvas_type(const struct canvas *canvas); /* of a channel */

/* shadows.c. Refuses a driver that cannot draw the shadows of the plan. */
bool shadows_can_draw(const struct drawing *of, struct error *err);

#endif
