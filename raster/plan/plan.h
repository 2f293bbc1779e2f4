/* SPDX-License-Identifier: MIT */
/* The plan of a render, decided once: instances, terms, effects, passes, bytes. */
#ifndef PLAN_H
#define PLAN_H

#include "data/material/material.h"
#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/terms/terms.h"
#include "data/texture/texture.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- plan.c: what a scene calls for, decided once ---- */

/* Rows of a tile that a thread draws and judges at a time. */
enum { CHUNK_ROWS = 16 };
enum { LIGHTS_PER_PASS = 8, BANDS_PER_PASS = TEXTURE_PLANES };

/* A material under the lights of the scene. Lights of one spectrum share their terms, and terms
 * whose spectrum is 0 in all bands are left out. */
struct shaded_material {
    const struct material *material;
    struct texture *texture; /* NULL: none */
    int n_terms, n_colours;  /* colours: those that OpenGL adds up, a term's one for each light */
    struct term *terms;      /* for the reference; owned */
    struct material_terms made; /* their spectra, on each page */
};

/* A mesh, or a part of one, that is drawn: re-centred and brought to a common size, so that single
 * precision spends its digits on the shape and not on where it stands. */
struct plan_mesh {
    struct mesh mesh;
    struct cutting { /* the part that is shown, -1: all; on which side of x = 0, -1: both */
        int whole, part, side;
    } cutting;
    struct vector centre; /* of the whole mesh */
    double unit;          /* what its lengths are measured in: a power of two, about its size */
    bool textured;        /* some instance of it is */
    int32_t *points; /* of a solid, the point of each vertex: see mesh_points; NULL: of another */
};
/* An object, or a part of one, as it will be drawn: transform and camera composed in double. */
struct placed_instance {
    const struct object *object;
    int mesh, shaded; /* indices into the plan */
    bool twin;        /* an earlier instance is the same in the same place, and hides it */
    struct instance instance;
};
struct plan_effect {
    const char *name;
    bool used;
    char reason[160];
};
enum { MAX_EFFECTS = 18 };
/* Counted where it is done. */
struct plan_work {
    long materials_loaded, textures_loaded, excitation_integrals, terms;
};

struct plan_options {
    double full_scale;  /* 0: the largest vertex radiance */
    bool check, use_gl; /* whether the reference and OpenGL are needed */
    int buffer_bits;    /* of a channel of OpenGL's colour buffer: 8, 16, or 32 of floats; 0: 32 */
    const char *gl_driver; /* "llvmpipe" or "softpipe"; NULL: any */
    bool strict;           /* edges that leak are differences */
    double unchecked;      /* the largest share of object pixels that may stay unchecked */
    bool store_raster;     /* the stored pixels are the reference's */
    int bits;              /* of a page's sample: 8 or 16 of counts, 32 of floats; 0: 16 */
    bool exchangeable; /* lights may be exchanged afterwards: all lights and terms are kept apart */
    int threads;       /* 0: one a processor; the plan holds the number */
    char *const *recorded; /* options for the stack's record, each one word; not owned */
    int n_recorded;        /* at most MAX_RECORDED */
};
struct plan {
    const struct scene *scene;
    const struct sampling *sampling; /* NULL: none */
    struct plan_options options;
    int n_bands, n_passes; /* n_passes: groups of bands */
    double unit; /* of lengths in eye space: a power of two, 1/1024 of the picture's size */
    double near; /* distance of the near plane, in that unit */
    bool tiled;  /* there is more than one tile */
    struct matrix world_to_eye;
    struct view view; /* of the picture, for the reference */
    struct plan_mesh *meshes;
    struct shaded_material *materials;
    struct texture *textures;
    struct index by_material, by_texture; /* shaded materials by material; textures by file */
    struct placed_instance *instances;
    struct illumination illumination; /* the lights of the scene, before idle ones are dropped */
    struct eye_light *lights;         /* those that shine; and each as the scene has it: */
    const struct light **sources;
    int n_meshes, n_materials, n_textures, n_instances, n_lights, n_effects;
    int n_light_groups; /* passes that a group of bands takes: 1, or more beyond LIGHTS_PER_PASS */
    int max_rows;       /* numbers that a pixel keeps, at most: see pixel_rows */
    int tile_width, tile_height; /* the last column and row of tiles may be smaller */
    uint64_t file_bytes, tile_bytes;
    int map_bytes; /* of a number in the object map; 0: there is none */
    struct plan_effect effects[MAX_EFFECTS];
    struct plan_work work;
    long n_vertices, n_triangles; /* as drawn: a mesh counts once for every instance */
};
/* Reads meshes and textures, composes matrices, multiplies spectra; draws nothing. Refuses, at its
 * place, what cannot be drawn. Scene and sampling (NULL: none) must outlive the plan. */
bool plan_make(const struct scene *scene, const struct sampling *sampling,
               const struct plan_options *options, struct plan *out, struct error *err);
/* A region is drawn in so many tiles of the plan's size or smaller, row by row. */
struct rectangle plan_picture(const struct plan *plan); /* the whole picture */
int plan_tiles(const struct plan *plan, const struct rectangle *region);
struct rectangle plan_tile(const struct plan *plan, const struct rectangle *region, int index);
bool has_components(const struct plan *plan); /* bands are not single wavelengths */
/* The name of a band: "450 nm", or the label of a component. */
enum { BAND_NAME = 32 };
void band_name(const struct plan *plan, int band, char out[BAND_NAME]);
double shaded_brightest(const struct shaded_material *shaded); /* largest peak; 1: it is black */
/* The name of a surface: that of its material; or "background" for -1. */
const char *object_name(const struct plan *plan, int surface);
/* Writes that name, and the place in the scene where the object stands. */
void object_text(const struct plan *plan, int surface, char *out, size_t capacity);

/* Steps of a channel of OpenGL's colour buffer, from 0 to full scale; 0: floats. */
int buffer_steps(const struct plan *plan);
/* Plane 0, 1 or 2 of a texture, for the reference. */
struct texels plan_texels(const struct texture *texture, int plane);
/* Loads the planes of spectral textures for the bands of a pass. */
bool plan_load_textures(const struct plan *plan, int first_band, struct error *err);
void plan_free(struct plan *plan);

/* effects.c. Returns true if any term of the material is of this kind. */
bool has_term(const struct shaded_material *shaded, enum term_kind kind);

/* ---- Inside this room ---- */

/* effects.c. Fills the plan's effects, each with the reason why it is simulated or not. */
void plan_effects(struct plan *plan);

/* lights.c. Lists all lights that shine; shaded materials then use those that matter to them. */
bool lights_list(struct plan *plan, struct error *err);
/* Forgets the lights that light nothing, when all shaded materials are made. */
bool lights_drop_idle(struct plan *plan, struct error *err);
/* Makes the shaded material of a material when it is first asked for; *out is its index. */
bool shaded_material_find(struct plan *plan, const struct material *material, int *out,
                          struct error *err);
/* Builds, parts and places the meshes of all objects. */
bool instances_make(struct plan *plan, struct error *err);

#endif
