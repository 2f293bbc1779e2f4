/* SPDX-License-Identifier: MIT */
/* The room "inputs": the files that a scene is made of, beside its own text. */
#ifndef INPUTS_H
#define INPUTS_H

#include "data/scene/scene.h"
#include "spectral.h"

/* Materials, spectra, textures, meshes: files that decide a picture, and that are not built in. */
struct inputs {
    char **path; /* in the order of strcmp, each once; both are owned */
    int n;
};
/* Lists the files that the scene's text and its options name, as far as the picture needs them and
 * they are there: a material that no object uses is not read, and a plan refuses a missing file
 * that it needs. detector: a file or a built-in name; NULL: the scene is not sampled for one. The
 * caller frees *out, also after a failure. */
bool inputs_list(const struct scene *scene, const char *detector, struct inputs *out,
                 struct error *err);
/* Lists these and the files of the scene's text, unless that came from a pipe. */
bool inputs_all(const struct scene *scene, const char *detector, struct inputs *out,
                struct error *err);
void inputs_free(struct inputs *inputs);
/* Prints "SHA-256 PATH" and a NUL for each file, as this process has read it, or else reads it. */
bool inputs_digest(const struct inputs *inputs, struct printed *to, struct error *err);

#endif
