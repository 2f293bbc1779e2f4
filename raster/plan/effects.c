/* SPDX-License-Identifier: MIT */
/* Prints the plan in words: each effect with the reason why it is simulated or not, each light, and
 * each value that is guessed, not measured. */
#include <string.h>

#include "data/spectra/spectra.h"
#include "raster/plan/plan.h"

/* ---- counting what the plan uses ---- */

/* How many materials, objects and lights call for each effect. */
struct counts {
    int ambient, diffuse, specular, with_excitation, with_matrix, fluorescent, bispectral, textured,
        spectrally_textured, emitting, halves;
    int two_sided, mapped, tessellated;
    int attenuated, spots;
};

static bool has_term(const struct shaded_material *shaded, enum term_kind kind)
{
    for (int i = 0; i < shaded->n_terms; i++)
        if (shaded->made.terms[i].kind == kind)
            return true;
    return false;
}

static bool has_excitation(const struct shaded_material *shaded)
{
    return shaded->material->excitation.kind != SPECTRUM_NONE;
}

/* A material with a partner and the partner count as one. */
static void count_material(const struct shaded_material *shaded, struct counts *n)
{
    const struct material *material = shaded->material;
    const struct texture *texture = shaded->texture;
    n->ambient += shaded->made.ambient;
    n->diffuse += has_term(shaded, TERM_DIFFUSE);
    n->specular += has_term(shaded, TERM_SPECULAR);
    n->with_excitation += has_excitation(shaded);
    n->with_matrix += material->donaldson != NULL;
    n->fluorescent += shaded->made.fluoresces && has_excitation(shaded);
    n->bispectral += shaded->made.fluoresces && material->donaldson;
    n->textured += texture && !texture->spectral;
    n->spectrally_textured += texture && texture->spectral;
    n->emitting += shaded->made.emits;
    n->halves += material->partner || material->partner_name;
}

static void count_object(const struct object *object, double tessellation, struct counts *n)
{
    const struct shape other = shape_tessellated(&object->shape, tessellation);
    n->two_sided += object->two_sided;
    n->mapped += object->material_map != NULL;
    n->tessellated += memcmp(object->shape.parameter, other.parameter, sizeof other.parameter) != 0;
}

