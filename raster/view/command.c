/* SPDX-License-Identifier: MIT */
/* spectral view: writes an interactive viewer in one HTML file. */
#include <stdio.h>

#include "data/base/base.h"
#include "data/invocation/invocation.h"
#include "data/scene/scene.h"
#include "raster/view/view.h"

static void print_page(const struct viewer_result *result, const char *output)
{
    fprintf(file_is_regular(output) ? stdout : stderr,
            "objects           %d\nlights            %d, %d illuminants to choose from\n"
            "detectors         %d\npage              %s, %.2f MB\n",
            result->n_objects, result->n_lights, result->n_illuminants, result->n_detectors, output,
            (double)result->bytes / 1e6);
}

bool command_view(struct options *options, struct error *err)
{
    const struct plan_options plan_options = {
        .store_raster = true, .exchangeable = true, .threads = options->threads};
    struct scene scene = {.path = NULL};
    struct plan plan = {.scene = NULL};
    struct viewer_result result;
    bool done = options_name_output(options, options_scene(options), ".html", err) &&
                scene_read_options(options, &scene, err) &&
                scene_spared(options->output, &scene, err) &&
                plan_make(&scene, NULL, &plan_options, &plan, err) &&
                viewer_write(&plan, options->output, &result, err);
    if (done && !options->quiet)
        print_page(&result, options->output);
    plan_free(&plan);
    scene_free(&scene);
    return done;
}
