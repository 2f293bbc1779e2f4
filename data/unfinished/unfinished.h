/* SPDX-License-Identifier: MIT */
/* The room "unfinished": a stack that outlives the processes that draw it. It is a file beside the
 * stack, STACK.unfinished, with the stack's own bytes. All that is not stored yet is 0, and its
 * verdict says that it is not finished. */
#ifndef UNFINISHED_H
#define UNFINISHED_H

#include "data/stack/stack.h"
#include "spectral.h"

/* Several processes may store in one file if they read nothing of it: on NFS a process could store
 * old samples of others, which it has read. */
enum unfinished_use { UNFINISHED_ALONE, UNFINISHED_SHARED };
/* Lets a writer, which stack_open has made with head_only, store in the unfinished stack. begun: it
 * must be there. Refuses a file of another length, and a full disk. */
bool unfinished_open(struct stack_writer *writer, enum unfinished_use use, bool begun,
                     struct error *err);
bool unfinished_sync(const struct stack_writer *writer, struct error *err); /* to the disk */
/* All of it is there: from now on stack_commit gives it the stack's name, and stack_discard removes
 * it. Before, stack_discard leaves it as it is. */
void unfinished_end(struct stack_writer *writer);

#endif
