/* SPDX-License-Identifier: MIT */
/* The room "view": an interactive viewer of a scene in one HTML page, or a still picture. A live
 * page holds this program, and draws the scene anew after each change. A still page contains the
 * weights of each pixel, and computes the picture for any lights, detector and display by itself.
 */
#ifndef RASTER_BESIDE_VIEW_VIEW_H
#define RASTER_BESIDE_VIEW_VIEW_H

#include "data/text/text.h"

/* ---- command.c: spectral view ---- */

/* Writes the page or the picture of a scene, as the ending of its name says, and prints its numbers
 * of objects and lights. */
extern const struct command view_command;

/* ---- live.c: a page that verifies the GPU of its browser ---- */

/* A scene to be verified. */
struct verified_scene {
    char name[BUILTIN_NAME]; /* "hard/..." of a hard case; of a file the end of its path */
    const char *path;        /* as SCENE of render */
    /* A built-in one is drawn at the page's size, unless it is hard. */
    enum { VERIFIED_BUILTIN, VERIFIED_HARD, VERIFIED_FILE } kind;
};
/* Returns whether this program holds itself for browsers: ./build.sh live makes such a one. Only it
 * writes live pages. */
bool has_live_pages(void);
/* Writes a page to options->output that holds this program and n scenes, changed as the options
 * say: it draws them by WebGL2, and judges each. Fails, and writes nothing, where a scene cannot be
 * read. */
bool verifier_write(struct options *options, const struct verified_scene *scenes, int n,
                    struct error *err);

#endif
