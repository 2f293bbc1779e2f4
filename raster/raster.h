/* SPDX-License-Identifier: MIT */
#ifndef RASTER_H
#define RASTER_H
#include "raster/cost/cost.h"
#include "raster/inspect/inspect.h"
#include "raster/view/view.h"
bool shape_build(const struct shape *shape, struct mesh *out, struct error *err);
#endif
