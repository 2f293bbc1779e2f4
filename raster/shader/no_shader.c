/* SPDX-License-Identifier: MIT */
/* Takes the place of the other files of this room in a program without OpenGL. */

#include "raster/shader/shader.h"

bool shader_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    (void)plan, (void)n_buffers;
    *out = NULL;
    return error_failed(err, "this program was built without OpenGL");
}
