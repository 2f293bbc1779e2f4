/* SPDX-License-Identifier: MIT */
/* A plan becomes a stack: everything before the first pixel, and after the last one. */
#include <stdlib.h>
#include <time.h>

#include "data/sampling/sampling.h"
#include "raster/gl/gl.h"
#include "raster/render/inside.h"

const char *render_stored(const struct plan *plan, const struct render_result *result)
{
    return plan->options.store_raster ? "raster" : result->names.renderer;
}

/* ---- everything before the first pixel ---- */

/* Prepares the check of all bands together, and its map if the output has one. */
static bool open_check(struct rendering *of, struct error *err)
{
    static const struct verdict_limits usual = {false, USUAL_UNCHECKED};
    const struct render_output *output = of->output;
    of->check_scene = (struct check_scene){.lit = &of->lit,
                                           .limits = output->limits ? output->limits : &usual,
                                           .mapped = output->check_map != NULL};
    const bool done =
        fit_make(&of->lit, &of->check_scene.fit, err) &&
        totals_open(&of->check_scene, &of->totals, err) &&
        (!output->check_map || check_map_open(output->check_map, of->plan, &of->map, err));
    clock_in(&of->since, &of->result->seconds.check);
    return done;
}

static bool open_renderer(struct rendering *of, struct error *err)
{
    const struct plan *plan = of->plan;
    const struct render_foreign *foreign = of->output->foreign;
    const int n_buffers = plan->options.check ? GL_BUFFERS : AHEAD_FRAMES;
    const bool done = foreign ? foreign->open(foreign->of, plan, n_buffers, &of->renderer, err)
                              : !plan->options.use_gl || drawing_ways.open[plan->options.gl_way](
                                                             plan, n_buffers, &of->renderer, err);
    of->result->driver = *driver_of(NULL);
    if (done && of->renderer) {
        of->result->names = of->renderer->names;
        of->result->driver = of->renderer->driver;
    }
    clock_in(&of->since, &of->result->seconds.gl);
    return done;
}

/* Finds the tiles to be drawn: those of the picture, or whole rows of them for a part. */
static bool find_tiles(struct rendering *of, struct error *err)
{
    const struct plan *plan = of->plan;
    const struct picture_part *part = &of->output->part;
    const struct rectangle picture = plan_picture(plan);
    const int n = plan_tiles(plan, &picture), height = plan->tile_height,
              all = (picture.height + height - 1) / height, columns = n / all,
              from = part->count > 0 ? (int)((long)all * (part->number - 1) / part->count) : 0,
              to = part->count > 0 ? (int)((long)all * part->number / part->count) : all;
    if (part->count > all)
        return error_usage(err,
                           "--part %d/%d: a part has whole rows of tiles, and this picture has %d; "
                           "expected at most %d parts",
                           part->number, part->count, all, all);
    of->first_tile = from * columns;
    of->n_tiles = (to - from) * columns;
    if (part->count == 0)
        return true;
    const struct rectangle first = plan_tile(plan, &picture, of->first_tile),
                           last = plan_tile(plan, &picture, to * columns - 1);
    of->result->rows.first = plan_pixels(plan, &first).y;
    of->result->rows.count = (last.y + last.height - first.y) / plan->scene->positions;
    return true;
}

static bool open_stack(struct rendering *of, struct error *err)
{
    const bool done = stack_file_open(&of->stack, of->plan, of->output, of->result, err);
    clock_in(&of->since, &of->result->seconds.write);
    return done;
}

/* Does everything that comes before the first pixel. */
static bool prepare(struct rendering *of, struct error *err)
{
    struct render_result *result = of->result;
    const struct render_output *output = of->output;
    if (!open_renderer(of, err) || !lit_make(of->plan, &result->driver, &of->lit, err) ||
        (of->renderer && !of->renderer->kind->take_scene(of->renderer, &of->lit, err)) ||
        !find_full_scale(&of->lit, err) ||
        (output->notes && !notes_make(&of->lit, SOME_PIXELS, output->notes, err)))
        return false;
    result->full_scale = of->lit.full_scale;
    result->light = of->lit.work;
    clock_in(&of->since, &result->seconds.raster);
    return find_tiles(of, err) && (!of->plan->options.check || open_check(of, err)) &&
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

/* Completes the result after the last pixel. */
static void take_results(struct rendering *of)
{
    struct render_result *result = of->result;
    const struct passes *passes = &of->plan->passes;
    if (of->renderer) {
        result->gl = of->renderer->work;
        result->dark_passes = passes->n_dark;
        result->repeated_passes = of->plan->n_passes - passes->n_dark - passes->n_frames;
    }
    if (of->check_scene.lit) {
        totals_finish(&of->totals);
        result->check = of->totals.verdict;
        result->check.lacks = of->renderer->lacks;
    }
}

/* Both files are complete before the first of them appears. */
static bool finish(struct rendering *of, struct error *err)
{
    const struct render_output *output = of->output;
    if ((of->check_scene.mapped && !check_map_finish(&of->map, err)) ||
        (output->path && !stack_file_finish(&of->stack, of->plan, output, of->result, err)))
        return false;
    clock_in(&of->since, &of->result->seconds.write);
    return !of->check_scene.mapped || check_map_commit(&of->map, output->outputs, err);
}

static bool render_all(struct rendering *of, struct error *err)
{
    if (!prepare(of, err) || !stages_run(of, err))
        return false;
    of->since = clock_seconds();
    take_results(of);
    return finish(of, err);
}

bool render(const struct plan *plan, const struct render_output *output,
            struct progress_line *progress, struct render_result *out, struct error *err)
{
    const double start = clock_seconds();
    struct rendering of = {
        .plan = plan, .output = output, .result = out, .progress = progress, .since = start};
    *out = (struct render_result){.notes = output->notes};
    bool done = render_all(&of, err);
    if (output->notes && plan->options.check && output->part.count == 0 && out->check.objects == 0)
        notes_of_nothing(output->notes);
    stack_discard(&of.stack); /* keeps a committed stack */
    fit_free(&of.check_scene.fit);
    check_map_discard(&of.map);
    totals_free(&of.totals);
    if (of.renderer)
        of.renderer->kind->close(of.renderer);
    lit_free(&of.lit);
    out->seconds.total = clock_seconds() - start;
    out->seconds.processor = processor_seconds();
    return done;
}
