/* SPDX-License-Identifier: MIT */
/* Plants one fault in the GL path, to prove that the cross-check finds it. Loaded before OSMesa
 * with LD_PRELOAD; the environment variable FAULT names the fault:
 * - those of the tables below
 * - wavelength: the first and third band of each pass are exchanged
 * - triangle: the last triangle of each draw call is left out
 * - shift: the picture is moved by half a pixel to the right
 * - front, shading: front and back faces, flat and smooth shading are exchanged
 * - provoking: a flat triangle has the colour of its first vertex, not its last
 * - texel-shift: textures are moved by one texel
 * - texel-bands: the first and third band of each pass of a spectral texture are exchanged
 * - texel: the texel in the middle is off by 1/100
 * - group: every second pass draws nothing, so the second group of lights where there are two
 * - pixel: one pixel in the middle of one pass is off by 1/1000 of full scale
 * - pixel-nan: one pixel in the middle of one pass is no number */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <GL/osmesa.h>
/* after GL/gl.h, which osmesa.h includes */
#include <GL/glext.h>

/* A parameter that OpenGL gets under another name or with another value. */
static const struct parameter_fault {
    const char *fault;
    GLenum name, becomes;
    GLfloat factor, offset;
} parameter_faults[] = {
    {"filter", GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MIN_FILTER, 0, GL_NEAREST},
    {"filter", GL_TEXTURE_MAG_FILTER, GL_TEXTURE_MAG_FILTER, 0, GL_NEAREST},
    {"clamp", GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_S, 0, GL_CLAMP_TO_EDGE},
    {"mirror", GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_T, 0, GL_MIRRORED_REPEAT},
    {"exponent", GL_SPOT_EXPONENT, GL_SPOT_EXPONENT, 1.01F, 0},
    {"cutoff", GL_SPOT_CUTOFF, GL_SPOT_CUTOFF, 0, 180},
    {"attenuation", GL_LINEAR_ATTENUATION, GL_QUADRATIC_ATTENUATION, 1, 0},
    {"attenuation", GL_QUADRATIC_ATTENUATION, GL_LINEAR_ATTENUATION, 1, 0},
    {"gloss", GL_SHININESS, GL_SHININESS, 1.01F, 0},
    {"viewer", GL_LIGHT_MODEL_LOCAL_VIEWER, GL_LIGHT_MODEL_LOCAL_VIEWER, 0, 0},
    {"one-sided", GL_LIGHT_MODEL_TWO_SIDE, GL_LIGHT_MODEL_TWO_SIDE, 0, 0},
    {"two-sided", GL_LIGHT_MODEL_TWO_SIDE, GL_LIGHT_MODEL_TWO_SIDE, 0, 1},
};

/* A vector one component of which OpenGL gets wrong: in a colour, a band of each pass. */
static const struct vector_fault {
    const char *fault;
    GLenum name;
    int component;
    GLfloat factor, offset;
} vector_faults[] = {
    {"diffuse", GL_DIFFUSE, 1, 0.999F, 0},    {"no-diffuse", GL_DIFFUSE, 1, 0, 0},
    {"specular", GL_SPECULAR, 0, 0.99F, 0},   {"constant", GL_AMBIENT, 2, 0.99F, 0},
    {"axis", GL_SPOT_DIRECTION, 0, 1, 0.01F}, {"position", GL_POSITION, 0, 1, 0.01F},
};

/* The whole picture times a factor. */
static const struct picture_fault {
    const char *fault;
    float factor;
} picture_faults[] = {{"gain", 1.001F}, {"half", 0.5F}, {"black", 0}, {"nan", NAN}};

static float *buffer;
static int buffer_width, buffer_height, passes;
static GLenum matrix_mode;

static bool fault_is(const char *name)
{
    const char *fault = getenv("FAULT");
    return fault && strcmp(fault, name) == 0;
}

/* ISO C casts no object pointer to a function pointer; POSIX promises that this works. */
static void real(const char *name, void *function)
{
    void *symbol = dlsym(RTLD_NEXT, name);
    memcpy(function, &symbol, sizeof symbol);
}

/* ---- parameters ---- */

static void spoil_parameter(GLenum *name, GLfloat *value)
{
    for (size_t i = 0; i < sizeof parameter_faults / sizeof *parameter_faults; i++) {
        const struct parameter_fault *fault = &parameter_faults[i];
        if (*name != fault->name || !fault_is(fault->fault))
            continue;
        *name = fault->becomes;
        *value = fault->factor * *value + fault->offset;
        return;
    }
}

void glTexParameteri(GLenum target, GLenum name, GLint value)
{
    void (*next)(GLenum, GLenum, GLint);
    GLfloat spoiled = (GLfloat)value; /* exact: names in OpenGL have 16 bits */
    real("glTexParameteri", &next);
    spoil_parameter(&name, &spoiled);
    next(target, name, (GLint)spoiled);
}

