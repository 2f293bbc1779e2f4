/* SPDX-License-Identifier: MIT */
/* Runs a job in a process of its own. Its result comes back through a pipe. */
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "data/base/base.h"
#include "raster/cost/cost.h"
#include "spectral.h"

/* The first bytes in the pipe; the job's own follow. */
struct reply {
    bool done;
    struct error err;
};

/* Signals are held back, so an interruption is looked for this often while a job runs. */
enum { LOOK_MS = 50 };

/* Reads until the job's end closes the pipe; returns how many bytes came, -1 if interrupted. */
static ssize_t read_reply(int from, char *bytes, size_t length)
{
    size_t got = 0;
    for (;;) {
        struct pollfd ready = {.fd = from, .events = POLLIN};
        if (output_interrupted())
            return -1;
        if (poll(&ready, 1, LOOK_MS) <= 0)
            continue;
        const ssize_t more = read(from, bytes + got, length - got);
        if (more == 0)
            return (ssize_t)got;
        if (more > 0)
            got += (size_t)more;
        else if (errno != EINTR)
            return 0;
    }
}

/* Takes the reply of a finished job; status is of waitpid. */
static bool take_reply(const char *bytes, ssize_t got, int status, void *out, size_t size,
                       struct error *err)
{
    struct reply reply;
    errno = 0;
    if (got < 0)
        return error_system(err, "interrupted; nothing was written");
    if ((size_t)got != sizeof reply + size)
        return error_system(err, "a run ended without a result%s%s",
                            WIFSIGNALED(status) ? ": " : "",
                            WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "");
    memcpy(&reply, bytes, sizeof reply);
    if (size > 0)
        memcpy(out, bytes + sizeof reply, size);
    if (!reply.done)
        *err = reply.err;
    return reply.done;
}

/* One byte more is asked for than comes, so that the end of the pipe is seen. */
static bool await(pid_t child, int from, void *out, size_t size, struct error *err)
{
    int status = 0;
    const size_t length = sizeof(struct reply) + size + 1;
    char *bytes = malloc(length);
    const ssize_t got = bytes ? read_reply(from, bytes, length) : -1;
    if (got < 0)
        kill(child, SIGKILL);
    while (waitpid(child, &status, 0) < 0 && errno == EINTR)
        continue;
    const bool done = bytes ? take_reply(bytes, got, status, out, size, err) : error_memory(err);
    free(bytes);
    return done;
}

bool process_run(bool (*job)(void *context, void *out, struct error *err), void *context, void *out,
                 size_t size, double *seconds, struct error *err)
{
    int ends[2];
    fflush(NULL);
    if (pipe(ends) != 0)
        return error_system(err, "cannot make a pipe");
    const double start = clock_seconds();
    const pid_t child = fork();
    if (child == 0) {
        struct reply reply = {.done = false};
        close(ends[0]);
        reply.done = job(context, out, &reply.err);
        _exit(!(write_all(ends[1], &reply, sizeof reply) && write_all(ends[1], out, size)));
    }
    close(ends[1]);
    const bool done = child > 0 ? await(child, ends[0], out, size, err)
                                : error_system(err, "cannot start a process");
    if (seconds)
        *seconds = clock_seconds() - start;
    close(ends[0]);
    return done;
}
