/* SPDX-License-Identifier: MIT */
/* Only the files of the room "see" include this. */
#ifndef RASTER_BESIDE_SEE_INSIDE_H
#define RASTER_BESIDE_SEE_INSIDE_H

#include "raster/beside/colour/colour.h"
#include "raster/beside/see/see.h"
#include "raster/render/render.h"

size_t picture_pixels(const struct picture *picture); /* decomposition.c */

/* ---- radiances.c ---- */

/* A band of some rows of a tile. */
struct drawn_band {
    const struct picture *picture; /* its positions; NULL: of a stack */
    struct rectangle pixels;       /* whose means the radiances are */
    int band;
    const float *radiance; /* row by row without gaps */
};
struct radiances {
    int threads; /* 1: rows are used from the top */
    void (*use)(void *context, const struct drawn_band *band);
    void *context;
};
/* Draws a region of the picture of a scene, whose plan has samples of floats, and gives `use` the
 * bands of each part of it in their order. Refuses a radiance that is not finite. */
bool radiances_each(const struct lit_scene *lit, const struct rectangle *pixels,
                    struct radiances *of, struct error *err);

/* ---- sight.c ---- */

/* Returns how a command line sees a stack. */
struct seeing seeing_of(const struct options *options, bool needs_white);
/* Makes the sights of a probe: of an observer, who sees colours; of a camera, in its channels,
 * beside which cie1931 sees colours, or the camera by its matrix. An observer is no camera, which
 * then has no channels. The caller frees both, zeroed before. */
bool sights_make(const struct cube *cube, const struct options *options, struct sight *camera,
                 struct sight *colours, struct error *err);

/* ---- develop.c ---- */

/* Raw values lie in a stack of one page a channel: linear, without balance, adaptation or display.
 * The value is the sum over pages of radiance x sensitivity x width of the page in nm
 * (detector_weights), times the exposure. */
enum develop_values { DEVELOP_RGB, DEVELOP_XYZ, DEVELOP_LAB, DEVELOP_RAW };
/* A stack that is being developed. */
struct development {
    /* The caller sets these, and zeroes all others. */
    struct options *options; /* detector, white, exposure, threads and output; its outputs get the
                                picture */
    struct adaptation adaptation; /* a luminance of 0 is found */
    struct display display;
    enum develop_values values;
    int bits; /* 8 or 16 of RGB; 32 of floats, as XYZ and CIELAB are; of raw values 32, or 16
                 of counts of the largest */
    struct printed *memory;      /* takes a PNG in place of a file; NULL: a file */
    const struct lit_scene *lit; /* is drawn in place of a stack, and has a cube; NULL: none */
    /* The findings. */
    double exposure; /* factor of all radiances */
    bool automatic;  /* it brings the largest displayed value (or Y) of the picture to just 1 (or
                        100), or the largest raw value to 1 */
    struct cube cube;
    double first_nm, last_nm; /* of pages, or of the range of components */
    struct sight sight;       /* weights: of the display's channels, of XYZ, or of raw values */
    double adapted_white[3];  /* to which an observer has adapted */
    double full_scale;        /* of raw counts: the largest value with the exposure; of floats 1 */
    struct counter clipped;   /* RGB: pixels with a channel that is clipped by more than 1e-6;
                                 otherwise: values below 0 */
    /* A chunk of rows. */
    int most;        /* rows */
    size_t stride;   /* of its channels: pixels of that many rows */
    int first;       /* of the rows at hand */
    size_t n;        /* pixels of the rows at hand */
    float *radiance; /* of a page of a stack; owned */
    double *sums;    /* [channel][pixel]; owned */
    void *samples;   /* as picture_write takes them, or pages of raw values; owned */
};
/* Reads the stack that is the operand and writes a picture of it, whose format follows from the
 * ending of its name; a PNG has no XYZ, no Lab and no raw values. The channels of cameras and films
 * are balanced: each is divided by the white's. Refuses adaptation, XYZ and Lab for them. The
 * caller frees *of, also after a failure. */
bool develop(struct development *of, struct error *err);
const char *raw_unit(const struct development *of); /* of raw values */
/* Prints the detector of a sight, and the file of its matrix, unless that is NULL. */
void print_detector(struct printed *to, const struct sight *sight, const char *matrix);
/* Prints a white in a detector's channels, and where it comes from. */
void print_white(struct printed *to, const double white[3], bool is_xyz, const char *source);
/* Prints all that decides a developed picture, except the stack. */
void develop_print_settings(const struct development *of, struct printed *to);
void develop_free(struct development *of);
/* weights.c: finds the weights that take the pages of the cube to linear display channels, to XYZ
 * (also for CIELAB), or to raw values, at exposure 1. Fills in all that is found but what pixels
 * decide. Refuses a detector that sees none of the wavelengths of a stack. */
