/* SPDX-License-Identifier: MIT */
/* The room "threads": loops that several threads share. A thread that has nothing to do sleeps: it
 * takes no processor from OpenGL, from other programs or from its own process. (OpenMP's threads
 * spin while they wait; only the environment, before the program starts, could forbid it.)
 */
#ifndef THREADS_H
#define THREADS_H

#include <pthread.h>

#include "spectral.h"

/* ---- loop.c ---- */

enum { MOST_THREADS = 1024 };
/* Returns `wanted`, at most MOST_THREADS; 0 stands for the number of processors that this process
 * may run on. */
int threads_count(int wanted);
/* Returns how many of n_threads threads are worth waking for n items, where a thread should have at
 * least `least` of them: at least 1. */
int threads_for(int n_threads, size_t n, size_t least);
/* Calls work(context, i) once for each i below n, on n_threads threads, this one included, and
 * returns after the last call. A thread takes the next i as soon as it is free. Where the system
 * starts fewer threads, those that there are do the work. */
void threads_each(int n_threads, int n, void (*work)(void *context, int i), void *context);
/* Does the same for n items in blocks of `block`: calls work(context, first, end) for the items
 * first .. end - 1. */
void threads_blocks(int n_threads, size_t n, size_t block,
                    void (*work)(void *context, size_t first, size_t end), void *context);

/* A number that several threads add to; COUNTER begins it. */
struct counter {
    pthread_mutex_t lock;
    uint64_t n;
};
#define COUNTER                                                                                    \
    {                                                                                              \
        PTHREAD_MUTEX_INITIALIZER, 0                                                               \
    }
void counter_add(struct counter *to, uint64_t n);

#endif
