/* SPDX-License-Identifier: MIT */
#include "spectral.h"

#ifdef _OPENMP
#include <omp.h>
#endif

int thread_count(int wanted)
{
    if (wanted > 0)
        return wanted;
#ifdef _OPENMP
    return omp_get_max_threads();
#else
    return 1;
#endif
}
