/* SPDX-License-Identifier: MIT */
/* The room "mesh": triangles from Wavefront OBJ files, polygons and the shapes of the scene
 * language, and the surfaces that the triangles of built-in shapes approximate. */
#ifndef DATA_MESH_MESH_H
#define DATA_MESH_MESH_H

#include "data/text/text.h"

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
    bool untextured;    /* of a file: some corner has no texture coordinates of its own */
    int32_t *part;      /* of each triangle; NULL: all are part 0 */
    char **part_names;  /* of a file: the usemtl of each part, "" before the first one */
    int n_parts;        /* at least 1 */
    struct place place; /* that names its shape; for messages */
    /* Once mesh_part has asked, the triangles of part p: triangles[first[p]] up to before
     * triangles[first[p + 1]]. */
    struct division {
        int32_t *triangles, *first; /* owned */
        int32_t *number; /* of each vertex in the part that is taken out; otherwise -1; NULL: nobody
                            has asked yet; owned */
    } division;
};

/* Finds the bounding box. Without vertices *low is HUGE_VAL and *high -HUGE_VAL. */
void mesh_box(const struct mesh *mesh, struct vector *low, struct vector *high);
/* Sets texture coordinates, 0 to 1, from x and y in the bounding box of the mesh. */
void mesh_planar(struct mesh *mesh);
/* Lets a texture fit so often along s and t: multiplies them. Then brings them near 0, where single
 * precision has most digits: halves edges until no triangle has the texture more than eight times,
 * up to six times; and moves the coordinates of each triangle by whole numbers, which changes no
 * texture, since it repeats. A vertex that triangles need at several places is copied. */
bool mesh_repeat_texture(struct mesh *mesh, const double repeat[2], struct error *err);
void mesh_free(struct mesh *mesh);

/* ---- split.c: parts of a mesh, and of its edges ---- */

/* Cuts all triangles that cross x = 0 there, and makes two parts: 0 at negative x, 1 at positive x.
 * New vertices lie at exactly x = 0, with the same bits on both sides and in neighbouring
 * triangles, so that no crack opens. The parts and names of *from are lost. */
bool mesh_cut(const struct mesh *from, struct mesh *out, struct error *err);
/* Halves all edges of a mesh, so that each triangle becomes four. The middle of an edge
 * depends on its ends alone: no crack opens. Keeps parts. */
bool mesh_halve(struct mesh *mesh, struct error *err);
/* Makes a mesh of the triangles of one part, with their vertices in the order of first use. It may
 * be empty: n_triangles 0. -1, or a mesh without parts: copies all. */
bool mesh_part(struct mesh *from, int part, struct mesh *out, struct error *err);

/* ---- displace.c: reliefs ---- */

/* Moves each vertex along its normal by its height, in units of the mesh. Vertices at one place
 * stay together, so that a closed mesh stays closed: they move by the mean of their heights along
 * the mean of their normals. Each of different normals counts once there, and opposite ones cancel.
 * Then turns the normals as much as the faces around them have turned; those that were equal at one
 * place stay so, and creases stay creases. The mesh is parametric no more. */
bool mesh_displace(struct mesh *mesh, const double *heights, struct error *err);

/* ---- shape.c: the words of the scene language ---- */

/* The table in shape.c has their words and sizes. A plane and a disk face +z. */
enum shape_kind {
    SHAPE_SPHERE,
    SHAPE_TORUS,
    SHAPE_BOX,
    SHAPE_PLANE,
    SHAPE_CYLINDER,
    SHAPE_CONE,
    SHAPE_DISK,
    SHAPE_TEAPOT,
    SHAPE_MESH /* an OBJ file */
};
struct shape {
    enum shape_kind kind;
    double parameter[4]; /* the sizes; 0 behind the last one */
    char *path;          /* SHAPE_MESH; owned */
    bool unitize;
    double crease_deg;    /* 90 by default */
    bool planar;          /* texture coordinates by mesh_planar */
    double repeat[2];     /* how often a texture or a relief fits along s and t; 1 1 by default */
    char *relief;         /* a picture that displaces the vertices; owned; NULL: none */
    double relief_height; /* of its value 1 */
    struct place relief_place;
    struct place place;
};
const char *shape_name(enum shape_kind kind); /* the scene language's word */
/* Prints the word of a built-in shape, its sizes, and what they are where they are left out. */
void shape_print_signature(enum shape_kind kind, struct printed *to);
/* Returns whether the mesh of the shape is a solid: it has no border, since each edge of a triangle
 * is, the other way round, one of another triangle. Of an OBJ file that is not known: it may have
 * faces inside out, even where it is closed. The spout of the teapot is open. */
bool shape_is_solid(enum shape_kind kind);
/* Reads a shape's word and sizes, or `mesh` and a file. Sizes that are left out and the other
 * members get their defaults. */
bool shape_read(struct text *text, struct shape *out, struct error *err);
/* Returns the shape with `factor` times as many slices, stacks, ...: rounded, and kept within the
 * range that shape_read accepts. The result shares what *shape owns and is not to be freed. */
struct shape shape_tessellated(const struct shape *shape, double factor);
void shape_free(struct shape *shape);

/* ---- patches.c: the surface of a built-in shape ---- */

/* A shape is made of parametric patches. u and v count cells from 0 to patch_cells, as the slices
 * and stacks of the shape. Where patches meet, equal places have equal bits. */
struct patches {
    const struct shape *shape;
    struct teapot_patch *teapot; /* owned; NULL: another shape */
};
/* Opens the surface of a shape, which must outlive it; of a mesh nothing. The caller always closes
 * it. Fails only where the system does. */
bool patches_open(const struct shape *shape, struct patches *out, struct error *err);
void patches_close(struct patches *patches);
/* Returns whether a patch is flat, so that its triangles are exact but at a round rim. */
bool patch_is_flat(const struct shape *shape, int patch);
/* Brings parameters that have left a curved patch back into it: around where it is closed,
 * otherwise to its border. */
void patch_enter(const struct shape *shape, double *u, double *v);
/* Returns the place on a patch, rounded to 2^-18 of a cell, with its outward normal. */
struct vertex patch_vertex(const struct patches *patches, int patch, double u, double v);

/* Builds the mesh of a shape: watertight where the solid is, normals outward. Reads a mesh file. */
bool shape_build(const struct shape *shape, struct mesh *out, struct error *err);

#endif
