/* SPDX-License-Identifier: MIT */
/* Draws the plan's picture through OpenGL, a tile and a pass at a time, and says which triangle
 * OpenGL shows at each pixel. It may not know what the reference shows: of lit scenes it reads only
 * where each surface lies in the window, so that it draws nothing that a tile cannot show. */
#ifndef GL_H
#define GL_H

#include "data/maths/maths.h"
#include "data/texture/texture.h"
#include "raster/bounds/bounds.h"
#include "raster/passes/passes.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "raster/renderer/renderer.h"
#include "raster/vertices/vertices.h"
#include "spectral.h"

/* Returns false in a program without OpenGL, where gl_open always fails. */
bool gl_is_built(void);
/* Writes name, version and driver of the library that is used by default. */
void gl_library(char *out, size_t capacity);
/* Opens OpenGL for a plan, which must outlive *out. n_buffers: at most MOST_BUFFERS. Fails with
 * EXIT_SYSTEM where there is no usable OpenGL, or not the driver that the plan asks for. The caller
 * closes *out unless it is NULL, also after a failure. One can be open at a time. */
enum { MOST_BUFFERS = 8 };
bool gl_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err);

/* ---- inside this room ---- */

struct gl {
    struct renderer renderer; /* the first member */
    const struct plan *plan;
    const struct lit_scene *lit;
    struct contexts *contexts;
    const struct gl_functions *call;
    struct canvas *colours; /* numbers are drawn there, too, where `numbers` is NULL */
    struct canvas *numbers; /* of floats, where `colours` has steps */
    /* tile_height rows of tile_width pixels of 4 floats, from the top */
    float *buffers[MOST_BUFFERS], *part; /* part: of some lights; NULL where one pass has all */
    float *shown;                        /* numbers of triangles; NULL: no check */
    uint8_t *steps;   /* the same of uint8_t or uint16_t, where `colours` has steps */
    uint32_t *depths; /* 24 bits of depth, 8 of stencil; NULL: no check */
    bool is_stale[2]; /* of `colours` and `numbers`: the buffer holds colours of another tile */
    struct canvas *current;
    /* the state of `colours`, which is set only where it changes: */
    int group;               /* the group of lights that is placed; -1: none */
    struct pass_colours set; /* colours of lights and of a material */
    float gloss;             /* of the last material that shines; -1: none did */
    bool two_sided, mirrored;
    const struct texture *texture; /* NULL: textures are switched off */
    struct vertex_buffers vertices;
    unsigned *textures; /* names of the texture objects, one for each texture; 0: not drawn */
    struct rectangle tile;
};

/* ---- open.c ---- */

/* Makes OpenGL draw into these floats from now on; NULL: into steps. `numbers`: not colours. */
bool gl_draw_into(struct gl *gl, float *floats, bool numbers, struct error *err);
/* Empties what the current context has drawn of another tile. */
void gl_clear_stale(struct gl *gl);

/* ---- upload.c ---- */

/* As struct renderer_kind says. Uploads the vertices, triangles and textures that are drawn; of
 * spectral textures no texels. */
bool gl_take_scene(struct renderer *renderer, const struct lit_scene *lit, struct error *err);
/* Loads and uploads all spectral textures for the bands of a pass. */
bool gl_upload_bands(struct gl *gl, int first_band, struct error *err);
/* The next draw call takes its vertices from an instance's mesh. Returns how many. */
int gl_bind_mesh(const struct gl *gl, int instance);
/* The next draw calls show a texture of the plan; NULL: none. */
void gl_bind_texture(struct gl *gl, const struct texture *texture);

/* ---- pass.c ---- */

/* As struct renderer_kind says. */
void gl_aim(struct renderer *renderer, const struct rectangle *tile);
bool gl_draw(struct renderer *renderer, int buffer, int first_band, double full_scale,
             struct error *err);
/* Sets the state of a new context that no pass changes. */
void gl_set_state(const struct gl *gl);
/* Loads projection and viewport of the aimed tile. */
void gl_load_view(const struct gl *gl);
/* Replaces the current matrix of OpenGL. */
void gl_load_matrix(const struct gl *gl, const struct matrix *m);
/* Empties the colours of the buffer, and leaves textures switched off. */
void gl_blacken(struct gl *gl);

/* ---- identify.c ---- */

/* As struct renderer_kind says. */
bool gl_identify(struct renderer *renderer, struct error *err);
struct shown gl_shown(const struct renderer *renderer, int x, int y);

#endif
