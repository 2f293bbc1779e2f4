/* SPDX-License-Identifier: MIT */
/* Plants one fault in the GL path, to prove that the cross-check finds it. Loaded before OSMesa
 * with LD_PRELOAD; the environment variable FAULT names the fault:
 * - wavelength: the first and third band of each pass are exchanged
 * - triangle: the last triangle of each draw call is left out
 * - shift: the picture is moved by half a pixel to the right
 * - pixel: one pixel in the middle of one pass is off by 1/1000 of full scale
 * - nan: one pixel in the middle of one pass is no number */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <GL/osmesa.h>

static float *buffer;
static int buffer_width, buffer_height, passes;
static GLenum matrix_mode;

static bool fault_is(const char *name)
{
    const char *fault = getenv("FAULT");
    return fault && strcmp(fault, name) == 0;
}

/* ISO C has no cast from an object pointer to a function pointer; POSIX promises that this works.
 */
static void real(const char *name, void *function)
{
    void *symbol = dlsym(RTLD_NEXT, name);
    memcpy(function, &symbol, sizeof symbol);
}

GLboolean OSMesaMakeCurrent(OSMesaContext context, void *pixels, GLenum type, GLsizei width,
                            GLsizei height)
{
    GLboolean (*next)(OSMesaContext, void *, GLenum, GLsizei, GLsizei);
    real("OSMesaMakeCurrent", &next);
    buffer = pixels;
    buffer_width = width;
    buffer_height = height;
    return next(context, pixels, type, width, height);
}

void glLightfv(GLenum light, GLenum name, const GLfloat *values)
{
    void (*next)(GLenum, GLenum, const GLfloat *);
    real("glLightfv", &next);
    GLfloat exchanged[4] = {values[2], values[1], values[0], values[3]};
    next(light, name, fault_is("wavelength") && name == GL_DIFFUSE ? exchanged : values);
}

void glDrawElements(GLenum mode, GLsizei count, GLenum type, const void *indices)
{
    void (*next)(GLenum, GLsizei, GLenum, const void *);
    real("glDrawElements", &next);
    next(mode, fault_is("triangle") ? count - 3 : count, type, indices);
}

void glMatrixMode(GLenum mode)
{
    void (*next)(GLenum);
    real("glMatrixMode", &next);
    matrix_mode = mode;
    next(mode);
}

void glLoadMatrixd(const GLdouble *matrix)
{
    void (*next)(const GLdouble *);
    real("glLoadMatrixd", &next);
    GLdouble moved[16];
    memcpy(moved, matrix, sizeof moved);
    for (int column = 0; column < 4; column++)
        moved[4 * column] += moved[4 * column + 3] / buffer_width;
    next(fault_is("shift") && matrix_mode == GL_PROJECTION ? moved : matrix);
}

void glFinish(void)
{
    void (*next)(void);
    real("glFinish", &next);
    next();
    size_t middle = (size_t)buffer_height / 2 * (size_t)buffer_width + (size_t)buffer_width / 2;
    if (passes == 1 && fault_is("pixel"))
        buffer[4 * middle] += 0.001F;
    if (passes == 1 && fault_is("nan"))
        buffer[4 * middle] = (float)NAN;
    passes++;
}
