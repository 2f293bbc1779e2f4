/* SPDX-License-Identifier: MIT */
/* Only the files of the room "images" include this. */
#ifndef DATA_IMAGES_INSIDE_H
#define DATA_IMAGES_INSIDE_H

#include "data/images/images.h"

enum { MEAN_COLOUR = 4 }; /* of sample_layout.colour */

/* How the samples of a page lie in the file: in blocks, which are tiles, or strips as wide as the
 * page. Uncompressed rows that lie one after the other are read in blocks of our own choice, which
 * fit into the processor's cache. */
struct sample_layout {
    uint64_t directory; /* the offset of the page's directory */
    uint32_t width, height, block_width, block_height;
    uint16_t bits, n_samples, n_colours, n_planes;
    uint16_t n_bands; /* pages of its directory */
    uint16_t plane;   /* the first of n_planes */
    uint16_t sample;  /* the first of a pixel there */
    uint16_t colour;  /* of RGB, the one that the page is: 1 red, 2 green, 3 blue; 0: their luma;
                         MEAN_COLOUR: their mean */
    uint64_t block_bytes;
    size_t pixel_step;    /* samples of a pixel in a plane */
    size_t row_bytes;     /* of a plane */
    uint64_t rows_offset; /* the first of such rows; 0: libtiff decodes the blocks */
    double largest;       /* sample of white; 1 of floats */
    double gamma;         /* of stored values: 0 of linear ones; see foreign.c */
    bool tiled, inverted; /* inverted: 0 is white */
    bool has_nodata;
    double nodata; /* see struct page_record */
};
/* The values of n rows from row y on of some pages, page after page. */
struct page_rows {
    uint32_t y, n;
    int page, end_page;
    float *values;
};
/* A file as libtiff reads or writes it. */
struct client {
    int descriptor;                     /* -1: builtin is read */
    const struct builtin_file *builtin; /* NULL: descriptor is read */
    struct pages *pages;                /* that are written; NULL: the file is only read */
    uint64_t position, bytes;           /* where libtiff is; the file's size */
    int cause;                          /* errno of the first call that failed; 0: none did */
    const char *failed;                 /* that call: "cannot be read" */
    bool decoding;                      /* a warning then means that samples are lost */
    char message[1024];                 /* the first of libtiff */
};
struct image_file {
    struct client client;
    double count_scale; /* radiance of a count, by the tags of page 0 */
    struct sample_layout *pages;
    uint64_t directory;            /* where libtiff is; 0: at none of the pages */
    struct page_rows kept;         /* of bands, which lie side by side in the file; owned */
    struct builtin_file converted; /* what client reads of another format */
    unsigned char *pixels;         /* its bytes; owned */
    struct place from;
};

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

/* mipmaps.c: sets the number of levels of a texture whose picture is open, and of the texels of a
 * plane. */
void mipmaps_count(struct texture *texture);
/* Makes all levels of a plane behind the first one: each texel is the average of the part of level
 * 0 that it covers, summed in double precision and rounded once. */
void mipmaps_make(const struct texture *texture, float *plane);

/* image.c: makes pages at rgb_knot_nm of a picture of one page. */
bool image_spread(struct image *image, struct error *err);

/* png.c: a PNG file (ISO/IEC 15948:2004), written from the top. Its bytes do not depend on how many
 * rows come at once. The output is the caller's, and stays where it is; png_open opens it. */
bool png_open(struct png **out, struct output *output, const char *path,
              const struct picture_options *options, struct error *err);
bool png_write(struct png *png, const void *samples, int rows, struct error *err);
bool png_finish(struct png *png, struct error *err);
void png_free(struct png *png); /* NULL is fine */
/* The filters; each predicts a byte from its neighbours. */
enum { FILTER_NONE, FILTER_SUB, FILTER_UP, FILTER_AVERAGE, FILTER_PAETH, FILTERS };

/* foreign.c: decodes an open file of such a format, and lets its client read the samples. */
bool foreign_read(struct image *image, const char *format, struct error *err);

/* Makes a value of 0 to 1 linear: by the power that encoded it, or by sRGB's curve. */
enum { GAMMA_SRGB = -1 };
double linear_value(double gamma, double value);

#endif
