/* SPDX-License-Identifier: MIT */
/* The threads of llvmpipe. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "data/base/base.h"
#include "raster/renderers/renderers.h"

enum { THREAD_NAME = 16 }; /* Linux cuts names of threads to 15 characters */

static void read_name(const char *task, char out[THREAD_NAME])
{
    char path[64];
    int file;
    memset(out, 0, THREAD_NAME);
    snprintf(path, sizeof path, "/proc/self/task/%.16s/comm", task);
    UNTIL_DONE(file, open(path, O_RDONLY | O_CLOEXEC));
    if (file < 0)
        return;
    read_at(file, out, THREAD_NAME - 1, 0);
    close(file);
}

bool driver_count_threads(struct driver_threads *out)
{
    static const char prefix[] = "llvmpipe-";
    char own[THREAD_NAME], name[THREAD_NAME], self[24];
    DIR *tasks = opendir("/proc/self/task");
    *out = (struct driver_threads){0, 0};
    if (!tasks)
        return false;
    snprintf(self, sizeof self, "%ld", (long)getpid());
    read_name(self, own);
    for (const struct dirent *task; (task = readdir(tasks));) {
        read_name(task->d_name, name);
        out->of_llvmpipe += strncmp(name, prefix, strlen(prefix)) == 0;
        out->unnamed += name[0] != '\0' && strcmp(name, own) == 0;
    }
    closedir(tasks);
    return true;
}

/* A new thread may take a moment to name itself; as many threads for compute shaders never do. */
bool driver_has_threads(const char *gl_renderer, const struct driver_threads *before,
                        struct error *err)
{
    const struct timespec pause = {0, 2000000};
    const int patience = 1000, most = 5000; /* pauses: without, and with a thread that is new */
    const char *wanted = getenv("LP_NUM_THREADS");
    const long asked = wanted ? strtol(wanted, NULL, 10) : 0;
    struct driver_threads now = {0, 0};
    if (strncmp(gl_renderer, "llvmpipe", strlen("llvmpipe")) != 0)
        return true;
    for (int i = 0; i < (now.unnamed - before->unnamed > asked ? most : patience); i++) {
        /* llvmpipe has at most 16 threads, in later versions of Mesa at most 32 (LP_MAX_THREADS) */
        if (!driver_count_threads(&now) || now.of_llvmpipe >= asked || now.of_llvmpipe == 16 ||
            now.of_llvmpipe == 32)
            return true;
        nanosleep(&pause, NULL);
    }
    return error_failed(err, "OpenGL has started %ld of its %ld threads", now.of_llvmpipe, asked);
}
