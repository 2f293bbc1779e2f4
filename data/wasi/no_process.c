/* SPDX-License-Identifier: MIT */
/* WebAssembly has no processes and no signals: the work is done in place. The browser's page runs
 * each command in an instance of its own, and throws that away to end the command. */
#include <stdlib.h>

#include "data/base/inside.h"

void guard_begin(void)
{
}

void guard_exit(int status)
{
    exit(status);
}

bool guard_remove(const char *path)
{
    return path != NULL;
}

void guard_forget(const char *path)
{
    (void)path;
}

void guard_hold(void)
{
}

void guard_release(void)
{
}

bool is_interrupted(void)
{
    return false;
}

bool process_run(process_job *job, void *context, void *out, size_t size, unsigned limit_s,
                 struct error *err)
{
    (void)size;
    (void)limit_s;
    return job(context, out, err);
}

bool process_program(const char *const *words, struct run_seconds *out, struct error *err)
{
    *out = (struct run_seconds){.wall = 0};
    return error_failed(err, "%s: this system has no processes", words[0]);
}
