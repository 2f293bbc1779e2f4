/* SPDX-License-Identifier: MIT */
/* Renders a plan into a stack, tile by tile and pass by pass, and reports what it did and found. It
 * brings reference, OpenGL, check and stack together, and may not know how any of them works. */
#ifndef RENDER_H
#define RENDER_H

#include "data/base/base.h"
#include "data/options/options.h"
#include "data/record/record.h"
#include "data/stack/stack.h"
#include "raster/check/check.h"
#include "raster/driver/driver.h"
#include "raster/gl/gl.h"
#include "raster/plan/plan.h"
#include "raster/radiance/radiance.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* ---- render.c: the loop over tiles and passes ---- */

struct render_seconds {
    double read, plan, gl, raster, check, write, total;
};
struct render_result {
    double full_scale;
    bool clips; /* a vertex is brighter than full_scale */
    char gl_renderer[128], gl_version[128];
    const struct driver *driver; /* its bounds hold */
    struct gl_work gl;
    struct light_work light;
    struct check_verdict check;
    struct odd_samples odd;
    struct stack_difference difference; /* from the stack that was to be made again */
    struct render_seconds seconds;
};
struct render_output {
    const char *path;  /* of the stack; NULL: none is written */
    const char *again; /* a stack with which the new one is compared, byte by byte; NULL: none */
    bool keep;         /* store the stack even if it failed its check, or differs from `again` */
    bool discard;      /* only compare the stack with `again`: store none */
};
/* Renders into a stack. Returns true also if the picture failed its check, or differs from the
 * stack that it was compared with: ask render_agreed. progress NULL: none. After a failure, an
 * interruption or a difference (without `keep`) no file has been created or changed. */
bool render(const struct plan *plan, const struct render_output *output,
            struct progress_line *progress, struct render_result *out, struct error *err);
bool render_agreed(const struct render_result *result);
/* Returns the renderer of the stored pixels: "raster", or OpenGL's GL_RENDERER. */
const char *render_stored(const struct plan *plan, const struct render_result *result);

/* ---- report.c: results in words and as JSON ---- */

/* Writes the verdict in one line of ASCII, for the stack. */
void report_verdict(const struct plan *plan, const struct check_verdict *verdict, char *out,
                    size_t capacity);
/* Returns false with EXIT_DIFFERENT and a message: where the pictures first differ, then `then`,
 * the consequence. */
bool report_difference(const struct plan *plan, const struct check_verdict *verdict,
                       const char *then, struct error *err);
/* Likewise reports how a stack made again differs from the one at `path`, which has the record
 * `made`. */
bool report_not_again(const struct plan *plan, const struct render_result *result, const char *path,
                      const struct record *made, const char *then, struct error *err);
void report_print(const struct plan *plan, const struct render_result *result, FILE *to);
/* Returns one JSON object, allocated; NULL: no memory. output and sha256 may be NULL. */
char *report_json(const struct plan *plan, const struct render_result *result, const char *output,
                  const char *sha256, uint64_t peak_bytes);

/* ---- command.c: spectral render ---- */

/* Renders a scene, or makes a stack again. Fails with EXIT_DIFFERENT where the pictures differ. */
bool command_render(struct options *options, struct error *err);
/* Renders a scene to its stack and reports. */
bool render_scene(struct options *options, struct error *err);

/* ---- inside this room ---- */

/* Reads, plans and renders the scene of the options, and reports. made: the record that the stack
 * is made again from; NULL: it is a new one. */
bool render_with_options(const struct options *options, const struct render_output *output,
                         const struct record *made, struct error *err);
/* Takes --no-check and --strict out of the options that the stack records: the reference's stack is
 * the same, however it was checked. */
void options_forget_check(struct options *options);

/* ---- again.c: spectral render --again ---- */

/* Makes a stack again from the scene and the options that it records. Fails with EXIT_DIFFERENT
 * where the new stack is not the same to the last byte. */
bool render_again(struct options *options, struct error *err);

#endif
