/* SPDX-License-Identifier: MIT */
/* Finds the spectra of a scene's lights and terms at every nm, from which samplings are made.
 * Textures do not count: a spectral texture is read at the wavelength of each page. */
#include "data/sampling/inside.h"

/* A stack of every nm has no more pages. */
enum { WIDEST_RANGE = 65535 };
/* With this limit, sums over the range times a detector's sensitivities are finite. */
static const double largest_radiance = 1e290;

/* ---- rows of spectra ---- */

/* Adds a zeroed row to the lights or the products. Returns NULL after an error. */
static double *add_row(struct fine_spectra *to, bool product, struct error *err)
{
    const size_t n_nm = (size_t)to->n_nm;
    double **rows = product ? &to->products : &to->lights;
    int *n = product ? &to->n_products : &to->n_lights;
    return array_add(rows, n, NULL, n_nm * sizeof(double), err) ? *rows + (size_t)(*n - 1) * n_nm
                                                                : NULL;
}

static bool check_row(const struct fine_spectra *of, const double *row, struct place place,
                      struct error *err)
{
    for (int i = 0; i < of->n_nm; i++)
        if (!(row[i] <= largest_radiance))
            return error_at(err, place, "radiance %g cannot be sampled; expected %g at most",
                            row[i], largest_radiance);
    return true;
}

static bool add_light(struct fine_spectra *to, const struct spectrum *spectrum, double intensity,
                      struct error *err)
{
    double *row = add_row(to, false, err);
    for (int i = 0; row && i < to->n_nm; i++)
        row[i] = intensity * spectrum_at(spectrum, to->first_nm + i, SPECTRUM_ZERO);
    return row && check_row(to, row, spectrum->place, err);
}

/* Adds every light and ambient light, or the luminescence of a material (NULL: none) under it, as
 * if its intensity were 1. Lights of one spectrum are one. */
static bool add_lights(struct fine_spectra *to, const struct illumination *illumination,
                       const struct material *material, struct error *err)
{
    const struct scene *scene = illumination->scene;
    bool done = true;
    for (int i = 0; done && i < illumination->n_lights + scene->n_ambients; i++) {
        const int ambient = i - illumination->n_lights;
        if (ambient < 0 && illumination->lights[i].first < i)
            continue;
        const struct light *light =
            ambient < 0 ? illumination->lights[i].light : &scene->ambients[ambient];
        double *row = material ? add_row(to, false, err) : NULL;
        done = material ? row &&
                              material_luminescence(&illumination->pages, material,
                                                    &light->spectrum, row, err) &&
                              check_row(to, row, material->place, err)
                        : add_light(to, &light->spectrum, light->intensity, err);
    }
    return done;
}

/* Adds what a material makes of the lights: its own light, its luminescence, and each of its terms.
 */
static bool add_material(struct fine_spectra *to, const struct illumination *illumination,
                         const struct material *material, struct error *err)
{
    const size_t n_nm = (size_t)to->n_nm;
    struct material_terms terms;
    bool done = material_terms_make(illumination, material, &terms, err) &&
                (!terms.emits || add_light(to, &material->glow, 1, err)) &&
                (!terms.fluoresces || add_lights(to, illumination, material, err));
    for (int t = 0; done && t < terms.n; t++) {
        double *row = add_row(to, true, err);
        if (row)
            memcpy(row, terms.spectra + (size_t)t * n_nm, n_nm * sizeof *row);
        done = row && check_row(to, row, material->place, err);
    }
    material_terms_free(&terms);
    return done;
}

/* ---- of a scene ---- */

/* Makes the grid: pages at every nm of the scene's range. Their wavelengths are the caller's. */
static bool make_grid(const struct scene *scene, struct spectral_pages *out, struct error *err)
{
    const double first = scene->wavelengths_nm[0];
    const double last = scene->wavelengths_nm[scene->n_wavelengths - 1];
    const double n = floor(last - first + 1e-9) + 1;
    *out = (struct spectral_pages){.n = 0};
    if (n > WIDEST_RANGE)
        return error_at(err, scene->wavelengths_place,
                        "wavelengths from %.10g to %.10g nm; a sampling takes up to %d nm", first,
                        last, WIDEST_RANGE);
    out->n = (int)n;
    const bool done = sampling_numbers(&out->wavelength_nm, (size_t)n, err);
    for (int i = 0; done && i < out->n; i++)
        out->wavelength_nm[i] = first + i;
    return done;
}

bool scene_spectra(const struct scene *scene, struct fine_spectra *out, struct error *err)
{
    struct spectral_pages every_nm;
    struct illumination illumination = {.n_lights = 0};
    const struct material **materials = NULL;
    int n = 0;
    *out = (struct fine_spectra){.first_nm = scene->wavelengths_nm[0]};
    bool done = make_grid(scene, &every_nm, err);
    out->n_nm = every_nm.n;
    done = done && illumination_make(scene, &every_nm, false, &illumination, err) &&
           materials_shown(scene, &materials, &n, err) && add_lights(out, &illumination, NULL, err);
    for (int i = 0; done && i < n; i++)
        done = add_material(out, &illumination, materials[i], err);
    illumination_free(&illumination);
    FREE_ALL(materials, every_nm.wavelength_nm);
    return done;
}
