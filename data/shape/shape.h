/* SPDX-License-Identifier: MIT */
/* The room "shape": the shapes of the scene language as triangles, and the surfaces that the
 * triangles of built-in shapes approximate. */
#ifndef SHAPE_H
#define SHAPE_H

#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "data/names/names.h"
#include "data/text/text.h"
#include "spectral.h"

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
    double crease_deg; /* 90 by default */
    bool planar;       /* texture coordinates by mesh_planar */
    double repeat[2];  /* how often a texture fits along s and t; 1 1 by default */
    struct place place;
};
const char *shape_name(enum shape_kind kind); /* the scene language's word */
/* Prints the word of a built-in shape, its sizes, and what they are where they are left out. */
void shape_print_signature(enum shape_kind kind, struct printed *to);
/* Returns whether all faces of the shape are flat. The rim of a disk is round all the same. */
bool shape_is_flat(enum shape_kind kind);
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

/* ---- build.c: the triangles of a shape ---- */

/* Builds the mesh of a shape: watertight where the solid is, normals outward. Reads a mesh file. */
bool shape_build(const struct shape *shape, struct mesh *out, struct error *err);

/* Lets a texture fit as often as the shape says: multiplies s and t. */
void shape_repeat_texture(const struct shape *shape, struct mesh *mesh);

/* ---- Inside this room ---- */

/* teapot.c: the 32 bicubic Bézier patches of the Utah teapot. */
enum { TEAPOT_PATCHES = 32 };
struct teapot_patch {
    struct vector point[16];
    bool pole; /* its first row is one point */
};
/* Returns the patches, allocated; NULL after an error. */
struct teapot_patch *teapot_read(struct place from, struct error *err);
/* Returns the place at row/count and column/count of a patch. */
struct vertex teapot_vertex(const struct teapot_patch *patch, double size, double column,
                            double row, double count);

#endif
