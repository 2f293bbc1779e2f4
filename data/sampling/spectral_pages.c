/* SPDX-License-Identifier: MIT */
/* Pages made of spectra: computes the value of a spectrum on a page, and the white of a scene. */
#include <float.h>

#include "data/sampling/inside.h"

struct spectral_pages scene_pages(const struct scene *scene)
{
    return (struct spectral_pages){.n = scene->n_wavelengths,
                                   .wavelength_nm = scene->wavelengths_nm};
}

int pages_looked_at(const struct spectral_pages *pages)
{
    return pages->analysis ? pages->n_nm : pages->n;
}

double pages_looked_at_nm(const struct spectral_pages *pages, int i)
{
    return pages->analysis ? pages->first_nm + i : pages->wavelength_nm[i];
}

bool pages_show(const struct spectral_pages *pages, const struct spectrum *light)
{
    for (int i = 0; i < pages_looked_at(pages); i++)
        if (spectrum_at(light, pages_looked_at_nm(pages, i), SPECTRUM_ZERO) != 0)
            return true;
    return false;
}

double page_value(const struct spectral_pages *pages, const struct spectrum *spectrum, int page,
                  enum spectrum_ends ends)
{
    const bool is_reflectance = ends == SPECTRUM_HOLD && pages->reflectance_analysis;
    const double *analysis = is_reflectance ? pages->reflectance_analysis : pages->analysis;
    if (!analysis || pages->of_products)
        return spectrum_at(spectrum, pages->wavelength_nm[page], ends);
    double sum = 0;
    for (int j = 0; j < pages->n_nm; j++) {
        double weight = analysis[(size_t)page * (size_t)pages->n_nm + (size_t)j];
        sum += weight != 0 ? weight * spectrum_at(spectrum, pages->first_nm + j, ends) : 0;
    }
    return pages->clips ? fmax(sum, 0) : sum;
}

/* ---- the white ---- */

double scene_white(const struct scene *scene, const struct spectral_pages *pages, double *out)
{
    double intensity = 0, largest = 0;
    bool finite = true;
    for (int page = 0; page < pages->n; page++) {
        intensity = out[page] = 0;
        for (int i = 0; i < scene->n_lights + scene->n_ambients; i++) {
            const struct light *light = scene_light(scene, i);
            intensity += light->intensity;
            out[page] +=
                light->intensity * page_value(pages, &light->spectrum, page, SPECTRUM_ZERO);
        }
        out[page] /= intensity;
        largest = fmax(largest, out[page]);
        finite = finite && out[page] <= DBL_MAX;
    }
    return finite && largest > 0 && intensity <= DBL_MAX ? intensity : 0;
}
