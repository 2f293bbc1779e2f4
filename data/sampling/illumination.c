/* SPDX-License-Identifier: MIT */
/* Lists the lights that shine. Lights that differ only in strength share their terms. A light that
 * is 0 everywhere does not shine. If lights may be exchanged, all of them are kept, each by itself.
 */
#include "data/sampling/sampling.h"

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

/* Writes a key that two spectra share if one is the other times a factor. It is made of their
 * numbers without rounding, so it may miss a pair. */
static void spectrum_key(const struct spectrum *spectrum, char key[65])
{
    const size_t size = (size_t)spectrum->count * sizeof *spectrum->value;
    struct digest digest;
    digest_start(&digest);
    digest_add(&digest, &spectrum->kind, sizeof spectrum->kind);
    if (spectrum->kind != SPECTRUM_CONSTANT)
        digest_add(&digest, spectrum->parameter, sizeof spectrum->parameter);
    if (size > 0) {
        digest_add(&digest, spectrum->wavelength_nm, size);
        digest_add(&digest, spectrum->value, size);
    }
    digest_end(&digest, key);
}

static double strength(const struct light *light)
{
    const struct spectrum *spectrum = &light->spectrum;
    double level = spectrum->kind == SPECTRUM_CONSTANT ? spectrum->parameter[0] : 1;
    return light->intensity * spectrum->factor * level;
}

/* The list of lights while it is made. */
struct light_list {
    struct illumination *to;
    struct index spectra; /* the first lights by their spectra, */
    int *next;            /* and after each the next first one of the same spectrum; 0: none */
};

/* Returns the first light that the light shares its spectrum with; itself: there is none. Two
 * lights share no spectrum if the share is too large or too small to be exact. *last is the last
 * light of this spectrum that had no other to share with; -1: none. */
static int find_first(const struct light_list *list, int index, const char *key, int *last)
{
    struct shining_light *lights = list->to->lights;
    *last = index_find(&list->spectra, key, strlen(key));
    for (int i = *last; i >= 0; i = list->next[i] > 0 ? list->next[i] : -1) {
        const double share = strength(lights[index].light) / strength(lights[i].light);
        *last = i;
        if (!(share > 1e-30 && share < 1e30))
            continue;
        lights[index].share = share;
        return i;
    }
    return index;
}

/* Adds the light. A light with shadows shares its spectrum with no other, and neither does one that
 * has no strength in numbers. */
static bool add_light(struct light_list *list, const struct light *light, struct error *err)
{
    struct illumination *to = list->to;
    const int index = to->n_lights++;
    const bool alone =
        to->exchangeable || light->shadows || !(strength(light) > 0 && isfinite(strength(light)));
    int first = index, last = -1;
    char key[65];
    to->lights[index] = (struct shining_light){.light = light, .share = 1};
    if (!alone) {
        spectrum_key(&light->spectrum, key);
        first = find_first(list, index, key, &last);
    }
    to->lights[index].first = first;
    to->lights[first].n_alike++;
    if (first != index)
        return true;
    to->first[to->n_first++] = index;
    if (last >= 0)
        list->next[last] = index;
    return alone || last >= 0 || index_add(&list->spectra, key, strlen(key), index, err);
}

bool illumination_make(const struct scene *scene, const struct spectral_pages *pages,
                       bool exchangeable, struct illumination *out, struct error *err)
{
    const size_t n = (size_t)scene->n_lights + 1;
    struct light_list list = {.to = out};
    *out = (struct illumination){.scene = scene, .pages = *pages, .exchangeable = exchangeable};
    bool done = MAKE_ARRAY(list.next, n, err, "%zu lights", n) &&
                MAKE_ARRAY(out->lights, n, err, "%zu lights", n) &&
                MAKE_ARRAY(out->first, n, err, "%zu lights", n);
    for (int i = 0; done && i < scene->n_lights; i++) {
        const struct light *light = &scene->lights[i];
        if (exchangeable || (light->intensity != 0 && !spectrum_is_zero(&light->spectrum)))
            done = add_light(&list, light, err);
    }
    index_free(&list.spectra);
    free(list.next);
    return done;
}

void illumination_free(struct illumination *illumination)
{
    FREE_ALL(illumination->lights, illumination->first);
    *illumination = (struct illumination){.n_lights = 0};
}
