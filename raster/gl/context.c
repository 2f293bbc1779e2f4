/* SPDX-License-Identifier: MIT */
/* The choice of a library, and its canvases. */
#include "raster/gl/inside.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

/* ---- the library ---- */

/* Mesa takes and frees blocks of megabytes in each draw. The GNU C library gives them back to the
 * kernel, which clears them for the next draw: with these bytes it keeps them. The second number
 * alone would leave the first as small as it begins. M_TOP_PAD stays small: the heap of each thread
 * has it, and --memory counts it. */
static void keep_freed_blocks(void)
{
#ifdef __GLIBC__
    if (mallopt(M_MMAP_THRESHOLD, 1 << 25))
        mallopt(M_TRIM_THRESHOLD, 1 << 26);
#endif
}

static bool refuse_missing(bool osmesa, bool egl, struct error *err)
{
    static const char of_osmesa[] =
        "libOSMesa.so.8 (Debian: libosmesa6, Fedora: mesa-compat-libOSMesa, Alpine: mesa-osmesa, "
        "Arch: osmesa)";
    static const char of_egl[] =
        "libEGL.so.1 (Debian: libegl1 and libgl1-mesa-dri, Fedora: mesa-libEGL and "
        "mesa-dri-drivers, Alpine: mesa-egl and mesa-dri-gallium, Arch: mesa)";
    return error_unsupported(
        err, "OpenGL is missing: there is no %s%s%s; --renderer raster needs none",
        osmesa ? of_osmesa : "", osmesa && egl ? ", and no " : "", egl ? of_egl : "");
}

/* Opens a library, unless none of its files is there. */
static bool open_kind(struct contexts *contexts, const struct context_kind *kind, int device,
                      struct error *err)
{
    void *library;
    if (!library_open(kind->files, &library, err))
        return false;
    if (!library)
        return true;
    if (!memory_make(&contexts->own, kind->own_size, 1))
        return memory_lacks(err, (double)kind->own_size, "%s", kind->name);
    contexts->kind = kind;
    if (!library_find_all(library, kind->functions, kind->n_functions, contexts->own))
        return error_unsupported(err, "%s", kind->too_old);
    return (!kind->begin || kind->begin(contexts, device, err)) &&
           functions_find(contexts, library, err);
}

static bool open_library(struct contexts *contexts, const char *wanted, struct error *err)
{
    const bool any = strcmp(wanted, "auto") == 0, shaders = contexts->way != GL_WITHOUT_SHADERS,
               osmesa = (any && !shaders) || strcmp(wanted, "osmesa") == 0;
    const bool egl = any || !osmesa;
    keep_freed_blocks();
    if (osmesa && shaders)
        return error_unsupported(err, "OSMesa draws without shaders here; add --gl egl");
    if (osmesa && !open_kind(contexts, &osmesa_kind, -1, err))
        return false;
    const char *driver = contexts->kind ? getenv("GALLIUM_DRIVER") : NULL;
    if (driver && *driver && strcmp(driver, "llvmpipe") != 0 && strcmp(driver, "softpipe") != 0)
        return error_unsupported(
            err,
            "OSMesa draws by llvmpipe and softpipe, not by GALLIUM_DRIVER=%.60s "
            "of the environment; unset that, or add --renderer llvmpipe",
            driver); /* Mesa would crash */
    if (egl && !contexts->kind && !open_kind(contexts, &egl_kind, driver_device(wanted), err))
        return false;
    return contexts->kind || refuse_missing(osmesa, egl, err);
}

#ifdef OSMESA_VERSION /* built in; Mesa crashes when asked for another driver */
static const char *const only_driver = "softpipe";
#else
static const char *const only_driver = NULL;
#endif

bool contexts_open(const struct plan_options *wish, struct contexts **out, struct error *err)
{
    const char *wanted = wish->gl_library ? wish->gl_library : "auto";
    const char *driver = only_driver ? only_driver : wish->gl_driver;
    char threads[16];
    if (!MAKE_ARRAY(*out, 1, err, "a context of OpenGL"))
        return false;
    memory_allow_stacks(); /* llvmpipe starts threads */
    (*out)->way = wish->gl_way;
    (*out)->n_colours = 1;
    snprintf(threads, sizeof threads, "%d", wish->threads);
    setenv("LP_NUM_THREADS", threads, 0); /* for llvmpipe; a user's own configuration stands */
    /* llvmpipe of Mesa 20.3 would mix levels of detail as OpenGL does not; later versions ignore
     * these words */
    setenv("GALLIVM_PERF", "no_brilinear,no_rho_approx", 0);
    if (driver)
        setenv("GALLIUM_DRIVER", driver, 1);
    if (only_driver && strcmp(wanted, "osmesa") != 0 && strcmp(wanted, "auto") != 0)
        return error_unsupported(err, "the static program has an OSMesa of its own, and no EGL");
    return open_library(*out, wanted, err);
}

void contexts_close(struct contexts *contexts)
{
    if (!contexts)
        return;
    for (int i = contexts->n_canvases - 1; i >= 0; i--)
        if (contexts->canvases[i].context)
            contexts->kind->close(&contexts->canvases[i]);
    if (contexts->kind && contexts->kind->end)
        contexts->kind->end(contexts);
    FREE_ALL(contexts->own, contexts);
}

bool has_extension(const char *list, const char *name)
{
    const size_t length = strlen(name);
    const char *at = list;
    while (at && (at = strstr(at, name)) != NULL) {
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0'))
            return true;
        at += length;
    }
    return false;
}

/* The core profile lists extensions one by one. */
bool contexts_have(const struct contexts *contexts, const char *extension)
{
    const struct gl_functions *call = &contexts->call;
    GLint n = 0;
    if (contexts->way == GL_WITHOUT_SHADERS)
        return has_extension((const char *)call->GetString(GL_EXTENSIONS), extension);
    call->GetIntegerv(GL_NUM_EXTENSIONS, &n);
    for (GLint i = 0; i < n; i++)
        if (strcmp((const char *)call->GetStringi(GL_EXTENSIONS, (GLuint)i), extension) == 0)
            return true;
    return false;
}

/* ---- canvases ---- */

GLenum canvas_type(const struct canvas *canvas)
{
    return canvas->bits == 32 ? GL_FLOAT : canvas->bits == 8 ? GL_UNSIGNED_BYTE : GL_UNSIGNED_SHORT;
}

bool canvas_open(struct contexts *contexts, int bits, int width, int height, struct canvas **out,
                 struct error *err)
{
    *out = &contexts->canvases[contexts->n_canvases++];
    **out = (struct canvas){.contexts = contexts, .bits = bits, .width = width, .height = height};
    return contexts->kind->open(*out, err);
}

bool canvas_use(struct canvas *canvas, void *pixels, struct error *err)
{
    if (!canvas->contexts->kind->use(canvas, pixels, err))
        return false;
    canvas->contexts->current = canvas;
    return true;
}
