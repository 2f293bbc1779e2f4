/* SPDX-License-Identifier: MIT */
/* Runs configurations of render, each many times and in a process of its own, and measures the
 * accuracy of their stacks. */
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "data/base/base.h"
#include "data/options/options.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "raster/accuracy/accuracy.h"
#include "raster/cost/cost.h"
#include "spectral.h"

enum { DEFAULT_RUNS = 5 };

struct measurement {
    const struct options *options;
    struct progress_line line;
    bool shown;                       /* the line of progress */
    char *folder, *stack, *reference; /* temporary, and files in it */
    struct survey survey;
    struct standard standard;
    struct attempts attempts;
    long steps, all_steps;
    struct cost *cost;
};

static void step(struct measurement *measurement, long steps)
{
    measurement->steps += steps;
    if (measurement->shown && measurement->steps > 0)
        progress_show(&measurement->line, measurement->steps, measurement->all_steps);
}

/* ---- the temporary folder ---- */

/* Returns folder/name, allocated; NULL: no memory. */
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

/* Deletes the folder with all that an interrupted run left there. */
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

/* ---- jobs for processes of their own ---- */

struct task {
    const struct measurement *measurement;
    const struct cost_entry *entry;
};

static bool render_stack(void *context, void *out, struct error *err)
{
    const struct task *task = context;
    (void)out;
    return cost_render(task->measurement->options, task->entry, task->measurement->stack, err);
}

static bool render_reference(void *context, void *out, struct error *err)
{
    const struct task *task = context;
    const struct measurement *measurement = task->measurement;
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.detector = NULL};
    const bool done =
        cost_read(measurement->options, task->entry, &scene, &sampling, err) &&
        standard_render(&scene, measurement->survey.observer, measurement->options->threads,
                        measurement->reference, out, err);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}

static bool measure_stack(void *context, void *out, struct error *err)
{
    const struct task *task = context;
    const struct measurement *measurement = task->measurement;
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.detector = NULL};
    bool done = cost_read(measurement->options, task->entry, &scene, &sampling, err);
    const struct accuracy_stack stack = {measurement->stack, &scene, sampling_or_none(&sampling),
                                         measurement->survey.observer};
    done = done && accuracy_measure(&measurement->standard, measurement->reference, &stack,
                                    measurement->options->threads, out, err);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}

/* ---- configurations ---- */

static bool make_reference(struct measurement *measurement, struct error *err)
{
    struct cost_entry entry = {.n_words = 0};
    struct task task = {measurement, &entry};
    const bool done =
        configuration_entry(&reference_configuration, measurement->survey.observer, &entry, err) &&
        process_run(render_reference, &task, &measurement->standard, sizeof measurement->standard,
                    &measurement->cost->reference_seconds, err);
    cost_entry_free(&entry);
    return done;
}

/* Runs a configuration once without counting its time, and measures its stack. A configuration that
 * fails becomes a note. */
static bool warm_up(struct measurement *measurement, struct attempt *attempt, struct error *err)
{
    struct task task = {measurement, &attempt->entry};
    struct accuracy accuracy = {.n_pages = 0};
    struct error own = {.status = EXIT_AGREED};
    const bool done = process_run(render_stack, &task, NULL, 0, NULL, &own) &&
                      process_run(measure_stack, &task, &accuracy, sizeof accuracy, NULL, &own);
    unlink(measurement->stack);
    step(measurement, done ? 2 : 2 + measurement->cost->runs);
    if (!done && output_interrupted()) {
        *err = own;
        return false;
    }
    if (!done) {
        const char *reason = strncmp(own.text, "error: ", 7) == 0 ? own.text + 7 : own.text;
        return cost_note(measurement->cost, err, "without %s: %s", attempt->entry.name, reason);
    }
    attempt->entry.accuracy = accuracy;
    attempt->seconds = calloc((size_t)measurement->cost->runs, sizeof *attempt->seconds);
    return attempt->seconds || error_memory(err);
}

/* `add` adds configurations, whose choice may depend on the errors so far. */
static bool warm_up_more(struct measurement *measurement,
                         bool (*add)(const struct survey *survey, struct attempts *attempts,
                                     struct error *err),
                         struct error *err)
{
    const int first = measurement->attempts.n;
    if (!add(&measurement->survey, &measurement->attempts, err))
        return false;
    for (int i = first; i < measurement->attempts.n; i++)
        if (!warm_up(measurement, &measurement->attempts.attempt[i], err))
            return false;
    return true;
}

