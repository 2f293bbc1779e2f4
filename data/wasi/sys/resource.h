/* SPDX-License-Identifier: MIT */
/* Stands for the C library's sys/resource.h where WebAssembly has no limits of processes. A command
 * may take a part of the 2 GiB that the module can have. */
#ifndef WASI_RESOURCE_H
#define WASI_RESOURCE_H

typedef unsigned long long rlim_t;
struct rlimit {
    rlim_t rlim_cur;
};
enum { RLIMIT_DATA, RLIMIT_STACK };
#define RLIM_INFINITY (~(rlim_t)0)

static inline int getrlimit(int which, struct rlimit *out)
{
    out->rlim_cur = which == RLIMIT_DATA ? (rlim_t)1324 << 20 : RLIM_INFINITY;
    return 0;
}

static inline int setrlimit(int which, const struct rlimit *limit)
{
    (void)which, (void)limit;
    return 0;
}

struct rusage {
    long ru_maxrss; /* KiB */
};
enum { RUSAGE_SELF };

/* The module's memory never shrinks, so that its size is its peak. */
static inline int getrusage(int whose, struct rusage *out)
{
    (void)whose;
    out->ru_maxrss = (long)(__builtin_wasm_memory_size(0) * 64);
    return 0;
}

#endif
