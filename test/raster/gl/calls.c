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
#include <dlfcn.h>
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

/* ISO C does not allow a cast from an object pointer to a function pointer; POSIX promises that
 * this works. */
static void real(const char *name, void *function)
{
    void *symbol = dlsym(RTLD_NEXT, name);
    memcpy(function, &symbol, sizeof symbol);
}

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
    void (*next)(int);
    real("_exit", &next);
    report();
    next(status);
    abort();
}

/* ---- contexts ---- */

OSMesaContext OSMesaCreateContextExt(GLenum format, GLint depth, GLint stencil, GLint accumulation,
                                     OSMesaContext shared)
{
    OSMesaContext (*next)(GLenum, GLint, GLint, GLint, OSMesaContext);
    real("OSMesaCreateContextExt", &next);
    count("OSMesaCreateContextExt", 0);
    return next(format, depth, stencil, accumulation, shared);
}

GLboolean OSMesaMakeCurrent(OSMesaContext context, void *pixels, GLenum type, GLsizei width,
                            GLsizei height)
{
    GLboolean (*next)(OSMesaContext, void *, GLenum, GLsizei, GLsizei);
    real("OSMesaMakeCurrent", &next);
    count("OSMesaMakeCurrent", 0);
    current = context;
    return next(context, pixels, type, width, height);
}

/* ---- state ---- */

/* Switches a state. glEnable and glDisable share their states, each with its own count. */
static void switch_state(const char *name, GLenum state, char on)
{
    void (*next)(GLenum);
    real(name, &next);
    pthread_mutex_lock(&lock);
    struct counted *of = find_kind(name, state);
    of->n++;
    of->again += (unsigned long)is_known(find_kind("switch", state), STATE, digest_of(&on, 1));
    pthread_mutex_unlock(&lock);
    next(state);
}

void glEnable(GLenum state)
{
    switch_state("glEnable", state, 1);
}

void glDisable(GLenum state)
{
    switch_state("glDisable", state, 0);
}

void glEnableClientState(GLenum state)
{
    switch_state("glEnableClientState", state, 1);
}

void glDisableClientState(GLenum state)
{
    switch_state("glDisableClientState", state, 0);
}

void glShadeModel(GLenum model)
{
    void (*next)(GLenum);
    real("glShadeModel", &next);
    give(STATE, "glShadeModel", 0, &model, sizeof model);
    next(model);
}

void glFrontFace(GLenum face)
{
    void (*next)(GLenum);
    real("glFrontFace", &next);
    give(STATE, "glFrontFace", 0, &face, sizeof face);
    next(face);
}

void glStencilOp(GLenum fail, GLenum depth_fail, GLenum pass)
{
    void (*next)(GLenum, GLenum, GLenum);
    const GLenum all[] = {fail, depth_fail, pass};
    real("glStencilOp", &next);
    give(STATE, "glStencilOp", 0, all, sizeof all);
    next(fail, depth_fail, pass);
}

/* ---- lights and materials ---- */

/* The parameters of eight lights differ in their low 16 bits. */
static unsigned long of_light(GLenum light, GLenum name)
{
    return (unsigned long)(light - GL_LIGHT0) << 16 | name;
}

void glLightf(GLenum light, GLenum name, GLfloat value)
{
    void (*next)(GLenum, GLenum, GLfloat);
    real("glLightf", &next);
    give(STATE, "glLightf", of_light(light, name), &value, sizeof value);
    next(light, name, value);
}

/* A direction has 3 values, other parameters have 4. */
void glLightfv(GLenum light, GLenum name, const GLfloat *vector)
{
    void (*next)(GLenum, GLenum, const GLfloat *);
    real("glLightfv", &next);
    give(STATE, "glLightfv", of_light(light, name), vector,
         (name == GL_SPOT_DIRECTION ? 3 : 4) * sizeof *vector);
    next(light, name, vector);
}

void glLightModeli(GLenum name, GLint value)
{
    void (*next)(GLenum, GLint);
    real("glLightModeli", &next);
    give(STATE, "glLightModeli", name, &value, sizeof value);
    next(name, value);
}

void glMaterialf(GLenum face, GLenum name, GLfloat value)
{
    void (*next)(GLenum, GLenum, GLfloat);
    real("glMaterialf", &next);
    give(STATE, "glMaterialf", name, &value, sizeof value);
    next(face, name, value);
}

