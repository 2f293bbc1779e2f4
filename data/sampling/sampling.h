/* SPDX-License-Identifier: MIT */
/* The room "sampling": few pages stand for a whole spectrum. Products of the spectra of lights and
 * materials are multiplied here, once for all vertices; they depend on no geometry and no drawing.
 */
#ifndef DATA_SAMPLING_SAMPLING_H
#define DATA_SAMPLING_SAMPLING_H

#include "data/scene/scene.h"

/* ---- spectral_pages.c: pages made of spectra ---- */

/* The pages of a picture, made of spectra. The arrays belong to others. A page holds the value of a
 * spectrum at the page's wavelength. If there is an analysis, it holds the sum of the spectrum
 * times the page's row of the analysis, over the grid first_nm, first_nm + 1, ... nm. */
struct spectral_pages {
    int n; /* pages */
    double *wavelength_nm;
    double first_nm;
    int n_nm;
    double *analysis;             /* [page * n_nm + j]; NULL: values at wavelengths */
    double *reflectance_analysis; /* of reflectances alone, whose pages then multiply those of
                                     lights, and show no fluorescence; NULL: as of lights */
    bool of_products;             /* light times reflectance is analysed, not each by itself */
    bool clips;                   /* a sum below 0 becomes 0 */
};
/* Returns the pages of a scene that is not sampled: one a wavelength. They are valid as long as the
 * scene. */
struct spectral_pages scene_pages(const struct scene *scene);
/* Return how many wavelengths the pages depend on, and wavelength i of them: those of the pages, or
 * every nm of the grid. */
int pages_looked_at(const struct spectral_pages *pages);
double pages_looked_at_nm(const struct spectral_pages *pages, int i);
/* Returns whether a light is above 0 at any of these wavelengths. */
bool pages_show(const struct spectral_pages *pages, const struct spectrum *light);

/* Computes the mean of all lights and ambient lights, weighted by intensity: the radiance on each
 * page of a perfect diffuser under one such light of intensity 1. Returns the sum of the
 * intensities, or 0 if nothing shines; *out is then undefined. */
double scene_white(const struct scene *scene, const struct spectral_pages *pages, double *out);

/* ---- illumination.c: lights that shine ---- */

/* Returns whether a spectrum is 0 at every wavelength, as far as its own numbers show. */
bool spectrum_is_zero(const struct spectrum *spectrum);
struct shining_light {
    const struct light *light;
    int first;    /* index of the first light of the same spectrum; perhaps this one */
    double share; /* this light's radiation divided by that of the first one */
    int n_alike;  /* lights whose first one this is */
};
/* The light of a scene, and the pages that show it. */
struct illumination {
    const struct scene *scene;
    struct spectral_pages pages;
    bool exchangeable; /* lights may be exchanged afterwards: lights and terms that are 0 are kept,
                          and each light has its own terms */
    int n_lights;
    int n_first;                  /* lights that are the first of their spectrum */
    struct shining_light *lights; /* in the scene's order; owned */
};
/* Lists the lights that are not 0 everywhere. Scene and pages must outlive *out. */
bool illumination_make(const struct scene *scene, const struct spectral_pages *pages,
                       bool exchangeable, struct illumination *out, struct error *err);
void illumination_free(struct illumination *illumination);

/* ---- terms.c: materials under lights ---- */

/* Radiance at a point is a sum over terms of weight(point) x spectrum(wavelength) (local
 * illumination is linear), times the texture there: weights depend on geometry only, spectra on
 * light and material. */
enum term_kind {
    TERM_CONSTANT, /* ambient light and emission; its weight is 1 */
    TERM_DIFFUSE,
    TERM_SPECULAR
};
struct spectral_term {
    enum term_kind kind;
    int light;         /* index of the first light of its spectrum; -1: none */
    double peak, mean; /* of its spectrum on all pages: the largest value, and the mean of them */
};
/* The terms of a material. Lights of one spectrum share their terms, and terms that are 0 on all
 * pages are left out. */
struct material_terms {
    const struct material *material;
    int n;
    struct spectral_term *terms; /* owned */
    double *spectra;             /* [term][page]; owned */
    bool ambient, emits, fluoresces;
    long excitation_integrals; /* how many were computed */
};
/* Makes the terms of the material under the light. The material must outlive *out. */
bool material_terms_make(const struct illumination *illumination, const struct material *material,
                         struct material_terms *out, struct error *err);
