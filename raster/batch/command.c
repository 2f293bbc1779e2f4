/* SPDX-License-Identifier: MIT */
/* spectral batch: prints a line for each render that has ended, and sums them up at the end. */
#include <unistd.h>

#include "data/threads/threads.h"
#include "raster/batch/batch.h"

/* A line's state, for people and for programs. */
static const char *const state_words[] = {[LINE_WAITS] = "not drawn",
                                          [LINE_CURRENT] = "up to date",
                                          [LINE_DRAWN] = "drawn",
                                          [LINE_FAILED] = "failed"};

struct batch_sums {
    int of[LINE_FAILED + 1];
    enum exit_status worst; /* of the lines that failed */
    double seconds;
};

/* ---- while it runs ---- */

struct printing {
    const struct batch *batch;
    int to; /* a descriptor */
    bool quiet;
};

/* A reader that has closed the pipe misses lines, and the batch goes on. */
static void print_ended(void *of, const struct batch_line *line, int n_ended)
{
    const struct printing *printing = of;
    struct printed printed = {.text = NULL};
    struct error ignored = {.status = EXIT_AGREED};
    if (printing->quiet)
        return;
    print(&printed, "%d/%d %-10s %8.2f s  %s", n_ended, printing->batch->n_lines,
          state_words[line->state], line->seconds, line->output);
    if (line->state == LINE_FAILED)
        print(&printed, ": %s", error_words(&line->err));
    print_text(&printed, "\n");
    printed_show(&printed, printing->to, &ignored);
}

/* ---- at the end ---- */

static struct batch_sums sum_up(const struct batch *batch, double seconds)
{
    struct batch_sums sums = {.seconds = seconds};
    for (int i = 0; i < batch->n_lines; i++) {
        const struct batch_line *line = &batch->lines[i];
        sums.of[line->state]++;
        if (line->state == LINE_FAILED && line->err.status > sums.worst)
            sums.worst = line->err.status;
    }
    return sums;
}

static void print_sums(const struct batch *batch, const struct batch_sums *sums, struct printed *to)
{
    print(to, "summary           %d renders: %d drawn, %d up to date, %d failed; %.1f s\n",
          batch->n_lines, sums->of[LINE_DRAWN], sums->of[LINE_CURRENT], sums->of[LINE_FAILED],
          sums->seconds);
}

static void print_failed(const struct options *options, const struct batch *batch,
                         struct printed *to)
{
    for (int i = 0; i < batch->n_lines; i++)
        if (batch->lines[i].state == LINE_FAILED)
            batch_print_command(options->program, &batch->lines[i], to);
}

static void json_line(const struct batch_line *line, struct json *json)
{
    json_open(json, NULL, '{');
    json_count(json, "line", (uint64_t)line->place.line);
    json_open(json, "words", '[');
    for (int i = 0; i < line->n_words; i++)
        json_string(json, NULL, line->words[i]);
    json_close(json, ']');
    json_string(json, "output", line->output);
    json_string(json, "state", state_words[line->state]);
    json_count(json, "exit_status", (uint64_t)line->err.status);
    json_string(json, "message", line->state == LINE_FAILED ? error_words(&line->err) : NULL);
    json_number(json, "seconds", line->seconds);
    json_close(json, '}');
}

/* The file appears also where renders have failed: it is their report. */
static bool write_json(const struct options *options, const struct batch *batch,
                       const struct batch_sums *sums, struct error *err)
{
    struct json json;
    if (!options->json)
        return true;
    json_begin(&json);
    json_open(&json, NULL, '{');
    json_string(&json, "program", PROGRAM);
    json_string(&json, "list", batch->text.path);
    json_open(&json, "lines", '[');
    for (int i = 0; i < batch->n_lines; i++)
        json_line(&batch->lines[i], &json);
    json_close(&json, ']');
    json_count(&json, "drawn", (uint64_t)sums->of[LINE_DRAWN]);
    json_count(&json, "up_to_date", (uint64_t)sums->of[LINE_CURRENT]);
    json_count(&json, "failed", (uint64_t)sums->of[LINE_FAILED]);
    json_number(&json, "seconds", sums->seconds);
    json_close(&json, '}');
    return json_write(&json, options->json, NULL, err);
}

static bool report(const struct options *options, const struct batch *batch,
                   const struct batch_sums *sums, int to, struct error *err)
{
    struct printed printed = {.text = NULL};
    if (!options->quiet)
        print_sums(batch, sums, &printed);
    print_failed(options, batch, &printed);
    if (!printed_show(&printed, to, err) || !write_json(options, batch, sums, err))
        return false;
    if (sums->of[LINE_FAILED] == 0)
        return true;
    error_different(err, "%d of %d renders failed; the commands above repeat them",
                    sums->of[LINE_FAILED], batch->n_lines);
    err->status = sums->worst;
    return false;
}

/* As many renders at a time as there are processors, which share these. */
static int threads_each_render(const struct options *options, int jobs)
{
    const int share = threads_count(0) / jobs;
    return options->threads > 0 ? options->threads : share > 1 ? share : 1;
}

bool command_batch(struct options *options, struct error *err)
{
    struct batch batch;
    const double start = clock_seconds();
    const int to = options_table(options, NULL);
    bool done = batch_read(options, &batch, err) &&
                output_spares(options->json, options->operand, err) &&
                output_can_open(options->json, err);
    if (done) {
        const int jobs = threads_count(options->jobs);
        struct printing printing = {&batch, to, options->quiet};
        struct batch_run run = {.batch = &batch,
                                .program = options->program,
                                .jobs = jobs,
                                .threads = threads_each_render(options, jobs),
                                .memory_mib = options->memory_mib,
                                .ended = print_ended,
                                .of = &printing};
        done = batch_run(&run, err);
    }
    if (done) {
        const struct batch_sums sums = sum_up(&batch, clock_seconds() - start);
        done = report(options, &batch, &sums, to, err);
    }
    batch_free(&batch);
    return done;
}
