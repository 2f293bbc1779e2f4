/* SPDX-License-Identifier: MIT */
/* Stages that work side by side: one makes on this thread, one takes on another. On one thread the
 * stage that takes lets the other one make what it waits for. */
#include "data/base/base.h"

/* Keeps the error of the stage that fails first. */
static void stop(struct pipeline *pipeline, const struct error *err)
{
    pthread_mutex_lock(&pipeline->lock);
    if (!pipeline->stopped)
        pipeline->err = *err;
    pipeline->stopped = true;
    pthread_cond_broadcast(&pipeline->changed);
    pthread_mutex_unlock(&pipeline->lock);
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
    struct error err = {.status = EXIT_AGREED};
    while (pipeline->alone && number > 0 && find(places, number) < 0)
        if (!pipeline->make(pipeline->context, &err)) {
            stop(pipeline, &err);
            return -1;
        }
    pthread_mutex_lock(&pipeline->lock);
    while (!pipeline->stopped && find(places, number) < 0)
        pthread_cond_wait(&pipeline->changed, &pipeline->lock);
    const int place = pipeline->stopped ? -1 : find(places, number);
    pthread_mutex_unlock(&pipeline->lock);
    return place;
}

void places_set(struct places *places, int place, long number)
{
    struct pipeline *pipeline = places->pipeline;
    pthread_mutex_lock(&pipeline->lock);
    places->holds[place] = number;
    pthread_cond_broadcast(&pipeline->changed);
    pthread_mutex_unlock(&pipeline->lock);
}

/* ---- both stages ---- */

static void *take_all(void *of)
{
    struct pipeline *pipeline = of;
    struct error err = {.status = EXIT_AGREED};
    if (!pipeline->take(pipeline->context, &err))
        stop(pipeline, &err);
    return NULL;
}

bool pipeline_run(struct pipeline *pipeline, struct error *err)
{
    struct error failure = {.status = EXIT_AGREED};
    pthread_t thread;
    pthread_mutex_init(&pipeline->lock, NULL);
    pthread_cond_init(&pipeline->changed, NULL);
    memory_allow_stacks();
    if (pipeline->alone || pthread_create(&thread, NULL, take_all, pipeline) != 0) {
        pipeline->alone = true;
        take_all(pipeline);
    } else {
        while (pipeline->make(pipeline->context, &failure)) {
        }
        if (failure.status != EXIT_AGREED)
            stop(pipeline, &failure);
        pthread_join(thread, NULL);
    }
    pthread_cond_destroy(&pipeline->changed);
    pthread_mutex_destroy(&pipeline->lock);
    if (pipeline->stopped)
        *err = pipeline->err;
    return !pipeline->stopped;
}
