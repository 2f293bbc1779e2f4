/* SPDX-License-Identifier: MIT */
#ifndef RASTER_H
#define RASTER_H
#include "raster/cost/cost.h"
#include "raster/inspect/inspect.h"
#include "raster/view/view.h"
#endif
