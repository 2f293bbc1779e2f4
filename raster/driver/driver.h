/* SPDX-License-Identifier: MIT */
/* Lists the known properties of each implementation of OpenGL. Bounds, candidates and check read
 * it. */
#ifndef DRIVER_H
#define DRIVER_H

#include "spectral.h"

/* The rule that gives a pixel to a triangle when its centre lies exactly on an edge. */
enum fill_rule { FILL_ANY, FILL_LEFT_BOTTOM };
struct driver {
    const char *name; /* what GL_RENDERER begins with; "unknown": the worst of all others;
                         "measured": see raster/traits */
    bool is_measured;
    double grid_px; /* corners are moved to a grid before edges are followed: by up to this */
    double edge_roundings;  /* of the largest window coordinate, while an edge is followed */
    double depth_roundings; /* of a depth of 1, while it is stored: half is a step of 24 bits */
    double value_roundings; /* of a plane at a pixel, relative to its value there */
    double corner_px;       /* planes of values run through corners that are moved by up to this */
    double filter_texels;   /* linear filtering mixes as for a place that is off by up to this */
    double lighting;        /* errors of lighting are at most so many times Mesa's */
    bool left_origin;       /* planes of values begin at the left of the picture */
    bool watertight;        /* a pixel where triangles meet belongs to exactly one of them */
    enum fill_rule fill_rule;
};
/* NULL stands for an unknown one. */
const struct driver *driver_of(const char *gl_renderer);

/* Writes the properties of a driver in words. */
enum { DRIVER_WORDS = 160 };
void driver_print(const struct driver *driver, char out[DRIVER_WORDS]);

/* The way in which OpenGL draws: with lighting of its own (OpenGL 1.x); with our shaders, by OpenGL
 * 3.3 core or by OpenGL ES 3.0. */
enum gl_way { GL_WITHOUT_SHADERS, GL_CORE, GL_ES };
/* choice.c. Accepts the words of --renderer: "gl", "llvmpipe", "softpipe", "raster"; "gl-shader"
 * and "es-shader", alone or with ":llvmpipe" or ":softpipe". */
bool driver_accepts_renderer(const char *option, const char *value, struct error *err);
/* Returns the way of such a word, NULL: none was given. *driver: Mesa's; NULL: any. */
enum gl_way driver_way(const char *renderer, const char **driver);
/* Accepts the words of --gl: "osmesa", "egl", "egl:N", "auto". */
bool driver_accepts_library(const char *option, const char *value, struct error *err);
int driver_device(const char *library); /* N of "egl:N"; -1 of other words */

/* threads.c. Threads of this process: of llvmpipe, and those that have this thread's name, which a
 * new thread has until it takes its own. */
struct driver_threads {
    long of_llvmpipe, unnamed;
};
/* Returns false where they cannot be counted. */
bool driver_count_threads(struct driver_threads *out);
/* Refuses a driver that has fewer threads than it has asked for. Where the system gives llvmpipe
 * fewer, Mesa 22.3.6 goes on, and then waits for ever: its fences count the threads that were asked
 * for (lp_fence_create in lp_setup.c). `before`: counted before the first context. */
bool driver_has_threads(const char *gl_renderer, const struct driver_threads *before,
                        struct error *err);

#endif
