/* SPDX-License-Identifier: MIT */
/* Only the files of the room "measure" include this. */
#ifndef RASTER_BESIDE_MEASURE_INSIDE_H
#define RASTER_BESIDE_MEASURE_INSIDE_H

#include "raster/beside/measure/measure.h"
#include "raster/beside/shader/shader.h"

/* ---- targets.c ---- */

/* Prints what was measured beside what OpenGL allows, a line each. */
void traits_print(const struct driver *of, struct printed *to);
/* Puts it as the object "measured_bounds". */
void traits_json(const struct driver *of, struct json *json);

#endif
