/* SPDX-License-Identifier: MIT */
/* Contexts of OSMesa, which draws into memory of the caller. Types and constants are those of
 * Mesa's GL/osmesa.h, which newer systems do not have. */
#include <stdlib.h>

#include "raster/gl/inside.h"

#ifdef OSMESA_VERSION /* built in, with its header */
#include <GL/osmesa.h>
#else
typedef struct osmesa_context *OSMesaContext;
enum { OSMESA_RGBA = GL_RGBA, OSMESA_Y_UP = 0x11 };
#endif

struct osmesa {
    OSMesaContext (*create)(GLenum format, GLint depth, GLint stencil, GLint accumulation,
                            OSMesaContext shared);
    void (*destroy)(OSMesaContext context);
    GLboolean (*make_current)(OSMesaContext context, void *buffer, GLenum type, GLsizei width,
                              GLsizei height);
    void (*pixel_store)(GLint name, GLint value);
    any_function *(*get)(const char *name);
};

static const struct osmesa *osmesa_of(const struct canvas *canvas)
{
    return canvas->contexts->own;
}

/* ---- a canvas ---- */

/* Colours are RGBA; 24 bits of depth, 8 of stencil, none of accumulation. */
static bool open_canvas(struct canvas *canvas, struct error *err)
{
    canvas->context = osmesa_of(canvas)->create(OSMESA_RGBA, 24, 8, 0, NULL);
    return canvas->context || error_system(err, "OSMesa gives no context");
}

static bool use_canvas(struct canvas *canvas, struct error *err)
{
    const struct osmesa *osmesa = osmesa_of(canvas);
    if (!osmesa->make_current(canvas->context, canvas->pixels, canvas_type(canvas),
                              canvas->size.width, canvas->size.height))
        return error_system(err, "OSMesa gives no context of %d x %d pixels of %d bits a channel",
                            canvas->size.width, canvas->size.height, canvas->size.bits);
    if (canvas->contexts->current != canvas)
        osmesa->pixel_store(OSMESA_Y_UP, 0); /* first row on top, as in the picture */
    return true;
}

/* Only now does OSMesa fill the caller's memory. */
static void fill_canvas(const struct canvas *canvas)
{
    canvas->contexts->call.Finish();
}

static void close_canvas(struct canvas *canvas)
{
    osmesa_of(canvas)->destroy(canvas->context);
}

static void end(struct contexts *contexts)
{
    free(contexts->own);
}

/* ---- the library ---- */

#ifdef OSMESA_VERSION /* built in */
static bool find_functions(struct osmesa *out, void **library, bool *found, struct error *err)
{
    (void)err;
    *library = NULL;
    *found = true;
    *out = (struct osmesa){OSMesaCreateContextExt, OSMesaDestroyContext, OSMesaMakeCurrent,
                           OSMesaPixelStore, OSMesaGetProcAddress};
    return true;
}
#else
static bool find_functions(struct osmesa *out, void **library, bool *found, struct error *err)
{
    static const char *const files[] = {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so", NULL};
    static const char *const names[] = {"OSMesaCreateContextExt", "OSMesaDestroyContext",
                                        "OSMesaMakeCurrent", "OSMesaPixelStore",
                                        "OSMesaGetProcAddress"};
    if (!library_open(files, library, err))
        return false;
    *found = *library != NULL;
    if (!*found)
        return true;
    return library_find_all(*library, names, sizeof names / sizeof *names, out) ||
           error_unsupported(err, "libOSMesa lacks a function of OSMesa 8");
}
#endif

bool osmesa_open(struct contexts *contexts, bool *found, struct error *err)
{
    static const struct context_kind kind = {open_canvas, use_canvas, fill_canvas, close_canvas,
                                             end};
    struct osmesa *osmesa;
    void *library;
    *found = false;
    if (!MAKE_ARRAY(osmesa, 1, err, "OSMesa"))
        return false;
    contexts->own = osmesa;
    contexts->kind = &kind;
    contexts->name = "OSMesa";
    if (!find_functions(osmesa, &library, found, err))
        return false;
    return !*found || functions_find(contexts, library, osmesa->get, contexts->name, err);
}
