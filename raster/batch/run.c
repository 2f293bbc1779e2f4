/* SPDX-License-Identifier: MIT */
/* Runs the lines of a batch, several at a time. Each is this program again, with --update, so that
 * a render that fails, or is ended, takes no other with it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "data/threads/threads.h"
#include "raster/batch/batch.h"

/* A file as it was before a render. A new one has another number. */
struct before {
    bool there;
    dev_t device;
    ino_t number;
    struct timespec changed;
};

static struct before look(const char *path)
{
    struct stat status;
    if (stat(path, &status) != 0)
        return (struct before){.there = false};
    return (struct before){true, status.st_dev, status.st_ino, status.st_mtim};
}

static bool is_same(const struct before *a, const struct before *b)
{
    return a->there && b->there && a->device == b->device && a->number == b->number &&
           a->changed.tv_sec == b->changed.tv_sec && a->changed.tv_nsec == b->changed.tv_nsec;
}

/* The words before those of a line, which may say otherwise. */
enum { COMMON_WORDS = 8 };
struct common {
    char threads[16], memory[16];
    const char *words[COMMON_WORDS];
    int n;
};

static void find_common(const struct batch_run *run, struct common *out)
{
    const char *const first[] = {run->program, "render",     "--update", "--quiet",
                                 "--threads",  out->threads, "--memory", out->memory};
    snprintf(out->threads, sizeof out->threads, "%d", run->threads);
    snprintf(out->memory, sizeof out->memory, "%d", run->memory_mib);
    memcpy(out->words, first, sizeof first);
    out->n = run->memory_mib > 0 ? COMMON_WORDS : COMMON_WORDS - 2;
}

/* Makes the words of a command, which end with NULL; the array is allocated. NULL: no memory. */
static const char **make_words(const struct common *common, const struct batch_line *line)
{
    const char **words = calloc((size_t)(common->n + line->n_words) + 1, sizeof *words);
    for (int i = 0; words && i < common->n; i++)
        words[i] = common->words[i];
    for (int i = 0; words && i < line->n_words; i++)
        words[common->n + i] = line->words[i];
    return words;
}

/* Runs a command and waits for its end. */
static bool run_words(struct batch_run *run, const char *const *words, double *seconds,
                      struct error *err)
{
    struct running_program program;
    struct run_seconds took = {.wall = 0};
    pthread_mutex_lock(&run->lock);
    const bool started = process_start(words, &program, err);
    pthread_mutex_unlock(&run->lock);
    const bool done = started && process_await(&program, &took, err);
    *seconds = took.wall;
    return done;
}

static void run_line(void *of, int i)
{
    struct batch_run *run = of;
    struct batch_line *line = &run->batch->lines[i];
    struct common common;
    if (is_interrupted())
        return;
    find_common(run, &common);
    const struct before before = look(line->output);
    const char **words = make_words(&common, line);
    const bool done =
        words ? run_words(run, words, &line->seconds, &line->err) : error_memory(&line->err);
    free(words);
    const struct before after = look(line->output);
    if (is_interrupted())
        return;
    pthread_mutex_lock(&run->lock);
    line->state = !done ? LINE_FAILED : is_same(&before, &after) ? LINE_CURRENT : LINE_DRAWN;
    run->ended(run->of, line, ++run->n_ended);
    pthread_mutex_unlock(&run->lock);
}

bool batch_run(struct batch_run *run, struct error *err)
{
    if (pthread_mutex_init(&run->lock, NULL) != 0)
        return error_memory(err);
    run->n_ended = 0;
    threads_each(run->jobs, run->batch->n_lines, run_line, run);
    pthread_mutex_destroy(&run->lock);
    errno = 0;
    return !is_interrupted() ||
           error_system(err, "interrupted; the next batch draws the missing stacks");
}
