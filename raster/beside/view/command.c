/* SPDX-License-Identifier: MIT */
/* spectral view: writes an interactive viewer in one HTML file, or the picture that it shows first.
 */
#include <inttypes.h>

#include "raster/beside/view/inside.h"

/* Kinds of outputs, by the endings of their names: a page; the picture that it shows first; the
 * data of a page alone, in two files. */
enum output_kind { HTML_PAGE, HTM_PAGE, PICTURE, PLANES, DESCRIPTION };
static const char *const endings[] = {".html", ".htm", ".png", ".planes", ".json", NULL},
                         *const endings_shown[] = {".html", ".htm", ".png", NULL}; /* to users */

/* ---- scenes ---- */

static bool is_still(const struct options *options)
{
    const struct view_options *own = options->own;
    return own->still || !has_live_pages();
}

static bool write_scene_page(struct viewing *view, struct error *err)
{
    return (is_still(view->options) ? viewer_write : live_write)(view, err);
}

static bool (*const writers[])(struct viewing *view, struct error *err) = {
    write_scene_page, write_scene_page, still_write, weights_write, description_write};

/* The facts of what a command has written, as JSON and in words. */
struct telling {
    struct json json;
    struct printed words;
};

static void tell_page(const struct options *options, size_t bytes, struct telling *to)
{
    json_count(&to->json, "bytes", bytes);
    print(&to->words, "page              %s, %.2f MB\n", options->output, (double)bytes / 1e6);
}

static void tell_scene(const struct viewing *view, enum output_kind kind, struct telling *to)
{
    const struct view_options *own = view->options->own;
    const struct plan *plan = view->plan;
    const uint64_t n_pixels = (uint64_t)plan->scene->width * (uint64_t)plan->scene->height;
    json_string(&to->json, "scene", options_scene(view->options));
    json_count(&to->json, "objects", (uint64_t)plan->n_instances);
    json_count(&to->json, "lights", (uint64_t)plan->n_lights);
    print(&to->words, "objects           %d\nlights            %d\n", plan->n_instances,
          plan->n_lights);
    if (kind == PICTURE) {
        json_number(&to->json, "exposure", view->exposure);
        json_count(&to->json, "out_of_gamut_pixels", view->out_of_gamut);
        print(&to->words,
              "exposure          %.10g%s\n"
              "out of gamut      %" PRIu64 " of %" PRIu64 " pixels (%.3f %%)\n"
              "picture           %s\n",
              view->exposure, exposure_factor(view->options, "auto") > 0 ? "" : " (auto)",
              view->out_of_gamut, n_pixels, 100 * (double)view->out_of_gamut / (double)n_pixels,
              view->options->output);
    } else
        tell_page(view->options, view->bytes, to);
    if (kind != PICTURE && is_still(view->options) && !own->still)
        print_text(&to->words,
                   "kind              still: lights and eye can be changed; ./build.sh live "
                   "makes a program whose pages can change all of the scene\n");
    notes_put(view->notes, &to->json);
    if (view->notes->shading)
        shading_judge->print(view->notes->shading, &to->words);
    notes_print(view->notes, &to->words);
}

/* Refuses pictures and scenes that are too large for a page. */
static bool page_allows(const struct plan *plan, struct error *err)
{
    if (plan->n_instances > MOST_PAGE_OBJECTS)
        return error_usage(err, "a page shows at most %d objects and parts; this scene has %d",
                           MOST_PAGE_OBJECTS, plan->n_instances);
    if ((int64_t)plan->view.width * plan->view.height > LARGEST_PAGE)
        return error_usage(err, "a page shows at most %d %s, not %d x %d; use --size WxH",
                           LARGEST_PAGE, plan->scene->positions > 1 ? "positions" : "pixels",
                           plan->view.width, plan->view.height);
    return true;
}

/* Lights the scene for all kinds but a description, and makes the notes on it. A live page, which
 * asks for planes, has the notes already. */
static bool light_scene(struct viewing *view, enum output_kind kind, struct error *err)
{
    return kind == DESCRIPTION ||
           ((kind == PICTURE || page_allows(view->plan, err)) &&
            lit_make(view->plan, driver_of(NULL), &view->lit, err) &&
            (kind == PLANES || notes_make(&view->lit, SOME_PIXELS, view->notes, err)));
}

static bool view_scene(struct options *options, enum output_kind kind, struct telling *to,
                       struct error *err)
{
    struct render_job job = {.options = {.store_raster = true,
                                         .bits = 32, /* samples are radiances */
                                         .exchangeable = kind != PICTURE,
                                         .threads = options->threads}};
    struct viewing view = {.options = options, .plan = &job.plan, .notes = &job.notes};
    const bool done = scene_read_options(options, &job.scene, err) &&
                      job_plan(options, &job, err) && light_scene(&view, kind, err) &&
                      writers[kind](&view, err);
    if (done)
        tell_scene(&view, kind, to);
    lit_free(&view.lit);
    job_free(&job);
    return done;
}

/* ---- stacks ---- */

/* Refuses what only a scene can be asked for. */
static bool refuse_for_stack(const struct options *options, enum output_kind kind,
                             struct error *err)
{
    const struct view_options *own = options->own;
    if (!stack_refuses_changes(options, err))
        return false;
    if (own->still)
        return error_usage(err, "--still is for scenes; %s is a stack", options->operand);
    if (kind == PICTURE || kind == DESCRIPTION)
        return error_usage(err,
                           "%s: view writes pages of stacks; expected .html (develop writes "
                           "pictures)",
                           options->output);
    return true;
}

