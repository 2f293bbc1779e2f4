/* SPDX-License-Identifier: MIT */
/* Finds the spectra of a scene's lights and terms at every nm, from which samplings are made.
 * Textures do not count: a spectral texture is read at the wavelength of each page. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/sampling/inside.h"

/* A stack of every nm has no more pages. */
enum { WIDEST_RANGE = 65535 };
/* With this limit, sums over the range times a detector's sensitivities are finite. */
static const double largest_radiance = 1e290;

/* A scene at every nm, with pages of their own wavelengths. */
struct fine_scene {
    double *nm; /* owned */
    struct illumination illumination;
    struct material_terms *materials; /* owned, as are all of them */
    int n;
};

/* ---- terms at every nm ---- */

static bool make_illumination(const struct scene *scene, struct fine_scene *out, struct error *err)
{
    const double first = scene->wavelengths_nm[0];
    const double last = scene->wavelengths_nm[scene->n_wavelengths - 1];
    const double n = floor(last - first + 1e-9) + 1;
    if (n > WIDEST_RANGE)
        return error_at(err, scene->wavelengths_place,
                        "wavelengths from %.10g to %.10g nm; a sampling takes up to %d nm", first,
                        last, WIDEST_RANGE);
    out->nm = sampling_numbers((size_t)n, err);
    if (!out->nm)
        return false;
    for (int i = 0; i < (int)n; i++)
        out->nm[i] = first + i;
    const struct spectral_pages pages = {.n = (int)n, .wavelength_nm = out->nm};
    return illumination_make(scene, &pages, false, &out->illumination, err);
}

static bool make_terms(const struct scene *scene, struct fine_scene *out, struct error *err)
{
    const struct material **materials;
    int n;
    if (!materials_shown(scene, &materials, &n, err))
        return false;
    bool done = MAKE_ARRAY(out->materials, n, err, "the spectra of %d materials", n);
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

/* Adds a zeroed row. Returns NULL after an error. */
static double *add_row(const struct rows *rows, struct error *err)
{
    const size_t n_nm = (size_t)rows->n_nm, row = (size_t)*rows->n;
    return array_add(rows->values, rows->n, NULL, n_nm * sizeof(double), err)
               ? *rows->values + row * n_nm
               : NULL;
}

static bool check_row(const struct rows *rows, const double *row, struct place place,
                      struct error *err)
{
    for (int i = 0; i < rows->n_nm; i++)
        if (!(row[i] <= largest_radiance))
            return error_at(err, place, "radiance %g cannot be sampled; expected %g at most",
                            row[i], largest_radiance);
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

/* Adds the luminescence of a material under a light of intensity 1. */
static bool add_luminescence(const struct rows *rows, const struct fine_scene *fine,
                             const struct material *material, const struct spectrum *light,
                             struct error *err)
{
    double *row = add_row(rows, err);
    return row && material_luminescence(&fine->illumination.pages, material, light, row, err) &&
           check_row(rows, row, material->place, err);
}

/* Adds every light and ambient light, or the luminescence of a material (NULL: none) under it.
 * Lights of one spectrum are one. */
static bool add_lights(const struct rows *rows, const struct fine_scene *fine,
                       const struct material *material, struct error *err)
{
    const struct illumination *illumination = &fine->illumination;
    const struct scene *scene = illumination->scene;
    bool done = true;
    for (int i = 0; done && i < illumination->n_first + scene->n_ambients; i++) {
        const int ambient = i - illumination->n_first;
        const struct light *light = ambient < 0 ? illumination->lights[illumination->first[i]].light
                                                : &scene->ambients[ambient];
        done = material ? add_luminescence(rows, fine, material, &light->spectrum, err)
                        : add_light(rows, fine, &light->spectrum, light->intensity, err);
    }
    return done;
}

/* Adds what shines: lights, then the own light and the luminescence of each material. */
static bool add_sources(const struct rows *rows, const struct fine_scene *fine, struct error *err)
{
    bool done = add_lights(rows, fine, NULL, err);
    for (int i = 0; done && i < fine->n; i++) {
        const struct material_terms *terms = &fine->materials[i];
        if (terms->emits)
            done = add_light(rows, fine, &terms->material->glow, 1, err);
        if (terms->fluoresces)
            done = done && add_lights(rows, fine, terms->material, err);
    }
    return done;
}

static bool add_products(const struct rows *rows, const struct fine_scene *fine, struct error *err)
{
    const size_t n_nm = (size_t)rows->n_nm;
    for (int i = 0; i < fine->n; i++)
        for (int t = 0; t < fine->materials[i].n; t++) {
            double *row = add_row(rows, err);
            if (!row)
                return false;
            memcpy(row, fine->materials[i].spectra + (size_t)t * n_nm, n_nm * sizeof *row);
            if (!check_row(rows, row, fine->materials[i].material->place, err))
                return false;
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
        done = add_sources(&lights, &fine, err) && add_products(&products, &fine, err);
    }
    fine_scene_free(&fine);
    if (!done)
        fine_spectra_free(out);
    return done;
}

void fine_spectra_free(struct fine_spectra *spectra)
{
    FREE_ALL(spectra->lights, spectra->products);
    *spectra = (struct fine_spectra){.n_nm = 0};
}
