/* SPDX-License-Identifier: MIT */
/* The room "tiff": pictures in, from TIFF files. */
#ifndef DATA_TIFF_H
#define DATA_TIFF_H

#include "data/base/base.h"
#include "spectral.h"

struct tiff; /* libtiff's TIFF */

/* ---- image.c: pages and their metadata ---- */

enum { TAG_VERDICT = 65111 };           /* of a stack of this program: the verdict of its check */
#define STACK_UNFINISHED "not finished" /* the verdict of a stack that is not whole yet */

/* A TIFF file of grey or RGB pages of 8 or 16 bits, or of grey pages of 32-bit floats. If its only
 * directory has several grey samples a pixel, as GDAL writes bands, each band is a page. */
struct image {
    char *path; /* owned */
    int width, height, n_pages;
    bool coloured;            /* some page is RGB */
    double *wavelengths_nm;   /* of each page, increasing; NULL: some page has none; owned */
    char no_wavelengths[128]; /* why they are NULL: "page 2 records no wavelength" */
    double scale;      /* radiance of value 1 (count 65535 of 16 bits); 1: the file records none */
    char *description; /* of the first page; "": it has none; owned */
    char *verdict;     /* of stack_finish; "": it has none; owned */
    struct image_file *file; /* owned */
};
/* Finds whether the file is a TIFF file, or an ENVI cube, which image_open refuses by name. Fails
 * only where the system does. */
bool image_is(const char *path, bool *out, struct error *err);
/* Opens the file (or "builtin:..." file) and reads the metadata of its pages, but no samples.
 * Refuses, at the place `from`: pages without pixels or of different sizes, other samples than the
 * above, bands without wavelengths, a file that is too short. Refuses a file of another format with
 * the command that converts it. */
bool image_open(const char *path, struct place from, struct image *out, struct error *err);
/* Reads rows y .. y + rows - 1 of a page, width values each, the top row first. A value is 0 to 1,
 * or a float sample, times the scale. An RGB pixel has the luma 0.2126 R + 0.7152 G + 0.0722 B
 * (ITU-R BT.709) of its stored values. Refuses a value that is negative or not finite, and a file
 * that ends too early. If the page is uncompressed, only these
 * rows are read. If the samples of all bands lie side by side, these rows of up to 256 MB of bands
 * are kept: read the same rows of one page after the other. */
bool image_read(struct image *image, int page, int y, int rows, float *out, struct error *err);
/* Returns whether all samples are grey floats. */
bool image_is_float(const struct image *image);
void image_close(struct image *image);

/* ---- decode.c: samples ---- */

/* Reads `length` bytes of the file. Refuses a file that ends before them. */
bool image_read_bytes(const struct image *image, uint64_t offset, size_t length, void *out,
                      struct error *err);

/* describe.c. Finds how the samples of all pages lie, for a program that knows no TIFF. Refuses
 * colours, grey whose 0 is white, compressed samples, and gaps between pages. */
struct raw_samples {
    uint64_t offset; /* of the first sample in the file */
    int bits;        /* 8 or 16: unsigned; 32: float */
    bool by_pixels;  /* the bands of a pixel lie side by side */
    bool big_endian;
};
bool image_describe(const struct image *image, struct raw_samples *out, struct error *err);

/* ---- Inside this room ---- */

/* How the samples of a page lie in the file: in blocks, which are tiles, or strips as wide as the
 * page. Uncompressed rows that lie one after the other are read in blocks of our own choice, which
 * fit into the processor's cache. */
struct sample_layout {
    uint64_t directory; /* the offset of the page's directory */
    uint32_t width, height, block_width, block_height;
    uint16_t bits, n_samples, n_colours, n_planes;
    uint16_t n_bands; /* pages of its directory */
    uint16_t plane;   /* the first of n_planes */
    size_t block_bytes;
    size_t pixel_step;    /* samples of a pixel in a plane */
    size_t row_bytes;     /* of a plane */
    uint64_t rows_offset; /* the first of such rows; 0: libtiff decodes the blocks */
    double largest;       /* sample of white; 1 of floats */
    bool tiled, inverted; /* inverted: 0 is white */
};
/* Rows of some bands as stored, but band after band. In the file the bands lie side by side. */
struct kept_bands {
    uint32_t first_row, n_rows;
    int first_page, end_page;
    size_t band_bytes;
    char *samples;
};
struct image_file {
    struct tiff *tiff;
    int descriptor;                     /* -1: builtin is read */
    const struct builtin_file *builtin; /* NULL: descriptor is read */
    uint64_t position, bytes;           /* where libtiff reads; the file's size */
    int cause;                          /* errno of the first call that failed; 0: none did */
    double count_scale;                 /* radiance of a count, by page 0's GDAL metadata */
    struct sample_layout *pages;
    uint64_t directory; /* where libtiff is; 0: at none of the pages */
    struct kept_bands kept;
    const char *channels; /* of its OME-XML: those of the pages that follow */
    char unit[32];        /* of the last page's wavelength, if it is unknown; otherwise "" */
    struct place from;
    bool decoding;     /* a warning then means that samples are lost */
    char message[256]; /* the first of libtiff */
};

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

#endif
