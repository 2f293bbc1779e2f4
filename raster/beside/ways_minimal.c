/* SPDX-License-Identifier: MIT */
/* The minimal program draws without shaders, by drivers that it knows. */
#include "raster/gl/gl.h"

const struct drawing_ways drawing_ways = {
    .open = {[GL_WITHOUT_SHADERS] = gl_open},
    .library = gl_library,
};
