/* SPDX-License-Identifier: MIT */
/* A scene as the command line names and changes it. */
#include <unistd.h>

#include "commands.h"

bool scene_read_options(const struct options *options, struct scene *out, struct error *err)
{
    if (!scene_read(options_scene(options), out, err))
        return false;
    for (int i = 0; i < options->n_changes; i++)
        if (!options->changes[i].apply(out, options->changes[i].value, err))
            return false;
    return true;
}

bool scene_spared(const char *output, const struct scene *scene, struct error *err)
{
    for (int i = 0; i < scene->n_files; i++)
        if (!output_spares(output, scene->files[i].path, err))
            return false;
    return true;
}

bool scene_refuse(const char *stack, struct error *err)
{
    return access(stack, F_OK) == 0 || scene_is_missing(stack) ||
           error_usage(err, "'%s' is a scene, not a stack; spectral render %s writes one", stack,
                       stack);
}
