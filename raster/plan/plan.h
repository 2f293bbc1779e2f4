/* SPDX-License-Identifier: MIT */
/* The room "plan": what a scene calls for, decided once: instances, terms, effects, bytes; which
 * bands OpenGL draws together, in which colours, and which it need not draw; the plan as facts. */
#ifndef RASTER_PLAN_PLAN_H
#define RASTER_PLAN_PLAN_H

#include "data/images/images.h"
#include "data/sampling/sampling.h"
#include "raster/renderers/renderers.h"

enum { LIGHTS_PER_PASS = 8, BANDS_PER_PASS = TEXTURE_PLANES };

/* A material under the lights of the scene. Lights of one spectrum share their terms, and terms
 * whose spectrum is 0 in all bands are left out. */
struct shaded_material {
    const struct material *material;
    struct texture *texture; /* NULL: none */
    int n_terms, n_colours;  /* colours: those that OpenGL adds up, a term's one for each light */
    struct term *terms;      /* for the reference; owned */
    struct material_terms made; /* their spectra, on each page */
    bool shown;                 /* by an instance in view */
};
/* A mesh or a part, re-centred and scaled, so that single precision spends its digits on shape. */
struct plan_mesh {
    struct mesh mesh;
    struct shape shape;   /* of the whole mesh, tessellated; its names are the scene's */
    struct vector centre; /* of the whole mesh */
    double unit;          /* what its lengths are measured in: a power of two, about its size */
    bool solid;           /* closed, with all faces outward */
    double relief_texels, relief_missed; /* texels of its relief in a triangle, on average; heights,
                                            rms, by which flat triangles miss it at their centres */
};
/* The planes of the view. A set of them has bit 1 << plane. */
enum view_plane { VIEW_LEFT, VIEW_RIGHT, VIEW_BELOW, VIEW_ABOVE, VIEW_NEAR, VIEW_FAR, VIEW_PLANES };
extern const char *const view_plane_words[]; /* where that is, as "left of the view" */
/* An object, or a part of one, as it will be drawn: transform and camera composed in double. */
struct placed_instance {
    const struct object *object;
    int mesh, shaded;        /* indices into the plan */
    uint32_t casts;          /* bit i: it may throw a shadow of shadowed light i into view */
    bool twin;               /* an earlier instance is the same in the same place, and hides it */
    bool in_view;            /* OpenGL draws it; otherwise */
    enum view_plane outside; /* all of it lies outside of this plane */
    struct instance instance;
};
enum { N_EFFECTS = 21, BAND_NAME = 32 };
/* So many of all that an effect may concern call for it. */
struct plan_effect {
    const char *name;
    int used, all;
    const char *what, *otherwise; /* what: of the numbers; NULL: the scene asks for it or not */
};
struct plan_options {
    double full_scale;  /* 0: the largest vertex radiance */
    bool check, use_gl; /* whether the reference and OpenGL are needed */
    enum gl_way gl_way;
    int buffer_bits; /* of a channel of OpenGL's colour buffer: 8, 10, 16, or 32 of floats; 0: 32 */
    const char *gl_driver, *gl_library; /* NULL: any driver; --gl */
    bool store_raster;                  /* pixels are the reference's */
    int bits;          /* of a page's sample: 8 or 16 of counts, 32 of floats; 0: 16 */
    bool exchangeable; /* lights may be exchanged afterwards: all lights and terms are kept apart */
    bool untextured;   /* weights stay without textures: pixels keep their places in them */
    bool complete;     /* another program draws: every pass, and the backs that solids hide, too */
    int threads;       /* 0: one a processor; the plan holds the number */
    int halvings;      /* how often the edges of all objects are halved */
};
/* A pass holds BANDS_PER_PASS consecutive bands. A frame is the pixels that OpenGL draws for a
 * pass, or for several that follow each other and have the same products of spectra. A pass whose
 * products are 0 has no frame: its pixels are 0. Where another program draws (plan_options), each
 * pass has a frame of its own. Ten bands; 3 to 5 are dark:
 *
 *     band     0    1    2  |  3    4    5  |  6    7    8  |  9      a page of the stack
 *     pass          0       |       1       |       2       |  3
 *     colour  red green blue| red green blue| red green blue| red
 *     frame         0       |      DARK     |       1       |  2
 *
 * OpenGL draws a frame once for each group of lights, and the drawings are added. Ten lights, and
 * two that throw shadows, make four groups:
 *
 *     group    0                 1             2                  3
 *     lights   0 to 7            8 and 9       10, where its      11, where its
 *              and constant                    light reaches      light reaches */
