/* SPDX-License-Identifier: MIT */
/* What the writers of TIFF files, stack.c and picture.c, share. Nobody else includes this, but for
 * tags.c through stack.h. */
#ifndef PAGES_H
#define PAGES_H

#include "spectral.h"

#include <tiffio.h>

/* Sets the tags of the current directory that tell what is on the page; `of` is the caller's. */
typedef bool page_tags(TIFF *tiff, const void *of, int page, struct error *err);

/* Lays out the file that the first half of `pages` describes. Tags may tell pages_offset where
 * there are bytes behind the last page. On failure nothing is left open. */
bool pages_open(struct pages *pages, const char *path, page_tags *set_tags, const void *of,
                struct error *err);
uint64_t pages_row_bytes(const struct pages *pages);
/* Where a page's pixels begin; of page `count`, where they end and the bytes behind them begin. */
uint64_t pages_offset(const struct pages *pages, int page);
uint64_t pages_end(const struct pages *pages); /* of the file */
/* Writes bytes `at` bytes behind the beginning of a page's pixels. */
bool pages_write(const struct pages *pages, int page, uint64_t at, const void *bytes, size_t length,
                 struct error *err);
/* Fills the room, NULL where there is none, and reads all directories again to see that they are
 * whole. */
bool pages_finish(struct pages *pages, const char *room, struct error *err);

#endif
