/* SPDX-License-Identifier: MIT */
/* The room "compare": finds where and by how much two stacks differ. */
#ifndef COMPARE_H
#define COMPARE_H

#include "data/options/options.h"
#include "data/stack/stack.h"
#include "spectral.h"

/* ---- compare.c: the differences of two stacks ---- */

/* Measures of the difference of two pixels: the angle between their spectra in degrees, and colour
 * differences. A is the standard of CIE94. */
enum pixel_measure { SPECTRAL_ANGLE, CIE76, CIE94, CIEDE2000, PIXEL_MEASURES };
enum tolerance_unit { /* the last three in the order of colour differences */
                      TOLERANCE_RADIANCE,
                      TOLERANCE_PERCENT,
                      TOLERANCE_CIE76,
                      TOLERANCE_CIE94,
                      TOLERANCE_CIEDE2000
};
struct tolerance {
    double value;
    enum tolerance_unit unit; /* of per cent, 100 is A's largest radiance */
};
/* Reads "0.01", "0.1%", "0.5dE00", "0.5dE94" or "0.5dE76". Messages name `option`. */
bool tolerance_read(const char *option, const char *text, struct tolerance *out, struct error *err);
struct compare_options {
    const char *observer, *white; /* white NULL: what A records */
    const char *map;              /* PNG or TIFF to write; NULL: none */
    struct tolerance tolerance;
    int threads;
    struct outputs *outputs; /* get the map; NULL: it appears at once */
};
struct band_difference {
    double largest; /* |A - B|, in radiance */
    int x, y;       /* the first pixel with this difference */
    double rms;
};
/* A measure over all pixels. */
struct pixel_difference {
    double mean, largest;
    double quantile_95; /* 95 % of the pixels do not exceed it; too high by less than 1/1024 */
    int x, y;           /* the pixel of the largest */
};
/* A map shows all three numbers of each pixel (in a TIFF), or one of them in colours. */
enum map_measure { MAP_NUMBERS, MAP_CIEDE2000, MAP_RADIANCE, MAP_COMPONENT };
struct comparison {
    int n, width, height;
    bool components;               /* in both stacks: wavelengths_nm is 1, 2, ... */
    double *wavelengths_nm;        /* owned */
    struct band_difference *bands; /* of each; owned */
    struct band_difference all;
    int largest_band;        /* the band that has all.largest */
    double largest_radiance; /* of A */
    struct pixel_difference pixels[PIXEL_MEASURES];
    bool has_white; /* without, there are no colours */
    char *observer; /* owned */
    enum map_measure map;
};
/* Compares stack A with stack B. Refuses stacks of different size or wavelengths (EXIT_INPUT),
 * components of different samplings, and a tolerance of colours without a white. The weights of A's
 * sampling give the colours. A TIFF map has three float samples a pixel: the largest |A - B| of all
 * pages, the angle between the spectra or components in degrees, CIEDE2000 (0 without a white). A
 * PNG map has the colours of scale_colour: for CIEDE2000 from 1/64 on, or without a white for the
 * largest |A - B| from 1/16384 on. The map is written even if the stacks differ. */
bool compare(const char *a, const char *b, const struct compare_options *options,
             struct comparison *out, struct error *err);
bool comparison_is_within(const struct comparison *comparison, const struct tolerance *tolerance);
void comparison_print(const struct comparison *comparison, struct printed *to);
/* json.c: begins a text with one JSON object. */
void comparison_json(const struct comparison *comparison, bool within, struct json *json);
void comparison_free(struct comparison *comparison);

/* ---- rows.c: a stack in chunks of rows ---- */

struct stack_rows {
    struct cube cube;
    int most;       /* rows in a chunk */
    int first, n;   /* the rows of the current chunk */
    size_t stride;  /* samples from one page to the next */
    float *samples; /* [page][row of the chunk][x]; owned */
};
/* Allocates chunks of at most so many samples, but at least one row. The cube is open. */
bool rows_allocate(struct stack_rows *rows, size_t most_samples, struct error *err);
/* Reads the chunk that begins with row `first`. The last chunk may have fewer rows. */
bool rows_read(struct stack_rows *rows, int first, struct error *err);
void rows_close(struct stack_rows *rows); /* and the cube */

/* ---- command.c: spectral compare ---- */

/* Prints the differences of two stacks. Fails with EXIT_DIFFERENT where they exceed the tolerance.
 */
bool command_compare(struct options *options, struct error *err);
/* Refuses a value that --tolerance cannot use; `option` is blamed. */
bool compare_accepts_tolerance(const char *option, const char *value, struct error *err);

#endif
