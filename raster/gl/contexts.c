/* SPDX-License-Identifier: MIT */
/* A library as it describes itself. */
#include <stdio.h>
#include <string.h>

#include "raster/gl/inside.h"

#ifdef OSMESA_VERSION /* built in; asking a context of softpipe would take tens of milliseconds */
static const char built_in[] = "OSMesa " OSMESA_VERSION " (softpipe), built in";
#else
static const char *const built_in = NULL;
#endif

static void copy_text(const struct gl_functions *call, GLenum name, char out[128])
{
    snprintf(out, 128, "%s", (const char *)call->GetString(name));
}

static void identify(const struct contexts *contexts, struct renderer_names *out)
{
    snprintf(out->library, sizeof out->library, "%s", contexts->name);
    copy_text(&contexts->call, GL_RENDERER, out->renderer);
    copy_text(&contexts->call, GL_VERSION, out->version);
}

bool contexts_accept(const struct contexts *contexts, const struct rectangle *size,
                     const char *wanted, struct renderer_names *out, struct error *err)
{
    static const char *const any[] = {
        [GL_WITHOUT_SHADERS] = "gl", [GL_CORE] = "gl-shader", [GL_ES] = "es-shader"};
    GLint largest[2] = {0, 0};
    contexts->call.GetIntegerv(GL_MAX_VIEWPORT_DIMS, largest);
    if (largest[0] < size->width || largest[1] < size->height)
        return error_unsupported(err, "%s draws at most %d x %d pixels at once", contexts->name,
                                 largest[0], largest[1]);
    identify(contexts, out);
    return !wanted || strncmp(out->renderer, wanted, strlen(wanted)) == 0 ||
           error_unsupported(err,
                             "this %s draws with %.100s, not with %s; --renderer %s takes any "
                             "driver",
                             out->library, out->renderer, wanted, any[contexts->way]);
}

bool contexts_describe(const struct context_wish *wish, struct context_description *out,
                       struct error *err)
{
    struct contexts *contexts;
    struct canvas *canvas = NULL;
    GLfloat pixel[4];
    const struct canvas_size size = {.bits = 32, .width = 1, .height = 1, .n_colours = 1};
    const bool done = contexts_open(wish, &contexts, err) &&
                      canvas_open(contexts, &size, &canvas, err) && canvas_use(canvas, pixel, err);
    if (done) {
        const struct gl_functions *call = &contexts->call;
        identify(contexts, &out->names);
        copy_text(call, GL_VENDOR, out->vendor);
        call->GetIntegerv(GL_MAX_VIEWPORT_DIMS, out->largest_viewport);
        call->GetIntegerv(GL_MAX_TEXTURE_SIZE, &out->largest_texture);
    }
    canvas_close(canvas);
    contexts_close(contexts);
    return done;
}

void gl_library(char *out, size_t capacity)
{
    const struct context_wish wish = {.threads = 1};
    struct context_description is;
    struct error err = {.status = EXIT_AGREED};
    if (built_in)
        snprintf(out, capacity, "%s", built_in);
    else if (contexts_describe(&wish, &is, &err))
        snprintf(out, capacity, "%s %s (%s)", is.names.library, is.names.version,
                 is.names.renderer);
    else
        snprintf(out, capacity, "OpenGL cannot draw: spectral drivers prints why");
}