bool develop_weights(struct development *of, struct error *err);

/* ---- compare.c: what counts as equal ---- */

/* Measures of the difference of two pixels: the largest |A - B| of their pages, the angle between
 * their spectra in degrees, and colour differences. A is the standard of CIE94. */
enum pixel_measure { RADIANCE, SPECTRAL_ANGLE, CIE76, CIE94, CIEDE2000, PIXEL_MEASURES };
struct tolerance {
    double value;
    enum pixel_measure measure;
    bool percent; /* of A's largest radiance */
};

/* ---- compare.c: the differences of two stacks ---- */

enum { N_BINS = 1 << 18 };
struct bin {
    uint64_t count;
    double largest;
};
struct band_difference {
    struct peak peak; /* of |A - B|, in radiance */
    double rms;
};
struct comparison {
    /* The caller sets these, and zeroes all others. */
    struct options *options;    /* its operands are the stacks, and its outputs get the map */
    const char *map;            /* PNG or TIFF to write; NULL: none */
    const char *other_detector; /* sees B, with the matrix of the options; NULL: as A is seen */
    struct tolerance tolerance;
    struct seen_stack *seen; /* compares colours alone: see stack_difference; NULL: pages, too */
    /* Two stacks, and how they differ. */
    struct stack_rows a, b;
    bool alike;         /* pages of the same number mean the same; otherwise colours are compared */
    struct sight sight; /* of A, with the white of both; without a white there are no colours */
    struct sight other; /* of B, unless the pages are alike: those of A hold for both */
    uint64_t n_pixels;  /* that are not black in both */
    struct band_difference *bands; /* of each page; owned */
    struct band_difference all;
    int largest_band;        /* the band that has the peak of `all` */
    double largest_radiance; /* of A */
    struct pixel_difference pixels[PIXEL_MEASURES];
    struct bin *bins; /* of each measure; owned */
    bool coloured;    /* the map shows one measure, in colours */
    /* The rows at hand; all are owned. */
    double *spectra;                    /* [row][a, b][band]: the pixel at hand */
    struct band_difference *row_bands;  /* [row][band]; rms: sum of squares so far */
    double *largest_a;                  /* [row] */
    double (*measures)[PIXEL_MEASURES]; /* [row][x] */
    bool *black;                        /* [row][x]: in both stacks */
    float *samples; /* of the map: [channel][row][x]; or its bytes: [row][x][channel] */
    struct picture_writer picture;
};
/* Compares stack A with stack B. Where their wavelengths, components or samplings differ, it
 * compares their colours alone, by the weights of either's sampling; otherwise those of A hold for
 * both. Means and quantiles are of the pixels that are not black in both. Refuses stacks of
 * different size (EXIT_INPUT) or units, and a tolerance or a map that the colours do not have. A
 * TIFF map has three float samples a pixel: the largest |A - B| of all pages, the angle between the
 * spectra or components in degrees, CIEDE2000 (0 without a white). A PNG map has the colours of
 * scale_colour: for CIEDE2000 from 1/64 on, or without a white for the largest |A - B| from 1/16384
 * on. The map is written even if the stacks differ. The caller frees *of, also after a failure. */
bool compare(struct comparison *of, struct error *err);
/* Returns how A or B is seen: a matrix is the other detector's, if there is one. */
struct seeing comparison_seeing(const struct comparison *of, bool is_b);
/* Refuses radiances in different units, of two stacks of this program. */
bool check_units(const struct cube *a, const struct cube *b, struct error *err);
/* Adds the measure of a pixel to those of all; ends them: see struct pixel_difference. */
void measure_add(struct pixel_difference *to, struct bin *bins, double value, int x, int y);
void measure_end(struct pixel_difference *of, const struct bin *bin, uint64_t n_pixels);
/* probe_objects.c: finds the CIEDE2000 of each object that both stacks show, of the means of its
 * pixels that are beside no other object; then n_pixels is that of objects, and x of the peak the
 * number of one. Adds a line and a JSON object for each, and the white. Refuses other objects and
 * units. */
bool objects_compare(struct comparison *of, struct json *json, struct printed *to,
                     struct error *err);
bool comparison_is_within(const struct comparison *of); /* the tolerance */
/* Prints the meaning of the colours of a map that has some, in a line without its end. */
void comparison_print_colours(const struct comparison *of, struct printed *to);
void comparison_free(struct comparison *of);

/* ---- probe.c: tables of spectra ---- */

