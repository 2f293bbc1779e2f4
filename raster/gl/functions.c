/* SPDX-License-Identifier: MIT */
/* The table of OpenGL's functions. */
#include <string.h>

#include "raster/gl/inside.h"

static const struct {
    const char *name;
    bool fixed, shaders; /* of one of these ways only */
} functions[] = {
#define COMMON_NAME(type, name, parameters) {"gl" #name, false, false},
#define FIXED_NAME(type, name, parameters) {"gl" #name, true, false},
#define SHADERS_NAME(type, name, parameters) {"gl" #name, false, true},
    COMMON_FUNCTIONS(COMMON_NAME) FIXED_FUNCTIONS(FIXED_NAME) SHADER_FUNCTIONS(SHADERS_NAME)};

bool functions_find(const struct gl_source *in, enum gl_way way, struct gl_functions *out,
                    struct error *err)
{
    enum { N = sizeof functions / sizeof *functions };
    any_function *found[N];
    for (int i = 0; i < N; i++) {
        const char *name = functions[i].name;
        found[i] = NULL;
        if (way == GL_WITHOUT_SHADERS ? functions[i].shaders : functions[i].fixed)
            continue;
        if (in->library)
            library_find(in->library, name, &found[i]);
        if (!found[i])
            found[i] = in->get(name);
        if (!found[i])
            return error_unsupported(err, "%s has no function %s", in->name, name);
    }
    memcpy(out, found, sizeof found); /* all pointers to functions have one size in POSIX */
    return true;
}

bool functions_succeeded(const struct gl_functions *call, struct error *err)
{
    const GLenum code = call->GetError();
    return code == GL_NO_ERROR || error_system(err, "OpenGL reports error 0x%04x", code);
}
