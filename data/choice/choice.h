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

/* Find tristimulus values by an observer's weights of pages: of a material's terms on the pages of
 * an illumination (0 where all pages are), which is of the same scene as the terms; and of the
 * white of the lights, or of a radiance of 1 where the observer sees none. */
bool terms_seen(const struct illumination *illumination, const struct material_terms *terms,
                const double *weights, double (*out)[3], struct error *err);
bool white_seen(const struct scene *scene, const struct spectral_pages *pages,
                const double *weights, double white[3], struct error *err);

/* A colour that a picture shows: the weights of a material's terms, and its texture. */
struct stimulus {
    int material; /* index */
    const double *weights;
    double texel;
};
struct stimuli {
    const struct material_terms *const
        *materials; /* to which the weights belong; NULL: not shown */
    int n_materials, n;
    const struct stimulus *list;
};
/* Finds the sampling of the fewest pages, of those whose pages are radiances at wavelengths, by
 * which 95 % of the stimuli are off by at most an error in CIEDE2000, as the observer sees them.
 * The standard is a page at every nm. Refuses a detector that is no observer, and what
 * scene_spectra refuses. */
bool sampling_choose(const struct scene *scene, const char *observer, double error,
                     const struct stimuli *stimuli, struct sampling_method *out, struct error *err);

#endif
