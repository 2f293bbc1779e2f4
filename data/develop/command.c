/* SPDX-License-Identifier: MIT */
/* spectral develop: the colour picture of a stack. */
#include <stdio.h>
#include <string.h>

#include "data/base/base.h"
#include "data/develop/develop.h"
#include "data/invocation/invocation.h"
#include "data/pages/pages.h"

/* ---- options ---- */

bool develop_accepts_adaptation(const char *option, const char *value, struct error *err)
{
    struct adaptation adaptation;
    return adaptation_read(option, value, &adaptation, err);
}

bool develop_accepts_display(const char *option, const char *value, struct error *err)
{
    enum display_kind display;
    return display_read(option, value, &display, err);
}

/* Returns the exposure, or 0 for auto. */
static bool exposure_read(const char *option, const char *value, double *out, struct error *err)
{
    *out = 0;
    return strcmp(value, "auto") == 0 || option_number(option, value, 1e-12, 1e12, out, err);
}

bool develop_accepts_exposure(const char *option, const char *value, struct error *err)
{
    double exposure;
    return exposure_read(option, value, &exposure, err);
}

/* Stores the sampling method in *method; out->sampling points to it. */
static bool read_options(struct options *options, struct sampling_method *method,
                         struct develop_options *out, struct error *err)
{
    *out =
        (struct develop_options){.detector = options_detector(options),
                                 .white = options->white,
                                 .exposure = 1,
                                 .values = options->xyz   ? DEVELOP_XYZ
                                           : options->lab ? DEVELOP_LAB
                                                          : DEVELOP_RGB,
                                 .bits = options->bits && strcmp(options->bits, "16") == 0 ? 16 : 8,
                                 .threads = options->threads,
                                 .outputs = &options->outputs,
                                 .sampling = options->sampling ? method : NULL};
    if (options->xyz && options->lab)
        return error_usage(err, "--xyz and --lab exclude each other");
    return (!options->adaptation ||
            adaptation_read("--adaptation", options->adaptation, &out->adaptation, err)) &&
           (!options->display || display_read("--display", options->display, &out->display, err)) &&
           (!options->exposure ||
            exposure_read("--exposure", options->exposure, &out->exposure, err)) &&
           (!options->sampling || sampling_read("--sampling", options->sampling, method, err));
}

/* ---- the command ---- */

/* Names the picture, if the command line does not, and refuses a PNG of floats. */
static bool name_picture(struct options *options, const char *stack, struct error *err)
{
    const char *floats = options->xyz ? "--xyz" : options->lab ? "--lab" : NULL;
    if (!options_name_output(options, stack, floats ? "-developed.tif" : "-developed.png", err) ||
        !picture_accepts(options->output, err))
        return false;
    return !floats || !picture_is_png(options->output) ||
           error_at(err, (struct place){options->output, 0, 0},
                    "%s writes floats, and a PNG has none; expected .tif or .tiff", floats);
}

bool command_develop(struct options *options, struct error *err)
{
    struct sampling_method method;
    struct develop_options develop_options;
    struct develop_result result;
    const char *stack = options->operand;
    if (!stack)
        return error_usage(err, "develop takes a STACK; see spectral develop --help");
    if (!name_picture(options, stack, err) ||
        !read_options(options, &method, &develop_options, err) || !scene_refuse(stack, err) ||
        !output_can_open(options->json, err) ||
        !develop(stack, options->output, &develop_options, &result, err))
        return false;
    if (options->json) {
        struct json json;
        develop_json(&develop_options, &result, options->output, &json);
        if (!json_write(&json, options->json, &options->outputs, err))
            return false;
    }
    if (options->quiet)
        return true;
    struct printed printed = {.text = NULL};
    develop_print(&develop_options, &result, &printed);
    print(&printed, "picture           %s\n", options->output);
    return printed_show(&printed, options_table(options, options->output), err);
}
