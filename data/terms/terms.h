/* SPDX-License-Identifier: MIT */
/* The room "terms": products of the spectra of lights and materials, multiplied once for all
 * vertices. It depends on no geometry, no drawing and no method of sampling. */
#ifndef TERMS_H
#define TERMS_H

#include "data/material/material.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "spectral.h"

/* ---- data/terms/spectral_pages.c: pages made of spectra ---- */

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
/* Returns the value of a spectrum on a page. SPECTRUM_HOLD means a reflectance, SPECTRUM_ZERO a
 * light. */
double page_value(const struct spectral_pages *pages, const struct spectrum *spectrum, int page,
                  enum spectrum_ends ends);
/* Computes the mean of all lights and ambient lights, weighted by intensity: the radiance on each
 * page of a perfect diffuser under one such light of intensity 1. Returns the sum of the
 * intensities, or 0 if nothing shines; *out is then undefined. */
double scene_white(const struct scene *scene, const struct spectral_pages *pages, double *out);

/* ---- data/terms/illumination.c: lights that shine ---- */

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
    struct shining_light *lights; /* in the scene's order; owned */
    int *first, n_first;          /* those that are the first of their spectrum; owned */
};
/* Lists the lights that are not 0 everywhere. Scene and pages must outlive *out. */
bool illumination_make(const struct scene *scene, const struct spectral_pages *pages,
                       bool exchangeable, struct illumination *out, struct error *err);
void illumination_free(struct illumination *illumination);

/* ---- data/terms/terms.c: materials under lights ---- */

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
/* Lists the materials of all objects, each once, and their partners. Lists all materials of a
 * material map, since only its mesh decides which of them are needed. The array is allocated, even
 * for no materials; after a failure it is NULL. */
bool materials_shown(const struct scene *scene, const struct material ***out, int *n,
                     struct error *err);

#endif
