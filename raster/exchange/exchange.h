/* SPDX-License-Identifier: MIT */
/* The room "exchange": pictures that another program draws. spectral export writes a scene as plain
 * files, spectral judge reads that program's pixels as those of a renderer. data/doc/exchange.md is
 * the contract of all files. This room needs no OpenGL. */
#ifndef EXCHANGE_H
#define EXCHANGE_H

#include "data/options/options.h"
#include "raster/plan/plan.h"
#include "raster/renderer/renderer.h"
#include "spectral.h"

/* ---- command.c: spectral export, spectral judge ---- */

/* Writes all that another program needs to draw a scene into a new folder. */
bool command_export(struct options *options, struct error *err);
/* Judges the pixels that another program drew of a scene. Fails with EXIT_DIFFERENT where they
 * differ. */
bool command_judge(struct options *options, struct error *err);

/* ---- inside this room ---- */

/* ---- describe.c: a scene as files ---- */

enum { DIGEST_TEXT = 65, FILE_NAME = 64 };
/* Gets each file of a scene when it is complete. */
struct file_taker {
    bool (*take)(void *of, const char *name, const void *bytes, size_t length, struct error *err);
    void *of;
};
/* Describes all that is to be drawn of a plan: the files of meshes, triangles, textures and passes,
 * and at last scene.txt, which has the digests of all others. id: the SHA-256 of scene.txt without
 * its line "id". taker NULL: only the id is wanted. */
bool scene_describe(const struct plan *plan, double full_scale, const struct file_taker *taker,
                    char id[DIGEST_TEXT], struct error *err);

/* ---- export.c ---- */

/* Writes the files of a plan into the folder, which appears whole or not at all. */
bool export_plan(const struct plan *plan, const char *folder, struct error *err);

/* ---- judge.c ---- */

struct drawn_names {
    const char *pixels, *driver; /* a folder, or a TIFF; the choice of --driver, NULL: none */
};
/* Opens pixels as a renderer of the plan: see gl_open. Colours are read pass by pass. */
bool drawn_open(const struct drawn_names *names, const struct plan *plan, int n_buffers,
                struct renderer **out, struct error *err);

/* ---- read.c: the files that another program wrote ---- */

/* The words of drawn.txt. */
struct drawn_words {
    char id[DIGEST_TEXT];
    struct renderer_names names;
    struct place place; /* of the id; its path belongs to the caller of drawn_read_words */
};
/* Reads the file `path`, which must outlive *out. */
bool drawn_read_words(const char *path, struct drawn_words *out, struct error *err);
/* Reads a file of a folder, which must have so many bytes. *found: NULL: it must be there. */
bool drawn_read_file(const char *folder, const char *name, size_t length, void *out, bool *found,
                     struct error *err);

#endif
