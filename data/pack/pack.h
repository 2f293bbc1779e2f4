/* SPDX-License-Identifier: MIT */
/* The room "pack": all that a scene needs, in one archive; spectral pack. */
#ifndef PACK_H
#define PACK_H

#include "data/options/options.h"
#include "spectral.h"

/* ---- command.c ---- */

/* Writes the scene with all files that it names as a tar archive, the same bytes for the same
 * files. Refuses a scene that names files outside of its folder: they would not be found where the
 * archive is unpacked. */
bool command_pack(struct options *options, struct error *err);

/* ---- Inside this room ---- */

/* archive.c: tar archives, as POSIX.1-2017 has them (pax, "ustar" where that can hold the name).
 * No date, owner or mode of a file is stored, so that equal files make equal archives. */

/* Adds a file under a name that is a relative path. */
bool archive_add(const struct output *to, const char *name, const char *path, struct error *err);
bool archive_end(const struct output *to, struct error *err);

#endif
