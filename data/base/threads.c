/* SPDX-License-Identifier: MIT */
/* Starts the threads of OpenMP. Without OpenMP the program has one thread. */
#ifdef _OPENMP
#include <omp.h>
#endif

#include "data/base/base.h"

int threads_start(int wanted)
{
    int n = wanted > 0 ? wanted : 1;
#ifdef _OPENMP
    n = wanted > 0 ? wanted : omp_get_max_threads();
#pragma omp parallel num_threads(n)
    (void)omp_get_thread_num();
#endif
    return n;
}
