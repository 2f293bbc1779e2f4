/* SPDX-License-Identifier: MIT */
/* The room "sampling": how a spectrum becomes a few numbers. */
#ifndef SAMPLING_H
#define SAMPLING_H

#include <stdio.h>

#include "data/method/method.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/terms/terms.h"
#include "spectral.h"

/* ---- sampling.c, fine_spectra.c: samplings of a scene ---- */

/* The spectra of a scene at first_nm, first_nm + 1, ... nm: as finely as they are ever looked at.
 * The cells of 1 nm around these cover the range that a sampling samples. */
struct fine_spectra {
    double first_nm;
    int n_nm;
    int n_lights;     /* lights, ambient lights, and own light and luminescence of materials */
    double *lights;   /* [light][nm]; owned */
    int n_products;   /* every term of every material: light times reflectance, luminescence, ... */
    double *products; /* [product][nm], none negative; owned */
};
/* Makes the spectra of all lights, and of every term of every material that an object shows, over
 * the range of the scene's wavelengths. Opens no mesh and no texture. */
bool scene_spectra(const struct scene *scene, struct fine_spectra *out, struct error *err);
void fine_spectra_free(struct fine_spectra *spectra);

/* How the spectra of a scene become pages, and pages the channels of a detector. */
struct sampling {
    struct sampling_method method;
    char *detector;          /* its channels result from `weights`; owned */
    int n;                   /* pages */
    bool spectral;           /* pages are radiances at wavelengths (of box: their means); otherwise
                                components, which are no stack of wavelengths */
    double *wavelength_nm;   /* of each page, increasing; 1, 2, ... if not spectral; owned */
    double (*segment_nm)[2]; /* between which limits a page, with all others of the same limits,
                                stands for the radiance: a polynomial through them, of one page a
                                constant. NULL: there are none (riemann, and if `fixed`); owned */
    double *weights;         /* [channel * n + page]; owned */
    bool fixed;              /* wavelengths and segments do not determine the weights, which hold
                                for this detector only */
    /* On the grid of fine_spectra; owned, NULL where there is none: */
    double first_nm;
    int n_nm;
    double *detector_weights; /* [channel * n_nm + j]: detector_weights there */
    double *light_mean;       /* [page * n_nm + j]: a page's mean of a light; NULL: its value */
    double *reflectance_mean; /* the same of a reflectance */
    double *analysis;         /* basis, [page * n_nm + j]: the component of a product; none is
                                 negative for the scene's products, but by rounding */
    double *synthesis;        /* [j * n + page]: the radiance at j that the pages stand for (between
                                 wavelengths linear, of box constant); NULL: there is none */
    bool clips;               /* negative page values of a spectrum become 0 (rgb) */
    int rank;                 /* basis: of the products; n is no more than that, but at least 1 */
    int n_peaks;              /* adaptive */
    double *peak_nm;          /* owned */
    int n_negative;           /* weights below 0 */
    double most_negative;     /* the least weight, in parts of its channel's sum; 0: none */
};
/* Refuses, with the reason: a detector that sees none of the range; more pages than nm; a gauss
 * without a solution (and says for which n there is one); box, gauss of xyz, lms or acc, rgb and
 * xyz without an observer; more than memory holds. A K above the rank becomes the rank. Never gives
 * NaN or infinity. */
bool sampling_make(const struct sampling_method *method, const char *detector,
                   const struct fine_spectra *spectra, struct sampling *out, struct error *err);
/* Makes a sampling of a scene's spectra; its wavelengths, or numbers of components, replace the
 * scene's. Refuses what sampling_make refuses, and spectral textures under basis, rgb and xyz. */
bool scene_sample(struct scene *scene, const struct sampling_method *method, const char *detector,
                  struct sampling *out, struct error *err);
/* Fills in the synthesis, which is all 0, from n, wavelength_nm and the grid: linear between the
 * wavelengths, and held at the ends. */
void sampling_linear(struct sampling *out);
/* The sampling, or NULL of a zeroed one: functions that take a sampling take NULL for none. */
const struct sampling *sampling_or_none(const struct sampling *sampling);
/* How the pages are made of spectra. Valid as long as the sampling. */
struct spectral_pages sampling_pages(const struct sampling *sampling);
/* Weights of any detector at wavelengths that stand for segments: out[channel * n + i] = the sum
 * over cells of 1 nm of detector x polynomial, scaled as detector_weights scales. */
void sampling_weights(const struct detector *detector, const double *wavelength_nm,
                      double (*segment_nm)[2], int n, double *out);
/* "red", "Y", "component 3"; "" of a wavelength. */
void sampling_label(const struct sampling *sampling, int page, char out[24]);
/* Prints one line: name, number of pages, negative weights, peaks, rank, limits. */
void sampling_print(const struct sampling *sampling, FILE *to);
void sampling_free(struct sampling *sampling);

/* A stack records this of its sampling, so that any reader can weigh its pages. */
struct sampling_description {
    char method[SAMPLING_NAME]; /* as sampling_name */
    const char *detector;       /* the sampling's, as are the arrays */
    bool components;            /* pages have no wavelengths */
    int n;                      /* pages */
    double (*segment_nm)[2];    /* NULL: none is needed */
    const double *response;     /* [channel * n + page]: the weights of a fixed sampling; or NULL */
    double range_nm[2];         /* where the response holds */
};
void sampling_describe(const struct sampling *sampling, struct sampling_description *out);
/* The response of the sampling's detector to the scene's white at every nm. Returns false after an
 * error. *illumination becomes the sum of the lights' intensities; 0: no such white is seen. */
bool sampling_white(const struct sampling *sampling, const struct scene *scene, double out[3],
                    double *illumination, struct error *err);

/* ---- Inside this room ---- */

/* The input of a sampling; out has the grid, its detector's name and its weights there. */
struct sampling_task {
    const struct sampling_method *method;
    char name[SAMPLING_NAME];
    const struct detector *detector;
    const struct fine_spectra *spectra;
    struct sampling *out;
};

/* Room for n pages; `segments` and `synthesis` too, if wanted. */
bool sampling_room(struct sampling *out, int n, bool segments, bool synthesis, struct error *err);
/* The weights of the fixed response that follows from synthesis. */
void sampling_respond(struct sampling *out);
/* Wavelength j of the grid, and the magnitude of the detector's sensitivities there. */
double sampling_grid(const struct sampling *sampling, int j);
double sampling_seen(const struct sampling *sampling, int j);
/* Refuses more pages than `most` nm. In uniform.c, as the next. */
bool sampling_refuse(const struct sampling_task *task, int most, struct error *err);
/* Combines three rows of n numbers by a matrix. */
void sampling_transform(double m[3][3], const double *rows, int n, double *out);

/* Makers of task->out, in uniform.c, gauss.c, adaptive.c and basis.c. */
bool sample_box(const struct sampling_task *task, struct error *err);
bool sample_riemann(const struct sampling_task *task, struct error *err);
bool sample_tristimulus(const struct sampling_task *task, struct error *err); /* rgb and xyz */
bool sample_gauss(const struct sampling_task *task, struct error *err);
bool sample_adaptive(const struct sampling_task *task, struct error *err);
bool sample_basis(const struct sampling_task *task, struct error *err);
/* In basis.c. Turns rows of n numbers (finite, with squares that are) among themselves until they
 * are orthogonal, the longest first: Jacobi's method on one side. */
void orthogonal_rows(double *row, int rows, int n);

#endif
