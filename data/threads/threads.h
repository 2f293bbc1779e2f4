/* SPDX-License-Identifier: MIT */
/* The room "threads": loops that several threads share, and stages that work side by side. A thread
 * that has nothing to do sleeps: it takes no processor from OpenGL, from other programs or from its
 * own process. (OpenMP's threads spin while they wait; only the environment, before the program
 * starts, could forbid it.)
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

/* ---- pipeline.c: stages that work side by side, one on what another has made ---- */

/* Stages share it. If `alone`, one stage works at a time, until it waits: there is one thread. */
struct pipeline {
    bool alone;
    bool stopped; /* a stage has failed */
    pthread_mutex_t lock;
    pthread_cond_t changed;
    const struct rest *rest; /* of no_threads.c */
};
/* A part of the work; false: it failed, or the pipeline has stopped. */
typedef bool stage(void *context, struct error *err);
enum { MOST_STAGES = 3 };
/* Runs the stages at the same time, the first one on this thread, and returns when all have ended.
 * If a stage fails, the others stop where they wait for it, and *err is the error of the first. */
bool pipeline_run(struct pipeline *out, bool alone, stage *const stages[], int n, void *context,
                  struct error *err);

/* A row of places that one stage fills in turn, and another takes and frees in the same order. It
 * says only which places are full; their contents belong to the stages. Zero it, but for the first
 * two members, before the pipeline runs. */
struct queue {
    struct pipeline *pipeline;
    int n_places;
    long filled, freed; /* how many so far */
    bool ended;         /* nothing is filled any more */
};
/* Return a place, or -1 where the pipeline has stopped. The first waits for a free place. The
 * second waits until there are more than `ahead` full places, and returns the one behind these; -1
 * also where the queue ends before. */
int queue_room(struct queue *queue);
int queue_next(struct queue *queue, int ahead);
/* Say that the place is full; that the place that was filled first is free; that no other follows.
 */
void queue_fill(struct queue *queue);
void queue_free(struct queue *queue);
void queue_end(struct queue *queue);

#endif
