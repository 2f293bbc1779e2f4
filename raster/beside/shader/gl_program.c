/* SPDX-License-Identifier: MIT */
/* Programs of shaders. */
#include <stdlib.h>

#include "raster/beside/shader/inside.h"

void program_begin(enum gl_way way, struct printed *to)
{
    print_text(to, way == GL_ES
                       ? "#version 300 es\nprecision highp float;\nprecision highp sampler2D;\n"
                       : "#version 330 core\n");
}

/* Compiles a shader and attaches it. Frees the text. */
static bool attach(const struct gl_functions *call, GLuint program, GLenum type,
                   struct printed *text, struct error *err)
{
    const GLuint shader = call->CreateShader(type);
    char *source = printed_take(text, err), log[256] = "";
    const char *const sources[] = {source};
    GLint done = 0;
    if (!source)
        return false;
    call->ShaderSource(shader, 1, sources, NULL);
    call->CompileShader(shader);
    call->GetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (!done) {
        call->GetShaderInfoLog(shader, sizeof log, NULL, log);
        hide_unprintable(log, "");
    }
    call->AttachShader(program, shader);
    free(source);
    return done || error_unsupported(err, "OpenGL does not compile a shader: %s", log);
}

bool program_end(const struct gl_functions *call, struct printed *vertex, struct printed *fragment,
                 unsigned *out, struct error *err)
{
    const GLuint name = call->CreateProgram();
    GLint done = 0;
    const bool attached = attach(call, name, GL_VERTEX_SHADER, vertex, err) &&
                          attach(call, name, GL_FRAGMENT_SHADER, fragment, err);
    free(printed_end(fragment));
    if (!attached)
        return false;
    call->LinkProgram(name);
    call->GetProgramiv(name, GL_LINK_STATUS, &done);
    if (!done)
        return error_unsupported(err, "OpenGL does not link the shaders of a program");
    call->UseProgram(name);
    *out = name;
    return true;
}
