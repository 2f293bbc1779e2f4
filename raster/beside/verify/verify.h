/* SPDX-License-Identifier: MIT */
/* The room "verify": many scenes on many drivers, each judged as a render judges its picture; and
 * pictures that another program draws: spectral export writes a scene as plain files, spectral
 * judge reads that program's pixels as those of a renderer. data/doc/exchange.md is the contract of
 * all files. The latter needs no OpenGL. */
#ifndef RASTER_BESIDE_VERIFY_VERIFY_H
#define RASTER_BESIDE_VERIFY_VERIFY_H

#include "data/text/text.h"

/* ---- judge.c: spectral export, spectral judge ---- */

/* Writes all that another program needs to draw a scene into a new folder. */
extern const struct command export_command;
/* Judges the pixels that another program drew of a scene. Fails with EXIT_DIFFERENT where they
 * differ. */
extern const struct command judge_command;

/* ---- interval.c: spectral render --bounds ---- */

/* Writes the lowest and the highest legal count of each pixel. */
extern const struct map_maker interval_maker;

/* ---- command.c: spectral verify ---- */

/* Judges scenes on drivers, and prints a table. Fails with EXIT_DIFFERENT where a picture differs,
 * or is not verified. */
extern const struct command verify_command;

#endif
