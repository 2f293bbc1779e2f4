/* SPDX-License-Identifier: MIT */
/* Runs each configuration of render several times, from exec to exit, and measures the accuracy of
 * its stack. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "raster/beside/cost/inside.h"

enum { DEFAULT_RUNS = 5 };

/* ---- a configuration as a command line of render ---- */

/* Puts the words that cost was given, then those of the entry. The reference alone, whose words are
 * "... --renderer=raster --no-check", has no use for a library of OpenGL. Returns how many. */
static int put_words(const struct options *options, const struct cost_entry *entry,
                     const char *line[])
{
    bool alone = false;
    int n = 0;
    for (int i = 0; i < entry->n_words; i++)
        alone = alone || strcmp(entry->words[i], "--renderer=raster") == 0;
    for (int i = 0; i < options->n_recorded; i++)
        if (!alone || strncmp(options->recorded[i], "--gl=", strlen("--gl=")) != 0)
            line[n++] = options->recorded[i];
    for (int i = 0; i < entry->n_words; i++)
        line[n++] = entry->words[i];
    return n;
}

/* Reads a command line of render: the changes of the scene that cost was given, then the words of
 * the entry. */
static bool read_words(const struct options *options, const struct cost_entry *entry,
                       struct options *out, struct error *err)
{
    const char *line[MOST_RECORDED + COST_WORDS];
    const int n = put_words(options, entry, line);
    if (!options_read(&render_command, false, line, n, out, err))
        return false;
    out->operand = options->operand;
    out->threads = options->threads;
    out->quiet = true;
    return true;
}

enum { FIXED_WORDS = 12 };

/* Adds "NAME=NUMBER" to a command line, in `text`; 0: the user gave none. */
static void add_count(const char *line[], int *n, const char *name, int count, char text[32])
{
    if (count == 0)
        return;
    snprintf(text, 32, "%s=%d", name, count);
    line[(*n)++] = text;
}

/* Runs the program on the scene of the options, with the words of the entry. The scene comes last:
 * its name may begin with a dash. */
static bool run_program(const struct options *options, const struct cost_entry *entry,
                        const char *output, struct run_seconds *out, struct error *err)
{
    const char *line[MOST_RECORDED + COST_WORDS + FIXED_WORDS] = {options->program, "render"};
    char threads[32], memory[32];
    int n = 2 + put_words(options, entry, line + 2);
    add_count(line, &n, "--threads", options->threads, threads);
    add_count(line, &n, "--memory", options->memory_mib, memory);
    const char *const last[] = {"--quiet", "--output", output, "--", options_scene(options), NULL};
    memcpy(line + n, last, sizeof last);
    return process_program(line, out, err);
}

struct measurement {
    const struct options *options;
    struct progress_line line;
    bool shown; /* the line of progress */
    struct folder folder;
    char stack[sizeof(struct folder) + 16]; /* a file in it */
    struct summary standard;
    long steps, all_steps;
    const struct cost_entry *entry; /* at hand */
    struct cost *cost;
};

static void step(struct measurement *measurement, long steps)
{
    measurement->steps += steps;
    if (measurement->shown && measurement->steps > 0)
        progress_show(&measurement->line, measurement->steps, measurement->all_steps);
}

/* Surveys the scene, and refuses a detector that is no observer. Without --detector, which needs a
 * sampling, the options of cost are those of render that change the scene. */
static bool survey(const struct measurement *measurement, struct error *err)
{
    struct options plain = *measurement->options;
    struct detector observer = {.name = NULL};
    struct render_job job = {.options = {.threads = 0}};
    struct cost *cost = measurement->cost;
    plain.detector = NULL;
    cost->observer = options_detector(measurement->options);
    const bool done = observer_read(cost->observer, &observer, err) &&
                      scene_read_sampled(&plain, &job.scene, &job.sampling, err) &&
                      survey_scene(&job.scene, measurement->options, cost, err);
    detector_free(&observer);
    job_free(&job);
    return done;
}

/* Renders the entry at hand to the stack, and measures that. It runs in a process of its own: the
 * error then says whether the system lacks what the entry needs, where a program has words only. */
