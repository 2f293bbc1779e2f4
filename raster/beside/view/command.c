/* SPDX-License-Identifier: MIT */
/* spectral view: writes an interactive viewer in one HTML file, or the picture that it shows first.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "data/images/images.h"
#include "raster/beside/view/inside.h"

/* A page; the picture that it shows first; the data of a page alone, in two files. */
enum { PAGE_KIND, PICTURE_KIND, PLANES_KIND, DESCRIPTION_KIND };

/* The figures and notes of a page, or of a picture. */
struct view_report {
    const struct plan *plan;
    struct viewer_result page;
    uint64_t out_of_gamut; /* pixels of a picture */
    struct notes notes;
    struct printed table;
};

static bool is_still(const struct options *options)
{
    const struct view_options *own = options->own;
    return own->still || !has_live_pages();
}

static bool write_output(struct options *options, int kind, struct view_report *report,
                         struct error *err)
{
    const struct plan *plan = report->plan;
    const char *path = options->output;
    struct outputs *outputs = &options->outputs;
    switch (kind) {
    case PICTURE_KIND:
        return still_write(plan, path, &report->out_of_gamut, &report->notes, outputs, err);
    case PLANES_KIND:
        return weights_write(plan, path, outputs, err);
    case DESCRIPTION_KIND:
        return description_write(plan, path, outputs, err);
    default:
        return is_still(options)
                   ? viewer_write(plan, path, &report->page, &report->notes, outputs, err)
                   : live_write(plan, options, &report->page, &report->notes, err);
    }
}

static void print_report(const struct options *options, int kind, struct view_report *report)
{
    const struct view_options *own = options->own;
    const struct plan *plan = report->plan;
    const uint64_t n_pixels = (uint64_t)plan->scene->width * (uint64_t)plan->scene->height;
    struct printed *to = &report->table;
    print(to, "objects           %d\nlights            %d\n", plan->n_instances, plan->n_lights);
    if (kind == PICTURE_KIND)
        print(to,
              "out of gamut      %" PRIu64 " of %" PRIu64 " pixels (%.3f %%)\n"
              "picture           %s\n",
              report->out_of_gamut, n_pixels, 100 * (double)report->out_of_gamut / (double)n_pixels,
              options->output);
    else
        print(to, "page              %s, %.2f MB\n", options->output,
              (double)report->page.bytes / 1e6);
    if (kind == PAGE_KIND && is_still(options) && !own->still)
        print_text(to, "kind              still: lights and eye can be changed; ./build.sh live "
                       "makes a program whose pages can change all of the scene\n");
    notes_print_shading(&report->notes, to);
    notes_print(&report->notes, to);
}

static bool write_json(struct options *options, const struct view_report *report, int kind,
                       struct error *err)
{
    const struct viewer_result *page = &report->page;
    struct json json;
    json_begin(&json);
    json_string(&json, "scene", options_scene(options));
    json_count(&json, "objects", (uint64_t)report->plan->n_instances);
    json_count(&json, "lights", (uint64_t)report->plan->n_lights);
    if (kind == PICTURE_KIND)
        json_count(&json, "out_of_gamut_pixels", report->out_of_gamut);
    else
        json_count(&json, "bytes", page->bytes);
    if (page->n_illuminants > 0) { /* a live page finds them later */
        json_count(&json, "illuminants", (uint64_t)page->n_illuminants);
        json_count(&json, "detectors", (uint64_t)page->n_detectors);
    }
    notes_put(&report->notes, &json);
    json_string(&json, "output", options->output);
    return json_write(&json, options->json, &options->outputs, err);
}

/* Reads the scene, and makes all outputs but the table. */
static bool view_scene(struct options *options, int kind, struct scene *scene, struct plan *plan,
                       struct view_report *report, struct error *err)
{
    const struct plan_options plan_options = {
        .store_raster = true, .exchangeable = kind != PICTURE_KIND, .threads = options->threads};
    return scene_read_options(options, scene, err) && output_can_open(options->json, err) &&
           plan_make(scene, NULL, &plan_options, plan, err) &&
           notes_refine(options, plan, &report->notes, err) &&
           write_output(options, kind, report, err) &&
           (!options->json || write_json(options, report, kind, err));
}

static bool view(struct options *options, int kind, struct error *err)
{
    struct scene scene = {.path = NULL};
    struct plan plan = {.scene = NULL};
    struct view_report report = {.plan = &plan};
    bool done = view_scene(options, kind, &scene, &plan, &report, err);
    if (done && !options->quiet && kind < PLANES_KIND)
        print_report(options, kind, &report);
    done = printed_show(&report.table, options_table(options, options->output), err) && done;
    notes_free(&report.notes);
    plan_free(&plan);
    scene_free(&scene);
    return done;
}

/* ---- stacks ---- */

/* Refuses what only a scene can be asked for. */
static bool refuse_for_stack(const struct options *options, int kind, struct error *err)
{
    const struct view_options *own = options->own;
    const char *stack = options->operand;
    if (options->n_recorded > 0)
        return error_usage(err, "%s is for scenes; the stack %s is rendered already",
                           options->recorded[0], stack);
    if (own->still)
        return error_usage(err, "--still is for scenes; %s is a stack", stack);
    if (kind == PICTURE_KIND || kind == DESCRIPTION_KIND)
        return error_usage(err,
                           "%s: view writes pages of stacks; expected .html (develop writes "
                           "pictures)",
                           options->output);
    return true;
}

