/* SPDX-License-Identifier: MIT */
/* The room "measure": what OpenGL can draw on this system, and how it does what its specification
 * leaves free, measured on small targets with known answers. The profile of a driver is made from
 * that. Bounds then come from the specification (of OpenGL 2.1) and from these measurements, never
 * from the scene under test. */
#ifndef RASTER_BESIDE_MEASURE_MEASURE_H
#define RASTER_BESIDE_MEASURE_MEASURE_H

#include "data/text/text.h"
#include "raster/gl/gl.h"
#include "raster/renderers/renderers.h"
#include "spectral.h"

/* ---- values.c ---- */

/* Makes the profile of a driver from measurements: see struct drawing_ways. */
bool driver_measure(struct contexts *contexts, const char *gl_renderer, struct driver *out,
                    struct error *err);

/* ---- command.c: spectral drivers ---- */

/* Prints each library and driver that can be used, and each library that cannot; with --measure how
 * it draws. Fails with EXIT_SYSTEM if none can. */
extern const struct command drivers_command;

/* A library and a driver, as the options --gl and --renderer name them. */
struct listed_driver {
    char library[16];
    const char *renderer;          /* NULL: the one that comes without --renderer */
    bool usable, again;            /* again: an earlier one of the list is the same OpenGL */
    struct context_description is; /* if it is usable */
    char reason[512];              /* why it is not, in a line */
};
struct driver_list {
    struct listed_driver *list; /* owned */
    int n;
};
/* Adds a library with a choice of --renderer, which it tries in a process of its own. `new_only`:
 * leaves out a driver that the library does not have, or has in the list by another choice. */
bool drivers_add(struct driver_list *to, const char *library, const char *renderer, bool new_only,
                 struct error *err);
/* Adds OSMesa, EGL, and each of EGL's devices, with each driver of Mesa's, with and without
 * shaders, but none twice. The caller always frees the list. */
bool drivers_list(struct driver_list *to, struct error *err);
/* Writes the options: "--gl egl --renderer softpipe". */
void driver_options(const struct listed_driver *driver, char out[64]);
/* Returns the name of the profile by which a render judges a driver; "" for one that is not usable.
 */
const char *driver_profile(const struct listed_driver *driver);

#endif
