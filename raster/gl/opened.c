/* SPDX-License-Identifier: MIT */
/* An open OpenGL: the driver by which it is judged, and the pixels that it has shown. */
#include "raster/gl/inside.h"

/* Finds the driver by which the pixels are judged: a known one, or, where they are judged, one that
 * is measured. */
static bool choose_driver(const struct plan *plan, struct contexts *contexts,
                          const char *gl_renderer, struct driver *out, struct error *err)
{
    const struct driver *known = driver_of(gl_renderer);
    *out = *known;
    if (known != driver_of(NULL) || !plan->options.check)
        return true;
    if (!drawing_ways.measure)
        return error_unsupported(err,
                                 "%s is not known, and this program cannot measure it; --no-check "
                                 "draws without a check",
                                 gl_renderer);
    return drawing_ways.measure(contexts, gl_renderer, out, err);
}

bool opened_accept(struct renderer *renderer, const struct plan *plan, struct contexts *contexts,
                   const struct driver_threads *before, struct error *err)
{
    const struct rectangle tile = {0, 0, plan->tile_width, plan->tile_height};
    struct renderer_names *names = &renderer->names;
    return contexts_accept(contexts, &tile, plan->options.gl_driver, names, err) &&
           driver_has_threads(names->renderer, before, err) &&
           choose_driver(plan, contexts, names->renderer, &renderer->driver, err);
}

struct shown shown_at(const struct plan *plan, const float *numbers, const uint32_t *depths,
                      bool flipped, int x, int y)
{
    const size_t width = (size_t)plan->tile_width,
                 row = (size_t)(flipped ? y : plan->tile_height - 1 - y);
    return shown_of(plan->n_instances, numbers + 4 * ((size_t)y * width + (size_t)x),
                    depths ? depths[row * width + (size_t)x] : 0);
}
