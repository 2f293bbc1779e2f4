/* SPDX-License-Identifier: MIT */
/* The room "spectra": spectra, detectors, tristimulus values, Gaussian quadrature, fluorescence. */
#ifndef DATA_SPECTRA_SPECTRA_H
#define DATA_SPECTRA_SPECTRA_H

#include "data/text/text.h"

/* ---- spectrum.c: sampled and analytic spectra ---- */

enum spectrum_kind {
    SPECTRUM_NONE = 0,  /* absent */
    SPECTRUM_CONSTANT,  /* parameter[0] at every wavelength */
    SPECTRUM_SAMPLED,   /* linear between samples */
    SPECTRUM_BLACKBODY, /* parameter[0]: temperature in K; 1.0 at 560 nm (Planck, CODATA 2018 c2) */
    SPECTRUM_GAUSSIAN   /* exp(-4 ln 2 ((nm - parameter[0]) / parameter[1])^2): centre, full width
                           at half maximum */
};
enum spectrum_ends { SPECTRUM_ZERO, SPECTRUM_HOLD }; /* outside the samples: 0, or the end value */

struct spectrum {
    enum spectrum_kind kind;
    double parameter[2];
    double factor;                 /* multiplies every value */
    int count;                     /* samples */
    double *wavelength_nm, *value; /* count each, wavelengths strictly increasing; owned */
    int n_limited;                 /* values that were noise beyond 0, or 1, and became that */
    double limited_nm;             /* the wavelength of the first */
    char *name;                    /* as written, for reports; owned */
    char *path;                    /* of its file, where that is not built in; NULL: none; owned */
    struct place place;
};

/* Reads a SPECTRUM word: the name of a built-in illuminant, a number, a file, blackbody:K,
 * daylight:K or gaussian:CENTRE,WIDTH, each optionally with *FACTOR, which is finite and not
 * negative. A table of several value columns (an observer) needs :COLUMN, from 1: cie1931:2. File
 * names are relative to the word's file. Refuses, at its own place, a value that is below `lowest`
 * or, times the factor, above `highest`: only reflectances have an upper limit. */
bool spectrum_read(const struct word *word, double lowest, double highest, struct spectrum *out,
                   struct error *err);
/* Adds one sample at the end. Refuses a wavelength that does not increase or is not positive. */
bool spectrum_append(struct spectrum *spectrum, double wavelength_nm, double value,
                     struct place place, struct error *err);
/* Refuses wavelengths that can only be in micrometres or metres. */
bool spectrum_is_in_nm(const struct spectrum *spectrum, struct error *err);
double spectrum_at(const struct spectrum *spectrum, double wavelength_nm, enum spectrum_ends ends);
/* Returns true if wavelength_nm lies outside the samples of a sampled spectrum. */
bool spectrum_extrapolates(const struct spectrum *spectrum, double wavelength_nm);
void spectrum_free(struct spectrum *spectrum);
/* The tables that words of a text have named: each is read once. Zero it before use. */
struct tables {
    struct index paths;
    struct table *list; /* owned */
    int n;
};
void tables_free(struct tables *tables);
/* Returns whether a text, before its first line, is a table of spectra and no list of names. */
bool set_is(struct text text);
/* Reads all samples, each as spectrum_read reads a file of one: (*out)[*n], with their names; a
 * sample without a name has its number. The caller's cursor stays. The caller frees them, also
 * after a failure, by set_free. */
bool set_read(struct text text, double highest, struct spectrum **out, int *n, struct error *err);
void set_free(struct spectrum *samples, int n);
/* Returns true if a built-in table has three values a line. */
bool table_is_detector(const struct builtin_file *file);

/* ---- detector.c: the response of a detector to a spectrum ---- */

/* Sensitivities over wavelength, one a channel. */
struct detector {
    char *name;     /* as written; owned */
    bool observer;  /* colour matching functions: its channels are tristimulus values X, Y and Z */
    bool named;     /* so that their names say which of X, Y, Z or R, G, B they are */
    int n;          /* channels */
    char **channel; /* their names, which belong to the sensitivities; owned */
    struct spectrum *sensitivity; /* owned */
};
/* Reads a built-in detector (spectral list detectors), or a table of a wavelength and a value for
 * each channel a line, with their names in its heading; or a set of samples, each of them a
 * channel. Three channels that are named x, y and z are an observer; others are a camera. The
 * caller frees *out, also after a failure. */
bool channels_read(const char *name, struct detector *out, struct error *err);
/* Reads a detector likewise, and refuses one without three channels. */
bool detector_read(const char *name, struct detector *out, struct error *err);
/* Reads a detector likewise, and refuses a camera. */
bool observer_read(const char *name, struct detector *out, struct error *err);
void detector_free(struct detector *detector);
/* Computes the weights of n >= 1 increasing wavelengths: out[channel * n + i] is the weight of the
 * radiance at wavelength i in a channel. A wavelength stands for the range half-way to its
 * neighbours, the first and the last for a whole step, a single one for 1 nm. On a uniform grid
 * that is equation 11 of the thesis. An observer's weights are scaled, so that radiance 1
 * everywhere has Y = 100: k = 100 / (sum of y over its own table x step), even if the wavelengths
 * cover only a part of the table. A camera's weights are not scaled. */
void detector_weights(const struct detector *detector, const double *wavelengths_nm, int n,
                      double *out);
