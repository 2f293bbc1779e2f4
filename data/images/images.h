/* SPDX-License-Identifier: MIT */
/* The room "images": TIFF files in, as pages of samples and as textures; TIFF files out, as pages
 * of one format; colour pictures out, as TIFF or PNG. */
#ifndef DATA_IMAGES_IMAGES_H
#define DATA_IMAGES_IMAGES_H

#include "data/files/files.h"

struct tiff; /* libtiff's TIFF */
struct png;

/* ---- image.c: pages and their metadata ---- */

/* A TIFF file of grey or RGB pages of 8 or 16 bits, or of grey pages of 32-bit floats; or a picture
 * in PNG or SGI format. If its only
 * directory has several grey samples a pixel, as GDAL writes bands, each band is a page. */
struct image {
    char *path; /* owned */
    int width, height, n_pages;
    bool coloured;            /* some page is RGB */
    double *wavelengths_nm;   /* of each page, increasing; NULL: some page has none; owned */
    char no_wavelengths[128]; /* why they are NULL: "page 2 records no wavelength" */
    double scale;      /* radiance of value 1 (count 65535 of 16 bits); 1: the file records none */
    char *description; /* of the first page; "": it has none; owned */
    char *verdict;     /* of the check of a stack; "": it has none; owned */
    struct tiff *tiff; /* at the page that is read; NULL: a file of another format */
    uint64_t bytes;    /* of the file */
    int n_recorded;    /* pages that the file says it has; 0: it does not say */
    const char *channels;    /* of its OME-XML, those of the pages that image_tags reads next */
    struct image_file *file; /* owned */
};
/* Finds whether the file is a TIFF file, or an ENVI cube, which image_open refuses by name. Fails
 * only where the system does. */
bool image_is(const char *path, bool *out, struct error *err);
/* The tags of a page. Numbers that are none are NaN. */
struct page_record {
    double wavelength_nm; /* 0: its unit is unknown; NaN: none */
    char unit[32];        /* that is unknown; otherwise "" */
    double count_scale;   /* radiance of a count; -1: none */
    double offset;        /* radiance of count 0 */
    bool has_nodata;      /* GDAL's mark of a pixel without data, */
    double nodata;        /* which is this stored value or NaN; it is read as 0 */
    double full_scale;    /* of the first page: the exact radiance of value 1; -1: none */
};
/* Reads what the current directory records of its n pages, which come behind image->n_pages others.
 * The first directory also has description, verdict and n_recorded. */
typedef bool image_tags(struct image *image, int n, struct page_record *out, struct error *err);
/* Opens the file (or "builtin:..." file) and reads the tags of its pages, but no samples.
 * Refuses, at the place `from`: pages without pixels or of different sizes, other samples than the
 * above, bands without wavelengths, a file that is too short. Refuses a file of another format with
 * the command that converts it. The caller closes *out, also after a failure. */
bool image_open(const char *path, struct place from, image_tags *read_tags, struct image *out,
                struct error *err);
/* Returns whether image_open reads this format (file_format) as it reads TIFF: PNG and SGI. */
bool image_converts(const char *format);
/* Refuses a page (from 0; -1: the file). The message has its wavelength, if that is recorded. */
bool PRINTF_LIKE(4, 5)
    image_refuse(const struct image *image, int page, struct error *err, const char *format, ...);
/* Reads rows y .. y + rows - 1 of a page, width values each, the top row first. A value is 0 to 1,
 * or a float sample, times the scale. An RGB pixel has the luma 0.2126 R + 0.7152 G + 0.0722 B
 * (ITU-R BT.709) of its values. Those of a PNG
 * file that says sRGB or gAMA are made linear. Refuses a value that is negative or not finite, and
 * a file that ends too early. If the page is uncompressed, only these rows are read. If the samples
 * of all bands lie side by side, these rows of up to 256 MB of bands are kept: read the same rows
 * of one page after the other. */
bool image_read(struct image *image, int page, int y, int rows, float *out, struct error *err);
/* The wavelengths at which three colours of unknown spectra are taken, from 0 red to 2 blue.
 * Between them they are linear. They reach beyond all light. */
