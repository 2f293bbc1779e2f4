/* SPDX-License-Identifier: MIT */
/* Textures as OpenGL keeps them. Texels are of single precision: Mesa filters texels of 8 bits with
 * weights of 8 bits. */
#include <stdlib.h>

#include "raster/gl/gl.h"

bool texture_fits(const struct gl_functions *call, const struct texture *texture, struct error *err)
{
    GLint largest = 0;
    call->GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    return (texture->image.width <= largest && texture->image.height <= largest) ||
           error_system(err, "%.500s: this OpenGL has textures of at most %d texels a side",
                        texture->image.path, largest);
}

void texture_repeats(const struct gl_functions *call, const struct texture *texture)
{
    const GLint filter = texture->linear ? GL_LINEAR : GL_NEAREST;
    call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_REPEAT);
}

bool texture_upload_bands(const struct gl_functions *call, const struct plan *plan,
                          struct texture *texture, int first_band, struct error *err)
{
    const int width = texture->image.width, height = texture->image.height;
    float *texels;
    const bool done = MAKE_ARRAY(texels, (size_t)width * (size_t)height * BANDS_PER_PASS, err,
                                 "the texels of %s", texture->image.path) &&
                      pass_texels(plan, texture, first_band, texels, err);
    if (done)
        call->TexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F_ARB, width, height, 0, GL_RGB, GL_FLOAT,
                         texels);
    free(texels);
    return done;
}
