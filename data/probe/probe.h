/* SPDX-License-Identifier: MIT */
/* The room "probe": the spectrum of a pixel or a region. */
#ifndef PROBE_H
#define PROBE_H

#include "data/stack/stack.h"
#include "spectral.h"

/* A spectrum that explains the one of the pixel, e.g. the spectrum of a light. */
struct probe_curve {
    char name[96];  /* e.g. "light 1 (d65)", "reflectance" */
    bool relative;  /* a reflectance, excitation or emission; otherwise a radiance */
    double *values; /* one for each wavelength; owned */
};
enum { MAX_PROBE_CURVES = 64 };
struct probe {
    char *source; /* stack or scene; owned */
    int x, y, width, height;
    int n;                  /* wavelengths */
    double *wavelengths_nm; /* owned, as mean and spread */
    double *mean, *spread;  /* radiance, and its standard deviation over the region */
    char *object;   /* name of the only object in the region; owned; NULL: unknown, or several */
    char *observer; /* owned */
    bool has_white;
    double xyz[3], white[3];                     /* of the mean, and of the white */
    struct probe_curve curves[MAX_PROBE_CURVES]; /* of a scene; a stack has none */
    int n_curves;
};
struct probe_options {
    int x, y, width, height; /* the region in pixels */
    const char *observer, *white;
};
/* Probes a stack. Refuses a stack without spectra and a region outside the picture. The caller
 * frees *out, also after a failure. */
bool probe_stack(const char *path, const struct probe_options *options, struct probe *out,
                 struct error *err);
/* Begins a probe of a stack or scene, whose path is `source`. Refuses a region that is not within a
 * picture of this size. */
bool probe_open(struct probe *out, const char *source, const struct probe_options *options,
                int width, int height, struct error *err);
/* Copies n wavelengths, and makes room for as many means and deviations. */
bool probe_allocate(struct probe *probe, const double *wavelengths_nm, int n, struct error *err);
/* Mean and standard deviation of samples that come in runs. Zero it before use. The sums are of
 * differences from the first sample, so that the mean of equal samples is exact and their deviation
 * is 0. */
struct moments {
    uint64_t n;
    double first, sum, sum_of_squares;
};
void moments_add(struct moments *moments, const float *values, size_t n);
void moments_end(const struct moments *moments, double *mean, double *spread);
/* Computes XYZ of the mean and of the white. has_white is false if neither the options name a white
 * nor the cube records one. Refuses a white that the options name if it cannot be used. */
bool probe_colour(struct probe *probe, const struct cube *cube, const struct probe_options *options,
                  struct error *err);
/* Print a probe as lines of text, as CSV (RFC 4180) and as a chart. */
void probe_print(const struct probe *probe, struct printed *to);
void probe_print_csv(const struct probe *probe, struct printed *to);
void probe_svg(const struct probe *probe, struct printed *to);
/* Begins a text with one JSON object. */
void probe_json(const struct probe *probe, struct json *json);
void probe_free(struct probe *probe);

#endif
