/* SPDX-License-Identifier: MIT */
/* Measures what each degree of accuracy costs in time, for one scene. It renders the scene in some
 * configurations, each by running this program as a user's command line does, and measures how far
 * their stacks are off. */
#ifndef RASTER_BESIDE_COST_COST_H
#define RASTER_BESIDE_COST_COST_H

#include "data/text/text.h"

/* ---- command.c: spectral cost ---- */

/* Names the cheapest configuration of render for some errors, and what else accuracy costs. */
extern const struct command cost_command;

#endif
