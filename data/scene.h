/* SPDX-License-Identifier: MIT */
/* What the files behind scene_read and material_read share. Nobody else includes this, but
 * fluorescence.c for its tables. */
#ifndef SCENE_H
#define SCENE_H

#include "spectral.h"

/* ---- data/keyword.c: words that mean something ---- */

enum { LIST_SIZE = 512 };

/* Adds up to `length` bytes of a name to a list in a message; what finds no room is left out. */
void list_add(char list[LIST_SIZE], const char *name, size_t length);
/* The index of the word in `known`, which ends with NULL; -1: none, and an error lists them. */
int word_choose(const struct word *word, const char *const *known, const char *what,
                struct error *err);
/* The same of the next word; its absence is the error "expected EXPECTED". */
int text_choose(struct text *text, const char *expected, const char *const *known, const char *what,
                struct error *err);
/* Sets *first, unless it is set already: "WHAT is given twice". */
bool place_once(struct place *first, struct place again, const char *what, struct error *err);
bool word_begins_number(const struct word *word);
/* Copies, allocated; a NULL stays one. */
bool string_copy(const char *from, char **out, struct error *err);
/* The file that a word names, as seen from the word's own file. Allocated. */
bool word_path(const struct word *word, char **out, struct error *err);
/* What text_word would yield. */
bool text_peek(struct text text, struct word *out);
/* Reads three numbers. */
bool text_vector(struct text *text, const char *what, struct vector *out, struct error *err);
/* The same, and refuses 0 0 0. */
bool text_direction(struct text *text, const char *what, struct vector *out, struct error *err);

/* ---- data/scene.c: files and statements ---- */

enum { DEEPEST_INCLUDE = 32 };

struct scene_reader {
    struct scene *scene;
    struct word *uses;  /* an object's material by name, or its map, until all materials are known;
                           start NULL: known */
    struct text *text;  /* the statement that is read; its first word has been read */
    struct place place; /* and stands here */
    const char *open[DEEPEST_INCLUDE]; /* the files that are being read, outermost first */
    int n_open;
    struct text list; /* what a checker reads instead of the list it names; zeroed: nothing */
};
/* Leaves the text to the scene, which frees it even if this fails. *text stays good as a cursor. */
bool scene_keep(struct scene *scene, struct text *text, struct error *err);
/* Opens the file that the word names, and keeps it. */
bool scene_open(struct scene *scene, const struct word *word, struct text *out, struct error *err);

/* ---- data/setting.c: everything in a scene but materials and objects ---- */

bool wavelengths_read(struct scene_reader *reader, struct error *err);
bool size_read(struct scene_reader *reader, struct error *err);
bool camera_read(struct scene_reader *reader, struct error *err);
bool viewer_read(struct scene_reader *reader, struct error *err);
bool shading_read(struct scene_reader *reader, struct error *err);
bool ambient_read(struct scene_reader *reader, struct error *err);
bool light_read(struct scene_reader *reader, struct error *err);
/* What holds where no statement says otherwise; to be called after reading. */
bool settings_complete(struct scene *scene, struct error *err);

/* ---- data/material.c: materials from files and from words ---- */

enum { HIGHEST_GLOSS = 128 }; /* as GL_SHININESS */

/* ---- data/mtl.c: the colours that come with OBJ models ---- */

/* The entry of that name; a file without one is blamed on `from`, which names it. */
bool mtl_read(const char *path, struct place from, const struct word *name, struct material *out,
              struct error *err);

/* ---- data/use.c: materials by name, and which of them are used ---- */

bool definition_read(struct scene_reader *reader, struct error *err);
/* The material of a file that a list names, which may be there already; *out is its index. */
bool listed_add(struct scene *scene, const struct word *word, int *out, struct error *err);
/* Finds the materials of all objects and reads those that are used. */
bool uses_resolve(struct scene_reader *reader, struct error *err);

/* ---- data/object.c: shapes, objects and grids of them ---- */

bool object_read(struct scene_reader *reader, struct error *err);
bool checker_read(struct scene_reader *reader, struct error *err);
void object_free(struct object *object);

#endif
