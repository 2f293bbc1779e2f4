/* SPDX-License-Identifier: MIT */
/* Renders a plan into a stack, tile by tile and pass by pass, and reports the result. This room
 * connects the reference, OpenGL, the check and the stack. It does not depend on how any of them
 * works. */
#ifndef RENDER_H
#define RENDER_H

#include "data/base/base.h"
#include "data/options/options.h"
#include "data/record/record.h"
#include "data/stack/stack.h"
#include "raster/driver/driver.h"
#include "raster/gl/gl.h"
#include "raster/notes/notes.h"
#include "raster/plan/plan.h"
#include "raster/radiance/radiance.h"
#include "raster/shader/shader.h"
#include "raster/stages/stages.h"
#include "raster/verdict/verdict.h"
#include "spectral.h"

/* ---- render.c: everything before the first pixel, and after the last one ---- */

struct render_result {
    double full_scale;
    struct renderer_names names; /* empty: OpenGL did not draw */
    struct driver driver;        /* whose bounds the check uses */
    struct renderer_work gl;
    int dark_passes, repeated_passes; /* that OpenGL does not draw, in each tile */
    struct light_work light;
    struct check_verdict check;
    struct odd_samples odd;
    struct stack_difference difference; /* from the stack that is made again */
    const struct notes *notes;          /* those of struct render_output */
    struct part_rows rows;              /* that the stack has; count 0: all */
    struct part_seconds seconds;
};
/* Another program draws the pixels. */
struct render_foreign {
    /* opens them as a renderer, as gl_open does */
    bool (*open)(void *of, const struct plan *plan, int n_buffers, struct renderer **out,
                 struct error *err);
    /* gets the plan, and nothing is judged; NULL: the pixels are judged */
    bool (*take_plan)(void *of, const struct plan *plan, struct error *err);
    void *of;
};
struct render_output {
    const char *path;      /* of the stack; NULL: no stack is written */
    const char *check_map; /* the map of the check; NULL: none is wanted */
    const char *again;     /* the stack to compare the new one with, byte by byte; NULL: none */
    bool keep;             /* store the stack even if it fails its check or differs from `again` */
    bool discard;          /* compare the stack with `again`, and store none */
    bool envi;             /* write the stack's ENVI header beside it */
    struct outputs *outputs; /* get all files; NULL: they appear at once */
    struct notes *notes;     /* as notes_make takes them; NULL: none are wanted */
    /* gets the result in place of the report, and `taker`; NULL: the result is reported */
    bool (*take)(void *taker, const struct plan *plan, const struct render_result *result,
                 struct error *err);
    void *taker;
    const struct render_foreign *foreign; /* NULL: OpenGL draws here */
    struct picture_part {                 /* draws these rows of tiles; count 0: all */
        int number, count;                /* from 1 */
    } part;
};
/* Renders into a stack. Returns true even if the picture fails its check or differs from `again`:
 * ask render_agreed. progress: shown after each pass; NULL: none. After a failure, an interruption
 * or a difference (without `keep`) no file has been created or changed. */
bool render(const struct plan *plan, const struct render_output *output,
            struct progress_line *progress, struct render_result *out, struct error *err);
bool render_agreed(const struct plan *plan, const struct render_result *result);
/* Returns the renderer of the stored pixels: "raster", or OpenGL's GL_RENDERER. */
const char *render_stored(const struct plan *plan, const struct render_result *result);

/* ---- words.c: the verdict in words ---- */

/* Writes the verdict as one line of ASCII, for the stack. */
void report_verdict(const struct plan *plan, const struct check_verdict *verdict,
                    char out[STACK_VERDICT]);
/* Returns false with EXIT_DIFFERENT. The message names the first pixel where the pictures differ,
 * or what could not be checked, and ends with `then`, the consequence; NULL: with none. */
bool report_disagreement(const struct plan *plan, const struct check_verdict *verdict,
                         const char *then, struct error *err);
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

void report_print(const struct plan *plan, const struct render_result *result, struct printed *to);
/* Begins a text with one JSON object. output: the stack's name, sha256: its digest; NULL becomes
 * null. */
void report_json(const struct plan *plan, const struct render_result *result, const char *output,
                 const char *sha256, uint64_t peak_bytes, struct json *json);

/* ---- command.c: spectral render ---- */

/* Renders a scene, or makes a stack again. Fails with EXIT_DIFFERENT if the pictures differ. */
bool command_render(struct options *options, struct error *err);
bool part_accepts(const char *option, const char *value, struct error *err); /* "3/7" */
/* Reads, plans and renders the scene of the options, and reports the result. made: the record of
 * the stack that is made again; NULL: the stack is new. */
bool render_with_options(const struct options *options, const struct render_output *output,
                         const struct record *made, struct error *err);

/* ---- inside this room ---- */

/* Removes --no-check and --strict from the options that the stack records. A stack of the
 * reference's pixels is the same with any check. */
void options_forget_check(struct options *options);

/* ---- again.c: spectral render --again ---- */

/* Makes a stack again from the scene and the options that it records. Fails with EXIT_DIFFERENT if
 * any byte of the new stack differs. */
bool render_again(struct options *options, struct error *err);

#endif
