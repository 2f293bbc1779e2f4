/* SPDX-License-Identifier: MIT */
/* spectral render --update: finds whether a stack is what its scene and options ask for, by the
 * record in the stack. */
#include <stdlib.h>
#include <string.h>

#include "data/invocation/invocation.h"
#include "raster/render/render.h"

/* Stacks of such verdicts are stored without --keep. A stack that was not checked records so by its
 * option. */
static bool is_good(const char *verdict)
{
    static const char *const good[] = {"agreed", "not checked", "pixels of the reference"};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++)
        if (strncmp(verdict, good[i], strlen(good[i])) == 0)
            return true;
    return false;
}

static bool same_options(const struct options *options, const struct record *made)
{
    if (options->n_recorded != made->n_options)
        return false;
    for (int i = 0; i < made->n_options; i++)
        if (strcmp(options->recorded[i], made->options[i]) != 0)
            return false;
    return true;
}

/* Compares the scene and the files that it names with those of the record. */
static bool same_scene(const struct options *options, const struct record *made, bool *same,
                       struct error *err)
{
    struct scene scene = {.path = NULL};
    char change[FILE_CHANGE] = "";
    bool done = scene_read_options(options, &scene, err);
    *same = done && strcmp(scene.sha256, made->scene_sha256) == 0;
    done = done && (!*same || record_find_change(made, &scene, options->detector, change, err));
    *same = *same && change[0] == '\0';
    scene_free(&scene);
    return done;
}

/* Returns whether all files are there that the command line names beside the stack. */
static bool has_others(const struct options *options)
{
    char *header = options->envi ? sidecar_name(options->output) : NULL;
    const bool has = (!options->envi || (header && !file_is_missing(header))) &&
                     (!options->json || !file_is_missing(options->json)) &&
                     (!options->check_map || !file_is_missing(options->check_map));
    free(header);
    return has;
}

bool render_is_current(const struct options *options, bool *out, struct error *err)
{
    struct image image = {.path = NULL};
    struct record made = {.text = NULL};
    struct error unreadable = {.status = EXIT_AGREED};
    bool done = true;
    *out = false;
    if (options->part || output_is_stream(options->output) || file_is_missing(options->output) ||
        !has_others(options))
        return true;
    if (record_open(options->output, &image, &made, &unreadable) && is_good(image.verdict) &&
        strcmp(made.program, PROGRAM) == 0 && strcmp(made.scene, options_scene(options)) == 0 &&
        same_options(options, &made))
        done = same_scene(options, &made, out, err);
    record_free(&made);
    image_close(&image);
    return done;
}
