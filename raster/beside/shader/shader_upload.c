/* SPDX-License-Identifier: MIT */
/* Meshes and textures as the shaders get them. */

#include "data/base/base.h"
#include "raster/beside/shader/inside.h"

enum { POSITION, NORMAL, COORDINATES }; /* the inputs of the vertex shaders */

/* ---- meshes ---- */

int shader_bind_mesh(const struct shader *shader, int instance)
{
    const struct gl_functions *call = shader->call;
    const GLsizei step = VERTEX_FLOATS * sizeof(GLfloat);
    vertex_buffers_bind_vertices(&shader->vertices, instance);
    call->VertexAttribPointer(POSITION, 3, GL_FLOAT, GL_FALSE, step, NULL);
    call->VertexAttribPointer(NORMAL, 3, GL_FLOAT, GL_FALSE, step,
                              (const void *)(3 * sizeof(GLfloat))); /* into the bound buffer */
    if (vertex_buffers_bind_coordinates(&shader->vertices, instance)) {
        call->EnableVertexAttribArray(COORDINATES);
        call->VertexAttribPointer(COORDINATES, COORDINATE_FLOATS, GL_FLOAT, GL_FALSE, 0, NULL);
    } else {
        call->DisableVertexAttribArray(COORDINATES);
    }
    return vertex_buffers_bind(&shader->vertices, instance);
}

/* ---- textures ---- */

static void bind_unit(const struct shader *shader, int index, int unit)
{
    shader->call->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    shader->call->BindTexture(GL_TEXTURE_2D, shader->textures[index * MOST_PASSES + unit]);
}

void shader_bind_texture(const struct shader *shader, const struct texture *texture)
{
    const int index = (int)(texture - shader->plan->textures);
    for (int k = 0; k < (texture->spectral ? shader->n_passes : 1); k++)
        bind_unit(shader, index, k);
}

/* OpenGL ES filters floats where an extension allows it. */
static bool upload_texture(const struct shader *shader, int index, struct error *err)
{
    const struct gl_functions *call = shader->call;
    const struct texture *texture = &shader->plan->textures[index];
    if (!texture_fits(call, texture, err))
        return false;
    if (texture->linear && shader->plan->options.gl_way == GL_ES &&
        !contexts_have(shader->contexts, "GL_OES_texture_float_linear"))
        return error_unsupported(err,
                                 "%.500s: this OpenGL ES does not filter floats; add `nearest`",
                                 texture->image.path);
    call->GenTextures(MOST_PASSES, shader->textures + index * MOST_PASSES);
    for (int k = 0; k < (texture->spectral ? shader->n_passes : 1); k++) {
        bind_unit(shader, index, k);
        texture_repeats(call, texture);
    }
    if (!texture->spectral)
        call->TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, texture->image.width, texture->image.height, 0,
                         GL_RED, GL_FLOAT, texture->plane[0]);
    return true;
}

static bool upload_bands(const struct shader *shader, int index, const int *first_bands, int n,
                         struct error *err)
{
    for (int k = 0; k < n; k++) {
        bind_unit(shader, index, k);
        if (!texture_upload_bands(shader->call, shader->plan, &shader->plan->textures[index],
                                  first_bands[k], err))
            return false;
    }
    return true;
}

bool shader_upload_bands(struct shader *shader, const int *first_bands, int n, struct error *err)
{
    for (int i = 0; i < shader->plan->n_textures; i++)
        if (shader->textures[i * MOST_PASSES] && shader->plan->textures[i].spectral &&
            !upload_bands(shader, i, first_bands, n, err))
            return false;
    return true;
}

/* ---- the scene ---- */

bool shader_take_scene(struct renderer *renderer, const struct lit_scene *lit, struct error *err)
{
    struct shader *shader = (struct shader *)renderer;
    const int n = shader->plan->n_textures;
    shader->lit = lit;
    if (!MAKE_ARRAY(shader->textures, n * MOST_PASSES, err, "%d textures", n) ||
        !MAKE_ARRAY(shader->programs, program_count(shader->plan), err, "the shaders") ||
        !vertex_buffers_fill(shader->call, lit, &shader->vertices, err))
        return false;
    for (int i = 0; i < n; i++)
        if (texture_is_drawn(shader->plan, &shader->plan->textures[i]) &&
            !upload_texture(shader, i, err))
            return false;
    return functions_succeeded(shader->call, err);
}
