/* SPDX-License-Identifier: MIT */
/* Libraries that are opened at run time. The static program opens none: it has no loader. */
#include <string.h>

#include "raster/gl/inside.h"

#ifdef OSMESA_VERSION /* static */
void library_find(void *library, const char *name, void *out)
{
    void *symbol = NULL;
    (void)library, (void)name;
    memcpy(out, &symbol, sizeof symbol);
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

/* ISO C does not allow a cast from an object pointer to a function pointer; POSIX promises that
 * this works. */
void library_find(void *library, const char *name, void *out)
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
