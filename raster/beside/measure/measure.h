/* SPDX-License-Identifier: MIT */
/* The room "measure": what OpenGL can draw on this system, and how far a driver that is not known
 * goes in what the specification (of OpenGL 2.1) leaves free. It draws the targets, a built-in
 * scene of small triangles, as any scene; its profile is the narrowest one that explains them.
 * Bounds then come from the specification and from the targets, never from the scene under test. */
#ifndef RASTER_BESIDE_MEASURE_MEASURE_H
#define RASTER_BESIDE_MEASURE_MEASURE_H

#include "raster/render/render.h"

/* ---- targets.c ---- */

/* Reads and plans the scene of the targets, with textures or not, to be drawn by the OpenGL that
 * `by` asks for; NULL: by another program. The caller frees the job, also after a failure. */
bool targets_plan(const struct plan_options *by, bool textured, struct render_job *job,
                  struct error *err);
/* Measures the driver that draws the targets, or drew them: opens the source, once, as a renderer
 * of their plan. *out comes in as a known driver, whose rule for the level of detail is found, or
 * as driver_of(NULL). Fails with EXIT_SYSTEM, and the first pixel, where the targets differ by more
 * than OpenGL leaves free. */
bool targets_measure(const struct render_foreign *source, const struct plan_options *by,
                     struct driver *out, struct error *err);
/* Writes what was measured of a driver as numbers: its traits, whether it is watertight, its rule
 * for levels of detail (-1: any). Reads them again, as a driver that was measured before; refuses
 * traits beyond those that a measured one can have. */
void traits_numbers(const struct driver *of, struct printed *to);
bool traits_read(struct text *text, struct driver *out, struct error *err);
/* Measures the driver that draws here: see struct drawing_ways. */
bool driver_measure(const struct plan_options *by, struct driver *out, struct error *err);

/* ---- command.c: spectral drivers ---- */

/* Prints each library and driver that can be used, and each library that cannot; with -v how
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
