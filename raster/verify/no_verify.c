/* SPDX-License-Identifier: MIT */
/* Takes the place of the other files of this room in a program without OpenGL. */

#include "raster/verify/verify.h"

bool command_verify(struct options *options, struct error *err)
{
    (void)options;
    return error_failed(err, "this program was built without OpenGL; there is none to verify");
}
