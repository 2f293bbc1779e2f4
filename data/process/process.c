/* SPDX-License-Identifier: MIT */
/* Runs a job in a process of its own, which sends its result through a pipe. */
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "data/process/process.h"

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
    pid_t ended;
    UNTIL_DONE(ended, waitpid(child, &status, 0));
    (void)ended;
    guard_follow(0);
    if (!whole)
        return error_failed(err, "a run ended without a result%s%s",
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
        int before;
        files_read(&before);
        close(ends[0]);
        if (!guard_child(parent))
            _exit(EXIT_SYSTEM);
        reply.done = job(context, out, &reply.err);
        _exit(!send(ends[1], &reply, before, out, size));
    }
    guard_follow(child > 0 ? child : 0);
    close(ends[1]);
    const bool done = child > 0 ? await(child, ends[0], out, size, err)
                                : error_system(err, "cannot start a process");
    close(ends[0]);
    return done;
}
