/* SPDX-License-Identifier: MIT */
/* Measures whether the passes of a picture show the same triangles: one draws numbers as flat
 * colours from the program's memory, the others draw lit triangles from OpenGL's. */
#include <stdlib.h>
#include <string.h>

#include "raster/traits/traits.h"

enum { TRIANGLES = 300, CORNERS = 3 * TRIANGLES };

/* A frustum of a right angle between 1 and 20; turned, and scaled differently along each axis. */
static void load_perspective(const struct target *target)
{
    const double up = target->mirrors ? -1 : 1;
    const GLdouble projection[16] = {1, 0, 0,          0,  0, up, 0,          0,
                                     0, 0, -21.0 / 19, -1, 0, 0,  -40.0 / 19, 0},
                   model[16] = {0.96, 0.28, 0.1, 0, -0.25, 0.85, 0.3, 0,
                                0.02, -0.3, 1,   0, 0,     0,    0,   1};
    target->call->MatrixMode(GL_PROJECTION);
    target->call->LoadMatrixd(projection);
    target->call->MatrixMode(GL_MODELVIEW);
    target->call->LoadMatrixd(model);
}

/* Triangles of several sizes; some cross the near plane. */
static void make_triangles(struct target *target, struct target_corner out[CORNERS])
{
    for (int t = 0; t < TRIANGLES; t++) {
        double middle[3];
        const double size = t % 10 == 0 ? 4 : 0.4;
        for (int j = 0; j < 3; j++)
            middle[j] = random_in(target, j < 2 ? -4 : -12, j < 2 ? 4 : 1);
        for (int i = 3 * t; i < 3 * t + 3; i++)
            for (int j = 0; j < 3; j++) {
                out[i].position[j] = (float)(middle[j] + random_in(target, -size, size));
                out[i].normal[j] = (float)random_in(target, -1, 1);
                out[i].colour[j] = (float)random_in(target, 0, 1);
            }
    }
}

static void draw_flat(struct target *target, const struct target_corner corners[CORNERS])
{
    target->call->ShadeModel(GL_FLAT);
    target_clear(target);
    target_draw(target, corners, TRIANGLES);
    target->call->ShadeModel(GL_SMOOTH);
    target_read(target);
}

static void draw_lit(struct target *target, const struct target_corner corners[CORNERS])
{
    const struct gl_functions *call = target->call;
    GLuint buffers[2], indices[CORNERS];
    for (GLuint i = 0; i < CORNERS; i++)
        indices[i] = i;
    call->GenBuffers(2, buffers);
    call->BindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    call->BufferData(GL_ARRAY_BUFFER, CORNERS * sizeof *corners, corners, GL_STATIC_DRAW);
    call->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    call->BufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof indices, indices, GL_STATIC_DRAW);
    call->VertexPointer(3, GL_FLOAT, sizeof *corners, NULL);
    call->NormalPointer(GL_FLOAT, sizeof *corners,
                        (const void *)offsetof(struct target_corner, normal));
    call->DisableClientState(GL_COLOR_ARRAY);
    call->EnableClientState(GL_NORMAL_ARRAY);
    call->Enable(GL_LIGHTING);
    call->Enable(GL_NORMALIZE);
    target_clear(target);
    call->DrawElements(GL_TRIANGLES, CORNERS, GL_UNSIGNED_INT, NULL);
    call->Disable(GL_NORMALIZE);
    call->Disable(GL_LIGHTING);
    call->DisableClientState(GL_NORMAL_ARRAY);
    call->EnableClientState(GL_COLOR_ARRAY);
    call->BindBuffer(GL_ARRAY_BUFFER, 0);
    call->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);
    target_read(target);
}

/* The buffers of OpenGL's stay until the context ends. */
bool measure_passes(struct target *target, struct traits *out, struct error *err)
{
    struct target_corner *corners = calloc(CORNERS, sizeof *corners);
    uint32_t *flat = malloc(sizeof target->depths);
    if (corners && flat) {
        load_perspective(target);
        target->call->DepthFunc(GL_LESS);
        for (int n = 0; n < 3; n++) {
            make_triangles(target, corners);
            draw_flat(target, corners);
            memcpy(flat, target->depths, sizeof target->depths);
            draw_lit(target, corners);
            for (int i = 0; i < TARGET * TARGET; i++) {
                const uint32_t lit = target->depths[i / TARGET][i % TARGET];
                out->seen_pixels += (flat[i] & 0xff) > 0;
                out->varying_pixels += lit != flat[i];
            }
        }
    }
    const bool done = corners && flat;
    free(corners);
    free(flat);
    return done || error_memory(err);
}
