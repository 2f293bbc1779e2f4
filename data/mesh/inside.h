/* SPDX-License-Identifier: MIT */
/* Only the files of the room "mesh" include this. */
#ifndef DATA_MESH_INSIDE_H
#define DATA_MESH_INSIDE_H

#include "data/mesh/mesh.h"

bool same_place(struct vector a, struct vector b);
/* The unit normal by Newell's sum; (0,0,0) where the area is within rounding of 0. */
struct vector polygon_normal(const struct vector *ring, int n);
/* The interior angle at ring[i], 0 to 2 pi, seen against the normal. Neighbours differ. */
double polygon_angle(const struct vector *ring, int n, int i, struct vector normal);

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

/* ---- mesh.c: triangles ---- */

/* Makes room for so many more vertices and triangles; *mesh keeps its content. A second call before
 * the room is filled must ask for the rest of it again; 0, 0 gives back all unused room. Fails with
 * EXIT_SYSTEM. */
bool mesh_reserve(struct mesh *mesh, size_t n_vertices, size_t n_triangles, struct error *err);
/* Does the same for the mesh of a shape. Refuses one that, planned and drawn, would need more
 * memory than is left. */
bool mesh_begin(struct mesh *mesh, size_t n_vertices, size_t n_triangles, struct error *err);
/* Counting sort of the numbers from 0 to n - 1 by their keys, which stand `step` numbers apart and
 * are below n_keys. Numbers of one key keep their order. starts[k], zeroed before and n_keys + 1
 * long, is first the end of those of key k, and at last their begin. */
void sort_by_key(const int32_t *key, size_t step, int n, int n_keys, int32_t *starts,
                 int32_t *order);
/* Reads a Wavefront OBJ file: v, vt, vn, f and usemtl. Skips other known statements, refuses
 * unknown and malformed ones. Cuts faces of any size, concave ones too, into triangles. A corner
 * without vn gets the mean normal of its face and of the faces there that meet it at less than
 * crease_deg, weighted by their angles; a face without area has no weight. A corner without vt gets
 * planar coordinates, as by mesh_planar. With unitize, the mesh is first moved and scaled into the
 * cube [-1, 1]^3. `from` is the place that names the file. */
bool mesh_read(const char *path, struct place from, bool unitize, double crease_deg,
               struct mesh *out, struct error *err);

/* obj.c: the statements of a Wavefront OBJ file. */

enum { OBJ_POINT, OBJ_TEXTURE, OBJ_NORMAL };

struct obj_corner {
    int32_t index[3]; /* into the lists, from 0; -1: none */
    int32_t face;
    /* The normal of the whole face, and the angle of the face here: mesh.c sets them if normals are
     * lacking. A face without area has 0 0 0 and 0, and so no weight in any mean. */
    struct vector normal;
    double angle;
};
struct obj_list {
    struct vector *at;
    int n;
};
struct obj_face {
    int32_t first, n; /* of its corners */
    int32_t name;     /* index of its usemtl */
};
/* A face has at least 3 corners, and neighbouring ones lie at different places. All counts are
 * below 2^30, since the file is shorter than 2^31 bytes. */
struct obj {
    struct obj_list list[3]; /* OBJ_POINT, OBJ_TEXTURE; OBJ_NORMAL, of unit length or 0 0 0 */
    struct obj_corner *corners;
    struct obj_face *faces;
    char **names; /* of usemtl, in order of first use by a face; "" before the first; owned */
    struct index places; /* of the names */
    int n_corners, n_faces, n_names;
    bool lacks_normals; /* some corner of a face has none */
    /* While the file is read: a face's name is the index of its usemtl here; index 0: none. */
    struct word *uses;
    int n_uses;
    struct obj_latest {
        int32_t end; /* behind the last item that a face has used */
        struct place place;
    } latest[3]; /* of each list */
};

/* Reads and checks the file. Refuses one without any face. */
bool obj_read(const char *path, struct place from, struct obj *out, struct error *err);
struct vector obj_point(const struct obj *obj, int corner); /* the place of a corner */
void obj_free(struct obj *obj);

/* normals.c: computes the normals that corners lack, and adds them to the list. The corners of a
 * point are order[starts[point]] up to before order[starts[point + 1]], and increase. */
bool normals_fill(struct obj *obj, const int32_t *order, const int32_t *starts, double crease_deg,
                  struct error *err);

#endif
