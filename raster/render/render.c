/* SPDX-License-Identifier: MIT */
/* A plan becomes a stack: everything before the first pixel, and after the last one. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "data/sampling/sampling.h"
#include "raster/bounds/bounds.h"
#include "raster/fit/fit.h"
#include "raster/render/render.h"

/* A render on its way: what the stages work on, in the order in which it is made. */
struct state {
    struct stages stages;
    struct passes passes;
    struct lit_scene lit;
    struct fit fit;
    struct check_scene check_scene;
    struct check_map map;
    struct stack_sink {
        struct tile_sink sink; /* the first member */
        struct stack_writer writer;
    } stack;
    int *tiles;       /* owned */
    char *provenance; /* of find_provenance; owned; NULL: not asked for */
    struct part_file part;
    bool shared; /* samples of parts are in the unfinished stack */
    struct renderer_lacks lacks;
    double since; /* clock_seconds at the last clock_in */
    struct render_result *result;
};

const char *render_stored(const struct plan *plan, const struct render_result *result)
{
    return plan->options.store_raster ? "raster" : result->names.renderer;
}

/* Lists the names of the objects in the order of their numbers; none if there is no object map. */
static bool list_objects(const struct plan *plan, struct record *record, struct error *err)
{
    const char **names = calloc((size_t)plan->n_instances + 1, sizeof *names);
    if (!names)
        return error_memory(err);
    record->objects = (struct texts){names, plan->map_bytes > 0 ? plan->n_instances : 0};
    for (int i = 0; i < record->objects.n; i++)
        names[i] = object_name(plan, i);
    return true;
}

/* Makes the record of the stack as text, when it is first asked for: all files of the scene are
 * read for their digests. */
static bool find_provenance(struct state *state, struct error *err)
{
    const struct plan *plan = state->stages.plan;
    struct record record;
    if (state->provenance)
        return true;
    if (!record_scene(plan->scene, plan->sampling, plan->options.detector, &record, err))
        return false;
    record.program = PROGRAM;
    record.renderer = render_stored(plan, state->result);
    record.n_options = plan->options.n_recorded;
    for (int i = 0; i < record.n_options; i++)
        record.options[i] = plan->options.recorded[i];
    if (list_objects(plan, &record, err) && !(state->provenance = record_text(&record)))
        error_memory(err);
    record_free(&record);
    return state->provenance != NULL;
}

/* Returns the labels of the pages of components. One allocation holds the pointers and the text.
 * NULL: no memory. */
static const char **make_labels(const struct sampling *sampling, struct error *err)
{
    typedef char label_text[24];
    size_t n = (size_t)sampling->pages.n;
    const char **labels = calloc(n, sizeof *labels + sizeof(label_text));
    label_text *text = (label_text *)(labels + n);
    if (!labels)
        error_memory(err);
    for (int i = 0; labels && i < sampling->pages.n; i++) {
        sampling_label(sampling, i, text[i]);
        labels[i] = text[i];
    }
    return labels;
}

static bool write_stack(struct tile_sink *sink, const struct stack_rectangle *to,
                        const void *samples, struct error *err)
{
    return stack_write(&((struct stack_sink *)sink)->writer, to, samples, err);
}

static bool open_stack(struct state *state, const char *path, bool head_only, struct error *err)
{
    const struct plan *plan = state->stages.plan;
    const struct sampling *sampling = plan->sampling;
    const bool labelled = sampling && !sampling->spectral;
    const bool recorded = find_provenance(state, err);
    const char **labels = labelled && recorded ? make_labels(sampling, err) : NULL;
    struct stack_options options = {.width = plan->scene->width,
                                    .height = plan->scene->height,
                                    .n_wavelengths = plan->n_bands,
                                    .wavelengths_nm = plan->scene->wavelengths_nm,
                                    .full_scale = state->result->full_scale,
                                    .bits = plan->options.bits,
                                    .scene = plan->scene->path,
                                    .provenance = state->provenance,
                                    .map_bytes = plan->map_bytes,
                                    .head_only = head_only,
                                    .labels = labels};
    if (recorded && (labels || !labelled) &&
        stack_open(&state->stack.writer, path, &options, err)) {
        state->stack.sink.write = write_stack;
        state->stages.sink = &state->stack.sink;
    }
    free(labels);
    clock_in(&state->since, &state->stages.seconds.write);
    return state->stages.sink != NULL;
}

/* ---- parts ---- */

/* Returns the facts of the picture as text, allocated; NULL on failure. */
static char *make_facts(struct state *state, struct error *err)
{
    const struct plan *plan = state->stages.plan;
    const struct part_facts facts = {.full_scale = state->stages.full_scale,
                                     .unchecked = plan->options.unchecked,
                                     .clips = state->stages.clips,
                                     .check = plan->options.check,
                                     .strict = plan->options.strict,
                                     .shared = state->shared,
                                     .measured = state->result->driver.is_measured,
                                     .names = state->result->names,
                                     .lacks = state->lacks};
    char *text = find_provenance(state, err) ? facts_text(plan, &facts, state->provenance) : NULL;
    if (state->provenance && !text)
        error_memory(err);
    return text;
}

