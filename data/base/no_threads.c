/* SPDX-License-Identifier: MIT */
/* Stages where the system has no threads. A stage runs until a queue that it fills has no
 * free place: then the next stage takes what is there. So only the last of two stages may wait. */
#include "data/base/base.h"

/* ---- queues ---- */

/* The stages that come after the current one. */
struct rest {
    pipeline_stage *const *stages;
    int n;
    void *context;
    struct error *err;
};

/* Lets the next stage take what the queues hold. */
static void run_next(struct pipeline *pipeline)
{
    const struct rest *rest = pipeline->rest;
    if (rest->n > 0 && !rest->stages[0](rest->context, rest->err))
        pipeline->stopped = true;
}

int queue_room(struct queue *queue)
{
    if (queue->filled - queue->freed == queue->n_places)
        run_next(queue->pipeline);
    return queue->pipeline->stopped ? -1 : (int)(queue->filled % queue->n_places);
}

int queue_next(struct queue *queue, int ahead)
{
    const bool none = queue->pipeline->stopped || queue->filled - queue->freed <= ahead;
    return none ? -1 : (int)((queue->freed + ahead) % queue->n_places);
}

void queue_fill(struct queue *queue)
{
    queue->filled++;
}

void queue_free(struct queue *queue)
{
    queue->freed++;
}

void queue_end(struct queue *queue)
{
    queue->ended = true;
}

/* ---- stages ---- */

bool pipeline_run(struct pipeline *out, bool alone, pipeline_stage *const stages[], int n,
                  void *context, struct error *err)
{
    struct rest rest = {stages + 1, n - 1, context, err};
    *out = (struct pipeline){.alone = alone, .rest = &rest};
    if (!stages[0](context, err))
        return false;
    run_next(out);
    return !out->stopped;
}
