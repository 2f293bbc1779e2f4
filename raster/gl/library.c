/* SPDX-License-Identifier: MIT */
/* Libraries that are opened at run time, and the table of OpenGL's functions. The static program
 * opens no library: it has no loader. */
#include "raster/gl/inside.h"

#ifdef OSMESA_VERSION /* static: OSMesa is built in, with its header, and there is no EGL */
#include <GL/osmesa.h>

static any_function *const built_in[] = {
    (any_function *)OSMesaGetProcAddress, (any_function *)OSMesaCreateContextExt,
    (any_function *)OSMesaDestroyContext, (any_function *)OSMesaMakeCurrent,
    (any_function *)OSMesaPixelStore};

bool library_open(const char *const *files, void **out, struct error *err)
{
    static char osmesa;
    (void)err;
    *out = *files ? &osmesa : NULL;
    return true;
}

static void library_find(void *library, const char *name, void *out)
{
    void *symbol = NULL;
    (void)library, (void)name;
    memcpy(out, &symbol, sizeof symbol);
}

bool library_find_all(void *library, const char *const *names, size_t n, void *out)
{
    (void)library, (void)names;
    memcpy(out, built_in, n * sizeof *built_in);
    return true;
}
#else
#include <dlfcn.h>

/* Its functions are for all to see, so that one that was loaded before can stand in the way: this
 * is how a debugger of OpenGL calls, or a test, is placed between. */
bool library_open(const char *const *files, void **out, struct error *err)
{
    *out = NULL;
    for (; *files && !*out; files++) {
        *out = dlopen(*files, RTLD_NOW | RTLD_GLOBAL);
        const char *reason = *out ? NULL : dlerror();
        /* it is no failure if there is no such file; the words are those of glibc and of musl */
        if (!*out && !(reason && strstr(reason, "No such file or directory")))
            return error_failed(err, "%s cannot be opened: %.500s", *files,
                                reason ? reason : "no reason is known");
    }
    if (*out)
        *out = dlopen(NULL, RTLD_NOW);
    return true;
}

/* Finds a function of an open library, or one of that name that was loaded before it; NULL: there
 * is none. `out` points to a pointer to the function. ISO C does not allow a cast from an object
 * pointer to a function pointer; POSIX promises that this works. */
static void library_find(void *library, const char *name, void *out)
{
    void *symbol = dlsym(library, name);
    memcpy(out, &symbol, sizeof symbol);
}

bool library_find_all(void *library, const char *const *names, size_t n, void *out)
{
    bool found = true;
    for (size_t i = 0; i < n; i++) {
        any_function *function;
        library_find(library, names[i], &function);
        memcpy((char *)out + i * sizeof function, &function, sizeof function);
        found = found && function;
    }
    return found;
}
#endif

/* ---- OpenGL's functions ---- */

static const struct {
    const char *name;
    bool fixed, shaders; /* of one of these ways only */
} functions[] = {
#define COMMON_NAME(type, name, parameters) {"gl" #name, false, false},
#define FIXED_NAME(type, name, parameters) {"gl" #name, true, false},
#define SHADERS_NAME(type, name, parameters) {"gl" #name, false, true},
    COMMON_FUNCTIONS(COMMON_NAME) FIXED_FUNCTIONS(FIXED_NAME) SHADER_FUNCTIONS(SHADERS_NAME)};

bool functions_find(struct contexts *to, void *library, struct error *err)
{
    const struct library_functions *own = to->own;
    enum { N = sizeof functions / sizeof *functions };
    any_function *found[N];
    for (int i = 0; i < N; i++) {
        const char *function = functions[i].name;
        found[i] = NULL;
        if (to->way == GL_WITHOUT_SHADERS ? functions[i].shaders : functions[i].fixed)
            continue;
        library_find(library, function, &found[i]);
        if (!found[i])
            found[i] = own->get(function);
        if (!found[i])
            return error_unsupported(err, "%s has no function %s", to->kind->name, function);
    }
    memcpy(&to->call, found, sizeof found); /* all pointers to functions have one size in POSIX */
    return true;
}

bool functions_succeeded(const struct gl_functions *call, struct error *err)
{
    const GLenum code = call->GetError();
    return code == GL_NO_ERROR || error_system(err, "OpenGL reports error 0x%04x", code);
}
