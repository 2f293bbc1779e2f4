/* SPDX-License-Identifier: MIT */
/* Lighting (OpenGL 2.1 specification, section 2.14.1): how much of each term a point reflects. The
 * point is a vertex, or in Phong shading a point between vertices. */
#include <math.h>

#include "raster/reference/reference.h"

/* A light as it is seen from a point in eye space. */
struct incidence incidence_at(const struct eye_light *light, struct vector eye)
{
    const struct vector path = vector_subtract(light->position, eye);
    const double *k = light->attenuation, d = light->directional ? 0 : vector_length(path);
    return (struct incidence){.towards =
                                  light->directional ? light->position : vector_normalise(path),
                              .distance = d,
                              .divisor = k[0] + k[1] * d + k[2] * d * d};
}

/* The direction half-way between light and viewer; not of unit length. */
struct vector half_vector(const struct view *view, struct vector towards, struct vector eye)
{
    const struct vector far_away = {0, 0, 1};
    return vector_add(towards,
                      view->local_viewer ? vector_normalise(vector_scale(eye, -1)) : far_away);
}

/* max(0, base)^exponent; 0 where the gate is not above 0. */
static double gated_power(double gate, double base, double exponent, struct light_work *work)
{
    if (!(gate > 0))
        return 0;
    work->power_functions += exponent != 0;
    return power(fmax(0, base), exponent);
}

/* The part of a light that distance and spot leave. */
static double falloff(const struct eye_light *light, const struct incidence *incidence,
                      struct light_work *work)
{
    double left = light->attenuated ? 1 / incidence->divisor : 1;
    if (!light->spot)
        return left;
    double cosine = vector_dot(incidence->towards, vector_scale(light->axis, -1));
    return left * gated_power(cosine - light->cutoff_cosine, cosine, light->spot_exponent, work);
}

/* The weight of one light at a point in eye space. gloss 0: diffuse reflection. */
static double light_weight(const struct view *view, const struct eye_light *light,
                           const struct vector at[2], double gloss, struct light_work *work)
{
    const struct vector eye = at[0], normal = at[1];
    const struct incidence incidence = incidence_at(light, eye);
    double cosine = vector_dot(normal, incidence.towards), weight = fmax(0, cosine);
    if (gloss > 0) {
        struct vector half = vector_normalise(half_vector(view, incidence.towards, eye));
        work->specular_vertices++;
        weight = gated_power(cosine, vector_dot(normal, half), gloss, work);
    }
    return light->share * (weight * falloff(light, &incidence, work));
}

/* Finds the attributes of one side of a point in the mesh, whose normal may have any length. */
void light_point(const struct view *view, const struct instance *of, const struct vertex *point,
                 int side, double *attributes, struct light_work *work)
{
    struct vector normal = matrix_direction(&of->normal_matrix, point->normal);
    const struct vector at[2] = {matrix_point(&of->model_view, point->position),
                                 vector_scale(vector_normalise(normal), side == 1 ? -1 : 1)};
    for (int t = 0; t < of->n_terms; t++) {
        const struct term *term = &of->terms[t];
        attributes[t] = term->reflection == CONSTANT;
        for (int i = 0; i < view->n_lights; i++)
            if (view->lights[i].first == term->light)
                attributes[t] += light_weight(view, &view->lights[i], at,
                                              term->reflection == SPECULAR ? of->gloss : 0, work);
    }
    if (of->textured) {
        attributes[of->n_terms] = point->s;
        attributes[of->n_terms + 1] = point->t;
    }
}