enum { RGB_KNOTS = 6 };
extern const double rgb_knot_nm[RGB_KNOTS];
extern const int rgb_knot_colour[RGB_KNOTS];
/* Returns whether pixels have an alpha, which is not read. */
bool image_has_alpha(const struct image *image);
/* Returns whether all samples are grey floats. */
bool image_is_float(const struct image *image);
/* Returns by how much a value may be off since it was stored; 0 where no file is open. */
double image_rounding(const struct image *image, double value);
void image_close(struct image *image);

/* ---- decode.c: samples ---- */

/* Reads `length` bytes of the file. Refuses a file that ends before them. */
bool image_read_bytes(const struct image *image, uint64_t offset, size_t length, void *out,
                      struct error *err);

/* Finds how the samples of all pages lie, for a program that knows no TIFF. Refuses
 * colours, grey whose 0 is white, compressed samples, and gaps between pages. */
struct raw_samples {
    uint64_t offset; /* of the first sample in the file */
    int bits;        /* 8 or 16: unsigned; 32: float */
    bool by_pixels;  /* the bands of a pixel lie side by side */
    bool big_endian;
};
bool image_describe(const struct image *image, struct raw_samples *out, struct error *err);

enum { TEXTURE_PLANES = 3 };
/* Planes have rows from t = 0 (the picture's bottom row) upwards, width values each; behind them
 * lie the further levels, each half as wide and high as the one before, rounded down, but at
 * least 1.
 */
struct texture {
    struct image image;           /* open as long as planes are to be loaded */
    bool spectral, rgb;           /* rgb: pages at rgb_knot_nm are made of the only one */
    bool relief;                  /* samples as they are stored, and the mean of colours */
    bool linear;                  /* between texel centres; otherwise the nearest texel */
    bool mipmapped;               /* planes have all levels down to one texel: see mipmaps.c */
    bool shown;                   /* by an object in view; its user keeps this */
    int n_levels;                 /* 1: no mipmaps */
    size_t plane_size;            /* texels of a plane, of all levels */
    double smallest, largest;     /* of all values of all pages */
    float *plane[TEXTURE_PLANES]; /* grey: the first; spectral: those loaded; owned */
    pthread_mutex_t reading;      /* held while the image is read */
};
/* Reads a texture; the caller chooses `linear`, `mipmapped`, `spectral`, `rgb` and `relief` of
 * *out, and zeroes all others. A grey texture is one page with values that hold for every
 * wavelength. A spectral texture is a stack of pages with wavelengths; all of them are read once,
 * to find their smallest and largest value. Refuses a side of more than 16384 texels, since
 * OpenGL's textures have a limit, too. The caller frees *out, also after a failure. */
bool texture_read(const char *path, struct place from, image_tags *read_tags, struct texture *out,
                  struct error *err);
/* Fills the planes for n wavelengths, at most TEXTURE_PLANES: linear between pages, and the end
 * page beyond the first and the last one. Does nothing for a grey texture. */
bool texture_load(struct texture *texture, const double *wavelengths_nm, int n, struct error *err);
/* Does the same with planes of the caller's, which have room for plane_size texels each. Several
 * threads may call it. */
bool texture_fill(struct texture *texture, const double *wavelengths_nm, int n,
                  float *const planes[TEXTURE_PLANES], struct error *err);
void texture_free(struct texture *texture);

/* ---- pages.c: files of uncompressed pages ---- */

/* A file of uncompressed pages of the same format. All directories come first, then all pages
 * without gaps. */
struct pages {
    int count, width, height;
    int channels;      /* 1: grey, 3: RGB */
    int bits;          /* of a sample: 8, 16, or 32 of a float */
    int bytes_behind;  /* of a pixel in a page behind the last one, where no TIFF reader looks */
    const char *room;  /* beginning of a text in the first page; pages_finish writes it */
    size_t room_bytes; /* of that text; room NULL: there is none */
    uint32_t room_tag;
    bool as_stored; /* samples come with their lowest byte first, on any machine */
    /* set by pages_open: */
    struct output output;
    uint64_t first; /* the offset of the first page's pixels */
    uint64_t room_offset;
    bool big; /* BigTIFF */
};

