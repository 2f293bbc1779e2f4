/* SPDX-License-Identifier: MIT */
/* Takes the place of all other files of this room in a program without OpenGL. */

#include "raster/gl/gl.h"

bool gl_is_built(void)
{
    return false;
}

void gl_library(char *out, size_t capacity)
{
    snprintf(out, capacity, "without OpenGL");
}

bool gl_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    (void)plan, (void)n_buffers;
    *out = NULL;
    return error_failed(err, "this program was built without OpenGL");
}
