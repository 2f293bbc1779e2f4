/* SPDX-License-Identifier: MIT */
/* Finds light that is rounding noise: a light that grazes a surface exactly leaves a cosine that
 * should be 0, and is some 1e-17. Its sign decides whether the surface has a highlight. */

#include "data/maths/maths.h"
#include "raster/counts/inside.h"

/* Normal and direction are each transformed and normalised in double precision, with less than 16
 * roundings of their components, and multiplied. */
static const double noise_cosine = 64 * DOUBLE_ROUNDOFF;

/* Returns the cosine between the normal of a vertex, on a side, and the direction of a light. */
static double light_cosine(const struct surface *surface, int vertex, int side,
                           const struct eye_light *light)
{
    const struct instance *instance = surface->instance;
    const struct vertex *point = &instance->vertices[vertex];
    const struct vector eye = matrix_point(&instance->model_view, point->position),
                        normal = vector_normalise(
                            matrix_direction(&instance->normal_matrix, point->normal));
    return (side == 1 ? -1 : 1) * vector_dot(normal, incidence_at(light, eye).towards);
}

int noisy_light(const struct lit_scene *lit, int surface, size_t at)
{
    const struct plan *plan = lit->plan;
    const struct surface *of = &lit->surfaces[surface];
    const struct instance *instance = of->instance;
    const int vertex = (int)(at / (size_t)of->n_sides), side = (int)(at % (size_t)of->n_sides);
    int noisy = -1;
    for (int t = 0; t < instance->n_terms; t++)
        if (instance->terms[t].reflection == CONSTANT)
            return -1;
    for (int i = 0; i < plan->n_lights; i++) {
        double cosine = reflects(instance, &plan->lights[i])
                            ? light_cosine(of, vertex, side, &plan->lights[i])
                            : 0;
        if (cosine > noise_cosine)
            return -1;
        if (cosine > 0)
            noisy = i;
    }
    return noisy;
}
