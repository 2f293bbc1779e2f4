/* SPDX-License-Identifier: MIT */
/* Runs settings of render, each many times and in a process of its own, and compares what they make
 * with the reference. */
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "data/base/base.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "raster/cost/cost.h"
#include "raster/render/render.h"
#include "spectral.h"

struct measurement {
    const struct cost_program *program;
    const struct cost_options *options;
    char *folder, *stack, *reference; /* temporary, and files in it */
    struct survey survey;
    struct truth truth;
    struct trials trials;
    long steps, all_steps;
    struct cost *cost;
};

static void step(struct measurement *measurement, long steps)
{
    const struct cost_options *options = measurement->options;
    measurement->steps += steps;
    if (options->progress && measurement->steps > 0)
        options->progress(options->progress_context, measurement->steps, measurement->all_steps);
}

/* ---- the temporary folder ---- */

/* folder/name, allocated; NULL: no memory. */
static char *path_in(const char *folder, const char *name)
{
    const size_t length = strlen(folder) + strlen(name) + 2;
    char *out = malloc(length);
    if (out)
        snprintf(out, length, "%s/%s", folder, name);
    return out;
}

static bool open_folder(struct measurement *measurement, struct error *err)
{
    const char *parent = getenv("TMPDIR");
    if (!parent || !parent[0])
        parent = "/tmp";
    measurement->folder = path_in(parent, "spectral-cost.XXXXXX");
    if (!measurement->folder)
        return error_memory(err);
    if (!mkdtemp(measurement->folder)) {
        error_system(err, "cannot make a temporary folder in %s", parent);
        free(measurement->folder);
        measurement->folder = NULL;
        return false;
    }
    measurement->stack = path_in(measurement->folder, "stack.tif");
    measurement->reference = path_in(measurement->folder, "reference");
    return (measurement->stack && measurement->reference) || error_memory(err);
}

/* With whatever an interrupted run left there. */
static void close_folder(struct measurement *measurement)
{
    DIR *folder = measurement->folder ? opendir(measurement->folder) : NULL;
    for (struct dirent *entry; folder && (entry = readdir(folder));) {
        char *path = path_in(measurement->folder, entry->d_name);
        if (path && strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            unlink(path);
        free(path);
    }
    if (folder)
        closedir(folder);
    if (measurement->folder)
        rmdir(measurement->folder);
    free(measurement->folder);
    free(measurement->stack);
    free(measurement->reference);
}

/* ---- what processes of their own do ---- */

struct task {
    const struct measurement *measurement;
    const struct cost_entry *entry;
};

static bool render_stack(void *context, void *out, struct error *err)
{
    const struct task *task = context;
    const struct measurement *measurement = task->measurement;
    (void)out;
    return measurement->program->render(measurement->program->context, task->entry->words,
                                        task->entry->n_words, measurement->stack, err);
}

static bool read_scene(const struct task *task, struct scene *out, struct sampling *sampling,
                       struct error *err)
{
    const struct cost_program *program = task->measurement->program;
    return program->read(program->context, task->entry->words, task->entry->n_words, out, sampling,
                         err);
}

static bool render_reference(void *context, void *out, struct error *err)
{
    const struct task *task = context;
    const struct measurement *measurement = task->measurement;
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.n = 0};
    const bool done = read_scene(task, &scene, &sampling, err) &&
                      truth_render(&scene, measurement->options->observer,
                                   measurement->options->threads, measurement->reference, out, err);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}

static bool compare_stack(void *context, void *out, struct error *err)
{
    const struct task *task = context;
    const struct measurement *measurement = task->measurement;
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.n = 0};
    bool done = read_scene(task, &scene, &sampling, err);
    const struct truth_stack stack = {measurement->stack, &scene, sampling_or_none(&sampling),
                                      measurement->options->observer};
    done = done && truth_compare(&measurement->truth, measurement->reference, &stack,
                                 measurement->options->threads, out, err);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}

/* ---- settings ---- */

static bool make_reference(struct measurement *measurement, struct error *err)
{
    struct cost_entry entry = {.n_words = 0};
    struct task task = {measurement, &entry};
    const bool done =
        setting_entry(&reference_setting, measurement->options->observer, &entry, err) &&
        process_run(render_reference, &task, &measurement->truth, sizeof measurement->truth,
                    &measurement->cost->reference_seconds, err);
    cost_entry_free(&entry);
    return done;
}

/* Its time is not counted; its stack is what the errors are of. A setting that fails becomes a
 * note. */
static bool warm_up(struct measurement *measurement, struct trial *trial, struct error *err)
{
    struct task task = {measurement, &trial->entry};
    struct truth_errors errors = {.n_pages = 0};
    struct error own = {.status = EXIT_AGREED};
    const bool done = process_run(render_stack, &task, NULL, 0, NULL, &own) &&
                      process_run(compare_stack, &task, &errors, sizeof errors, NULL, &own);
    unlink(measurement->stack);
    step(measurement, done ? 2 : 2 + measurement->options->runs);
    if (!done && output_interrupted()) {
        *err = own;
        return false;
    }
    if (!done) {
        const char *reason = strncmp(own.text, "error: ", 7) == 0 ? own.text + 7 : own.text;
        return cost_note(measurement->cost, err, "without %s: %s", trial->entry.name, reason);
    }
    trial->n_pages = errors.n_pages;
    trial->entry.spectral = errors.spectral;
    trial->entry.mean = errors.mean;
    trial->entry.quantile_95 = errors.quantile_95;
    trial->entry.largest = errors.largest;
    trial->entry.radiance_error = errors.radiance;
    trial->seconds = calloc((size_t)measurement->options->runs, sizeof *trial->seconds);
    return trial->seconds || error_memory(err);
}

