/* SPDX-License-Identifier: MIT */
/* Measures what each degree of accuracy costs in time, for one scene. It renders the scene in many
 * configurations, each by running this program as a user's command line does, and measures the
 * accuracy of their stacks. */
#ifndef RASTER_BESIDE_COST_COST_H
#define RASTER_BESIDE_COST_COST_H

#include "data/text/text.h"
#include "spectral.h"

/* ---- command.c: spectral cost ---- */

/* Measures configurations of render and names the best. Fails with EXIT_DIFFERENT if none is within
 * the tolerance or the budget. */
extern const struct command cost_command;

#endif
