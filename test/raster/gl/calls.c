/* SPDX-License-Identifier: MIT */
/* Counts the calls of the running program to OpenGL, and those that move pixels to and from
 * libtiff, from outside. LD_PRELOAD loads this library before theirs. At the end of the process it
 * writes a line for each kind of call to the file named by CALLS:
 *
 *   NAME DETAIL COUNT AGAIN
 *
 * DETAIL separates calls of one name: the name of the state, or of the buffer, as a number. AGAIN
 * calls of COUNT were needless: they set a state to the value that it had in the current context,
 * or uploaded bytes that the context had got already. */
#define _GNU_SOURCE
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
/* after GL/gl.h, which osmesa.h includes */
#include <GL/glext.h>
#include <tiffio.h>
#include <unistd.h>

#include "test/shared/preload.h"

/* ---- counting ---- */

/* A state holds one value; a store holds all that was uploaded; an action leaves nothing. */
enum kind { ACTION, STATE, STORE };
struct counted {
    const char *name; /* a literal */
    unsigned long detail, n, again;
};
struct value {
    const struct counted *of;
    const void *context;
    uint64_t digest;
};
enum { KINDS = 256, VALUES = 4096 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct counted kinds[KINDS];
static struct value values[VALUES];
static int n_kinds, n_values;
static const void *current;

static struct counted *find_kind(const char *name, unsigned long detail)
{
    int i = 0;
    while (i < n_kinds && !(kinds[i].detail == detail && strcmp(kinds[i].name, name) == 0))
        i++;
    if (i == KINDS)
        abort();
    if (i == n_kinds)
        kinds[n_kinds++] = (struct counted){name, detail, 0, 0};
    return &kinds[i];
}

/* FNV-1a */
static uint64_t digest_of(const void *bytes, size_t n)
{
    const unsigned char *at = bytes;
    uint64_t digest = 0xcbf29ce484222325;
    for (size_t i = 0; i < n; i++)
        digest = (digest ^ at[i]) * 0x100000001b3;
    return digest;
}

/* Remembers a value. Returns whether the context has it already. */
static int is_known(const struct counted *of, enum kind kind, uint64_t digest)
{
    int i = 0;
    while (i < n_values && !(values[i].of == of && values[i].context == current &&
                             (kind == STATE || values[i].digest == digest)))
        i++;
    const int known = i < n_values && values[i].digest == digest;
    if (i == VALUES)
        abort();
    values[i] = (struct value){of, current, digest};
    n_values += i == n_values;
    return known;
}

/* Counts a call that gives OpenGL n bytes. */
static void give(enum kind kind, const char *name, unsigned long detail, const void *bytes,
                 size_t n)
{
    pthread_mutex_lock(&lock);
    struct counted *of = find_kind(name, detail);
    of->n++;
    of->again += (unsigned long)(kind != ACTION && is_known(of, kind, digest_of(bytes, n)));
    pthread_mutex_unlock(&lock);
}

static void count(const char *name, unsigned long detail)
{
    give(ACTION, name, detail, NULL, 0);
}

/* Both count a call and are the function behind this library. */
#define COUNTED(name, detail) (count(#name, detail), REAL(name))
#define GIVEN(kind, name, detail, bytes, n) (give(kind, #name, detail, bytes, n), REAL(name))

__attribute__((destructor)) static void report(void)
{
    const char *path = getenv("CALLS");
    FILE *file = path && n_kinds > 0 ? fopen(path, "w") : NULL;
    if (!file)
        return;
    for (int i = 0; i < n_kinds; i++)
        fprintf(file, "%s %lu %lu %lu\n", kinds[i].name, kinds[i].detail, kinds[i].n,
                kinds[i].again);
    if (fclose(file) != 0)
        abort();
}

/* The program works in a child process, which ends without exit. */
void _exit(int status)
{
    report();
    REAL(_exit)(status);
    abort();
}

/* ---- contexts ---- */

OSMesaContext OSMesaCreateContextExt(GLenum format, GLint depth, GLint stencil, GLint accumulation,
                                     OSMesaContext shared)
{
    return COUNTED(OSMesaCreateContextExt, 0)(format, depth, stencil, accumulation, shared);
}

GLboolean OSMesaMakeCurrent(OSMesaContext context, void *pixels, GLenum type, GLsizei width,
                            GLsizei height)
{
    count("OSMesaMakeCurrent", 0);
    current = context;
    return REAL(OSMesaMakeCurrent)(context, pixels, type, width, height);
}

/* ---- state ---- */

/* glEnable and glDisable share their states, each with its own count. */
static void count_switch(const char *name, GLenum state, char on)
{
    pthread_mutex_lock(&lock);
    struct counted *of = find_kind(name, state);
    of->n++;
    of->again += (unsigned long)is_known(find_kind("switch", state), STATE, digest_of(&on, 1));
    pthread_mutex_unlock(&lock);
}

void glEnable(GLenum state)
{
    count_switch("glEnable", state, 1);
    REAL(glEnable)(state);
}

void glDisable(GLenum state)
{
    count_switch("glDisable", state, 0);
    REAL(glDisable)(state);
}

void glEnableClientState(GLenum state)
{
    count_switch("glEnableClientState", state, 1);
    REAL(glEnableClientState)(state);
}

void glDisableClientState(GLenum state)
{
    count_switch("glDisableClientState", state, 0);
    REAL(glDisableClientState)(state);
}

void glShadeModel(GLenum model)
{
    GIVEN(STATE, glShadeModel, 0, &model, sizeof model)(model);
}

void glFrontFace(GLenum face)
{
    GIVEN(STATE, glFrontFace, 0, &face, sizeof face)(face);
}

void glStencilOp(GLenum fail, GLenum depth_fail, GLenum pass)
{
    const GLenum all[] = {fail, depth_fail, pass};
    GIVEN(STATE, glStencilOp, 0, all, sizeof all)(fail, depth_fail, pass);
}

/* ---- lights and materials ---- */

/* The parameters of eight lights differ in their low 16 bits. */
static unsigned long of_light(GLenum light, GLenum name)
{
    return (unsigned long)(light - GL_LIGHT0) << 16 | name;
}

void glLightf(GLenum light, GLenum name, GLfloat value)
{
    GIVEN(STATE, glLightf, of_light(light, name), &value, sizeof value)(light, name, value);
}

/* A direction has 3 values, other parameters have 4. */
void glLightfv(GLenum light, GLenum name, const GLfloat *vector)
{
    const size_t size = (name == GL_SPOT_DIRECTION ? 3 : 4) * sizeof *vector;
    GIVEN(STATE, glLightfv, of_light(light, name), vector, size)(light, name, vector);
}

void glLightModeli(GLenum name, GLint value)
{
    GIVEN(STATE, glLightModeli, name, &value, sizeof value)(name, value);
}

void glMaterialf(GLenum face, GLenum name, GLfloat value)
{
    GIVEN(STATE, glMaterialf, name, &value, sizeof value)(face, name, value);
}

void glMaterialfv(GLenum face, GLenum name, const GLfloat *vector)
{
    GIVEN(STATE, glMaterialfv, name, vector, 4 * sizeof *vector)(face, name, vector);
}

/* ---- uploads ---- */

void glGenBuffers(GLsizei n, GLuint *names)
{
    for (GLsizei i = 0; i < n; i++)
        count("glGenBuffers", 0);
    REAL(glGenBuffers)(n, names);
}

void glBufferData(GLenum target, GLsizeiptr size, const void *data, GLenum usage)
{
    GIVEN(STORE, glBufferData, target, data, (size_t)size)(target, size, data, usage);
}

void glGenTextures(GLsizei n, GLuint *names)
{
    for (GLsizei i = 0; i < n; i++)
        count("glGenTextures", 0);
    REAL(glGenTextures)(n, names);
}

void glBindTexture(GLenum target, GLuint name)
{
    COUNTED(glBindTexture, 0)(target, name);
}

void glTexParameteri(GLenum target, GLenum name, GLint value)
{
    COUNTED(glTexParameteri, name)(target, name, value);
}

/* Texels are floats of one or of three channels. */
void glTexImage2D(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height,
                  GLint border, GLenum format, GLenum type, const void *pixels)
{
    const size_t n = (size_t)width * (size_t)height * (format == GL_RGB ? 3 : 1);
    GIVEN(STORE, glTexImage2D, 0, pixels, n * sizeof(GLfloat))
    (target, level, internal, width, height, border, format, type, pixels);
}

void glTexCoordPointer(GLint size, GLenum type, GLsizei stride, const void *pointer)
{
    COUNTED(glTexCoordPointer, 0)(size, type, stride, pointer);
}

/* ---- drawing ---- */

void glClear(GLbitfield buffers)
{
    COUNTED(glClear, buffers)(buffers);
}

void glDrawElements(GLenum mode, GLsizei n, GLenum type, const void *indices)
{
    COUNTED(glDrawElements, 0)(mode, n, type, indices);
}

void glDrawArrays(GLenum mode, GLint first, GLsizei n)
{
    COUNTED(glDrawArrays, 0)(mode, first, n);
}

void glFinish(void)
{
    COUNTED(glFinish, 0)();
}

void glReadPixels(GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type,
                  void *pixels)
{
    COUNTED(glReadPixels, 0)(x, y, width, height, format, type, pixels);
}

/* ---- libtiff ---- */

tmsize_t TIFFWriteRawStrip(TIFF *tiff, uint32_t strip, void *data, tmsize_t size)
{
    return COUNTED(TIFFWriteRawStrip, 0)(tiff, strip, data, size);
}

tmsize_t TIFFReadEncodedStrip(TIFF *tiff, uint32_t strip, void *data, tmsize_t size)
{
    return COUNTED(TIFFReadEncodedStrip, 0)(tiff, strip, data, size);
}
