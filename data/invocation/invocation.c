/* SPDX-License-Identifier: MIT */
/* A scene as the command line names it, changes it and samples it. */
#include <string.h>

#include "data/base/base.h"
#include "data/invocation/invocation.h"
#include "data/method/method.h"

/* Refuses a stack or a picture where a scene is expected. */
static bool refuse_picture(const char *scene, struct error *err)
{
    const char *format;
    if (!file_format(scene, &format, err))
        return false;
    if (strcmp(format, "TIFF") == 0)
        return error_usage(err,
                           "%s is a TIFF file, not a scene; a stack is for develop, probe, "
                           "compare, view and info",
                           scene);
    return format[0] == '\0' || strcmp(format, "text") == 0 ||
           error_usage(err, "%s is a %s file, not a scene", scene, format);
}

bool scene_read_options(const struct options *options, struct scene *out, struct error *err)
{
    if (!refuse_picture(options_scene(options), err) ||
        !scene_read(options_scene(options), out, err))
        return false;
    for (int i = 0; i < options->n_changes; i++)
        if (!options->changes[i].apply(out, options->changes[i].value, err))
            return false;
    return true;
}

bool scene_refuse(const char *stack, struct error *err)
{
    const char *format;
    if (!file_format(stack, &format, err))
        return false;
    const bool is_text = strcmp(format, "text") == 0;
    return (!is_text && (!file_is_missing(stack) || scene_is_missing(stack))) ||
           error_usage(err, "%s is %s, not a stack; spectral render writes the stack of a scene",
                       stack, is_text ? "a text file" : "a scene");
}

bool scene_read_sampled(const struct options *options, struct scene *out, struct sampling *sampling,
                        struct error *err)
{
    struct sampling_method method;
    if (!options->sampling)
        return options->detector && !options->accuracy
                   ? error_usage(err, "--detector needs --sampling, which samples "
                                      "for it; develop takes any detector")
                   : scene_read_options(options, out, err);
    return sampling_read("--sampling", options->sampling, &method, err) &&
           scene_read_options(options, out, err) &&
           scene_sample(out, &method, options_detector(options), sampling, err);
}
