/* SPDX-License-Identifier: MIT */
/* The threads of OpenMP, without which the program has one. */
#ifdef _OPENMP
#include <omp.h>
#endif

#include "data/base/base.h"

/* Threads inherit which signals are held back from the one that starts them, and keep it. */
int threads_start(int wanted)
{
    int n = wanted > 0 ? wanted : 1;
#ifdef _OPENMP
    void *held = signals_hold();
    n = wanted > 0 ? wanted : omp_get_max_threads();
#pragma omp parallel num_threads(n)
    (void)omp_get_thread_num();
    signals_release(held);
#endif
    return n;
}
