/* SPDX-License-Identifier: MIT */
/* What only the files of the room "images" share. */
#ifndef DATA_IMAGES_INSIDE_H
#define DATA_IMAGES_INSIDE_H

#include "data/images/images.h"

/* reading.c: opens the file with libtiff. */
bool source_open(struct image *image, struct error *err);
/* Reads bytes of the file. Returns false at its end, or where the system failed. */
bool source_bytes(const struct image *image, uint64_t offset, size_t length, void *out);
/* Returns whether each read so far succeeded, and memory sufficed. libtiff goes on without what it
 * could not read, so ask this after its calls: they begin with errno 0. */
bool source_is_sound(const struct image *image, struct error *err);

/* Refuses a page (from 0; -1: the file). The message has its wavelength, if that is recorded. */
bool PRINTF_LIKE(4, 5)
    image_refuse(const struct image *image, int page, struct error *err, const char *format, ...);
/* Refuses a page with libtiff's message. */
bool image_refuse_broken(const struct image *image, int page, struct error *err);
/* Finds the layout of the current directory, and lets libtiff decode JPEG as RGB. Refuses pages
 * that cannot be read. */
bool image_layout(const struct image *image, int page, struct sample_layout *out,
                  struct error *err);

/* metadata.c: the wavelength and scale of a page. An item of GDAL_METADATA ends at a '<'. */
enum item { ITEM_WAVELENGTH, ITEM_UNIT, ITEM_MICROMETRES, ITEM_SCALE, ITEM_OFFSET, ITEMS };
/* Stores the items of the current directory in out[band * ITEMS + item]; NULL stays where there is
 * none. A directory of one band need not number it. */
void metadata_items(struct tiff *tiff, int n_bands, const char **out);
/* Returns a page's wavelength in nm; 0: its unit, file->unit, is unknown; NaN: it records none. */
double metadata_wavelength(struct image_file *file, const char *const items[ITEMS]);
/* Finds the scale. Float samples are radiances themselves. Counts have the same scale in all pages;
 * a stack of this program has its exact value in the description of page 0. */
bool metadata_scale(struct image *image, int page, const struct sample_layout *layout,
                    const char *const items[ITEMS], struct error *err);
/* Reads the first page's description and verdict. */
bool metadata_description(struct image *image, struct error *err);

/* png.c: a PNG file (ISO/IEC 15948:2004), written from the top. Its bytes do not depend on how many
 * rows come at once. */
bool png_open(struct png **out, const char *path, const struct picture_options *options,
              struct error *err);
bool png_write(struct png *png, const void *samples, int rows, struct error *err);
bool png_finish(struct png *png, struct error *err);
bool png_commit(struct png *png, struct outputs *outputs, struct error *err);
void png_free(struct png *png); /* an uncommitted file is gone; NULL is fine */

#endif
