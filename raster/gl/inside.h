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

/* Finds the functions of the way of *to, in the library (NULL: none), or by what its own function
 * finds; all others are NULL. Fails with EXIT_SYSTEM if one is missing. `name`: the library's. */
bool functions_find(struct contexts *to, void *library, any_function *(*get)(const char *name),
                    const char *name, struct error *err);

/* Open a library; *found: its file is there, otherwise nothing is opened. device: EGL's; -1: none
 * is asked for. */
bool osmesa_open(struct contexts *contexts, bool *found, struct error *err);
bool egl_open(struct contexts *contexts, int device, bool *found, struct error *err);

bool has_extension(const char *list, const char *name); /* list: words; NULL: none */

GLenum canvas_type(const struct canvas *canvas); /* of a channel */

#endif
