/* SPDX-License-Identifier: MIT */
/* What the two halves of the stack share: stack.c writes the file, tags.c lets its pages tell what
 * they are. Nobody else includes this. */
#ifndef STACK_H
#define STACK_H

#include "pages.h"

/* Until the stack is whole its verdict is this, padded to STACK_VERDICT bytes. */
#define UNFINISHED "not finished"

/* ---- data/tags.c: what a page says of itself ---- */

/* Sets all tags of the current directory but those of its format: page_tags of a stack_writer. */
bool tags_set(TIFF *tiff, const void *stack, int page, struct error *err);

#endif
