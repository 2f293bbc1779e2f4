/* SPDX-License-Identifier: MIT */
/* What only the files of the room "gl" share. */
#ifndef RASTER_GL_INSIDE_H
#define RASTER_GL_INSIDE_H

#include "data/maths/maths.h"
#include "raster/gl/gl.h"

/* after GL/gl.h */

/* ---- library.c: files of libraries ---- */

typedef void any_function(void);
/* Opens the first of the files that is there; NULL ends the list. *out is NULL if none is. The
 * library stays open as long as the program runs: Mesa's may not be closed. */
bool library_open(const char *const *files, void **out, struct error *err);
/* Finds a function of an open library, or one of that name that was loaded before it; NULL: there
 * is none. `out` points to a pointer to the function. */
void library_find(void *library, const char *name, void *out);
/* Finds n of them, for a struct that begins with as many pointers, which all have one size in
 * POSIX. Returns whether all are there. */
bool library_find_all(void *library, const char *const *names, size_t n, void *out);

/* ---- functions.c: the functions of OpenGL ---- */

/* Finds the functions of a way, in the library (NULL: none), or by what its own function finds; all
 * others are NULL. Fails with EXIT_SYSTEM if one is missing. `name`: the library's. */
struct gl_source {
    void *library;
    any_function *(*get)(const char *name);
    const char *name;
};
bool functions_find(const struct gl_source *in, enum gl_way way, struct gl_functions *out,
                    struct error *err);

/* Open a library; *found: its file is there, otherwise nothing is opened. device: EGL's; -1: none
 * is asked for. */
bool osmesa_open(struct contexts *contexts, bool *found, struct error *err);
bool egl_open(struct contexts *contexts, int device, bool *found, struct error *err);

/* buffers.c, textures.c: upload what is drawn. Nothing is uploaded twice, and nothing of an
 * instance out of view. */
bool meshes_upload(struct drawing *of, struct error *err);
bool textures_upload(struct drawing *of, struct error *err);

struct gl {
    struct drawing base;    /* the first member */
    struct canvas *colours; /* numbers are drawn there, too, where `numbers` is NULL */
    struct canvas *numbers; /* of floats, where `colours` has steps */
    uint8_t *steps;         /* pixels of uint8_t or uint16_t, where `colours` has steps */
    bool is_stale[2]; /* of `colours` and `numbers`: the buffer holds colours of another tile */
    struct canvas *current;
    /* the state of `colours`, which is set only where it changes: */
    int group;               /* the group of lights that is placed; -1: none */
    struct pass_colours set; /* colours of lights and of a material */
    float gloss;             /* of the last material that shines; -1: none did */
    bool two_sided, mirrored;
    const struct texture *texture; /* NULL: textures are switched off */
};

/* ---- open.c ---- */

/* Makes OpenGL draw into these floats from now on; NULL: into steps. `numbers`: not colours. */
bool gl_draw_into(struct gl *gl, float *floats, bool numbers, struct error *err);
/* Empties what the current context has drawn of another tile. */
void gl_clear_stale(struct gl *gl);

/* ---- upload.c ---- */

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
void gl_load_matrix(const struct gl_functions *call, const struct matrix *m);
/* Empties the colours of the buffer, and leaves textures switched off. */
void gl_blacken(struct gl *gl);

/* ---- identify.c ---- */

/* As struct renderer_kind says. */
bool gl_identify(struct renderer *renderer, struct error *err);

/* Finds the names of what draws; a canvas is in use. Refuses a size that is too large for OpenGL,
 * and another driver than the wanted one, which was chosen before the first canvas. wanted: NULL:
 * any. */
bool contexts_accept(const struct contexts *contexts, const struct rectangle *size,
                     const char *wanted, struct renderer_names *out, struct error *err);

bool has_extension(const char *list, const char *name); /* list: words; NULL: none */

GLenum canvas_type(const struct canvas *canvas); /* of a channel */

#endif
