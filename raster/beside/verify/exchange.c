/* SPDX-License-Identifier: MIT */
/* spectral export and spectral judge. Both plan the scene as spectral render does. */
#include "raster/beside/verify/inside.h"

/* ---- export ---- */

static bool run_export(struct options *options, struct error *err)
{
    if (!options->output)
        return error_usage(err, "export needs -o FOLDER");
    const struct render_foreign foreign = {.take_plan = export_plan, .of = options};
    return render_with_options(options, &(struct render_output){.foreign = &foreign}, NULL, err);
}

/* ---- judge ---- */

struct judge_options {
    struct render_options render; /* the first member */
    const char *driver;
};

static bool run_judge(struct options *options, struct error *err)
{
    const struct judge_options *own = options->own;
    struct drawn_names names = {.driver = own->driver};
    if (options->n_operands < 2)
        return error_usage(err, "judge needs SCENE and PIXELS: a folder, or a TIFF");
    names.pixels = options->operands[1];
    const struct render_foreign foreign = {.open = drawn_open, .of = &names};
    const struct render_output output = {
        .check_map = own->render.check_map, .outputs = &options->outputs, .foreign = &foreign};
    return render_with_options(options, &output, NULL, err);
}

/* ---- the commands ---- */

static const struct option export_rows[] = {
    {"-o, --output FOLDER", "writes the files into this new folder", SHARED(TEXT, output)},
};
static const struct option_list export_list = OPTION_LIST(export_rows);
static const struct option_list *const export_lists[] = {
    &export_list,  &scene_options,  &shading_options, &accuracy_options, &sampling_options,
    &scale_option, &threads_option, &json_option,     &common_options,   NULL};
const struct command export_command = {
    .name = "export",
    .operands = "[SCENE] -o FOLDER",
    .summary = "write a scene as plain files, for another program to draw",
    .example = "export room -o room",
    .run = run_export,
    .lists = export_lists,
    .own_size = sizeof(struct render_options),
    .n_operands = 1,
};

static const char *const drivers[] = {"llvmpipe", "softpipe", "unknown", NULL};
static const struct option judge_rows[] = {
    {"--driver llvmpipe|softpipe|unknown",
     "judges by the bounds of this driver (default: that of the renderer that drawn.txt names)",
     OWN(TEXT, judge_options, driver), .choices = drivers},
};
static const struct option_list judge_list = OPTION_LIST(judge_rows);
static const struct option_list *const judge_lists[] = {&judge_list,       &scene_options,
                                                        &shading_options,  &accuracy_options,
                                                        &sampling_options, &judged_options,
                                                        &map_option,       &scale_option,
                                                        &threads_option,   &json_option,
                                                        &verbose_option,   &quiet_option,
                                                        &common_options,   NULL};
const struct command judge_command = {
    .name = "judge",
    .operands = "SCENE PIXELS",
    .summary = "judge what that program drew: a folder, or a TIFF",
    .example = "judge room drawn",
    .run = run_judge,
    .lists = judge_lists,
    .own_size = sizeof(struct judge_options),
    .n_operands = 2,
};
