/* SPDX-License-Identifier: MIT */
/* Starts processes and waits for them: one runs a job, and sends its result through a pipe; another
 * becomes this program again, as a shell would run it, from exec to exit. */
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "data/base/inside.h"

/* ---- any child ---- */

/* Starts a copy of this process, with a pipe from it: *child is 0 in the copy, and *end is the end
 * of the pipe that each of the two owns. Ends the copy if this process has ended. */
static bool child_start(pid_t *child, int *end, struct error *err)
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

/* Closes the pipe's end and waits for the child; stores its status as waitpid does. */
static bool child_end(pid_t child, int end, int *status, struct error *err)
{
    pid_t ended;
    close(end);
    UNTIL_DONE(ended, waitpid(child, status, 0));
    guard_follow(0);
    return ended >= 0 || error_system(err, "cannot wait for a run");
}

/* Fails: the child has ended without a result; by which signal. */
static bool child_failed(int status, struct error *err)
{
    const bool killed = WIFSIGNALED(status);
    if (killed && WTERMSIG(status) == SIGALRM)
        return error_failed(err, "a run had no result in its time");
    return error_failed(err, "a run ended without a result%s%s", killed ? ": " : "",
                        killed ? strsignal(WTERMSIG(status)) : "");
}

/* ---- a job ---- */

/* Fails if the pipe ends before the last byte. */
static bool read_all(int from, void *bytes, size_t length)
{
    return read_at(from, bytes, length, OWN_PLACE) == (ssize_t)length;
}

/* The job's failure comes first, if any, and then its bytes. */
bool process_run(process_job *job, void *context, void *out, size_t size, unsigned limit_s,
                 struct error *err)
{
    struct error failure = {.status = EXIT_AGREED};
    pid_t child;
    int end, status = 0;
    if (!child_start(&child, &end, err))
        return false;
    if (child == 0) {
        signal(SIGALRM, SIG_DFL);
        alarm(limit_s);
        job(context, out, &failure);
        _exit(!(write_all(end, &failure, sizeof failure) && write_all(end, out, size)));
    }
    const bool whole = read_all(end, &failure, sizeof failure) && read_all(end, out, size);
    if (!child_end(child, end, &status, err))
        return false;
    if (!whole)
        return child_failed(status, err);
    if (failure.status != EXIT_AGREED)
        *err = failure;
    return failure.status == EXIT_AGREED;
}

/* ---- this program again ---- */

/* Makes `to` another name of the open file `from`. */
static bool redirect(int from, int to)
{
    int got;
    UNTIL_DONE(got, dup2(from, to));
    return got >= 0;
}

/* Nobody types at the program and nobody reads its table. Its messages go to the pipe. Linux has a
 * name for the file of the running program, even if that file has been moved or replaced meanwhile;
 * elsewhere the name that the user typed is looked for as a shell does. Where the system can run
 * neither, this process ends with the reason in a line, as the program itself would. */
static void become(const char *const *words, int messages)
{
    struct error err = {.status = EXIT_AGREED};
    char *const *line; /* as execvp wants it, which changes no word */
    int nothing;
    memcpy(&line, &words, sizeof line);
    UNTIL_DONE(nothing, open("/dev/null", O_RDWR | O_CLOEXEC));
    if (nothing >= 0 && redirect(nothing, STDIN_FILENO) && redirect(nothing, STDOUT_FILENO) &&
        redirect(messages, STDERR_FILENO)) {
        execv("/proc/self/exe", line);
        execvp(line[0], line);
    }
    error_system(&err, "cannot run the program %s", line[0]);
    _exit(write_all(messages, err.text, strlen(err.text)) ? EXIT_SYSTEM : EXIT_SYSTEM + 1);
}

/* Reads messages until no process has the pipe open. */
static bool read_messages(int from, struct printed *out)
{
    char bytes[512];
    ssize_t got = 1;
    while (got > 0) {
        UNTIL_DONE(got, read(from, bytes, sizeof bytes));
        print_bytes(out, bytes, got > 0 ? (size_t)got : 0);
    }
    return got == 0;
}

/* Cuts the ends of lines off a text, and returns its last line. */
static const char *last_line(char *text)
{
    for (size_t n = strlen(text); n > 0 && text[n - 1] == '\n'; n--)
        text[n - 1] = '\0';
    const char *newline = strrchr(text, '\n');
    return newline ? newline + 1 : text;
}

/* Concludes from the status of a program that has ended by itself. */
static bool conclude(int status, const char *message, struct error *err)
{
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (code == EXIT_AGREED)
        return true;
    if (code < 0 || code > EXIT_SYSTEM || message[0] == '\0')
        return child_failed(status, err);
    *err = (struct error){.status = (enum exit_status)code};
    snprintf(err->text, sizeof err->text, "%s", message);
    return false;
}

/* Returns the processor time of all processes that this one has waited for, and of theirs. */
static double children_seconds(void)
{
    struct rusage used;
    if (getrusage(RUSAGE_CHILDREN, &used) != 0)
        return 0;
    return (double)used.ru_utime.tv_sec + (double)used.ru_stime.tv_sec +
           1e-6 * ((double)used.ru_utime.tv_usec + (double)used.ru_stime.tv_usec);
}

bool process_program(const char *const *words, struct run_seconds *out, struct error *err)
{
    const struct run_seconds start = {clock_seconds(), children_seconds()};
    struct printed messages = {.text = NULL};
    pid_t child;
    int end, status = 0;
    *out = (struct run_seconds){.wall = 0};
    if (!child_start(&child, &end, err))
        return false;
    if (child == 0) {
        fcntl(end, F_SETFD, FD_CLOEXEC);
        become(words, end);
    }
    if (!read_messages(end, &messages))
        kill(child, SIGKILL);
    const bool ended = child_end(child, end, &status, err);
    *out = (struct run_seconds){clock_seconds() - start.wall, children_seconds() - start.processor};
    char *text = printed_end(&messages);
    const bool done = ended && conclude(status, text ? last_line(text) : "", err);
    free(text);
    return done;
}
