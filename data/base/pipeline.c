/* SPDX-License-Identifier: MIT */
/* Stages that work side by side. A thread works with the lock open, and holds it only to look at
 * places. Where stages work one at a time, it is the other way round: a thread holds the lock while
 * it works, and opens it where it waits. */
#include "data/base/base.h"

/* Begin and end the use of places. */
static void begin_use(struct pipeline *pipeline)
{
    if (!pipeline->alone)
        pthread_mutex_lock(&pipeline->lock);
}

static void end_use(struct pipeline *pipeline)
{
    pthread_cond_broadcast(&pipeline->changed);
    if (!pipeline->alone)
        pthread_mutex_unlock(&pipeline->lock);
}

/* ---- a stage on its way ---- */

struct worker {
    struct pipeline *pipeline;
    pipeline_stage *work;
    void *context;
    struct error *err; /* of the first stage that fails */
};

static void *run_stage(void *of)
{
    const struct worker *worker = of;
    struct pipeline *pipeline = worker->pipeline;
    struct error err = {.status = EXIT_AGREED};
    if (pipeline->alone)
        pthread_mutex_lock(&pipeline->lock);
    const bool done = worker->work(worker->context, &err);
    begin_use(pipeline);
    if (!done && !pipeline->stopped) {
        pipeline->stopped = true;
        *worker->err = err;
    }
    end_use(pipeline);
    if (pipeline->alone)
        pthread_mutex_unlock(&pipeline->lock);
    return NULL;
}

/* ---- places ---- */

static int find(const struct places *places, long number)
{
    for (int i = 0; i < places->n; i++)
        if (places->holds[i] == number)
            return i;
    return -1;
}

int places_wait(struct places *places, long number)
{
    struct pipeline *pipeline = places->pipeline;
    begin_use(pipeline);
    while (!pipeline->stopped && find(places, number) < 0)
        pthread_cond_wait(&pipeline->changed, &pipeline->lock);
    const int place = pipeline->stopped ? -1 : find(places, number);
    end_use(pipeline);
    return place;
}

void places_set(struct places *places, int place, long number)
{
    begin_use(places->pipeline);
    places->holds[place] = number;
    end_use(places->pipeline);
}

/* ---- both stages ---- */

bool pipeline_run(struct pipeline *out, bool alone, pipeline_stage *here, pipeline_stage *beside,
                  void *context, struct error *err)
{
    struct worker first = {out, here, context, err}, second = {out, beside, context, err};
    pthread_t thread;
    *out = (struct pipeline){.alone = alone};
    pthread_mutex_init(&out->lock, NULL);
    pthread_cond_init(&out->changed, NULL);
    memory_allow_stacks();
    errno = pthread_create(&thread, NULL, run_stage, &second);
    if (errno == 0) {
        run_stage(&first);
        pthread_join(thread, NULL);
    } else
        out->stopped = !error_system(err, "cannot start a thread");
    pthread_cond_destroy(&out->changed);
    pthread_mutex_destroy(&out->lock);
    return !out->stopped;
}
