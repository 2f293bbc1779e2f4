/* SPDX-License-Identifier: MIT */
/* What the files behind scene_read and material_read share. Nobody else includes this. */
#ifndef SCENE_H
#define SCENE_H

#include "spectral.h"

/* ---- data/keyword.c: words that mean something ---- */

/* The index of the word in `known`, which ends with NULL; -1: none, and an error lists them. */
int word_choose(const struct word *word, const char *const *known, const char *what,
                struct error *err);
/* True when `first` is still unset; otherwise "WHAT is given twice". */
bool place_once(struct place first, struct place again, const char *what, struct error *err);
/* The file that a word names, as seen from the word's own file. Allocated; NULL after an error. */
char *word_path(const struct word *word, struct error *err);
/* Reads three numbers; *place, where it is not NULL, becomes that of the first. */
bool text_vector(struct text *text, const char *what, struct vector *out, struct place *place,
                 struct error *err);
/* The same, and refuses 0 0 0. */
bool text_direction(struct text *text, const char *what, struct vector *out, struct error *err);

/* ---- data/scene.c: files and statements ---- */

enum { DEEPEST_INCLUDE = 32 };

/* An object's material, found when all materials are known. Words live in scene.files. */
struct material_use {
    int object;
    struct word word;
    bool listed; /* the word is a file in a list, otherwise a name in the scene */
};
struct scene_reader {
    struct scene *scene;
    struct material_use *uses;
    int n_uses;
    const char *open[DEEPEST_INCLUDE]; /* the files that are being read, outermost first */
    int n_open;
    const struct text *list; /* what a checker reads instead of the list it names; NULL: nothing */
};
/* Leaves the text to the scene, which frees it even if this fails. *text stays good as a cursor. */
bool scene_keep(struct scene *scene, const struct text *text, struct error *err);

/* ---- data/setting.c: everything in a scene but materials and objects ---- */

/* Each reads a statement whose first word, at `place`, has been read. */
bool wavelengths_read(struct scene_reader *reader, struct text *text, struct place place,
                      struct error *err);
bool size_read(struct scene_reader *reader, struct text *text, struct place place,
               struct error *err);
bool camera_read(struct scene_reader *reader, struct text *text, struct place place,
                 struct error *err);
bool viewer_read(struct scene_reader *reader, struct text *text, struct place place,
                 struct error *err);
bool shading_read(struct scene_reader *reader, struct text *text, struct place place,
                  struct error *err);
bool ambient_read(struct scene_reader *reader, struct text *text, struct place place,
                  struct error *err);
bool light_read(struct scene_reader *reader, struct text *text, struct place place,
                struct error *err);
/* What holds where no statement says otherwise; to be called after reading. */
bool settings_complete(struct scene *scene, struct error *err);

/* ---- data/object.c: materials, shapes, objects and grids of them ---- */

bool definition_read(struct scene_reader *reader, struct text *text, struct place place,
                     struct error *err);
bool object_read(struct scene_reader *reader, struct text *text, struct place place,
                 struct error *err);
bool checker_read(struct scene_reader *reader, struct text *text, struct place place,
                  struct error *err);
void shape_free(struct shape *shape);
/* Finds the materials of all objects and reads those that are used. */
bool uses_resolve(struct scene_reader *reader, struct error *err);

#endif