/* Sets those tags of the current directory that describe the page. `of` is the caller's. */
typedef bool page_tags(struct tiff *tiff, const void *of, int page, struct error *err);

/* Writes the directories of the file that the first half of `pages` describes, and reserves the
 * places of the pages. Tags may record the pages_offset of the bytes behind the last page.
 * On failure nothing is left open. */
bool pages_open(struct pages *pages, const char *path, page_tags *set_tags, const void *of,
                struct error *err);
/* Returns the offset of a page's pixels; for page `count`, of the bytes behind the last page. */
uint64_t pages_offset(const struct pages *pages, int page);
uint64_t pages_end(const struct pages *pages);                 /* the size of the whole file */
size_t pages_pixel_bytes(const struct pages *pages, int page); /* likewise */
/* Writes the samples of a rectangle, row by row without gaps. Page `count` is that behind the last
 * one. Rectangles come in any order. */
struct page_rectangle {
    int page, x, y, width, height;
};
bool pages_write(const struct pages *pages, const struct page_rectangle *to, const void *samples,
                 struct error *err);
/* Fills the room with a text (NULL: there is no room). Reads all directories again, and fails if
 * one of them is not complete. */
bool pages_finish(struct pages *pages, const char *room, struct error *err);

/* ---- picture.c: colour pictures ---- */

/* Refuses the name of a picture whose ending is neither .png nor .tif or .tiff. */
bool picture_accepts(const char *path, struct error *err);
bool picture_is_png(const char *path); /* any other picture, as one of /dev/stdout, is a TIFF */

enum { MOST_PAGES_OF_FLOATS = 4 };
struct picture_options {
    int width, height; /* a TIFF above 4 GiB becomes a BigTIFF */
    int bits;          /* of a sample: 8, 16, or 32 of a float, which a PNG has not */
    const char *channels[MOST_PAGES_OF_FLOATS]; /* of floats: "X", "Y", "Z"; NULL: no more */
    bool srgb;                    /* a PNG says so in chunks of its own, and needs no profile */
    const unsigned char *profile; /* ICC; NULL: none */
    size_t profile_length;
    const char *description; /* ASCII */
    struct printed *memory;  /* takes the bytes of a PNG, and no file is written; NULL: a file */
};
/* Replaces all but newlines and printable ASCII by '?', as a description needs it. Returns the
 * text; NULL is fine. */
char *picture_text(char *text);
/* A picture that is written from the top, and appears whole or not at all. RGB is one page of three
 * samples a pixel. Floats are pages, one for each channel, with its name; pages_write fills them,
 * too. A PNG is compressed, and takes the memory of some rows. */
struct picture_writer {
    struct picture_options options;
    int row;            /* the next one */
    struct pages pages; /* of a TIFF; a PNG has its output */
    struct png *png;    /* NULL: a TIFF; owned */
    struct picture_strip {
        char *samples;  /* owned */
        int first, end; /* its rows */
    } strip;            /* rows that are not complete yet */
};
/* The path chooses the format, which picture_accepts; in memory it is a PNG, and the path is a name
 * in messages. */
bool picture_open(struct picture_writer *out, const char *path,
                  const struct picture_options *options, struct error *err);
/* Writes the next rows: three samples a pixel of uint8_t or uint16_t; or floats, all rows of a
 * channel before those of the next. */
bool picture_write(struct picture_writer *writer, const void *samples, int rows, struct error *err);
/* Writes a rectangle of RGB, of page 0, row by row without gaps. Rows are kept until a rectangle
 * reaches the right border: it comes after all others of its rows, and no row comes before the one
 * above it. */
bool picture_put(struct picture_writer *writer, const struct page_rectangle *at,
                 const void *samples, struct error *err);
/* picture_finish completes the file, and output_pass then lets it appear; picture_commit does both.
 */
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

#endif
