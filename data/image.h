/* SPDX-License-Identifier: MIT */
/* Private to data/image.c, data/metadata.c and data/samples.c: a TIFF file that is open. */
#ifndef IMAGE_H
#define IMAGE_H

#include <tiffio.h>

#include "spectral.h"

/* How a page's samples lie in its blocks, which are tiles, or strips as wide as the page: colour i
 * of pixel p is sample i * colour_step + p * pixel_step of the planes of a block. */
struct layout {
    uint32_t width, height, block_width, block_height;
    uint16_t bits, n_samples, n_colours, n_planes;
    uint16_t n_bands; /* pages of its directory */
    uint16_t plane;   /* the first of n_planes */
    size_t block_bytes, colour_step, pixel_step;
    size_t row_bytes;     /* of a plane */
    uint64_t rows_offset; /* where its rows lie one after the other, uncompressed; 0: they do not */
    double largest;       /* sample; 1 where they are float */
    bool tiled, inverted; /* 0 is white */
};
struct page {
    uint64_t directory; /* where it lies */
    struct layout layout;
};
/* Samples of some bands and rows that lie side by side in the file, where to read one band is to
 * read them all: as stored, but band after band. */
struct kept_bands {
    uint32_t first_row, end_row;
    int first_page, end_page;
    char *samples;
};
struct image_file {
    TIFF *tiff;
    const struct builtin_file *builtin; /* NULL: libtiff reads a descriptor */
    uint64_t position;                  /* in it */
    double count_scale;                 /* radiance of a count, by page 0's GDAL metadata */
    struct page *pages;
    uint64_t directory; /* at which libtiff is; 0: none of the pages' */
    struct kept_bands kept;
    const char *channels; /* of its OME-XML, those of the pages to come */
    char unit[32];        /* of a page's wavelength, where it is none that is known */
    bool told;            /* some page tells a wavelength, in whichever unit */
    struct place from;
    bool decoding;     /* a warning then means lost samples */
    char message[256]; /* libtiff's first */
};

/* Items of GDAL_METADATA, a band's: what they hold, up to a '<'. */
enum item { WAVELENGTH, UNIT, MICROMETRES, SCALE, OFFSET, ITEMS };

/* ---- data/image.c ---- */

/* Blames a page (from 0; -1: the file) with its wavelength where it tells one. */
bool PRINTF_LIKE(4, 5)
    image_refuse(const struct image *image, int page, struct error *err, const char *format, ...);
bool image_refuse_broken(const struct image *image, int page, struct error *err);
/* Of the current directory. */
bool image_layout(const struct image *image, int page, struct layout *out, struct error *err);

/* ---- data/metadata.c: what a page says of itself ---- */

/* Those of the current directory go to out[band * ITEMS + item]; NULL: it has none. A directory of
 * one band need not number it. */
void metadata_items(TIFF *tiff, int n_bands, const char **out);
/* In nm; NaN: the page tells none. */
double metadata_wavelength(struct image_file *file, const char *const items[ITEMS]);
/* Float samples are radiances themselves. Counts have one scale in all pages; page 0's description
 * tells it exactly in a stack of our own. */
bool metadata_scale(struct image *image, int page, const struct layout *layout,
                    const char *const items[ITEMS], struct error *err);
bool metadata_description(struct image *image, struct error *err);

#endif
