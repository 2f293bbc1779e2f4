/* SPDX-License-Identifier: MIT */
/* The room "see": stacks as a detector sees them; where and by how much two stacks differ; the
 * spectrum of a pixel or a region, of a stack, or of a scene with the spectra that contribute to
 * it; charts as SVG. */
#ifndef RASTER_BESIDE_SEE_SEE_H
#define RASTER_BESIDE_SEE_SEE_H

#include "data/base/base.h"
#include "data/files/files.h"
#include "data/stack/stack.h"
#include "data/text/text.h"
#include "spectral.h"

/* Lengths in SVG's pixels, 96 an inch. */
enum {
    CHART_WIDTH = 800,
    CHART_LEFT = 84,
    CHART_TOP = 52,
    CHART_MARGIN = 28,     /* on the right, without an axis there */
    CHART_RIGHT_AXIS = 72, /* on the right, with an axis there */
    CHART_TICK = 5,
    CHART_LEGEND_ROW = 20,
    CHART_TITLE_SIZE = 16,
    CHART_LABEL_SIZE = 13,
    CHART_TEXT_SIZE = 12
};

/* An axis from `low` to `high` on its scale: values over the unit, or decimal logarithms. */
struct axis {
    bool logarithmic;
    double low, high;
    double unit, step; /* linear: the unit is a power of ten; the step between ticks is in units */
    int exponent;      /* of the unit; 0: labels are values */
    int decimals;      /* of a label */
    bool clipped;      /* logarithmic: smaller values lie at the low end, */
    double least;      /* whose value is this one */
};
/* The rectangle that the axes enclose. Its left edge is at CHART_LEFT, its top at CHART_TOP. */
struct chart_area {
    struct printed *to; /* the SVG file */
    double width;
    int height;
    struct axis x, y, right;
};

/* ---- chart.c: what all charts have ---- */

/* Writes the beginning of a file of this height, with the title. */
void chart_head(struct printed *to, const char *title, int height);
/* Writes a text, escaped. The last of more than `most` characters becomes an ellipsis. A character
 * that XML cannot hold becomes U+FFFD. */
void chart_text(struct printed *to, const char *text, int most);
int chart_fitting(double width, int size); /* characters that fit into a width */
int chart_text_length(const char *text);   /* in characters of UTF-8 */
/* A legend, filled column by column. Makes one of n cells in 1 to 3 columns. Each cell has room for
 * a sample of this width and a text of `longest` characters, unless there is one column only. */
struct chart_legend {
    int rows;
    double column; /* width */
};
struct chart_legend chart_legend(int n, int longest, double sample);
/* Return the left edge and the middle of a cell. */
double legend_x(const struct chart_legend *legend, int cell);
double legend_y(const struct chart_legend *legend, int top, int cell);

/* ---- axis.c ---- */

/* Makes a logarithmic axis with some room beyond the decimal logarithms low and high; from 0.1 to 1
 * if low > high. */
struct axis axis_logarithmic(double low, double high);
double decimal_logarithm(double value); /* of a finite value above 0 */
/* Return the place of a value in the SVG file. On a logarithmic axis values below its low end, and
 * 0, lie at that end. */
double chart_x(const struct chart_area *area, double value);
double chart_y(const struct chart_area *area, const struct axis *axis, double value);
/* Draws the border and the axes: ticks, grid lines, labels. The labels of the axes are those of x,
 * y, and the axis on the right, which has no grid lines; NULL: there is none. The x axis lies below
 * the area and a strip of this height. */
void chart_axes(const struct chart_area *area, const char *const labels[3], int strip);

/* ---- command.c: spectral develop ---- */

/* Plots spectra; without an option for that it is show_command. */
extern const struct command curves_command;
/* Writes the picture of a stack that a detector sees. */
extern const struct command develop_command;

/* The picture of a scene, as a detector sees it without adaptation on an sRGB display. */
struct scene_picture {
    const char *detector;    /* NULL: cie1931 */
    bool automatic;          /* at the exposure that "develop --exposure auto" finds; otherwise 1 */
    const char *output;      /* the path of a PNG */
    struct outputs *outputs; /* as output_pass takes them */
    struct printed *memory;  /* takes the PNG in place of a file; NULL: a file */
    uint64_t out_of_gamut;   /* found: pixels with a clipped channel */
};
/* Draws a scene by the reference, and writes its picture. Samples of the scene's plan are floats.
 * Memory beside picture->memory does not grow with the picture's height. */
