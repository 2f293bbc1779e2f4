/* SPDX-License-Identifier: MIT */
/* WebAssembly has no processes and no signals: the work is done in place. The browser's page runs
 * each command in an instance of its own, and throws that away to end the command. */
#include <string.h>

#include "data/process/process.h"

int guard_run(int (*work)(void *of), void *of)
{
    return work(of);
}

bool is_interrupted(void)
{
    return false;
}

bool process_run(bool (*job)(void *context, void *out, struct error *err), void *context, void *out,
                 size_t size, struct error *err)
{
    (void)size;
    return job(context, out, err);
}

bool process_start(const char *const *words, struct running_program *out, struct error *err)
{
    (void)out;
    errno = 0;
    return error_system(err, "%s: this system has no processes", words[0]);
}

bool process_await(const struct running_program *program, struct run_seconds *out,
                   struct error *err)
{
    (void)program, (void)out;
    errno = 0;
    return error_system(err, "this system has no processes");
}

bool process_program(const char *const *words, struct run_seconds *out, struct error *err)
{
    struct running_program program;
    *out = (struct run_seconds){.wall = 0};
    return process_start(words, &program, err);
}

const char *program_file(const char *link, const char *typed)
{
    (void)link;
    return typed;
}
