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

static bool open_gl(struct render_state *state, struct error *err)
{
    struct render_result *result = state->result;
    const int n_buffers = AHEAD_PASSES + (state->plan->options.check ? MAX_PILOT_PASSES : 0);
    if (!gl_open(state->plan, n_buffers, &state->gl, err))
        return false;
    snprintf(result->gl_renderer, sizeof result->gl_renderer, "%s", gl_renderer(state->gl));
    snprintf(result->gl_version, sizeof result->gl_version, "%s", gl_version(state->gl));
    return true;
}

const char *render_stored(const struct plan *plan, const struct render_result *result)
{
    return plan->options.store_raster ? "raster" : result->gl_renderer;
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

/* Returns the record of the stack as text, allocated; NULL on failure. */
static char *provenance_text(const struct plan *plan, const struct render_result *result,
                             struct error *err)
{
    struct record record;
    char *text = NULL;
    if (!record_scene(plan->scene, plan->sampling, &record, err))
        return NULL;
    record.program = PROGRAM;
    record.renderer = render_stored(plan, result);
    record.n_options = plan->options.n_recorded;
    for (int i = 0; i < record.n_options; i++)
        record.options[i] = plan->options.recorded[i];
    if (list_objects(plan, &record, err)) {
        text = record_text(&record);
        if (!text)
            error_memory(err);
    }
    record_free(&record);
    return text;
}

static bool allocate_samples(struct render_state *state, struct error *err)
{
    const struct plan *plan = state->plan;
    size_t n_samples = (size_t)plan->tile_width * (size_t)plan->tile_height;
    size_t size = (size_t)plan->options.bits / 8, map = (size_t)plan->map_bytes;
    for (int i = 0; i < WRITTEN_PLACES * BANDS_PER_PASS; i++) {
        unsigned char **samples = &state->written[i / BANDS_PER_PASS].samples[i % BANDS_PER_PASS];
        *samples = malloc(n_samples * (size > map ? size : map));
        if (!*samples)
            return error_memory(err);
    }
    return true;
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

static bool open_stack(struct render_state *state, const char *path, struct error *err)
{
    const struct plan *plan = state->plan;
    const struct sampling *sampling = plan->sampling;
    const bool labelled = sampling && !sampling->spectral;
    if (!allocate_samples(state, err))
        return false;
    char *provenance = provenance_text(plan, state->result, err);
    const char **labels = labelled && provenance ? make_labels(sampling, err) : NULL;
    struct stack_options options = {.width = plan->scene->width,
                                    .height = plan->scene->height,
                                    .n_wavelengths = plan->n_bands,
                                    .wavelengths_nm = plan->scene->wavelengths_nm,
                                    .full_scale = state->result->full_scale,
                                    .bits = plan->options.bits,
                                    .scene = plan->scene->path,
                                    .provenance = provenance,
                                    .map_bytes = plan->map_bytes,
                                    .labels = labels};
    state->writing =
        provenance && (labels || !labelled) && stack_open(&state->writer, path, &options, err);
    free(labels);
    free(provenance);
    clock_in(&state->since, &state->result->seconds.write);
    return state->writing;
}

/* Prepares the check of all bands together. */
static bool prepare_fit(struct render_state *state, struct error *err)
{
    const struct plan *plan = state->plan;
    if (!fit_make(plan, state->result->full_scale, &state->fit, err))
        return false;
    state->check_scene.lit = &state->lit;
    state->check_scene.fit = &state->fit;
    state->check_scene.full_scale = state->result->full_scale;
    state->check_scene.clips = state->result->clips;
    bool done = totals_open(&state->check_scene, &state->totals, err);
    clock_in(&state->since, &state->result->seconds.check);
    return done;
}

/* Does everything that comes before the first pixel. notes: see struct render_output. */
static bool prepare(struct render_state *state, struct notes *notes, struct error *err)
{
    struct render_result *result = state->result;
    const struct plan *plan = state->plan;
    if (plan->options.use_gl && !open_gl(state, err))
        return false;
    result->driver = driver_of(state->gl ? result->gl_renderer : NULL);
    clock_in(&state->since, &result->seconds.gl);
    if (!lit_make(plan, result->driver, &state->lit, &result->light, err) ||
        (state->gl && !gl_take_scene(state->gl, &state->lit, err)))
        return false;
    if (!find_full_scale(&state->lit, &result->full_scale, &result->clips, err) ||
        (notes && !notes_make(&state->lit, notes, err)))
        return false;
    clock_in(&state->since, &result->seconds.raster);
    return !plan->options.check || prepare_fit(state, err);
}

bool render_agreed(const struct plan *plan, const struct render_result *result)
{
    return !result->difference.found &&
           (!plan->options.check || check_outcome(plan, &result->check) == OUTCOME_AGREED);
}

static bool commit(struct render_state *state, const struct render_output *output,
                   struct error *err)
{
    struct render_result *result = state->result;
    char verdict[STACK_VERDICT];
    bool compared = output->again && result->odd.undefined == 0;
    if (!state->writing || !(output->keep || compared || render_agreed(state->plan, result)))
        return true;
    if (result->odd.undefined > 0) {
        errno = 0;
        return error_system(err,
                            "%llu samples are not finite (or too large for a float page); "
                            "nothing was written",
                            (unsigned long long)result->odd.undefined);
    }
    report_verdict(state->plan, &result->check, verdict, sizeof verdict);
    bool done =
        stack_finish(&state->writer, verdict, err) &&
        (!output->again || stack_compare(&state->writer, output->again, &result->difference, err));
    if (done && !output->discard && (output->keep || render_agreed(state->plan, result)))
        done = output->envi ? stack_commit_envi(&state->writer, output->path, output->outputs, err)
                            : stack_commit(&state->writer, output->outputs, err);
    clock_in(&state->since, &result->seconds.write);
    return done;
}

static bool render_all(struct render_state *state, const struct render_output *output,
                       struct error *err)
{
    bool done = prepare(state, output->notes, err);
    if (done && output->check_map && state->plan->options.check)
        done = state->check_scene.mapped =
            check_map_open(output->check_map, state->plan, &state->map, err);
    if (!done || (output->path && !open_stack(state, output->path, err)) || !stages_run(state, err))
        return false;
    if (state->gl)
        state->result->gl = gl_work(state->gl);
    if (state->plan->options.check) {
        totals_finish(&state->totals);
        state->result->check = state->totals.verdict;
    }
    /* both files are complete before the first of them appears */
    const bool mapped = state->check_scene.mapped;
    return (!mapped || check_map_finish(&state->map, err)) && commit(state, output, err) &&
           (!mapped || check_map_commit(&state->map, output->outputs, err));
}

bool render(const struct plan *plan, const struct render_output *output,
            struct progress_line *progress, struct render_result *out, struct error *err)
{
    const double start = clock_seconds();
    struct render_state state = {.plan = plan, .progress = progress, .result = out, .since = start};
    *out = (struct render_result){.notes = output->notes};
    bool done = render_all(&state, output, err);
    if (state.writing)
        stack_discard(&state.writer); /* keeps a committed stack */
    for (int i = 0; i < WRITTEN_PLACES * BANDS_PER_PASS; i++)
        free(state.written[i / BANDS_PER_PASS].samples[i % BANDS_PER_PASS]);
    if (state.fit.plan)
        fit_free(&state.fit);
    if (state.check_scene.mapped)
        check_map_discard(&state.map);
    totals_free(&state.totals);
    gl_close(state.gl);
    lit_free(&state.lit);
    out->seconds.total = clock_seconds() - start;
    return done;
}