/* A column of a table; the first one holds the wavelengths. */
struct column {
    char name[96];    /* e.g. "light 1 (d65)", "reflectance" */
    const char *unit; /* NULL: none */
    double *values;   /* one for each wavelength; NaN: there is none */
};
/* Writes the name of a column, with its unit. */
enum { COLUMN_HEADING = 160 };
void column_heading(const struct column *column, char out[COLUMN_HEADING]);
/* Print n rows of columns: as text; as CSV, below their headings. */
void columns_print(const struct column *columns, int n_columns, int n, struct printed *to);
void columns_print_csv(const struct column *columns, int n_columns, int n, struct printed *to);

/* ---- probe.c: the spectrum of a region ---- */

/* The columns of a probe: the wavelengths; the radiance, and its standard deviation over the
 * region; then, of a scene, spectra that explain the radiance, e.g. that of a light. Reflectances,
 * excitations and emissions have the unit 1. */
enum { WAVELENGTH, MEAN, SPREAD, CURVES };
struct probe {
    /* The caller sets these, and zeroes all others. */
    struct rectangle at;           /* the region in pixels: not negative; sides of 1 or more */
    const struct options *options; /* the stack or scene, and who sees it under which white */
    const char *wanted; /* an object, by its name or number, in place of a region; NULL: none */
    /* The findings. */
    char *source;  /* stack or scene; owned */
    int n;         /* wavelengths */
    char *object;  /* name of the only object in the region; owned; NULL: unknown, or several */
    bool raw_file; /* of raw values: there are no colours */
    bool absolute; /* radiances are in W sr-1 m-2 nm-1, and Y in cd m-2 */
    struct sight sight;  /* of the observer */
    struct sight camera; /* and of a camera, if the options name one */
    double raw[MOST_CHANNELS], raw_bound[MOST_CHANNELS]; /* its values; by how much these may be off
                                                            since samples are counts */
    double xyz[3], lab[3];  /* of the mean; lab: beside the white, if there is one */
    struct column *columns; /* owned, with their values */
    int n_columns;
    int shown; /* the object, or surface, that all pixels so far show; or a number below */
};
enum { NO_PIXEL = -3, SEVERAL = -2 };
/* Mean and standard deviation of values. Zero it before use. The sums are of differences from the
 * first value, so that the mean of equal values is exact and their deviation is 0. */
struct moments {
    uint64_t n;
    double first, sum, sum_of_squares;
};
void moments_add(struct moments *moments, double value);
void moments_end(const struct moments *moments, double *mean, double *spread); /* of one or more */
/* probe_objects.c: prints the values of each object of the stack that is the operand, as text, CSV
 * or JSON. edges: pixels whose neighbours show other objects count, too. */
bool probe_objects(struct options *options, bool csv, bool edges, struct error *err);
/* Finds the mean radiance, on each page, of an object, by its name or number, from 1. */
bool object_radiance(const char *path, const char *wanted, double *out, struct error *err);
/* Returns the angle in degrees: 0 if both are black, 90 if one is. b is the sum of a multiple of a
 * and of a rest at right angles to a. The rest gives the sine, so that small angles keep their
 * digits. */
double spectral_angle(const double *a, const double *b, int n);
/* against.c: prints how two regions of the stack that is the operand differ. The caller sets of the
 * probes what probe_stack needs. */
bool probe_against(struct options *options, const struct probe *first, const struct probe *second,
                   bool csv, struct error *err);
/* Begins a probe of a stack or scene: copies the wavelengths, and makes room for means and
 * deviations. The cube gives these, the size and the unit. Refuses a region that is not within it.
 */
bool probe_begin(struct probe *probe, const struct cube *cube, struct error *err);
/* Notes the object, or surface, that a pixel shows. */
void note_shown(struct probe *probe, int number);
/* Ends it: the means of the moments of its bands, and their colour under the white of the cube. */
bool probe_end(struct probe *probe, const struct cube *cube, const struct moments *moments,
               struct error *err);
/* probe_objects.c: probes the stack that is the operand: the region, or the object that is wanted,
 * without its edges. Refuses a stack without spectra and a region outside the picture. The caller
 * frees *probe, here and below, also after a failure. */
bool probe_stack(struct probe *probe, struct error *err);

/* Computes the mean radiance of a region by the reference, and lists its curves: the lights and the
 * ambient lights; if the region shows one object only, also its reflectance, specular reflectance,
 * excitation, emission and own light, and the emission of a matrix under each light. The region is
 * one of the plan's picture, whose samples are floats. */
bool probe_scene(struct probe *probe, struct error *err);
void probe_free(struct probe *probe);

/* Writes the pixel or region in words, e.g. "pixel 3,4". */
void region_text(const struct probe *probe, char *out, size_t capacity);

#endif
