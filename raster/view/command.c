/* SPDX-License-Identifier: MIT */
/* spectral view: writes an interactive viewer in one HTML file, or the picture that it shows first.
 */
#include <inttypes.h>
#include <stdio.h>

#include "data/base/base.h"
#include "data/invocation/invocation.h"
#include "data/scene/scene.h"
#include "raster/view/view.h"

/* The table goes to standard output, unless the output may be there. */
static FILE *table_stream(const char *output)
{
    return file_is_regular(output) ? stdout : stderr;
}

static bool write_page(const struct options *options, const struct plan *plan, struct notes *notes,
                       struct error *err)
{
    struct viewer_result result;
    if (!viewer_write(plan, options->output, &result, notes, err))
        return false;
    if (!options->quiet)
        fprintf(table_stream(options->output),
                "objects           %d\nlights            %d, %d illuminants to choose from\n"
                "detectors         %d\npage              %s, %.2f MB\n",
                result.n_objects, result.n_lights, result.n_illuminants, result.n_detectors,
                options->output, (double)result.bytes / 1e6);
    return true;
}

static bool write_still(const struct options *options, const struct plan *plan, struct notes *notes,
                        struct error *err)
{
    const uint64_t n_pixels = (uint64_t)plan->scene->width * (uint64_t)plan->scene->height;
    uint64_t out_of_gamut;
    if (!still_write(plan, options->output, &out_of_gamut, notes, err))
        return false;
    if (!options->quiet)
        fprintf(table_stream(options->output),
                "objects           %d\nlights            %d\n"
                "out of gamut      %" PRIu64 " of %" PRIu64 " pixels (%.3f %%)\n"
                "picture           %s\n",
                plan->n_instances, plan->n_lights, out_of_gamut, n_pixels,
                100 * (double)out_of_gamut / (double)n_pixels, options->output);
    return true;
}

bool command_view(struct options *options, struct error *err)
{
    enum { HTML, HTM, PNG };
    static const char *const endings[] = {[HTML] = ".html", [HTM] = ".htm", [PNG] = ".png", NULL};
    struct scene scene = {.path = NULL};
    struct plan plan = {.scene = NULL};
    int ending;
    if (!options_name_output(options, options_scene(options), ".html", err) ||
        !output_ending(options->output, endings, &ending, err))
        return false;
    const bool still = ending == PNG;
    const struct plan_options plan_options = {
        .store_raster = true, .exchangeable = !still, .threads = options->threads};
    struct notes notes = {.list = NULL};
    const bool done = scene_read_options(options, &scene, err) &&
                      scene_spared(options->output, &scene, err) &&
                      plan_make(&scene, NULL, &plan_options, &plan, err) &&
                      (still ? write_still : write_page)(options, &plan, &notes, err);
    if (done && !options->quiet)
        notes_print(&notes, table_stream(options->output));
    notes_free(&notes);
    plan_free(&plan);
    scene_free(&scene);
    return done;
}
