/* SPDX-License-Identifier: MIT */
/* Opens OpenGL with shaders for a plan. */
#include <stdlib.h>

#include "data/base/base.h"
#include "raster/beside/shader/inside.h"

/* Sets the state that no pass changes. */
static void set_state(struct shader *shader)
{
    const struct gl_functions *call = shader->base.call;
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

/* Depths can be read by OpenGL, and by OpenGL ES with an extension. */
static void find_depths(struct drawing *of)
{
    of->renderer.lacks.depths = of->plan->options.check && of->plan->options.gl_way == GL_ES &&
                                !contexts_have(of->contexts, "GL_NV_read_depth_stencil");
    if (!of->renderer.lacks.depths)
        return;
    free(of->depths);
    of->depths = NULL;
}

static bool open_all(struct shader *shader, int n_buffers, struct error *err)
{
    struct drawing *of = &shader->base;
    const size_t n = 4 * (size_t)of->plan->tile_width * (size_t)of->plan->tile_height;
    for (int i = 0; i < of->n_units; i++)
        if (!MAKE_ARRAY(shader->ready[i], n, err, "the pixels of a tile"))
            return false;
    if (!MAKE_ARRAY(shader->programs, program_count(of->plan), err, "the shaders") ||
        !drawing_open(of, n_buffers, err) ||
        !drawing_canvas(of, 32, of->n_units, &shader->canvas, err) ||
        !canvas_use(shader->canvas, shader->ready[0], err))
        return false;
    find_depths(of);
    set_state(shader);
    return drawing_accept(of, err) && functions_succeeded(of->call, err);
}

static void shader_close(struct renderer *renderer)
{
    struct shader *shader = (struct shader *)renderer;
    canvas_close(shader->canvas);
    for (int i = 0; i < MOST_PASSES; i++)
        free(shader->ready[i]);
    FREE_ALL(shader->programs, shader->order);
    drawing_close(&shader->base);
}

bool shader_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    static const struct renderer_kind kind = {.take_scene = drawing_take_scene,
                                              .aim = shader_aim,
                                              .expect = shader_expect,
                                              .draw = shader_draw,
                                              .identify = shader_identify,
                                              .shown = drawing_shown,
                                              .close = shader_close};
    struct shader *shader;
    *out = NULL;
    if (!MAKE_ARRAY(shader, 1, err, "a renderer"))
        return false;
    *out = &shader->base.renderer;
    shader->base.renderer.kind = &kind;
    shader->base.plan = plan;
    shader->base.n_units = plan->n_passes < MOST_PASSES ? plan->n_passes : MOST_PASSES;
    shader->batch = -1;
    return open_all(shader, n_buffers, err);
}
