/* SPDX-License-Identifier: MIT */
/* An OpenGL that nobody knows, and that may lie: placed between the program and OSMesa by
 * LD_PRELOAD. GL_RENDERER is "Liar", or LIAR_NAME. The environment variable LIE says what else is
 * not as in Mesa:
 *
 *     low       a depth in four is a step too low
 *     coarse    depths have 16 bits
 *     filter    linear filtering has weights of 5 bits, cut off
 *     passes    each second mesh lies further back where it is lit than where it is numbered
 *
 * Other lies are faults of fault.c, which is then loaded behind this library. */
#define _GNU_SOURCE
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
/* after GL/gl.h, which osmesa.h includes */
#include <GL/glext.h>

#include "test/shared/preload.h"

static bool lies(const char *about)
{
    const char *lie = getenv("LIE");
    return lie && strcmp(lie, about) == 0;
}

const GLubyte *glGetString(GLenum name)
{
    const char *own = getenv("LIAR_NAME");
    return name == GL_RENDERER ? (const GLubyte *)(own ? own : "Liar") : REAL(glGetString)(name);
}

/* ---- where things are drawn ---- */

void glReadPixels(GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type,
                  void *pixels)
{
    const bool coarse = lies("coarse"), low = lies("low");
    GLuint *depths = pixels;
    REAL(glReadPixels)(x, y, width, height, format, type, pixels);
    for (size_t i = 0; i < (size_t)width * (size_t)height && (coarse || low); i++) {
        if (coarse)
            depths[i] &= 0xffff00ffu;
        if (low && depths[i] >> 8 > 0 && depths[i] >> 8 < 0xffffff)
            depths[i] -= (depths[i] & 0x300) == 0x300 ? 0x100 : 0;
    }
}

/* ---- values ---- */

/* Linear filtering by weights of 5 bits is nearest filtering of a texture that is 32 times as large
 * a side. Textures with mipmaps stay as they are. */
enum { WEIGHTS = 32 };

static bool mipmapped; /* the texture whose filter was set last */

static float filtered(const float *texels, const int size[2], const int at[2], int channels)
{
    float sum = 0;
    for (int corner = 0; corner < 4; corner++) {
        int index[2];
        float weight = 1;
        for (int j = 0; j < 2; j++) {
            const int shifted = at[j] + WEIGHTS / 2, up = corner >> j & 1;
            const float part = (float)(shifted % WEIGHTS) / WEIGHTS;
            index[j] = (shifted / WEIGHTS - 1 + up + size[j]) % size[j];
            weight *= size[j] == 1 ? 0.5F : up ? part : 1 - part;
        }
        sum += weight * texels[channels * (index[1] * size[0] + index[0])];
    }
    return sum;
}

void glTexParameteri(GLenum target, GLenum name, GLint value)
{
    mipmapped = name == GL_TEXTURE_MIN_FILTER ? value == GL_LINEAR_MIPMAP_LINEAR : mipmapped;
    REAL(glTexParameteri)
    (target, name, lies("filter") && !mipmapped && value == GL_LINEAR ? GL_NEAREST : value);
}

/* A side of one texel stays as it is. */
void glTexImage2D(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height,
                  GLint border, GLenum format, GLenum type, const void *pixels)
{
    const int size[2] = {width, height},
              step[2] = {width > 1 ? WEIGHTS : 1, height > 1 ? WEIGHTS : 1},
              across = width * step[0], up = height * step[1];
    if (!lies("filter") || mipmapped) {
        REAL(glTexImage2D)(target, level, internal, width, height, border, format, type, pixels);
        return;
    }
    const int channels = format == GL_RGB ? 3 : 1, n = channels * across * up;
    float *large = malloc((size_t)n * sizeof *large);
    if (!large)
        abort();
    for (int i = 0; i < n; i++) {
        const int texel = i / channels, at[2] = {texel % across, texel / across};
        large[i] = filtered((const float *)pixels + i % channels, size, at, channels);
    }
    REAL(glTexImage2D)(target, level, internal, across, up, border, format, type, large);
    free(large);
}

void glDrawElements(GLenum mode, GLsizei count, GLenum type, const void *indices)
{
    static bool second;
    second = !second;
    if (second && lies("passes")) {
        glEnable(GL_POLYGON_OFFSET_FILL);
        glPolygonOffset(0, 4096);
    }
    REAL(glDrawElements)(mode, count, type, indices);
    glDisable(GL_POLYGON_OFFSET_FILL);
}
