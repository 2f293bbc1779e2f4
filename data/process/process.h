/* SPDX-License-Identifier: MIT */
/* The room "process": jobs in processes of their own, and the signals that end a run. */
#ifndef PROCESS_H
#define PROCESS_H

#include "data/base/base.h"

/* ---- guard.c: the command in a process that another one watches ---- */

/* Does the work in a process of its own, and returns its exit status, 0 to 3, when that process has
 * ended. A status counts only if the work returned it: if a library ends the process, or a signal
 * does, this prints a line and returns EXIT_SYSTEM. SIGINT, SIGTERM and SIGHUP end both processes:
 * the work has GRACE_MS to remove its temporary files. */
int guard_run(int (*work)(void *of), void *of);
enum { GRACE_MS = 150 };
/* Returns whether such a signal has come. The work looks for it between its steps, and then
 * returns. Outside of guard_run: whether one is blocked and pending. */
bool is_interrupted(void);

/* ---- process.c: a job in a process of its own ---- */

/* Runs a job in a copy of this process, and waits for it. Returns the job's `size` bytes at `out`.
 * An interruption ends the job. This process may start no thread and no OpenGL: a copy of a process
 * has none of its threads, and OpenGL would wait for them. */
bool process_run(bool (*job)(void *context, void *out, struct error *err), void *context, void *out,
                 size_t size, struct error *err);

/* ---- program.c: this program again, as a user's command line runs it ---- */

/* The seconds of a program from exec to exit: by the clock; and of the processor, for the user and
 * for the system, in all processes of the program. */
struct run_seconds {
    double wall, processor;
};
/* Runs this program with the words, which end with NULL; the first is the name that this program
 * was started by. Standard input and output are /dev/null. Returns false with the last line that
 * the program printed on standard error, and with its exit status. An interruption ends it. */
bool process_program(const char *const *words, struct run_seconds *out, struct error *err);
/* Do that in two steps, for several programs at a time, each on a thread of its own. The caller
 * lets only one thread start a program at a time. Processor seconds are those of all programs. */
struct running_program {
    pid_t child;
    int messages; /* a descriptor */
    struct run_seconds start;
};
bool process_start(const char *const *words, struct running_program *out, struct error *err);
bool process_await(const struct running_program *program, struct run_seconds *out,
                   struct error *err);
/* Returns the file to run: the link if it leads to a program, or else the name that the user typed,
 * which the system looks for as a shell does. */
const char *program_file(const char *link, const char *typed);

/* ---- Inside this room ---- */

/* Lets this process end when its parent ends, where the system can do so. Returns false if the
 * parent has ended already. */
bool process_follow(pid_t parent);
/* Lets the signals pass that guard_run holds back: a program must start without that. */
void signals_release(void);
/* Signals are held back, so a wait for a process looks for one this often. */
enum { LOOK_MS = 10 };

#endif
