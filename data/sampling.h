/* SPDX-License-Identifier: MIT */
/* Between the files that make samplings. */
#ifndef SAMPLING_H
#define SAMPLING_H

#include "data/terms/terms.h"

/* What a sampling is made of; out has the grid, its detector's name and its weights there. */
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

/* ---- data/weighing.c ---- */

bool sample_box(const struct sampling_task *task, struct error *err);
bool sample_riemann(const struct sampling_task *task, struct error *err);
/* rgb and xyz. */
bool sample_tristimulus(const struct sampling_task *task, struct error *err);
/* Refuses more pages than `most` nm. */
bool sampling_refuse(const struct sampling_task *task, int most, struct error *err);
/* Three rows of n numbers as a matrix combines them. */
void sampling_transform(double m[3][3], const double *rows, int n, double *out);

/* ---- data/gauss.c ---- */

bool sample_gauss(const struct sampling_task *task, struct error *err);

/* ---- data/adaptive.c ---- */

bool sample_adaptive(const struct sampling_task *task, struct error *err);

/* ---- data/basis.c ---- */

bool sample_basis(const struct sampling_task *task, struct error *err);
/* Turns rows of n numbers (finite, with squares that are) among themselves until they are
 * orthogonal, the longest first: Jacobi's method on one side. */
void orthogonal_rows(double *row, int rows, int n);

#endif
