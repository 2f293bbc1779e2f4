/* SPDX-License-Identifier: MIT */
/* Runs each configuration of render several times, each time in a process of its own, and measures
 * the accuracy of its stack. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "data/base/base.h"
#include "data/process/process.h"
#include "raster/cost/cost.h"

enum { DEFAULT_RUNS = 5 };

struct measurement {
    const struct options *options;
    struct progress_line line;
    bool shown; /* the line of progress */
    struct folder folder;
    char stack[sizeof(struct folder) + 16], summary[sizeof(struct folder) + 16]; /* files in it */
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

static bool open_folder(struct measurement *measurement, struct error *err)
{
    if (!folder_open(&measurement->folder, err))
        return false;
    snprintf(measurement->stack, sizeof measurement->stack, "%s/stack.tif",
             measurement->folder.path);
    snprintf(measurement->summary, sizeof measurement->summary, "%s/standard",
             measurement->folder.path);
    return true;
}

/* Removes the two files by their names, since listing a folder needs memory. */
static void close_folder(struct measurement *measurement)
{
    unlink(measurement->stack);
    unlink(measurement->summary);
    folder_close(&measurement->folder);
}

/* ---- jobs for processes of their own ---- */

struct task {
    const struct measurement *measurement;
    const struct cost_entry *entry;
};

static bool render_job(void *context, void *out, struct error *err)
{
    const struct task *task = context;
    (void)out;
    return cost_render(task->measurement->options, task->entry, task->measurement->stack, err);
}

static bool summarize_job(void *context, void *out, struct error *err)
{
    return standard_summarize(context, out, err);
}

static struct standard_request request_of(const struct measurement *measurement)
{
    return (struct standard_request){.stack = measurement->stack,
                                     .summary = measurement->summary,
                                     .observer = measurement->cost->survey.observer,
                                     .threads = measurement->options->threads};
}

static bool compare_job(void *context, void *out, struct error *err)
{
    const struct task *task = context;
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.detector = NULL};
    struct standard_request request = request_of(task->measurement);
    request.sampling = &sampling;
    const bool done = cost_read(task->measurement->options, task->entry, &scene, &sampling, err) &&
                      standard_compare(&request, out, err);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}

/* Renders an entry to the stack. seconds NULL: not wanted. */
static bool render_entry(const struct measurement *measurement, const struct cost_entry *entry,
                         double *seconds, struct error *err)
{
    struct task task = {measurement, entry};
    return process_run(render_job, &task, NULL, 0, seconds, err);
}

/* ---- configurations ---- */

/* Returns a message without "error: ". */
static const char *reason(const struct error *err)
{
    static const char prefix[] = "error: ";
    const size_t length = sizeof prefix - 1;
    return err->text + (strncmp(err->text, prefix, length) == 0 ? length : 0);
}

/* Renders the standard, and summarizes its stack. A failure that names a temporary file is for want
 * of room. */
static bool make_standard(struct measurement *measurement, bool *lit, struct error *err)
{
    struct cost_entry entry = {.n_words = 0};
    struct standard_request request = request_of(measurement);
    struct error own = {.status = EXIT_AGREED};
    const bool done =
        configuration_standard(request.observer, &entry, &own) &&
        render_entry(measurement, &entry, &measurement->cost->standard_seconds, &own) &&
        process_run(summarize_job, &request, lit, sizeof *lit, NULL, &own);
    unlink(measurement->stack);
    cost_entry_free(&entry);
    errno = 0;
    if (strstr(own.text, measurement->folder.path))
        error_system(err, "%s; set TMPDIR to a folder with more room", reason(&own));
    else if (!done)
        *err = own;
    return done;
}

/* Runs a configuration once, without taking its time, and measures its stack. A configuration that
 * is refused, or that this system does not support, becomes a note. */
static bool warm_up(struct measurement *measurement, struct cost_entry *entry, struct error *err)
{
    struct task task = {measurement, entry};
    struct accuracy accuracy = {.n_pages = 0};
    struct error own = {.status = EXIT_AGREED};
    const bool done = render_entry(measurement, entry, NULL, &own) &&
                      process_run(compare_job, &task, &accuracy, sizeof accuracy, NULL, &own);
    unlink(measurement->stack);
    step(measurement, done ? 2 : 2 + measurement->cost->runs);
    if (!done && own.status == EXIT_SYSTEM && !own.unsupported) {
        *err = own;
        return false;
    }
    if (!done)
        return cost_note(measurement->cost, err, "without %s: %s", entry->name, reason(&own));
    entry->accuracy = accuracy;
    entry->run_seconds = calloc((size_t)measurement->cost->runs, sizeof *entry->run_seconds);
    return entry->run_seconds || error_memory(err);
}