enum { DARK = -1 };
struct passes {
    int n_frames, n_dark, n_repeated; /* passes without a frame; or with that of another pass */
    int *frame;                       /* of each pass, ascending; or DARK; owned */
};
struct plan {
    const struct scene *scene;
    const struct sampling *sampling; /* NULL: none */
    struct plan_options options;
    int n_bands, n_passes; /* n_passes: groups of bands */
    double unit; /* of lengths in eye space: a power of two, 1/1024 of the picture's size */
    double near; /* distance of the near plane, in that unit */
    bool tiled;  /* there is more than one tile */
    struct matrix world_to_eye, background_to_eye;
    struct view view; /* of the picture, for the reference */
    struct plan_mesh *meshes;
    struct shaded_material *materials;
    struct texture *textures;
    struct index by_material; /* shaded materials */
    struct placed_instance *instances;
    struct illumination illumination; /* the lights of the scene, before idle ones are dropped */
    struct eye_light *lights;         /* those that shine, in the order of the scene; but those
                                         that throw shadows into view come last: see struct view */
    const struct light **sources;     /* each of them as the scene has it */
    bool *is_idle;                    /* lights that add exactly 0 to all in view; owned */
    int n_meshes, n_materials, n_textures, n_instances, n_lights;
    int n_light_groups;          /* passes that a group of bands takes: see light_group */
    int max_rows;                /* numbers that a pixel keeps, at most: see pixel_rows */
    int tile_width, tile_height; /* the last column and row of tiles may be smaller */
    int chunk_rows; /* of a tile, that a thread draws and judges at a time; the last chunk may have
                       fewer */
    uint64_t file_bytes, tile_bytes;
    int map_bytes; /* of a number in the object map; 0: there is none */
    struct plan_effect effects[N_EFFECTS];
    struct passes passes;
    struct plan_work { /* counted where it is done */
        long excitation_integrals, terms, unseen_instances, idle_lights, idle_groups,
            undrawn_textures;
    } work;
    long n_vertices, n_triangles; /* as drawn: a mesh counts once for every instance */
};
/* plan.c. Reads meshes and textures, composes matrices, multiplies spectra; draws nothing. Refuses,
 * at its place, what cannot be drawn. Scene and sampling (NULL: none) must outlive the plan. */
bool plan_make(const struct scene *scene, const struct sampling *sampling,
               const struct plan_options *options, struct plan *out, struct error *err);
/* A region, in positions, is drawn in so many tiles of the plan's size or smaller, row by row. */
struct rectangle plan_picture(const struct plan *plan); /* all positions */
struct rectangle plan_pixels(const struct plan *plan, const struct rectangle *positions);
int plan_tiles(const struct plan *plan, const struct rectangle *region);
struct rectangle plan_tile(const struct plan *plan, const struct rectangle *region, int index);
bool has_components(const struct plan *plan);            /* bands are not single wavelengths */
int pass_bands(const struct plan *plan, int first_band); /* of the pass that begins with it */
void band_name(const struct plan *plan, int band, char out[BAND_NAME]);   /* "450 nm", or a label */
bool has_term(const struct shaded_material *shaded, enum term_kind kind); /* any of its terms */
double shaded_brightest(const struct shaded_material *shaded); /* largest peak; 1: it is black */
/* The radiance of these weights in a band, without the texture. */
double shaded_radiance(const struct plan *plan, const struct shaded_material *shaded,
                       const double *weights, int band);
