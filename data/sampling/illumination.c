/* SPDX-License-Identifier: MIT */
/* Lists the lights that shine. Lights that differ only in strength share their terms. A light that
 * is 0 everywhere does not shine. If lights may be exchanged, all of them are kept, each by itself.
 */
#include "data/sampling/sampling.h"

bool spectrum_is_zero(const struct spectrum *spectrum)
{
    bool zero = spectrum->kind == SPECTRUM_SAMPLED ||
                (spectrum->kind == SPECTRUM_CONSTANT && spectrum->parameter[0] == 0);
    for (int i = 0; i < spectrum->count; i++)
        zero = zero && spectrum->value[i] == 0;
    return zero || spectrum->factor == 0;
}

/* Returns whether one spectrum is the other times a factor. Compares their numbers without
 * rounding, so it may miss a pair. */
static bool are_alike(const struct spectrum *a, const struct spectrum *b)
{
    const size_t size = (size_t)a->count * sizeof *a->value;
    return a->kind == b->kind && a->count == b->count &&
           (a->kind == SPECTRUM_CONSTANT ||
            memcmp(a->parameter, b->parameter, sizeof a->parameter) == 0) &&
           (size == 0 || (memcmp(a->wavelength_nm, b->wavelength_nm, size) == 0 &&
                          memcmp(a->value, b->value, size) == 0));
}

static double strength(const struct light *light)
{
    const struct spectrum *spectrum = &light->spectrum;
    double level = spectrum->kind == SPECTRUM_CONSTANT ? spectrum->parameter[0] : 1;
    return light->intensity * spectrum->factor * level;
}

/* Returns the first light that the light shares its spectrum with; itself: there is none. A light
 * with shadows shares its spectrum with no other. Two lights share none if the share is too large
 * or too small to be exact, or no number. */
static int find_first(const struct illumination *of, int index)
{
    struct shining_light *light = &of->lights[index];
    for (int i = 0; !of->exchangeable && !light->light->shadows && i < index; i++) {
        const struct light *first = of->lights[i].light;
        const double share = strength(light->light) / strength(first);
        if (of->lights[i].first < i || first->shadows || !(share > 1e-30 && share < 1e30) ||
            !are_alike(&light->light->spectrum, &first->spectrum))
            continue;
        light->share = share;
        return i;
    }
    return index;
}

bool illumination_make(const struct scene *scene, const struct spectral_pages *pages,
                       bool exchangeable, struct illumination *out, struct error *err)
{
    const size_t n = (size_t)scene->n_lights + 1;
    *out = (struct illumination){.scene = scene, .pages = *pages, .exchangeable = exchangeable};
    const bool done = MAKE_ARRAY(out->lights, n, err, "%zu lights", n);
    for (int i = 0; done && i < scene->n_lights; i++) {
        const struct light *light = &scene->lights[i];
        if (!exchangeable && (light->intensity == 0 || spectrum_is_zero(&light->spectrum)))
            continue;
        const int index = out->n_lights++;
        out->lights[index] = (struct shining_light){.light = light, .share = 1};
        const int first = out->lights[index].first = find_first(out, index);
        out->lights[first].n_alike++;
        out->n_first += first == index;
    }
    return done;
}

void illumination_free(struct illumination *illumination)
{
    free(illumination->lights);
    *illumination = (struct illumination){.n_lights = 0};
}
