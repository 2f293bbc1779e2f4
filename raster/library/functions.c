/* SPDX-License-Identifier: MIT */
/* The table of OpenGL's functions. */
#include <string.h>

#include "raster/library/library.h"

static const char *const names[] = {
#define FUNCTION_NAME(type, name, parameters) "gl" #name,
    GL_FUNCTIONS(FUNCTION_NAME)};

bool functions_find(void *library, any_function *(*get)(const char *name), const char *name,
                    struct gl_functions *out, struct error *err)
{
    enum { N = sizeof names / sizeof *names };
    any_function *found[N];
    for (int i = 0; i < N; i++) {
        found[i] = NULL;
        if (library)
            library_find(library, names[i], &found[i]);
        if (!found[i])
            found[i] = get(names[i]);
        if (!found[i])
            return error_unsupported(err, "%s has no function %s", name, names[i]);
    }
    memcpy(out, found, sizeof found); /* all pointers to functions have one size in POSIX */
    return true;
}
