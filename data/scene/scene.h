/* SPDX-License-Identifier: MIT */
/* The room "scene": the scene language; the thesis's material files, materials in words, MTL files;
 * the names of everything that is built in. */
#ifndef DATA_SCENE_SCENE_H
#define DATA_SCENE_SCENE_H

#include "data/mesh/mesh.h"
#include "data/spectra/spectra.h"

/* ---- material.c: materials from files and from words ---- */

/* Parts of an entry of an MTL file that may be lost: the picture of map_Kd, where it is missing,
 * has another format or is moved or scaled; other pictures; transparency, d or Tr; an Ns above 128;
 * a Ks above 1. */
enum {
    LOST_MAP_KD = 1,
    LOST_MAPS = 2,
    LOST_TRANSPARENCY = 4,
    LOST_GLOSS = 8,
    LOST_SPECULAR = 16,
    LOST_HIGHLIGHT = 32,
    LOST_ILLUM = 64,
    LOST_KINDS = 7
};
/* How a surface reflects and emits light. All reflectances are in [0, 1]. */
struct material {
    char *name; /* file name without folder and ending, or the scene's name; owned */
    char *path; /* owned; NULL for a material written in the scene */
    struct place place;
    struct spectrum diffuse;              /* always present */
    struct spectrum specular;             /* absent with gloss > 0: 1 at every wavelength */
    double gloss;                         /* 0..128; 0: no highlight */
    struct place gloss_place;             /* in a material file */
    struct spectrum excitation, emission; /* fluorescence; both or neither; sum(excitation) > 0 */
    char *donaldson;                      /* bispectral matrix file; owned, NULL: none */
    bool densities;                       /* in that file, not shares */
    struct donaldson matrix;              /* of that file, if an object uses the material */
    struct place donaldson_place;
    char *texture; /* file; owned, NULL: none */
    enum texture_filter { TEXTURE_NEAREST, TEXTURE_LINEAR, TEXTURE_BILINEAR } texture_filter;
    bool spectral_texture; /* the file is a stack of wavelengths */
    struct place texture_place;
    struct spectrum glow;     /* emission that needs no light */
    char *partner_name;       /* `metamer MATERIAL`: name in the scene; owned */
    int partner_index;        /* in the scene, if an object uses this material; otherwise 0 */
    struct material *partner; /* from the m lines of a material file; owned; NULL: none */
    struct place partner_place;
    bool from_rgb; /* an entry of an MTL file: spectra are made of three numbers, not measured */
    int lost;      /* parts of that entry, as a sum of LOST_... */
};

/* Reads a material file, which the place `from` names. */
bool material_read(const char *path, struct place from, struct material *out, struct error *err);
void material_free(struct material *material);

struct light {
    struct spectrum spectrum;
    double intensity;
    struct place place;     /* an ambient light has nothing but these three */
    struct vector position; /* or the direction towards it */
    bool directional;
    double attenuation[3]; /* constant, linear, quadratic; 1 0 0 by default */
    bool spot;
    struct vector spot_direction;
    double spot_cutoff_deg, spot_exponent;
    struct place attenuation_place;
    bool absolute; /* spectrum x intensity is in W sr-1 m-2 nm-1; otherwise relative */
    bool shadows;  /* objects throw shadows in this light */
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
    int material;                            /* index; -1: the assignments have it */
    char *material_map;                      /* owned; NULL: none */
    struct material_assignment *assignments; /* its lines, or of the mesh's own mtllib; owned */
    int n_assignments;
    bool two_sided;
    bool casts_none; /* it throws no shadow */
    bool background; /* a plane of 1 x 1 that the plan places behind the view, whatever transform is
                      */
    double
        fit; /* of a list: makes a shape of radius 1 as large as the thesis's sphere; 0: others */
    struct matrix transform;
    struct place place;
    /* The name of its material or map, which is looked up when the scene knows all materials; start
     * NULL: there was nothing to look up. */
    struct word named;
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
    struct tables tables;   /* while the scene is read */
    double *wavelengths_nm; /* strictly increasing */
    int n_wavelengths;
    int width, height;
    struct camera camera;
    bool local_viewer;
    enum shading_kind shading;
    int positions;             /* a pixel is the mean of positions x positions: a power of two */
    double tessellation;       /* factor of all slices, stacks, ... of built-in shapes, above 0 */
    struct place doubted_turn; /* may be meant as X Y Z ANGLE; line 0: there is none */
    struct place wavelengths_place;
    struct light *ambients, *lights;
    struct material *materials; /* read if an object uses them; others have only name and path */
    struct object *objects;
    int n_ambients, n_lights, n_materials, n_objects;
};
bool scene_is_input(const char *path); /* of a scene: it was read from standard input */
/* Finds whether a name is neither built in nor a file. Refuses an empty one. */
bool scene_is_missing(const char *name, bool *out, struct error *err);
void scene_free(struct scene *scene);
/* Returns light i of n_lights + n_ambients: the ambient ones come last. */
const struct light *scene_light(const struct scene *scene, int i);
/* Returns whether the lights have the unit W sr-1 m-2 nm-1: all of them have the same. */
bool scene_is_absolute(const struct scene *scene);
/* Returns the metameric partner of a material of the scene; NULL: it has none. */
const struct material *scene_partner(const struct scene *scene, const struct material *material);
/* Options: the value `text` replaces what the scene file says. Messages name option and column. */
bool scene_set_wavelengths(struct scene *scene, const char *text, struct error *err);
bool scene_set_size(struct scene *scene, const char *text, struct error *err);
bool scene_set_light(struct scene *scene, const char *text, struct error *err);

/* ---- scene_options.c: a scene as the command line names and changes it ---- */

/* Changes of all scenes; and of those that are shaded once, as cost and verify do not. */
extern const struct option_list scene_options, shading_options;
/* Reads SCENE and makes the changes that the options ask for, in their order. The caller frees
 * *out, also after a failure. */
bool scene_read_options(const struct options *options, struct scene *out, struct error *err);
/* Refuses a text file, or the name of a built-in scene, where a stack is expected: nobody has
 * rendered it yet.
 * A missing file passes: whoever opens it reports that. */
bool scene_refuse(const char *stack, struct error *err);

/* ---- command.c: spectral list, spectral show ---- */

/* Prints the names of one kind, or of all kinds. */
extern const struct command list_command;
/* Writes a built-in file, by the name that a list prints or by its path "builtin:...", to standard
 * output or to the output. If files of several kinds have the name, it is the first of scene,
 * material, list of materials, spectrum or detector, model, material map, texture and relief. */
extern const struct command show_command;
bool show_file(struct options *options, struct error *err); /* does so for a command like it */

#endif
