/* SPDX-License-Identifier: MIT */
/* Materials under the lights of the plan, each made when it is first asked for, with its texture. A
 * material without terms is black: its texture is not opened. */
#include <stdlib.h>
#include <string.h>

#include "plan.h"

/* ---- textures ---- */

static bool same_texture(const struct texture *a, const char *path, bool spectral, bool linear)
{
    return a->spectral == spectral && a->linear == linear && strcmp(a->image.path, path) == 0;
}

/* A texture is read when it is first asked for; NULL after an error. */
static struct texture *find_texture(struct plan *plan, const struct material *material,
                                    struct error *err)
{
    bool spectral = material->spectral_texture != NULL, linear = material->texture_linear;
    const char *path = spectral ? material->spectral_texture : material->texture;
    struct place place = spectral ? material->spectral_texture_place : material->texture_place;
    struct texture *new = &plan->textures[plan->n_textures];
    for (int i = 0; i < plan->n_textures; i++)
        if (same_texture(&plan->textures[i], path, spectral, linear))
            return &plan->textures[i];
    if (!(spectral ? texture_read_spectral : texture_read)(path, place, linear, new, err))
        return NULL;
    plan->n_textures++;
    plan->work.textures_loaded++;
    return new;
}

bool plan_load_textures(const struct plan *plan, int first_band, struct error *err)
{
    int n = plan->n_bands - first_band;
    for (int i = 0; i < plan->n_textures; i++)
        if (!texture_load(&plan->textures[i], plan->scene->wavelengths_nm + first_band,
                          n < BANDS_PER_PASS ? n : BANDS_PER_PASS, err))
            return false;
    return true;
}

/* ---- shaded materials ---- */

int finish_rows(const struct finish *finish)
{
    bool places = finish->texture && finish->texture->spectral;
    return finish->n_terms + (places ? 2 : 0);
}

/* A constant term is one colour of OpenGL's, another term one for each light of its spectrum. */
static int count_colours(const struct plan *plan, const struct material_terms *made)
{
    int n = 0;
    for (int t = 0; t < made->n; t++) {
        n += made->terms[t].kind == TERM_CONSTANT;
        for (int i = 0; i < plan->n_lights; i++)
            n += plan->lights[i].first == made->terms[t].light;
    }
    return n;
}

static bool make_terms(struct plan *plan, const struct material *material, struct finish *out,
                       struct error *err)
{
    struct material_terms made;
    plan->work.materials_loaded++;
    if (!material_terms_make(&plan->illumination, material, &made, err))
        return false;
    plan->work.terms += made.n;
    plan->work.excitation_integrals += made.excitation_integrals;
    *out = (struct finish){.material = material,
                           .n_terms = made.n,
                           .n_colours = count_colours(plan, &made),
                           .terms = made.terms, /* taken over, as the spectra */
                           .spectra = made.spectra,
                           .ambient = made.ambient,
                           .emits = made.emits,
                           .fluoresces = made.fluoresces};
    return true;
}

static bool find_terms(struct plan *plan, const struct material *material, int *out,
                       struct error *err)
{
    for (*out = 0; *out < plan->n_finishes; ++*out)
        if (plan->finishes[*out].material == material)
            return true;
    if (!make_terms(plan, material, &plan->finishes[*out], err))
        return false;
    plan->n_finishes++;
    return true;
}

bool shaded_material_find(struct plan *plan, const struct material *material, int *out,
                          struct error *err)
{
    const bool textured = material->texture || material->spectral_texture;
    if (!find_terms(plan, material, out, err))
        return false;
    struct finish *finish = &plan->finishes[*out];
    if (textured && finish->n_terms > 0 && !finish->texture) {
        finish->texture = find_texture(plan, material, err);
        if (!finish->texture)
            return false;
    }
    if (finish_rows(finish) > plan->max_rows)
        plan->max_rows = finish_rows(finish);
    return true;
}
