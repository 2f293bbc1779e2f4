/* SPDX-License-Identifier: MIT */
/* Only the files of the room "scene" include this. */
#ifndef DATA_SCENE_INSIDE_H
#define DATA_SCENE_INSIDE_H

#include "data/scene/scene.h"

/* ---- material.c: materials from files and from words ---- */

/* Reads the words of a material in a scene up to its }, over several lines. Its { has been read. */
bool material_read_words(struct text *text, struct material *out, struct error *err);
/* Reads the spectrum and the intensity of a material that only emits. */
bool material_read_emission(struct text *text, struct material *out, struct error *err);
/* Returns whether a word begins an entry between { and }, as `diffuse` does. */
bool material_has_word(const struct word *word);

/* ---- mtl.c: the colours that come with OBJ models ---- */

/* Where an entry is in its file. */
struct mtl_entry {
    struct text behind; /* the cursor behind its name */
    struct word name;
    struct place again; /* of the next entry of that name; line 0: there is none */
    int material;       /* of the scene, from 1; 0: it is not read yet */
};
/* An MTL file and its entries. */
struct mtl {
    struct text text;
    struct index names; /* the indices of the entries */
    struct mtl_entry *entries;
    int n_entries;
};
/* Opens an MTL file and finds its entries. `from` is the place that names it. */
bool mtl_open(const char *path, struct place from, struct mtl *out, struct error *err);
/* Returns the entry of that name; NULL: there is none, with an error at `from`. */
struct mtl_entry *mtl_find(const struct mtl *mtl, struct place from, const struct word *name,
                           struct error *err);
/* Reads an entry. The caller frees *out, after a failure too. */
bool mtl_read(const struct mtl_entry *entry, struct material *out, struct error *err);
void mtl_free(struct mtl *mtl);

enum { HIGHEST_GLOSS = 128 }; /* as GL_SHININESS */

enum { N_ONCE = 6 };

/* The state of reading a scene. A function NAME_read below reads one statement, from behind its
 * first word. */
struct scene_reader {
    struct scene *scene;
    struct text *text;                 /* the statement that is read */
    struct place place;                /* of its first word */
    struct place given[N_ONCE];        /* of the statements that may be given only once */
    const char *open[DEEPEST_INCLUDE]; /* the files that are being read, outermost first */
    int n_open, n_included;            /* n_included: all files included, each as often as it is */
    struct text list; /* a checker reads it in place of the list that it names; zeroed: none */
    struct index named, listed; /* indices of materials: by name; by file, of those in lists */
    struct mtl *mtl;            /* the MTL files that were read */
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
/* Adds a material to the scene, or frees it where that fails, or where it is not good. */
bool material_keep(struct scene *scene, struct material *material, bool good, struct error *err);
bool definition_read(struct scene_reader *reader, struct error *err);
/* Finds the materials of all objects and reads those that are used. */
bool materials_resolve(struct scene_reader *reader, struct error *err);

/* object.c: shapes, objects and grids of them. */
bool object_read(struct scene_reader *reader, struct error *err);
bool checker_read(struct scene_reader *reader, struct error *err);
/* Adds a plane that emits, behind all else. */
bool background_read(struct scene_reader *reader, struct error *err);
void object_free(struct object *object);

bool scene_set_ambient(struct scene *scene, const char *text, struct error *err);
bool scene_set_shading(struct scene *scene, const char *text, struct error *err);
bool scene_set_tessellation(struct scene *scene, const char *text, struct error *err);

/* SCENE: a built-in name, a scene file, a thesis list file, or "-", standard input. */
bool scene_read(const char *name, struct scene *out, struct error *err);

#endif
