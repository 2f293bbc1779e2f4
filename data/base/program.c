/* SPDX-License-Identifier: MIT */
/* Runs this program again, as a shell would: from exec to exit, in a process of its own. */
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "data/base/inside.h"

/* Linux has this name for the file of the running program, even if that file has been moved or
 * replaced meanwhile. */
static const char running[] = "/proc/self/exe";

const char *program_file(const char *link, const char *typed)
{
    return access(link, X_OK) == 0 ? link : typed;
}

/* ---- the process that becomes the program ---- */

/* Ends this process with the system's reason in a line, as the program itself would. */
static void refuse(const char *file, int messages)
{
    struct error err = {.status = EXIT_AGREED};
    error_system(&err, "cannot run the program %s", file);
    _exit(write_all(messages, err.text, strlen(err.text)) ? EXIT_SYSTEM : EXIT_SYSTEM + 1);
}

/* Makes `to` another name of the open file `from`. */
static bool redirect(int from, int to)
{
    int got;
    UNTIL_DONE(got, dup2(from, to));
    return got >= 0;
}

/* Nobody types at the program and nobody reads its table. Its messages go to the pipe. */
static void become(const char *file, const char *const *words, int messages)
{
    char *const *line; /* as execvp wants it, which changes no word */
    int nothing;
    memcpy(&line, &words, sizeof line);
    UNTIL_DONE(nothing, open("/dev/null", O_RDWR | O_CLOEXEC));
    if (nothing >= 0 && redirect(nothing, STDIN_FILENO) && redirect(nothing, STDOUT_FILENO) &&
        redirect(messages, STDERR_FILENO)) {
        errno = 0;
        execvp(file, line);
    }
    refuse(file, messages);
}

/* ---- the process that waits ---- */

/* The last line of what the program has printed so far. */
struct last_line {
    char text[sizeof((struct error *)NULL)->text];
    size_t length;
    bool ended; /* the next byte begins another line */
};

static void take(struct last_line *line, const char *bytes, size_t length)
{
    for (; length > 0; bytes++, length--) {
        if (*bytes == '\n') {
            line->ended = true;
            continue;
        }
        if (line->ended)
            line->length = 0;
        line->ended = false;
        if (line->length + 1 < sizeof line->text)
            line->text[line->length++] = *bytes;
    }
    line->text[line->length] = '\0';
}

/* Reads messages until no process has the pipe open. */
static bool read_messages(int from, struct last_line *out)
{
    for (;;) {
        char bytes[512];
        ssize_t got;
        UNTIL_DONE(got, read(from, bytes, sizeof bytes));
        if (got <= 0)
            return got == 0;
        take(out, bytes, (size_t)got);
    }
}

/* Concludes from the status of a program that has ended by itself. */
static bool conclude(int status, const struct last_line *messages, struct error *err)
{
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (code == EXIT_AGREED)
        return true;
    if (code < 0 || code > EXIT_SYSTEM || messages->length == 0)
        return child_failed(status, err);
    *err = (struct error){.status = (enum exit_status)code};
    memcpy(err->text, messages->text, sizeof err->text);
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
    const char *file = program_file(running, words[0]);
    const struct run_seconds start = {clock_seconds(), children_seconds()};
    struct last_line messages = {.length = 0};
    pid_t child;
    int end, status = 0;
    *out = (struct run_seconds){.wall = 0};
    if (!child_start(&child, &end, err))
        return false;
    if (child == 0) {
        fcntl(end, F_SETFD, FD_CLOEXEC);
        become(file, words, end);
    }
    if (!read_messages(end, &messages))
        kill(child, SIGKILL);
    const bool ended = child_end(child, end, &status, err);
    *out = (struct run_seconds){clock_seconds() - start.wall, children_seconds() - start.processor};
    return ended && conclude(status, &messages, err);
}
