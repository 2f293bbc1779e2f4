/* SPDX-License-Identifier: MIT */
/* Errors and rules of OpenGL's implementations, where the specification leaves them free. Measured
 * on Mesa 22.3.6; data/doc/mesa.md says how. */
#include "raster/renderers/renderers.h"

/* ---- errors and rules ---- */

/* llvmpipe moves corners to a grid of 1/256 pixel, to the nearest point (half a step), and follows
 * edges in integers. softpipe follows them line by line in single precision, from unmoved corners:
 * start, slope and step round 8 times relative to the largest coordinate. Depth is rounded by the
 * one (a product in single precision, then to the nearest of 2^24 - 1 steps) and truncated by the
 * other. A plane's value at a pixel rounds at the framebuffer's origin and in two sums; softpipe
 * adds steps to the pixel's right and lower neighbours. The level of detail follows from one corner
 * of a quad of pixels. */
static const struct driver drivers[] = {
    {"llvmpipe", false, 1.0 / 512, 0, 1, 3, 0, 0, 1, true, true, FILL_LEFT_BOTTOM,
     .detail = {.quad = true, .logarithm = LOGARITHM_LINEAR}},
    {"softpipe", false, 0, 8, 1.5, 5, 0, 0, 1, true, false, FILL_ANY,
     .detail = {.quad = true, .lower = true, .largest = true, .logarithm = LOGARITHM_TABLE}},
    {"unknown", false, 1.0 / 512, 8, 1.5, 5, 0, 0, 1, false, false, FILL_ANY, .detail_error = -1},
};

enum { N_KNOWN = sizeof drivers / sizeof *drivers - 1 };

const struct driver *driver_of(const char *gl_renderer)
{
    for (size_t i = 0; gl_renderer && i < N_KNOWN; i++)
        if (strncmp(gl_renderer, drivers[i].name, strlen(drivers[i].name)) == 0)
            return &drivers[i];
    return &drivers[N_KNOWN];
}

bool driver_is_known(const struct driver *driver)
{
    return !driver->is_measured && strcmp(driver->name, drivers[N_KNOWN].name) != 0;
}

/* softpipe of Mesa 20.3 takes logarithms without a table, which are off by half a step of it at
 * most, 0.0029. Which version between it and 22.3 changed has not been tried. */
void driver_of_version(struct driver *driver, const char *gl_version)
{
    const char *mesa = strstr(gl_version, "Mesa ");
    if (!mesa || driver->detail.logarithm != LOGARITHM_TABLE ||
        strtod(mesa + strlen("Mesa "), NULL) >= 22.3)
        return;
    driver->detail_error = 0.0029;
    driver->detail.logarithm = LOGARITHM_EXACT;
}

void driver_print(const struct driver *driver, char out[DRIVER_WORDS])
{
    char detail[32] = "as specified";
    if (driver->detail_error >= 0)
        snprintf(detail, sizeof detail, "to %.2g", driver->detail_error);
    snprintf(out, DRIVER_WORDS,
             "edges to %.3g pixel, values to %.3g, depth to %g step, filters to %.3g, levels of "
             "detail %s, light to %g x Mesa's, %s where triangles meet",
             driver->grid_px, driver->corner_px, driver->depth_roundings, driver->filter_texels,
             detail, driver->lighting,
             !driver->watertight   ? "holes"
             : driver->is_measured ? "no holes seen"
                                   : "no holes");
}

/* ---- --renderer ---- */

const char *const renderer_words[] = {"gl",
                                      "llvmpipe",
                                      "softpipe",
                                      "gl-shader",
                                      "gl-shader:llvmpipe",
                                      "gl-shader:softpipe",
                                      "es-shader",
                                      "es-shader:llvmpipe",
                                      "es-shader:softpipe",
                                      "raster",
                                      NULL};

enum gl_way driver_way(const char *renderer, const char **driver)
{
    *driver = NULL;
    for (int i = 0; renderer && i < GL_WAYS * WAY_WORDS; i++)
        if (strcmp(renderer, renderer_words[i]) == 0) {
            *driver = i % WAY_WORDS > 0 ? drivers[i % WAY_WORDS - 1].name : NULL;
            return (enum gl_way)(i / WAY_WORDS);
        }
    return GL_WITHOUT_SHADERS;
}

/* ---- --gl ---- */

int driver_device(const char *library)
{
    static const char prefix[] = "egl:";
    const size_t length = sizeof prefix - 1;
    const char *digits = library + length;
    if (strncmp(library, prefix, length) != 0 || !*digits || strlen(digits) > 2 ||
        digits[strspn(digits, "0123456789")] != '\0')
        return -1;
    return atoi(digits);
}

bool driver_accepts_library(const char *option, const char *value, struct error *err)
{
    return strcmp(value, "osmesa") == 0 || strcmp(value, "egl") == 0 ||
           strcmp(value, "auto") == 0 || driver_device(value) >= 0 ||
           error_at(err, VALUE_OF(option),
                    "expected osmesa, egl, egl:N (EGL's device N) or auto, not '%.100s'", value);
}
