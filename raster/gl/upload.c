/* SPDX-License-Identifier: MIT */
/* Meshes and textures as OpenGL keeps them. A spectral texture's texels are uploaded anew for each
 * pass. */

#include "raster/gl/inside.h"

int gl_bind_mesh(const struct gl *gl, int instance)
{
    const GLsizei step = VERTEX_FLOATS * sizeof(GLfloat);
    vertex_buffers_bind_vertices(&gl->vertices, instance);
    gl->call->VertexPointer(3, GL_FLOAT, step, NULL); /* offsets into the bound buffer */
    gl->call->NormalPointer(GL_FLOAT, step, (const void *)(3 * sizeof(GLfloat)));
    if (vertex_buffers_bind_coordinates(&gl->vertices, instance))
        gl->call->TexCoordPointer(COORDINATE_FLOATS, GL_FLOAT, 0, NULL);
    return vertex_buffers_bind(&gl->vertices, instance);
}

/* ---- textures ---- */

/* A spectral texture has no texels yet. */
static bool upload_texture(const struct gl *gl, const struct texture *texture, GLuint *name,
                           struct error *err)
{
    if (!texture_fits(gl->call, texture, err))
        return false;
    gl->call->GenTextures(1, name);
    gl->call->BindTexture(GL_TEXTURE_2D, *name);
    texture_repeats(gl->call, texture);
    if (!texture->spectral)
        gl->call->TexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE32F_ARB, texture->image.width,
                             texture->image.height, 0, GL_LUMINANCE, GL_FLOAT, texture->plane[0]);
    return true;
}

static bool upload_textures(struct gl *gl, struct error *err)
{
    const size_t n = (size_t)gl->plan->n_textures;
    if (!MAKE_ARRAY(gl->textures, n, err, "%zu textures", n))
        return false;
    for (size_t i = 0; i < n; i++)
        if (texture_is_drawn(gl->plan, &gl->plan->textures[i]) &&
            !upload_texture(gl, &gl->plan->textures[i], &gl->textures[i], err))
            return false;
    return true;
}

static void switch_textures(const struct gl *gl, bool on)
{
    (on ? gl->call->Enable : gl->call->Disable)(GL_TEXTURE_2D);
    (on ? gl->call->EnableClientState : gl->call->DisableClientState)(GL_TEXTURE_COORD_ARRAY);
}

void gl_bind_texture(struct gl *gl, const struct texture *texture)
{
    const struct texture *drawn = texture_is_drawn(gl->plan, texture) ? texture : NULL;
    if (!drawn != !gl->texture)
        switch_textures(gl, drawn != NULL);
    if (drawn && drawn != gl->texture)
        gl->call->BindTexture(GL_TEXTURE_2D, gl->textures[texture - gl->plan->textures]);
    gl->texture = drawn;
}

bool gl_upload_bands(struct gl *gl, int first_band, struct error *err)
{
    for (int i = 0; i < gl->plan->n_textures; i++) {
        struct texture *texture = &gl->plan->textures[i];
        if (!gl->textures[i] || !texture->spectral)
            continue;
        gl_bind_texture(gl, texture);
        if (!texture_upload_bands(gl->call, gl->plan, texture, first_band, err))
            return false;
    }
    return true;
}

bool gl_take_scene(struct renderer *renderer, const struct lit_scene *lit, struct error *err)
{
    struct gl *gl = (struct gl *)renderer;
    gl->lit = lit;
    return vertex_buffers_fill(gl->call, lit, &gl->vertices, err) && upload_textures(gl, err) &&
           functions_succeeded(gl->call, err);
}
