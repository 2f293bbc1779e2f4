/* SPDX-License-Identifier: MIT */
/* Contexts of OSMesa, which draws into memory of the caller. Types and constants are those of
 * Mesa's GL/osmesa.h, which newer systems do not have. */
#include "raster/gl/inside.h"

typedef struct osmesa_context *OSMesaContext;
enum { OSMESA_RGBA = GL_RGBA, OSMESA_Y_UP = 0x11 };

struct osmesa {
    struct library_functions find;
    OSMesaContext (*create)(GLenum format, GLint depth, GLint stencil, GLint accumulation,
                            OSMesaContext shared);
    void (*destroy)(OSMesaContext context);
    GLboolean (*make_current)(OSMesaContext context, void *buffer, GLenum type, GLsizei width,
                              GLsizei height);
    void (*pixel_store)(GLint name, GLint value);
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

static bool use_canvas(struct canvas *canvas, void *pixels, struct error *err)
{
    const struct osmesa *osmesa = osmesa_of(canvas);
    if (!osmesa->make_current(canvas->context, pixels, canvas_type(canvas), canvas->width,
                              canvas->height))
        return error_system(err, "OSMesa gives no context of %d x %d pixels of %d bits a channel",
                            canvas->width, canvas->height, canvas->bits);
    if (canvas->contexts->current != canvas)
        osmesa->pixel_store(OSMESA_Y_UP, 0); /* first row on top, as in the picture */
    return true;
}

/* Only now does OSMesa fill the caller's memory. */
static void fill_canvas(const struct canvas *canvas, int colours, void *pixels)
{
    (void)colours, (void)pixels;
    canvas->contexts->call.Finish();
}

static void close_canvas(struct canvas *canvas)
{
    osmesa_of(canvas)->destroy(canvas->context);
}

/* ---- the library ---- */

static const char *const files[] = {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so", NULL};
/* In the order of struct osmesa, and of `built_in` in library.c. */
static const char *const functions[] = {"OSMesaGetProcAddress", "OSMesaCreateContextExt",
                                        "OSMesaDestroyContext", "OSMesaMakeCurrent",
                                        "OSMesaPixelStore"};
enum { N_FUNCTIONS = sizeof functions / sizeof *functions };
static const char too_old[] = "libOSMesa lacks a function of OSMesa 8";

const struct context_kind osmesa_kind = {
    "OSMesa", false, files,       functions,  N_FUNCTIONS, sizeof(struct osmesa), too_old,
    NULL,     NULL,  open_canvas, use_canvas, fill_canvas, close_canvas};
