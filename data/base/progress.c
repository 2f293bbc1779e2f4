/* SPDX-License-Identifier: MIT */
/* Measures seconds and memory of this process, and shows progress on a terminal. */
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "data/base/base.h"

/* The shortest time between two lines of progress. */
static const double pause_s = 0.1;

static double seconds_of(clockid_t clock)
{
    struct timespec time = {0};
    clock_gettime(clock, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

double clock_seconds(void)
{
    return seconds_of(CLOCK_MONOTONIC);
}

double processor_seconds(void)
{
    return seconds_of(CLOCK_PROCESS_CPUTIME_ID);
}

bool progress_start(struct progress_line *out, bool quiet)
{
    *out = (struct progress_line){.start = clock_seconds()};
    return !quiet && isatty(STDERR_FILENO);
}

void progress_show(struct progress_line *line, long done, long all)
{
    double time = clock_seconds(), elapsed = time - line->start;
    if (done == all)
        fprintf(stderr, "\r%40s\r", "");
    else if (time - line->printed > pause_s) {
        fprintf(stderr, "\r%3ld %%, %.0f s left ", 100 * done / all,
                elapsed * (double)(all - done) / (double)done);
        line->printed = time;
    }
}

uint64_t peak_bytes(void)
{
    struct rusage used;
    return getrusage(RUSAGE_SELF, &used) == 0 ? (uint64_t)used.ru_maxrss * 1024 : 0;
}
