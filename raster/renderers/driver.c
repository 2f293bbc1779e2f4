/* SPDX-License-Identifier: MIT */
/* Errors and rules of OpenGL's implementations, where the specification leaves them free. Measured
 * on Mesa 22.3.6; test/README.md says how. */
#include <string.h>

#include "raster/renderers/renderers.h"

/* llvmpipe moves corners to a grid of 1/256 pixel, to the nearest point (half a step), and follows
 * edges in integers. softpipe follows them line by line in single precision, from unmoved corners:
 * start, slope and step round 8 times relative to the largest coordinate. Depth is rounded by the
 * one (a product in single precision, then to the nearest of 2^24 - 1 steps) and truncated by the
 * other. A plane's value at a pixel rounds at the framebuffer's origin and in two sums; softpipe
 * adds steps to the pixel's right and lower neighbours. */
static const struct driver drivers[] = {
    {"llvmpipe", false, 1.0 / 512, 0, 1, 3, 0, 0, 1, true, true, FILL_LEFT_BOTTOM},
    {"softpipe", false, 0, 8, 1.5, 5, 0, 0, 1, true, false, FILL_ANY},
    {"unknown", false, 1.0 / 512, 8, 1.5, 5, 0, 0, 1, false, false, FILL_ANY},
};

const struct driver *driver_of(const char *gl_renderer)
{
    size_t last = sizeof drivers / sizeof *drivers - 1;
    for (size_t i = 0; gl_renderer && i < last; i++)
        if (strncmp(gl_renderer, drivers[i].name, strlen(drivers[i].name)) == 0)
            return &drivers[i];
    return &drivers[last];
}

void driver_print(const struct driver *driver, char out[DRIVER_WORDS])
{
    snprintf(
        out, DRIVER_WORDS,
        "edges to %.3g pixel, values to %.3g, depth to %g step, filters to %.3g, light to %g x "
        "Mesa's, %s where triangles meet",
        driver->grid_px, driver->corner_px, driver->depth_roundings, driver->filter_texels,
        driver->lighting, driver->watertight ? "no holes" : "holes");
}
