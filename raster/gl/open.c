/* SPDX-License-Identifier: MIT */
/* Opens OpenGL for a plan, with what it draws on: floats, or counts of 8 or 16 bits. */
#include <stdlib.h>

#include "raster/gl/inside.h"

/* ---- canvases ---- */

static bool check_canvas(const struct gl *gl, int needed_bits, struct error *err)
{
    GLint red_bits = 0, depth_bits = 0, stencil_bits = 0;
    gl->base.call->GetIntegerv(GL_RED_BITS, &red_bits);
    gl->base.call->GetIntegerv(GL_DEPTH_BITS, &depth_bits);
    gl->base.call->GetIntegerv(GL_STENCIL_BITS, &stencil_bits);
    return (red_bits == needed_bits && depth_bits >= 24 && stencil_bits >= 8) ||
           error_unsupported(err,
                             "%s gives %d bits of colour, %d of depth and %d of stencil; %d, 24 "
                             "and 8 are needed",
                             gl->base.contexts->name, red_bits, depth_bits, stencil_bits,
                             needed_bits);
}

/* Each type of buffer has a context of its own. One context for both would work, but OSMesa of Mesa
 * 22.3.6 would make new buffers at every change, and keep the old ones. */
bool gl_draw_into(struct gl *gl, float *floats, bool numbers, struct error *err)
{
    struct canvas *canvas = numbers && gl->numbers ? gl->numbers : gl->colours;
    if (!canvas_use(canvas, floats ? floats : (void *)gl->steps, err))
        return false;
    if (gl->current == canvas)
        return true;
    gl->current = canvas;
    if (gl->base.lit)
        gl_load_view(gl);
    return check_canvas(gl, floats ? 32 : gl->base.plan->options.buffer_bits, err);
}

void gl_clear_stale(struct gl *gl)
{
    bool *is_stale = &gl->is_stale[gl->current != gl->colours];
    if (*is_stale)
        gl_blacken(gl);
    *is_stale = false;
}

static bool open_canvases(struct gl *gl, int n_buffers, struct error *err)
{
    const struct plan *plan = gl->base.plan;
    const bool steps = buffer_steps(plan) > 0;
    const size_t n = (size_t)plan->tile_width * (size_t)plan->tile_height;
    return (!steps || MAKE_ARRAY(gl->steps, n * (size_t)plan->options.buffer_bits / 2, err,
                                 "the pixels of a tile")) &&
           drawing_open(&gl->base, n_buffers, err) &&
           drawing_canvas(&gl->base, steps ? plan->options.buffer_bits : 32, 1, &gl->colours,
                          err) &&
           (!steps || !plan->options.check ||
            drawing_canvas(&gl->base, 32, 1, &gl->numbers, err)) &&
           gl_draw_into(gl, steps ? NULL : gl->base.renderer.buffers[0], false, err) &&
           drawing_accept(&gl->base, err);
}

static void gl_close(struct renderer *renderer)
{
    struct gl *gl = (struct gl *)renderer;
    canvas_close(gl->numbers);
    canvas_close(gl->colours);
    free(gl->steps);
    drawing_close(&gl->base);
}

/* Sets the state of all contexts. */
static bool set_states(struct gl *gl, struct error *err)
{
    gl_set_state(gl);
    if (gl->numbers) {
        if (!functions_succeeded(gl->base.call, err) ||
            !gl_draw_into(gl, gl->base.shown, true, err))
            return false;
        gl_set_state(gl);
        return functions_succeeded(gl->base.call, err) &&
               gl_draw_into(gl, NULL, false, err); /* for uploads */
    }
    return functions_succeeded(gl->base.call, err);
}

bool gl_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    static const struct renderer_kind kind = {.take_scene = drawing_take_scene,
                                              .aim = gl_aim,
                                              .draw = gl_draw,
                                              .identify = gl_identify,
                                              .shown = drawing_shown,
                                              .close = gl_close};
    struct gl *gl;
    *out = NULL;
    if (!MAKE_ARRAY(gl, 1, err, "a renderer"))
        return false;
    *out = &gl->base.renderer;
    gl->base.renderer.kind = &kind;
    gl->base.plan = plan;
    gl->base.n_units = 1;
    gl->group = -1;
    gl->gloss = -1;
    return open_canvases(gl, n_buffers, err) && set_states(gl, err);
}
