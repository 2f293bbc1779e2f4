/* SPDX-License-Identifier: MIT */
/* Only the files of the room "base" include this. */
#ifndef DATA_BASE_INSIDE_H
#define DATA_BASE_INSIDE_H

#include "data/base/base.h"

/* ---- descriptor.c: the files that this process has opened for reading ---- */

void files_read_forget(void); /* for tests, which write and read one file again and again */

/* ---- loop.c ---- */

enum { MOST_THREADS = 1024 };

/* ---- guard.c and process.c ---- */

/* A child ends when its parent ends, where the system can do so. `of` is the parent. Crashes end
 * the child as usual, and it removes no names. Returns false if the parent has ended already. */
bool guard_child(pid_t parent);
/* Remembers a child, which an ending signal kills first; 0: there is none. */
void guard_follow(pid_t child);

#endif
