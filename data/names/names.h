/* SPDX-License-Identifier: MIT */
/* The room "names": the files that words name. Some files are built in, and each kind of them has
 * names of its own, which `spectral list` prints. */
#ifndef NAMES_H
#define NAMES_H

#include "data/text/text.h"
#include "spectral.h"

/* ---- names.c ---- */

enum file_kind {
    FILE_SCENE,
    FILE_MATERIAL,
    FILE_LIST, /* of materials */
    FILE_TABLE,
    FILE_MODEL,
    FILE_MAP, /* of materials of a mesh */
    FILE_TEXTURE,
    FILE_KINDS
};
/* Writes the name of a built-in file of this kind. Returns false if the file is of another kind. */
bool builtin_is(const struct builtin_file *file, enum file_kind kind, char out[BUILTIN_NAME]);
/* Finds the path of the file that a word names, relative to the word's own file. *out is allocated.
 * Refuses an empty word. */
bool word_path(const struct word *word, char **out, struct error *err);
/* Finds the file that a word names: a built-in one by its name, or a file relative to the word's
 * own file; if that is missing, a built-in one whose name differs in case. *out is its path,
 * allocated. Refuses an empty word, but not a missing file. */
bool word_file(const struct word *word, enum file_kind kind, char **out, struct error *err);
/* Refuses a missing file, and proposes a built-in one of this kind. The place names the file. */
bool file_expected(const char *path, struct place from, enum file_kind kind, struct error *err);

#endif