/* Adds the sums of the tiles that are complete already. A process that draws alone reads their
 * samples again. */
static bool take_complete(struct state *state, const struct render_output *output,
                          struct error *err)
{
    struct stages *stages = &state->stages;
    struct collector collector;
    bool found = true,
         done = collector_open(stages->plan, output->resume ? &state->stack.writer : NULL,
                               &stages->sums, &collector, err);
    while (done && found)
        done = collector_take(&collector, &state->part, &found, err);
    collector_close(&collector);
    return done;
}

/* Opens the unfinished stack, if it is to take the samples of the part. */
static bool open_unfinished(struct state *state, const struct render_output *output,
                            struct error *err)
{
    const enum unfinished_use use = output->resume ? UNFINISHED_ALONE : UNFINISHED_SHARED;
    return !state->shared ||
           unfinished_open(&state->stack.writer, use, part_begun(&state->part), err);
}

/* Opens the file of a part, and lists the tiles that are not complete. */
static bool open_part(struct state *state, const struct render_output *output, struct error *err)
{
    struct stages *stages = &state->stages;
    struct part_file *file = &state->part;
    state->shared = output->shared || output->resume;
    if (state->shared && !open_stack(state, output->path, true, err))
        return false;
    file->part = *output->part;
    file->stack = state->shared ? &state->stack.writer : NULL;
    char *text = make_facts(state, err);
    const bool done = text && part_create(output->path, stages->plan, text, file, err) &&
                      open_unfinished(state, output, err) && take_complete(state, output, err);
    free(text);
    if (!done)
        return false;
    state->result->part =
        (struct part_result){*output->part, file->n_tiles, file->n_complete, output->resume};
    stages->sink = &file->sink;
    stages->tiles = file->tiles + file->n_complete;
    stages->n_tiles = file->n_tiles - file->n_complete;
    clock_in(&state->since, &stages->seconds.write);
    return true;
}

/* Takes what the parts record, in place of what is found when a scene is drawn. Refuses parts that
 * this program would not draw from the scene as it is now. */
static bool prepare_join(struct state *state, const struct render_output *output, struct error *err)
{
    struct stages *stages = &state->stages;
    const char *recorded = output->join->list[0].text;
    char own[FACT_LINE], other[FACT_LINE];
    struct part_facts facts;
    if (!facts_read(recorded, &facts))
        return error_usage(err, "%s: records no facts", output->join->list[0].path);
    state->result->names = facts.names;
    state->result->driver = *driver_of(facts.names.renderer);
    if (facts.measured) {
        state->result->driver.is_measured = true;
        state->result->driver.name = "measured";
    }
    state->result->full_scale = stages->full_scale = facts.full_scale;
    stages->clips = facts.clips;
    state->shared = facts.shared;
    state->lacks = facts.lacks;
    state->lit.plan = stages->plan;
    char *text = make_facts(state, err);
    const bool differ = text && facts_differ(text, recorded, own, other);
    free(text);
    if (!text)
        return false;
    if (differ)
        return error_usage(err, "%s: the parts record '%s', but now it is '%s'", output->path,
                           other, own);
    if (!stages->plan->options.check)
        return true;
    state->check_scene = (struct check_scene){
        .lit = &state->lit, .full_scale = stages->full_scale, .clips = stages->clips};
    stages->check_scene = &state->check_scene;
    return totals_open(&state->check_scene, &stages->sums.totals, err);
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
    const bool shaders = plan->options.gl_way != GL_WITHOUT_SHADERS,
               done = foreign ? foreign->open(foreign->of, plan, n_buffers, out, err)
                      : !plan->options.use_gl ? true
                      : shaders               ? shader_open(plan, n_buffers, out, err)
                                              : gl_open(plan, n_buffers, out, err);
    if (done && stages->renderer) {
        state->result->names = stages->renderer->names;
        state->lacks = stages->renderer->lacks;
    }
    clock_in(&state->since, &stages->seconds.gl);
    return done;
}

/* Lists all tiles. */
static bool list_tiles(struct state *state, struct error *err)
{
    struct stages *stages = &state->stages;
    const struct rectangle picture = plan_picture(stages->plan);
    stages->n_tiles = plan_tiles(stages->plan, &picture);
    state->tiles = calloc((size_t)stages->n_tiles, sizeof *state->tiles);
    if (!state->tiles)
        return error_memory(err);
    for (int i = 0; i < stages->n_tiles; i++)
        state->tiles[i] = i;
    stages->tiles = state->tiles;
    return true;
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
    return list_tiles(state, err) &&
           (!plan->options.check || open_check(state, output->check_map, err)) &&
           (!output->path || (output->part ? open_part(state, output, err)
                                           : open_stack(state, output->path, false, err)));
}

