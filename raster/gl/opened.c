/* SPDX-License-Identifier: MIT */
/* What renderers through OpenGL share: the library and the driver by which it is judged, the tile
 * that is aimed at, and the pixels that are read back. */
#include <stdlib.h>

#include "raster/gl/inside.h"

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
    const struct rectangle tile = {0, 0, of->plan->tile_width, of->plan->tile_height};
    struct renderer_names *names = &of->renderer.names;
    return contexts_accept(of->contexts, &tile, of->plan->options.gl_driver, names, err) &&
           driver_has_threads(names->renderer, &of->before, err) &&
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
