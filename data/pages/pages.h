/* SPDX-License-Identifier: MIT */
/* The room "pages": TIFF files out, as pages of one format and as colour pictures. */
#ifndef PAGES_H
#define PAGES_H

#include "data/base/base.h"
#include "spectral.h"

struct tiff; /* libtiff's TIFF */

/* ---- pages.c: files of uncompressed pages ---- */

/* A file of uncompressed pages of the same format. All directories come first, then all pages
 * without gaps. */
struct pages {
    int count, width, height;
    int channels;          /* 1: grey, 3: RGB */
    int bits;              /* of a sample: 8, 16, or 32 of a float */
    uint64_t bytes_behind; /* behind the last page, where no TIFF reader looks */
    const char *room;      /* beginning of a text in the first page; pages_finish writes it */
    size_t room_bytes;     /* of that text; room NULL: there is none */
    uint32_t room_tag;
    /* set by pages_open: */
    struct output output;
    uint64_t first; /* the offset of the first page's pixels */
    uint64_t room_offset;
    bool big; /* BigTIFF */
};

/* Sets those tags of the current directory that describe the page. `of` is the caller's. */
typedef bool page_tags(struct tiff *tiff, const void *of, int page, struct error *err);

/* Writes the directories of the file that the first half of `pages` describes, and reserves the
 * places of the pages. If there are bytes behind the last page, tags may record their pages_offset.
 * On failure nothing is left open. */
bool pages_open(struct pages *pages, const char *path, page_tags *set_tags, const void *of,
                struct error *err);
/* Returns the offset of a page's pixels; for page `count`, of the bytes behind the last page. */
uint64_t pages_offset(const struct pages *pages, int page);
uint64_t pages_end(const struct pages *pages); /* the size of the whole file */
/* Writes bytes into a page, from byte `at` of its pixels on. */
bool pages_write(const struct pages *pages, int page, uint64_t at, const void *bytes, size_t length,
                 struct error *err);
/* Fills the room with a text (NULL: there is no room). Reads all directories again, and fails if
 * one of them is not complete. */
bool pages_finish(struct pages *pages, const char *room, struct error *err);

/* ---- picture.c: colour pictures ---- */

enum picture_samples { PICTURE_8, PICTURE_16, PICTURE_FLOAT };
struct picture_options {
    int width, height; /* a picture above 4 GiB becomes a BigTIFF */
    enum picture_samples samples;
    const char *channels[3];      /* of a float picture, such as "X", "Y", "Z" */
    const unsigned char *profile; /* ICC; NULL: none */
    size_t profile_length;
    const char *description; /* ASCII */
};
/* A picture that is written from the top, and appears whole or not at all. RGB is one page of three
 * samples a pixel. Floats are three pages, one for each channel, with its name. */
struct picture_writer {
    struct pages pages;
    struct picture_options options;
    int row; /* the next one */
};
bool picture_open(struct picture_writer *out, const char *path,
                  const struct picture_options *options, struct error *err);
/* Writes the next rows: three samples a pixel of uint8_t, uint16_t or float. */
bool picture_write(struct picture_writer *writer, const void *samples, int rows, struct error *err);
bool picture_commit(struct picture_writer *writer, struct error *err);
void picture_discard(struct picture_writer *writer); /* safe after commit */

/* ---- planes.c: float pages with names ---- */

struct planes_options {
    int width, height, n;
    const char *const *names; /* of the n pages */
    const char *description;  /* ASCII */
};
/* A file of these pages, filled in rectangles of any order. planes_finish completes it;
 * planes_commit lets it appear. */
bool planes_open(struct pages *out, const char *path, const struct planes_options *options,
                 struct error *err);
/* Writes the samples of a rectangle, row by row without gaps. */
struct plane_rectangle {
    int page, x, y, width, height;
};
bool planes_write(const struct pages *pages, const struct plane_rectangle *to, const float *samples,
                  struct error *err);
bool planes_finish(struct pages *pages, struct error *err);
bool planes_commit(struct pages *pages, struct error *err);
void planes_discard(struct pages *pages); /* safe after commit */

/* ---- Inside this room ---- */

uint64_t pages_row_bytes(const struct pages *pages);

#endif
