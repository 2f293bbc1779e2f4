/* SPDX-License-Identifier: MIT */
/* Meshes and textures as OpenGL keeps them. A spectral texture's texels are uploaded anew for each
 * pass. */

#include "raster/gl/inside.h"

int gl_bind_mesh(const struct gl *gl, int instance)
{
    const GLsizei step = VERTEX_FLOATS * sizeof(GLfloat);
    mesh_bind_vertices(&gl->base, instance);
    gl->base.call->VertexPointer(3, GL_FLOAT, step, NULL); /* offsets into the bound buffer */
    gl->base.call->NormalPointer(GL_FLOAT, step, (const void *)(3 * sizeof(GLfloat)));
    if (mesh_bind_coordinates(&gl->base, instance))
        gl->base.call->TexCoordPointer(COORDINATE_FLOATS, GL_FLOAT, 0, NULL);
    return mesh_bind_triangles(&gl->base, instance);
}

/* ---- textures ---- */

static void switch_textures(const struct gl *gl, bool on)
{
    (on ? gl->base.call->Enable : gl->base.call->Disable)(GL_TEXTURE_2D);
    (on ? gl->base.call->EnableClientState
        : gl->base.call->DisableClientState)(GL_TEXTURE_COORD_ARRAY);
}

void gl_bind_texture(struct gl *gl, const struct texture *texture)
{
    const struct texture *drawn = texture_is_drawn(gl->base.plan, texture) ? texture : NULL;
    if (!drawn != !gl->texture)
        switch_textures(gl, drawn != NULL);
    if (drawn && drawn != gl->texture)
        texture_bind(&gl->base, (int)(texture - gl->base.plan->textures), 0);
    gl->texture = drawn;
}

bool gl_upload_bands(struct gl *gl, int first_band, struct error *err)
{
    for (int i = 0; i < gl->base.plan->n_textures; i++) {
        const struct texture *texture = &gl->base.plan->textures[i];
        if (!gl->base.textures[i] || !texture->spectral)
            continue;
        gl_bind_texture(gl, texture);
        if (!texture_upload_bands(&gl->base, i, first_band, err))
            return false;
    }
    return true;
}
