/* SPDX-License-Identifier: MIT */
/* The room "sampling": how a spectrum becomes a few numbers. */
#ifndef SAMPLING_H
#define SAMPLING_H

#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "spectral.h"

/* ---- method.c: names of samplings ---- */

enum sampling_kind {
    SAMPLING_BOX,      /* box:N - N boxes of equal area under the detector's functions (Hall) */
    SAMPLING_RIEMANN,  /* riemann:STEP - a value every STEP nm */
    SAMPLING_GAUSS,    /* gauss:N[,FUNCTIONS] - quadrature weighted by functions of the detector */
    SAMPLING_ADAPTIVE, /* adaptive:TOL - segments, peaks found, quadrature between (Deville) */
    SAMPLING_BASIS,    /* basis:K - principal components of the scene's lights x reflectances */
    SAMPLING_RGB,      /* rgb - linear sRGB of lights times that of reflectances */
    SAMPLING_XYZ       /* xyz - the same of tristimulus values */
};
/* The weights of gauss. Of the last three each function has nodes of its own. */
enum sampling_functions {
    FUNCTIONS_DETECTOR, /* the sum of the magnitudes of the detector's three */
    FUNCTIONS_OPEN,     /* 1: the detector is left open, and may be any one afterwards */
    FUNCTIONS_XYZ,      /* the observer's own */
    FUNCTIONS_LMS,      /* Hunt-Pointer-Estevez cone responses, linear in those */
    FUNCTIONS_ACC       /* opponent A, C1, C2: the principal axes of the cones' overlaps, linear in
                           those; C1 and C2 change sign */
};
struct sampling_method {
    enum sampling_kind kind;
    int count;        /* N or K; gauss: 1 to LARGEST_QUADRATURE */
    double step_nm;   /* STEP */
    double tolerance; /* TOL: of a channel's response to a light, in parts of that */
    enum sampling_functions functions;
};
/* Reads a method as written above. Messages name `option`. */
bool sampling_read(const char *option, const char *text, struct sampling_method *out,
                   struct error *err);
/* Writes a method as sampling_read takes it; numbers as short as they are exact. */
enum { SAMPLING_NAME = 48 };
void sampling_name(const struct sampling_method *method, char out[SAMPLING_NAME]);

/* ---- sampling.c: samplings of a scene ---- */

/* The spectra of a scene at first_nm, first_nm + 1, ... nm: as finely as they are ever looked at.
 * The cells of 1 nm around these cover the range that a sampling samples. */
struct fine_spectra {
    double first_nm;
    int n_nm;
    int n_lights;     /* lights, ambient lights, and own light and luminescence of materials */
    double *lights;   /* [light][nm]; owned */
    int n_products;   /* every term of every finish: light times reflectance, luminescence, ... */
    double *products; /* [product][nm], none negative; owned */
};
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
/* Weights of any detector at wavelengths that stand for segments: out[channel * n + i] = the sum
 * over cells of 1 nm of detector x polynomial, scaled as detector_weights scales. */
void sampling_weights(const struct detector *detector, const double *wavelength_nm,
                      double (*segment_nm)[2], int n, double *out);
/* The value of a spectrum in a page: SPECTRUM_HOLD means a reflectance, SPECTRUM_ZERO a light. A
 * scene without a sampling takes the value at the page's wavelength. */
double scene_page(const struct scene *scene, const struct spectrum *spectrum, int page,
                  enum spectrum_ends ends);
/* "red", "Y", "component 3"; "" of a wavelength. */
void sampling_label(const struct sampling *sampling, int page, char out[24]);
/* Prints one line: name, number of pages, negative weights, peaks, rank, limits. */
void sampling_print(const struct sampling *sampling, FILE *to);
void sampling_free(struct sampling *sampling);

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
/* Synthesis that is linear between the wavelengths, and held at the ends. */
void sampling_linear(struct sampling *out);
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
