/* SPDX-License-Identifier: MIT */
/* Starts the threads of OpenMP. Without OpenMP the program has one thread. */
#ifdef _OPENMP
#include <omp.h>
#include <pthread.h>
#endif

#include "data/base/base.h"

#ifdef _OPENMP
enum { MOST_THREADS = 1024 };

/* Waits until all threads that are tried have been made, or not. */
static void *wait_for(void *gate)
{
    pthread_mutex_lock(gate);
    pthread_mutex_unlock(gate);
    return NULL;
}

/* Returns how many threads, at most so many, the system gives at once, this one included. OpenMP
 * would end the program if it got fewer than it asks for. */
static int count_possible(int wanted)
{
    pthread_t threads[MOST_THREADS];
    pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER;
    int n = 1;
    pthread_mutex_lock(&gate);
    while (n < wanted && n < MOST_THREADS &&
           pthread_create(&threads[n], NULL, wait_for, &gate) == 0)
        n++;
    pthread_mutex_unlock(&gate);
    for (int i = 1; i < n; i++)
        pthread_join(threads[i], NULL);
    return n;
}
#endif

int threads_start(int wanted)
{
    int n = wanted > 0 ? wanted : 1;
#ifdef _OPENMP
    n = count_possible(wanted > 0 ? wanted : omp_get_max_threads());
#pragma omp parallel num_threads(n)
    (void)omp_get_thread_num();
#endif
    return n;
}
