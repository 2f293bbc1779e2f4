/* SPDX-License-Identifier: MIT */
/* An OpenGL with a fault, whatever library it comes from: placed between the program and OSMesa or
 * EGL by LD_PRELOAD. The environment variable SPOIL names the fault:
 *
 *     diffuse   diffuse light is 1/100 too weak in the second band of each pass
 *     crash     the driver ends the process where a texture is switched on */
#define _GNU_SOURCE
#include <GL/gl.h>
#include <dlfcn.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef void any_function(void);

static bool spoils(const char *what)
{
    const char *fault = getenv("SPOIL");
    return fault && strcmp(fault, what) == 0;
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
    next(light, name, spoiled);
}

void glEnable(GLenum name)
{
    void (*next)(GLenum);
    real("glEnable", &next);
    if (name == GL_TEXTURE_2D && spoils("crash"))
        raise(SIGSEGV);
    next(name);
}
