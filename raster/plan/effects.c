/* SPDX-License-Identifier: MIT */
/* Lists the effects of a plan, each with the reason why it is simulated or not. */
#include <string.h>

#include "data/spectra/spectra.h"
#include "raster/plan/inside.h"

/* ---- counting what the plan uses ---- */

/* How many materials, objects and lights call for each effect. */
struct counts {
    int ambient, diffuse, specular, with_excitation, with_matrix, fluorescent, bispectral, textured,
        spectrally_textured, emitting, halves;
    int two_sided, mapped, tessellated;
    int attenuated, spots;
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
        n.mapped += object->material_map != NULL;
        n.tessellated += memcmp(shape->parameter, other.parameter, sizeof other.parameter) != 0;
    }
    for (int i = 0; i < plan->n_lights; i++) {
        n.attenuated += plan->lights[i].attenuated;
        n.spots += plan->lights[i].spot;
    }
    return n;
}

/* ---- effects and their reasons ---- */

static void add_effect(struct plan *plan, const char *name, bool used, const char *reason)
{
    struct plan_effect *effect = &plan->effects[plan->n_effects++];
    effect->name = name;
    effect->used = used;
    snprintf(effect->reason, sizeof effect->reason, "%s", reason);
}

static void add_counted(struct plan *plan, const char *name, int used, int all, const char *what,
                        const char *otherwise)
{
    char reason[sizeof plan->effects->reason];
    snprintf(reason, sizeof reason, "%d of %d %s", used, all, what);
    add_effect(plan, name, used > 0, used > 0 ? reason : otherwise);
}

static void add_material_effect(struct plan *plan, const char *name, int used,
                                const char *otherwise)
{
    add_counted(plan, name, used, plan->n_materials, "materials", otherwise);
}

static void add_shading(struct plan *plan, const char *name, enum shading_kind shading)
{
    const enum shading_kind used = plan->scene->shading;
    add_effect(plan, name, used == shading,
               used == shading         ? "the scene asks for it"
               : used == SHADING_FLAT  ? "shading is flat"
               : used == SHADING_PHONG ? "shading is phong"
                                       : "shading is smooth");
}

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
    const bool local = scene->local_viewer && n.specular > 0;
    add_material_effect(plan, "ambient", n.ambient, "no ambient light reflected");
    add_counted(plan, "lights", plan->n_lights, scene->n_lights, "shine", "no light shines");
    add_material_effect(plan, "diffuse", n.diffuse, "no material reflects a light");
    add_material_effect(plan, "specular", n.specular, "no lit material has gloss");
    add_effect(plan, "local_viewer", local,
               local                 ? "the scene asks for it"
               : scene->local_viewer ? "no highlight depends on it"
                                     : "the viewer is infinite");
    add_counted(plan, "attenuation", n.attenuated, plan->n_lights, "lights", "no light weakens");
    add_counted(plan, "spot", n.spots, plan->n_lights, "lights", "no light is a spot");
    add_material_effect(plan, "fluorescence", n.fluorescent,
                        why_no_luminescence(plan, n.with_excitation, "no material has excitation"));
    add_material_effect(
        plan, "bispectral", n.bispectral,
        why_no_luminescence(plan, n.with_matrix, "no material has a Donaldson matrix"));
    add_material_effect(plan, "texture", n.textured, "no lit material has a texture");
    add_material_effect(plan, "spectral_texture", n.spectrally_textured,
                        "no lit material has a spectral texture");
    add_material_effect(plan, "emission", n.emitting, "no material emits");
    add_material_effect(plan, "metamer", n.halves, "no material has a partner");
    add_counted(plan, "two_sided", n.two_sided, scene->n_objects, "objects",
                "no object is two-sided");
    add_shading(plan, "flat", SHADING_FLAT);
    add_shading(plan, "phong", SHADING_PHONG);
    add_counted(plan, "material_map", n.mapped, scene->n_objects, "objects",
                "no object has several materials");
    add_counted(plan, "tessellation", n.tessellated, scene->n_objects, "objects",
                scene->tessellation == 1 ? "shapes are as the scene says"
                                         : "no object has other numbers by the factor");
}
