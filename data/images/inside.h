/* SPDX-License-Identifier: MIT */
/* Only the files of the room "images" include this. */
#ifndef DATA_IMAGES_INSIDE_H
#define DATA_IMAGES_INSIDE_H

#include "data/images/images.h"
/* ---- client.c ---- */

/* Opens a file for libtiff to read ("rmc") or write. NULL on failure: see client->cause and
 * message. "m": the file is not mapped into memory; a file that is cut while it is mapped would end
 * the program. "c": libtiff does not split a large strip into small ones. From here on nothing may
 * set errno to 0 until it is asked whether memory sufficed. */
struct tiff *client_open(struct client *client, const char *path, const char *mode);
/* Returns the number of bytes read, fewer at the end of the file; -1: the system failed. */
ssize_t client_bytes(struct client *client, void *out, size_t length, uint64_t offset);

/* ---- image.c ---- */

/* Returns whether each read so far succeeded, and memory sufficed. libtiff goes on without what it
 * could not read, so ask this after its calls: they begin with errno 0. */
bool source_is_sound(const struct image *image, struct error *err);
/* Refuses a page with libtiff's message. */
bool image_refuse_broken(const struct image *image, int page, struct error *err);
/* Finds the layout of the current directory, and lets libtiff decode JPEG as RGB. Refuses pages
 * that cannot be read. */
bool image_layout(const struct image *image, int page, struct sample_layout *out,
                  struct error *err);

/* decode.c: returns whether a block, a tile or a strip, has neither bytes nor a place. */
bool block_is_missing(struct tiff *tiff, uint32_t block);

/* mipmaps.c: returns how many levels a texture of this size has, and counts their texels. */
int mipmap_levels(int width, int height, size_t *texels);
/* Makes all levels behind the first one: each texel is the average of the part of level 0 that it
 * covers, summed in double precision and rounded once. */
void mipmaps_make(float *plane, int width, int height, int n_levels);

/* image.c: makes pages at rgb_knot_nm of a picture of one page. */
bool image_spread(struct image *image, struct error *err);

/* png.c: a PNG file (ISO/IEC 15948:2004), written from the top. Its bytes do not depend on how many
 * rows come at once. The output is the caller's, and stays where it is; png_open opens it. */
bool png_open(struct png **out, struct output *output, const char *path,
              const struct picture_options *options, struct error *err);
bool png_write(struct png *png, const void *samples, int rows, struct error *err);
bool png_finish(struct png *png, struct error *err);
void png_free(struct png *png); /* NULL is fine */
/* The filters; each predicts a byte from its neighbours. The last one takes that of them which is
 * nearest to left + above - corner. */
enum { FILTER_NONE, FILTER_SUB, FILTER_UP, FILTER_AVERAGE, FILTER_PAETH, FILTERS };
int png_paeth(int left, int above, int corner);

/* foreign.c: decodes an open file of such a format, and lets its client read the samples. */
bool foreign_read(struct image *image, const char *format, struct error *err);

#endif
