/* SPDX-License-Identifier: MIT */
/* Notes on darkness: nothing is in view, or an object in view is black in all bands. */
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "raster/render/inside.h"

/* Returns the sum of what all lights may give all vertices of a surface. Phong shading lights
 * points between vertices: there each light that the material shows counts. */
static double light_of(const struct lit_scene *lit, int index)
{
    const struct surface *surface = &lit->surfaces[index];
    const struct shaded_material *shaded = lit->bounds[index].shaded;
    const bool phong = lit->plan->scene->shading == SHADING_PHONG;
    double light = 0;
    for (int i = 0; i < surface->instance->n_vertices; i++)
        for (int side = 0; side < surface->n_sides; side++) {
            const double *weights = surface->weights + surface_attributes(surface, i, side);
            for (int t = 0; t < shaded->n_terms; t++)
                light += (phong ? 1 : weights[t]) * shaded->made.terms[t].peak;
        }
    return shaded->texture && !phong ? light * shaded->texture->largest : light;
}

/* A material of diffuse 0 alone is meant to be black. */
static bool is_black(const struct lit_scene *lit, int index)
{
    const struct material *material = lit->bounds[index].shaded->material;
    const bool meant = spectrum_is_zero(&material->diffuse) && material->gloss == 0 &&
                       material->excitation.kind == SPECTRUM_NONE && !material->donaldson &&
                       material->glow.kind == SPECTRUM_NONE;
    return lit->plan->instances[index].in_view && !meant && light_of(lit, index) == 0;
}

/* Adds one note for all objects that are black. Halves and parts of an object count once. */
void note_dark(const struct lit_scene *lit, struct notes *notes)
{
    const struct placed_instance *instances = lit->plan->instances;
    const struct object *last = NULL;
    int n = 0, first = 0;
    char object[256];
    bool shows = false;
    for (int s = 0; s < lit->plan->n_instances; s++) {
        shows = shows || instances[s].in_view;
        if (instances[s].object == last || !is_black(lit, s))
            continue;
        first = n++ == 0 ? s : first;
        last = instances[s].object;
    }
    if (!shows)
        notes_of_nothing(notes);
    if (n == 0)
        return;
    object_text(lit->plan, first, object, sizeof object);
    note_add(notes, "black",
             "%d object%s black, first %s: no light that it shows reaches its vertices", n,
             n == 1 ? " is" : "s are", object);
}
