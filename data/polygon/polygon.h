/* SPDX-License-Identifier: MIT */
/* The room "polygon": faces of any number of corners, and their cutting into triangles. */
#ifndef POLYGON_H
#define POLYGON_H

#include "data/maths/maths.h"
#include "spectral.h"

bool same_place(struct vector a, struct vector b);
/* The unit normal by Newell's sum; (0,0,0) where the area is within rounding of 0. */
struct vector polygon_normal(const struct vector *ring, int n);
/* The interior angle at ring[i], 0 to 2 pi, seen against the normal. Neighbours differ. */
double polygon_angle(const struct vector *ring, int n, int i, struct vector normal);

struct cutter { /* working memory, for faces of up to so many corners */
    struct cutter_node *nodes;
    struct blockers *blockers;
    int32_t (*triangles)[3]; /* the result: indices into the ring */
    int n_triangles;
    double noise; /* rounding has moved a corner by at most so much in the plane of the polygon */
};
bool cutter_open(struct cutter *out, int corners, struct error *err);
/* Cuts the polygon, concave or not, into at most n - 2 triangles of the same orientation. Leaves
 * out triangles with two corners at one place. A polygon without area becomes a fan. */
void cutter_run(struct cutter *cutter, const struct vector *ring, int n);
void cutter_free(struct cutter *cutter);

#endif
