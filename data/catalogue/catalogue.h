/* SPDX-License-Identifier: MIT */
/* The room "catalogue": the names of everything that is built in. */
#ifndef CATALOGUE_H
#define CATALOGUE_H

#include "data/base/base.h"
#include "data/options/options.h"
#include "spectral.h"

/* ---- command.c: spectral list ---- */

/* Prints the names of one kind, or of all kinds. */
bool command_list(struct options *options, struct error *err);

#endif
