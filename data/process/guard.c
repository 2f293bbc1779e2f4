/* SPDX-License-Identifier: MIT */
/* A command runs in a process that another one watches. A library may end its process, as OpenMP
 * does without threads and LLVM without memory, or be ended by a bad pointer. The watching process
 * survives that, and the user still gets one line and an exit status. It also ends a command that
 * does not stop by itself after a signal. */
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "data/process/process.h"

#ifdef __linux__
#include <sys/prctl.h>
#endif

/* ---- signals ---- */

static const int ending_signals[] = {SIGINT, SIGTERM, SIGHUP};
enum { ENDING_SIGNALS = sizeof ending_signals / sizeof ending_signals[0] };

/* Finds the signals that end the program: not those that it ignores, as SIGHUP under nohup. Linux
 * keeps a blocked signal pending although it is ignored. */
static void find_ending(sigset_t *out)
{
    sigemptyset(out);
    for (int i = 0; i < ENDING_SIGNALS; i++) {
        struct sigaction action;
        if (sigaction(ending_signals[i], NULL, &action) == 0 && action.sa_handler != SIG_IGN)
            sigaddset(out, ending_signals[i]);
    }
}

/* Returns the ending signal that is blocked and pending; 0: none is. */
static int pending_signal(void)
{
    sigset_t ending, pending;
    find_ending(&ending);
    sigpending(&pending);
    for (int i = 0; i < ENDING_SIGNALS; i++)
        if (sigismember(&ending, ending_signals[i]) == 1 &&
            sigismember(&pending, ending_signals[i]) == 1)
            return ending_signals[i];
    return 0;
}

bool is_interrupted(void)
{
    return pending_signal() != 0;
}

/* Ends this process as the signal does by default, so that a shell sees why. */
static int die_of(int number)
{
    sigset_t set;
    signal(number, SIG_DFL);
    sigemptyset(&set);
    sigaddset(&set, number);
    raise(number);
    sigprocmask(SIG_UNBLOCK, &set, NULL);
    return EXIT_SYSTEM;
}

/* ---- the process that works ---- */

/* It reports its exit status, or this and the number of a signal that it found. */
enum { SIGNALLED = 1000 };

bool process_follow(pid_t parent)
{
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    return getppid() == parent;
}

static void run_worker(int (*work)(void *of), void *of, pid_t parent, int to)
{
    if (!process_follow(parent))
        exit(EXIT_SYSTEM);
    const int status = work(of), number = pending_signal();
    const int report = number > 0 ? SIGNALLED + number : status;
    write_all(to, &report, sizeof report);
    exit(status);
}

/* ---- the process that watches ---- */

/* Waits for the end of the worker. Returns the signal that came meanwhile; 0: none. The first one
 * is passed on; after a second, or GRACE_MS, the worker is killed. */
static int watch(pid_t worker, const sigset_t *held, int *status)
{
    const struct timespec grace = {0, GRACE_MS * 1000000L};
    int number = 0;
    pid_t ended;
    while ((ended = waitpid(worker, status, WNOHANG)) == 0 || (ended < 0 && errno == EINTR)) {
        const int got = number > 0 ? sigtimedwait(held, NULL, &grace) : sigwaitinfo(held, NULL);
        if (number > 0 && (got > 0 ? got != SIGCHLD : errno == EAGAIN))
            kill(worker, SIGKILL);
        else if (got > 0 && got != SIGCHLD)
            kill(worker, number = got);
    }
    return number;
}

/* Returns the worker's report; -1: there is none. */
static int read_report(int from)
{
    int report;
    ssize_t got;
    if (fcntl(from, F_SETFL, O_NONBLOCK) != 0)
        return -1;
    UNTIL_DONE(got, read(from, &report, sizeof report));
    return got == (ssize_t)sizeof report ? report : -1;
}

/* Returns the exit status of a worker that has ended. */
static int conclude(int report, int status)
{
    static const char hint[] = "memory or threads may have run out";
    if (report > SIGNALLED)
        return die_of(report - SIGNALLED);
    if (WIFEXITED(status) && WEXITSTATUS(status) == report)
        return report;
    if (WIFSIGNALED(status))
        fprintf(stderr, "error: the work was ended by signal %d (%s); %s\n", WTERMSIG(status),
                strsignal(WTERMSIG(status)), hint);
    else
        fprintf(stderr, "error: a library ended the work with status %d; %s\n",
                WIFEXITED(status) ? WEXITSTATUS(status) : -1, hint);
    return EXIT_SYSTEM;
}

static int fail(const char *what)
{
    fprintf(stderr, "error: %s: %s\n", what, strerror(errno));
    return EXIT_SYSTEM;
}

/* Puts something in the place of standard input, output or error where it is closed: a file of the
 * program would take its number, and get the text of a table. Reading or writing there still fails.
 */
static void fill_standard(void)
{
    static const int wrong_ways[] = {O_WRONLY, O_RDONLY, O_RDONLY};
    for (int i = 0; i < 3; i++)
        if (fcntl(i, F_GETFD) < 0 && open("/dev/null", wrong_ways[i]) < 0)
            return;
}

int guard_run(int (*work)(void *of), void *of)
{
    int ends[2], status = 0;
    fill_standard();
    sigset_t held;
    const pid_t parent = getpid();
    signal(SIGCHLD, SIG_DFL); /* a process that ignores it cannot wait for another */
    find_ending(&held);
    sigaddset(&held, SIGCHLD);
    sigprocmask(SIG_BLOCK, &held, NULL);
    if (pipe(ends) != 0)
        return fail("cannot make a pipe");
    const pid_t worker = fork();
    if (worker < 0)
        return fail("cannot start a process");
    if (worker == 0) {
        close(ends[0]);
        run_worker(work, of, parent, ends[1]);
    }
    close(ends[1]);
    const int number = watch(worker, &held, &status);
    return number > 0 ? die_of(number) : conclude(read_report(ends[0]), status);
}
