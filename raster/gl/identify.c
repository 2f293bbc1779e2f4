/* SPDX-License-Identifier: MIT */
/* Finds which triangle OpenGL shows at each pixel, its depth, and how many fragments OpenGL has
 * drawn there: draws all instances once more, with their numbers as flat colours, while the stencil
 * counts fragments, hidden ones too. Corners, order and matrices are the same, so OpenGL must show
 * the same triangles as in colour (section 2.22 of the OpenGL 2.1 specification, invariance). */
#include <stdlib.h>

#include "data/mesh/mesh.h"
#include "data/scene/scene.h"
#include "raster/context/context.h"
#include "raster/gl/gl.h"

/* Triangles given to OpenGL at once: few enough to stay in the second-level cache. */
enum { BATCH = 4096 };

/* The number is that of shown_of. */
struct numbered_vertex {
    GLfloat position[3], number[3];
};

static void number_triangle(const struct mesh *mesh, int triangle, int placed,
                            struct numbered_vertex out[3])
{
    for (int i = 0; i < 3; i++) {
        struct vector p = mesh->vertices[mesh->triangles[triangle][i]].position;
        out[i] = (struct numbered_vertex){
            {(GLfloat)p.x, (GLfloat)p.y, (GLfloat)p.z},
            {(GLfloat)(triangle & 0xffff), (GLfloat)(triangle >> 16), (GLfloat)(placed + 1)}};
    }
}

static void draw_batch(const struct gl *gl, const struct numbered_vertex *batch, int n_triangles)
{
    gl->call->VertexPointer(3, GL_FLOAT, sizeof *batch, batch->position);
    gl->call->ColorPointer(3, GL_FLOAT, sizeof *batch, batch->number);
    gl->call->DrawArrays(GL_TRIANGLES, 0, 3 * n_triangles);
}

static void draw_numbers(const struct gl *gl, int placed, struct numbered_vertex *batch)
{
    const struct placed_instance *instance = &gl->plan->instances[placed];
    const struct mesh *mesh = &gl->plan->meshes[instance->mesh].mesh;
    const bool *hidden = gl->lit->bounds[placed].hidden;
    int n = 0;
    gl_load_matrix(gl, &instance->instance.model_view);
    for (int i = 0; i < mesh->n_triangles; i++) {
        if (hidden && hidden[i])
            continue;
        number_triangle(mesh, i, placed, batch + 3 * (size_t)n++);
        if (n == BATCH) {
            draw_batch(gl, batch, n);
            n = 0;
        }
    }
    if (n > 0)
        draw_batch(gl, batch, n);
}

static void draw_instances(struct gl *gl, struct numbered_vertex *batch)
{
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
    for (int i = 0; i < gl->plan->n_instances; i++)
        if (surface_reaches(&gl->lit->bounds[i], &gl->tile))
            draw_numbers(gl, i, batch);
    gl->call->DisableClientState(GL_COLOR_ARRAY);
    gl->call->EnableClientState(GL_NORMAL_ARRAY);
    gl->call->Disable(GL_STENCIL_TEST);
    gl->call->Enable(GL_LIGHTING);
    if (is_smooth)
        gl->call->ShadeModel(GL_SMOOTH);
}

bool gl_identify(struct renderer *renderer, struct error *err)
{
    struct gl *gl = (struct gl *)renderer;
    struct numbered_vertex *batch = malloc(3 * BATCH * sizeof *batch);
    if (!batch)
        return error_memory(err);
    if (!gl_draw_into(gl, gl->shown, true, err)) {
        free(batch);
        return false;
    }
    draw_instances(gl, batch);
    canvas_fill(gl->current);
    gl->call->ReadPixels(0, 0, gl->plan->tile_width, gl->plan->tile_height, GL_DEPTH_STENCIL,
                         GL_UNSIGNED_INT_24_8, gl->depths);
    free(batch);
    if (!gl_succeeded(gl, err))
        return false;
    /* OSMesa fills the buffer once more when another context becomes current */
    return !gl->numbers || gl_draw_into(gl, NULL, false, err);
}

struct shown gl_shown(const struct renderer *renderer, int x, int y)
{
    const struct gl *gl = (const struct gl *)renderer;
    size_t width = (size_t)gl->plan->tile_width,
           row = (size_t)(gl->flipped ? y : gl->plan->tile_height - 1 - y);
    const float *number = gl->shown + 4 * ((size_t)y * width + (size_t)x);
    uint32_t depth = gl->depths[row * width + (size_t)x];
    return shown_of(gl->plan, number, depth);
}
