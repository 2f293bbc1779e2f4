/* SPDX-License-Identifier: MIT */
/* A plan becomes a stack: everything before the first pixel, and after the last one. */
#include <stdlib.h>
#include <time.h>

#include "data/sampling/sampling.h"
#include "raster/gl/gl.h"
#include "raster/render/inside.h"

/* A render on its way: what the stages work on, in the order in which it is made. */
struct state {
    struct stages stages;
    struct passes passes;
    struct lit_scene lit;
    struct fit fit;
    struct check_scene check_scene;
    struct check_map map;
    struct stack_writer stack;
    struct renderer_lacks lacks;
    const struct verdict_limits *limits;
    double since; /* clock_seconds at the last clock_in */
    struct render_result *result;
};

const char *render_stored(const struct plan *plan, const struct render_result *result)
{
    return plan->options.store_raster ? "raster" : result->names.renderer;
}

/* ---- everything before the first pixel ---- */

/* Prepares the check of all bands together, and its map if `path` is not NULL. */
static bool open_check(struct state *state, const char *path, struct error *err)
{
    struct stages *stages = &state->stages;
    if (!fit_make(stages->plan, stages->full_scale, &state->fit, err))
        return false;
    state->check_scene = (struct check_scene){.lit = &state->lit,
                                              .fit = &state->fit,
                                              .limits = state->limits,
                                              .full_scale = stages->full_scale,
                                              .clips = stages->clips,
                                              .mapped = path != NULL};
    stages->check_scene = &state->check_scene;
    if (!totals_open(&state->check_scene, &stages->sums.totals, err))
        return false;
    if (path && check_map_open(path, stages->plan, &state->map, err))
        stages->map = &state->map;
    clock_in(&state->since, &stages->seconds.check);
    return !path || stages->map;
}

static bool open_renderer(struct state *state, const struct render_foreign *foreign,
                          struct error *err)
{
    struct stages *stages = &state->stages;
    const int n_buffers = stages->plan->options.check ? GL_BUFFERS : AHEAD_FRAMES;
    const struct plan *plan = stages->plan;
    struct renderer **out = &stages->renderer;
    const bool done = foreign
                          ? foreign->open(foreign->of, plan, n_buffers, out, err)
                          : !plan->options.use_gl ||
                                drawing_ways.open[plan->options.gl_way](plan, n_buffers, out, err);
    if (done && stages->renderer) {
        state->result->names = stages->renderer->names;
        state->lacks = stages->renderer->lacks;
    }
    clock_in(&state->since, &stages->seconds.gl);
    return done;
}

/* Finds the tiles to be drawn: those of the picture, or whole rows of them for a part. */
static bool find_tiles(struct state *state, const struct picture_part *part, struct error *err)
{
    struct stages *stages = &state->stages;
    const struct plan *plan = stages->plan;
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
    stages->first_tile = from * columns;
    stages->n_tiles = (to - from) * columns;
    if (part->count == 0)
        return true;
    const struct rectangle first = plan_tile(plan, &picture, stages->first_tile),
                           last = plan_tile(plan, &picture, to * columns - 1);
    stages->first_row = plan_pixels(plan, &first).y;
    state->result->rows.first = stages->first_row;
    state->result->rows.count = (last.y + last.height - first.y) / plan->scene->positions;
    return true;
}

static bool open_stack(struct state *state, const struct render_output *output, struct error *err)
{
    if (stack_file_open(&state->stack, state->stages.plan, output, state->result, err))
        state->stages.stack = &state->stack;
    clock_in(&state->since, &state->stages.seconds.write);
    return state->stages.stack != NULL;
}

/* Does everything that comes before the first pixel. */
static bool prepare(struct state *state, const struct render_output *output, struct error *err)
{
    struct render_result *result = state->result;
    struct stages *stages = &state->stages;
    const struct plan *plan = stages->plan;
    if (!passes_make(plan, &state->passes, err) || !open_renderer(state, output->foreign, err))
        return false;
    result->driver = stages->renderer ? stages->renderer->driver : *driver_of(NULL);
    if (!lit_make(plan, &result->driver, &state->lit, &stages->sums.light, err) ||
        (stages->renderer &&
         !stages->renderer->kind->take_scene(stages->renderer, &state->lit, err)) ||
        !find_full_scale(&state->lit, &stages->full_scale, &stages->clips, err) ||
        (output->notes && !notes_make(&state->lit, SOME_PIXELS, output->notes, err)))
        return false;
    result->full_scale = stages->full_scale;
    clock_in(&state->since, &stages->seconds.raster);
    return find_tiles(state, &output->part, err) &&
           (!plan->options.check || open_check(state, output->check_map, err)) &&
           (!output->path || open_stack(state, output, err));
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

/* Takes what the stages have found into the result. */
static void take_results(struct state *state)
{
    const struct stages *stages = &state->stages;
    struct render_result *result = state->result;
    result->odd = stages->sums.odd;
    result->light = stages->sums.light;
    result->seconds = stages->seconds;
    if (stages->renderer) {
        result->gl = stages->renderer->work;
        result->dark_passes = state->passes.n_dark;
        result->repeated_passes =
            stages->plan->n_passes - state->passes.n_dark - state->passes.n_frames;
    }
    if (stages->check_scene) {
        totals_finish(&state->stages.sums.totals);
        result->check = stages->sums.totals.verdict;
        result->check.lacks = state->lacks;
    }
}

/* Both files are complete before the first of them appears. */
static bool finish(struct state *state, const struct render_output *output, struct error *err)
{
    const struct stages *stages = &state->stages;
    if (stages->map && !check_map_finish(&state->map, err))
        return false;
    if (stages->stack &&
        !stack_file_finish(&state->stack, stages->plan, output, state->result, err))
        return false;
    clock_in(&state->since, &state->result->seconds.write);
    return !stages->map || check_map_commit(&state->map, output->outputs, err);
}

static bool render_all(struct state *state, const struct render_output *output, struct error *err)
{
    if (!prepare(state, output, err) || !stages_run(&state->stages, err))
        return false;
    state->since = clock_seconds();
    take_results(state);
    return finish(state, output, err);
}

bool render(const struct plan *plan, const struct render_output *output,
            struct progress_line *progress, struct render_result *out, struct error *err)
{
    static const struct verdict_limits usual = {false, USUAL_UNCHECKED};
    const double start = clock_seconds();
    struct state state = {
        .since = start, .limits = output->limits ? output->limits : &usual, .result = out};
    state.stages = (struct stages){
        .plan = plan, .passes = &state.passes, .lit = &state.lit, .progress = progress};
    *out = (struct render_result){.notes = output->notes};
    bool done = render_all(&state, output, err);
    if (output->notes && plan->options.check && output->part.count == 0 && out->check.objects == 0)
        notes_of_nothing(output->notes);
    if (state.stages.stack)
        stack_discard(&state.stack); /* keeps a committed stack */
    if (state.fit.plan)
        fit_free(&state.fit);
    if (state.stages.map)
        check_map_discard(&state.map);
    totals_free(&state.stages.sums.totals);
    if (state.stages.renderer)
        state.stages.renderer->kind->close(state.stages.renderer);
    lit_free(&state.lit);
    passes_free(&state.passes);
    out->seconds.total = clock_seconds() - start;
    out->seconds.processor = processor_seconds();
    return done;
}
