/* SPDX-License-Identifier: MIT */
/* The room "mesh": triangles, Wavefront OBJ files. */
#ifndef MESH_H
#define MESH_H

#include "data/index/index.h"
#include "data/maths/maths.h"
#include "data/names/names.h"
#include "data/polygon/polygon.h"
#include "spectral.h"

/* ---- mesh.c: triangles ---- */

/* Where a vertex lies on the surface that its mesh approximates: on a patch, in cells. */
enum { PARAMETER_CELL = 1 << 16 };
struct parameters {
    int32_t patch, u, v; /* u and v: times PARAMETER_CELL */
};
struct mesh {
    struct vertex *vertices;
    struct parameters *parameters; /* of each vertex, if the mesh is parametric */
    bool parametric;
    int32_t (*triangles)[3]; /* counter-clockwise seen from outside */
    int n_vertices, n_triangles;
    int32_t *part;      /* of each triangle; NULL: all are part 0 */
    char **part_names;  /* the usemtl of each part, "" before the first one; NULL: no names */
    int n_parts;        /* at least 1 */
    struct place place; /* that names its shape; for messages */
    struct division *division; /* the triangles of each part, once mesh_part has asked; owned */
};

/* Makes room for so many more vertices and triangles; *mesh keeps its content. A second call before
 * the room is filled must ask for the rest of it again; 0, 0 gives back all unused room. Fails with
 * EXIT_SYSTEM. */
bool mesh_reserve(struct mesh *mesh, size_t n_vertices, size_t n_triangles, struct error *err);
/* Does the same for the mesh of a shape. Refuses one that, planned and drawn, would need more
 * memory than is left. */
bool mesh_begin(struct mesh *mesh, size_t n_vertices, size_t n_triangles, struct error *err);
/* Reads a Wavefront OBJ file: v, vt, vn, f and usemtl. Skips other known statements, refuses
 * unknown and malformed ones. Cuts faces of any size, concave ones too, into triangles. A corner
 * without vn gets the mean normal of its face and of the faces there that meet it at less than
 * crease_deg, weighted by their angles; a face without area has no weight. A corner without vt gets
 * planar coordinates, as by mesh_planar. With unitize, the mesh is first moved and scaled into the
 * cube [-1, 1]^3. `from` is the place that names the file. */
bool mesh_read(const char *path, struct place from, bool unitize, double crease_deg,
               struct mesh *out, struct error *err);
/* Finds the bounding box. Without vertices *low is HUGE_VAL and *high -HUGE_VAL. */
void mesh_box(const struct mesh *mesh, struct vector *low, struct vector *high);
/* Sets texture coordinates, 0 to 1, from x and y in the bounding box of the mesh. */
void mesh_planar(struct mesh *mesh);
void mesh_free(struct mesh *mesh);

/* closed.c. Finds whether each edge of each triangle is, the other way round, one of another
 * triangle: the mesh has no border. A mesh with a border is taken for a closed one with a chance of
 * 2^-64. */
bool mesh_find_closed(const struct mesh *mesh, bool *closed, struct error *err);

/* ---- split.c: parts of a mesh, and of its edges ---- */
/* Cuts all triangles that cross x = 0 there, and makes two parts: 0 at negative x, 1 at positive x.
 * New vertices lie at exactly x = 0, with the same bits on both sides and in neighbouring
 * triangles, so that no crack opens. The parts and names of *from are lost. */
bool mesh_cut(const struct mesh *from, struct mesh *out, struct error *err);
/* Halves all edges of a mesh of a file, so that each triangle becomes four. The middle of an edge
 * depends on its ends alone: no crack opens. Keeps parts. */
bool mesh_halve(struct mesh *mesh, struct error *err);
/* Makes a mesh of the triangles of one part (-1: of all), with the vertices that they use, in their
 * order. It may be empty: n_triangles 0. */
bool mesh_part(struct mesh *from, int part, struct mesh *out, struct error *err);

/* ---- Inside this room ---- */

void division_free(struct division *division); /* in split.c; NULL is fine */

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
    struct word material; /* the latest usemtl, while the file is read */
    int32_t name;         /* its index; -1: not used yet */
    bool lacks_normals;   /* some corner that was read has none */
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
