/* SPDX-License-Identifier: MIT */
/* What the two halves of the stack share: stack.c lays the file out and writes it, tags.c lets its
 * pages tell what they are. Nobody else includes this. */
#ifndef STACK_H
#define STACK_H

#include "spectral.h"

#include <tiffio.h>

/* Until the stack is whole its verdict is this, padded to STACK_VERDICT bytes. */
#define UNFINISHED "not finished"

/* ---- data/tags.c: what a page says of itself ---- */

/* Sets all tags of the current directory but the place of its pixels. */
bool tags_set(TIFF *tiff, const struct stack_options *options, int page, struct error *err);

#endif
