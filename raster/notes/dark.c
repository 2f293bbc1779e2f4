/* SPDX-License-Identifier: MIT */
/* Notes on darkness: nothing is in view, no light shines, or an object in view is black in all
 * bands. */
#include <math.h>

#include "raster/notes/notes.h"

/* Returns an upper bound on the radiance of the vertices of a surface in all bands. */
static double brightest_of(const struct lit_scene *lit, int index)
{
    const struct surface *surface = &lit->surfaces[index];
    const struct shaded_material *shaded = lit->bounds[index].shaded;
    double brightest = 0;
    for (int i = 0; i < surface->instance->n_vertices; i++)
        for (int side = 0; side < surface->n_sides; side++) {
            const double *weights = surface->weights + surface_attributes(surface, i, side);
            double radiance = 0;
            for (int t = 0; t < shaded->n_terms; t++)
                radiance += weights[t] * shaded->made.terms[t].peak;
            brightest = fmax(brightest, radiance);
        }
    return shaded->texture ? brightest * shaded->texture->largest : brightest;
}

/* Returns true if the material shows a light, or its own. */
static bool is_lit(const struct shaded_material *shaded)
{
    for (int t = 0; t < shaded->n_terms; t++)
        if (shaded->made.terms[t].peak > 0)
            return true;
    return false;
}

/* Phong shading lights points between vertices, so that dark vertices show nothing. A material of
 * diffuse 0 alone is meant to be black. */
static bool is_black(const struct lit_scene *lit, int index)
{
    const struct shaded_material *shaded = lit->bounds[index].shaded;
    const struct material *material = shaded->material;
    const bool meant = spectrum_is_zero(&material->diffuse) && material->gloss == 0 &&
                       material->excitation.kind == SPECTRUM_NONE && !material->donaldson &&
                       material->glow.kind == SPECTRUM_NONE;
    return lit->plan->instances[index].in_view && !meant &&
           (!is_lit(shaded) || lit->plan->scene->shading != SHADING_PHONG) &&
           brightest_of(lit, index) == 0;
}

/* Adds one note for all objects that are black. Halves and parts of an object count once. */
static void note_black(const struct lit_scene *lit, struct notes *notes)
{
    const struct placed_instance *instances = lit->plan->instances;
    int n = 0, first = 0, last = 0;
    char object[256];
    for (int s = 0; s < lit->plan->n_instances; s++)
        if (is_black(lit, s)) {
            first = n == 0 ? s : first;
            n += n == 0 || instances[s].object != instances[last].object;
            last = s;
        }
    if (n == 0)
        return;
    object_text(lit->plan, first, object, sizeof object);
    note_add(notes, "black",
             "%d object%s black, first %s: no light that it shows reaches its vertices", n,
             n == 1 ? " is" : "s are", object);
}

void note_dark(const struct lit_scene *lit, struct notes *notes)
{
    const struct plan *plan = lit->plan;
    bool shows = false, shines = false;
    for (int i = 0; i < plan->n_instances; i++)
        shows = shows || plan->instances[i].in_view;
    for (int i = 0; i < plan->n_materials; i++)
        shines = shines || is_lit(&plan->materials[i]);
    if (!shows)
        notes_of_nothing(notes);
    else if (!shines)
        note_add(notes, "no-light", "the picture is black: no light shines that a material shows");
    else
        note_black(lit, notes);
}
