/* SPDX-License-Identifier: MIT */
/* Lists the effects of a plan, each with the reason why it is simulated or not. */
#include "raster/plan/inside.h"

/* ---- counting what the plan uses ---- */

/* How many materials, objects and lights call for each effect. */
struct counts {
    int ambient, diffuse, specular, with_excitation, with_matrix, fluorescent, bispectral, textured,
        mipmapped, spectrally_textured, emitting, halves;
    int two_sided, mapped, displaced, tessellated;
    int attenuated, spots, shadows;
};

bool has_term(const struct shaded_material *shaded, enum term_kind kind)
{
    for (int i = 0; i < shaded->n_terms; i++)
        if (shaded->made.terms[i].kind == kind)
            return true;
    return false;
}

/* A material with a partner and the partner count as one. */
static void count_material(const struct shaded_material *shaded, struct counts *n)
{
    const struct material *material = shaded->material;
    const struct texture *texture = shaded->texture;
    const bool has_excitation = material->excitation.kind != SPECTRUM_NONE;
    n->ambient += shaded->made.ambient;
    n->diffuse += has_term(shaded, TERM_DIFFUSE);
    n->specular += has_term(shaded, TERM_SPECULAR);
    n->with_excitation += has_excitation;
    n->with_matrix += material->donaldson != NULL;
    n->fluorescent += shaded->made.fluoresces && has_excitation;
    n->bispectral += shaded->made.fluoresces && material->donaldson;
    n->textured += texture && !texture->spectral;
    n->mipmapped += texture && texture->n_levels > 1;
    n->spectrally_textured += texture && texture->spectral;
    n->emitting += shaded->made.emits;
    n->halves += material->partner || material->partner_name;
}

static struct counts count_all(const struct plan *plan)
{
    struct counts n = {.ambient = 0};
    for (int i = 0; i < plan->n_materials; i++)
        count_material(&plan->materials[i], &n);
    for (int i = 0; i < plan->scene->n_objects; i++) {
        const struct object *object = &plan->scene->objects[i];
        const struct shape *shape = &object->shape,
                           other = shape_tessellated(shape, plan->scene->tessellation);
        n.two_sided += object->two_sided;
        n.mapped += object->n_assignments > 0;
        n.displaced += shape->relief != NULL;
        n.tessellated += memcmp(shape->parameter, other.parameter, sizeof other.parameter) != 0;
    }
    for (int i = 0; i < plan->n_lights; i++) {
        n.attenuated += plan->lights[i].attenuated;
        n.spots += plan->lights[i].spot;
        n.shadows += plan->sources[i]->shadows;
    }
    return n;
}

/* ---- effects and their reasons ---- */

static const char *why_no_luminescence(const struct plan *plan, int able, const char *none_able)
{
    return able == 0                                       ? none_able
           : plan->illumination.pages.reflectance_analysis ? "rgb and xyz cannot show it"
                                                           : "nothing is excited and shown";
}

void plan_effects(struct plan *plan)
{
    const struct scene *scene = plan->scene;
    const struct counts n = count_all(plan);
    const enum shading_kind shading = scene->shading;
    const int materials = plan->n_materials, objects = scene->n_objects, lights = plan->n_lights;
    const char *is_other = shading == SHADING_FLAT    ? "shading is flat"
                           : shading == SHADING_PHONG ? "shading is phong"
                                                      : "shading is smooth";
    const struct plan_effect effects[N_EFFECTS] = {
        {"ambient", n.ambient, materials, "materials", "no ambient light reflected"},
        {"lights", lights, scene->n_lights, "shine", "no light shines"},
        {"diffuse", n.diffuse, materials, "materials", "no material reflects a light"},
        {"specular", n.specular, materials, "materials", "no lit material has gloss"},
        {"local_viewer", scene->local_viewer && n.specular > 0, 1, NULL,
         scene->local_viewer ? "no highlight depends on it" : "the viewer is infinite"},
        {"attenuation", n.attenuated, lights, "lights", "no light weakens"},
        {"spot", n.spots, lights, "lights", "no light is a spot"},
        {"shadows", plan->view.n_shadowed, lights, "lights",
         n.shadows ? "no object throws a shadow into view" : "no light has shadows"},
        {"fluorescence", n.fluorescent, materials, "materials",
         why_no_luminescence(plan, n.with_excitation, "no material has excitation")},
        {"bispectral", n.bispectral, materials, "materials",
         why_no_luminescence(plan, n.with_matrix, "no material has a Donaldson matrix")},
        {"texture", n.textured, materials, "materials", "no lit material has a texture"},
        {"spectral_texture", n.spectrally_textured, materials, "materials",
         "no lit material has a spectral texture"},
        {"mipmaps", n.mipmapped, materials, "materials", "no texture is linear"},
        {"emission", n.emitting, materials, "materials", "no material emits"},
        {"metamer", n.halves, materials, "materials", "no material has a partner"},
        {"two_sided", n.two_sided, objects, "objects", "no object is two-sided"},
        {"flat", shading == SHADING_FLAT, 1, NULL, is_other},
        {"phong", shading == SHADING_PHONG, 1, NULL, is_other},
        {"material_map", n.mapped, objects, "objects", "no object has several materials"},
        {"displace", n.displaced, objects, "objects", "no object has a relief"},
        {"tessellation", n.tessellated, objects, "objects",
         scene->tessellation == 1 ? "shapes are as the scene says"
                                  : "no object has other numbers by the factor"}};
    memcpy(plan->effects, effects, sizeof effects);
}
