/* SPDX-License-Identifier: MIT */
/* The room "scene": the scene language. */
#ifndef SCENE_H
#define SCENE_H

#include "data/material/material.h"
#include "data/maths/maths.h"
#include "data/shape/shape.h"
#include "spectral.h"

struct light {
    struct spectrum spectrum;
    double intensity;
    struct vector position; /* or the direction towards it */
    bool directional;
    double attenuation[3]; /* constant, linear, quadratic; 1 0 0 by default */
    bool spot;
    struct vector spot_direction;
    double spot_cutoff_deg, spot_exponent;
    struct place place, attenuation_place;
};
struct ambient {
    struct spectrum spectrum;
    double intensity;
    struct place place;
};
struct camera {
    bool perspective;
    double extent; /* width of the view, or vertical angle in degrees */
    double near, far;
    struct vector eye, look, up;
};
/* A line of a material map, which gives a part of a mesh its material. */
struct material_assignment {
    char *name;   /* of a usemtl; "*" stands for all others; owned */
    int material; /* index */
    struct place place;
};
struct object {
    struct shape shape;
    int material;                            /* index; -1 with a material map */
    char *material_map;                      /* owned; NULL: none */
    struct material_assignment *assignments; /* its lines; owned */
    int n_assignments;
    bool two_sided;
    struct matrix transform;
    struct place place;
};
enum shading_kind {
    SHADING_SMOOTH, /* Gouraud's: lit at the vertices, interpolated */
    SHADING_FLAT,   /* the colour of a triangle's last vertex */
    SHADING_PHONG   /* normals interpolated, lit at each pixel; the reference only */
};
extern const char *const shading_words[]; /* of enum shading_kind, then NULL */
struct scene {
    char *path;         /* as given: file or built-in name; or see scene_is_input */
    char sha256[65];    /* of its text: its file, then those that it includes and lists, as read */
    struct text *files; /* those that sha256 is of, then options: own the paths of all places */
    int n_files, n_texts;   /* n_texts: the first ones, that sha256 is of */
    double *wavelengths_nm; /* strictly increasing */
    int n_wavelengths;
    int width, height;
    struct camera camera;
    bool local_viewer;
    enum shading_kind shading;
    int positions;       /* a pixel is the mean of positions x positions: a power of two */
    double tessellation; /* factor of all slices, stacks, ... of built-in shapes, above 0 */
    struct place wavelengths_place;
    struct ambient *ambients;
    struct light *lights;
    struct material *materials; /* read if an object uses them; others have only name and path */
    struct object *objects;
    int n_ambients, n_lights, n_materials, n_objects;
};
/* SCENE: a built-in name, a scene file, a thesis list file, or "-", standard input. */
bool scene_read(const char *name, struct scene *out, struct error *err);
bool scene_is_input(const char *path);   /* of a scene: it was read from standard input */
bool scene_is_missing(const char *name); /* neither built in nor a file */
void scene_free(struct scene *scene);
/* Returns the metameric partner of a material of the scene; NULL: it has none. */
const struct material *scene_partner(const struct scene *scene, const struct material *material);
/* Options: the value `text` replaces what the scene file says. Messages name option and column. */
bool scene_set_wavelengths(struct scene *scene, const char *text, struct error *err);
bool scene_set_size(struct scene *scene, const char *text, struct error *err);
bool scene_set_light(struct scene *scene, const char *text, struct error *err);
bool scene_set_ambient(struct scene *scene, const char *text, struct error *err);
bool scene_set_shading(struct scene *scene, const char *text, struct error *err);
bool scene_set_samples(struct scene *scene, const char *text, struct error *err);
bool scene_set_tessellation(struct scene *scene, const char *text, struct error *err);

/* ---- Inside this room ---- */
enum { DEEPEST_INCLUDE = 32, MOST_INCLUDES = 1000, N_ONCE = 5 };

/* The state of reading a scene. A function NAME_read below reads one statement, from behind its
 * first word. */
struct scene_reader {
    struct scene *scene;
    struct word *materials;     /* of each object, the name of its material or map, to be looked up
                                   when all materials are known; start NULL: it is known already */
    struct text *text;          /* the statement that is read */
    struct place place;         /* of its first word */
    struct place given[N_ONCE]; /* of the statements that may be given only once */
    const char *open[DEEPEST_INCLUDE]; /* the files that are being read, outermost first */
    int n_open, n_included;            /* n_included: all files included, each as often as it is */
    struct text list; /* a checker reads it in place of the list that it names; zeroed: none */
    /* Indices of materials: by name; by file, of those in lists; by MTL file and entry. The last
     * one has the indices of the MTL files in `mtl`. */
    struct index named, listed, entries, mtl_paths;
    struct mtl *mtl; /* the MTL files that were read */
    int n_mtl;
};
/* Gives the text to the scene, which owns it; a failure frees it. *text stays valid as a cursor. */
bool scene_keep(struct scene *scene, struct text *text, struct error *err);
/* Opens the file of this kind that the word names, and keeps it. */
bool scene_open(struct scene *scene, const struct word *word, enum file_kind kind, struct text *out,
                struct error *err);

/* view.c: wavelengths, size, camera, shading. */
bool wavelengths_read(struct scene_reader *reader, struct error *err);
bool size_read(struct scene_reader *reader, struct error *err);
bool camera_read(struct scene_reader *reader, struct error *err);
bool viewer_read(struct scene_reader *reader, struct error *err);
bool shading_read(struct scene_reader *reader, struct error *err);
/* Sets the size, camera, ... that hold unless a statement says otherwise. */
void view_set_defaults(struct scene *scene);
/* Sets the wavelengths where no statement has set them. */
bool wavelengths_complete(struct scene *scene, struct error *err);
/* Opens an option's value as a text of one line. The scene keeps it: places point into it. */
bool option_open(struct scene *scene, const char *option, const char *value, struct text *out,
                 struct error *err);
/* The bytes of an option's text from `start` up to `end` as a word. */
struct word option_word(const struct text *text, const char *start, const char *end);

bool ambient_read(struct scene_reader *reader, struct error *err); /* in lights.c */
bool light_read(struct scene_reader *reader, struct error *err);

/* materials.c: finds materials by name, and reads those that are used. */
bool definition_read(struct scene_reader *reader, struct error *err);
/* Adds the material of a file that a list names, unless it is there already; *out is its index. */
bool listed_add(struct scene_reader *reader, const struct word *word, int *out, struct error *err);
/* Finds the materials of all objects and reads those that are used. */
bool materials_resolve(struct scene_reader *reader, struct error *err);
void materials_forget(struct scene_reader *reader); /* frees what finds materials by name */

/* object.c: shapes, objects and grids of them. */
bool object_read(struct scene_reader *reader, struct error *err);
bool checker_read(struct scene_reader *reader, struct error *err);
void object_free(struct object *object);

#endif