void glLightModeli(GLenum name, GLint value)
{
    void (*next)(GLenum, GLint);
    GLfloat spoiled = (GLfloat)value;
    real("glLightModeli", &next);
    spoil_parameter(&name, &spoiled);
    next(name, (GLint)spoiled);
}

void glLightf(GLenum light, GLenum name, GLfloat value)
{
    void (*next)(GLenum, GLenum, GLfloat);
    real("glLightf", &next);
    spoil_parameter(&name, &value);
    next(light, name, value);
}

void glMaterialf(GLenum face, GLenum name, GLfloat value)
{
    void (*next)(GLenum, GLenum, GLfloat);
    real("glMaterialf", &next);
    spoil_parameter(&name, &value);
    next(face, name, value);
}

/* values has 3 components in a direction, 4 otherwise. */
static void spoil_vector(GLenum name, const GLfloat *values, GLfloat out[4])
{
    memcpy(out, values, (name == GL_SPOT_DIRECTION ? 3 : 4) * sizeof *out);
    for (size_t i = 0; i < sizeof vector_faults / sizeof *vector_faults; i++) {
        const struct vector_fault *fault = &vector_faults[i];
        if (name == fault->name && fault_is(fault->fault))
            out[fault->component] = fault->factor * out[fault->component] + fault->offset;
    }
    if (name == GL_DIFFUSE && fault_is("wavelength")) {
        out[0] = values[2];
        out[2] = values[0];
    }
}

void glLightfv(GLenum light, GLenum name, const GLfloat *values)
{
    void (*next)(GLenum, GLenum, const GLfloat *);
    GLfloat spoiled[4];
    real("glLightfv", &next);
    spoil_vector(name, values, spoiled);
    next(light, name, spoiled);
}

void glMaterialfv(GLenum face, GLenum name, const GLfloat *values)
{
    void (*next)(GLenum, GLenum, const GLfloat *);
    GLfloat spoiled[4];
    real("glMaterialfv", &next);
    /* what a material has under the name of a light's colour is white or black */
    if (name == GL_AMBIENT)
        spoil_vector(name, values, spoiled);
    next(face, name, name == GL_AMBIENT ? spoiled : values);
}

void glFrontFace(GLenum mode)
{
    void (*next)(GLenum);
    real("glFrontFace", &next);
    next(fault_is("front") == (mode == GL_CW) ? GL_CCW : GL_CW);
}

void glShadeModel(GLenum mode)
{
    void (*next)(GLenum), (*provoke)(GLenum);
    real("glShadeModel", &next);
    next(fault_is("shading") == (mode == GL_FLAT) ? GL_SMOOTH : GL_FLAT);
    if (fault_is("provoking")) {
        real("glProvokingVertex", &provoke);
        provoke(GL_FIRST_VERTEX_CONVENTION);
    }
}

/* ---- geometry and textures ---- */

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

void glTexImage2D(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height,
                  GLint border, GLenum format, GLenum type, const void *pixels)
{
    void (*next)(GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum, GLenum, const void *);
    const float *texels = pixels;
    bool shift = fault_is("texel-shift"), exchange = fault_is("texel-bands");
    size_t channels = format == GL_RGB ? 3 : 1, across = (size_t)width;
    size_t n = across * (size_t)height, middle = (size_t)height / 2 * across + across / 2;
    float *spoiled = malloc(n * channels * sizeof *spoiled);
    if (!spoiled)
        abort();
    for (size_t i = 0; i < n; i++) {
        size_t from = shift ? i - i % across + (i + 1) % across : i;
        for (size_t c = 0; c < channels; c++)
            spoiled[channels * i + c] = texels[channels * from + (exchange ? channels - 1 - c : c)];
    }
    for (size_t c = 0; c < channels && fault_is("texel"); c++)
        spoiled[channels * middle + c] *= 1.01F;
    real("glTexImage2D", &next);
    next(target, level, internal, width, height, border, format, type, spoiled);
    free(spoiled);
}

/* ---- the picture ---- */

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

static void spoil_picture(float factor)
{
    for (size_t i = 0; i < 4 * (size_t)buffer_width * (size_t)buffer_height; i++)
        buffer[i] *= factor;
}

void glFinish(void)
{
    void (*next)(void);
    real("glFinish", &next);
    next();
    size_t middle = (size_t)buffer_height / 2 * (size_t)buffer_width + (size_t)buffer_width / 2;
    for (size_t i = 0; i < sizeof picture_faults / sizeof *picture_faults; i++)
        if (fault_is(picture_faults[i].fault))
            spoil_picture(picture_faults[i].factor);
    if (passes % 2 == 1 && fault_is("group"))
        spoil_picture(0);
    if (passes == 1 && fault_is("pixel"))
        buffer[4 * middle] += 0.001F;
    if (passes == 1 && fault_is("pixel-nan"))
        buffer[4 * middle] = NAN;
    passes++;
}
