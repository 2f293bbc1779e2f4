/* SPDX-License-Identifier: MIT */
/* Only the files of the room "stack" include this. */
#ifndef DATA_STACK_INSIDE_H
#define DATA_STACK_INSIDE_H

#include "data/stack/stack.h"

/* Returns the text of the OME-XML's element Description, unescaped; allocated. NULL: there is none,
 * or an error. */
char *description_text(const char *xml, struct error *err);
/* Returns whether the description of the first page has a record, whole or damaged. */
bool record_is_there(const struct image *image);

/* ---- stack.c: the verdict on a stack, in numbers ---- */

/* Returns false where the line records no numbers: nothing was checked, or the reference's pixels
 * are stored. */
bool stack_verdict_read(const char *line, struct stack_verdict *out);

enum { TAG_VERDICT = 65111 };           /* the verdict of the check */
#define STACK_UNFINISHED "not finished" /* the verdict of a stack that is not whole yet */
#define PAGE_LABEL "%.10g nm"
/* tags.c: returns the width of a page: the mean distance to its neighbours; 0: it is the only one.
 */
double page_width_nm(const double *wavelengths_nm, int n, int page);
/* Sets all tags of the current directory but those of its format. It is the page_tags of a
 * stack_writer, to which `stack` points. */
bool tags_set(struct tiff *tiff, const void *stack, int page, struct error *err);

#endif