static bool measure_job(void *context, void *out, struct error *err)
{
    struct measurement *measurement = context;
    struct options own = {.operand = NULL};
    struct render_job job = {.options = {.threads = 0}};
    bool done = read_words(measurement->options, measurement->entry, &own, err);
    own.output = measurement->stack;
    done = done && render_command.run(&own, err) && outputs_commit(&own.outputs, err) &&
           scene_read_sampled(&own, &job.scene, &job.sampling, err) &&
           standard_compare(measurement->stack, &job.sampling, &measurement->standard, out, err);
    job_free(&job);
    options_free(&own);
    return done;
}

/* ---- configurations ---- */

/* Removes the stack, if there is one: the next one gets its name. */
static bool remove_stack(const struct measurement *measurement, struct error *err)
{
    return unlink(measurement->stack) == 0 || errno == ENOENT ||
           error_system(err, "cannot remove %s", measurement->stack);
}

/* Renders the standard, and summarizes its stack. A failure that names a temporary file is for want
 * of room. */
static bool make_standard(struct measurement *measurement, struct error *err)
{
    struct cost_entry entry = standard_entry(measurement->cost);
    struct error own = {.status = EXIT_AGREED};
    struct run_seconds seconds = {.wall = 0};
    const bool done =
        entry_words(&entry, measurement->cost->observer, &own) &&
        run_program(measurement->options, &entry, measurement->stack, &seconds, &own) &&
        standard_summarize(measurement->stack, &measurement->standard, &own);
    measurement->cost->standard_seconds = seconds.wall;
    cost_entry_free(&entry);
    if (!remove_stack(measurement, err))
        return false;
    if (strstr(own.text, measurement->folder.path))
        error_failed(err, "%s; set TMPDIR to a folder with more room", error_words(&own));
    else if (!done)
        *err = own;
    return done;
}

/* Runs a configuration once and measures its stack. A configuration that is refused, or that this
 * system does not support, becomes a note. */
static bool warm_up(struct measurement *measurement, struct cost_entry *entry, struct error *err)
{
    struct error own = {.status = EXIT_AGREED};
    measurement->entry = entry;
    if (!entry_words(entry, measurement->cost->observer, err))
        return false;
    const bool done =
        process_run(measure_job, measurement, &entry->accuracy, sizeof entry->accuracy, &own);
    if (!remove_stack(measurement, err))
        return false;
    step(measurement, 2);
    if (!done && own.status == EXIT_SYSTEM && !own.unsupported) {
        *err = own;
        return false;
    }
    if (!done)
        return cost_note(measurement->cost, err, "without %s: %s", entry->name, error_words(&own));
    return MAKE_ARRAY(entry->times, measurement->cost->runs, err, "the seconds of runs");
}

/* Adds configurations and warms them up. `add` may choose by the errors measured before. */
static bool warm_up_more(struct measurement *measurement, void (*add)(struct cost *cost),
                         struct error *err)
{
    struct cost *cost = measurement->cost;
    const int first = cost->n;
    add(cost);
    for (int i = first; i < cost->n; i++)
        if (!warm_up(measurement, &cost->entries[i], err))
            return false;
    return true;
}

/* Removes the entries that failed. */
static void remove_failed(struct cost *cost)
{
    int n = 0;
    for (int i = 0; i < cost->n; i++)
        if (cost->entries[i].accuracy.n_pages > 0)
            cost->entries[n++] = cost->entries[i];
        else
            cost_entry_free(&cost->entries[i]);
    cost->n = n;
}

/* ---- the estimate ---- */

/* Most scenes have about so many configurations. */
static int likely_configurations(const struct cost *cost)
{
    return cost->tessellated ? 52 : 36;
}

/* A run takes some time to start, and this part of the standard's seconds on average; a comparison
 * takes another part. data/doc/accuracy.md compares estimates with measurements. */
static const double start_seconds = 0.03, run_part = 0.2, compare_part = 0.8;

static double estimate(const struct cost *cost)
{
    const double parts = cost->positions > 1 ? 2 : 1, /* the standard has more positions */
        standard = cost->standard_seconds / parts, runs = 1 + cost->runs;
    return likely_configurations(cost) *
           (runs * (start_seconds + run_part * standard) + compare_part * standard);
}

/* Says how long the measurement is likely to take, before the first configuration. */
static bool announce(const struct measurement *measurement, struct error *err)
{
    const struct cost *cost = measurement->cost;
    const double seconds = estimate(cost);
    const bool is_long = seconds >= 90;
    struct printed line = {.text = NULL};
    if (measurement->options->quiet)
        return true;
    print(&line, "about %.0f %s, for %d runs of about %d configurations\n",
          is_long ? seconds / 60 : seconds, is_long ? "min" : "s", cost->runs,
          likely_configurations(cost));
    return printed_show(&line, STDERR_FILENO, err);
}

