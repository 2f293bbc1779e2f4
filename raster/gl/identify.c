/* SPDX-License-Identifier: MIT */
/* Finds which triangle OpenGL shows at each pixel, its depth, and how many fragments OpenGL has
 * drawn there: draws all instances once more, with their numbers as flat colours, while the stencil
 * counts fragments, hidden ones too. Corners, order and matrices are the same, so OpenGL must show
 * the same triangles as in colour (section 2.22 of the OpenGL 2.1 specification, invariance). */
#include "data/scene/scene.h"
#include "raster/gl/inside.h"

static void draw_batch(void *of, const struct numbered_vertex *corners, int n)
{
    const struct gl *gl = of;
    gl->call->VertexPointer(3, GL_FLOAT, sizeof *corners, corners->position);
    gl->call->ColorPointer(3, GL_FLOAT, sizeof *corners, corners->number);
    gl->call->DrawArrays(GL_TRIANGLES, 0, n);
}

static void place(void *of, int instance)
{
    const struct gl *gl = of;
    gl_load_matrix(gl, &gl->plan->instances[instance].instance.model_view);
}

static bool draw_instances(struct gl *gl, struct error *err)
{
    const struct numbered_draw by = {place, draw_batch, gl};
    const bool is_smooth = gl->plan->scene->shading != SHADING_FLAT;
    gl_clear_stale(gl);
    gl->call->Disable(GL_LIGHTING);
    gl->call->Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    if (is_smooth)
        gl->call->ShadeModel(GL_FLAT);
    gl->call->Enable(GL_STENCIL_TEST);
    gl->call->BindBuffer(GL_ARRAY_BUFFER, 0);
    gl->call->DisableClientState(GL_NORMAL_ARRAY);
    gl->call->EnableClientState(GL_COLOR_ARRAY);
    const bool done = numbers_draw(gl->lit, &gl->tile, &by, err);
    gl->call->DisableClientState(GL_COLOR_ARRAY);
    gl->call->EnableClientState(GL_NORMAL_ARRAY);
    gl->call->Disable(GL_STENCIL_TEST);
    gl->call->Enable(GL_LIGHTING);
    if (is_smooth)
        gl->call->ShadeModel(GL_SMOOTH);
    return done;
}

bool gl_identify(struct renderer *renderer, struct error *err)
{
    struct gl *gl = (struct gl *)renderer;
    if (!gl_draw_into(gl, gl->shown, true, err) || !draw_instances(gl, err))
        return false;
    canvas_fill(gl->current);
    gl->call->ReadPixels(0, 0, gl->plan->tile_width, gl->plan->tile_height, GL_DEPTH_STENCIL,
                         GL_UNSIGNED_INT_24_8, gl->depths);
    if (!functions_succeeded(gl->call, err))
        return false;
    /* OSMesa fills the buffer once more when another context becomes current */
    return !gl->numbers || gl_draw_into(gl, NULL, false, err);
}

struct shown gl_shown(const struct renderer *renderer, int x, int y)
{
    const struct gl *gl = (const struct gl *)renderer;
    return shown_at(gl->plan, gl->shown, gl->depths, gl->contexts->flipped, x, y);
}
