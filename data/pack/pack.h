/* SPDX-License-Identifier: MIT */
/* The room "pack": all that a scene needs, in one archive; spectral pack. */
#ifndef PACK_H
#define PACK_H

#include "data/index/index.h"
#include "data/inputs/inputs.h"
#include "data/options/options.h"
#include "spectral.h"

/* ---- files.c: the files of a scene, as seen from its folder ---- */

/* A file that is not built in. */
struct packed_file {
    char *name; /* relative to the scene's folder, without "." and ".."; owned */
    const char *path;
};
struct packing {
    struct packed_file *files; /* the first one is the scene's; owned */
    int n_files;
    struct index places;  /* in `files`, by name */
    struct inputs inputs; /* own the paths of files that are no texts of the scene */
    char *above;          /* how the paths of files in that folder begin: "" or "scenes/"; owned */
};
/* Returns the scene's name with a mark, so that the paths of all files that the scene names by
 * relative names begin in another way than a path from / on. Read the scene under this name.
 * Allocated; NULL: no memory. */
char *pack_marked_name(const char *scene);
/* Lists the texts of a scene and the files that it names. The scene must outlive *out. Refuses a
 * file outside of the scene's folder. The caller frees *out, also after a failure. */
bool packing_make(const struct scene *scene, struct packing *out, struct error *err);
void packing_free(struct packing *packing);

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