/* ---- rounds ---- */

static int by_clock(const void *a, const void *b)
{
    const double one = ((const struct run_seconds *)a)->wall,
                 two = ((const struct run_seconds *)b)->wall;
    return (one > two) - (one < two);
}

static int by_processor(const void *a, const void *b)
{
    const double one = ((const struct run_seconds *)a)->processor,
                 two = ((const struct run_seconds *)b)->processor;
    return (one > two) - (one < two);
}

/* Finds medians and extremes of the times of n runs. */
static void take_seconds(struct cost_entry *entry, int n)
{
    struct run_seconds *times = entry->times;
    qsort(times, (size_t)n, sizeof *times, by_processor);
    entry->processor = (times[(n - 1) / 2].processor + times[n / 2].processor) / 2;
    qsort(times, (size_t)n, sizeof *times, by_clock);
    entry->seconds = (times[(n - 1) / 2].wall + times[n / 2].wall) / 2;
    entry->fastest = times[0].wall;
    entry->slowest = times[n - 1].wall;
}

/* Runs all configurations in turn, so that a slow moment of the machine meets all of them. */
static bool run_round(struct measurement *measurement, int round, struct error *err)
{
    for (int i = 0; i < measurement->cost->n; i++) {
        struct cost_entry *entry = &measurement->cost->entries[i];
        if (!run_program(measurement->options, entry, measurement->stack, &entry->times[round],
                         err) ||
            !remove_stack(measurement, err))
            return false;
        step(measurement, 1);
    }
    return true;
}

static bool measure_all(struct measurement *measurement, struct error *err)
{
    struct cost *cost = measurement->cost;
    measurement->all_steps = (long)likely_configurations(cost) * (2 + cost->runs);
    if (!warm_up_more(measurement, configurations_first, err) ||
        !warm_up_more(measurement, configurations_samplings, err) ||
        !survey_notes(cost, measurement->standard.lit, err))
        return false;
    configurations_choose(cost);
    if (!warm_up_more(measurement, configurations_styles, err) ||
        !warm_up_more(measurement, configurations_combined, err))
        return false;
    remove_failed(cost);
    measurement->all_steps = measurement->steps + (long)cost->n * cost->runs;
    for (int round = 0; round < cost->runs; round++)
        if (!run_round(measurement, round, err))
            return false;
    for (int i = 0; i < cost->n; i++)
        take_seconds(&cost->entries[i], cost->runs);
    return true;
}

/* ---- conclusions ---- */

static int by_seconds(const void *a, const void *b)
{
    const struct cost_entry *one = a, *two = b;
    return (one->seconds > two->seconds) - (one->seconds < two->seconds);
}

static bool conclude(struct cost *cost, struct error *err)
{
    qsort(cost->entries, (size_t)cost->n, sizeof *cost->entries, by_seconds);
    cost_mark(cost);
    return cost->n > 0 || error_failed(err, "no configuration could be rendered: %s",
                                       cost->n_notes > 0 ? cost->notes[cost->n_notes - 1] : "");
}

static bool measure(struct measurement *measurement, struct error *err)
{
    const struct cost_options *own = measurement->options->own;
    struct cost *cost = measurement->cost;
    cost->runs = own->runs ? own->runs : DEFAULT_RUNS;
    if (!survey(measurement, err) || !folder_open(&measurement->folder, err))
        return false;
    snprintf(measurement->stack, sizeof measurement->stack, "%s/stack.tif",
             measurement->folder.path);
    guard_remove(measurement->stack);
    return make_standard(measurement, err) &&
           MAKE_ARRAY(cost->entries, MOST_CONFIGURATIONS, err, "the table of configurations") &&
           announce(measurement, err) && measure_all(measurement, err) && conclude(cost, err);
}

bool cost_measure(const struct options *options, struct cost *out, struct error *err)
{
    struct measurement measurement = {
        .options = options,
        .standard = {.observer = options_detector(options), .threads = options->threads},
        .cost = out};
    measurement.shown = progress_start(&measurement.line, options->quiet);
    *out = (struct cost){.scene = NULL};
    const bool done = measure(&measurement, err);
    guard_forget(measurement.stack);
    folder_close(&measurement.folder);
    summary_free(&measurement.standard);
    return done;
}
