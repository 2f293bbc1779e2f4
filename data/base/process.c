/* SPDX-License-Identifier: MIT */
/* Starts processes and waits for them; runs a job in one, which sends its result through a pipe. */
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "data/base/inside.h"

/* ---- any child ---- */

bool child_start(pid_t *child, int *end, struct error *err)
{
    int ends[2];
    fflush(NULL);
    if (pipe(ends) != 0)
        return error_system(err, "cannot make a pipe");
    const pid_t parent = getpid();
    *child = fork();
    const bool started = *child >= 0 || error_system(err, "cannot start a process");
    close(ends[*child != 0]);
    *end = ends[*child == 0];
    if (*child == 0 && !guard_child(parent))
        _exit(EXIT_SYSTEM);
    guard_follow(*child > 0 ? *child : 0);
    if (!started)
        close(*end);
    return started;
}

bool child_end(pid_t child, int end, int *status, struct error *err)
{
    pid_t ended;
    close(end);
    UNTIL_DONE(ended, waitpid(child, status, 0));
    guard_follow(0);
    return ended >= 0 || error_system(err, "cannot wait for a run");
}

bool child_failed(int status, struct error *err)
{
    const bool killed = WIFSIGNALED(status);
    return error_failed(err, "a run ended without a result%s%s", killed ? ": " : "",
                        killed ? strsignal(WTERMSIG(status)) : "");
}

/* ---- a job ---- */

/* The job sends this first, then the files that it has read, then its own bytes. */
struct reply {
    bool done;
    int n_read;
    struct error err;
};

/* Reads all bytes. Fails if the pipe ends before the last one. */
static bool read_all(int from, void *bytes, size_t length)
{
    for (size_t got = 0; got < length;) {
        ssize_t more;
        UNTIL_DONE(more, read(from, (char *)bytes + got, length - got));
        if (more <= 0)
            return false;
        got += (size_t)more;
    }
    return true;
}

/* Takes over the files that the job has read. */
static bool read_files(int from, int n, struct error *err)
{
    bool done = true;
    for (struct file_identity file; done && n > 0; n--)
        done = read_all(from, &file, sizeof file) && files_read_add(&file, err);
    return done;
}

/* Sends a result, and the files that were read since there were `before`. */
static bool send(int to, struct reply *reply, int before, const void *out, size_t size)
{
    const struct file_identity *files = files_read(&reply->n_read);
    reply->n_read -= before;
    return write_all(to, reply, sizeof *reply) &&
           (reply->n_read == 0 ||
            write_all(to, files + before, (size_t)reply->n_read * sizeof *files)) &&
           write_all(to, out, size);
}

/* Reads the job's result, and waits until its process ends. */
static bool await(pid_t child, int from, void *out, size_t size, struct error *err)
{
    struct reply reply;
    int status = 0;
    const bool whole = read_all(from, &reply, sizeof reply) &&
                       read_files(from, reply.n_read, err) && read_all(from, out, size);
    if (!child_end(child, from, &status, err))
        return false;
    if (!whole)
        return child_failed(status, err);
    if (!reply.done)
        *err = reply.err;
    return reply.done;
}

bool process_run(bool (*job)(void *context, void *out, struct error *err), void *context, void *out,
                 size_t size, struct error *err)
{
    pid_t child;
    int end, before;
    files_read(&before);
    if (!child_start(&child, &end, err))
        return false;
    if (child == 0) {
        struct reply reply = {.done = false};
        reply.done = job(context, out, &reply.err);
        _exit(!send(end, &reply, before, out, size));
    }
    return await(child, end, out, size, err);
}
