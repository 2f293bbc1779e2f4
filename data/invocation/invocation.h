/* SPDX-License-Identifier: MIT */
/* The room "invocation": a scene as the command line names it, changes it and samples it. */
#ifndef INVOCATION_H
#define INVOCATION_H

#include "data/options/options.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "spectral.h"

/* Reads SCENE and makes the changes that the options ask for, in their order. */
bool scene_read_options(const struct options *options, struct scene *out, struct error *err);
/* Refuses a text file, or the name of a built-in scene, where a stack is expected: nobody has
 * rendered it yet.
 * A missing file passes: whoever opens it reports that. */
bool scene_refuse(const char *stack, struct error *err);
/* Reads SCENE with its changes, and samples it if --sampling is given; otherwise *sampling stays
 * zeroed. Refuses --detector without --sampling or --accuracy. The caller frees both, also after a
 * failure. */
bool scene_read_sampled(const struct options *options, struct scene *out, struct sampling *sampling,
                        struct error *err);

#endif
