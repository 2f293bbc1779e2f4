/* SPDX-License-Identifier: MIT */
/* Finds which triangle OpenGL shows at each pixel, as raster/gl does. All programs compute
 * positions by the same expression of the same numbers, which is declared invariant. */
#include "raster/beside/shader/inside.h"

enum { POSITION, NUMBER, COORDINATES };

static void draw_corners(struct drawing *of, const struct numbered_vertex *corners, int n)
{
    const struct gl_functions *call = of->call;
    const GLsizei step = sizeof *corners;
    call->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)n * step, corners, GL_STREAM_DRAW);
    call->VertexAttribPointer(POSITION, 3, GL_FLOAT, GL_FALSE, step, NULL);
    call->VertexAttribPointer(NUMBER, 3, GL_FLOAT, GL_FALSE, step,
                              (const void *)sizeof corners->position); /* into the bound buffer */
    call->DrawArrays(GL_TRIANGLES, 0, n);
}

static void place(struct drawing *of, int instance)
{
    const struct shader *shader = (const struct shader *)of;
    shader_place(shader, &shader->numbers, instance);
}

/* Lets the first n buffers of colours be drawn. */
static void choose_colours(const struct shader *shader, int n)
{
    GLenum colours[MOST_PASSES];
    for (int i = 0; i < n; i++)
        colours[i] = GL_COLOR_ATTACHMENT0 + (GLenum)i;
    shader->base.call->DrawBuffers(n, colours);
}

bool shader_identify(struct renderer *renderer, struct error *err)
{
    struct shader *shader = (struct shader *)renderer;
    static const struct numbered_draw by = {place, draw_corners};
    if (!program_use_numbers(shader, err))
        return false;
    shader_clear(shader);
    choose_colours(shader, 1);
    shader->base.call->Enable(GL_STENCIL_TEST);
    shader->base.call->DisableVertexAttribArray(COORDINATES);
    shader->base.call->BindBuffer(GL_ARRAY_BUFFER, shader->stream);
    const bool done = numbers_draw(&shader->base, &by, err);
    shader->base.call->Disable(GL_STENCIL_TEST);
    choose_colours(shader, shader->base.n_units);
    canvas_read(shader->canvas, 0, shader->base.shown);
    drawing_read_depths(&shader->base);
    return done && functions_succeeded(shader->base.call, err);
}
