/* SPDX-License-Identifier: MIT */
/* A program without OpenGL. */
#include "raster/renderers/renderers.h"

const struct drawing_ways drawing_ways = {.library = NULL};
