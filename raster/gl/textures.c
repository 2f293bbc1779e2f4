/* SPDX-License-Identifier: MIT */
/* Textures as OpenGL keeps them. Texels are of single precision: Mesa filters texels of 8 bits with
 * weights of 8 bits. */
#include <stdlib.h>

#include "raster/gl/inside.h"

static bool fits(const struct drawing *of, const struct texture *texture, struct error *err)
{
    GLint largest = 0;
    of->call->GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    if (texture->image.width > largest || texture->image.height > largest)
        return error_system(err, "%.500s: this OpenGL has textures of at most %d texels a side",
                            texture->image.path, largest);
    /* OpenGL ES filters floats where an extension allows it */
    return !texture->linear || of->contexts->way != GL_ES ||
           contexts_have(of->contexts, "GL_OES_texture_float_linear") ||
           error_unsupported(err, "%.500s: this OpenGL ES does not filter floats; add `nearest`",
                             texture->image.path);
}

void texture_bind(const struct drawing *of, int index, int unit)
{
    if (of->contexts->way != GL_WITHOUT_SHADERS)
        of->call->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    of->call->BindTexture(GL_TEXTURE_2D, of->textures[index * of->n_units + unit]);
}

/* A spectral texture has no texels yet. */
static bool upload(const struct drawing *of, int index, struct error *err)
{
    const struct texture *texture = &of->plan->textures[index];
    const bool shaders = of->contexts->way != GL_WITHOUT_SHADERS;
    const GLint filter = texture->linear ? GL_LINEAR : GL_NEAREST;
    if (!fits(of, texture, err))
        return false;
    of->call->GenTextures(of->n_units, of->textures + index * of->n_units);
    for (int unit = 0; unit < (texture->spectral ? of->n_units : 1); unit++) {
        texture_bind(of, index, unit);
        of->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
        of->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
        of->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
        of->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_REPEAT);
    }
    if (!texture->spectral)
        of->call->TexImage2D(GL_TEXTURE_2D, 0, shaders ? GL_R32F : GL_LUMINANCE32F_ARB,
                             texture->image.width, texture->image.height, 0,
                             shaders ? GL_RED : GL_LUMINANCE, GL_FLOAT, texture->plane[0]);
    return true;
}

bool textures_upload(struct drawing *of, struct error *err)
{
    const int n = of->plan->n_textures;
    if (!MAKE_ARRAY(of->textures, n * of->n_units, err, "%d textures", n))
        return false;
    for (int i = 0; i < n; i++)
        if (texture_is_drawn(of->plan, &of->plan->textures[i]) && !upload(of, i, err))
            return false;
    return true;
}

bool texture_upload_bands(const struct drawing *of, int index, int first_band, struct error *err)
{
    struct texture *texture = &of->plan->textures[index];
    const int width = texture->image.width, height = texture->image.height;
    float *texels;
    const bool done = MAKE_ARRAY(texels, (size_t)width * (size_t)height * BANDS_PER_PASS, err,
                                 "the texels of %s", texture->image.path) &&
                      pass_texels(of->plan, texture, first_band, texels, err);
    if (done)
        of->call->TexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F_ARB, width, height, 0, GL_RGB, GL_FLOAT,
                             texels);
    free(texels);
    return done;
}
