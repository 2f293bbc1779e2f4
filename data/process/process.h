/* SPDX-License-Identifier: MIT */
/* The room "process": the end of this process, wanted or not; jobs and programs in processes of
 * their own. */
#ifndef PROCESS_H
#define PROCESS_H

#include "data/base/base.h"

/* ---- guard.c: the end of this process ---- */

/* Call once, first of all. From then on:
 * - SIGINT, SIGTERM and SIGHUP end the process at once, unless it ignores them, and remove the
 * names that guard_remove knows.
 * - A crash, or an exit that is not by guard_exit, removes these names, prints one line and ends
 * the process with EXIT_SYSTEM: a library may end its process, as LLVM does without memory. */
void guard_begin(void);
/* Ends the process with the exit status of a command. Does not return. */
void guard_exit(int status);

/* Remembers the name of a file or of an empty folder that must not outlive the process; the latest
 * is removed first. Returns false where there is no room for it: the caller then makes no such
 * file. The name is absolute, or relative to a working folder that stays. guard_forget takes it
 * back. */
bool guard_remove(const char *path);
void guard_forget(const char *path);

/* Between these two calls the signals that end the process wait: outputs get their names, or a
 * folder holds files that have no guard. They nest. */
void guard_hold(void);
void guard_release(void);
bool is_interrupted(void); /* such a signal waits */

/* ---- process.c: a job in a process of its own ---- */

/* Runs a job in a copy of this process, and waits for it. Returns the job's `size` bytes at `out`.
 * What the job has read counts as read by this process: see file_was_read. No other thread of this
 * process runs now, and it starts no OpenGL: a copy of a process has none of its threads, and
 * OpenGL would wait for them. */
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
 * the program printed on standard error, and with its exit status. */
bool process_program(const char *const *words, struct run_seconds *out, struct error *err);
/* Returns the file to run: the link if it leads to a program, or else the name that the user typed,
 * which the system looks for as a shell does. */
const char *program_file(const char *link, const char *typed);

/* ---- Inside this room ---- */

/* A child ends when its parent ends, where the system can do so. `of` is the parent. Crashes end
 * the child as usual, and it removes no names. Returns false if the parent has ended already. */
bool guard_child(pid_t parent);
/* Remembers a child, which an ending signal kills first; 0: there is none. */
void guard_follow(pid_t child);

/* Starts a copy of this process, with a pipe from it: *child is 0 in the copy, and *end is the end
 * of the pipe that each of the two owns. Ends the copy if this process has ended. */
bool child_start(pid_t *child, int *end, struct error *err);
/* Closes the pipe's end and waits for the child; stores its status as waitpid does. */
bool child_end(pid_t child, int end, int *status, struct error *err);
/* Fails: the child has ended without a result; by which signal. */
bool child_failed(int status, struct error *err);

#endif
