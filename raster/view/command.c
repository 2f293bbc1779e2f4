/* SPDX-License-Identifier: MIT */
/* spectral view: writes an interactive viewer in one HTML file, or the picture that it shows first.
 */
#include <inttypes.h>
#include <stdio.h>

#include "data/base/base.h"
#include "data/invocation/invocation.h"
#include "data/scene/scene.h"
#include "raster/view/view.h"

/* The figures and notes of a page, or of a picture. */
struct view_report {
    struct viewer_result page;
    uint64_t out_of_gamut; /* pixels of a picture */
    struct notes notes;
    struct printed table;
};

static bool write_page(struct options *options, const struct plan *plan, struct view_report *out,
                       struct error *err)
{
    const struct viewer_result *page = &out->page;
    if (!viewer_write(plan, options->output, &out->page, &out->notes, &options->outputs, err))
        return false;
    if (!options->quiet)
        print(&out->table,
              "objects           %d\nlights            %d, %d illuminants to choose from\n"
              "detectors         %d\npage              %s, %.2f MB\n",
              page->n_objects, page->n_lights, page->n_illuminants, page->n_detectors,
              options->output, (double)page->bytes / 1e6);
    return true;
}

static bool write_still(struct options *options, const struct plan *plan, struct view_report *out,
                        struct error *err)
{
    const uint64_t n_pixels = (uint64_t)plan->scene->width * (uint64_t)plan->scene->height;
    out->page = (struct viewer_result){.n_objects = plan->n_instances, .n_lights = plan->n_lights};
    if (!still_write(plan, options->output, &out->out_of_gamut, &out->notes, &options->outputs,
                     err))
        return false;
    if (!options->quiet)
        print(&out->table,
              "objects           %d\nlights            %d\n"
              "out of gamut      %" PRIu64 " of %" PRIu64 " pixels (%.3f %%)\n"
              "picture           %s\n",
              plan->n_instances, plan->n_lights, out->out_of_gamut, n_pixels,
              100 * (double)out->out_of_gamut / (double)n_pixels, options->output);
    return true;
}

static bool write_json(struct options *options, const struct view_report *report, bool still,
                       struct error *err)
{
    struct json json;
    json_begin(&json);
    json_open(&json, NULL, '{');
    json_string(&json, "scene", options_scene(options));
    json_count(&json, "objects", (uint64_t)report->page.n_objects);
    json_count(&json, "lights", (uint64_t)report->page.n_lights);
    if (still) {
        json_count(&json, "out_of_gamut_pixels", report->out_of_gamut);
    } else {
        json_count(&json, "illuminants", (uint64_t)report->page.n_illuminants);
        json_count(&json, "detectors", (uint64_t)report->page.n_detectors);
        json_count(&json, "bytes", report->page.bytes);
    }
    notes_json(&report->notes, &json);
    json_string(&json, "output", options->output);
    json_close(&json, '}');
    return json_write(&json, options->json, &options->outputs, err);
}

bool command_view(struct options *options, struct error *err)
{
    enum { HTML, HTM, PNG };
    static const char *const endings[] = {[HTML] = ".html", [HTM] = ".htm", [PNG] = ".png", NULL};
    struct scene scene = {.path = NULL};
    struct plan plan = {.scene = NULL};
    struct refine_result refined = {.levels = 0};
    int ending;
    if (!options_name_output(options, options_scene(options), ".html", err) ||
        !output_ending(options->output, endings, &ending, err))
        return false;
    const bool still = ending == PNG;
    const struct plan_options plan_options = {
        .store_raster = true, .exchangeable = !still, .threads = options->threads};
    struct view_report report = {.notes.refined = options->accuracy ? &refined : NULL};
    bool done = scene_read_options(options, &scene, err) &&
                scene_spared(options->output, &scene, err) &&
                scene_spared(options->json, &scene, err) && output_can_open(options->json, err) &&
                plan_make(&scene, NULL, &plan_options, &plan, err) &&
                refine_options(options, &plan, &refined, err) &&
                (still ? write_still : write_page)(options, &plan, &report, err) &&
                (!options->json || write_json(options, &report, still, err));
    if (done && !options->quiet)
        notes_print(&report.notes, &report.table);
    done = printed_show(&report.table, options_table(options, options->output), err) && done;
    notes_free(&report.notes);
    refine_result_free(&refined);
    plan_free(&plan);
    scene_free(&scene);
    return done;
}
