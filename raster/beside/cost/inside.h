/* SPDX-License-Identifier: MIT */
/* Only the files of the room "cost" include this. */
#ifndef RASTER_BESIDE_COST_INSIDE_H
#define RASTER_BESIDE_COST_INSIDE_H

#include "data/base/base.h"
#include "data/files/files.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/stack/stack.h"
#include "raster/beside/cost/cost.h"
#include "raster/beside/see/see.h"
#include "raster/render/render.h"

struct cost_options {
    struct render_options render; /* the first member */
    const char *csv, *svg, *tolerance;
    double budget; /* 0: none was given */
    int runs;
};

enum { COST_WORDS = 10, MOST_CONFIGURATIONS = 80, COST_OPTIONS = 128 };
/* The difference of a stack from the standard: in CIEDE2000, over the pixels in which either
 * picture shows an object (0 if there are none); and in radiance at every nm, relative rms. */
struct accuracy {
    int n_pages;
    bool spectral; /* pages are radiances at wavelengths */
    double mean, quantile_95, largest;
    double radiance;   /* NaN: the pages determine no radiances */
    int n_peaks, rank; /* of its sampling: see struct sampling */
};
struct seen_pixel {
    double lab[3];
    bool shown; /* an object; not the background */
};
/* All that is kept of a stack: see standard.c. */
struct summary {
    const char *observer; /* this and the threads are the caller's */
    int threads;
    int width, height, n_pages;
    double white[3];    /* XYZ of the lights, or of a radiance of 1 where the observer sees none */
    bool lit;           /* the observer sees some light */
    double first_nm;    /* of the first page */
    int step, n_points; /* of the lattice */
    struct seen_pixel *pixels; /* owned */
    float *lattice;            /* [point][page]; owned */
};
struct cost_entry {
    char sampling[SAMPLING_NAME]; /* or "accuracy:ERROR"; "": at the scene's own wavelengths */
    char options[COST_OPTIONS];   /* of render, beside the sampling, with a blank between two */
    char name[COST_OPTIONS];
    char *text;              /* of the words; owned */
    char *words[COST_WORDS]; /* options of render, e.g. "--sampling=gauss:8" */
    int n_words;
    struct accuracy accuracy;  /* of 0 pages until it has been measured */
    struct run_seconds *times; /* of each run of the program; owned */
    double seconds, fastest, slowest,
        processor;        /* median and extremes by the clock; other median */
    bool best, uncertain; /* on the frontier of seconds and quantile_95; within noise of it */
};
enum { GOOD, COLOURS, SPECTRA, FINE_SPECTRA, N_CHOSEN }; /* samplings with few pages */
struct cost {
    char *scene; /* its name with the changes of the command line; owned */
    const char *observer;
    int width, height, positions; /* positions: a side of each pixel */
    /* The properties of the scene that decide which configurations make sense. */
    bool shaded;      /* smooth, flat and phong shading differ */
    bool tessellated; /* has built-in shapes of slices, stacks, ... */
    bool fluorescent, spectral_texture;
    bool peaks; /* adaptive sampling finds emission peaks */
    char chosen[N_CHOSEN][SAMPLING_NAME];
    int runs, n;
    struct cost_entry *entries; /* room for MOST_CONFIGURATIONS; by seconds in the end; owned */
    char **notes;               /* on the scene, and on configurations that failed; owned */
    int n_notes;
    double standard_seconds;
};

/* ---- cost.c: conclusions and tables ---- */

void cost_entry_free(struct cost_entry *entry);
void cost_free(struct cost *cost);
bool cost_note(struct cost *cost, struct error *err, const char *format, ...) PRINTF_LIKE(3, 4);
/* Marks the entries on the frontier, and those within noise of it. */
void cost_mark(struct cost *cost);
struct advice {
    const struct cost_entry *entry; /* of its rivals and itself, the one of least processor time */
    int n_rivals;                   /* that are as good, and whose times overlap */
};
/* Returns the fastest entry of at most this error in quantile_95; HUGE_VAL: the most accurate entry
 * of at most so many seconds. NULL: none. spectral: only entries whose pages are radiances count.
 */
struct advice cost_advise(const struct cost *cost, double error, double seconds, bool spectral);
void cost_print(const struct cost *cost, struct printed *to);
void cost_csv(const struct cost *cost, struct printed *to); /* the table */
void cost_json(const struct cost *cost, struct json *json); /* begins a text with one object */

/* ---- frontier.c: the chart ---- */

/* Prints a whole SVG 1.1 file. Errors below 1/1000 of the largest are drawn as that. Points of the
 * frontier have numbers, and a legend names them. */
void cost_svg(const struct cost *cost, struct printed *to);

/* ---- measure.c ---- */

/* Measures all configurations that make sense for the scene. The caller always frees *out. */
bool cost_measure(const struct options *options, struct cost *out, struct error *err);

/* ---- standard.c: the picture at every nm, and the differences of stacks from it ---- */

/* Summarize the stack of the standard; measure a stack of the standard's size, with its sampling
 * (zeroed: none). */
bool standard_summarize(const char *stack, struct summary *out, struct error *err);
bool standard_compare(const char *stack, const struct sampling *sampling,
                      const struct summary *standard, struct accuracy *out, struct error *err);
void summary_free(struct summary *summary);

/* ---- configurations.c ---- */

/* Survey the scene of a command line of render; add notes on what it suggests. */
bool survey_scene(const struct scene *scene, const struct options *options, struct cost *out,
                  struct error *err);
bool survey_notes(struct cost *cost, bool lit, struct error *err);
/* Fills in the words of an entry, which has none. The caller always frees it. */
bool entry_words(struct cost_entry *entry, const char *observer, struct error *err);
/* Returns the entry of the standard: every nm, the finest shading, pages of floats. */
struct cost_entry standard_entry(const struct cost *cost);
/* Add the samplings that find out about the scene; all others, with the finest shading; choose
 * samplings; add shadings, renderers, positions and depths with a good one; add the best samplings
 * with the best shadings. Choices depend on errors, not on seconds: they are the same in every run.
 * Entries have no words yet. */
void configurations_first(struct cost *cost);
void configurations_samplings(struct cost *cost);
void configurations_choose(struct cost *cost);
void configurations_styles(struct cost *cost);
void configurations_combined(struct cost *cost);

#endif
