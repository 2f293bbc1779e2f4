/* SPDX-License-Identifier: MIT */
/* The loop over tiles and passes, and the report of it. */
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
    bool clips; /* a vertex is brighter than that */
    char gl_renderer[128], gl_version[128];
    const struct driver *driver;
    struct gl_work gl;
    struct light_work light;
    struct check_verdict check;
    struct odd_samples odd;
    struct stack_difference difference; /* from the stack that was to be made again */
    struct render_seconds seconds;
};
struct render_output {
    const char *path;  /* of the stack; NULL: none is written */
    const char *again; /* the stack that it shall be the same as, to the last byte; NULL: none */
    bool keep;         /* also what failed its check, or is not the same, is stored */
    bool discard;      /* nothing is stored: the stack is only compared with the other */
};
/* Called between passes with done of all steps. */
struct render_progress {
    void (*step)(void *context, long done, long all);
    void *context;
};
/* Renders into a stack. True also if the picture failed its check, or is not the same: the result
 * tells, and render_agreed. */
bool render(const struct plan *plan, const struct render_output *output,
            const struct render_progress *progress, struct render_result *out, struct error *err);
bool render_agreed(const struct render_result *result);
/* Whose pixels are stored: "raster", or OpenGL's GL_RENDERER. */
const char *render_stored(const struct plan *plan, const struct render_result *result);

/* ---- report.c: results in words and as JSON ---- */

/* The verdict in one line of ASCII, for the stack. */
void report_verdict(const struct plan *plan, const struct check_verdict *verdict, char *out,
                    size_t capacity);
/* Returns false with EXIT_DIFFERENT: where the pictures first differ, and `then` what follows from
 * it. */
bool report_difference(const struct plan *plan, const struct check_verdict *verdict,
                       const char *then, struct error *err);
/* The same for a stack made again that is not the same; `made` is how the one at `path` was made.
 */
bool report_not_again(const struct plan *plan, const struct render_result *result, const char *path,
                      const struct record *made, const char *then, struct error *err);
void report_print(const struct plan *plan, const struct render_result *result, FILE *to);
/* One JSON object, allocated; NULL: no memory. output and sha256 may be NULL. */
char *report_json(const struct plan *plan, const struct render_result *result, const char *output,
                  const char *sha256, uint64_t peak_bytes);

/* ---- command.c: spectral render ---- */

/* Renders a scene, or makes a stack again. Fails with EXIT_DIFFERENT where the pictures differ. */
bool command_render(struct options *options, struct error *err);
/* Renders a scene to its stack and reports. */
bool render_scene(struct options *options, struct error *err);

/* ---- Inside this room ---- */

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
