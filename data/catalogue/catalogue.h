/* SPDX-License-Identifier: MIT */
/* The room "catalogue": the names of everything that is built in. */
#ifndef CATALOGUE_H
#define CATALOGUE_H

#include "data/base/base.h"
#include "data/options/options.h"
#include "spectral.h"

/* ---- command.c: spectral list, spectral show ---- */

/* Prints the names of one kind, or of all kinds. */
bool command_list(struct options *options, struct error *err);
/* Writes a built-in file, by the name that a list prints or by its path "builtin:...", to standard
 * output or to the output. If files of several kinds have the name, it is the first of scene,
 * material, list of materials, spectrum or detector, model, material map and texture. */
bool command_show(struct options *options, struct error *err);

#endif
