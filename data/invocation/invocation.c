/* SPDX-License-Identifier: MIT */
/* A scene as the command line names it, changes it and samples it. */
#include <unistd.h>

#include "data/base/base.h"
#include "data/invocation/invocation.h"
#include "data/method/method.h"

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

bool scene_read_sampled(const struct options *options, struct scene *out, struct sampling *sampling,
                        struct error *err)
{
    struct sampling_method method;
    if (!options->sampling)
        return options->detector ? error_usage(err, "--detector needs --sampling, which samples "
                                                    "for it; develop takes any detector")
                                 : scene_read_options(options, out, err);
    return sampling_read("--sampling", options->sampling, &method, err) &&
           scene_read_options(options, out, err) &&
           scene_sample(out, &method, options_detector(options), sampling, err);
}
