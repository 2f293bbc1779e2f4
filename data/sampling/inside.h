/* SPDX-License-Identifier: MIT */
/* Only the files of the room "sampling" include this. */
#ifndef DATA_SAMPLING_INSIDE_H
#define DATA_SAMPLING_INSIDE_H

#include "data/sampling/sampling.h"

/* ---- spectral_pages.c: pages made of spectra ---- */

/* Returns the value of a spectrum on a page. SPECTRUM_HOLD means a reflectance, SPECTRUM_ZERO a
 * light. */
double page_value(const struct spectral_pages *pages, const struct spectrum *spectrum, int page,
                  enum spectrum_ends ends);

/* ---- terms.c: materials under lights ---- */

/* Lists the materials of all objects, each once, and their partners. Lists all materials of a
 * material map, since only its mesh decides which of them are needed. The array is allocated, even
 * for no materials; after a failure it is NULL. */
bool materials_shown(const struct scene *scene, const struct material ***out, int *n,
                     struct error *err);

/* The input of a maker; `out` has the method, the detector's name and the fine detector. */
struct sampling_task {
    char name[SAMPLING_NAME];
    int count; /* N or K */
    const struct detector *detector;
    const struct fine_spectra *spectra;
    struct sampling *out;
};

/* A kind of sampling: the function that makes its pages, and all else that differs between kinds.
 */
enum {
    NEEDS_OBSERVER = 1,
    ANY_DETECTOR = 2, /* the pages are chosen without looking at the detector */
    FIXED = 4,        /* as in struct sampling */
    COMPONENTS = 8,   /* pages have no wavelengths */
    ANY_CHANNELS = 16 /* the detector may have any number of channels */
};
struct sampling_traits {
    const char *name, *functions; /* the words before and behind the number */
    bool (*make)(const struct sampling_task *task, struct error *err);
    const struct sampling_words {
        const char *page, *pages, *limit; /* one page, several, what they do not show */
    } * words;
    int flags;
    const char *const *labels; /* of components; NULL: "component 1" and so on */
};
extern const struct sampling_traits sampling_kinds[]; /* in method.c */

/* Makes room for n pages, and for the arrays that are wanted. */
enum { SEGMENTS = 1, ANALYSIS = 2, SYNTHESIS = 4 };
bool sampling_room(struct sampling *out, int n, int arrays, struct error *err);
/* Makes a zeroed array. */
bool sampling_numbers(double **out, size_t count, struct error *err);
/* Returns the sum of the magnitudes of the detector's weights at nm j of the grid. */
double sampling_seen(const struct sampling *sampling, int j);
/* Refuses more pages than `most` nm. In uniform.c, as the next. */
bool sampling_refuse(const struct sampling_task *task, int most, struct error *err);
double sampling_dot(const double *a, const double *b, int n); /* in basis.c */

/* Makers, in uniform.c, gauss.c, adaptive.c and basis.c. Each makes room for pages and sets their
 * wavelengths, or their analysis and synthesis (which is otherwise linear between wavelengths), and
 * their segments, or weights where these do not follow from segments. */
bool sample_box(const struct sampling_task *task, struct error *err);
bool sample_riemann(const struct sampling_task *task, struct error *err);
bool sample_tristimulus(const struct sampling_task *task, struct error *err); /* rgb and xyz */
bool sample_gauss(const struct sampling_task *task, struct error *err);
bool sample_gauss_functions(const struct sampling_task *task, struct error *err);
bool sample_adaptive(const struct sampling_task *task, struct error *err);
bool sample_basis(const struct sampling_task *task, struct error *err);
/* In basis.c. Turns rows of n numbers (finite, with squares that are) among themselves until they
 * are orthogonal, the longest first: Jacobi's method on one side. */
void orthogonal_rows(double *row, int rows, int n);

/* Makes the spectra of all lights, and of every term of every material that an object shows, over
 * the range of the scene's wavelengths. Opens no mesh and no texture. The caller frees them, also
 * after a failure. */
bool scene_spectra(const struct scene *scene, struct fine_spectra *out, struct error *err);

/* Makes a sampling of a scene's spectra; its wavelengths, or numbers of components, replace the
 * scene's. Refuses what sampling_make refuses, and spectral textures under basis, rgb and xyz. */
bool scene_sample(struct scene *scene, const struct sampling_method *method, const char *detector,
                  struct sampling *out, struct error *err);

#endif
