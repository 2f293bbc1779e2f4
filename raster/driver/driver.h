/* SPDX-License-Identifier: MIT */
/* Lists the known properties of each implementation of OpenGL. Bounds, candidates and check read
 * it. */
#ifndef DRIVER_H
#define DRIVER_H

#include <stdbool.h>

/* The rule that gives a pixel to a triangle when its centre lies exactly on an edge. */
enum fill_rule { FILL_ANY, FILL_LEFT_BOTTOM };
struct driver {
    const char *name; /* what GL_RENDERER begins with; "unknown": the worst of all others */
    double grid_px;   /* corners are moved to a grid before edges are followed: by up to this */
    double edge_roundings;  /* of the largest window coordinate, while an edge is followed */
    double depth_roundings; /* of a depth of 1, while it is stored: half is a step of 24 bits */
    double value_roundings; /* of a plane at a pixel, relative to its value there */
    bool watertight;        /* a pixel where triangles meet belongs to exactly one of them */
    enum fill_rule fill_rule;
};
/* NULL stands for an unknown one. */
const struct driver *driver_of(const char *gl_renderer);

#endif