/* A surface's name, its material's; -1: "background". object_text adds its object's place. */
const char *object_name(const struct plan *plan, int surface);
void object_text(const struct plan *plan, int surface, char *out, size_t capacity);
int buffer_steps(const struct plan *plan); /* of a channel, from 0 to full scale; 0: floats */
struct texels plan_texels(const struct texture *texture, int plane); /* for the reference */
/* Reads a place that put_rows has written. */
void plan_place(const struct texels *texels, const double *rows, size_t stride,
                double out[TEXEL_PLACE]);
/* Loads the planes of spectral textures for the bands of a pass. */
bool plan_load_textures(const struct plan *plan, int first_band, struct error *err);
void plan_free(struct plan *plan);

/* ---- reach.c: what reaches the picture ---- */

/* sum_j |m_ij| |v_j|: the rounding errors of row i are relative to it. */
void matrix_magnitudes(const struct matrix *m, const double v[4], double out[4]);
bool reflects(const struct instance *instance, const struct eye_light *light); /* by some term */
/* Lights that OpenGL draws at a time: up to LIGHTS_PER_PASS, or one that throws shadows. */
struct light_group {
    int first, n; /* of the plan's lights */
    int shadowed; /* the number of the one that throws shadows, from 0; -1: none does */
};
struct light_group light_group(const struct plan *plan, int group);
int group_of(const struct plan *plan, int light); /* the number of the group that has it */
/* A group of lights has one that is not idle, or is the first: OpenGL draws it. */
bool group_is_drawn(const struct plan *plan, int group);

bool plan_has_mipmaps(const struct plan *plan); /* of some texture in view */
/* The pixels that are stored have other levels of detail than those that are checked. */
bool checks_other_rows(const struct plan *plan);

/* ---- passes.c ---- */

/* The colours of a material in a pass under one group of lights: products of the spectra of lights
 * and material in parts of full scale, red, green and blue for three bands, and 1. Where there is
 * no such term, or no such band, a colour is black. */
struct pass_colours {
    float constant[4], diffuse[LIGHTS_PER_PASS][4], specular[LIGHTS_PER_PASS][4];
    int n_lights; /* of this group */
    bool shines;  /* there is a specular term */
};
/* group: its number; group 0 has the constant term. */
void pass_colours(const struct plan *plan, const struct shaded_material *shaded, int group,
                  int first_band, double full_scale, struct pass_colours *out);

/* Reads the texels of a spectral texture for the bands of a pass: red, green and blue of each, rows
 * from the bottom, level by level. Those of bands that do not exist are 0. out has room for all. */
bool pass_texels(const struct plan *plan, struct texture *texture, int first_band, float *out,
                 struct error *err);

/* The numbers of a vertex as OpenGL gets them: position, normal, texture coordinates. */
enum { VERTEX_NUMBERS = 8 };
void vertex_numbers(const struct vertex *vertex, float out[VERTEX_NUMBERS]);
/* The projection that makes a tile of the picture fill clip space; mirrored: y is turned around. */
struct matrix pass_projection(const struct plan *plan, const struct rectangle *tile, bool mirrored);

/* ---- facts.c: the plan as JSON or in words ---- */

/* Puts the facts: work, effects, lights, values that are guessed. */
void plan_facts(const struct plan *plan, struct json *json);
/* Puts the list of the scene's files with their digests. detector: of its sampling; NULL: none was
 * given. Fails only where memory or a file does. */
bool plan_put_files(const struct plan *plan, const char *detector, struct json *json,
                    struct error *err);
/* Puts the members on the scene, and on the size and the wavelengths of its picture. */
void scene_put(const struct plan *plan, struct json *json);

/* ---- beyond_tables.c: spectra that are tables ---- */

enum { BEYOND_TEXT = 384 };
struct tables_found {
    int n, n_limited;          /* tables that end too early; values that were noise */
    char first[BEYOND_TEXT];   /* the first of these tables, in words */
    char limited[BEYOND_TEXT]; /* the first of these values */
};
/* Finds what is to be noted of tables. Prints a line for each that the picture reaches beyond; `to`
 * NULL: none. */
struct tables_found tables_look(const struct plan *plan, struct printed *to);

#endif
