/* SPDX-License-Identifier: MIT */
/* Only the files of the room "text" include this. */
#ifndef DATA_TEXT_INSIDE_H
#define DATA_TEXT_INSIDE_H

#include "data/text/text.h"

/* Goes through the options of a command; zero it before use, but for the command. */
struct option_walk {
    const struct command *command;
    bool recorded; /* only those that a stack records */
    int list, row; /* the next one */
};
const struct option *option_next(struct option_walk *walk); /* NULL: there is none */

#endif
