/* SPDX-License-Identifier: MIT */
/* A note on lights that add less than half a count anywhere. Beside other light that half may still
 * decide a rounding, so that such a light is kept. */
#include <math.h>

#include "raster/notes/notes.h"

/* Returns the largest part of a light that distance leaves at a vertex. */
static double least_weakened(const struct instance *instance, const struct eye_light *light)
{
    double largest = light->attenuated ? 0 : 1;
    for (int i = 0; i < instance->n_vertices && light->attenuated; i++) {
        const struct vector eye =
            matrix_point(&instance->model_view, instance->vertices[i].position);
        largest = fmax(largest, 1 / incidence_at(light, eye).divisor);
    }
    return largest;
}

/* Returns an upper bound on the radiance that a light adds to a vertex of an instance. */
static double most_added(const struct lit_scene *lit, int surface, const struct eye_light *light)
{
    const struct shaded_material *shaded = lit->bounds[surface].shaded;
    const struct instance *instance = lit->surfaces[surface].instance;
    double sum = 0;
    for (int t = 0; t < shaded->n_terms; t++)
        if (shaded->terms[t].light == light->first)
            sum += light->share * shaded->made.terms[t].peak;
    if (sum > 0)
        sum *= least_weakened(instance, light);
    return shaded->texture ? sum * shaded->texture->largest : sum;
}

static bool is_weak(const struct scene_survey *survey, int light)
{
    const struct lit_scene *lit = survey->lit;
    double most = 0;
    if (lit->plan->is_idle[light])
        return false;
    for (int s = 0; s < lit->plan->n_instances; s++)
        if (lit->plan->instances[s].in_view)
            most = fmax(most, most_added(lit, s, &lit->plan->lights[light]));
    return most > 0 && most <= survey_black(survey);
}

/* Where all light is weak, the picture is black, which another note says. */
bool note_weak(const struct scene_survey *survey, struct notes *notes, struct error *err)
{
    const struct plan *plan = survey->lit->plan;
    int n = 0, first = 0;
    if (plan->options.exchangeable || plan->scene->shading == SHADING_PHONG)
        return true;
    for (int i = 0; i < plan->n_lights; i++)
        if (is_weak(survey, i) && n++ == 0)
            first = i;
    if (n == 0 || survey->brightest <= survey_black(survey))
        return true;
    const struct place place = plan->sources[first]->place;
    return note_add(notes, "weak-light", err,
                    "%d of %d lights, first %.200s:%d, add less than half a count anywhere; they "
                    "are kept, since a rounding may depend on them",
                    n, plan->scene->n_lights, place.path, place.line);
}
