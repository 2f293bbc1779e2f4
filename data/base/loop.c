/* SPDX-License-Identifier: MIT */
/* Loops that several threads share. */
#define _GNU_SOURCE /* sched_getaffinity */
#include <sched.h>
#include <unistd.h>

#include "data/base/inside.h"

/* Returns 0 where the system does not say. */
static int count_processors(void)
{
#ifdef __linux__
    cpu_set_t allowed;
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0)
        return CPU_COUNT(&allowed);
#endif
    return (int)sysconf(_SC_NPROCESSORS_ONLN);
}

int threads_count(int wanted)
{
    const int n = wanted > 0 ? wanted : count_processors();
    return n < 1 ? 1 : n < MOST_THREADS ? n : MOST_THREADS;
}

uint64_t counter_add(struct counter *to, uint64_t n)
{
    pthread_mutex_lock(&to->lock);
    const uint64_t before = to->n;
    to->n += n;
    pthread_mutex_unlock(&to->lock);
    return before;
}

struct loop {
    void (*work)(void *context, int i);
    void *context;
    int n;
    struct counter next;
};

static void *run(void *of)
{
    struct loop *loop = of;
    for (uint64_t i; (i = counter_add(&loop->next, 1)) < (uint64_t)loop->n;)
        loop->work(loop->context, (int)i);
    return NULL;
}

void threads_each(int n_threads, int n, void (*work)(void *context, int i), void *context)
{
    struct loop loop = {work, context, n, COUNTER};
    pthread_t others[MOST_THREADS];
    const int most = n_threads < n ? n_threads : n;
    int n_others = 0;
    if (most > 1)
        memory_allow_stacks();
    while (n_others < most - 1 && pthread_create(&others[n_others], NULL, run, &loop) == 0)
        n_others++;
    run(&loop);
    for (int i = 0; i < n_others; i++)
        pthread_join(others[i], NULL);
}
