/* SPDX-License-Identifier: MIT */
/* The room "pages": TIFF files out, as pages of one format; colour pictures as TIFF or PNG. */
#ifndef PAGES_H
#define PAGES_H

#include "data/output/output.h"
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

/* Refuses the name of a picture whose ending is neither .png nor .tif or .tiff. */
bool picture_accepts(const char *path, struct error *err);
bool picture_is_png(const char *path); /* any other picture, as one of /dev/stdout, is a TIFF */

enum picture_samples { PICTURE_8, PICTURE_16, PICTURE_FLOAT };
struct picture_options {
    int width, height;            /* a TIFF above 4 GiB becomes a BigTIFF */
    enum picture_samples samples; /* a PNG has no floats */
    const char *channels[3];      /* of a float picture, such as "X", "Y", "Z" */
    bool srgb;                    /* a PNG says so in chunks of its own, and needs no profile */
    const unsigned char *profile; /* ICC; NULL: none */
    size_t profile_length;
    const char *description; /* ASCII */
};
/* Replaces all but newlines and printable ASCII by '?', as a description needs it. Returns the
 * text; NULL is fine. */
char *picture_text(char *text);
/* A picture that is written from the top, and appears whole or not at all. RGB is one page of three
 * samples a pixel. Floats are three pages, one for each channel, with its name. A PNG is
 * compressed, and takes the memory of some rows. */
struct picture_writer {
    struct picture_options options;
    int row; /* the next one */
    bool finished;
    struct pages pages; /* of a TIFF */
    struct png *png;    /* NULL: a TIFF; owned */
    struct picture_strip {
        char *samples;  /* owned */
        int first, end; /* its rows */
    } strip;            /* rows that are not complete yet */
};
/* The path chooses the format, which picture_accepts. */
bool picture_open(struct picture_writer *out, const char *path,
                  const struct picture_options *options, struct error *err);
/* Writes the next rows: three samples a pixel of uint8_t, uint16_t or float. */
bool picture_write(struct picture_writer *writer, const void *samples, int rows, struct error *err);
/* Writes a rectangle of RGB, row by row without gaps. Rows are kept until a rectangle reaches the
 * right border: it comes after all others of its rows, and no row comes before the one above it. */
struct picture_rectangle {
    int x, y, width, height;
};
bool picture_put(struct picture_writer *writer, const struct picture_rectangle *at,
                 const void *samples, struct error *err);
/* picture_finish completes the file; picture_commit does so, too, and lets it appear: see
 * output_pass. */
bool picture_finish(struct picture_writer *writer, struct error *err);
bool picture_commit(struct picture_writer *writer, struct outputs *outputs, struct error *err);
void picture_discard(struct picture_writer *writer); /* safe after commit */

/* ---- scale.c: numbers as colours ---- */

/* A scale of colours for numbers from 0 on, in steps of powers of two. 0 is black; numbers up to
 * `least` are navy, and each doubling is the next colour, from blue over pale yellow (up to 128 x
 * least) to dark red (up to 4096 x least); all others, also infinity, are maroon. Blue and red stay
 * apart for colour-blind readers. */
void scale_colour(double value, double least, uint8_t out[3]);
/* Prints the meaning of the colours but black, in a line without its end. */
void scale_print(double least, struct printed *to);

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
bool planes_commit(struct pages *pages, struct outputs *outputs, struct error *err);
void planes_discard(struct pages *pages); /* safe after commit */

/* ---- Inside this room ---- */

uint64_t pages_row_bytes(const struct pages *pages);

/* png.c: a PNG file (ISO/IEC 15948:2004), written from the top. Its bytes do not depend on how many
 * rows come at once. */
struct png;
bool png_open(struct png **out, const char *path, const struct picture_options *options,
              struct error *err);
bool png_write(struct png *png, const void *samples, int rows, struct error *err);
bool png_finish(struct png *png, struct error *err);
bool png_commit(struct png *png, struct outputs *outputs, struct error *err);
void png_free(struct png *png); /* an uncommitted file is gone; NULL is fine */

#endif
