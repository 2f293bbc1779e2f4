/* SPDX-License-Identifier: MIT */
/* What the files behind mesh_read share: obj.c reads statements, polygon.c cuts faces,
 * mesh.c makes vertices of them. Nobody else includes this. */
#ifndef MESH_H
#define MESH_H

#include "spectral.h"

/* ---- data/obj.c: the statements of a Wavefront OBJ file ---- */

struct obj_corner {
    int32_t point, texture, normal; /* from 0; -1: none */
};
/* Neighbouring corners of a face lie at different places, and a face has at least 3. */
struct obj {
    struct vector *points, *normals; /* normals of unit length or 0 0 0 */
    double (*textures)[2];
    struct obj_corner *corners;
    int32_t *face_ends; /* face i has the corners up to face_ends[i], from where face i - 1 ends */
    size_t n_points, n_normals, n_textures, n_corners, n_faces;
    size_t room_points, room_normals, room_textures, room_corners, room_faces;
};

/* Reads and checks the file; one without any face is refused. All counts are below 2^31. */
bool obj_read(const char *path, struct place from, struct obj *out, struct error *err);
bool obj_add_normal(struct obj *obj, struct vector normal, struct error *err);
void obj_free(struct obj *obj);

/* ---- data/polygon.c: faces of any size ---- */

/* The unit normal by Newell's sum; (0,0,0) where the area is within rounding of 0. */
struct vector polygon_normal(const struct vector *ring, int n);
/* The interior angle at ring[i], 0..2 pi, seen against the normal. Neighbours differ. */
double polygon_angle(const struct vector *ring, int n, int i, struct vector normal);

struct cutter_node;
struct cutter { /* working memory, for faces of up to so many corners */
    struct cutter_node *nodes;
    int32_t *queue, *blockers;
    int32_t (*triangles)[3]; /* the result: indices into the ring */
    int n_triangles;
    double noise; /* how far rounding may have moved a corner in the polygon's plane */
};
bool cutter_open(struct cutter *out, size_t corners, struct error *err);
/* At most n - 2 triangles with the ring's orientation that fill the polygon, concave or not; those
 * with two corners at one place are left out. One without area becomes a fan. */
void cutter_run(struct cutter *cutter, const struct vector *ring, int n);
void cutter_free(struct cutter *cutter);

#endif
