/* SPDX-License-Identifier: MIT */
/* The room "tiff": TIFF files in, and textures. */
#ifndef DATA_TIFF_H
#define DATA_TIFF_H

#include "data/base/base.h"
#include "spectral.h"

struct tiff; /* libtiff's TIFF */

/* ---- image.c: TIFF files in ---- */

/* The tag in which a stack of this program stores the verdict of its check. */
enum { TAG_VERDICT = 65111 };

/* A TIFF file of grey or RGB pages of 8 or 16 bits, or of 32-bit float grey ones. Where its only
 * directory has several grey samples a pixel, as GDAL writes bands, each of them is a page. */
struct image {
    char *path; /* owned */
    int width, height, n_pages;
    uint64_t bytes;         /* of the file */
    bool coloured;          /* some page is RGB */
    double *wavelengths_nm; /* of each page, increasing; NULL where some page has none; owned */
    char untold[128];       /* why they are NULL, e.g. "page 2 tells no wavelength" */
    double scale; /* radiance of sample value 1 (16 bits: of 65535); 1 where the file has none */
    char *description;       /* of the first page; "" where it has none; owned */
    char *verdict;           /* of stack_finish; "" where it has none; owned */
    struct image_file *file; /* owned */
};
/* Opens the file (or "builtin:..." file) and reads what its pages record of themselves, but no
 * samples. Refuses, in the name of `from`: a file that is no TIFF, pages without pixels or of
 * different sizes, other samples than the above, bands without wavelengths, and uncompressed pages
 * that reach beyond the end of the file. */
bool image_open(const char *path, struct place from, struct image *out, struct error *err);
void image_close(struct image *image);

/* ---- decode.c: samples ---- */

/* Reads rows y .. y + rows - 1 of a page, width values each, the top row first: 0 to 1 (or float
 * samples) times the scale; of RGB the luma 0.2126 R + 0.7152 G + 0.0722 B (ITU-R BT.709) of the
 * stored values. Refuses a value that is negative or not finite, and samples that are cut short. Of
 * an uncompressed page it reads no more than these rows. Where the samples of all bands lie side by
 * side, it keeps those of these rows, up to 256 MB: ask for the same rows of one page after the
 * other. */
bool image_read(struct image *image, int page, int y, int rows, float *out, struct error *err);
/* Reads any bytes of the file. */
bool image_read_bytes(const struct image *image, uint64_t offset, size_t length, void *out,
                      struct error *err);

/* ---- texture.c: pictures on surfaces ---- */

enum { TEXTURE_PLANES = 3 };
/* Planes have rows from t = 0 (the picture's bottom row) upwards, width values each. */
struct texture {
    struct image image; /* open as long as planes are to be loaded */
    bool spectral;
    bool linear;                  /* between texel centres; otherwise the nearest texel */
    double largest;               /* of all values of all pages */
    float *plane[TEXTURE_PLANES]; /* of a grey texture the first; of a spectral one those loaded */
};
/* Reads a texture; the caller chooses `linear` and `spectral` of *out. A grey texture is one page
 * with values that hold for every wavelength. A spectral texture is a stack of pages with
 * wavelengths; all of them are read once, to find their largest value. Refuses a side of more than
 * 16384 texels, since OpenGL's textures have a limit, too. */
bool texture_read(const char *path, struct place from, struct texture *out, struct error *err);
/* Fills the planes for up to TEXTURE_PLANES wavelengths: linear between pages, the end page beyond
 * the first and the last one. A grey texture needs no loading. */
bool texture_load(struct texture *texture, const double *wavelengths_nm, int n, struct error *err);
void texture_free(struct texture *texture);

/* ---- Inside this room ---- */

/* How a page's samples lie in its blocks, which are tiles, or strips as wide as the page. Rows that
 * lie one after the other, uncompressed, are read in blocks that stay in the processor's cache. */
struct sample_layout {
    uint64_t directory; /* the offset of the page's directory */
    uint32_t width, height, block_width, block_height;
    uint16_t bits, n_samples, n_colours, n_planes;
    uint16_t n_bands;               /* pages of its directory */
    uint16_t plane;                 /* the first of n_planes */
    size_t block_bytes, pixel_step; /* in samples, from one pixel to the next */
    size_t row_bytes;               /* of a plane */
    uint64_t rows_offset;           /* where such rows begin; 0: libtiff decodes the blocks */
    double largest;                 /* sample; 1 where they are float */
    bool tiled, inverted;           /* inverted: 0 is white */
};
/* Samples of some bands and rows, where the bands lie side by side in the file and reading one band
 * means reading them all: as stored, but band after band. */
struct kept_bands {
    uint32_t first_row, n_rows;
    int first_page, end_page;
    size_t band_bytes;
    char *samples;
};
struct image_file {
    struct tiff *tiff;
    const struct builtin_file *builtin; /* NULL: libtiff reads a descriptor */
    uint64_t position;                  /* in it */
    double count_scale;                 /* radiance of a count, by page 0's GDAL metadata */
    struct sample_layout *pages;
    uint64_t directory; /* at which libtiff is; 0: none of the pages' */
    struct kept_bands kept;
    const char *channels; /* of its OME-XML, those of the pages to come */
    char unit[32];        /* of the last page's wavelength, where it is unknown */
    struct place from;
    bool decoding;     /* a warning then means lost samples */
    char message[256]; /* libtiff's first */
};

/* Refuses a page (from 0; -1: the file); the message has its wavelength where it records one. */
bool PRINTF_LIKE(4, 5)
    image_refuse(const struct image *image, int page, struct error *err, const char *format, ...);
bool image_refuse_broken(const struct image *image, int page, struct error *err);
/* Finds the layout of the current directory. */
bool image_layout(const struct image *image, int page, struct sample_layout *out,
                  struct error *err);

/* metadata.c: what a page records of itself. */

/* Items of GDAL_METADATA of a band; the text of each ends at a '<'. */
enum item { ITEM_WAVELENGTH, ITEM_UNIT, ITEM_MICROMETRES, ITEM_SCALE, ITEM_OFFSET, ITEMS };

/* Stores the items of the current directory in out[band * ITEMS + item], NULL where it has none. A
 * directory of one band need not number it. */
void metadata_items(struct tiff *tiff, int n_bands, const char **out);
/* A page's wavelength in nm; 0: file->unit, its unit, is unknown; NaN: it records none. */
double metadata_wavelength(struct image_file *file, const char *const items[ITEMS]);
/* Finds the scale. Float samples are radiances themselves. Counts have one scale in all pages; page
 * 0's description has its exact value in a stack of this program. */
bool metadata_scale(struct image *image, int page, const struct sample_layout *layout,
                    const char *const items[ITEMS], struct error *err);
/* Reads the first page's description and verdict. */
bool metadata_description(struct image *image, struct error *err);

#endif
