/* SPDX-License-Identifier: MIT */
/* What renderers through OpenGL share: the library as it describes itself, the driver by which it
 * is judged, the tile that is aimed at, and the pixels that are read back. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster/gl/inside.h"

/* ---- a library as it describes itself ---- */

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

/* ---- opening ---- */

bool drawing_open(struct drawing *of, int n_buffers, struct error *err)
{
    const struct plan *plan = of->plan;
    const struct context_wish wish = {plan->options.gl_library, plan->options.gl_driver,
                                      plan->options.threads, plan->options.gl_way};
    const size_t n = (size_t)plan->tile_width * (size_t)plan->tile_height;
    if (!renderer_make_buffers(&of->renderer, n_buffers, n, "the pixels of a tile", err) ||
        !(plan->n_light_groups == 1 || MAKE_ARRAY(of->part, 4 * n, err, "the pixels of a tile")) ||
        !(!plan->options.check || (MAKE_ARRAY(of->shown, 4 * n, err, "the numbers of a tile") &&
                                   MAKE_ARRAY(of->depths, n, err, "the depths of a tile"))))
        return false;
    driver_count_threads(&of->before);
    if (!contexts_open(&wish, &of->contexts, err))
        return false;
    of->call = &of->contexts->call;
    return true;
}

bool drawing_canvas(const struct drawing *of, int bits, int n_colours, struct canvas **out,
                    struct error *err)
{
    const struct canvas_size size = {bits, of->plan->tile_width, of->plan->tile_height, n_colours};
    return canvas_open(of->contexts, &size, out, err);
}

/* Finds the driver by which the pixels are judged: a known one, or, where they are judged, one that
 * is measured. */
static bool choose_driver(const struct drawing *of, const char *gl_renderer, struct driver *out,
                          struct error *err)
{
    const struct driver *known = driver_of(gl_renderer);
    *out = *known;
    if (known != driver_of(NULL) || !of->plan->options.check)
        return true;
    if (!drawing_ways.measure)
        return error_unsupported(err,
                                 "%s is not known, and this program cannot measure it; --no-check "
                                 "draws without a check",
                                 gl_renderer);
    return drawing_ways.measure(of->contexts, gl_renderer, out, err);
}

bool drawing_accept(struct drawing *of, struct error *err)
{
    static const char *const any[] = {
        [GL_WITHOUT_SHADERS] = "gl", [GL_CORE] = "gl-shader", [GL_ES] = "es-shader"};
    const struct contexts *contexts = of->contexts;
    const char *wanted = of->plan->options.gl_driver;
    struct renderer_names *names = &of->renderer.names;
    GLint largest[2] = {0, 0};
    of->call->GetIntegerv(GL_MAX_VIEWPORT_DIMS, largest);
    if (largest[0] < of->plan->tile_width || largest[1] < of->plan->tile_height)
        return error_unsupported(err, "%s draws at most %d x %d pixels at once", contexts->name,
                                 largest[0], largest[1]);
    identify(contexts, names);
    if (wanted && strncmp(names->renderer, wanted, strlen(wanted)) != 0)
        return error_unsupported(err,
                                 "this %s draws with %.100s, not with %s; --renderer %s takes any "
                                 "driver",
                                 names->library, names->renderer, wanted, any[contexts->way]);
    return driver_has_threads(names->renderer, &of->before, err) &&
           choose_driver(of, names->renderer, &of->renderer.driver, err);
}

bool drawing_take_scene(struct renderer *renderer, const struct lit_scene *lit, struct error *err)
{
    struct drawing *of = (struct drawing *)renderer;
    of->lit = lit;
    return meshes_upload(of, err) && textures_upload(of, err) && functions_succeeded(of->call, err);
}

void drawing_close(struct drawing *of)
{
    contexts_close(of->contexts);
    FREE_ALL(of->objects, of->indices, of->textures, of->part, of->shown, of->depths);
    renderer_free(&of->renderer);
}

/* ---- a tile ---- */

/* A smaller tile lies in the first rows of the buffer. */
void drawing_set_viewport(const struct drawing *of)
{
    of->call->Viewport(0, of->contexts->flipped ? 0 : of->plan->tile_height - of->tile.height,
                       of->tile.width, of->tile.height);
}

void drawing_read_depths(const struct drawing *of)
{
    if (of->depths)
        of->call->ReadPixels(0, 0, of->plan->tile_width, of->plan->tile_height, GL_DEPTH_STENCIL,
                             GL_UNSIGNED_INT_24_8, of->depths);
}

struct shown drawing_shown(const struct renderer *renderer, int x, int y)
{
    const struct drawing *of = (const struct drawing *)renderer;
    const size_t width = (size_t)of->plan->tile_width,
                 row = (size_t)(of->contexts->flipped ? y : of->plan->tile_height - 1 - y);
    return shown_of(of->plan->n_instances, of->shown + 4 * ((size_t)y * width + (size_t)x),
                    of->depths ? of->depths[row * width + (size_t)x] : 0);
}
