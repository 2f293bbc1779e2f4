/* SPDX-License-Identifier: MIT */
/* The room "catalogue": the names of everything that is built in. */
#ifndef CATALOGUE_H
#define CATALOGUE_H

#include "data/base/base.h"
#include "data/options/options.h"
#include "spectral.h"

/* ---- command.c: spectral list ---- */

/* Writes the name by which scenes and options refer to a built-in table, of a detector or of an
 * illuminant. Returns false if the file is not such a table. `out` has room for `capacity` bytes.
 */
bool table_name(const struct builtin_file *file, bool detector, char *out, size_t capacity);
/* Prints the names of one kind, or of all kinds. */
bool command_list(struct options *options, struct error *err);

#endif
