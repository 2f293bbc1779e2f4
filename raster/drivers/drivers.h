/* SPDX-License-Identifier: MIT */
/* The room "drivers": what OpenGL can draw on this system. */
#ifndef DRIVERS_H
#define DRIVERS_H

#include "data/options/options.h"
#include "spectral.h"

/* ---- command.c: spectral drivers ---- */

/* Prints each library and driver that can be used, and each library that cannot; with --measure how
 * it draws. Fails with EXIT_SYSTEM if none can. */
bool command_drivers(struct options *options, struct error *err);

/* ---- list.c: inside this room ---- */

struct context_description;
struct traits;

/* A library and a driver, as the options --gl and --renderer name them. */
struct listed_driver {
    char library[16];
    const char *renderer;           /* NULL: the one that comes without --renderer */
    struct context_description *is; /* NULL: it is not usable; owned */
    char reason[512];               /* why not, in a line */
    struct traits *traits;          /* NULL: not measured; owned */
};
struct driver_list {
    struct listed_driver *list; /* owned */
    int n;
};
/* Tries OSMesa, EGL, and each of EGL's devices, with each driver of Mesa's, with and without
 * shaders, in processes of their own. Leaves out a driver that a library does not have, or has
 * without being asked for it. The caller always frees *out. */
bool drivers_list(struct driver_list *out, struct error *err);
/* Measures each one that is usable: see raster/traits. */
bool drivers_measure(struct driver_list *drivers, struct error *err);
void drivers_free(struct driver_list *drivers);

#endif
