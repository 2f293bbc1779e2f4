/* SPDX-License-Identifier: MIT */
/* Only the files of the room "cost" include this. */
#ifndef RASTER_BESIDE_COST_INSIDE_H
#define RASTER_BESIDE_COST_INSIDE_H

#include "raster/beside/cost/cost.h"
#include "raster/beside/see/see.h"
#include "raster/render/render.h"

enum { MOST_SAMPLINGS = 32, MOST_RUNS = 5, RENDER_WORDS = 96 };

/* Seconds of processors of the runs of a command line, from exec to exit, in order of size. */
struct timing {
    double seconds[MOST_RUNS];
    int n;
};
double median_of(const struct timing *of); /* NaN: there is no run */

/* A way to render the scene, how far its stack is off, and what it takes. */
struct configuration {
    char words[RENDER_WORDS];      /* options of render, with a blank between two; "": none */
    bool components;               /* its pages are no radiances at wavelengths */
    struct pixel_difference error; /* CIEDE2000 */
    struct timing unchecked;       /* by the reference alone */
    struct timing checked; /* of those that are named, whose error is that of this picture */
    bool best;             /* no other of its kind of pages is cheaper and closer */
    bool named;            /* in the answer */
};

/* A finer way of one kind: its error, and that of the way without it, from the finest one. */
struct refinement {
    char words[RENDER_WORDS]; /* of the finer way, behind those of the typical one; "": none */
    double before, after;     /* errors; before NaN: nothing finer can be drawn */
    double factor;            /* its seconds, as a multiple */
};

struct cost {
    char *scene; /* its name with the changes of the command line; owned */
    const char *observer;
    int width, height;
    bool checked; /* OpenGL draws, and the reference checks it; otherwise the reference draws alone
                   */
    int small_width, small_height; /* of the pictures whose refinement was measured */
    struct configuration every_nm; /* the standard: it has no error */
    struct configuration samplings[MOST_SAMPLINGS];
    int n;                               /* of samplings; by seconds in the end */
    const struct configuration *typical; /* which the other prices are measured with */
    struct timing opengl;                /* seconds of OpenGL alone for that */
    struct refinement positions, triangles;
    int n_runs, n_not_agreed; /* not agreed: the check said so */
    char **notes;             /* on what the scene refuses; owned */
    int n_notes;
};

/* ---- measure.c ---- */

/* Measures all that makes sense for the scene. The caller always frees *out. */
bool cost_measure(const struct options *options, struct cost *out, struct error *err);
void cost_free(struct cost *cost);

/* ---- answer.c: conclusions, in words and as tables ---- */

enum { WANTED_ERRORS = 4 };
extern const double wanted_errors[WANTED_ERRORS]; /* in CIEDE2000, the largest first */

/* Returns the cheapest configuration within an error; NULL: none. components: only those whose
 * pages are components count; otherwise only radiances at wavelengths. */
const struct configuration *cost_cheapest(const struct cost *cost, double error, bool components);
/* Returns the cheapest of radiances within 0.5, or else the most accurate: the first, if
 * there is none of radiances. */
const struct configuration *cost_typical(const struct cost *cost);
void cost_mark(struct cost *cost); /* sorts the samplings, and finds which are best and named */
void cost_print(const struct options *options, const struct cost *cost, struct printed *to);
void cost_csv(const struct cost *cost, struct printed *to);
void cost_json(const struct cost *cost, struct json *json); /* begins a text with one object */

/* ---- frontier.c: the chart ---- */

/* Prints a whole SVG 1.1 file: errors over seconds, checked and unchecked. */
void cost_svg(const struct cost *cost, struct printed *to);

#endif
