/* SPDX-License-Identifier: MIT */
/* The room "see": stacks as a detector sees them; where and by how much two stacks differ; the
 * spectrum of a pixel or a region, of a stack, or of a scene with the spectra that contribute to
 * it; charts as SVG. */
#ifndef RASTER_BESIDE_SEE_SEE_H
#define RASTER_BESIDE_SEE_SEE_H

#include "data/stack/stack.h"

struct lit_scene;
struct picture;
struct plan;

/* ---- chart.c: lines and points between axes ---- */

enum chart_kind {
    CHART_LINE,    /* a line through its points */
    CHART_BARS,    /* a thin line: bars, with a point that is not finite between two */
    CHART_STEPS,   /* first along x, then along y; with disks at its points */
    CHART_CIRCLES, /* small circles */
    CHART_RINGS    /* larger ones, around points of other series */
};
/* A name and n points. A point that is not finite, or not above 0 on a logarithmic axis, is left
 * out and interrupts a line. */
struct chart_series {
    const char *name; /* in the legend */
    enum chart_kind kind;
    int n;
    const double *x, *y;
    bool right;                /* y is on the axis on the right */
    const char *const *labels; /* names of the points, which get numbers; NULL: they have none */
};
struct chart {
    const char *title, *x_label, *y_label;
    const char *right_label;           /* NULL: there is no axis on the right */
    bool logarithmic;                  /* all axes */
    const struct chart_series *series; /* the first one is the subject, and lies on top */
    int n;
};
/* Prints a whole SVG 1.1 file. Linear axes of y contain 0. A legend names series and labels. */
void chart_svg(const struct chart *chart, struct printed *to);

/* ---- command.c: spectral develop ---- */

/* Plots spectra; without an option for that it is show_command. */
extern const struct command curves_command;
/* Writes the picture of a stack that a detector sees. */
extern const struct command develop_command;

/* --exposure, of pictures and pages. */
extern const struct option_list exposure_option;
/* Returns the factor that --exposure names, or `usual` where it is not given; 0: "auto". */
double exposure_factor(const struct options *options, const char *usual);

/* Draws a scene by the reference, and writes a PNG of it, as the options' detector sees it without
 * adaptation on their display, at their exposure, by default that of "develop --exposure auto": to
 * the options' output; or to *memory, unless that is NULL. *exposure is its factor; *out_of_gamut:
 * pixels with a clipped channel. Samples of the scene's plan are floats. Memory beside *memory does
 * not grow with the picture's height. */
bool develop_scene(const struct lit_scene *lit, struct options *options, struct printed *memory,
                   double *exposure, uint64_t *out_of_gamut, struct error *err);
/* Makes a cube of a scene: a stack that records its white and nothing else. The caller frees
 * record.white.value, also after a failure; the scene owns the rest. */
bool scene_cube(const struct scene *scene, struct cube *out, struct error *err);

/* ---- maps.c: maps of a picture ---- */

/* Opens a file of pages that is no stack. It gets this record, and the pages these names, in lines;
 * both texts are freed. */
bool named_pages_open(struct stack_writer *out, const char *path, struct stack_options layout,
                      struct printed *record, struct printed *names, struct error *err);
/* Ends it: its pages were written, or (done: false) there was a failure. It says why it has no
 * check, and goes to the outputs. */
bool named_pages_end(struct stack_writer *writer, bool done, const char *check,
                     struct outputs *outputs, struct error *err);

/* Writes float pages of the weights of all lights, textures and places. Their record has the
 * spectra of all terms. */
extern const struct map_maker reference_maps;

/* ---- decomposition.c: a picture as weights and textures ---- */

/* Pages of numbers, one for each position of the picture. First come the weights of the terms: page
 * 0 is the constant one; 1 + 2 i and 2 + 2 i are the diffuse and the specular one of light i. Then
 * come the values of textures in each band; there is one page if none is spectral. */