/* `add` fills in settings whose choice may depend on the errors so far. */
static bool warm_up_more(struct measurement *measurement,
                         bool (*add)(const struct survey *survey, const char *observer,
                                     struct trials *trials, struct error *err),
                         struct error *err)
{
    const int first = measurement->trials.n;
    if (!add(&measurement->survey, measurement->options->observer, &measurement->trials, err))
        return false;
    for (int i = first; i < measurement->trials.n; i++)
        if (!warm_up(measurement, &measurement->trials.trial[i], err))
            return false;
    return true;
}

/* All settings in turn, so that a machine that slows down does so for all of them. */
static bool run_round(struct measurement *measurement, int round, struct error *err)
{
    for (int i = 0; i < measurement->trials.n; i++) {
        struct trial *trial = &measurement->trials.trial[i];
        struct task task = {measurement, &trial->entry};
        if (trial->n_pages == 0)
            continue;
        if (!process_run(render_stack, &task, NULL, 0, &trial->seconds[round], err))
            return false;
        unlink(measurement->stack);
        step(measurement, 1);
    }
    return true;
}

/* About how many settings there are; only the progress asks. */
enum { LIKELY_SETTINGS = 60 };

static long steps_of(const struct measurement *measurement, int n_trials)
{
    return (long)n_trials * (2 + measurement->options->runs);
}

static bool measure_settings(struct measurement *measurement, struct error *err)
{
    measurement->all_steps = steps_of(measurement, LIKELY_SETTINGS);
    if (!warm_up_more(measurement, settings_samplings, err) ||
        !warm_up_more(measurement, settings_pictures, err) ||
        !warm_up_more(measurement, settings_combined, err))
        return false;
    measurement->all_steps = steps_of(measurement, measurement->trials.n);
    for (int round = 0; round < measurement->options->runs; round++)
        if (!run_round(measurement, round, err))
            return false;
    return true;
}

/* ---- conclusions ---- */

static int by_seconds(const void *a, const void *b)
{
    const double one = *(const double *)a, two = *(const double *)b;
    return (one > two) - (one < two);
}

static int entries_by_seconds(const void *a, const void *b)
{
    const struct cost_entry *one = a, *two = b;
    return by_seconds(&one->seconds, &two->seconds);
}

static void take_seconds(struct trial *trial, int runs)
{
    const size_t n = (size_t)runs;
    qsort(trial->seconds, n, sizeof *trial->seconds, by_seconds);
    trial->entry.seconds = (trial->seconds[(n - 1) / 2] + trial->seconds[n / 2]) / 2;
    trial->entry.fastest = trial->seconds[0];
    trial->entry.slowest = trial->seconds[n - 1];
}

/* Entries move to the result. */
static bool conclude(struct measurement *measurement, struct error *err)
{
    struct cost *cost = measurement->cost;
    struct trials *trials = &measurement->trials;
    cost->entries = calloc((size_t)trials->n + 1, sizeof *cost->entries);
    if (!cost->entries)
        return error_memory(err);
    for (int i = 0; i < trials->n; i++) {
        struct trial *trial = &trials->trial[i];
        if (trial->n_pages == 0)
            continue;
        take_seconds(trial, cost->runs);
        cost->entries[cost->n++] = trial->entry;
        trial->entry = (struct cost_entry){.n_words = 0};
    }
    qsort(cost->entries, (size_t)cost->n, sizeof *cost->entries, entries_by_seconds);
    cost_mark(cost);
    errno = 0;
    return cost->n > 0 || error_system(err, "no setting could be rendered: %s",
                                       cost->n_notes > 0 ? cost->notes[cost->n_notes - 1] : "");
}

/* The scene with what the command line changes of it; allocated, NULL: no memory. */
static char *name_scene(const struct measurement *measurement)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (!stream)
        return NULL;
    fputs(measurement->survey.scene, stream);
    for (int i = 0; i < measurement->options->n_given; i++)
        fprintf(stream, " %s", measurement->options->given[i]);
    if (fclose(stream) == 0)
        return text;
    free(text);
    return NULL;
}

static bool describe(struct measurement *measurement, struct error *err)
{
    struct cost *cost = measurement->cost;
    cost->scene = name_scene(measurement);
    cost->observer = strdup(measurement->options->observer);
    cost->width = measurement->survey.width;
    cost->height = measurement->survey.height;
    cost->runs = measurement->options->runs;
    return ((cost->scene && cost->observer) || error_memory(err)) &&
           survey_notes(&measurement->survey, cost, err) &&
           (measurement->truth.lit ||
            cost_note(cost, err,
                      "no light that the observer sees shines: colours are beside a "
                      "radiance of 1"));
}

static bool measure(struct measurement *measurement, struct error *err)
{
    return open_folder(measurement, err) &&
           survey_scene(measurement->program, measurement->options->observer, &measurement->survey,
                        err) &&
           make_reference(measurement, err) && describe(measurement, err) &&
           measure_settings(measurement, err) && conclude(measurement, err);
}

bool cost_measure(const struct cost_program *program, const struct cost_options *options,
                  struct cost *out, struct error *err)
{
    struct measurement measurement = {.program = program, .options = options, .cost = out};
    void *held = signals_hold();
    *out = (struct cost){.scene = NULL};
    const bool done = held ? measure(&measurement, err) : error_memory(err);
    for (int i = 0; i < measurement.trials.n; i++) {
        cost_entry_free(&measurement.trials.trial[i].entry);
        free(measurement.trials.trial[i].seconds);
    }
    close_folder(&measurement);
    signals_release(held);
    return done;
}