static struct counts count_all(const struct plan *plan)
{
    struct counts n = {.ambient = 0};
    for (int i = 0; i < plan->n_materials; i++)
        count_material(&plan->materials[i], &n);
    for (int i = 0; i < plan->scene->n_objects; i++)
        count_object(&plan->scene->objects[i], plan->scene->tessellation, &n);
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

/* ---- the plan in words ---- */

const char *plan_why_off(const struct plan *plan, const struct light *light)
{
    const struct spectral_pages *pages = &plan->illumination.pages;
    for (int i = 0; i < plan->n_lights; i++)
        if (plan->sources[i] == light)
            return NULL;
    return light->intensity == 0                  ? "intensity 0"
           : !pages_show(pages, &light->spectrum) ? "spectrum 0 at every wavelength shown"
                                                  : "no material reflects it";
}

static void print_lights(const struct plan *plan, FILE *to)
{
    for (int i = 0; i < plan->scene->n_lights; i++) {
        const struct light *light = &plan->scene->lights[i];
        const char *off = plan_why_off(plan, light);
        fprintf(to, "light %-11d %s%s (%s, intensity %.6g)\n", i + 1, off ? "off: " : "on",
                off ? off : "", light->spectrum.name, light->intensity);
    }
}

static void print_extrapolation(const struct plan *plan, const char *what, const char *ends,
                                const struct spectrum *spectrum, const char *owner, FILE *to)
{
    const struct spectral_pages *pages = &plan->illumination.pages;
    const int n = pages_looked_at(pages);
    int outside = 0;
    for (int i = 0; i < n; i++)
        outside += spectrum_extrapolates(spectrum, pages_looked_at_nm(pages, i));
    if (outside > 0)
        fprintf(to, "extrapolated      %s %s: %d of %d wavelengths outside %g..%g nm, %s there\n",
                what, owner, outside, n, spectrum->wavelength_nm[0],
                spectrum->wavelength_nm[spectrum->count - 1], ends);
}

static void print_material(const struct plan *plan, const struct shaded_material *shaded, FILE *to)
{
    static const char held[] = "the end value holds", dark[] = "0";
    const struct material *material = shaded->material;
    print_extrapolation(plan, "diffuse", held, &material->diffuse, material->name, to);
    if (has_term(shaded, TERM_SPECULAR))
        print_extrapolation(plan, "specular", held, &material->specular, material->name, to);
    if (shaded->made.fluoresces && has_excitation(shaded))
        print_extrapolation(plan, "emission", dark, &material->emission, material->name, to);
    if (shaded->made.emits)
        print_extrapolation(plan, "emission", dark, &material->glow, material->name, to);
    if (material->from_rgb)
        fprintf(to, "not measured      %s: RGB of %s, spread over three bands\n", material->name,
                material->path);
}

static void print_texture(const struct plan *plan, const struct texture *texture, FILE *to)
{
    const struct image *image = &texture->image;
    struct spectrum pages = {
        .kind = SPECTRUM_SAMPLED, .count = image->n_pages, .wavelength_nm = image->wavelengths_nm};
    fprintf(to, "texture           %s: %d x %d texels, %d pages, %s%s\n", image->path, image->width,
            image->height, image->n_pages, texture->linear ? "linear" : "nearest",
            texture->spectral && plan->sampling ? ", at the wavelength of each page" : "");
    if (texture->spectral)
        print_extrapolation(plan, "texture", "the end page holds", &pages, image->path, to);
}

static void print_guesses(const struct plan *plan, FILE *to)
{
    const struct scene *scene = plan->scene;
    for (int i = 0; i < plan->n_lights; i++)
        print_extrapolation(plan, "light", "0", &plan->sources[i]->spectrum,
                            plan->sources[i]->spectrum.name, to);
    for (int i = 0; i < scene->n_ambients; i++)
        print_extrapolation(plan, "ambient", "0", &scene->ambients[i].spectrum,
                            scene->ambients[i].spectrum.name, to);
    for (int i = 0; i < plan->n_materials; i++)
        print_material(plan, &plan->materials[i], to);
}

static void print_work(const struct plan *plan, FILE *to)
{
    const struct scene *scene = plan->scene;
    const struct rectangle picture = plan_picture(plan);
    int passes = plan->n_passes * plan->n_light_groups, most = 0;
    for (int i = 0; i < plan->n_materials; i++)
        most = plan->materials[i].n_terms > most ? plan->materials[i].n_terms : most;
    fprintf(to, "objects           %d (%d instances, %ld vertices, %ld triangles)\n",
            scene->n_objects, plan->n_instances, plan->n_vertices, plan->n_triangles);
    fprintf(to, "materials         %d (%ld terms, at most %d in one)\n", plan->n_materials,
            plan->work.terms, most);
    fprintf(to, "excitation        %ld integrals\n", plan->work.excitation_integrals);
    fprintf(to, "tiles             %d of %d x %d pixels\n", plan_tiles(plan, &picture),
            plan->tile_width, plan->tile_height);
    fprintf(to, "passes            %ld (%d a tile, %d bands and %d lights each)\n",
            (long)passes * plan_tiles(plan, &picture), passes, BANDS_PER_PASS, LIGHTS_PER_PASS);
    fprintf(to, "memory            %.1f MiB for a tile\n", (double)plan->tile_bytes / 1048576);
    fprintf(to, "file              %llu bytes of pixels\n", (unsigned long long)plan->file_bytes);
}

static void print_bands(const struct plan *plan, FILE *to)
{
    const struct scene *scene = plan->scene;
    if (plan->sampling && !plan->sampling->spectral)
        fprintf(to, "bands             %d (components)\n", plan->n_bands);
    else
        fprintf(to, "bands             %d (%.10g to %.10g nm)\n", plan->n_bands,
                scene->wavelengths_nm[0], scene->wavelengths_nm[plan->n_bands - 1]);
    if (plan->sampling) {
        fprintf(to, "sampling          ");
        sampling_print(plan->sampling, to);
    }
}

void plan_print(const struct plan *plan, FILE *to)
{
    const struct scene *scene = plan->scene;
    fprintf(to, "scene             %s\n", scene->path);
    fprintf(to, "picture           %d x %d pixels\n", scene->width, scene->height);
    print_bands(plan, to);
    print_work(plan, to);
    for (int i = 0; i < plan->n_effects; i++)
        fprintf(to, "%-17s %s (%s)\n", plan->effects[i].name, plan->effects[i].used ? "yes" : "no",
                plan->effects[i].reason);
    print_lights(plan, to);
    for (int i = 0; i < plan->n_textures; i++)
        print_texture(plan, &plan->textures[i], to);
    print_guesses(plan, to);
}
