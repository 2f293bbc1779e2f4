/* SPDX-License-Identifier: MIT */
/* The room "stages": draws, judges and writes all tiles of a picture. OpenGL, the check and the
 * file work side by side, each on what the one before has made. */
#ifndef STAGES_H
#define STAGES_H

#include "data/base/base.h"
#include "data/pages/pages.h"
#include "data/stack/stack.h"
#include "data/threads/threads.h"
#include "raster/check/check.h"
#include "raster/passes/passes.h"
#include "raster/radiance/radiance.h"
#include "raster/renderer/renderer.h"
#include "spectral.h"

/* ---- check_map.c ---- */

/* A map of the check, written chunk by chunk. A TIFF has float pages of the floor, the floor of one
 * band, the largest error / bound, and enum check_class. A PNG, twice as wide, has the two floors
 * in colours, side by side. */
struct check_map {
    struct pages pages;
    struct picture_writer picture;
    bool coloured;  /* a PNG */
    int width;      /* of the scene's picture */
    float *samples; /* of a chunk */
};
/* Prints the meaning of a PNG's colours, in a line without its end. */
void check_map_print_colours(struct printed *to);
bool check_map_open(const char *path, const struct plan *plan, struct check_map *out,
                    struct error *err);
bool check_map_write(struct check_map *map, const struct check *check, struct error *err);
bool check_map_finish(struct check_map *map, struct error *err);
bool check_map_commit(struct check_map *map, struct outputs *outputs, struct error *err);
void check_map_discard(struct check_map *map); /* safe after commit */

/* ---- stages.c ---- */

/* Seconds of each part. Parts work side by side, so that their sum may exceed the total. The
 * processor's are those of all threads. */
struct part_seconds {
    double read, plan, gl, raster, check, write, total, processor;
};
/* Adds the seconds since *since to a part, and makes now the new *since. */
void clock_in(double *since, double *part);

/* The work of the stages. All but the last two members come in, prepared for the plan, and stay
 * the caller's. */
struct stages {
    const struct plan *plan;
    const struct passes *passes;
    const struct lit_scene *lit;
    const struct check_scene *check_scene; /* NULL: no check */
    struct check_map *map;                 /* NULL: none is wanted */
    struct renderer *renderer;             /* with GL_BUFFERS; NULL: only the reference draws */
    struct stack_writer *stack;            /* NULL: no samples are stored */
    int first_row;                         /* of the picture that the stack has, in its pixels */
    int first_tile, n_tiles;               /* those to be drawn: whole rows */
    struct progress_line *progress; /* NULL: none */
    double full_scale;
    bool clips; /* a vertex is brighter than full_scale */
    /* what comes out is added to these */
    struct tile_sums sums; /* with open totals, if there is a check */
    struct part_seconds seconds;
};
/* Frames that OpenGL may be ahead of the check; and its buffers, so many more for the pilots. */
enum { AHEAD_FRAMES = 2, GL_BUFFERS = AHEAD_FRAMES + MAX_PILOT_PASSES };
/* Draws, judges and writes all tiles. Output and verdict do not depend on the number of threads. */
bool stages_run(struct stages *stages, struct error *err);

/* ---- inside this room ---- */

/* object_map.c. Fills the object map of a tile: of each pixel the number, from 1, of the object
 * that most of its positions show; 0: the background. at: the tile in pixels of the stack. The
 * renderer of the stored pixels decides. */
void map_objects(const struct stages *stages, const struct tile *tile, const struct rectangle *at,
                 unsigned char *out);

#endif
