/* SPDX-License-Identifier: MIT */
/* Only the files of the room "base" include this. */
#ifndef DATA_BASE_INSIDE_H
#define DATA_BASE_INSIDE_H

#include "data/base/base.h"

/* ---- was_read.c: the files that this process has opened for reading ---- */

struct file_identity {
    uint64_t device, inode;
};

/* For a process that reads in place of another: the files noted so far; and one more. */
const struct file_identity *files_read(int *n);
bool files_read_add(const struct file_identity *file, struct error *err);
void files_read_forget(void); /* for tests, which write and read one file again and again */

/* ---- loop.c ---- */

enum { MOST_THREADS = 1024 };

/* ---- program.c: this program again, as a user's command line runs it ---- */

/* Returns the file to run: the link if it leads to a program, or else the name that the user typed,
 * which the system looks for as a shell does. */
const char *program_file(const char *link, const char *typed);

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
