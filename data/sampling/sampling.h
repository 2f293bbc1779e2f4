/* SPDX-License-Identifier: MIT */
/* The room "sampling": few pages stand for a whole spectrum. */
#ifndef SAMPLING_H
#define SAMPLING_H


#include "data/method/method.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/terms/terms.h"
#include "spectral.h"

/* ---- sampling.c, fine_spectra.c: samplings of a scene ---- */

/* The spectra of a scene at first_nm, first_nm + 1, ... nm. The cells of 1 nm around these cover
 * the range that a sampling samples. */
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

/* A detector at first_nm, first_nm + 1, ... nm. */
struct fine_detector {
    int n;
    double *nm;      /* owned, with the weights behind them */
    double *weights; /* detector_weights there: [channel * n + j] */
};
/* Makes a fine detector of n >= 1 nm. Fails only where memory runs out. */
bool fine_detector_make(const struct detector *detector, double first_nm, int n,
                        struct fine_detector *out, struct error *err);
void fine_detector_free(struct fine_detector *detector);

/* How spectra become pages (`pages`), and pages the channels of a detector (`weights`). */
struct sampling {
    struct sampling_method method;
    struct spectral_pages pages; /* its arrays are owned. Wavelengths increase; components have 1,
                                    2, ... instead */
    bool spectral;               /* pages are radiances at wavelengths, or means of radiances;
                                    otherwise components */
    char *detector;              /* its channels result from the weights; owned */
    double *weights;             /* [channel * n + page]; owned */
    bool fixed;                  /* the weights hold for this detector only: neither wavelengths nor
                                    segments determine them */
    double (*segment_nm)[2];     /* between which limits a page, with all others of the same limits,
                                    stands for the radiance: a polynomial through them, of one page
                                    a constant. NULL: there are none (riemann, and if `fixed`);
                                    owned */
    struct fine_detector fine;   /* the detector on the grid of the fine_spectra */
    double *synthesis;           /* [j * n + page]: the radiance at fine.nm[j] that the pages stand
                                    for; NULL: they determine none; owned */
    int rank;                    /* of basis: of the products; n is at most the rank, at least 1 */
    int n_peaks;                 /* of adaptive */
    double *peak_nm;             /* owned */
};
/* Refuses, with the reason: a detector that sees none of the range; more pages than nm; a gauss
 * without a solution (and says for which n there is one); box, gauss of xyz, lms or acc, rgb and
 * xyz without an observer; more than memory holds. A K above the rank becomes the rank. Never
 * makes NaN or infinity. */
bool sampling_make(const struct sampling_method *method, const char *detector,
                   const struct fine_spectra *spectra, struct sampling *out, struct error *err);
/* Makes a sampling of a scene's spectra; its wavelengths, or numbers of components, replace the
 * scene's. Refuses what sampling_make refuses, and spectral textures under basis, rgb and xyz. */
bool scene_sample(struct scene *scene, const struct sampling_method *method, const char *detector,
                  struct sampling *out, struct error *err);
/* Returns whether the pages of a method have no wavelengths, but are components of whole spectra.
 */
bool sampling_makes_components(const struct sampling_method *method);
/* Returns the sampling, or NULL for a zeroed one: functions take NULL for no sampling. */
const struct sampling *sampling_or_none(const struct sampling *sampling);
/* Finds the weights of any detector at n wavelengths that stand for segments: out[channel * n + i]
 * = the sum over cells of 1 nm of detector x polynomial, scaled as detector_weights scales. */
void sampling_weights(const struct detector *detector, const double *wavelength_nm,
                      double (*segment_nm)[2], int n, double *out);
/* Finds the wavelength before nm, of n >= 1 increasing ones. *part: how far nm lies towards the
 * next, 0 to 1; 0 if there is no next. Beyond the ends the end's wavelength stands for nm. */
int wavelength_before(const double *wavelength_nm, int n, double nm, double *part);
/* Makes the radiance at first_nm, first_nm + 1, ... of the radiances at n wavelengths: linear
 * between them, constant beyond the ends. [j * n + i], allocated; NULL after an error. */
double *linear_synthesis(const double *wavelength_nm, int n, double first_nm, int n_nm,
                         struct error *err);
/* Writes the name of a component: "red", "Y", "component 3"; "" for a wavelength. */
void sampling_label(const struct sampling *sampling, int page, char out[24]);
/* Returns those of n components. One allocation holds the pointers and the texts; NULL: no memory.
 */
const char **sampling_labels(const struct sampling *sampling, int n, struct error *err);
/* Prints one line: name, number of pages, negative weights, peaks, rank, limits. */
void sampling_print(const struct sampling *sampling, struct printed *to);
void sampling_free(struct sampling *sampling);

/* ---- Inside this room ---- */

/* The input of a maker; `out` has the method, the detector's name and the fine detector. */
struct sampling_task {
    char name[SAMPLING_NAME];
    const struct detector *detector;
    const struct fine_spectra *spectra;
    struct sampling *out;
};

/* Makes room for n pages, with segments if wanted. */
bool sampling_room(struct sampling *out, int n, bool segments, struct error *err);
/* Returns a zeroed array; NULL after an error. */
double *sampling_numbers(size_t count, struct error *err);
/* Returns the sum of the magnitudes of the detector's weights at nm j of the grid. */
double sampling_seen(const struct sampling *sampling, int j);
/* Refuses more pages than `most` nm. In uniform.c, as the next. */
bool sampling_refuse(const struct sampling_task *task, int most, struct error *err);
/* Combines three rows of n numbers by a matrix. */
void sampling_transform(double m[3][3], const double *rows, int n, double *out);

/* Makers, in uniform.c, gauss.c, adaptive.c and basis.c. Each makes room for pages and sets their
 * wavelengths, or their analysis and synthesis (which is otherwise linear between wavelengths), and
 * their segments, or weights where these do not follow from segments. */
bool sample_box(const struct sampling_task *task, struct error *err);
bool sample_riemann(const struct sampling_task *task, struct error *err);
bool sample_tristimulus(const struct sampling_task *task, struct error *err); /* rgb and xyz */
bool sample_gauss_detector(const struct sampling_task *task, struct error *err);
bool sample_gauss_open(const struct sampling_task *task, struct error *err);
bool sample_gauss_functions(const struct sampling_task *task, struct error *err);
bool sample_adaptive(const struct sampling_task *task, struct error *err);
bool sample_basis(const struct sampling_task *task, struct error *err);
/* In basis.c. Turns rows of n numbers (finite, with squares that are) among themselves until they
 * are orthogonal, the longest first: Jacobi's method on one side. */
void orthogonal_rows(double *row, int rows, int n);

#endif
