/* SPDX-License-Identifier: MIT */
/* What the files behind mesh_read share: obj.c reads statements, polygon.c cuts faces,
 * mesh.c makes vertices of them. Nobody else includes this. */
#ifndef MESH_H
#define MESH_H

#include "spectral.h"

/* ---- data/obj.c: the statements of a Wavefront OBJ file ---- */

enum { POINT, TEXTURE, NORMAL };

struct obj_corner {
    int32_t index[3]; /* into the lists, from 0; -1: none */
};
struct obj_list {
    struct vector *at;
    int n;
};
struct obj_face {
    int32_t end;  /* its corners reach up to here, from where those of the face before it end */
    int32_t name; /* index of its usemtl */
};
/* Neighbouring corners of a face lie at different places, and a face has at least 3. All counts are
 * below 2^30, since the file is shorter than 2^31 bytes. */
struct obj {
    struct obj_list list[3]; /* POINT, TEXTURE; NORMAL, of unit length or 0 0 0 */
    struct obj_corner *corners;
    struct obj_face *faces;
    char **names; /* of usemtl, in order of first use by a face; "" before the first; owned */
    int n_corners, n_faces, n_names;
    struct word material; /* the latest usemtl, while the file is read */
    int32_t name;         /* its index; -1: not used yet */
    bool lacks_normals;   /* perhaps: some corner has none */
};

/* Reads and checks the file; one without any face is refused. */
bool obj_read(const char *path, struct place from, struct obj *out, struct error *err);
bool obj_add(struct obj_list *list, struct vector item, struct error *err);
void obj_free(struct obj *obj);

/* ---- data/polygon.c: faces of any size ---- */

bool same_place(struct vector a, struct vector b);
/* The unit normal by Newell's sum; (0,0,0) where the area is within rounding of 0. */
struct vector polygon_normal(const struct vector *ring, int n);
/* The interior angle at ring[i], 0..2 pi, seen against the normal. Neighbours differ. */
double polygon_angle(const struct vector *ring, int n, int i, struct vector normal);

struct cutter_node;
struct cutter { /* working memory, for faces of up to so many corners */
    struct cutter_node *nodes;
    int32_t *blockers;
    int32_t (*triangles)[3]; /* the result: indices into the ring */
    int n_blockers, n_triangles;
    double noise; /* how far rounding may have moved a corner in the polygon's plane */
};
bool cutter_open(struct cutter *out, int corners, struct error *err);
/* At most n - 2 triangles with the ring's orientation that fill the polygon, concave or not; those
 * with two corners at one place are left out. One without area becomes a fan. */
void cutter_run(struct cutter *cutter, const struct vector *ring, int n);
void cutter_free(struct cutter *cutter);

#endif
