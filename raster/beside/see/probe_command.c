/* SPDX-License-Identifier: MIT */
/* spectral probe: prints the spectrum of a pixel or a region, of a stack or of a scene. The command
 * lies in raster/ because the reference draws the scene. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "data/images/images.h"
#include "data/scene/scene.h"
#include "raster/beside/accuracy/accuracy.h"
#include "raster/beside/see/inside.h"

struct probe_own {
    bool csv, svg;
};

/* ---- operands ---- */

static bool region_read(const struct options *options, struct probe *out, struct error *err)
{
    static const char *const names[] = {"X", "Y", "W", "H"};
    int *numbers[] = {&out->x, &out->y, &out->width, &out->height};
    if (options->n_operands != 3 && options->n_operands != 5)
        return error_usage(err,
                           "probe takes a STACK or SCENE, X and Y, and optionally W and H; see "
                           "spectral probe --help");
    for (int i = 0; i + 1 < options->n_operands; i++)
        if (!option_count(names[i], options->operands[1 + i], i < 2 ? 0 : 1, INT32_MAX, numbers[i],
                          err))
            return false;
    return true;
}

/* ---- the command ---- */

static bool probe_picture(const struct options *options, struct probe *probe, struct error *err)
{
    const struct plan_options plan_options = {.store_raster = true, .threads = options->threads};
    struct scene scene = {.path = NULL};
    struct plan plan = {.scene = NULL};
    struct refine_result refined = {.levels = 0};
    bool done = scene_read_options(options, &scene, err) &&
                plan_make(&scene, NULL, &plan_options, &plan, err) &&
                refine_options(options, &plan, &refined, err) && probe_scene(probe, &plan, err);
    refine_result_free(&refined);
    plan_free(&plan);
    scene_free(&scene);
    return done;
}

static bool probe_operand(const struct options *options, struct probe *probe, struct error *err)
{
    bool is_stack;
    if (!image_is(options->operand, &is_stack, err))
        return false;
    if (!is_stack)
        return probe_picture(options, probe, err);
    if (options->n_recorded > 0)
        return error_usage(err, "%s is a stack; %s needs a scene", options->operand,
                           options->recorded[0]);
    return probe_stack(probe, options->operand, err);
}

static bool probe_write(struct options *options, const struct probe *probe, struct error *err)
{
    const struct probe_own *own = options->own;
    struct printed printed = {.text = NULL};
    struct json json;
    if (options->json) {
        probe_json(probe, &json);
        return json_write(&json, options->json, &options->outputs, err);
    }
    (own->svg ? probe_svg : own->csv ? probe_print_csv : probe_print)(probe, &printed);
    return printed_write(&printed, options->output ? options->output : "-", &options->outputs, err);
}

static bool run_probe(struct options *options, struct error *err)
{
    const struct probe_own *own = options->own;
    struct probe probe = {
        .width = 1, .height = 1, .observer = options_detector(options), .white = options->white};
    if (!region_read(options, &probe, err))
        return false;
    if (own->csv + own->svg + (options->json != NULL) > 1)
        return error_usage(err, "--csv, --svg and --json exclude each other; give one of them");
    bool done = probe_operand(options, &probe, err) && probe_write(options, &probe, err);
    probe_free(&probe);
    return done;
}

static const struct option probe_rows[] = {
    {"-o, --output FILE", "writes there (default: standard output)", SHARED(TEXT, output),
     .writes = true},
    {"--csv", "writes a table instead of text", OWN(FLAG, probe_own, csv)},
    {"--svg", "writes a plot instead of text", OWN(FLAG, probe_own, svg)},
};
static const struct option_list probe_list = OPTION_LIST(probe_rows);
static const struct option_list *const lists[] = {
    &probe_list,      &seeing_options,   &scene_options,
    &shading_options, &accuracy_options, &threads_option,
    &json_option,     &common_options,   NULL};
const struct command probe_command = {
    .name = "probe",
    .operands = "STACK|SCENE X Y [W H]",
    .summary = "print the spectrum of a pixel, or the mean of a region",
    .example = "probe fluorescence 700 300 --svg -o spectrum.svg",
    .run = run_probe,
    .lists = lists,
    .own_size = sizeof(struct probe_own),
    .n_operands = 5,
};