struct decomposition {
    bool own_wavelengths; /* textures: only spectral ones, on pages of their own wavelengths */
    /* Takes a page of some rows of a tile; all weights of a tile come before its textures. The
     * background is 0, and a texture that does not exist 1; with own_wavelengths 0. */
    bool (*take)(void *context, const struct picture *picture, int page, const float *values,
                 struct error *err);
    void *context;
};
int weight_pages(const struct plan *plan);
int texture_pages(const struct plan *plan, bool own_wavelengths);
/* Draws the picture by the reference, in parts. The plan is exchangeable. Textures that have no
 * pages are a part of the weights: those that are not spectral, unless the plan is untextured. */
bool decompose(const struct lit_scene *lit, const struct decomposition *of, struct error *err);

/* ---- sight.c: how a detector sees a stack ---- */

/* Finds the white's radiance at each page's wavelength (for box its mean), n_pages values. The
 * white is the SPECTRUM that the word of a command line names; NULL: the one that the stack
 * records. Refuses a stack that records none, and a white that is 0 everywhere. */
bool cube_white(const struct cube *cube, const char *spectrum, double *out, struct error *err);
struct seeing {
    const char *detector; /* a name, or a file */
    const char *matrix;   /* a file that takes its channels to XYZ; NULL: none */
    const char *white;    /* as cube_white takes it */
    bool needs_white;     /* refuse a stack without a white, even if `white` is NULL */
};
/* How a detector sees a stack, whose pages have weights in each channel. Of a fixed sampling, only
 * its own detector sees it. */
struct sight {
    struct detector detector;   /* owned */
    int n;                      /* channels: the detector's, or with a matrix three */
    bool observes;              /* they are XYZ */
    double *weights;            /* [channel * n_pages + page]; owned */
    double lost[MOST_CHANNELS]; /* parts of sensitivities outside the range, as detector_lost */
    /* A detector of three channels has responses to the white, and to a radiance of 1. */
    bool has_white;
    double white[3], equal[3];
};
/* The first one, of a detector of three channels, is in the unit of the radiances. The others are
 * in cd m-2 where radiances are absolute: of an observer; of a detector of three channels, where a
 * camera needs a white, by which it is balanced; of any number of channels, without a white and
 * responses. */
enum sight_kind { SIGHT_RELATIVE, SIGHT_OF_OBSERVER, SIGHT_OF_PICTURE, SIGHT_OF_CHANNELS };
/* Makes a sight. Refuses what the readers of detectors and cube_white refuse, and weights or a
 * white too large to compute with. The caller frees *out, zeroed before, also after a failure. */
bool sight_make(const struct cube *cube, enum sight_kind kind, const struct seeing *by,
                struct sight *out, struct error *err);
void sight_free(struct sight *sight);
/* Reads the numbers of the objects at n pixels of a row, from 1, with names in record.objects. 0 is
 * the background; -1 means an unknown number, or a stack without an object map. */
bool cube_objects(const struct cube *cube, int x, int y, int n, int *out, struct error *err);

/* ---- compare.c: how far a stack is off ---- */

struct peak {
    double largest;
    int x, y; /* the first pixel that has it */
};
/* A measure over the pixels that are not black in both stacks. */
struct pixel_difference {
    struct peak peak;
    double mean;
    double quantile_95; /* 95 % of the pixels do not exceed it; too high by less than 1/1024 */
};
/* A stack that others are compared with, as an observer sees it. Set the path, and zero the rest.
 */
struct seen_stack {
    const char *path;
    bool complete; /* the pixels are known */
    struct seen_pixel {
        double xyz[3];
        bool black; /* on all pages */
    } * pixels;     /* owned by the caller */
};
/* Finds how far stack B is off from A in CIEDE2000, as an observer sees both with the white that A
 * records. The wavelengths of the two may differ. A is read the first time; its observer stays.
 * Refuses what compare refuses, and an A without a white. The caller frees a->pixels. */
bool stack_difference(struct seen_stack *a, const char *b, const char *observer, int threads,
                      struct pixel_difference *out, struct error *err);

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
/* Refuses options that change a scene beside a stack, the operand, but for detector and display. */
bool stack_refuses_changes(const struct options *options, struct error *err);

#endif
