/* SPDX-License-Identifier: MIT */
/* Meshes and textures as the shaders get them. */

#include "data/base/base.h"
#include "raster/beside/shader/inside.h"

enum { POSITION, NORMAL, COORDINATES }; /* the inputs of the vertex shaders */

/* ---- meshes ---- */

int shader_bind_mesh(const struct shader *shader, int instance)
{
    const struct gl_functions *call = shader->base.call;
    const GLsizei step = VERTEX_FLOATS * sizeof(GLfloat);
    mesh_bind_vertices(&shader->base, instance);
    call->VertexAttribPointer(POSITION, 3, GL_FLOAT, GL_FALSE, step, NULL);
    call->VertexAttribPointer(NORMAL, 3, GL_FLOAT, GL_FALSE, step,
                              (const void *)(3 * sizeof(GLfloat))); /* into the bound buffer */
    if (mesh_bind_coordinates(&shader->base, instance)) {
        call->EnableVertexAttribArray(COORDINATES);
        call->VertexAttribPointer(COORDINATES, COORDINATE_FLOATS, GL_FLOAT, GL_FALSE, 0, NULL);
    } else {
        call->DisableVertexAttribArray(COORDINATES);
    }
    return mesh_bind_triangles(&shader->base, instance);
}

/* ---- textures ---- */

void shader_bind_texture(const struct shader *shader, const struct texture *texture)
{
    for (int k = 0; k < (texture->spectral ? shader->base.n_units : 1); k++)
        texture_bind(&shader->base, (int)(texture - shader->base.plan->textures), k);
}

bool shader_upload_bands(struct shader *shader, const int *first_bands, int n, struct error *err)
{
    const struct drawing *of = &shader->base;
    for (int i = 0; i < of->plan->n_textures; i++)
        for (int k = 0; k < n; k++) {
            if (!of->textures[i * of->n_units] || !of->plan->textures[i].spectral)
                continue;
            texture_bind(of, i, k);
            if (!texture_upload_bands(of, i, first_bands[k], err))
                return false;
        }
    return true;
}