void glMaterialfv(GLenum face, GLenum name, const GLfloat *vector)
{
    void (*next)(GLenum, GLenum, const GLfloat *);
    real("glMaterialfv", &next);
    give(STATE, "glMaterialfv", name, vector, 4 * sizeof *vector);
    next(face, name, vector);
}

/* ---- uploads ---- */

void glGenBuffers(GLsizei n, GLuint *names)
{
    void (*next)(GLsizei, GLuint *);
    real("glGenBuffers", &next);
    for (GLsizei i = 0; i < n; i++)
        count("glGenBuffers", 0);
    next(n, names);
}

void glBufferData(GLenum target, GLsizeiptr size, const void *data, GLenum usage)
{
    void (*next)(GLenum, GLsizeiptr, const void *, GLenum);
    real("glBufferData", &next);
    give(STORE, "glBufferData", target, data, (size_t)size);
    next(target, size, data, usage);
}

void glGenTextures(GLsizei n, GLuint *names)
{
    void (*next)(GLsizei, GLuint *);
    real("glGenTextures", &next);
    for (GLsizei i = 0; i < n; i++)
        count("glGenTextures", 0);
    next(n, names);
}

void glBindTexture(GLenum target, GLuint name)
{
    void (*next)(GLenum, GLuint);
    real("glBindTexture", &next);
    count("glBindTexture", 0);
    next(target, name);
}

void glTexParameteri(GLenum target, GLenum name, GLint value)
{
    void (*next)(GLenum, GLenum, GLint);
    real("glTexParameteri", &next);
    count("glTexParameteri", name);
    next(target, name, value);
}

/* Texels are floats of one or of three channels. */
void glTexImage2D(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height,
                  GLint border, GLenum format, GLenum type, const void *pixels)
{
    void (*next)(GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum, GLenum, const void *);
    const size_t n = (size_t)width * (size_t)height * (format == GL_RGB ? 3 : 1);
    real("glTexImage2D", &next);
    give(STORE, "glTexImage2D", 0, pixels, n * sizeof(GLfloat));
    next(target, level, internal, width, height, border, format, type, pixels);
}

void glTexCoordPointer(GLint size, GLenum type, GLsizei stride, const void *pointer)
{
    void (*next)(GLint, GLenum, GLsizei, const void *);
    real("glTexCoordPointer", &next);
    count("glTexCoordPointer", 0);
    next(size, type, stride, pointer);
}

/* ---- drawing ---- */

void glClear(GLbitfield buffers)
{
    void (*next)(GLbitfield);
    real("glClear", &next);
    count("glClear", buffers);
    next(buffers);
}

void glRectf(GLfloat x1, GLfloat y1, GLfloat x2, GLfloat y2)
{
    void (*next)(GLfloat, GLfloat, GLfloat, GLfloat);
    real("glRectf", &next);
    count("glRectf", 0);
    next(x1, y1, x2, y2);
}

void glDrawElements(GLenum mode, GLsizei n, GLenum type, const void *indices)
{
    void (*next)(GLenum, GLsizei, GLenum, const void *);
    real("glDrawElements", &next);
    count("glDrawElements", 0);
    next(mode, n, type, indices);
}

void glDrawArrays(GLenum mode, GLint first, GLsizei n)
{
    void (*next)(GLenum, GLint, GLsizei);
    real("glDrawArrays", &next);
    count("glDrawArrays", 0);
    next(mode, first, n);
}

void glFinish(void)
{
    void (*next)(void);
    real("glFinish", &next);
    count("glFinish", 0);
    next();
}

void glReadPixels(GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type,
                  void *pixels)
{
    void (*next)(GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, void *);
    real("glReadPixels", &next);
    count("glReadPixels", 0);
    next(x, y, width, height, format, type, pixels);
}

/* ---- libtiff ---- */

tmsize_t TIFFWriteRawStrip(TIFF *tiff, uint32_t strip, void *data, tmsize_t size)
{
    tmsize_t (*next)(TIFF *, uint32_t, void *, tmsize_t);
    real("TIFFWriteRawStrip", &next);
    count("TIFFWriteRawStrip", 0);
    return next(tiff, strip, data, size);
}

tmsize_t TIFFReadEncodedStrip(TIFF *tiff, uint32_t strip, void *data, tmsize_t size)
{
    tmsize_t (*next)(TIFF *, uint32_t, void *, tmsize_t);
    real("TIFFReadEncodedStrip", &next);
    count("TIFFReadEncodedStrip", 0);
    return next(tiff, strip, data, size);
}
