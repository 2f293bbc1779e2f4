/* SPDX-License-Identifier: MIT */
/* A plan becomes a stack: everything before the first pixel, and after the last one. */
#include "raster/render/inside.h"

const char *render_stored(const struct plan *plan, const struct render_result *result)
{
    return plan->options.store_raster ? "raster" : result->names.renderer;
}

/* ---- everything before the first pixel ---- */

/* Prepares the check of all bands together, and its map if the output has one. */
static bool open_check(struct rendering *of, struct error *err)
{
    const struct render_output *output = of->output;
    of->check_scene = (struct check_scene){
        .lit = &of->lit, .limits = output->limits, .mapped = output->check_map != NULL};
    const bool done =
        fit_make(&of->lit, &of->check_scene.fit, err) &&
        totals_open(&of->check_scene, &of->totals, err) &&
        (!output->check_map || check_map_open(output->check_map, of->plan, &of->map, err));
    clock_in(&of->since, &of->result->seconds.check);
    return done;
}

/* Opens OpenGL. A driver that is not known is measured before it draws the plan: one renderer can
 * be open at a time. */
static bool open_gl(const struct plan *plan, int n_buffers, struct renderer **out,
                    struct error *err)
{
    const struct plan_options *options = &plan->options;
    struct driver measured;
    if (!drawing_ways.open[options->gl_way](plan, n_buffers, out, err))
        return false;
    if (!options->check || driver_is_known(&(*out)->driver))
        return true;
    if (!drawing_ways.measure)
        return error_unsupported(err,
                                 "%s is not known, and this program cannot measure it; --no-check "
                                 "draws without a check",
                                 (*out)->names.renderer);
    (*out)->kind->close(*out);
    *out = NULL;
    if (!drawing_ways.measure(options, &measured, err) ||
        !drawing_ways.open[options->gl_way](plan, n_buffers, out, err))
        return false;
    (*out)->driver = measured;
    return true;
}

static bool open_renderer(struct rendering *of, struct error *err)
{
    const struct plan *plan = of->plan;
    const struct render_foreign *foreign = of->output->foreign;
    const int n_buffers = plan->options.check ? GL_BUFFERS : AHEAD_FRAMES;
    const bool done = foreign
                          ? foreign->open(foreign->of, plan, n_buffers, &of->renderer, err)
                          : !plan->options.use_gl || open_gl(plan, n_buffers, &of->renderer, err);
    of->result->driver = *driver_of(NULL);
    if (done && of->renderer) {
        of->result->names = of->renderer->names;
        of->result->driver = of->renderer->driver;
    }
    clock_in(&of->since, &of->result->seconds.gl);
    return done;
}

/* Finds what is to be drawn: the picture, or whole rows of its tiles for a part. */
static bool find_region(struct rendering *of, struct error *err)
{
    const struct plan *plan = of->plan;
    const struct picture_part *part = &of->output->part;
    const int height = plan->tile_height, last = plan->view.height,
              all = (last + height - 1) / height;
    of->region = plan_picture(plan);
    if (part->count > all)
        return error_usage(err,
                           "--part %d/%d: a part has whole rows of tiles, and this picture has %d; "
                           "expected at most %d parts",
                           part->number, part->count, all, all);
    if (part->count == 0)
        return true;
    const int end = (int)((long)all * part->number / part->count) * height;
    of->region.y = (int)((long)all * (part->number - 1) / part->count) * height;
    of->region.height = (end < last ? end : last) - of->region.y;
    const struct rectangle pixels = plan_pixels(plan, &of->region);
    of->result->rows = (struct part_rows){pixels.y, pixels.height};
    return true;
}

/* ---- the stack: its record, and whether it is stored ---- */

/* Returns the record of the stack as text, allocated; NULL on failure. Objects are recorded if
 * there is an object map. */
static char *make_provenance(const struct rendering *of, struct error *err)
{
    const struct plan *plan = of->plan;
    const struct part_rows *rows = &of->result->rows;
    const struct recorded made = {.scene = plan->scene,
                                  .sampling = plan->sampling,
                                  .renderer = render_stored(plan, of->result),
                                  .mipmaps = !plan_has_mipmaps(plan)      ? NULL
                                             : plan->options.store_raster ? "specification"
                                                                          : of->result->driver.name,
                                  .options = of->output->options};
    struct printed lines = {.text = NULL};
    record_put_scene(&lines, &made, err);
    for (int i = 0; i < plan->n_instances && plan->map_bytes > 0; i++)
        record_put(&lines, "object", object_name(plan, i));
    if (rows->count > 0)
        record_put_part(&lines, rows, plan->scene->height, plan->scene->wavelengths_nm,
                        has_components(plan) ? 0 : plan->n_bands);
    return printed_take(&lines, err);
}

