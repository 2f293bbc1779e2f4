/* SPDX-License-Identifier: MIT */
/* Fuzz targets: each hands bytes to a reader, and looks at the result. It ends the program with
 * abort() if the result breaks a rule that holds for all bytes; the sanitizers look for the rest.
 */
#ifndef FUZZ_H
#define FUZZ_H

#include <stdbool.h>
#include <stddef.h>

#include "spectral.h"

enum { FUZZ_PATH = 512 };
/* Bytes to be read, and the NUL behind them; the path of the file that holds them, too. */
struct fuzz_input {
    const char *bytes;
    size_t length;
    char path[FUZZ_PATH];
};
struct fuzz_target {
    const char *name, *ending; /* of the file; NULL: the bytes are in none */
    void (*run)(const struct fuzz_input *input);
};
/* Returns the target of that name; NULL: there is none. */
const struct fuzz_target *fuzz_target(const char *name);
/* Gives the target a copy of the bytes, whose end the sanitizers guard. */
void fuzz_run(const struct fuzz_target *target, const unsigned char *bytes, size_t length);

/* Writes bytes to a file of this process in $FUZZ_FOLDER, with this ending, and stores its path. */
void fuzz_write(const char *ending, const char *bytes, size_t length, char path[FUZZ_PATH]);
/* Aborts unless the truth holds. */
void fuzz_holds(bool truth, const char *what);
/* Aborts if a success has an error, or if a failure has no message of one line, or none of the
 * statuses 2 and 3. Returns `done`. */
bool fuzz_ends(bool done, const struct error *err);

/* The targets, each in its file. */
void fuzz_scene(const struct fuzz_input *input);
void fuzz_list(const struct fuzz_input *input);
void fuzz_material(const struct fuzz_input *input);
void fuzz_table(const struct fuzz_input *input);
void fuzz_mesh(const struct fuzz_input *input);
void fuzz_mtl(const struct fuzz_input *input);
void fuzz_map(const struct fuzz_input *input);
void fuzz_matrix(const struct fuzz_input *input);
void fuzz_display(const struct fuzz_input *input);
void fuzz_texture(const struct fuzz_input *input);
void fuzz_png(const struct fuzz_input *input);
void fuzz_record(const struct fuzz_input *input);
void fuzz_stack(const struct fuzz_input *input);
void fuzz_line(const struct fuzz_input *input);

#endif
