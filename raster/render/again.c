/* SPDX-License-Identifier: MIT */
/* spectral render --again: makes a stack again from its own record. The new stack must be the same,
 * byte for byte. */
#include <string.h>

#include "data/scene/scene.h"
#include "data/tiff/tiff.h"
#include "raster/render/render.h"

/* Takes from the record all options that decide the picture, and the others from the command line.
 */
static bool recorded_options(const struct options *options, const struct record *record,
                             struct options *out, struct error *err)
{
    const struct option_rules rules = {"render", options->table, RECORDED, 1};
    if (!options_read(&rules, record->options, record->n_options, out, err))
        return false;
    if (out->operand)
        return error_usage(err, "%s records '%s', which is not an option", options->again,
                           out->operand);
    out->operand = record->scene;
    out->json = options->json;
    out->threads = options->threads;
    out->quiet = options->quiet;
    if (!out->renderer || strcmp(out->renderer, "raster") != 0)
        return !(options->no_check || options->strict || options->unchecked) ||
               error_usage(err,
                           "%s stores OpenGL's pixels and records whether to check them; "
                           "--again takes no %s",
                           options->again,
                           options->no_check ? "--no-check"
                           : options->strict ? "--strict"
                                             : "--unchecked");
    out->no_check = options->no_check;
    out->strict = options->strict;
    out->unchecked = options->unchecked;
    out->check_map = options->check_map;
    return true;
}

/* Refuses a stack that cannot be the same, before anything is drawn. */
static bool can_be_same(const struct record *record, const struct render_output *output,
                        struct error *err)
{
    if (scene_is_input(record->scene))
        return error_usage(err,
                           "%s: its scene was read from standard input, and is not in the stack; "
                           "store the scene in a file, and render that",
                           output->again);
    if (strcmp(record->program, PROGRAM) != 0 && !output->keep)
        return error_different(err,
                               "%s was made by %.80s, but this is " PROGRAM
                               ", and each stack records its program; --keep stores the new "
                               "stack anyway",
                               output->again, record->program);
    return !scene_is_missing(record->scene) ||
           error_usage(err,
                       "%s: its scene '%.500s' does not exist; a relative name starts from the "
                       "folder where the stack was made",
                       output->again, record->scene);
}

static bool render_recorded(const struct options *options, const struct render_output *output,
                            struct error *err)
{
    struct image image = {.path = NULL};
    struct record record = {.text = NULL};
    struct options made = {.operand = NULL};
    bool done = record_open(options->again, &image, &record, err) &&
                recorded_options(options, &record, &made, err) &&
                can_be_same(&record, output, err) &&
                render_with_options(&made, output, &record, err);
    options_free(&made);
    record_free(&record);
    image_close(&image);
    return done;
}

bool render_again(struct options *options, struct error *err)
{
    options_forget_check(options);
    if (options->operand || options->n_recorded > 0)
        return error_usage(err, "--again takes no %s: the stack records it",
                           options->operand ? "SCENE" : options->recorded[0]);
    /* With -o /dev/null the stack is written under its default name, compared, and then discarded.
     */
    const bool discard = options->output && strcmp(options->output, "/dev/null") == 0;
    if (discard)
        options->output = NULL;
    if (!options_name_output(options, options->again, "-again.tif", err))
        return false;
    const struct render_output output = {.path = options->output,
                                         .check_map = options->check_map,
                                         .again = options->again,
                                         .keep = options->keep,
                                         .discard = discard,
                                         .envi = options->envi,
                                         .outputs = &options->outputs};
    return render_recorded(options, &output, err);
}
