/* SPDX-License-Identifier: MIT */
/* The room "choice": the accuracy that the user wants, and the sampling that it calls for. */
#ifndef CHOICE_H
#define CHOICE_H

#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "spectral.h"

/* An error that 95 % of object pixels may have at most. */
struct wanted_accuracy {
    double error;
    bool counts; /* of 65535, in every band; otherwise CIEDE2000 */
};
/* Reads an error: "0.5" is in CIEDE2000, "8counts" in counts. Messages name `option`. */
bool accuracy_read(const char *option, const char *text, struct wanted_accuracy *out,
                   struct error *err);
/* Refuses a value that accuracy_read refuses. */
bool accuracy_accepts(const char *option, const char *value, struct error *err);

/* Finds the sampling of the fewest pages, of those whose pages are radiances at wavelengths, by
 * which no colour of the scene is off by more than an error in CIEDE2000. The colours are those of
 * each material under its ambient light, with each light and with all of them, and in highlights,
 * as the observer sees them; the standard is a page at every nm. *predicted: the largest error that
 * is left. Refuses a detector that is no observer, and what scene_spectra refuses. */
bool sampling_choose(const struct scene *scene, const char *observer, double error,
                     struct sampling_method *out, double *predicted, struct error *err);

#endif
