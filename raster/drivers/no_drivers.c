/* SPDX-License-Identifier: MIT */
/* Takes the place of the other files of this room in a program without OpenGL. */

#include "raster/drivers/drivers.h"

bool command_drivers(struct options *options, struct error *err)
{
    (void)options;
    return error_failed(err, "this program was built without OpenGL; --renderer raster draws");
}
