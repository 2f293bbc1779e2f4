/* SPDX-License-Identifier: MIT */
/* Runs a job in a process of its own, which sends its result through a pipe. */
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "data/process/process.h"

/* The job sends this first, then its own bytes. */
struct reply {
    bool done;
    struct error err;
};

/* Reads all bytes. Fails if the pipe ends before the last one, or at an interruption. */
static bool read_all(int from, void *bytes, size_t length)
{
    for (size_t got = 0; got < length;) {
        struct pollfd ready = {.fd = from, .events = POLLIN};
        if (is_interrupted())
            return false;
        int n;
        ssize_t more;
        UNTIL_DONE(n, poll(&ready, 1, LOOK_MS));
        if (n < 0)
            return false;
        if (n == 0)
            continue;
        UNTIL_DONE(more, read(from, (char *)bytes + got, length - got));
        if (more <= 0)
            return false;
        got += (size_t)more;
    }
    return true;
}

/* Reads the job's result, and waits until its process ends. */
static bool await(pid_t child, int from, void *out, size_t size, struct error *err)
{
    struct reply reply;
    int status = 0;
    const bool whole = read_all(from, &reply, sizeof reply) && read_all(from, out, size);
    const bool interrupted = !whole && is_interrupted();
    pid_t ended;
    if (!whole)
        kill(child, SIGKILL);
    UNTIL_DONE(ended, waitpid(child, &status, 0));
    (void)ended;
    errno = 0;
    if (interrupted)
        return error_system(err, "interrupted; nothing was written");
    if (!whole)
        return error_system(err, "a run ended without a result%s%s",
                            WIFSIGNALED(status) ? ": " : "",
                            WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "");
    if (!reply.done)
        *err = reply.err;
    return reply.done;
}

bool process_run(bool (*job)(void *context, void *out, struct error *err), void *context, void *out,
                 size_t size, struct error *err)
{
    int ends[2];
    fflush(NULL);
    if (pipe(ends) != 0)
        return error_system(err, "cannot make a pipe");
    const pid_t parent = getpid(), child = fork();
    if (child == 0) {
        struct reply reply = {.done = false};
        close(ends[0]);
        if (!process_follow(parent))
            _exit(EXIT_SYSTEM);
        reply.done = job(context, out, &reply.err);
        _exit(!(write_all(ends[1], &reply, sizeof reply) && write_all(ends[1], out, size)));
    }
    close(ends[1]);
    const bool done = child > 0 ? await(child, ends[0], out, size, err)
                                : error_system(err, "cannot start a process");
    close(ends[0]);
    return done;
}
