/* SPDX-License-Identifier: MIT */
/* Opens OpenGL for a plan, with what it draws on: floats, or counts of 8 or 16 bits. */
#include <stdlib.h>

#include "raster/gl/inside.h"

/* ---- the driver ---- */

void gl_library(char *out, size_t capacity)
{
    contexts_print(out, capacity);
}

/* ---- canvases ---- */

static bool check_canvas(const struct gl *gl, int needed_bits, struct error *err)
{
    GLint red_bits = 0, depth_bits = 0, stencil_bits = 0;
    gl->call->GetIntegerv(GL_RED_BITS, &red_bits);
    gl->call->GetIntegerv(GL_DEPTH_BITS, &depth_bits);
    gl->call->GetIntegerv(GL_STENCIL_BITS, &stencil_bits);
    return (red_bits == needed_bits && depth_bits >= 24 && stencil_bits >= 8) ||
           error_unsupported(err,
                             "%s gives %d bits of colour, %d of depth and %d of stencil; %d, 24 "
                             "and 8 are needed",
                             gl->contexts->name, red_bits, depth_bits, stencil_bits, needed_bits);
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
    if (gl->lit)
        gl_load_view(gl);
    return check_canvas(gl, floats ? 32 : gl->plan->options.buffer_bits, err);
}

void gl_clear_stale(struct gl *gl)
{
    bool *is_stale = &gl->is_stale[gl->current != gl->colours];
    if (*is_stale)
        gl_blacken(gl);
    *is_stale = false;
}

static bool allocate(struct gl *gl, int n_buffers, struct error *err)
{
    const struct plan *plan = gl->plan;
    const size_t n = (size_t)plan->tile_width * (size_t)plan->tile_height;
    const bool check = plan->options.check;
    bool done = true;
    for (int i = 0; i < n_buffers && done; i++)
        done = MAKE_ARRAY(gl->buffers[i], 4 * n, err, "the pixels of a tile");
    return done &&
           (plan->n_light_groups == 1 ||
            MAKE_ARRAY(gl->part, 4 * n, err, "the pixels of a tile")) &&
           (!check || (MAKE_ARRAY(gl->shown, 4 * n, err, "the numbers of a tile") &&
                       MAKE_ARRAY(gl->depths, n, err, "the depths of a tile"))) &&
           (buffer_steps(plan) == 0 ||
            MAKE_ARRAY(gl->steps, n * (size_t)plan->options.buffer_bits / 2, err,
                       "the pixels of a tile"));
}

static bool open_canvas(struct gl *gl, int bits, struct canvas **out, struct error *err)
{
    const struct canvas_size size = {bits, gl->plan->tile_width, gl->plan->tile_height, 1};
    return canvas_open(gl->contexts, &size, out, err);
}

static bool open_canvases(struct gl *gl, int n_buffers, struct error *err)
{
    const struct plan *plan = gl->plan;
    const struct context_wish wish = {plan->options.gl_library, plan->options.gl_driver,
                                      plan->options.threads, GL_WITHOUT_SHADERS};
    struct driver_threads before;
    if (!allocate(gl, n_buffers, err))
        return false;
    driver_count_threads(&before);
    if (!contexts_open(&wish, &gl->contexts, err))
        return false;
    gl->call = &gl->contexts->call;
    return open_canvas(gl, gl->steps ? plan->options.buffer_bits : 32, &gl->colours, err) &&
           (!gl->steps || !plan->options.check || open_canvas(gl, 32, &gl->numbers, err)) &&
           gl_draw_into(gl, gl->steps ? NULL : gl->buffers[0], false, err) &&
           opened_accept(&gl->renderer, plan, gl->contexts, &before, err);
}

static void gl_close(struct renderer *renderer)
{
    struct gl *gl = (struct gl *)renderer;
    canvas_close(gl->numbers);
    canvas_close(gl->colours);
    contexts_close(gl->contexts);
    for (int i = 0; i < MOST_BUFFERS; i++)
        free(gl->buffers[i]);
    vertex_buffers_free(&gl->vertices);
    FREE_ALL(gl->textures, gl->part, gl->shown, gl->steps, gl->depths, gl);
}

static const float *gl_pixels(const struct renderer *renderer, int buffer)
{
    return ((const struct gl *)renderer)->buffers[buffer];
}

/* Sets the state of all contexts. */
static bool set_states(struct gl *gl, struct error *err)
{
    gl_set_state(gl);
    if (gl->numbers) {
        if (!functions_succeeded(gl->call, err) || !gl_draw_into(gl, gl->shown, true, err))
            return false;
        gl_set_state(gl);
        return functions_succeeded(gl->call, err) &&
               gl_draw_into(gl, NULL, false, err); /* for uploads */
    }
    return functions_succeeded(gl->call, err);
}

bool gl_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    static const struct renderer_kind kind = {.take_scene = gl_take_scene,
                                              .aim = gl_aim,
                                              .draw = gl_draw,
                                              .pixels = gl_pixels,
                                              .identify = gl_identify,
                                              .shown = gl_shown,
                                              .close = gl_close};
    struct gl *gl;
    *out = NULL;
    if (!MAKE_ARRAY(gl, 1, err, "a renderer"))
        return false;
    *out = &gl->renderer;
    gl->renderer.kind = &kind;
    gl->plan = plan;
    gl->group = -1;
    gl->gloss = -1;
    return open_canvases(gl, n_buffers, err) && set_states(gl, err);
}
