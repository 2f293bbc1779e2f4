/* SPDX-License-Identifier: MIT */
/* The end of this process. Outputs have no name until they are whole, so a process can end at any
 * moment. Only a file system that keeps no nameless files, and temporary folders, have names to be
 * removed first. A signal handler gets no context: its data must be static. */
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "data/base/inside.h"

#ifdef __linux__
#include <sys/prctl.h>
#endif

enum { MOST_NAMES = 8, NAME_ROOM = 4096 };
static struct {
    char names[MOST_NAMES][NAME_ROOM]; /* "": a free place */
    volatile sig_atomic_t child;       /* 0: none */
    volatile sig_atomic_t holds;       /* guard_hold without guard_release */
    volatile sig_atomic_t waiting;     /* the signal that came meanwhile; 0: none */
    volatile sig_atomic_t is_over;     /* guard_exit ends the process */
} guard;

static const int ending_signals[] = {SIGINT, SIGTERM, SIGHUP};
/* The messages of signals that mean a crash, by their numbers; NULL: of all others. */
static const char *const crashes[] = {
    [SIGSEGV] = "error: the program crashed: Segmentation fault",
    [SIGBUS] = "error: the program crashed: Bus error",
    [SIGFPE] = "error: the program crashed: Floating point exception",
    [SIGILL] = "error: the program crashed: Illegal instruction",
    [SIGABRT] = "error: a library aborted the program",
};
enum { ENDING_SIGNALS = 3, CRASHES = sizeof crashes / sizeof *crashes };

/* ---- what the handlers do: only calls that POSIX allows there ---- */

static void remove_names(void)
{
    for (int i = MOST_NAMES - 1; i >= 0; i--)
        if (guard.names[i][0] && unlink(guard.names[i]) != 0)
            rmdir(guard.names[i]);
}

/* The signal is blocked until the handler returns, and then ends the process as it does by default,
 * so that a shell sees why. A child could make new files in a folder, so it ends first. */
static void end_by(int number)
{
    const pid_t child = (pid_t)guard.child;
    if (guard.holds > 0) {
        guard.waiting = number;
        return;
    }
    if (child > 0 && kill(child, SIGKILL) == 0)
        waitpid(child, NULL, 0);
    remove_names();
    signal(number, SIG_DFL);
    raise(number);
}

/* Ends the process with a line of its own. */
static void end_with(const char *message)
{
    static const char line[] = "; memory or threads may have run out; --memory sets a limit\n";
    remove_names();
    const bool said = write_all(STDERR_FILENO, message, strlen(message)) &&
                      write_all(STDERR_FILENO, line, sizeof line - 1);
    (void)said;
    _exit(EXIT_SYSTEM);
}

static void end_crashed(int number)
{
    end_with(crashes[number]);
}

/* A library called exit. */
static void end_exited(void)
{
    if (!guard.is_over)
        end_with("error: a library ended the program");
}

/* ---- the guard ---- */

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

/* Installs a handler where the signal has none: a sanitizer has its own. It runs on a stack of its
 * own, as the usual one may be full. */
static void handle(int number, void (*handler)(int number))
{
    struct sigaction now, action = {.sa_handler = handler, .sa_flags = SA_ONSTACK};
    if (sigaction(number, NULL, &now) != 0 || now.sa_handler != SIG_DFL)
        return;
    for (int i = 0; i < ENDING_SIGNALS; i++)
        sigaddset(&action.sa_mask, ending_signals[i]);
    sigaction(number, &action, NULL);
}

void guard_begin(void)
{
    static char stack[1 << 16];
    const stack_t other = {.ss_sp = stack, .ss_size = sizeof stack};
    fill_standard();
    sigaltstack(&other, NULL);
    atexit(end_exited);
    for (int i = 0; i < ENDING_SIGNALS; i++)
        handle(ending_signals[i], end_by);
    for (int i = 0; i < CRASHES; i++)
        if (crashes[i])
            handle(i, end_crashed);
    signal(SIGCHLD, SIG_DFL); /* a process that ignores it cannot wait for another */
}

/* After a failure of the system the libraries may be in no state to clean up. */
void guard_exit(int status)
{
    guard.is_over = 1;
    if (status == EXIT_SYSTEM)
        _exit(status);
    exit(status);
}

/* ---- names ---- */

/* Returns the index of a name, or of a free place for ""; -1: there is none. */
static int find_name(const char *path)
{
    for (int i = 0; i < MOST_NAMES; i++)
        if (strcmp(guard.names[i], path) == 0)
            return i;
    return -1;
}

/* The first byte comes last: until then a handler finds no name. */
bool guard_remove(const char *path)
{
    const int i = find_name("");
    const size_t length = strlen(path);
    if (i < 0 || length >= NAME_ROOM)
        return false;
    memcpy(guard.names[i] + 1, path + 1, length);
    *(volatile char *)guard.names[i] = path[0];
    return true;
}

void guard_forget(const char *path)
{
    const int i = find_name(path);
    if (i >= 0)
        *(volatile char *)guard.names[i] = '\0';
}

/* ---- signals that wait ---- */

void guard_hold(void)
{
    guard.holds++;
}

void guard_release(void)
{
    guard.holds--;
    if (guard.holds == 0 && guard.waiting)
        end_by((int)guard.waiting);
}

bool is_interrupted(void)
{
    return guard.waiting != 0;
}

/* ---- children ---- */

bool guard_child(pid_t parent)
{
    for (int i = 0; i < MOST_NAMES; i++)
        guard.names[i][0] = '\0';
    for (int i = 0; i < CRASHES; i++)
        if (crashes[i])
            signal(i, SIG_DFL);
    guard.child = 0;
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    return getppid() == parent;
}

void guard_follow(pid_t child)
{
    guard.child = (sig_atomic_t)child;
}
