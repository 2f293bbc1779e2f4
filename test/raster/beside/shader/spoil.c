/* SPDX-License-Identifier: MIT */
/* An OpenGL with a fault, whatever library it comes from: placed between the program and OSMesa or
 * EGL by LD_PRELOAD. The environment variable SPOIL names the faults:
 *
 *     diffuse   diffuse light is 1/100 too weak in the second band of each pass
 *     crash     the driver ends the process where a texture is switched on
 *     hang      it waits there for ever
 *     die       it ends the process at each light
 *     start     it waits for ever when it is asked for its name
 *     black     lights are black
 *     unknown   the driver has another name
 *     depths    OpenGL ES cannot read depths
 *     filters   OpenGL ES does not filter floats
 *
 * In shaders the light is that of the variable "diffuse", matrices with a pass in each column. */
#define _GNU_SOURCE
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
/* after GL/gl.h */
#include <GL/glext.h>
#include <dlfcn.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef void any_function(void);

static bool spoils(const char *what)
{
    const char *fault = getenv("SPOIL");
    return fault && strstr(fault, what);
}

/* ISO C does not allow a cast from an object pointer to a function pointer; POSIX promises that
 * this works. */
static void real(const char *name, void *function)
{
    any_function *(*get)(const char *) = NULL;
    void *symbol = dlsym(RTLD_DEFAULT, "eglGetProcAddress");
    if (!symbol)
        symbol = dlsym(RTLD_DEFAULT, "OSMesaGetProcAddress");
    if (!symbol)
        abort();
    memcpy(&get, &symbol, sizeof symbol);
    any_function *found = get(name);
    memcpy(function, &found, sizeof found);
}

void glLightfv(GLenum light, GLenum name, const GLfloat *values)
{
    void (*next)(GLenum, GLenum, const GLfloat *);
    GLfloat spoiled[4];
    real("glLightfv", &next);
    memcpy(spoiled, values, (name == GL_SPOT_DIRECTION ? 3 : 4) * sizeof *spoiled);
    if (name == GL_DIFFUSE && spoils("diffuse"))
        spoiled[1] *= 0.99F;
    if (spoils("die"))
        raise(SIGSEGV);
    if ((name == GL_DIFFUSE || name == GL_SPECULAR) && spoils("black"))
        memset(spoiled, 0, sizeof spoiled);
    next(light, name, spoiled);
}

/* ---- shaders ---- */

static GLint diffuse = -1; /* the variable of the program that was made last */

GLint glGetUniformLocation(GLuint program, const char *name)
{
    GLint (*next)(GLuint, const char *);
    real("glGetUniformLocation", &next);
    const GLint at = next(program, name);
    if (strcmp(name, "diffuse") == 0)
        diffuse = at;
    return at;
}

void glUniformMatrix4fv(GLint at, GLsizei n, GLboolean transposed, const GLfloat *values)
{
    void (*next)(GLint, GLsizei, GLboolean, const GLfloat *);
    real("glUniformMatrix4fv", &next);
    GLfloat *spoiled = malloc(16 * (size_t)n * sizeof *spoiled + 1);
    if (!spoiled)
        abort();
    memcpy(spoiled, values, 16 * (size_t)n * sizeof *spoiled);
    for (GLsizei i = 0; i < 4 * n && at == diffuse && spoils("diffuse"); i++)
        spoiled[4 * i + 1] *= 0.99F;
    next(at, n, transposed, spoiled);
    free(spoiled);
}

const GLubyte *glGetStringi(GLenum name, GLuint index)
{
    const GLubyte *(*next)(GLenum, GLuint);
    real("glGetStringi", &next);
    const GLubyte *text = next(name, index);
    const bool hidden =
        (spoils("depths") && strcmp((const char *)text, "GL_NV_read_depth_stencil") == 0) ||
        (spoils("filters") && strcmp((const char *)text, "GL_OES_texture_float_linear") == 0);
    return hidden ? (const GLubyte *)"GL_hidden" : text;
}

const GLubyte *glGetString(GLenum name)
{
    const GLubyte *(*next)(GLenum);
    real("glGetString", &next);
    while (spoils("start"))
        pause();
    return name == GL_RENDERER && spoils("unknown") ? (const GLubyte *)"Foo 9000" : next(name);
}

void glEnable(GLenum name)
{
    void (*next)(GLenum);
    real("glEnable", &next);
    if (name == GL_TEXTURE_2D && spoils("crash"))
        raise(SIGSEGV);
    while (name == GL_TEXTURE_2D && spoils("hang"))
        pause();
    next(name);
}
