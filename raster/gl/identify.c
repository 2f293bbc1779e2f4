/* SPDX-License-Identifier: MIT */
/* Finds which triangle OpenGL shows at each pixel, its depth, and how many fragments OpenGL has
 * drawn there: draws all instances once more, with their numbers as flat colours, while the stencil
 * counts fragments, hidden ones too. Corners, order and matrices are the same, so OpenGL must show
 * the same triangles as in colour (section 2.22 of the OpenGL 2.1 specification, invariance). */
#include "data/scene/scene.h"
#include "raster/gl/inside.h"

static void draw_batch(struct drawing *of, const struct numbered_vertex *corners, int n)
{
    of->call->VertexPointer(3, GL_FLOAT, sizeof *corners, corners->position);
    of->call->ColorPointer(3, GL_FLOAT, sizeof *corners, corners->number);
    of->call->DrawArrays(GL_TRIANGLES, 0, n);
}

static void place(struct drawing *of, int instance)
{
    gl_load_matrix(of->call, &of->plan->instances[instance].instance.model_view);
}

static bool draw_instances(struct gl *gl, struct error *err)
{
    static const struct numbered_draw by = {place, draw_batch};
    const struct gl_functions *call = gl->base.call;
    const bool is_smooth = gl->base.plan->scene->shading != SHADING_FLAT;
    gl_clear_stale(gl);
    call->Disable(GL_LIGHTING);
    call->Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    if (is_smooth)
        call->ShadeModel(GL_FLAT);
    call->Enable(GL_STENCIL_TEST);
    call->BindBuffer(GL_ARRAY_BUFFER, 0);
    call->DisableClientState(GL_NORMAL_ARRAY);
    call->EnableClientState(GL_COLOR_ARRAY);
    const bool done = numbers_draw(&gl->base, &by, err);
    call->DisableClientState(GL_COLOR_ARRAY);
    call->EnableClientState(GL_NORMAL_ARRAY);
    call->Disable(GL_STENCIL_TEST);
    call->Enable(GL_LIGHTING);
    if (is_smooth)
        call->ShadeModel(GL_SMOOTH);
    return done;
}

bool gl_identify(struct renderer *renderer, struct error *err)
{
    struct gl *gl = (struct gl *)renderer;
    if (!gl_draw_into(gl, gl->base.shown, true, err) || !draw_instances(gl, err))
        return false;
    canvas_fill(gl->current);
    drawing_read_depths(&gl->base);
    if (!functions_succeeded(gl->base.call, err))
        return false;
    /* OSMesa fills the buffer once more when another context becomes current */
    return !gl->numbers || gl_draw_into(gl, NULL, false, err);
}
