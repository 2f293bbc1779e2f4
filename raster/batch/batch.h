/* SPDX-License-Identifier: MIT */
/* The room "batch": many renders, one a line of a list, each by a process of its own; spectral
 * batch. */
#ifndef BATCH_H
#define BATCH_H

#include <pthread.h>

#include "data/options/options.h"
#include "data/process/process.h"
#include "data/text/text.h"
#include "spectral.h"

/* ---- command.c ---- */

/* Renders the lines of a list that are not up to date, several at a time. Prints a line when each
 * has ended, and at the end a summary and the commands that failed. Fails with the largest exit
 * status of a line. A batch that was killed leaves no process behind where the system can do so,
 * and no stack that is not whole: the next one draws what is missing. */
bool command_batch(struct options *options, struct error *err);

/* ---- inside this room ---- */

enum line_state {
    LINE_WAITS,
    LINE_CURRENT, /* its stack was up to date */
    LINE_DRAWN,
    LINE_FAILED
};
/* A line of the list: the words behind "spectral render". */
struct batch_line {
    struct place place; /* of its first word */
    char **words;       /* owned, as each word is */
    int n_words;
    char *output; /* the file that the line writes; owned */
    enum line_state state;
    double seconds;   /* from start to end */
    struct error err; /* of LINE_FAILED */
};
struct batch {
    struct text text; /* the list */
    struct batch_line *lines;
    int n_lines;
};

/* list.c. Reads a list. Each line is what a shell would get behind "spectral render", but that "#"
 * begins a comment and only double quotes hold words together. Refuses, at its line, what render
 * refuses before it reads a scene, and two lines with the same output. The caller frees *out, also
 * after a failure. */
bool batch_read(const struct options *options, struct batch *out, struct error *err);
void batch_free(struct batch *batch);
/* Prints the words as a command that a shell reads back. program: as the user started it. */
void batch_print_command(const char *program, const struct batch_line *line, struct printed *to);

/* run.c. Runs all lines, `jobs` at a time. Calls `ended` after each one, never at the same time.
 * Fails where it was interrupted. */
struct batch_run {
    struct batch *batch;
    const char *program;
    int jobs;                /* at a time */
    int threads, memory_mib; /* of each render whose line gives none; memory_mib 0: the usual */
    void (*ended)(void *of, const struct batch_line *line, int n_ended);
    void *of;
    /* inside: */
    pthread_mutex_t lock;
    int n_ended;
};
bool batch_run(struct batch_run *run, struct error *err);

#endif