void material_terms_free(struct material_terms *terms);
/* Computes the luminescence of a material on each page, under a light of intensity 1 that shines on
 * it at a right angle. Pages must not be components. */
bool material_luminescence(const struct spectral_pages *pages, const struct material *material,
                           const struct spectrum *light, double *out, struct error *err);

/* ---- method.c: names of samplings ---- */

enum sampling_kind {
    SAMPLING_BOX,     /* box:N - N boxes of equal area under the detector's functions (Hall) */
    SAMPLING_RIEMANN, /* riemann:STEP - a value every STEP nm */
    /* Quadrature with N nodes, at most LARGEST_QUADRATURE, weighted by functions. Each of the three
     * functions of XYZ, LMS and ACC has nodes of its own. */
    SAMPLING_GAUSS,      /* gauss:N - by the sum of the magnitudes of the detector's three */
    SAMPLING_GAUSS_OPEN, /* gauss:N,open - by the constant 1: any detector can be used afterwards */
    SAMPLING_GAUSS_XYZ,  /* gauss:N,xyz - by the observer's own */
    SAMPLING_GAUSS_LMS,  /* gauss:N,lms - by Hunt-Pointer-Estevez cone responses, linear in those */
    SAMPLING_GAUSS_ACC,  /* gauss:N,acc - by opponent A, C1, C2: the principal axes of the cones'
                            overlaps, linear in those; C1 and C2 change sign */
    SAMPLING_ADAPTIVE,   /* adaptive:TOL - segments, peaks found, quadrature between (Deville) */
    SAMPLING_BASIS,      /* basis:K - principal components of the scene's lights x reflectances */
    SAMPLING_RGB,        /* rgb - linear sRGB of lights times linear sRGB of reflectances */
    SAMPLING_XYZ         /* xyz - tristimulus values of lights times those of reflectances */
};
struct sampling_method {
    enum sampling_kind kind;
    double number; /* N, K or STEP; TOL: of a channel's response to a light, in parts of that */
};
/* Reads a method as written above. Messages name `option`. */
bool sampling_read(const char *option, const char *text, struct sampling_method *out,
                   struct error *err);
/* Writes a method as sampling_read takes it, with the fewest digits that are exact. */
enum { SAMPLING_NAME = 48 };
void sampling_name(const struct sampling_method *method, char out[SAMPLING_NAME]);
/* Returns how many decimal digits of a number read back as the same double: at least 15. */
int exact_digits(double number);

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

/* A detector at first_nm, first_nm + 1, ... nm. */
struct fine_detector {
    int n, n_channels;
    double *nm;      /* owned, with the weights behind them */
    double *weights; /* detector_weights there: [channel * n + j] */
};
/* Makes a fine detector of n >= 1 nm. Fails only where memory runs out. The caller frees `nm`. */
bool fine_detector_make(const struct detector *detector, double first_nm, int n,
                        struct fine_detector *out, struct error *err);

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
/* Finds the weights of any detector at n wavelengths that stand for segments: out[channel * n + i],
 * zeroed before, = the sum over cells of 1 nm of detector x polynomial, scaled as detector_weights
 * scales. */
void sampling_weights(const struct detector *detector, const double *wavelength_nm,
                      double (*segment_nm)[2], int n, double *out);
/* Writes the name of a component: "red", "Y", "component 3"; "" for a wavelength. */
void sampling_label(const struct sampling_method *method, int page, char out[24]);
/* Prints one line: name, number of pages, negative weights, peaks, rank, limits. */
void sampling_print(const struct sampling *sampling, struct printed *to);
void sampling_free(struct sampling *sampling);

/* ---- method.c: a scene as the command line samples it ---- */

extern const struct option_list sampling_options;
/* Reads SCENE with its changes, and samples it if --sampling is given; otherwise *sampling stays
 * zeroed. Refuses --detector without --sampling or --accuracy. The caller frees both, also after a
 * failure. */
bool scene_read_sampled(const struct options *options, struct scene *out, struct sampling *sampling,
                        struct error *err);

#endif
