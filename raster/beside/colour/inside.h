/* SPDX-License-Identifier: MIT */
/* Only the files of the room "colour" include this. */
#ifndef RASTER_BESIDE_COLOUR_INSIDE_H
#define RASTER_BESIDE_COLOUR_INSIDE_H

#include "raster/beside/colour/colour.h"

/* The tone curve of a display: linear = (gain x value + offset)^exponent; for values below `from`
 * linear = slope x value. */
struct display_curve {
    double exponent, gain, offset, slope, from;
};
struct display_curve display_curve(enum display_kind kind, int channel);

#endif
