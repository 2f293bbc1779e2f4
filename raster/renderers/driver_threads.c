/* SPDX-License-Identifier: MIT */
/* The threads of llvmpipe. */
#include <dirent.h>
#include <fcntl.h>
#include <time.h>
#include <unistd.h>

#include "data/base/base.h"
#include "raster/renderers/renderers.h"

static const char prefix[] = "llvmpipe-";

/* Returns whether a thread of this process is one of llvmpipe. */
static bool is_of_llvmpipe(const char *task)
{
    char path[64], name[sizeof prefix - 1] = "";
    int file;
    snprintf(path, sizeof path, "/proc/self/task/%.16s/comm", task);
    UNTIL_DONE(file, open(path, O_RDONLY | O_CLOEXEC));
    if (file < 0)
        return false;
    read_at(file, name, sizeof name, 0);
    close(file);
    return memcmp(name, prefix, sizeof name) == 0;
}

/* Counts the threads of llvmpipe. Returns false where they cannot be counted. */
static bool count_threads(long *out)
{
    DIR *tasks = opendir("/proc/self/task");
    *out = 0;
    if (!tasks)
        return false;
    for (const struct dirent *task; (task = readdir(tasks));)
        *out += is_of_llvmpipe(task->d_name);
    closedir(tasks);
    return true;
}

/* A new thread may take a moment to name itself: the last one has ten seconds. */
bool driver_has_threads(const char *gl_renderer, struct error *err)
{
    const struct timespec pause = {0, 2000000};
    const char *wanted = getenv("LP_NUM_THREADS");
    const long asked = wanted ? strtol(wanted, NULL, 10) : 0;
    long n = 0;
    if (strncmp(gl_renderer, "llvmpipe", strlen("llvmpipe")) != 0)
        return true;
    for (int i = 0; i < 5000; i++) {
        /* llvmpipe has at most 16 threads, in later versions of Mesa at most 32 (LP_MAX_THREADS) */
        if (!count_threads(&n) || n >= asked || n == 16 || n == 32)
            return true;
        nanosleep(&pause, NULL);
    }
    return error_failed(err, "OpenGL has started %ld of its %ld threads", n, asked);
}
