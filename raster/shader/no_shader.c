/* SPDX-License-Identifier: MIT */
/* Takes the place of the other files of this room in a program without OpenGL. */
#include <errno.h>

#include "raster/shader/shader.h"

bool shader_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    (void)plan, (void)n_buffers;
    *out = NULL;
    errno = 0;
    return error_system(err, "this program was built without OpenGL");
}
