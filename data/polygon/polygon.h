/* SPDX-License-Identifier: MIT */
/* The room "polygon": faces of several corners, and their cutting into triangles. */
#ifndef POLYGON_H
#define POLYGON_H

#include "data/maths/maths.h"
#include "spectral.h"

bool same_place(struct vector a, struct vector b);
/* The unit normal by Newell's sum; (0,0,0) where the area is within rounding of 0. */
struct vector polygon_normal(const struct vector *ring, int n);
/* The interior angle at ring[i], 0 to 2 pi, seen against the normal. Neighbours differ. */
double polygon_angle(const struct vector *ring, int n, int i, struct vector normal);

enum { LONGEST_FACE = 10000 }; /* in corners; cutting takes seconds at most */
/* A corner of the rest of the polygon, a ring that shrinks ear by ear. */
struct cutter_node {
    double x, y; /* in the plane of the polygon, which is counter-clockwise there */
    int32_t previous, next;
    bool convex, candidate; /* candidate: may be an ear */
};
struct cutter {
    struct vector ring[LONGEST_FACE];   /* the caller fills it */
    int32_t triangles[LONGEST_FACE][3]; /* the result: indices into the ring */
    int n_triangles;
    struct cutter_node nodes[LONGEST_FACE];
    double noise; /* rounding has moved a corner by at most so much in the plane of the polygon */
};
/* Cuts the polygon of the first n places of the ring, concave or not, into at most n - 2 triangles
 * of the same orientation. Leaves out triangles with two corners at one place. A polygon without
 * area becomes a fan. */
void cutter_run(struct cutter *cutter, int n);

#endif
