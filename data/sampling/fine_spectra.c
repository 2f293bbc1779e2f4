/* SPDX-License-Identifier: MIT */
/* The spectra of a scene's lights and terms at every nm, which methods of sampling look at.
 * Textures do not count: a spectral texture is taken at the wavelength of each page. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/material/material.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/terms/terms.h"
#include "spectral.h"

/* As wide as a stack of every nm may be. */
enum { WIDEST_RANGE = 65535 };
/* Sums over the range times a detector's sensitivities, and 100 of an observer, are finite. */
static const double largest_radiance = 1e290;

/* The scene at every nm: pages of their own wavelengths. */
struct fine_scene {
    double *nm; /* owned */
    struct illumination illumination;
    struct material_terms *materials; /* owned, as are all of them */
    int n;
};

/* ---- terms at every nm ---- */

static bool read_range(const struct scene *scene, double *first_nm, int *n_nm, struct error *err)
{
    const double last = scene->wavelengths_nm[scene->n_wavelengths - 1];
    *first_nm = scene->wavelengths_nm[0];
    const double n = floor(last - *first_nm + 1e-9) + 1;
    *n_nm = (int)fmin(n, WIDEST_RANGE);
    return n <= WIDEST_RANGE ||
           error_at(err, scene->wavelengths_place,
                    "wavelengths from %.10g to %.10g nm; a sampling takes up to %d nm", *first_nm,
                    last, WIDEST_RANGE);
}

static bool make_illumination(const struct scene *scene, struct fine_scene *out, struct error *err)
{
    double first_nm;
    int n;
    if (!read_range(scene, &first_nm, &n, err))
        return false;
    out->nm = calloc((size_t)n, sizeof *out->nm);
    if (!out->nm)
        return error_memory(err);
    for (int i = 0; i < n; i++)
        out->nm[i] = first_nm + i;
    const struct spectral_pages pages = {.n = n, .wavelength_nm = out->nm};
    return illumination_make(scene, &pages, false, &out->illumination, err);
}

static bool make_terms(const struct scene *scene, struct fine_scene *out, struct error *err)
{
    const struct material **materials;
    int n;
    if (!materials_shown(scene, &materials, &n, err))
        return false;
    out->materials = calloc((size_t)n + 1, sizeof *out->materials);
    bool done = out->materials || error_memory(err);
    for (; done && out->n < n; out->n++)
        done = material_terms_make(&out->illumination, materials[out->n], &out->materials[out->n],
                                   err);
    free(materials);
    return done;
}

static void fine_scene_free(struct fine_scene *fine)
{
    for (int i = 0; i < fine->n; i++)
        material_terms_free(&fine->materials[i]);
    free(fine->materials);
    illumination_free(&fine->illumination);
    free(fine->nm);
}

/* ---- rows of spectra ---- */

/* Rows of n_nm values each. */
struct rows {
    double **values;
    int *n, n_nm;
};

/* A zeroed row more; NULL after an error. */
static double *add_row(const struct rows *rows, struct error *err)
{
    const size_t n_nm = (size_t)rows->n_nm;
    double *more = array_more(*rows->values, *rows->n, n_nm * sizeof *more, err);
    if (!more)
        return NULL;
    *rows->values = more;
    return more + (size_t)(*rows->n)++ * n_nm;
}

static bool check_row(const struct rows *rows, const double *row, struct place place,
                      struct error *err)
{
    for (int i = 0; i < rows->n_nm; i++)
        if (!(row[i] <= largest_radiance))
            return error_at(err, place, "radiance %g cannot be sampled; it is at most %g", row[i],
                            largest_radiance);
    return true;
}

static bool add_light(const struct rows *rows, const struct fine_scene *fine,
                      const struct spectrum *spectrum, double intensity, struct error *err)
{
    double *row = add_row(rows, err);
    for (int i = 0; row && i < rows->n_nm; i++)
        row[i] = intensity * spectrum_at(spectrum, fine->nm[i], SPECTRUM_ZERO);
    return row && check_row(rows, row, spectrum->place, err);
}

static bool add_luminescence(const struct rows *rows, const struct fine_scene *fine,
                             const struct material *material, const struct spectrum *light,
                             struct error *err)
{
    double *row = add_row(rows, err);
    return row && material_luminescence(&fine->illumination.pages, material, light, row, err) &&
           check_row(rows, row, material->place, err);
}

/* Adds what a material emits: its own light, and its luminescence under each other light. */
static bool add_emission(const struct rows *rows, const struct fine_scene *fine,
                         const struct material_terms *terms, struct error *err)
{
    const struct illumination *illumination = &fine->illumination;
    const struct scene *scene = illumination->scene;
    const struct material *material = terms->material;
    if (terms->emits && !add_light(rows, fine, &material->glow, 1, err))
        return false;
    for (int i = 0; terms->fluoresces && i < illumination->n_lights; i++)
        if (illumination->lights[i].first == i &&
            !add_luminescence(rows, fine, material, &illumination->lights[i].light->spectrum, err))
            return false;
    for (int i = 0; terms->fluoresces && i < scene->n_ambients; i++)
        if (!add_luminescence(rows, fine, material, &scene->ambients[i].spectrum, err))
            return false;
    return true;
}

/* Lights of one spectrum are one. */
static bool add_lights(const struct rows *rows, const struct fine_scene *fine, struct error *err)
{
    const struct illumination *illumination = &fine->illumination;
    const struct scene *scene = illumination->scene;
    for (int i = 0; i < illumination->n_lights; i++) {
        const struct light *light = illumination->lights[i].light;
        if (illumination->lights[i].first == i &&
            !add_light(rows, fine, &light->spectrum, light->intensity, err))
            return false;
    }
    for (int i = 0; i < scene->n_ambients; i++)
        if (!add_light(rows, fine, &scene->ambients[i].spectrum, scene->ambients[i].intensity, err))
            return false;
    for (int i = 0; i < fine->n; i++)
        if (!add_emission(rows, fine, &fine->materials[i], err))
            return false;
    return true;
}

static bool add_products(const struct rows *rows, const struct fine_scene *fine, struct error *err)
{
    const size_t n_nm = (size_t)rows->n_nm;
    for (int i = 0; i < fine->n; i++)
        for (int t = 0; t < fine->materials[i].n; t++) {
            const double *spectrum = fine->materials[i].spectra + (size_t)t * n_nm;
            double *row = add_row(rows, err);
            if (!row || !check_row(rows, spectrum, fine->materials[i].material->place, err))
                return false;
            memcpy(row, spectrum, n_nm * sizeof *row);
        }
    return true;
}

bool scene_spectra(const struct scene *scene, struct fine_spectra *out, struct error *err)
{
    struct fine_scene fine = {.n = 0};
    *out = (struct fine_spectra){.n_nm = 0};
    bool done = make_illumination(scene, &fine, err) && make_terms(scene, &fine, err);
    if (done) {
        out->first_nm = fine.nm[0];
        out->n_nm = fine.illumination.pages.n;
        const struct rows lights = {&out->lights, &out->n_lights, out->n_nm};
        const struct rows products = {&out->products, &out->n_products, out->n_nm};
        done = add_lights(&lights, &fine, err) && add_products(&products, &fine, err);
    }
    fine_scene_free(&fine);
    if (!done)
        fine_spectra_free(out);
    return done;
}

void fine_spectra_free(struct fine_spectra *spectra)
{
    free(spectra->lights);
    free(spectra->products);
    *spectra = (struct fine_spectra){.n_nm = 0};
}