/* Adds configurations and warms them up. `add` may choose by the errors measured before. */
static bool warm_up_more(struct measurement *measurement,
                         bool (*add)(struct cost *cost, struct error *err), struct error *err)
{
    struct cost *cost = measurement->cost;
    const int first = cost->n;
    if (!add(cost, err))
        return false;
    for (int i = first; i < cost->n; i++)
        if (!warm_up(measurement, &cost->entries[i], err))
            return false;
    return true;
}

/* Runs all configurations in turn, so that a slow moment of the machine meets all of them. */
static bool run_round(struct measurement *measurement, int round, struct error *err)
{
    for (int i = 0; i < measurement->cost->n; i++) {
        const struct cost_entry *entry = &measurement->cost->entries[i];
        if (entry->accuracy.n_pages == 0)
            continue;
        if (!render_entry(measurement, entry, &entry->run_seconds[round], err))
            return false;
        unlink(measurement->stack);
        step(measurement, 1);
    }
    return true;
}

/* Progress assumes so many configurations until all are known. */
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
    measurement->all_steps = steps_of(measurement, measurement->cost->n);
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

static void take_seconds(struct cost_entry *entry, int runs)
{
    const size_t n = (size_t)runs;
    qsort(entry->run_seconds, n, sizeof *entry->run_seconds, by_seconds);
    entry->seconds = (entry->run_seconds[(n - 1) / 2] + entry->run_seconds[n / 2]) / 2;
    entry->fastest = entry->run_seconds[0];
    entry->slowest = entry->run_seconds[n - 1];
}

/* Removes the entries that failed, and sorts the others. */
static bool conclude(struct cost *cost, struct error *err)
{
    int n = 0;
    for (int i = 0; i < cost->n; i++) {
        struct cost_entry *entry = &cost->entries[i];
        if (entry->accuracy.n_pages == 0) {
            cost_entry_free(entry);
            continue;
        }
        take_seconds(entry, cost->runs);
        cost->entries[n++] = *entry;
    }
    cost->n = n;
    qsort(cost->entries, (size_t)n, sizeof *cost->entries, entries_by_seconds);
    cost_mark(cost);
    errno = 0;
    return n > 0 || error_system(err, "no configuration could be rendered: %s",
                                 cost->n_notes > 0 ? cost->notes[cost->n_notes - 1] : "");
}

/* Returns the scene's name with the changes of the command line, allocated; NULL: no memory. */
static char *name_scene(const struct measurement *measurement)
{
    struct printed printed = {.text = NULL};
    print_text(&printed, measurement->cost->survey.scene);
    for (int i = 0; i < measurement->options->n_recorded; i++)
        print(&printed, " %s", measurement->options->recorded[i]);
    return printed_end(&printed);
}

static bool describe(struct measurement *measurement, bool lit, struct error *err)
{
    struct cost *cost = measurement->cost;
    cost->scene = name_scene(measurement);
    cost->runs = measurement->options->runs ? measurement->options->runs : DEFAULT_RUNS;
    cost->entries = calloc(MAX_CONFIGURATIONS, sizeof *cost->entries);
    return ((cost->scene && cost->entries) || error_memory(err)) && survey_notes(cost, err) &&
           (lit ||
            cost_note(cost, err, "the observer sees no light: the white is a radiance of 1"));
}

static bool measure(struct measurement *measurement, struct error *err)
{
    bool lit = false;
    return open_folder(measurement, err) &&
           survey_scene(measurement->options, &measurement->cost->survey, err) &&
           make_standard(measurement, &lit, err) && describe(measurement, lit, err) &&
           measure_configurations(measurement, err) && conclude(measurement->cost, err);
}

bool cost_measure(const struct options *options, struct cost *out, struct error *err)
{
    struct measurement measurement = {.options = options, .folder = {.lock = -1}, .cost = out};
    measurement.shown = progress_start(&measurement.line, options->quiet);
    *out = (struct cost){.scene = NULL};
    const bool done = measure(&measurement, err);
    close_folder(&measurement);
    return done;
}
