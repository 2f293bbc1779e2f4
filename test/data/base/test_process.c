/* SPDX-License-Identifier: MIT */
/* A job in a process of its own returns its result or its failure. Whatever ends a guarded process,
 * the user gets an exit status that the command itself gave, or 3 and one line, and no file is left
 * that the guard knows. kills.py looks for processes that go on. */
#include <signal.h>
#include <sys/wait.h>
#include <time.h>

#include "data/base/inside.h"
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

static bool waits(void *context, void *out, struct error *err)
{
    (void)context;
    (void)out;
    (void)err;
    return pause() == 0;
}

static void jobs(void)
{
    struct error err = {.status = EXIT_AGREED};
    int number = 21, out = 0;
    CHECK(process_run(doubles, &number, &out, sizeof out, 60, &err) && out == 42,
          "a process returns its result");
    CHECK(number == 21, "a process has its own copy of all other memory");
    CHECK(!process_run(refuses, &number, &out, sizeof out, 60, &err) && err.status == EXIT_INPUT,
          "a process returns its failure");
    CHECK_TEXT(err.text, "error: seven is no colour",
               "the message of the failure is the process's own");
    err = (struct error){.status = EXIT_AGREED};
    CHECK(!process_run(dies, &number, &out, sizeof out, 60, &err) && err.status == EXIT_SYSTEM,
          "a killed process is a failure of the system");
    CHECK(strstr(err.text, "Killed") != NULL, "the message names the signal");
    err = (struct error){.status = EXIT_AGREED};
    CHECK(!process_run(waits, &number, &out, sizeof out, 1, &err) &&
              strstr(err.text, "no result in its time") != NULL,
          "a process that takes too long is ended");
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
}

/* ---- ends ---- */

static const char *const doomed = "doomed"; /* a file that must not outlive its process */

/* Works take a number, as exit and guard_exit do. */
static void raises(int number)
{
    raise(number);
}

static int sink(int depth)
{
    volatile char room[1 << 16];
    room[0] = (char)depth;
    return depth < 0 ? 0 : sink(depth + 1) + room[0];
}

static void overflows(int depth)
{
    sink(depth);
}

static void works_on(int seconds)
{
    for (int i = 0; i < seconds; i++)
        sleep(1);
}

/* A signal waits until the end, which comes in a moment. */
static void holds(int ms)
{
    guard_hold();
    rest(ms);
    if (!is_interrupted())
        return;
    FILE *file = fopen(doomed, "a");
    fprintf(file, "all of it");
    fclose(file);
    guard_forget(doomed);
    guard_release();
}

static void is_short(int ms)
{
    rest(ms);
    guard_exit(EXIT_AGREED);
}

/* How a guarded process ended: the status of waitpid, lines on standard error, and seconds. */
struct end {
    int status, lines;
    double seconds;
    bool left; /* the file is still there */
};

/* Runs a work under guard in a process of its own. Sends it a signal 50 ms later; 0: none. */
static struct end run(void (*work)(int), int argument, int number)
{
    struct end end = {0};
    FILE *messages = tmpfile(), *file = fopen(doomed, "w");
    const double start = clock_seconds();
    fclose(file);
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        dup2(fileno(messages), STDERR_FILENO);
        guard_begin();
        guard_remove(doomed);
        work(argument);
        _exit(99);
    }
    rest(50);
    if (number > 0)
        kill(child, number);
    waitpid(child, &end.status, 0);
    end.seconds = clock_seconds() - start;
    end.left = access(doomed, F_OK) == 0;
    unlink(doomed);
    rewind(messages);
    for (int c; (c = getc(messages)) != EOF;)
        end.lines += c == '\n';
    fclose(messages);
    return end;
}

static bool ends_with(void (*work)(int), int argument, int status, int lines)
{
    const struct end end = run(work, argument, 0);
    return WIFEXITED(end.status) && WEXITSTATUS(end.status) == status && end.lines == lines &&
           end.left == (lines == 0);
}

static void ends(void)
{
    CHECK(ends_with(guard_exit, EXIT_AGREED, 0, 0), "a command that succeeds gives 0");
    CHECK(ends_with(guard_exit, EXIT_DIFFERENT, 1, 0), "a command that finds a difference gives 1");
    CHECK(ends_with(exit, 1, 3, 1),
          "a library that exits with 1 gives 3 and a line; no file is left");
    CHECK(ends_with(exit, 0, 3, 1), "a library that exits with 0 gives 3 and a line");
    CHECK(ends_with(raises, SIGABRT, 3, 1), "a library that aborts gives 3 and a line");
    CHECK(ends_with(raises, SIGSEGV, 3, 1), "a crash gives 3 and a line");
    CHECK(ends_with(overflows, 0, 3, 1), "an overflow of the stack gives 3 and a line");
}

static void signals(void)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    for (int i = 0; i < 3; i++) {
        const char *name = strsignal(numbers[i]);
        signal(numbers[i], SIG_DFL); /* shells ignore SIGINT in background jobs */
        struct end end = run(works_on, 10, numbers[i]);
        CHECK(WIFSIGNALED(end.status) && WTERMSIG(end.status) == numbers[i] && end.lines == 0 &&
                  !end.left && end.seconds < 5,
              "%s ends the process without a message in %.3f s, and no file is left", name,
              end.seconds);
        end = run(holds, 300, numbers[i]);
        CHECK(WIFSIGNALED(end.status) && WTERMSIG(end.status) == numbers[i] && end.left,
              "%s waits until outputs have their names, and then ends the process", name);
        signal(numbers[i], SIG_IGN);
        end = run(is_short, 300, numbers[i]);
        CHECK(WIFEXITED(end.status) && WEXITSTATUS(end.status) == 0,
              "%s does not end a process that ignores it", name);
        signal(numbers[i], SIG_DFL);
    }
}

int main(int argc, char **argv)
{
    if (argc > 1)
        return play(argv[1]);
    test_enter();
    jobs();
    programs();
    ends();
    signals();
    return test_end();
}
