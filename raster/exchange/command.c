/* SPDX-License-Identifier: MIT */
/* spectral export and spectral judge. Both plan the scene as spectral render does. */
#include "raster/exchange/exchange.h"
#include "raster/render/render.h"

/* ---- export ---- */

static bool take_plan(void *of, const struct plan *plan, struct error *err)
{
    const struct options *options = of;
    return export_plan(plan, options->output, err);
}

bool command_export(struct options *options, struct error *err)
{
    if (!options->output)
        return error_usage(err, "export needs -o FOLDER");
    const struct render_foreign foreign = {.take_plan = take_plan, .of = options};
    return render_with_options(options, &(struct render_output){.foreign = &foreign}, NULL, err);
}

/* ---- judge ---- */

static bool open_drawn(void *of, const struct plan *plan, int n_buffers, struct renderer **out,
                       struct error *err)
{
    return drawn_open(of, plan, n_buffers, out, err);
}

bool command_judge(struct options *options, struct error *err)
{
    struct drawn_names names = {.driver = options->driver};
    if (options->n_operands < 2)
        return error_usage(err, "judge needs SCENE and PIXELS: a folder, or a TIFF");
    names.pixels = options->operands[1];
    const struct render_foreign foreign = {.open = open_drawn, .of = &names};
    const struct render_output output = {
        .check_map = options->check_map, .outputs = &options->outputs, .foreign = &foreign};
    return render_with_options(options, &output, NULL, err);
}
