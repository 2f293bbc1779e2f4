/* SPDX-License-Identifier: MIT */
/* How this program draws through OpenGL. */
#include "raster/beside/measure/measure.h"
#include "raster/beside/shader/shader.h"

const struct drawing_ways drawing_ways = {
    .open = {[GL_WITHOUT_SHADERS] = gl_open, [GL_CORE] = shader_open, [GL_ES] = shader_open},
    .measure = driver_measure,
    .library = gl_library,
};
