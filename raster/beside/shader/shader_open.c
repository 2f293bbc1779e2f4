/* SPDX-License-Identifier: MIT */
/* Opens OpenGL with shaders for a plan. */
#include <stdlib.h>

#include "data/base/base.h"
#include "raster/beside/shader/inside.h"

/* ---- buffers ---- */

static bool allocate(struct shader *shader, int n_buffers, struct error *err)
{
    const struct plan *plan = shader->plan;
    const size_t n = 4 * (size_t)plan->tile_width * (size_t)plan->tile_height;
    bool done = true;
    for (int i = 0; i < n_buffers && done; i++)
        done = MAKE_ARRAY(shader->buffers[i], n, err, "the pixels of a tile");
    for (int i = 0; i < shader->n_passes && done; i++)
        done = MAKE_ARRAY(shader->ready[i], n, err, "the pixels of a tile");
    return done &&
           (plan->n_light_groups == 1 ||
            MAKE_ARRAY(shader->part, n, err, "the pixels of a tile")) &&
           (!plan->options.check || MAKE_ARRAY(shader->shown, n, err, "the numbers of a tile"));
}

/* Depths can be read by OpenGL, and by OpenGL ES with an extension. */
static bool open_depths(struct shader *shader, struct error *err)
{
    const struct plan *plan = shader->plan;
    if (!plan->options.check)
        return true;
    shader->renderer.lacks.depths = plan->options.gl_way == GL_ES &&
                                    !contexts_have(shader->contexts, "GL_NV_read_depth_stencil");
    if (shader->renderer.lacks.depths)
        return true;
    return MAKE_ARRAY(shader->depths, (size_t)plan->tile_width * (size_t)plan->tile_height, err,
                      "the depths of a tile");
}

static bool open_canvas(struct shader *shader, struct error *err)
{
    const struct plan *plan = shader->plan;
    const struct canvas_size size = {32, plan->tile_width, plan->tile_height, shader->n_passes};
    return canvas_open(shader->contexts, &size, &shader->canvas, err) &&
           canvas_use(shader->canvas, shader->ready[0], err);
}

/* ---- state ---- */

/* Sets the state that no pass changes. */
static void set_state(struct shader *shader)
{
    const struct gl_functions *call = shader->call;
    GLuint array;
    call->GenVertexArrays(1, &array);
    call->BindVertexArray(array);
    call->EnableVertexAttribArray(0);
    call->EnableVertexAttribArray(1);
    call->GenBuffers(1, &shader->stream);
    call->Disable(GL_DITHER);
    call->Enable(GL_DEPTH_TEST);
    call->DepthFunc(GL_LESS);
    call->ClearColor(0, 0, 0, 0);
    call->StencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP);
}

static bool open_all(struct shader *shader, int n_buffers, struct error *err)
{
    const struct plan_options *options = &shader->plan->options;
    const struct context_wish wish = {options->gl_library, options->gl_driver, options->threads,
                                      options->gl_way};
    struct driver_threads before;
    if (!allocate(shader, n_buffers, err))
        return false;
    driver_count_threads(&before);
    if (!contexts_open(&wish, &shader->contexts, err))
        return false;
    shader->call = &shader->contexts->call;
    if (!open_canvas(shader, err) || !open_depths(shader, err))
        return false;
    set_state(shader);
    return opened_accept(&shader->renderer, shader->plan, shader->contexts, &before, err) &&
           functions_succeeded(shader->call, err);
}

static void shader_close(struct renderer *renderer)
{
    struct shader *shader = (struct shader *)renderer;
    canvas_close(shader->canvas);
    contexts_close(shader->contexts);
    vertex_buffers_free(&shader->vertices);
    for (int i = 0; i < MOST_PIXEL_BUFFERS; i++)
        free(shader->buffers[i]);
    for (int i = 0; i < MOST_PASSES; i++)
        free(shader->ready[i]);
    FREE_ALL(shader->programs, shader->textures, shader->part, shader->shown, shader->depths,
             shader->order, shader);
}

static const float *shader_pixels(const struct renderer *renderer, int buffer)
{
    return ((const struct shader *)renderer)->buffers[buffer];
}

bool shader_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    static const struct renderer_kind kind = {.take_scene = shader_take_scene,
                                              .aim = shader_aim,
                                              .expect = shader_expect,
                                              .draw = shader_draw,
                                              .pixels = shader_pixels,
                                              .identify = shader_identify,
                                              .shown = shader_shown,
                                              .close = shader_close};
    struct shader *shader;
    *out = NULL;
    if (!MAKE_ARRAY(shader, 1, err, "a renderer"))
        return false;
    *out = &shader->renderer;
    shader->renderer.kind = &kind;
    shader->plan = plan;
    shader->n_passes = plan->n_passes < MOST_PASSES ? plan->n_passes : MOST_PASSES;
    shader->batch = -1;
    return open_all(shader, n_buffers, err);
}
