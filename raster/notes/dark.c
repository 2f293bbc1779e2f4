/* SPDX-License-Identifier: MIT */
/* Notes on darkness: no light shines, or an object in view is black in all bands. */
#include <math.h>

#include "data/terms/terms.h"
#include "raster/notes/notes.h"
#include "raster/radiance/radiance.h"

/* ---- no light ---- */

/* Returns true if the light is above 0 at some wavelength of the picture. */
static bool shines(const struct plan *plan, const struct spectrum *spectrum, double intensity)
{
    return intensity != 0 && pages_show(&plan->illumination.pages, spectrum);
}

/* Returns whether anything reaches the picture: a light, or the light of a material. */
static bool has_light(const struct plan *plan)
{
    const struct scene *scene = plan->scene;
    for (int i = 0; i < scene->n_lights; i++)
        if (shines(plan, &scene->lights[i].spectrum, scene->lights[i].intensity))
            return true;
    for (int i = 0; i < scene->n_ambients; i++)
        if (shines(plan, &scene->ambients[i].spectrum, scene->ambients[i].intensity))
            return true;
    for (int i = 0; i < plan->n_materials; i++)
        for (int t = 0; t < plan->materials[i].n_terms; t++)
            if (plan->materials[i].made.terms[t].peak > 0)
                return true;
    return false;
}

static bool note_no_light(const struct plan *plan, struct notes *notes, struct error *err)
{
    const struct scene *scene = plan->scene;
    const struct light *light = scene->lights;
    const struct ambient *ambient = scene->ambients;
    if (scene->n_lights + scene->n_ambients == 0)
        return note_add(notes, "no-light", err,
                        "the scene has no light: the picture is black; add a line such as "
                        "light d65 1 direction 0 0 1");
    const struct place place = scene->n_lights > 0 ? light->place : ambient->place;
    const double intensity = scene->n_lights > 0 ? light->intensity : ambient->intensity;
    return note_add(notes, "no-light", err,
                    "no light shines: the picture is black; the first light (%.200s:%d) %s",
                    place.path, place.line,
                    intensity == 0 ? "has intensity 0" : "is 0 at every wavelength of the picture");
}

/* ---- black objects ---- */

enum darkness { NOT_BLACK, MATERIAL, TEXTURE, FAR_SIDE, FACES_AWAY, SPOTS_MISS, TOO_WEAK, N_DARK };
static const char *const why[N_DARK] = {
    [MATERIAL] = "at every wavelength of the picture its light or its reflectance is 0",
    [TEXTURE] = "its texture is black",
    [FAR_SIDE] = "light reaches only a side that is not in view; a light's position or direction "
                 "says where it comes from",
    [FACES_AWAY] = "its normals face no light; move a light, or "
                   "write two-sided if its back is seen",
    [SPOTS_MISS] = "all of its vertices lie outside the cones of the spots; light between vertices "
                   "is not seen",
    [TOO_WEAK] = "it reflects less than half a count of the full scale",
};

/* Returns true if the material reflects nothing because its author wrote so: diffuse 0. */
static bool is_meant(const struct material *material)
{
    return material->diffuse.kind == SPECTRUM_CONSTANT && spectrum_is_zero(&material->diffuse) &&
           material->gloss == 0 && material->excitation.kind == SPECTRUM_NONE &&
           !material->donaldson && material->glow.kind == SPECTRUM_NONE;
}

/* Returns true if some vertex of the surface faces a light that the surface reflects. */
static bool faces_light(const struct lit_scene *lit, int surface)
{
    const struct view *view = &lit->plan->view;
    const struct surface *of = &lit->surfaces[surface];
    for (int l = 0; l < view->n_lights; l++)
        for (int i = 0; reflects(of->instance, &view->lights[l]) && i < of->instance->n_vertices;
             i++)
            for (int side = 0; side < of->n_sides; side++)
                if (light_cosine(of, i, side, &view->lights[l]) > 0)
                    return true;
    return false;
}

/* Returns true if nothing of the surface in view shows light, or hardly anything: where a solid is
 * lit from behind, triangles at its outline have a lit corner. A spot may light little on purpose.
 */
static bool is_dark(const struct scene_survey *survey, int surface)
{
    const struct surface_survey *seen = &survey->surfaces[surface];
    const struct view *view = &survey->lit->plan->view;
    bool spots = false;
    for (int i = 0; i < view->n_lights; i++)
        spots = spots || view->lights[i].spot;
    return seen->brightest_in_view <= survey_black(survey) ||
           (!spots && seen->dark_area >= 0.95 * seen->area);
}

/* Phong shading lights points between vertices, so that dark vertices show nothing. */
static enum darkness darkness_of(const struct scene_survey *survey, int surface)
{
    const struct surface_survey *seen = &survey->surfaces[surface];
    const struct shaded_material *shaded = survey->lit->bounds[surface].shaded;
    const bool phong = survey->lit->plan->scene->shading == SHADING_PHONG;
    double peak = 0;
    for (int t = 0; t < shaded->n_terms; t++)
        peak = fmax(peak, shaded->made.terms[t].peak);
    if (seen->area == 0 || !is_dark(survey, surface) || is_meant(shaded->material))
        return NOT_BLACK;
    if (peak == 0)
        return MATERIAL;
    if (shaded->texture && shaded->texture->largest == 0)
        return TEXTURE;
    if (phong)
        return NOT_BLACK;
    return seen->brightest > survey_black(survey) ? FAR_SIDE
           : !faces_light(survey->lit, surface)   ? FACES_AWAY
           : seen->brightest == 0                 ? SPOTS_MISS
                                                  : TOO_WEAK;
}

/* One note for all objects that are black for one reason. */
static bool note_black(const struct plan *plan, const int *n, const int *first, struct notes *notes,
                       struct error *err)
{
    char object[256], others[40];
    for (int reason = NOT_BLACK + 1; reason < N_DARK; reason++) {
        if (n[reason] == 0)
            continue;
        object_text(plan, first[reason], object, sizeof object);
        others[0] = '\0';
        if (n[reason] > 1)
            snprintf(others, sizeof others, "%d objects, first ", n[reason]);
        if (!note_add(notes, "black", err, "%s: %s%s: %s",
                      reason == FAR_SIDE ? "black, or almost" : "black in all bands", others,
                      object, why[reason]))
            return false;
    }
    return true;
}

bool note_dark(const struct scene_survey *survey, struct notes *notes, struct error *err)
{
    const struct plan *plan = survey->lit->plan;
    int n[N_DARK] = {0}, first[N_DARK], last[N_DARK];
    if (!has_light(plan))
        return note_no_light(plan, notes, err);
    for (int s = 0; s < plan->n_instances; s++) {
        const enum darkness reason = darkness_of(survey, s);
        if (n[reason] == 0)
            first[reason] = s;
        /* halves and parts of an object count once */
        n[reason] +=
            n[reason] == 0 || plan->instances[s].object != plan->instances[last[reason]].object;
        last[reason] = s;
    }
    return note_black(plan, n, first, notes, err);
}
