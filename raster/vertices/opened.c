/* SPDX-License-Identifier: MIT */
/* An open OpenGL: the driver by which it is judged, and the pixels that it has shown. */
#include "raster/context/context.h"
#include "raster/traits/traits.h"
#include "raster/vertices/vertices.h"

bool opened_accept(struct renderer *renderer, const struct plan *plan, struct contexts *contexts,
                   const struct driver_threads *before, struct error *err)
{
    const struct rectangle tile = {0, 0, plan->tile_width, plan->tile_height};
    struct renderer_names *names = &renderer->names;
    return contexts_accept(contexts, &tile, plan->options.gl_driver, names, err) &&
           driver_has_threads(names->renderer, before, err) &&
           traits_choose(contexts, names->renderer, plan->options.check, &renderer->driver, err);
}

struct shown shown_at(const struct plan *plan, const float *numbers, const uint32_t *depths,
                      bool flipped, int x, int y)
{
    const size_t width = (size_t)plan->tile_width,
                 row = (size_t)(flipped ? y : plan->tile_height - 1 - y);
    return shown_of(plan, numbers + 4 * ((size_t)y * width + (size_t)x),
                    depths ? depths[row * width + (size_t)x] : 0);
}