/* All configurations in turn, so that a machine that slows down does so for all of them. */
static bool run_round(struct measurement *measurement, int round, struct error *err)
{
    for (int i = 0; i < measurement->attempts.n; i++) {
        struct attempt *attempt = &measurement->attempts.attempt[i];
        struct task task = {measurement, &attempt->entry};
        if (attempt->entry.accuracy.n_pages == 0)
            continue;
        if (!process_run(render_stack, &task, NULL, 0, &attempt->seconds[round], err))
            return false;
        unlink(measurement->stack);
        step(measurement, 1);
    }
    return true;
}

/* For the progress until all configurations are known. */
enum { LIKELY_CONFIGURATIONS = 60 };

static long steps_of(const struct measurement *measurement, int n_attempts)
{
    return (long)n_attempts * (2 + measurement->cost->runs);
}

static bool measure_configurations(struct measurement *measurement, struct error *err)
{
    measurement->all_steps = steps_of(measurement, LIKELY_CONFIGURATIONS);
    if (!warm_up_more(measurement, configurations_samplings, err) ||
        !warm_up_more(measurement, configurations_pictures, err) ||
        !warm_up_more(measurement, configurations_combined, err))
        return false;
    measurement->all_steps = steps_of(measurement, measurement->attempts.n);
    for (int round = 0; round < measurement->cost->runs; round++)
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

static void take_seconds(struct attempt *attempt, int runs)
{
    const size_t n = (size_t)runs;
    qsort(attempt->seconds, n, sizeof *attempt->seconds, by_seconds);
    attempt->entry.seconds = (attempt->seconds[(n - 1) / 2] + attempt->seconds[n / 2]) / 2;
    attempt->entry.fastest = attempt->seconds[0];
    attempt->entry.slowest = attempt->seconds[n - 1];
}

/* Moves entries to the result. */
static bool conclude(struct measurement *measurement, struct error *err)
{
    struct cost *cost = measurement->cost;
    struct attempts *attempts = &measurement->attempts;
    cost->entries = calloc((size_t)attempts->n + 1, sizeof *cost->entries);
    if (!cost->entries)
        return error_memory(err);
    for (int i = 0; i < attempts->n; i++) {
        struct attempt *attempt = &attempts->attempt[i];
        if (attempt->entry.accuracy.n_pages == 0)
            continue;
        take_seconds(attempt, cost->runs);
        cost->entries[cost->n++] = attempt->entry;
        attempt->entry = (struct cost_entry){.n_words = 0};
    }
    qsort(cost->entries, (size_t)cost->n, sizeof *cost->entries, entries_by_seconds);
    cost_mark(cost);
    errno = 0;
    return cost->n > 0 || error_system(err, "no setting could be rendered: %s",
                                       cost->n_notes > 0 ? cost->notes[cost->n_notes - 1] : "");
}

/* Returns the scene's name with the changes of the command line, allocated; NULL: no memory. */
static char *name_scene(const struct measurement *measurement)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (!stream)
        return NULL;
    fputs(measurement->survey.scene, stream);
    for (int i = 0; i < measurement->options->n_recorded; i++)
        fprintf(stream, " %s", measurement->options->recorded[i]);
    if (fclose(stream) == 0)
        return text;
    free(text);
    return NULL;
}

static bool describe(struct measurement *measurement, struct error *err)
{
    struct cost *cost = measurement->cost;
    cost->scene = name_scene(measurement);
    cost->observer = strdup(measurement->survey.observer);
    cost->width = measurement->survey.width;
    cost->height = measurement->survey.height;
    cost->runs = measurement->options->runs ? measurement->options->runs : DEFAULT_RUNS;
    return ((cost->scene && cost->observer) || error_memory(err)) &&
           survey_notes(&measurement->survey, cost, err) &&
           (measurement->standard.lit ||
            cost_note(cost, err,
                      "no light that the observer sees shines: colours are beside a "
                      "radiance of 1"));
}

static bool measure(struct measurement *measurement, struct error *err)
{
    return open_folder(measurement, err) &&
           survey_scene(measurement->options, &measurement->survey, err) &&
           make_reference(measurement, err) && describe(measurement, err) &&
           measure_configurations(measurement, err) && conclude(measurement, err);
}

bool cost_measure(const struct options *options, struct cost *out, struct error *err)
{
    struct measurement measurement = {.options = options, .cost = out};
    void *held = signals_hold();
    measurement.shown = progress_start(&measurement.line, options->quiet);
    *out = (struct cost){.scene = NULL};
    const bool done = held ? measure(&measurement, err) : error_memory(err);
    for (int i = 0; i < measurement.attempts.n; i++) {
        cost_entry_free(&measurement.attempts.attempt[i].entry);
        free(measurement.attempts.attempt[i].seconds);
    }
    close_folder(&measurement);
    signals_release(held);
    return done;
}
