/* SPDX-License-Identifier: MIT */
/* Draws the plan's picture through OpenGL, a tile and a pass at a time, and says which triangle
 * OpenGL shows at each pixel. Only this room includes a GL header. It may not know what the
 * reference shows: of lit scenes it reads only where each surface lies in the window, so that it
 * draws nothing that a tile cannot show. */
#ifndef GL_H
#define GL_H

#include "data/maths/maths.h"
#include "data/texture/texture.h"
#include "raster/bounds/bounds.h"
#include "raster/passes/passes.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- context.c: OSMesa's contexts and their buffers ---- */

struct gl;
/* Returns false in a program without OpenGL, where gl_open always fails. */
bool gl_is_built(void);
/* Writes name, version and driver of the OSMesa in use. */
void gl_library(char *out, size_t capacity);
/* Opens OpenGL for a plan, which must outlive *out.
 * n_buffers: of gl_draw, at most MOST_BUFFERS. Fails with EXIT_SYSTEM where there is no usable
 * OpenGL, or not the driver that the plan asks for. Afterwards gl_close frees *out, also after a
 * failure. One struct gl can be open at a time; the thread that opens it draws. */
enum { MOST_BUFFERS = 8 };
bool gl_open(const struct plan *plan, int n_buffers, struct gl **out, struct error *err);
void gl_close(struct gl *gl); /* NULL is fine */
struct gl_names {
    char renderer[128], version[128]; /* GL_RENDERER and GL_VERSION; empty: OpenGL is not open */
};
struct gl_names gl_names(const struct gl *gl);

/* ---- upload.c: meshes and textures ---- */

/* Takes the lit scene of the plan, before the first gl_aim, and uploads the vertices, triangles and
 * textures that are drawn; of spectral textures no texels. It must outlive gl. */
bool gl_take_scene(struct gl *gl, const struct lit_scene *lit, struct error *err);

/* ---- pass.c: lights, materials and passes ---- */

/* Aims at a tile of the picture, of at most the plan's tile size in pixels. */
void gl_aim(struct gl *gl, const struct rectangle *tile);
/* Draws bands first_band .. first_band + BANDS_PER_PASS - 1 (those that exist) of the aimed tile
 * into a buffer. Where the plan asks for a check, gl_identify has drawn the tile before. */
bool gl_draw(struct gl *gl, int buffer, int first_band, double full_scale, struct error *err);
/* Returns what was last drawn into the buffer: radiances divided by full_scale, rounded to the
 * nearest step where the colour buffer has steps; 4 floats a pixel, rows of the plan's tile_width
 * from the top. Other threads may read it until something is drawn there again. */
const float *gl_pixels(const struct gl *gl, int buffer);
struct gl_work {
    long passes, draw_calls;
};
/* Returns the work of all gl_draw so far. */
struct gl_work gl_work(const struct gl *gl);

/* ---- identify.c: which triangle OpenGL shows ---- */

/* The nearest fragment of a pixel, as OpenGL draws it. */
struct shown {
    int32_t surface, triangle; /* -1: background */
    uint32_t depth;            /* in steps of 1 / (2^24 - 1) */
    uint8_t fragments;         /* drawn there, hidden ones too, modulo 256 */
};
/* Draws the numbers of surfaces and triangles of the aimed tile instead of their colours. The plan
 * asks for a check. */
bool gl_identify(struct gl *gl, struct error *err);
/* Returns what the last gl_identify drew. x and y count from the tile's top left pixel. A number
 * that no instance has becomes surface n_instances. Other threads may call it until the next
 * gl_identify. */
struct shown gl_shown(const struct gl *gl, int x, int y);

/* ---- inside this room ---- */

struct gl {
    const struct plan *plan;
    const struct lit_scene *lit;
    struct osmesa_context *context; /* draws colours; numbers too where `numbers` is NULL */
    struct osmesa_context *numbers; /* draws into floats where `context` draws into steps */
    /* tile_height rows of tile_width pixels of 4 floats, from the top */
    float *buffers[MOST_BUFFERS], *part; /* part: of some lights; NULL where one pass has all */
    float *shown;                        /* numbers of triangles; NULL: no check */
    void *steps;      /* the same of uint8_t or uint16_t, where `context` draws into steps */
    uint32_t *depths; /* rows from the bottom: 24 bits of depth, 8 of stencil; NULL: no check */
    bool is_stale[2]; /* of `context` and `numbers`: the buffer holds colours of another tile */
    struct osmesa_context *current;
    /* the state of `context`, which is set only where it changes: */
    int group;               /* the group of lights that is placed; -1: none */
    struct pass_colours set; /* colours of lights and of a material */
    float gloss;             /* of the last material that shines; -1: none did */
    bool two_sided, mirrored;
    const struct texture *texture; /* NULL: textures are switched off */
    unsigned *objects;  /* names of the buffer objects: some for each mesh; 0: not in view */
    unsigned *indices;  /* of triangles: each mesh's, then those of instances that hide some */
    unsigned *textures; /* names of the texture objects, one for each texture; 0: not drawn */
    struct rectangle tile;
    struct gl_work work;
};

/* ---- context.c ---- */

/* Makes OpenGL draw into these floats from now on; NULL: into steps. `numbers`: not colours. */
bool gl_draw_into(struct gl *gl, float *floats, bool numbers, struct error *err);
/* Empties what the current context has drawn of another tile. */
void gl_clear_stale(struct gl *gl);
/* Returns false after any error of OpenGL since the last call. */
bool gl_succeeded(struct error *err);

/* ---- upload.c ---- */

/* Loads and uploads all spectral textures for the bands of a pass. */
bool gl_upload_bands(struct gl *gl, int first_band, struct error *err);
/* The next draw call takes its vertices from an instance's mesh. Returns how many. */
int gl_bind_mesh(const struct gl *gl, int instance);
/* The next draw calls show a texture of the plan; NULL: none. */
void gl_bind_texture(struct gl *gl, const struct texture *texture);

/* ---- pass.c ---- */

/* Sets the state of a new context that no pass changes. */
void gl_set_state(const struct gl *gl);
/* Loads projection and viewport of the aimed tile. */
void gl_load_view(const struct gl *gl);
/* Replaces the current matrix of OpenGL. */
void gl_load_matrix(const struct matrix *m);
/* Empties the colours of the buffer, and leaves textures switched off. */
void gl_blacken(struct gl *gl);

#endif