static bool open_stack(struct rendering *of, struct error *err)
{
    const struct plan *plan = of->plan;
    const struct part_rows *rows = &of->result->rows;
    char *provenance = make_provenance(of, err);
    const struct stack_options options = {
        .width = plan->scene->width,
        .height = rows->count > 0 ? rows->count : plan->scene->height,
        .n_wavelengths = plan->n_bands,
        .wavelengths_nm = plan->scene->wavelengths_nm,
        .full_scale = of->lit.full_scale,
        .bits = plan->options.bits,
        .scene = plan->scene->path,
        .provenance = provenance,
        .map_bytes = plan->map_bytes,
        .unit = scene_is_absolute(plan->scene) ? ABSOLUTE_UNIT : NULL,
        .components = has_components(plan) ? &plan->sampling->method : NULL};
    const bool done = provenance && stack_open(&of->stack, of->output->path, &options, err);
    free(provenance);
    clock_in(&of->since, &of->result->seconds.write);
    return done;
}

static bool make_volumes(struct rendering *of, struct error *err)
{
    if (!of->renderer || of->plan->view.n_shadowed == 0)
        return true;
    of->lit.volumes = &of->volumes;
    return volumes_make(&of->lit, &of->volumes, err);
}

/* Does everything that comes before the first pixel. */
static bool prepare(struct rendering *of, struct error *err)
{
    struct render_result *result = of->result;
    const struct render_output *output = of->output;
    if (!open_renderer(of, err) || !lit_make(of->plan, &result->driver, &of->lit, err) ||
        !make_volumes(of, err) || !find_full_scale(&of->lit, err) ||
        (of->renderer && of->renderer->kind->take_scene &&
         !of->renderer->kind->take_scene(of->renderer, &of->lit, err)) ||
        (output->notes && !notes_make(&of->lit, SOME_PIXELS, output->notes, err)))
        return false;
    result->full_scale = of->lit.full_scale;
    result->light = of->lit.work;
    clock_in(&of->since, &result->seconds.raster);
    return find_region(of, err) && (!of->plan->options.check || open_check(of, err)) &&
           (!output->path || open_stack(of, err));
}

bool render_agreed(const struct plan *plan, const struct render_result *result)
{
    if (result->difference.found)
        return false;
    if (!plan->options.check)
        return true;
    /* The share of a picture that may stay unchecked is no limit of a part: join knows the sum. The
     * verdict on pixels of the reference has no sums. */
    const enum check_outcome outcome = check_outcome(&result->check);
    return outcome == OUTCOME_AGREED || (outcome == OUTCOME_NOT_VERIFIED &&
                                         result->rows.count > 0 && !plan->options.store_raster);
}

/* ---- everything after the last pixel ---- */

/* Completes the stack, compares it with the stack that is made again, and commits it if it agrees
 * or is kept anyway. */
static bool finish_stack(struct rendering *of, struct error *err)
{
    const struct plan *plan = of->plan;
    const struct render_output *output = of->output;
    struct render_result *result = of->result;
    const char *again = result->odd.undefined == 0 ? output->again : NULL;
    char verdict[STACK_VERDICT];
    if (!output->keep && !again && !render_agreed(plan, result))
        return true;
    if (result->odd.undefined > 0)
        return error_failed(err,
                            "%llu samples are not finite (or too large for a float page); "
                            "nothing was written",
                            (unsigned long long)result->odd.undefined);
    report_verdict(plan, &result->check, verdict);
    if (!stack_finish(&of->stack, verdict, err) ||
        (again && !stack_compare(&of->stack, again, &result->difference, err)))
        return false;
    if (output->discard || !(output->keep || render_agreed(plan, result)))
        return true;
    return output_pass(&of->stack.pages.output, output->outputs, err);
}

/* Completes all. Both files are complete before the first of them appears. */
static bool finish(struct rendering *of, struct error *err)
{
    const struct render_output *output = of->output;
    struct render_result *result = of->result;
    of->since = clock_seconds();
    if (of->renderer)
        result->gl = of->renderer->work;
    if (of->check_scene.lit) {
        totals_finish(&of->totals);
        result->check = of->totals.verdict;
        result->check.lacks = of->renderer->lacks;
    }
    if ((of->check_scene.mapped && !picture_finish(&of->map.picture, err)) ||
        (output->path && !finish_stack(of, err)))
        return false;
    clock_in(&of->since, &result->seconds.write);
    return !of->check_scene.mapped ||
           output_pass(&of->map.picture.pages.output, output->outputs, err);
}

bool render(const struct plan *plan, const struct render_output *output,
            struct progress_line *progress, struct render_result *out, struct error *err)
{
    const double start = clock_seconds();
    struct rendering of = {
        .plan = plan, .output = output, .result = out, .progress = progress, .since = start};
    *out = (struct render_result){.notes = output->notes};
    const bool done = prepare(&of, err) && stages_run(&of, err) && finish(&of, err);
    if (output->notes && plan->options.check && output->part.count == 0 && out->check.objects == 0)
        notes_of_nothing(plan, output->notes);
    stack_discard(&of.stack); /* keeps a stack that has been passed on */
    fit_free(&of.check_scene.fit);
    picture_discard(&of.map.picture);
    free(of.map.samples);
    totals_free(&of.totals);
    if (of.renderer && of.renderer->kind->close)
        of.renderer->kind->close(of.renderer);
    volumes_free(&of.volumes);
    lit_free(&of.lit);
    out->seconds.total = clock_seconds() - start;
    out->seconds.processor = processor_seconds();
    return done;
}
