/* SPDX-License-Identifier: MIT */
/* A command runs in a process that another one watches. A library may end its process, as LLVM
 * does without memory, or be ended by a bad pointer. The watching process
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

void signals_release(void)
{
    sigset_t held;
    find_ending(&held);
    sigaddset(&held, SIGCHLD);
    sigprocmask(SIG_UNBLOCK, &held, NULL);
}

/* ---- the process that works ---- */

/* It ends with this and its exit status, or this and the number of a signal that it found: no
 * library ends a process so. */
enum { ENDED = 96, SIGNALLED = 128 };

bool process_follow(pid_t parent)
{
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    return getppid() == parent;
}

static void run_worker(int (*work)(void *of), void *of, pid_t parent)
{
    if (!process_follow(parent))
        exit(EXIT_SYSTEM);
    const int status = work(of), number = pending_signal();
    if (status == EXIT_SYSTEM && number == 0) /* the libraries may be in no state to clean up */
        _exit(ENDED + status);
    exit(number > 0 ? SIGNALLED + number : ENDED + status);
}

/* ---- the process that watches ---- */

enum { UNKNOWN_STATUS = -1 }; /* waitpid never gives it */

/* Returns whether the worker has ended. A worker that cannot be waited for is killed. */
static bool has_ended(pid_t worker, int *status)
{
    pid_t ended;
    UNTIL_DONE(ended, waitpid(worker, status, WNOHANG));
    if (ended < 0) {
        kill(worker, SIGKILL);
        *status = UNKNOWN_STATUS;
    }
    return ended != 0;
}

/* Waits for the end of the worker. Returns the signal that came meanwhile; 0: none. The first one
 * is passed on; after a second, or GRACE_MS, the worker is killed. */
static int watch(pid_t worker, const sigset_t *held, int *status)
{
    const struct timespec grace = {0, GRACE_MS * 1000000L}, rest = {1, 0};
    int number = 0;
    while (!has_ended(worker, status)) {
        const int got = sigtimedwait(held, NULL, number > 0 ? &grace : &rest);
        if (number > 0 && (got > 0 ? got != SIGCHLD : errno == EAGAIN))
            kill(worker, SIGKILL);
        else if (got > 0 && got != SIGCHLD)
            kill(worker, number = got);
    }
    return number;
}

/* Returns the exit status of a worker that has ended. */
static int conclude(int status)
{
    static const char hint[] = "memory or threads may have run out; --memory sets a limit";
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (status == UNKNOWN_STATUS) {
        fprintf(stderr, "error: cannot wait for the work, and ended it\n");
        return EXIT_SYSTEM;
    }
    if (code > SIGNALLED)
        return die_of(code - SIGNALLED);
    if (code >= ENDED && code <= ENDED + EXIT_SYSTEM)
        return code - ENDED;
    if (WIFSIGNALED(status))
        fprintf(stderr, "error: the work was ended by signal %d (%s); %s\n", WTERMSIG(status),
                strsignal(WTERMSIG(status)), hint);
    else
        fprintf(stderr, "error: a library ended the work with status %d; %s\n", code, hint);
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
    int status = 0;
    sigset_t held;
    const pid_t parent = getpid();
    fill_standard();
    signal(SIGCHLD, SIG_DFL); /* a process that ignores it cannot wait for another */
    find_ending(&held);
    sigaddset(&held, SIGCHLD);
    sigprocmask(SIG_BLOCK, &held, NULL);
    const pid_t worker = fork();
    if (worker == 0)
        run_worker(work, of, parent);
    if (worker < 0) {
        fprintf(stderr, "error: cannot start a process: %s\n", strerror(errno));
        return EXIT_SYSTEM;
    }
    const int number = watch(worker, &held, &status);
    return number > 0 ? die_of(number) : conclude(status);
}
