/* SPDX-License-Identifier: MIT */
/* Stands for the C library's pthread.h where WebAssembly has no threads. One thread never waits for
 * a lock, so locks do nothing. */
#ifndef WASI_PTHREAD_H
#define WASI_PTHREAD_H

#include <sys/types.h> /* pthread_mutex_t, pthread_cond_t */

#define PTHREAD_MUTEX_INITIALIZER                                                                  \
    {                                                                                              \
        {                                                                                          \
            {                                                                                      \
                0                                                                                  \
            }                                                                                      \
        }                                                                                          \
    }

static inline int pthread_mutex_init(pthread_mutex_t *lock, const void *attributes)
{
    (void)lock, (void)attributes;
    return 0;
}

static inline int pthread_mutex_lock(pthread_mutex_t *lock)
{
    (void)lock;
    return 0;
}

static inline int pthread_mutex_unlock(pthread_mutex_t *lock)
{
    (void)lock;
    return 0;
}

static inline int pthread_mutex_destroy(pthread_mutex_t *lock)
{
    (void)lock;
    return 0;
}

#endif
