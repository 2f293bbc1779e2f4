/* SPDX-License-Identifier: MIT */
/* The room "vertices": meshes in OpenGL's buffer objects, and triangles that are drawn in numbers.
 * Rooms that draw a plan through OpenGL share it, so that all give OpenGL the same vertices. */
#ifndef VERTICES_H
#define VERTICES_H

#include "raster/bounds/bounds.h"
#include "raster/plan/plan.h"
#include "spectral.h"

struct gl_functions;

/* ---- buffers.c ---- */

/* Floats of a vertex in its two buffers: position and normal; texture coordinates, which only
 * textured meshes have. */
enum { VERTEX_FLOATS = 6, COORDINATE_FLOATS = 2 };
/* Nothing is uploaded twice, and nothing of an instance out of view. */
struct vertex_buffers {
    const struct gl_functions *call;
    const struct plan *plan;
    const struct lit_scene *lit;
    unsigned *objects; /* names of the buffer objects: some for each mesh; 0: not in view */
    unsigned *indices; /* of triangles: each mesh's, then those of instances that hide some */
};
/* Uploads vertices and triangles for OpenGL's current context. All three must outlive *out.
 * vertex_buffers_free accepts what a failure left; the names end with their context. */
bool vertex_buffers_fill(const struct gl_functions *call, const struct lit_scene *lit,
                         struct vertex_buffers *out, struct error *err);
void vertex_buffers_free(struct vertex_buffers *buffers);
/* Binds the triangles of an instance. Returns how many corners they have. */
int vertex_buffers_bind(const struct vertex_buffers *of, int instance);
/* Bind the buffer of positions and normals, and that of texture coordinates; the latter returns
 * false where the instance shows no texture. */
void vertex_buffers_bind_vertices(const struct vertex_buffers *of, int instance);
bool vertex_buffers_bind_coordinates(const struct vertex_buffers *of, int instance);

/* ---- numbers.c ---- */

/* A corner of a triangle that is drawn in its number: see shown_of. */
struct numbered_vertex {
    float position[3], number[3];
};
/* Gives the triangles of an instance that are not hidden to `draw`, some at a time. */
bool numbered_draw(const struct lit_scene *lit, int instance,
                   void (*draw)(void *of, const struct numbered_vertex *corners, int n), void *of,
                   struct error *err);

#endif