struct lit_scene;
bool develop_scene(const struct lit_scene *lit, struct scene_picture *picture, struct error *err);
/* Returns a scene as if it were a stack without a record. Nothing of it is owned. */
struct cube scene_cube(const struct scene *scene);

/* ---- maps.c: maps of a picture ---- */

/* Writes float pages of the weights of all lights, textures, places, and with --illumination the
 * radiance of a perfect diffuser in each band. Their record has the spectra of all terms. */
extern const struct map_maker reference_maps;

/* ---- sight.c: how a detector sees a stack ---- */

/* Finds the weights of the pages in each channel: out[channel * n_pages + page]. They follow from
 * the sampling that the stack records, otherwise from detector_weights. Refuses weights too large
 * to compute with, and, for a fixed sampling, any detector but its own. */
bool cube_weights(const struct cube *cube, const struct detector *detector, double *out,
                  struct error *err);
/* Finds the response of such weights to a radiance of 1 everywhere. Fails where memory runs out. */
bool cube_equal_response(const struct cube *cube, const struct detector *detector,
                         const double *weights, double out[3], struct error *err);
/* Finds the part of each sensitivity outside the range of the pages, as detector_lost. */
void cube_lost(const struct cube *cube, const struct detector *detector, double *out);
/* Finds the white's radiance at each page's wavelength (for box its mean), n_pages values. The
 * white is the SPECTRUM that the word of a command line names; NULL: the one that the stack
 * records. Refuses a stack that records none, and a white that is 0 everywhere. */
bool cube_white(const struct cube *cube, const char *spectrum, double *out, struct error *err);
struct white_request {
    const char *spectrum; /* as cube_white takes it */
    bool needed;          /* refuse a stack without a white, even if `spectrum` is NULL */
};
/* Finds the response of weights (cube_weights) to a white; in a fixed stack, the response of its
 * detector to the white at every nm. *found: there is a white. Refuses a missing white that is
 * needed or named, and a white too large to compute with. */
bool cube_white_response(const struct cube *cube, const struct white_request *request,
                         const double *weights, bool *found, double out[3], struct error *err);
/* How an observer sees a stack. */
struct sight {
    double *weights; /* of X, Y and Z, as cube_weights, times cube_luminance; owned */
    double white[3]; /* XYZ, likewise */
    bool has_white;
};
/* Refuses what observer_read, cube_weights and cube_white_response refuse. */
bool sight_make(const struct cube *cube, const char *observer, const struct white_request *white,
                struct sight *out, struct error *err);
void sight_free(struct sight *sight);
/* Reads the numbers of the objects at n pixels of a row, from 1, with names in record.objects. 0 is
 * the background; -1 means an unknown number, or a stack without an object map. */
bool cube_objects(const struct cube *cube, int x, int y, int n, int *out, struct error *err);

/* ---- compare.c: what counts as equal ---- */

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

/* ---- compare.c: a stack in chunks of rows ---- */

struct stack_rows {
    struct cube cube;
    int end;        /* of the rows that are wanted; rows_allocate takes all of the picture */
    int most;       /* rows in a chunk */
    int first, n;   /* the rows of the current chunk */
    size_t stride;  /* samples from one page to the next */
    float *samples; /* [page][row of the chunk][x]; owned */
};
/* Allocates chunks of at most so many samples, but at least one row. The cube is open. */
bool rows_allocate(struct stack_rows *rows, uint64_t most_samples, struct error *err);
/* Reads the chunk that begins with row `first`. The last chunk may have fewer rows. */
bool rows_read(struct stack_rows *rows, int first, struct error *err);
void rows_close(struct stack_rows *rows); /* and the cube */

/* ---- command.c: spectral compare ---- */

/* Prints the differences of two stacks. Fails with EXIT_DIFFERENT where they exceed the tolerance.
 */
extern const struct command compare_command;

/* ---- command.c: spectral probe ---- */

/* Prints the spectrum of a region of a stack or of a scene, as text, CSV or SVG. */
extern const struct command probe_command;

#endif
