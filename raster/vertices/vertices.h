/* SPDX-License-Identifier: MIT */
/* The room "vertices": what rooms that draw a plan through OpenGL share: the driver that is
 * accepted, meshes in buffer objects, textures, and triangles that are drawn in numbers. */
#ifndef VERTICES_H
#define VERTICES_H

#include "raster/bounds/bounds.h"
#include "raster/driver/driver.h"
#include "raster/plan/plan.h"
#include "raster/renderer/renderer.h"
#include "spectral.h"

struct contexts;
struct gl_functions;

/* ---- opened.c ---- */

/* Takes the names of what draws the plan, and the bounds by which it is judged: an unknown driver
 * is measured first. A canvas is in use. Refuses what contexts_accept and driver_has_threads
 * refuse. The bounds of raster/bounds hold for the shaders of a known driver as for its own
 * lighting: the shaders do the same operations, and both measure the same (test/run/traits.py). */
bool opened_accept(struct renderer *renderer, const struct plan *plan, struct contexts *contexts,
                   const struct driver_threads *before, struct error *err);
/* Returns what the pixel x, y of a tile of the plan's size shows: numbers from the top, depths
 * (NULL: none) from the bottom unless `flipped`. */
struct shown shown_at(const struct plan *plan, const float *numbers, const uint32_t *depths,
                      bool flipped, int x, int y);

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

/* ---- textures.c ---- */

/* Refuses a texture that is too large for OpenGL. */
bool texture_fits(const struct gl_functions *call, const struct texture *texture,
                  struct error *err);
/* Sets filter and repetition of the bound texture. */
void texture_repeats(const struct gl_functions *call, const struct texture *texture);
/* Uploads the texels of a spectral texture for the bands of a pass into the bound texture. */
bool texture_upload_bands(const struct gl_functions *call, const struct plan *plan,
                          struct texture *texture, int first_band, struct error *err);

/* ---- numbers.c ---- */

/* A corner of a triangle that is drawn in its number: see shown_of. */
struct numbered_vertex {
    float position[3], number[3];
};
/* Draws all instances that reach a tile: places each, and gives its triangles that are not hidden
 * to `draw`, some at a time. */
struct numbered_draw {
    void (*place)(void *of, int instance);
    void (*draw)(void *of, const struct numbered_vertex *corners, int n);
    void *of;
};
bool numbers_draw(const struct lit_scene *lit, const struct rectangle *tile,
                  const struct numbered_draw *by, struct error *err);

#endif
