/* SPDX-License-Identifier: MIT */
/* Draws the plan's picture by shaders, through OpenGL 3.3 core or OpenGL ES 3.0, for drivers
 * without lighting of their own. A vertex shader does that lighting; up to 12 bands are drawn at
 * once, three in each of four buffers of colours. As raster/gl it may not know what the reference
 * shows. */
#ifndef RASTER_BESIDE_SHADER_SHADER_H
#define RASTER_BESIDE_SHADER_SHADER_H

#include "raster/gl/gl.h"

/* Opens OpenGL for a plan whose gl_way has shaders, as gl_open does. */
bool shader_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err);

#endif
