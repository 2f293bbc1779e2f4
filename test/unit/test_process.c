/* SPDX-License-Identifier: MIT */
/* A job in a process of its own returns its result or its failure. Whatever ends the work of a
 * guarded command, the user gets an exit status that the work itself gave, or 3 and one line. */
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "data/process/process.h"
#include "test.h"

static void rest(long ms)
{
    nanosleep(&(struct timespec){ms / 1000, ms % 1000 * 1000000L}, NULL);
}

/* ---- jobs ---- */

static bool doubles(void *context, void *out, struct error *err)
{
    const int *number = context;
    (void)err;
    *(int *)out = 2 * *number;
    return true;
}

static bool refuses(void *context, void *out, struct error *err)
{
    (void)context;
    (void)out;
    return error_usage(err, "seven is no colour");
}

static bool dies(void *context, void *out, struct error *err)
{
    (void)context;
    (void)out;
    (void)err;
    return kill(getpid(), SIGKILL) == 0;
}

static void jobs(void)
{
    struct error err = {.status = EXIT_AGREED};
    int number = 21, out = 0;
    CHECK(process_run(doubles, &number, &out, sizeof out, &err) && out == 42,
          "a process returns its result");
    CHECK(number == 21, "a process has its own copy of all other memory");
    CHECK(!process_run(refuses, &number, &out, sizeof out, &err) && err.status == EXIT_INPUT,
          "a process returns its failure");
    CHECK_TEXT(err.text, "error: seven is no colour",
               "the message of the failure is the process's own");
    err = (struct error){.status = EXIT_AGREED};
    CHECK(!process_run(dies, &number, &out, sizeof out, &err) && err.status == EXIT_SYSTEM,
          "a killed process is a failure of the system");
    CHECK(strstr(err.text, "Killed") != NULL, "the message names the signal");
}

/* Writes to the pipe to show that nothing ended the process early. */
static bool lingers(void *context, void *out, struct error *err)
{
    const int *to = context;
    (void)out;
    (void)err;
    return sleep(1) == 0 && write(*to, "x", 1) == 1;
}

static void interruption(void)
{
    struct error err = {.status = EXIT_AGREED};
    int ends[2];
    char byte;
    sigset_t set, before;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigprocmask(SIG_BLOCK, &set, &before);
    CHECK(pipe(ends) == 0 && !is_interrupted(), "no signal waits at first");
    raise(SIGTERM);
    CHECK(is_interrupted(), "a blocked signal waits");
    CHECK(!process_run(lingers, &ends[1], NULL, 0, &err) && err.status == EXIT_SYSTEM,
          "a waiting signal ends a process");
    CHECK(strstr(err.text, "interrupted") != NULL,
          "the message says that the process was interrupted");
    close(ends[1]);
    CHECK(read(ends[0], &byte, 1) == 0, "the interrupted process is gone");
    close(ends[0]);
    signal(SIGTERM, SIG_IGN); /* drops the waiting signal */
    raise(SIGTERM);
    CHECK(!is_interrupted(), "an ignored signal does not count");
    sigprocmask(SIG_SETMASK, &before, NULL);
    signal(SIGTERM, SIG_DFL);
}

/* ---- programs ---- */

/* This test itself, as the program that process_program runs. */
static int play(const char *part)
{
    if (strcmp(part, "works") == 0) {
        const double start = clock_seconds();
        while (clock_seconds() < start + 0.05)
            continue;
        return printf("nobody reads this\n") > 0 && getchar() == EOF ? EXIT_AGREED : EXIT_DIFFERENT;
    }
    if (strcmp(part, "lingers") == 0)
        rest(5000);
    if (strcmp(part, "dies") == 0)
        raise(SIGKILL);
    fprintf(stderr, "a library says something\nerror: seven is no colour\n");
    return EXIT_INPUT;
}

static bool run_program(const char *part, struct run_seconds *seconds, struct error *err)
{
    const char *const words[] = {"test_process", part, NULL};
    *err = (struct error){.status = EXIT_AGREED};
    return process_program(words, seconds, err);
}

static void programs(void)
{
    struct run_seconds seconds = {0, 0};
    struct error err;
    CHECK(run_program("works", &seconds, &err),
          "a program has no input, and its output goes nowhere");
    CHECK(seconds.wall >= 0.05 && seconds.processor > 0 && seconds.processor < 100,
          "a program has %.3f seconds of the clock, at least 0.05, and %.3f of the processor",
          seconds.wall, seconds.processor);
    CHECK(!run_program("refuses", &seconds, &err) && err.status == EXIT_INPUT,
          "a program returns its exit status");
    CHECK_TEXT(err.text, "error: seven is no colour", "its last line is the message");
    CHECK(!run_program("dies", &seconds, &err) && err.status == EXIT_SYSTEM,
          "a killed program is a failure of the system");
    CHECK(strstr(err.text, "Killed") != NULL, "the message names the signal of the program");
    CHECK_TEXT(program_file("/missing", "spectral"), "spectral",
               "without a link to the running program, its name is looked for");
    CHECK_TEXT(program_file("/bin/sh", "spectral"), "/bin/sh", "a link to a program is used");
}