static void tell_stack(const struct options *options, const struct stack_page *page,
                       struct telling *to)
{
    const struct image *image = &page->rows.cube.image;
    json_string(&to->json, "stack", options->operand);
    json_count(&to->json, "width", (uint64_t)image->width);
    json_count(&to->json, "height", (uint64_t)image->height);
    json_count(&to->json, "bands", (uint64_t)image->n_pages);
    json_count(&to->json, "factor", (uint64_t)page->factor);
    print(&to->words, "stack             %d x %d pixels, %d bands\n", image->width, image->height,
          image->n_pages);
    if (page->factor > 1)
        print(&to->words,
              "reduced           means of %d x %d pixels, to keep to %g MB (--budget)%s\n",
              page->factor, page->factor, page->budget_bytes / 1e6,
              has_live_pages() ? "; drop the stack onto the page to see all of it" : "");
    tell_page(options, page->bytes, to);
}

/* Writes the page of a stack, or its data alone. */
static bool view_stack(struct options *options, enum output_kind kind, struct telling *to,
                       struct error *err)
{
    const struct view_options *own = options->own;
    const double usual_mb = 40;
    struct stack_page page = {.options = options,
                              .budget_bytes = 1e6 * (own->budget > 0 ? own->budget : usual_mb)};
    const bool done = refuse_for_stack(options, kind, err) &&
                      stack_page_write(&page, options, kind == PLANES, err);
    if (done)
        tell_stack(options, &page, to);
    stack_page_free(&page);
    return done;
}

/* ---- the command ---- */

/* For a live page the scene is read under its marked name. */
static bool view_marked(struct options *options, enum output_kind kind, struct telling *to,
                        struct error *err)
{
    const char *operand = options->operand;
    const bool marks = operand && !is_still(options);
    char *marked = marks ? marked_name(operand, err) : NULL;
    options->operand = marks ? marked : operand;
    const bool done = (!marks || marked) && view_scene(options, kind, to, err);
    options->operand = operand;
    free(marked);
    return done;
}

static bool run_view(struct options *options, struct error *err)
{
    const struct view_options *own = options->own;
    const char *operand = options->operand;
    const char *subject = own->gallery ? "gallery" : options_scene(options);
    struct telling to = {.words = {.text = NULL}};
    struct error unknown = {.status = EXIT_AGREED};
    bool is_stack = false;
    int ending;
    if (!options_name_output(options, subject, ".html", err))
        return false;
    if (!path_ending(options->output, endings, &ending, &unknown))
        return path_ending(options->output, endings_shown, &ending, err);
    const enum output_kind kind = ending < 0 ? HTML_PAGE : (enum output_kind)ending;
    if (own->gallery && (operand || own->still))
        return error_usage(err, "--gallery is a live page of all built-in scenes; it takes no %s",
                           operand ? "SCENE" : "--still");
    if (own->gallery && !has_live_pages())
        return error_usage(err, "--gallery is a live page, and this program writes still ones; "
                                "./build.sh live makes one that writes both");
    if (operand && !output_is_standard(operand) && !image_is(operand, &is_stack, err))
        return false;
    if (own->budget > 0 && !is_stack)
        return error_usage(err, "--budget is for pages of stacks; %s is a scene",
                           options_scene(options));
    json_begin(&to.json);
    bool done = (is_stack ? view_stack : view_marked)(options, kind, &to, err);
    json_string(&to.json, "output", options->output);
    if (done && options->json)
        done = json_write(&to.json, options->json, &options->outputs, err);
    if (done && !options->quiet && kind < PLANES)
        done = printed_show(&to.words, options_table(options, options->output), err);
    FREE_ALL(to.json.printed.text, to.words.text);
    return done;
}

static const struct option view_rows[] = {
    {"-o, --output PAGE.html",
     "writes there, HTML or .png; - is standard output (default: SCENE's name + .html)",
     SHARED(TEXT, output), .writes = true},
    {"--still", "the page draws one geometry, and cannot be edited",
     OWN(FLAG, view_options, still)},
    {"--gallery", "a live page of all built-in scenes", OWN(FLAG, view_options, gallery)},
    {"--detector, --observer NAME", "sees with it, a built-in one or a file (default: cie1931)",
     SHARED(TEXT, detector), .recorded = true},
    {"--display srgb|monitor|FILE", "shows on it: see spectral develop (default: srgb)",
     SHARED(TEXT, display), .recorded = true},
    {"--budget MB", "samples in the page of a stack, at most (default: 40)",
     OWN(NUMBER, view_options, budget), .lowest = 1, .highest = 1e6},
};
const struct command view_command = {
    .name = "view",
    .operands = "[SCENE|STACK] [-o PAGE.html]",
    .summary = "write an interactive viewer in one HTML file, or a PNG",
    .example = "view fluorescence",
    .first = "writes a page for the browser",
    .run = run_view,
    .rows = OPTION_LIST(view_rows),
    .shared = {&exposure_option, &scene_options, &shading_options, &accuracy_options,
               &threads_option, &json_option, &quiet_option},
    .own_size = sizeof(struct view_options),
    .n_operands = 1,
};
