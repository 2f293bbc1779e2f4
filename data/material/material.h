/* SPDX-License-Identifier: MIT */
/* The room "material": the thesis's material files, materials in words, MTL files. */
#ifndef MATERIAL_H
#define MATERIAL_H

#include "data/index/index.h"
#include "data/names/names.h"
#include "data/spectra/spectra.h"
#include "spectral.h"

/* ---- material.c: materials from files and from words ---- */

/* How a surface reflects and emits light. All reflectances are in [0, 1]. */
struct material {
    char *name; /* file name without folder and ending, or the scene's name; owned */
    char *path; /* owned; NULL for a material written in the scene */
    struct place place;
    struct spectrum diffuse;  /* always present */
    struct spectrum specular; /* absent with gloss > 0: 1 at every wavelength */
    double gloss;             /* 0..128; 0: no highlight */
    struct place gloss_place;
    struct spectrum excitation, emission; /* fluorescence; both or neither; sum(excitation) > 0 */
    char *donaldson;                      /* bispectral matrix file; owned, NULL: none */
    struct place donaldson_place;
    char *texture;       /* file; owned, NULL: none */
    bool texture_linear; /* of either kind */
    struct place texture_place;
    char *spectral_texture; /* stack; owned, NULL: none */
    struct place spectral_texture_place;
    struct spectrum glow;     /* emission that needs no light */
    char *partner_name;       /* `metamer MATERIAL`: name in the scene; owned */
    int partner_index;        /* in the scene, if an object uses this material; otherwise 0 */
    struct material *partner; /* from the m lines of a material file; owned; NULL: none */
    struct place partner_place;
    bool from_rgb; /* spectra are made of three numbers of an MTL file, not measured */
};

/* Reads a material file, which the place `from` names. */
bool material_read(const char *path, struct place from, struct material *out, struct error *err);
/* Reads the words of a material in a scene up to its }, over several lines. Its { has been read. */
bool material_read_words(struct text *text, struct material *out, struct error *err);
void material_free(struct material *material);
/* Returns whether a word begins an entry between { and }, as `diffuse` does. */
bool material_has_word(const struct word *word);

/* ---- mtl.c: the colours that come with OBJ models ---- */

/* An MTL file and where its entries are. */
struct mtl {
    struct text text;
    struct index names; /* the indices of the entries */
    struct mtl_entry *entries;
    int n_entries;
};
/* Opens an MTL file and finds its entries. `from` is the place that names it. A failure frees all.
 */
bool mtl_open(const char *path, struct place from, struct mtl *out, struct error *err);
/* Reads the entry of that name; without one the error is at `from`. The caller frees *out, after a
 * failure too. */
bool mtl_read(const struct mtl *mtl, struct place from, const struct word *name,
              struct material *out, struct error *err);
void mtl_free(struct mtl *mtl);

/* ---- Inside this room ---- */

enum { HIGHEST_GLOSS = 128 }; /* as GL_SHININESS */

#endif