static void interrupted_program(void)
{
    struct run_seconds seconds = {0, 0};
    struct error err;
    sigset_t set, before;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigprocmask(SIG_BLOCK, &set, &before);
    raise(SIGTERM);
    CHECK(!run_program("lingers", &seconds, &err) && err.status == EXIT_SYSTEM && seconds.wall < 5,
          "a waiting signal ends a program");
    CHECK(strstr(err.text, "interrupted") != NULL, "the message says that it was interrupted");
    signal(SIGTERM, SIG_IGN); /* drops the waiting signal */
    sigprocmask(SIG_SETMASK, &before, NULL);
    signal(SIGTERM, SIG_DFL);
}

/* ---- works ---- */

static int succeeds(void *of)
{
    (void)of;
    return EXIT_AGREED;
}

static int differs(void *of)
{
    (void)of;
    return EXIT_DIFFERENT;
}

static int exits(void *of) /* as a library may do */
{
    (void)of;
    exit(1);
}

static int exits_well(void *of)
{
    (void)of;
    exit(0);
}

static int aborts(void *of)
{
    (void)of;
    abort();
}

static int is_killed(void *of)
{
    (void)of;
    return raise(SIGKILL);
}

static int looks(void *of)
{
    (void)of;
    for (int i = 0; i < 1000 && !is_interrupted(); i++)
        rest(10);
    return EXIT_SYSTEM;
}

static int never_looks(void *of)
{
    (void)of;
    for (int i = 0; i < 10; i++)
        sleep(1);
    return EXIT_AGREED;
}

static int is_short(void *of)
{
    (void)of;
    rest(300);
    return EXIT_AGREED;
}

/* How a guarded work ended: the status of waitpid, lines on standard error, and seconds. */
struct end {
    int status, lines;
    double seconds;
};

/* Runs a work under guard in a process of its own. Sends it a signal 50 ms later; 0: none. */
static struct end run(int (*work)(void *of), int number)
{
    struct end end = {0};
    FILE *messages = tmpfile();
    const double start = clock_seconds();
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        dup2(fileno(messages), STDERR_FILENO);
        _exit(guard_run(work, NULL));
    }
    rest(50);
    if (number > 0)
        kill(child, number);
    waitpid(child, &end.status, 0);
    end.seconds = clock_seconds() - start;
    rewind(messages);
    for (int c; (c = getc(messages)) != EOF;)
        end.lines += c == '\n';
    fclose(messages);
    return end;
}

static bool ends_with(int (*work)(void *of), int status, int lines)
{
    const struct end end = run(work, 0);
    return WIFEXITED(end.status) && WEXITSTATUS(end.status) == status && end.lines == lines;
}

static void ends(void)
{
    CHECK(ends_with(succeeds, 0, 0), "work that succeeds gives 0");
    CHECK(ends_with(differs, 1, 0), "work that finds a difference gives 1");
    CHECK(ends_with(exits, 3, 1), "a library that exits with 1 gives 3 and a line");
    CHECK(ends_with(exits_well, 3, 1), "a library that exits with 0 gives 3 and a line");
    CHECK(ends_with(aborts, 3, 1), "a library that aborts gives 3 and a line");
    CHECK(ends_with(is_killed, 3, 1), "work that the system kills gives 3 and a line");
}

static void signals(void)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    for (int i = 0; i < 3; i++) {
        const char *name = strsignal(numbers[i]);
        signal(numbers[i], SIG_DFL); /* shells ignore SIGINT in background jobs */
        struct end end = run(looks, numbers[i]);
        CHECK(WIFSIGNALED(end.status) && WTERMSIG(end.status) == numbers[i] && end.lines == 0,
              "%s ends work that looks for it, without a message", name);
        end = run(never_looks, numbers[i]);
        CHECK(WIFSIGNALED(end.status) && WTERMSIG(end.status) == numbers[i] && end.seconds < 5,
              "%s ends work that never looks for it, in %.3f s", name, end.seconds);
        signal(numbers[i], SIG_IGN);
        end = run(is_short, numbers[i]);
        CHECK(WIFEXITED(end.status) && WEXITSTATUS(end.status) == 0,
              "%s does not end work that ignores it", name);
        signal(numbers[i], SIG_DFL);
    }
}

/* The pipe ends when the last process that holds it has ended. */
static void orphan(void)
{
    int ends[2];
    char byte;
    CHECK(pipe(ends) == 0, "a pipe is made");
    fflush(stdout);
    const double start = clock_seconds();
    const pid_t child = fork();
    if (child == 0)
        _exit(guard_run(never_looks, NULL));
    rest(50);
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    close(ends[1]);
    CHECK(read(ends[0], &byte, 1) == 0 && clock_seconds() - start < 5,
          "where the watching process is killed, the work ends with it");
    close(ends[0]);
}

int main(int argc, char **argv)
{
    if (argc > 1)
        return play(argv[1]);
    jobs();
    interruption();
    programs();
    interrupted_program();
    ends();
    signals();
    orphan();
    return test_end();
}
