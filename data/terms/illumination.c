/* SPDX-License-Identifier: MIT */
/* Lists the lights that shine. Lights that differ only in strength share their terms. A light that
 * is 0 everywhere does not shine. If lights may be exchanged, all of them are kept, each by itself.
 */
#include <stdlib.h>
#include <string.h>

#include "data/terms/terms.h"

bool spectrum_is_zero(const struct spectrum *spectrum)
{
    bool zero = spectrum->kind == SPECTRUM_CONSTANT && spectrum->parameter[0] == 0;
    if (spectrum->kind == SPECTRUM_SAMPLED) {
        zero = true;
        for (int i = 0; i < spectrum->count; i++)
            zero = zero && spectrum->value[i] == 0;
    }
    return zero || spectrum->factor == 0;
}

/* Returns whether one spectrum is the other times a factor. Compares without rounding, so it may
 * miss a pair. */
static bool same_spectrum(const struct spectrum *a, const struct spectrum *b)
{
    if (a->kind != b->kind || a->count != b->count)
        return false;
    size_t size = (size_t)a->count * sizeof *a->value;
    return a->kind == SPECTRUM_CONSTANT ||
           (memcmp(a->parameter, b->parameter, sizeof a->parameter) == 0 &&
            (size == 0 || (memcmp(a->wavelength_nm, b->wavelength_nm, size) == 0 &&
                           memcmp(a->value, b->value, size) == 0)));
}

static double strength(const struct light *light)
{
    const struct spectrum *spectrum = &light->spectrum;
    double level = spectrum->kind == SPECTRUM_CONSTANT ? spectrum->parameter[0] : 1;
    return light->intensity * spectrum->factor * level;
}

/* Adds the light, and finds the first one of its spectrum. Two lights share no spectrum if the
 * share is too large or too small to be exact. */
static void add_light(struct illumination *illumination, const struct light *light)
{
    int index = illumination->n_lights++;
    struct shining_light *new = &illumination->lights[index];
    *new = (struct shining_light){light, index, 1};
    for (int i = 0; i < index && !illumination->exchangeable; i++) {
        const struct shining_light *other = &illumination->lights[i];
        double share = strength(light) / strength(other->light);
        if (other->first != i || !(share > 1e-30 && share < 1e30) ||
            !same_spectrum(&light->spectrum, &other->light->spectrum))
            continue;
        new->first = i;
        new->share = share;
        return;
    }
}

bool illumination_make(const struct scene *scene, const struct spectral_pages *pages,
                       bool exchangeable, struct illumination *out, struct error *err)
{
    *out = (struct illumination){.scene = scene, .pages = *pages, .exchangeable = exchangeable};
    out->lights = calloc((size_t)scene->n_lights + 1, sizeof *out->lights);
    if (!out->lights)
        return error_memory(err);
    for (int i = 0; i < scene->n_lights; i++) {
        const struct light *light = &scene->lights[i];
        if (exchangeable || (light->intensity != 0 && !spectrum_is_zero(&light->spectrum)))
            add_light(out, light);
    }
    return true;
}

void illumination_free(struct illumination *illumination)
{
    free(illumination->lights);
    *illumination = (struct illumination){.n_lights = 0};
}
