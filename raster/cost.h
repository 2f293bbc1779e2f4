/* SPDX-License-Identifier: MIT */
/* Private to the files of `spectral cost`: trials.c says which settings make sense for a scene,
 * process.c runs them, truth.c says how far off they are, measure.c puts that together, and cost.c
 * concludes. Only a test includes this, too. */
#ifndef COST_H
#define COST_H

#include "raster/raster.h"

/* ---- raster/process.c ---- */

/* Runs a job in a process of its own, a copy of this one, and waits for it. The job fills `size`
 * bytes at `out`, which come back. This process never starts a thread or OpenGL, so that the copies
 * can: a copy of a process with OpenMP's threads hangs. An interruption ends the job at once.
 * Seconds are from fork to its end; NULL: not wanted. */
bool process_run(bool (*job)(void *context, void *out, struct error *err), void *context, void *out,
                 size_t size, double *seconds, struct error *err);

/* ---- raster/trials.c ---- */

/* What a scene has that decides which settings make sense. */
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
struct setting {
    char sampling[SAMPLING_NAME]; /* "": at the scene's own wavelengths */
    enum shading_kind shading;
    int tessellation;
    enum cost_renderer renderer;
    int buffer_bits, bits; /* 0: the default */
};
extern const struct setting reference_setting; /* on a scene with all axes */
/* Fills in name and words, which are allocated. */
bool setting_entry(const struct setting *setting, const char *observer, struct cost_entry *out,
                   struct error *err);
enum { MAX_SETTINGS = 80 };
/* A setting and what was measured of it. */
struct trial {
    struct setting setting;
    struct cost_entry entry;
    int n_pages;
    double *seconds; /* of each run; owned */
};
struct trials {
    int n;
    struct trial trial[MAX_SETTINGS];
};
/* Every sampling, with the finest shading. */
bool settings_samplings(const struct survey *survey, const char *observer, struct trials *out,
                        struct error *err);
/* Adds shadings, renderers and depths, with a good one of the samplings, whose errors are known. By
 * those it is chosen, not by seconds, so that the same scene always has the same settings. */
bool settings_pictures(const struct survey *survey, const char *observer, struct trials *trials,
                       struct error *err);
/* Adds the samplings that are worth it with the shadings that are, likewise. */
bool settings_combined(const struct survey *survey, const char *observer, struct trials *trials,
                       struct error *err);
/* Adds what the scene suggests. */
bool survey_notes(const struct survey *survey, struct cost *cost, struct error *err);
bool cost_note(struct cost *cost, struct error *err, const char *format, ...) PRINTF_LIKE(3, 4);

/* ---- raster/truth.c ---- */

/* The reference picture, which lies in a file: CIELAB of every pixel, whether it shows an object,
 * and the spectra of a lattice of pixels. */
struct truth {
    int width, height;
    double white[3]; /* of the lights, or of a radiance of 1 where none shines */
    bool lit;        /* some light shines */
    double first_nm;
    int n_nm;
    int step, columns, rows; /* of the lattice */
};
/* Renders the scene, of which every nm is a wavelength, for an observer. */
bool truth_render(const struct scene *scene, const char *observer, int threads, const char *path,
                  struct truth *out, struct error *err);
struct truth_errors {
    int n_pages;
    bool spectral;
    double mean, quantile_95, largest, radiance;
};
/* A stack of a scene, how it was sampled (NULL: not), and who sees it. */
struct truth_stack {
    const char *path;
    const struct scene *scene;
    const struct sampling *sampling;
    const char *observer;
};
/* How far a stack is off the reference picture, which lies in the file `path`. */
bool truth_compare(const struct truth *truth, const char *path, const struct truth_stack *stack,
                   int threads, struct truth_errors *out, struct error *err);

/* ---- raster/cost.c ---- */

void cost_entry_free(struct cost_entry *entry);
/* Which entries are on the frontier, and which are within noise of that. */
void cost_mark(struct cost *cost);

#endif
