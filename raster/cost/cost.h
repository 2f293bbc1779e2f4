/* SPDX-License-Identifier: MIT */
/* What accuracy costs in time. */
#ifndef COST_H
#define COST_H

#include "data/method/method.h"
#include "data/options/options.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "raster/render/render.h"
#include "spectral.h"

/* ---- cost.c: what accuracy costs in time ---- */

/* How configurations are run: `words` are options of render, e.g. "--sampling=gauss:8". */
struct cost_program {
    /* Renders the scene with the words (and all that the command line said) to a stack. */
    bool (*render)(void *context, char *const *words, int n_words, const char *output,
                   struct error *err);
    /* Reads it as render would, and samples it; *sampling stays zeroed where the words ask for
     * none. */
    bool (*read)(void *context, char *const *words, int n_words, struct scene *scene,
                 struct sampling *sampling, struct error *err);
    void *context;
};
enum { COST_WORDS = 8 };
struct cost_entry {
    char name[128];
    char *words[COST_WORDS]; /* owned */
    int n_words;
    bool spectral;                     /* its pages are radiances at wavelengths */
    double seconds, fastest, slowest;  /* median and extremes of the runs: the whole render, in a
                                          process of its own */
    double mean, quantile_95, largest; /* CIEDE2000 from the reference, over all pixels in which
                                          either picture shows an object */
    double radiance_error; /* rms of the radiance's error at every nm, relative to its rms; NaN: no
                              radiances */
    bool best, uncertain;  /* on the frontier of seconds and quantile_95; within noise of that */
};
struct cost_options {
    const char *observer;
    char *const *given; /* what the command line changes of the scene, for the reader */
    int n_given;
    int runs, threads;
    void (*progress)(void *context, long done, long all); /* NULL: none */
    void *progress_context;
};
struct cost {
    char *scene, *observer; /* owned */
    int width, height, runs, n;
    struct cost_entry *entries; /* by seconds; owned */
    char **notes; /* what the scene suggests, and which configurations it has not, and why; owned */
    int n_notes;
    double reference_seconds;
};
/* Runs all configurations that make sense for the scene. */
bool cost_measure(const struct cost_program *program, const struct cost_options *options,
                  struct cost *out, struct error *err);
void cost_print(const struct cost *cost, FILE *to);
void cost_print_csv(const struct cost *cost, FILE *to);
char *cost_svg(const struct cost *cost); /* allocated; NULL: no memory */
/* The cheapest entry whose quantile_95 is within the tolerance; NULL: none is. spectral: only of
 * those whose pages are radiances. */
const struct cost_entry *cost_within(const struct cost *cost, double tolerance, bool spectral);
/* The most accurate one within the time, likewise. */
const struct cost_entry *cost_affordable(const struct cost *cost, double seconds, bool spectral);
void cost_free(struct cost *cost);

/* ---- command.c: spectral cost ---- */

/* Measures configurations of render and names the best. Fails with EXIT_DIFFERENT where none is
 * within the tolerance or the budget. */
bool command_cost(struct options *options, struct error *err);

/* ---- inside this room ---- */

/* ---- process.c ---- */

/* Runs a job in a process of its own, a copy of this one, and waits for it. The job fills `size`
 * bytes at `out`, which come back. This process never starts a thread or OpenGL, so that the copies
 * can: a copy of a process with OpenMP's threads hangs. An interruption ends the job at once.
 * Seconds are from fork to its end; NULL: not wanted. */
bool process_run(bool (*job)(void *context, void *out, struct error *err), void *context, void *out,
                 size_t size, double *seconds, struct error *err);

/* ---- attempts.c ---- */

/* What a scene has that decides which configurations make sense. */
enum { MAX_SURVEY_PEAKS = 16 };
struct survey {
    char scene[256];
    int width, height;
    bool shaded;      /* smooth, flat and phong shading differ */
    bool tessellated; /* has built-in shapes of slices, stacks, ... */
    bool fluorescent, spectral_texture;
    int n_peaks; /* emission peaks that adaptive sampling finds; -1: it refused */
    double peak_nm[MAX_SURVEY_PEAKS];
    int rank; /* of lights x reflectances; 0: a basis was refused */
};
bool survey_scene(const struct cost_program *program, const char *observer, struct survey *out,
                  struct error *err);

enum cost_renderer { BY_RASTER, BY_LLVMPIPE, BY_CHECKED_LLVMPIPE, BY_SOFTPIPE };
struct configuration {
    char sampling[SAMPLING_NAME]; /* "": at the scene's own wavelengths */
    enum shading_kind shading;
    int tessellation;
    enum cost_renderer renderer;
    int buffer_bits, bits; /* 0: the default */
};
extern const struct configuration reference_configuration; /* on a scene with all axes */
/* Fills in name and words, which are allocated. */
bool configuration_entry(const struct configuration *configuration, const char *observer,
                         struct cost_entry *out, struct error *err);
enum { MAX_CONFIGURATIONS = 80 };
/* A configuration and what was measured of it. */
struct attempt {
    struct configuration configuration;
    struct cost_entry entry;
    int n_pages;
    double *seconds; /* of each run; owned */
};
struct attempts {
    int n;
    struct attempt attempt[MAX_CONFIGURATIONS];
};
/* Every sampling, with the finest shading. */
bool configurations_samplings(const struct survey *survey, const char *observer,
                              struct attempts *out, struct error *err);
/* Adds shadings, renderers and depths, with a good one of the samplings, whose errors are known. By
 * those it is chosen, not by seconds, so that the same scene always has the same configurations. */
bool configurations_pictures(const struct survey *survey, const char *observer,
                             struct attempts *attempts, struct error *err);
/* Adds the samplings that are worth it with the shadings that are, likewise. */
bool configurations_combined(const struct survey *survey, const char *observer,
                             struct attempts *attempts, struct error *err);
/* Adds what the scene suggests. */
bool survey_notes(const struct survey *survey, struct cost *cost, struct error *err);
bool cost_note(struct cost *cost, struct error *err, const char *format, ...) PRINTF_LIKE(3, 4);

/* ---- standard.c ---- */

/* The reference picture, which lies in a file: CIELAB of every pixel, whether it shows an object,
 * and the spectra of a lattice of pixels. */
struct standard {
    int width, height;
    double white[3]; /* of the lights, or of a radiance of 1 where none shines */
    bool lit;        /* some light shines */
    double first_nm;
    int n_nm;
    int step, columns, rows; /* of the lattice */
};
/* Renders the scene, of which every nm is a wavelength, for an observer. */
bool standard_render(const struct scene *scene, const char *observer, int threads, const char *path,
                     struct standard *out, struct error *err);
struct standard_errors {
    int n_pages;
    bool spectral;
    double mean, quantile_95, largest, radiance;
};
/* A stack of a scene, how it was sampled (NULL: not), and who sees it. */
struct standard_stack {
    const char *path;
    const struct scene *scene;
    const struct sampling *sampling;
    const char *observer;
};
/* How far a stack is off the reference picture, which lies in the file `path`. */
bool standard_compare(const struct standard *standard, const char *path,
                      const struct standard_stack *stack, int threads, struct standard_errors *out,
                      struct error *err);

/* ---- cost.c ---- */

void cost_entry_free(struct cost_entry *entry);
/* Which entries are on the frontier, and which are within noise of that. */
void cost_mark(struct cost *cost);

#endif
