/* SPDX-License-Identifier: MIT */
/* The room "colour": colour spaces and differences, adaptation, displays, ICC profiles. */
#ifndef RASTER_BESIDE_COLOUR_COLOUR_H
#define RASTER_BESIDE_COLOUR_COLOUR_H

#include "data/spectra/spectra.h"

/* ---- colour.c: chromaticities, colour spaces and colour differences ---- */

/* Computes x and y; 0, 0 for black. */
void chromaticity(const double xyz[3], double out[2]);
/* Computes L*, a*, b* relative to a white (CIE 15:2018, 8.2.1). XYZ may be negative. If X, Y or Z
 * of the white is 0, that value of the colour counts as 0. `out` may be xyz. */
void cielab(const double xyz[3], const double white[3], double out[3]);
/* Return the difference of two colours in CIELAB. CIE 94 takes the first as the standard, with the
 * weights of graphic arts (kL = kC = kH = 1, K1 = 0.045, K2 = 0.015; CIE 116-1995). CIEDE2000 is
 * ISO/CIE 11664-6 with kL = kC = kH = 1. */
double cie76_difference(const double a[3], const double b[3]);
double cie94_difference(const double standard[3], const double sample[3]);
double ciede2000_difference(const double a[3], const double b[3]);

/* ---- rows.c: small tables ---- */

/* Reads a file of n rows of three numbers, which blanks, commas or semicolons part; before them may
 * stand the row's name. Lines without numbers are headings. Refuses anything else. */
bool rows_of_three(const char *path, const char *const *names, int n, double (*out)[3],
                   struct error *err);

/* ---- adaptation.c: how the eye adapts to the light ---- */

enum adaptation_kind {
    ADAPTATION_NONE,
    ADAPTATION_VON_KRIES, /* complete, in Hunt-Pointer-Estevez cone responses: eqs. 17 to 20 */
    ADAPTATION_FAIRCHILD, /* incomplete, more so under dimmer light: equations 21 to 23 */
    ADAPTATION_BRADFORD,  /* complete, linear (ICC.1:2010, annex E) */
    ADAPTATION_CAT16      /* complete (CIE 248:2022) */
};
struct adaptation {
    enum adaptation_kind kind;
    double luminance; /* Fairchild: of the adapting light, cd/m2; 0: 10 x the intensity of the
                         lights, as in the thesis */
};
/* Reads none, von-kries, fairchild, fairchild:LUMINANCE, bradford or cat16. Messages name
 * `option`. */
bool adaptation_read(const char *option, const char *text, struct adaptation *out,
                     struct error *err);
extern const char *const adaptation_names[]; /* of enum adaptation_kind */
/* Writes the matrix from XYZ to the cone responses in which a kind adapts; all 0 for none. */
void adaptation_cones(enum adaptation_kind kind, double out[3][3]);
/* Writes the matrix from XYZ to adapted XYZ; the identity for none. A complete adaptation maps the
 * white to display_white. `equal` is the XYZ of a radiance of 1 at all wavelengths. Fairchild's
 * kind needs a luminance above 0. Refuses a white with a cone response of 0 or less. */
bool adaptation_matrix(const struct adaptation *adaptation, const double white[3],
                       const double equal[3], double out[3][3], struct error *err);

/* ---- display.c: tristimulus values on a display ---- */

/* The tone curve of a display: linear = (gain x value + offset)^exponent; for values below `from`
 * linear = slope x value. */
struct display_curve {
    double exponent, gain, offset, slope, from;
};
struct display {
    const char *name;
    bool is_srgb;           /* IEC 61966-2-1 */
    double primaries[3][3]; /* XYZ of red, green and blue at full drive; of sRGB 0 */
    double matrix[3][3];    /* from XYZ, with Y = 100 for white, to linear red, green and blue */
    struct display_curve curve[3];
    unsigned char profile[1024]; /* ICC's, with matrix and tone curves */
    size_t profile_length;
};
/* Reads srgb; monitor, that of the thesis (equations 13 and 14); or a file of six rows of three
 * numbers: X, Y, Z of red, green and blue at full drive, where 100 is the Y of a picture's white;
 * gain, offset and gamma of the three. The name must outlive *out. Refuses primaries in a plane or
 * that add up to no white; gain, gamma and gain + offset lie from 0.01 to 100. */
bool display_is_known(const char *name); /* it is no file */
bool display_read(const char *name, struct display *out, struct error *err);
/* Returns the value, 0 to 1, that makes the display show a linear value of channel 0, 1 or 2. Clips
 * values that the display cannot show. */
double display_encode(const struct display *of, int channel, double linear);
/* Returns the largest linear value of a channel that is not clipped: 1 for sRGB. */
double display_largest(const struct display *of, int channel);
/* Stores the values of a pixel as three numbers of 8 bits (uint8_t) or 16 (uint16_t). Returns
 * whether a channel was clipped; by less than 1e-6 does not count, since rounding may clip a white
 * by that. */
bool display_store(const struct display *of, int bits, const double linear[3], void *out);

#endif
