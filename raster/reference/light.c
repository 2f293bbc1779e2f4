/* SPDX-License-Identifier: MIT */
/* Lighting (OpenGL 2.1 specification, section 2.14.1): how much of each term a point reflects. The
 * point is a vertex, or in Phong shading a point between vertices. */
#include <math.h>

#include "data/maths/maths.h"
#include "raster/reference/reference.h"

static struct vector towards_light(const struct eye_light *light, struct vector eye,
                                   double *distance)
{
    struct vector path = vector_subtract(light->position, eye);
    *distance = 0;
    if (light->directional)
        return light->position;
    *distance = vector_length(path);
    return vector_normalise(path);
}

static struct vector towards_viewer(const struct view *view, struct vector eye)
{
    const struct vector far_away = {0, 0, 1};
    return view->local_viewer ? vector_normalise(vector_scale(eye, -1)) : far_away;
}

struct incidence incidence_at(const struct eye_light *light, struct vector eye)
{
    struct incidence out;
    const double *k = light->attenuation;
    out.towards = towards_light(light, eye, &out.distance);
    out.divisor = k[0] + k[1] * out.distance + k[2] * out.distance * out.distance;
    return out;
}

struct vector half_vector(const struct view *view, struct vector towards, struct vector eye)
{
    return vector_add(towards, towards_viewer(view, eye));
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

bool reflects(const struct instance *instance, const struct eye_light *light)
{
    for (int t = 0; t < instance->n_terms; t++)
        if (instance->terms[t].light == light->first)
            return true;
    return false;
}

/* A point that is about to be lit, in eye space. */
struct lit_point {
    struct vector eye, normal;
};

static double specular_weight(const struct view *view, const struct instance *instance,
                              const struct lit_point *point, struct vector towards,
                              struct light_work *work)
{
    struct vector half = vector_normalise(half_vector(view, towards, point->eye));
    double cosine = vector_dot(point->normal, half);
    work->specular_vertices++;
    return gated_power(vector_dot(point->normal, towards), cosine, instance->gloss, work);
}

/* Adds a light to the weights of the terms of its spectrum. */
static void add_light(const struct view *view, const struct instance *instance,
                      const struct eye_light *light, const struct lit_point *point, double *weights,
                      struct light_work *work)
{
    struct incidence incidence = incidence_at(light, point->eye);
    double left = falloff(light, &incidence, work);
    for (int t = 0; t < instance->n_terms; t++) {
        if (instance->terms[t].light != light->first)
            continue;
        double weight = instance->terms[t].reflection == DIFFUSE
                            ? fmax(0, vector_dot(point->normal, incidence.towards))
                            : specular_weight(view, instance, point, incidence.towards, work);
        weights[t] += light->share * (weight * left);
    }
}

void light_point(const struct view *view, const struct instance *instance,
                 const struct vertex *point, int side, double *attributes, struct light_work *work)
{
    struct lit_point lit = {
        matrix_point(&instance->model_view, point->position),
        vector_normalise(matrix_direction(&instance->normal_matrix, point->normal))};
    if (side == 1)
        lit.normal = vector_scale(lit.normal, -1);
    for (int t = 0; t < instance->n_terms; t++)
        attributes[t] = instance->terms[t].reflection == CONSTANT;
    for (int i = 0; i < view->n_lights; i++)
        if (reflects(instance, &view->lights[i]))
            add_light(view, instance, &view->lights[i], &lit, attributes, work);
    if (instance->textured) {
        attributes[instance->n_terms] = point->s;
        attributes[instance->n_terms + 1] = point->t;
    }
}
