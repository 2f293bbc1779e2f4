/* SPDX-License-Identifier: MIT */
/* The room "view": an interactive viewer of a scene in one HTML page, or a still picture. A live
 * page holds this program, and draws the scene anew after each change. A still page contains the
 * weights of each pixel, and computes the picture for any lights, detector and display by itself.
 */
#ifndef RASTER_BESIDE_VIEW_VIEW_H
#define RASTER_BESIDE_VIEW_VIEW_H

#include "data/text/text.h"

/* ---- command.c: spectral view ---- */

/* Writes the page or the picture of a scene, as the ending of its name says, and prints its numbers
 * of objects and lights. */
extern const struct command view_command;

#endif
