/* SPDX-License-Identifier: MIT */
/* Only the files of the room "render" include this. */
#ifndef RASTER_RENDER_INSIDE_H
#define RASTER_RENDER_INSIDE_H

#include "raster/render/render.h"
#include "raster/volumes/volumes.h"

/* ---- notes.c: a list of notes ---- */

/* Leaves one note, on a picture that shows no object. */
void notes_of_nothing(const struct plan *plan, struct notes *notes);

/* ---- check_map.c ---- */

/* A map of the check, written chunk by chunk. A TIFF has float pages of the floor, the floor of one
 * band, the largest error / bound, and enum check_class. A PNG, twice as wide, has the two floors
 * in colours, side by side. */
struct check_map {
    struct picture_writer picture; /* the caller finishes, commits and discards it */
    float *samples;                /* of a chunk; the caller frees them, also after a failure */
};
/* Prints the meaning of a PNG's colours, in a line without its end. */
void check_map_print_colours(struct printed *to);
bool check_map_open(const char *path, const struct plan *plan, struct check_map *out,
                    struct error *err);
bool check_map_write(struct check_map *map, const struct check *check, struct error *err);

/* ---- render.c: everything before the first pixel, and after the last one ---- */

/* A render on its way, in the order in which it is made. */
struct rendering {
    const struct plan *plan;
    const struct render_output *output;
    struct render_result *result;   /* the stages add odd samples, light and seconds */
    struct progress_line *progress; /* NULL: none */
    double since;                   /* clock_seconds at the last clock_in */
    struct renderer *renderer;      /* with GL_BUFFERS; NULL: only the reference draws */
    struct lit_scene lit;
    struct volumes volumes;         /* of the shadows that OpenGL draws */
    struct rectangle region;        /* to be drawn: whole rows of tiles */
    struct check_scene check_scene; /* lit NULL: there is no check */
    struct check_totals totals;     /* of the picture; open, if there is a check */
    struct check_map map;           /* if the output has one */
    struct stack_writer stack;      /* if the output has one; otherwise no samples are stored */
};

bool render_agreed(const struct plan *plan, const struct render_result *result);
/* Returns the renderer of the stored pixels: "raster", or OpenGL's GL_RENDERER. */
const char *render_stored(const struct plan *plan, const struct render_result *result);

/* ---- stages.c ---- */

/* Adds the seconds since *since to a part, and makes now the new *since. */
void clock_in(double *since, double *part);
/* Frames that OpenGL may be ahead of the check; and its buffers, so many more for the pilots, where
 * it draws one frame at once. */
enum { AHEAD_FRAMES = 2, GL_BUFFERS = AHEAD_FRAMES + MOST_PILOT_PASSES };
/* Draws, judges and writes all tiles. Output and verdict do not depend on the number of threads. */
bool stages_run(struct rendering *of, struct error *err);

/* ---- verdict_words.c: the verdict in words ---- */

/* Writes the verdict as one line of ASCII, for the stack. */
void report_verdict(const struct plan *plan, const struct check_verdict *verdict,
                    char out[STACK_VERDICT]);

/* Does the same for a stack that differs from the stack at `path`, whose record is `made`. The
 * message names the most certain reason. */
bool report_not_again(const struct plan *plan, const struct render_result *result, const char *path,
                      const struct record *made, const char *then, struct error *err);
/* Returns "agreed", "differs", "not verified" or "not checked". */
const char *verdict_word(const struct plan *plan, const struct check_verdict *verdict);
/* Prints the verdict with its reason. */
void print_verdict(const struct plan *plan, const struct check_verdict *verdict,
                   struct printed *to);

/* ---- report.c: results as a table and as JSON ---- */

/* Prints the picture, the verdict, each defect of the picture, and the seconds. */
void report_print(const struct plan *plan, const struct render_result *result, struct printed *to);
/* Puts all figures. */
void report_put(const struct plan *plan, const struct render_result *result, struct json *json);

/* ---- again.c: spectral render --again ---- */

/* Makes a stack again from the scene and the options that it records. Fails with EXIT_DIFFERENT if
 * any byte of the new stack differs. */
bool render_again(struct options *options, struct error *err);
/* Removes those options from what the stack records that decide how it is checked, and by which
 * OpenGL. A stack of the reference's pixels is the same with any check. */
void options_forget_check(struct options *options);

/* ---- job.c ---- */

/* The word of --renderer is "raster": the stack has the pixels of the reference. */
bool stores_raster(const struct render_options *own);

#endif
