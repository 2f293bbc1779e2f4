/* SPDX-License-Identifier: MIT */
/* Measures what each degree of accuracy costs in time, for one scene. It renders the scene in many
 * configurations, each as a user's command line would and in a process of its own, and measures the
 * accuracy of their stacks. It may know of render only its options and its stacks, so that no
 * configuration gains anything that a user would not. */
#ifndef COST_H
#define COST_H

#include "data/method/method.h"
#include "data/options/options.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "raster/accuracy/accuracy.h"
#include "spectral.h"

/* ---- command.c: spectral cost ---- */

/* Measures configurations of render and names the best. Fails with EXIT_DIFFERENT where none is
 * within the tolerance or the budget. */
bool command_cost(struct options *options, struct error *err);

/* ---- inside this room ---- */

/* ---- cost.c: conclusions and tables ---- */

/* A configuration in words, and what was measured of it. */
enum { COST_WORDS = 8 };
struct cost_entry {
    char name[128];
    char *words[COST_WORDS]; /* options of render, e.g. "--sampling=gauss:8"; owned */
    int n_words;
    double seconds, fastest, slowest; /* median and extremes of the runs: the whole render, in a
                                         process of its own */
    struct accuracy accuracy;
    bool best, uncertain; /* on the frontier of seconds and quantile_95; within noise of that */
};
struct cost {
    char *scene, *observer; /* owned */
    int width, height, runs, n;
    struct cost_entry *entries; /* by seconds; owned */
    char **notes; /* what the scene suggests, and why some configurations are missing; owned */
    int n_notes;
    double reference_seconds;
};
void cost_entry_free(struct cost_entry *entry);
void cost_free(struct cost *cost);
/* Adds a note, in printf's format. */
bool cost_note(struct cost *cost, struct error *err, const char *format, ...) PRINTF_LIKE(3, 4);
/* Finds out which entries are on the frontier, and which are within noise of that. */
void cost_mark(struct cost *cost);
/* Returns the fastest entry of at most the tolerance in quantile_95; NULL: none. spectral: only
 * entries whose pages are radiances count. */
const struct cost_entry *cost_within(const struct cost *cost, double tolerance, bool spectral);
/* Returns the most accurate entry of at most so many seconds, likewise. */
const struct cost_entry *cost_affordable(const struct cost *cost, double seconds, bool spectral);
/* Print the table, as text and as CSV; cost_svg returns the chart, allocated; NULL: no memory. */
void cost_print(const struct cost *cost, FILE *to);
void cost_print_csv(const struct cost *cost, FILE *to);
char *cost_svg(const struct cost *cost);

/* ---- command.c: configurations as command lines ---- */

/* Renders to a stack what `options` say, with the words of the entry. */
bool cost_render(const struct options *options, const struct cost_entry *entry, const char *output,
                 struct error *err);
/* Reads the scene as cost_render would, and samples it; *sampling stays zeroed where the words ask
 * for none. The caller frees both, also after a failure. entry NULL: without further words. */
bool cost_read(const struct options *options, const struct cost_entry *entry, struct scene *scene,
               struct sampling *sampling, struct error *err);

/* ---- measure.c ---- */

/* Runs all configurations that make sense for the scene of the options. The caller frees *out, also
 * after a failure. */
bool cost_measure(const struct options *options, struct cost *out, struct error *err);

/* ---- process.c ---- */

/* Runs a job in a process of its own, a copy of this one, and waits for it. The job fills `size`
 * bytes at `out`, which come back. This process never starts a thread or OpenGL, so that the copies
 * can: a copy of a process with OpenMP's threads hangs. An interruption ends the job at once.
 * Seconds are from fork to its end; NULL: not wanted. */
bool process_run(bool (*job)(void *context, void *out, struct error *err), void *context, void *out,
                 size_t size, double *seconds, struct error *err);

/* ---- configurations.c ---- */

/* The properties of a scene that decide which configurations make sense, and who sees it. */
enum { MAX_SURVEY_PEAKS = 16 };
struct survey {
    char scene[256];
    const char *observer;
    int width, height;
    bool shaded;      /* smooth, flat and phong shading differ */
    bool tessellated; /* has built-in shapes of slices, stacks, ... */
    bool fluorescent, spectral_texture;
    int n_peaks; /* emission peaks that adaptive sampling finds; -1: it refused */
    double peak_nm[MAX_SURVEY_PEAKS];
    int rank; /* of lights x reflectances; 0: a basis was refused */
};
/* Surveys the scene of the options, in a process of its own. */
bool survey_scene(const struct options *options, struct survey *out, struct error *err);
/* Adds notes on what the scene suggests. */
bool survey_notes(const struct survey *survey, struct cost *cost, struct error *err);

enum cost_renderer { BY_RASTER, BY_LLVMPIPE, BY_CHECKED_LLVMPIPE, BY_SOFTPIPE };
struct configuration {
    char sampling[SAMPLING_NAME]; /* "": at the scene's own wavelengths */
    enum shading_kind shading;
    int tessellation;
    enum cost_renderer renderer;
    int buffer_bits, bits; /* 0: the default */
};
extern const struct configuration reference_configuration; /* on a scene with all axes */
/* Fills in the name and the words of an entry; cost_entry_free frees the words. */
bool configuration_entry(const struct configuration *configuration, const char *observer,
                         struct cost_entry *out, struct error *err);
/* A configuration and what was measured of it. */
struct attempt {
    struct configuration configuration;
    struct cost_entry entry; /* of 0 pages where it could not be rendered */
    double *seconds;         /* of each run; owned */
};
enum { MAX_CONFIGURATIONS = 80 };
struct attempts {
    int n;
    struct attempt attempt[MAX_CONFIGURATIONS];
};
/* Adds every sampling, with the finest shading. */
bool configurations_samplings(const struct survey *survey, struct attempts *attempts,
                              struct error *err);
/* Adds shadings, renderers and depths, with a good one of the samplings. The choice depends on the
 * errors measured so far, not on seconds: the same scene always has the same configurations. */
bool configurations_pictures(const struct survey *survey, struct attempts *attempts,
                             struct error *err);
/* Adds the best samplings with the best shadings, chosen likewise. */
bool configurations_combined(const struct survey *survey, struct attempts *attempts,
                             struct error *err);

#endif
