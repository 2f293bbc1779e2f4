/* SPDX-License-Identifier: MIT */
/* Materials under the lights of the plan, each made when it is first asked for, with its texture. A
 * material without terms is black: its texture is not opened. */
#include "data/stack/stack.h"
#include "raster/plan/inside.h"

/* ---- textures ---- */

/* A texture is read when it is first asked for; NULL after an error. A material asks once. */
static struct texture *find_texture(struct plan *plan, const struct material *material,
                                    struct error *err)
{
    struct texture *texture = plan->textures;
    for (; texture < plan->textures + plan->n_textures; texture++)
        if (strcmp(texture->image.path, material->texture) == 0 &&
            texture->spectral == material->spectral_texture && texture->rgb == material->from_rgb &&
            texture->linear == (material->texture_filter != TEXTURE_NEAREST) &&
            texture->mipmapped == (material->texture_filter == TEXTURE_LINEAR))
            return texture;
    *texture = (struct texture){.spectral = material->spectral_texture,
                                .rgb = material->from_rgb,
                                .linear = material->texture_filter != TEXTURE_NEAREST,
                                .mipmapped = material->texture_filter == TEXTURE_LINEAR};
    plan->n_textures++; /* counted first, so that plan_free reaches it after a failure */
    return texture_read(material->texture, material->texture_place, tags_read, texture, err)
               ? texture
               : NULL;
}

struct texels plan_texels(const struct texture *texture, int plane)
{
    return (struct texels){texture->plane[plane], texture->image.width, texture->image.height,
                           texture->linear, texture->n_levels};
}

void plan_place(const struct texels *texels, const double *rows, size_t stride,
                double out[TEXEL_PLACE])
{
    const int n = place_rows(texels);
    for (int i = 0; i < TEXEL_PLACE; i++)
        out[i] = i < n ? rows[(size_t)i * stride] : 0;
}

bool plan_load_textures(const struct plan *plan, int first_band, struct error *err)
{
    for (int i = 0; i < plan->n_textures; i++)
        if (plan->textures[i].shown &&
            !texture_load(&plan->textures[i], plan->scene->wavelengths_nm + first_band,
                          pass_bands(plan, first_band), err))
            return false;
    return true;
}

/* ---- shaded materials ---- */

/* Makes the terms as the reference takes them, and counts their colours: a constant term is one of
 * OpenGL's, another term one for each light of its spectrum. */
static bool copy_terms(const struct plan *plan, struct shaded_material *out, struct error *err)
{
    static const enum reflection reflections[] = {
        [TERM_CONSTANT] = CONSTANT, [TERM_DIFFUSE] = DIFFUSE, [TERM_SPECULAR] = SPECULAR};
    out->n_terms = out->made.n;
    if (!MAKE_ARRAY(out->terms, out->n_terms, err, "the terms of a material"))
        return false;
    for (int t = 0; t < out->n_terms; t++) {
        const struct spectral_term *made = &out->made.terms[t];
        out->terms[t] = (struct term){reflections[made->kind], made->light};
        out->n_colours +=
            made->kind == TERM_CONSTANT ? 1 : plan->illumination.lights[made->light].n_alike;
    }
    return true;
}

double shaded_brightest(const struct shaded_material *shaded)
{
    double most = 0;
    for (int t = 0; t < shaded->n_terms; t++)
        most = fmax(most, shaded->made.terms[t].peak);
    return most > 0 ? most : 1;
}

double shaded_radiance(const struct plan *plan, const struct shaded_material *shaded,
                       const double *weights, int band)
{
    double radiance = 0;
    for (int t = 0; t < shaded->n_terms; t++)
        radiance +=
            weights[t] * shaded->made.spectra[(size_t)t * (size_t)plan->n_bands + (size_t)band];
    return radiance;
}

bool shaded_material_find(struct plan *plan, const struct material *material, int *out,
                          struct error *err)
{
    *out = index_find(&plan->by_material, &material, sizeof material);
    if (*out >= 0)
        return true;
    *out = plan->n_materials++; /* counted first, so that plan_free reaches it after a failure */
    struct shaded_material *shaded = &plan->materials[*out];
    shaded->material = material;
    if (!material_terms_make(&plan->illumination, material, &shaded->made, err))
        return false;
    plan->work.terms += shaded->made.n;
    plan->work.excitation_integrals += shaded->made.excitation_integrals;
    if (!copy_terms(plan, shaded, err) ||
        !index_add(&plan->by_material, &material, sizeof material, *out, err))
        return false;
    if (!material->texture || shaded->n_terms == 0)
        return true;
    shaded->texture = find_texture(plan, material, err);
    return shaded->texture;
}
