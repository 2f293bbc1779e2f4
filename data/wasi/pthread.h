/* SPDX-License-Identifier: MIT */
/* Stands for the C library's pthread.h where WebAssembly has no threads. One thread never waits for
 * a lock, so locks do nothing. */
#ifndef WASI_PTHREAD_H
#define WASI_PTHREAD_H

#include <errno.h>
#include <sys/types.h> /* pthread_t, pthread_mutex_t, pthread_cond_t */

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

/* No thread starts: loops and pipelines then work on the one that there is. */
static inline int pthread_create(pthread_t *out, const void *attributes, void *(*work)(void *of),
                                 void *of)
{
    (void)out, (void)attributes, (void)work, (void)of;
    return ENOSYS;
}

static inline int pthread_join(pthread_t thread, void **result)
{
    (void)thread, (void)result;
    return 0;
}

static inline int pthread_cond_init(pthread_cond_t *changed, const void *attributes)
{
    (void)changed, (void)attributes;
    return 0;
}

static inline int pthread_cond_broadcast(pthread_cond_t *changed)
{
    (void)changed;
    return 0;
}

static inline int pthread_cond_wait(pthread_cond_t *changed, pthread_mutex_t *lock)
{
    (void)changed, (void)lock;
    return 0;
}

static inline int pthread_cond_destroy(pthread_cond_t *changed)
{
    (void)changed;
    return 0;
}

#endif
