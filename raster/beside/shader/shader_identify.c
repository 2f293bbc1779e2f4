/* SPDX-License-Identifier: MIT */
/* Finds which triangle OpenGL shows at each pixel, as raster/gl does. All programs compute
 * positions by the same expression of the same numbers, which is declared invariant. */
#include "raster/beside/shader/inside.h"

enum { POSITION, NUMBER, COORDINATES };

static void draw_corners(void *of, const struct numbered_vertex *corners, int n)
{
    const struct shader *shader = of;
    const struct gl_functions *call = shader->call;
    const GLsizei step = sizeof *corners;
    call->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)n * step, corners, GL_STREAM_DRAW);
    call->VertexAttribPointer(POSITION, 3, GL_FLOAT, GL_FALSE, step, NULL);
    call->VertexAttribPointer(NUMBER, 3, GL_FLOAT, GL_FALSE, step,
                              (const void *)sizeof corners->position); /* into the bound buffer */
    call->DrawArrays(GL_TRIANGLES, 0, n);
}

static void place(void *of, int instance)
{
    const struct shader *shader = of;
    shader_place(shader, &shader->numbers, instance);
}

/* Lets the first n buffers of colours be drawn. */
static void choose_colours(const struct shader *shader, int n)
{
    GLenum colours[MOST_PASSES];
    for (int i = 0; i < n; i++)
        colours[i] = GL_COLOR_ATTACHMENT0 + (GLenum)i;
    shader->call->DrawBuffers(n, colours);
}

/* OpenGL ES reads depths where an extension allows it. */
static void read_depths(struct shader *shader)
{
    if (shader->depths)
        shader->call->ReadPixels(0, 0, shader->plan->tile_width, shader->plan->tile_height,
                                 GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, shader->depths);
}

bool shader_identify(struct renderer *renderer, struct error *err)
{
    struct shader *shader = (struct shader *)renderer;
    const struct numbered_draw by = {place, draw_corners, shader};
    if (!program_use_numbers(shader, err))
        return false;
    shader_clear(shader);
    choose_colours(shader, 1);
    shader->call->Enable(GL_STENCIL_TEST);
    shader->call->DisableVertexAttribArray(COORDINATES);
    shader->call->BindBuffer(GL_ARRAY_BUFFER, shader->stream);
    const bool done = numbers_draw(shader->lit, &shader->tile, &by, err);
    shader->call->Disable(GL_STENCIL_TEST);
    choose_colours(shader, shader->n_passes);
    canvas_read(shader->canvas, 0, shader->shown);
    read_depths(shader);
    return done && functions_succeeded(shader->call, err);
}

struct shown shader_shown(const struct renderer *renderer, int x, int y)
{
    const struct shader *shader = (const struct shader *)renderer;
    return shown_at(shader->plan, shader->shown, shader->depths, shader->contexts->flipped, x, y);
}
