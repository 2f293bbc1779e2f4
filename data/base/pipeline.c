/* SPDX-License-Identifier: MIT */
/* Stages that work side by side. A thread works with the lock open, and holds it only to look at
 * queues. Where stages work one at a time, it is the other way round: a thread holds the lock while
 * it works, and opens it where it waits. Where the system has no threads, the first of two stages
 * runs until a queue that it fills has no free place: then the last one takes what is there. */
#include "data/base/base.h"

/* Begin and end the use of queues. */
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
    pthread_t thread;
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

/* Waits until another stage has changed a queue. Without threads the last stage works meanwhile. */
static void wait_for_change(struct pipeline *pipeline)
{
    if (!pipeline->last) {
        pthread_cond_wait(&pipeline->changed, &pipeline->lock);
        return;
    }
    pthread_mutex_unlock(&pipeline->lock);
    run_stage(pipeline->last);
    pthread_mutex_lock(&pipeline->lock);
}

/* ---- queues ---- */

int queue_room(struct queue *queue)
{
    struct pipeline *pipeline = queue->pipeline;
    begin_use(pipeline);
    while (!pipeline->stopped && queue->filled - queue->freed == queue->n_places)
        wait_for_change(pipeline);
    const int place = pipeline->stopped ? -1 : (int)(queue->filled % queue->n_places);
    end_use(pipeline);
    return place;
}

int queue_next(struct queue *queue, int ahead)
{
    struct pipeline *pipeline = queue->pipeline;
    begin_use(pipeline);
    while (!pipeline->stopped && !queue->ended && !pipeline->last &&
           queue->filled - queue->freed <= ahead)
        wait_for_change(pipeline);
    const bool none = pipeline->stopped || queue->filled - queue->freed <= ahead;
    const int place = none ? -1 : (int)((queue->freed + ahead) % queue->n_places);
    end_use(pipeline);
    return place;
}

void queue_fill(struct queue *queue)
{
    begin_use(queue->pipeline);
    queue->filled++;
    end_use(queue->pipeline);
}

void queue_free(struct queue *queue)
{
    begin_use(queue->pipeline);
    queue->freed++;
    end_use(queue->pipeline);
}

void queue_end(struct queue *queue)
{
    begin_use(queue->pipeline);
    queue->ended = true;
    end_use(queue->pipeline);
}

/* ---- all stages ---- */

/* Starts all stages but the first. Returns how many run. */
static int start(struct worker *workers, int n)
{
    int running = 1;
    memory_allow_stacks();
    while (running < n && (errno = pthread_create(&workers[running].thread, NULL, run_stage,
                                                  &workers[running])) == 0)
        running++;
    return running;
}

bool pipeline_run(struct pipeline *out, bool alone, pipeline_stage *const stages[], int n,
                  void *context, struct error *err)
{
    struct worker workers[MOST_STAGES];
    *out = (struct pipeline){.alone = alone};
    pthread_mutex_init(&out->lock, NULL);
    pthread_cond_init(&out->changed, NULL);
    for (int i = 0; i < n; i++)
        workers[i] =
            (struct worker){.pipeline = out, .work = stages[i], .context = context, .err = err};
    const int running = start(workers, n);
    if (running < n && errno == ENOSYS && n == 2) {
        out->last = &workers[1];
    } else if (running < n) {
        pthread_mutex_lock(&out->lock);
        out->stopped = !error_system(err, "cannot start a thread");
        pthread_mutex_unlock(&out->lock);
    }
    run_stage(&workers[0]);
    if (out->last && !out->stopped)
        run_stage(out->last);
    for (int i = 1; i < running; i++)
        pthread_join(workers[i].thread, NULL);
    pthread_cond_destroy(&out->changed);
    pthread_mutex_destroy(&out->lock);
    return !out->stopped;
}