/* Returns the factor by which an observer's weights give cd m-2 of radiances in W sr-1 m-2 nm-1:
 * 683 lm/W (CIE 15) over k. */
double detector_luminance(const struct detector *detector);
/* Computes the response to n radiances by such weights: XYZ, or a camera's channels. `radiance`
 * NULL: 1 everywhere. */
void detector_response(const double *weights, const double *radiance, int n, double out[3]);
/* Computes the part, 0 to 1, of each channel's sensitivity (of its magnitude, if it is negative),
 * n values of a detector of n channels, that lies outside the wavelengths: before half a step below
 * the first, or beyond half a step above the last. */
void detector_lost(const struct detector *detector, const double *wavelengths_nm, int n,
                   double *out);
/* Computes the part that lies outside the range from first_nm to last_nm. */
void detector_lost_outside(const struct detector *detector, double first_nm, double last_nm,
                           double *out);

/* ---- quadrature.c: Gaussian quadrature ---- */

struct quadrature {
    int n; /* nodes, increasing */
    double node[LARGEST_QUADRATURE], weight[LARGEST_QUADRATURE];
};
/* Gauss-Legendre from first to last, 1 <= n <= LARGEST_QUADRATURE, is exact for polynomials of
 * degree 2n - 1. Nodes and weights are right to 1e-14 of the interval. */
void quadrature_legendre(double first, double last, int n, struct quadrature *out);
/* Finds the quadrature of a sum over `count` increasing points x of weight w, by the polynomials of
 * Stieltjes's procedure (Gautschi, Orthogonal Polynomials, 2004, 2.2). Weights w may change sign.
 * Then weights of the result may be negative. Returns false if there is no quadrature: fewer than n
 * points have weight, or the nodes are not real, distinct and between the first and the last x. */
bool quadrature_discrete(const double *x, const double *w, int count, int n,
                         struct quadrature *out);
/* Returns the value at x of the polynomial that is 1 at node i, 0 at others (thesis, eq. 2). */
double quadrature_lagrange(const double *node, int n, int i, double x);

/* ---- tristimulus.c: matrices of tristimulus values ---- */

/* XYZ of the white of displays, D65: x = 0.3127, y = 0.3290 (IEC 61966-2-1), Y = 100. */
extern const double display_white[3];
/* Matrices have three rows and act on columns of tristimulus values. The inverse needs a matrix
 * that is not singular. out must not be an input. */
void tristimulus_inverse(double m[3][3], double out[3][3]);
void tristimulus_apply(double m[3][3], const double xyz[3], double out[3]);
/* Replaces n columns by their products with a matrix. Their three rows are n numbers apart: the 3
 * columns may be those of another matrix. */
void tristimulus_apply_all(double m[3][3], int n, double *columns);
/* Write the matrices from XYZ, with Y = 100 for white, to linear red, green and blue of sRGB, 0 to
 * 1 (IEC 61966-2-1), and to the cone responses of Hunt, Pointer and Estevez (thesis, eq. 17). */
void tristimulus_to_srgb(double out[3][3]);
void tristimulus_to_cones(double out[3][3]);

/* ---- fluorescence.c: light that is absorbed at one wavelength and emitted at another ---- */

/* Returns N = sum(light x excitation) / sum(excitation), equations 6 to 9 of the thesis: the factor
 * of the emission under this light. The sums run over the wavelengths of both spectra within the
 * excitation's own, whatever range a picture shows. Each wavelength counts for the distance
 * half-way to its neighbours, the first and last for a whole step: on one uniform grid these are
 * the thesis's plain sums. N is 0 if the excitation is 0 at all of these wavelengths. */
double excitation_mean(const struct spectrum *light, const struct spectrum *excitation);

/* A bispectral (Donaldson) matrix: the share of the light in an excitation band that the surface
 * emits in an emission band. Each band reaches half-way to its neighbours, as above. The diagonal,
 * of equal wavelengths, is 0: it is the diffuse reflectance. */
struct donaldson {
    struct spectrum excitation, emission; /* their wavelengths; the values are 0 */
    double *share;                        /* [emission][excitation], not negative; owned */
};
/* Reads a table: a first row with a word and the excitation wavelengths, then rows of an emission
 * wavelength and its shares, or its densities: shares divided by the nm of the emission band. A
 * diagonal with a value above 0 becomes *diffuse, which must be the constant 0 then. Refuses a
 * matrix of zeros, decimal commas, and, with its wavelength, a column that emits more than the
 * surface absorbs there (1 - diffuse). The caller frees *out, also after a failure. */
bool donaldson_read(const char *path, struct place from, bool densities, struct spectrum *diffuse,
                    struct donaldson *out, struct error *err);
/* Computes the emission under a light of intensity 1, at its wavelengths. *out is allocated. */
bool donaldson_emission(const struct donaldson *matrix, const struct spectrum *light,
                        struct spectrum *out, struct error *err);
void donaldson_free(struct donaldson *matrix);

/* Computes the part, 0 to 1, of the emission that has a shorter wavelength than the light that the
 * surface absorbed; and the largest share of the light of a wavelength that the surface emits. Of a
 * matrix: by its shares; of two curves: share is NULL. */
void fluorescence_balance(const struct spectrum *excitation, const struct spectrum *emission,
                          const double *share, double *shorter, double *most);

/* Returns how many of n increasing wavelengths are at most this one. */
int samples_up_to(const double *wavelengths_nm, int n, double wavelength_nm);

#endif