bool render_agreed(const struct plan *plan, const struct render_result *result)
{
    if (result->difference.found)
        return false;
    if (!plan->options.check)
        return true;
    /* the share of a picture that may stay unchecked is no limit of a part's */
    const enum check_outcome outcome = check_outcome(plan, &result->check);
    return outcome == OUTCOME_AGREED || (result->part.part.count > 0 && !result->part.finished &&
                                         outcome == OUTCOME_NOT_VERIFIED);
}

/* Refuses samples that no page can hold. */
static bool are_finite(const struct render_result *result, struct error *err)
{
    errno = 0;
    return result->odd.undefined == 0 ||
           error_system(err,
                        "%llu samples are not finite (or too large for a float page); "
                        "nothing was written",
                        (unsigned long long)result->odd.undefined);
}

static bool remove_part(const char *path, struct error *err)
{
    errno = 0;
    return remove(path) == 0 || errno == ENOENT || error_system(err, "cannot remove %s", path);
}

/* The unfinished stack becomes the stack. What is left of it then is no part of anything, so the
 * parts go first; where one cannot, there is no stack. */
static bool end_parts(struct state *state, const struct render_output *output, struct error *err)
{
    if (!state->shared)
        return true;
    bool done = !output->resume || remove_part(state->part.path, err);
    for (int i = 0; done && output->join && i < output->join->n; i++)
        done = remove_part(output->join->list[i].path, err);
    if (done)
        unfinished_end(&state->stack.writer);
    return done;
}

static bool commit(struct state *state, const struct render_output *output, struct error *err)
{
    struct render_result *result = state->result;
    const struct plan *plan = state->stages.plan;
    char verdict[STACK_VERDICT];
    bool compared = output->again && result->odd.undefined == 0;
    if (!state->stages.sink || !(output->keep || compared || render_agreed(plan, result)))
        return true;
    if (!are_finite(result, err))
        return false;
    report_verdict(plan, &result->check, verdict, sizeof verdict);
    bool done = stack_finish(&state->stack.writer, verdict, err) &&
                (!output->again ||
                 stack_compare(&state->stack.writer, output->again, &result->difference, err));
    if (done && !output->discard && (output->keep || render_agreed(plan, result)))
        done = end_parts(state, output, err) &&
               (output->envi
                    ? stack_commit_envi(&state->stack.writer, output->path, output->outputs, err)
                    : stack_commit(&state->stack.writer, output->outputs, err));
    clock_in(&state->since, &result->seconds.write);
    return done;
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

/* Puts parts together. */
static bool join_all(struct state *state, const struct render_output *output, struct error *err)
{
    if (!prepare_join(state, output, err) || !open_stack(state, output->path, state->shared, err) ||
        (state->shared && !unfinished_open(&state->stack.writer, UNFINISHED_ALONE, true, err)) ||
        !parts_collect(output->join, state->stages.plan, &state->stack.writer, &state->stages.sums,
                       err))
        return false;
    clock_in(&state->since, &state->stages.seconds.write);
    take_results(state);
    return commit(state, output, err);
}

static bool render_all(struct state *state, const struct render_output *output, struct error *err)
{
    if (output->join)
        return join_all(state, output, err);
    if (!prepare(state, output, err) || !stages_run(&state->stages, err))
        return false;
    state->since = clock_seconds();
    take_results(state);
    if (output->part && !output->resume)
        return are_finite(state->result, err);
    /* both files are complete before the first of them appears */
    const bool mapped = state->stages.map != NULL;
    return (!mapped || check_map_finish(&state->map, err)) && commit(state, output, err) &&
           (!mapped || check_map_commit(&state->map, output->outputs, err));
}

bool render(const struct plan *plan, const struct render_output *output,
            struct progress_line *progress, struct render_result *out, struct error *err)
{
    const double start = clock_seconds();
    struct state state = {.since = start, .result = out};
    state.stages = (struct stages){
        .plan = plan, .passes = &state.passes, .lit = &state.lit, .progress = progress};
    *out = (struct render_result){.notes = output->notes};
    bool done = render_all(&state, output, err);
    if (output->notes && plan->options.check && !output->part && out->check.objects == 0)
        notes_of_nothing(output->notes);
    part_close(&state.part);
    if (state.stack.sink.write)
        stack_discard(&state.stack.writer); /* keeps a committed stack, and an unfinished one */
    if (state.fit.plan)
        fit_free(&state.fit);
    if (state.stages.map)
        check_map_discard(&state.map);
    totals_free(&state.stages.sums.totals);
    free(state.tiles);
    free(state.provenance);
    if (state.stages.renderer)
        state.stages.renderer->kind->close(state.stages.renderer);
    lit_free(&state.lit);
    passes_free(&state.passes);
    out->seconds.total = clock_seconds() - start;
    out->seconds.processor = processor_seconds();
    return done;
}