static void print_stack(const struct options *options, const struct stack_result *result,
                        double budget_mb, struct printed *to)
{
    print(to, "stack             %d x %d pixels, %d bands\n", result->width, result->height,
          result->n_bands);
    if (result->factor > 1)
        print(to, "reduced           means of %d x %d pixels, to keep to %g MB (--budget)%s\n",
              result->factor, result->factor, budget_mb,
              has_live_pages() ? "; drop the stack onto the page to see all of it" : "");
    print(to, "page              %s, %.2f MB\n", options->output, (double)result->bytes / 1e6);
}

static bool write_stack_json(struct options *options, const struct stack_result *result,
                             struct error *err)
{
    struct json json;
    json_begin(&json);
    json_string(&json, "stack", options->operand);
    json_count(&json, "width", (uint64_t)result->width);
    json_count(&json, "height", (uint64_t)result->height);
    json_count(&json, "bands", (uint64_t)result->n_bands);
    json_count(&json, "factor", (uint64_t)result->factor);
    json_count(&json, "bytes", result->bytes);
    json_string(&json, "output", options->output);
    return json_write(&json, options->json, &options->outputs, err);
}

/* Writes the page of a stack, or its data alone. */
static bool view_stack(struct options *options, bool alone, struct error *err)
{
    const struct view_options *own = options->own;
    const double usual_mb = 40;
    double budget_mb = usual_mb;
    struct stack_result result;
    struct printed table = {.text = NULL};
    if (own->budget && !option_number("--budget", own->budget, 1, 1e6, &budget_mb, err))
        return false;
    const struct stack_page_options page = {1e6 * budget_mb, alone};
    const bool done = output_can_open(options->json, err) &&
                      stack_page_write(options->operand, options->output, &page, &result,
                                       &options->outputs, err) &&
                      (!options->json || write_stack_json(options, &result, err));
    if (done && !options->quiet && !alone)
        print_stack(options, &result, budget_mb, &table);
    return printed_show(&table, options_table(options, options->output), err) && done;
}

/* ---- the command ---- */

static bool run_view(struct options *options, struct error *err)
{
    const struct view_options *own = options->own;
    static const char *const endings[] = {".html", ".htm", ".png", ".planes", ".json", NULL};
    static const int kinds[] = {PAGE_KIND, PAGE_KIND, PICTURE_KIND, PLANES_KIND, DESCRIPTION_KIND};
    int ending;
    const char *subject = own->gallery ? "gallery" : options_scene(options);
    if (!options_name_output(options, subject, ".html", err) ||
        !output_ending(options->output, endings, &ending, err))
        return false;
    if (ending < 0) /* none, or standard output: the first kind */
        ending = 0;
    const char *operand = options->operand;
    if (own->gallery && (operand || own->still))
        return error_usage(err, "--gallery is a live page of all built-in scenes; it takes no %s",
                           operand ? "SCENE" : "--still");
    if (own->gallery && !has_live_pages())
        return error_usage(err, "--gallery is a live page, and this program writes still ones; "
                                "./build.sh live makes one that writes both");
    bool is_stack = false;
    if (operand && !output_is_standard(operand) && !image_is(operand, &is_stack, err))
        return false;
    if (is_stack)
        return refuse_for_stack(options, kinds[ending], err) &&
               view_stack(options, kinds[ending] == PLANES_KIND, err);
    if (own->budget)
        return error_usage(err, "--budget is for pages of stacks; %s is a scene",
                           options_scene(options));
    char *marked = operand ? marked_name(operand) : NULL;
    if (operand && !marked)
        return memory_lacks(err, (double)strlen(operand), "the name of the scene");
    options->operand = marked;
    const bool done = view(options, kinds[ending], err);
    options->operand = operand;
    free(marked);
    return done;
}

static const struct option view_rows[] = {
    {"-o, --output PAGE.html",
     "writes there, HTML or .png; - is standard output (default: SCENE's name + .html)",
     SHARED(TEXT, output), .writes = true},
    {"--still", "the page draws one geometry, and cannot be edited",
     OWN(FLAG, view_options, still)},
    {"--gallery", "a live page of all built-in scenes", OWN(FLAG, view_options, gallery)},
    {"--budget MB", "samples in the page of a stack, at most (default: 40)",
     OWN(TEXT, view_options, budget)},
};
static const struct option_list view_list = OPTION_LIST(view_rows);
static const struct option_list *const lists[] = {
    &view_list,   &scene_options, &shading_options, &accuracy_options, &threads_option,
    &json_option, &quiet_option,  &common_options,  NULL};
const struct command view_command = {
    .name = "view",
    .operands = "[SCENE|STACK] [-o PAGE.html]",
    .summary = "write an interactive viewer in one HTML file, or a PNG",
    .example = "view fluorescence --size 600x400 -o fluorescence.html",
    .run = run_view,
    .lists = lists,
    .own_size = sizeof(struct view_options),
    .n_operands = 1,
};
