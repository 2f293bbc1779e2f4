/* SPDX-License-Identifier: MIT */
/* Finds the radiance that the largest count stands for: the largest of all vertices in all bands.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "raster/counts/counts.h"

/* ---- upper bounds for Phong shading ---- */

/* The point of a triangle that is nearest to p is the foot of the perpendicular from p, or it lies
 * on an edge. */
static double distance_to_edge(struct vector p, struct vector a, struct vector b)
{
    struct vector edge = vector_subtract(b, a), to = vector_subtract(p, a);
    double squared = vector_dot(edge, edge);
    double part = squared > 0 ? fmin(fmax(vector_dot(to, edge) / squared, 0), 1) : 0;
    return vector_length(vector_subtract(to, vector_scale(edge, part)));
}

static double distance_to_triangle(struct vector p, const struct vector corner[3])
{
    struct vector normal = vector_normalise(
        vector_cross(vector_subtract(corner[1], corner[0]), vector_subtract(corner[2], corner[0])));
    double least = HUGE_VAL;
    bool above = vector_length(normal) > 0;
    for (int i = 0; i < 3; i++) {
        struct vector a = corner[i], b = corner[(i + 1) % 3];
        struct vector inwards = vector_cross(normal, vector_subtract(b, a));
        above = above && vector_dot(inwards, vector_subtract(p, a)) > 0;
        least = fmin(least, distance_to_edge(p, a, b));
    }
    return above ? fabs(vector_dot(normal, vector_subtract(p, corner[0]))) : least;
}

/* Returns the distance of a light from a surface, reduced by the roundings of the surface's points.
 */
static double least_distance(const struct surface *surface, const struct eye_light *light)
{
    const struct instance *instance = surface->instance;
    double least = HUGE_VAL, largest = vector_length(light->position);
    for (int i = 0; i < instance->n_triangles; i++) {
        struct vector corner[3];
        for (int j = 0; j < 3; j++) {
            corner[j] = matrix_point(&instance->model_view,
                                     instance->vertices[instance->triangles[i][j]].position);
            largest = fmax(largest, vector_length(corner[j]));
        }
        least = fmin(least, distance_to_triangle(light->position, corner));
    }
    return fmax(0, least - 1e-12 * largest);
}

/* Computes an upper bound on the weight of each term at any point that phong shading lights. The
 * bound is infinite if a light that weakens with distance may be too near. Returns the index of
 * such a light; -1: there is none. */
static int phong_limits(const struct view *view, const struct surface *surface, double *limits)
{
    const struct instance *instance = surface->instance;
    int light = -1;
    for (int t = 0; t < instance->n_terms; t++)
        limits[t] = instance->terms[t].reflection == CONSTANT;
    for (int i = 0; i < view->n_lights; i++) {
        const struct eye_light *from = &view->lights[i];
        const double *k = from->attenuation;
        double d, most = from->share;
        if (!reflects(instance, from))
            continue;
        if (from->attenuated) {
            d = least_distance(surface, from);
            most /= k[0] + k[1] * d + k[2] * d * d;
        }
        if (!isfinite(most))
            light = i;
        for (int t = 0; t < instance->n_terms; t++)
            limits[t] += instance->terms[t].light == from->first ? most : 0;
    }
    return light;
}

/* ---- the largest radiance ---- */

/* The weights that may make a surface brightest: of both sides of its vertices; with phong shading
 * one set of upper bounds on the weights of all its points. */
struct brightest {
    const double *weights;
    size_t n, stride;
};

/* Returns the largest radiance in one band; *at becomes the index of its weights. */
static double largest_radiance(const struct plan *plan, const struct shaded_material *shaded,
                               const struct brightest *of, int band, size_t *at)
{
    double largest = -1;
    for (size_t i = 0; i < of->n; i++) {
        const double radiance = shaded_radiance(plan, shaded, of->weights + i * of->stride, band);
        if (!(radiance <= largest)) { /* NaN counts as larger, so that it is reported */
            largest = radiance;
            *at = i;
        }
        if (!isfinite(largest))
            break;
    }
    return shaded->texture ? largest * shaded->texture->largest : largest;
}

static bool check_radiance(const struct lit_scene *lit, int surface, int band, size_t at,
                           double radiance, struct error *err)
{
    char page[BAND_NAME], vertex[32] = "this object";
    const struct plan *plan = lit->plan;
    struct place place = lit->bounds[surface].placed->object->place;
    if (isfinite(radiance) && !(plan->options.bits == 32 && radiance > (double)FLT_MAX))
        return true;
    if (plan->scene->shading != SHADING_PHONG)
        snprintf(vertex, sizeof vertex, "vertex %d", (int)at / lit->surfaces[surface].n_sides + 1);
    band_name(plan, band, page);
    return isfinite(radiance)
               ? error_at(err, place,
                          "the radiance of %s at %s is %.3g, too large for a float page", vertex,
                          page, radiance)
               : error_at(
                     err, place,
                     "the radiance of %s at %s is not finite; lights and factors are too large",
                     vertex, page);
}

/* The largest radiance so far, and whose it is. */
struct largest {
    double radiance;
    int surface;
    size_t at; /* index of its weights */
};

/* Raises *largest to the largest radiance of a surface. Refuses a radiance without a bound, unless
 * the plan asks for a full scale. */
static bool raise_largest(const struct lit_scene *lit, int surface, double *limits,
                          struct largest *largest, struct error *err)
{
    const struct plan *plan = lit->plan;
    const struct shaded_material *shaded = lit->bounds[surface].shaded;
    const struct surface *of = &lit->surfaces[surface];
    struct brightest brightest = {of->weights,
                                  (size_t)of->instance->n_vertices * (size_t)of->n_sides,
                                  (size_t)of->n_attributes};
    int light = -1;
    if (plan->scene->shading == SHADING_PHONG) {
        light = phong_limits(&plan->view, of, limits);
        brightest = (struct brightest){limits, 1, 0};
    }
    if (light >= 0)
        return plan->options.full_scale > 0 ||
               error_at(
                   err, plan->sources[light]->attenuation_place,
                   "this light touches %s and is infinitely bright there, so phong shading has no "
                   "largest radiance; set --full-scale, or give the light a constant attenuation",
                   shaded->material->name);
    for (int band = 0; band < plan->n_bands; band++) {
        size_t at = 0;
        double radiance = largest_radiance(plan, shaded, &brightest, band, &at);
        if (!check_radiance(lit, surface, band, at, radiance, err))
            return false;
        if (radiance > largest->radiance)
            *largest = (struct largest){radiance, surface, at};
    }
    return true;
}

/* ---- noise ---- */

/* A light that grazes a surface exactly leaves a cosine that should be 0, and is some 1e-17. Its
 * sign decides whether the surface has a highlight. */

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

/* Returns the index of a light, if the radiance of weights `at` of a surface (a vertex and a side)
 * comes only from lights that graze it, so that it is rounding noise; otherwise -1. */
static int noisy_light(const struct lit_scene *lit, int surface, size_t at)
{
    const struct plan *plan = lit->plan;
    const struct surface *of = &lit->surfaces[surface];
    const struct instance *instance = of->instance;
    const int vertex = (int)(at / (size_t)of->n_sides), side = (int)(at % (size_t)of->n_sides);
    int noisy = -1;
    if (has_term(lit->bounds[surface].shaded, TERM_CONSTANT))
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

/* Refuses noise as the largest radiance: a picture of it would mean nothing. */
static bool check_noise(const struct lit_scene *lit, const struct largest *largest,
                        struct error *err)
{
    const struct plan *plan = lit->plan;
    if (!(largest->radiance > 0) || plan->options.full_scale > 0 ||
        plan->scene->shading == SHADING_PHONG)
        return true;
    int light = noisy_light(lit, largest->surface, largest->at);
    if (light < 0)
        return true;
    const struct place place = plan->sources[light]->place;
    return error_at(
        err, lit->bounds[largest->surface].placed->object->place,
        "rounding alone decides whether the brightest point of the picture reflects %.3g or "
        "nothing: the light at %s:%d grazes this object exactly; turn one of them, or set "
        "--full-scale",
        largest->radiance, place.path, place.line);
}

/* ---- the full scale ---- */

/* OpenGL gets colours that are spectra over full scale. Below 2^100 single precision can hold them
 * and their sums. Beside such light everything else is black. */
static double least_full_scale(const struct plan *plan)
{
    double largest = 0, share = 1;
    for (int i = 0; i < plan->n_lights; i++)
        share = fmax(share, plan->lights[i].share);
    for (int f = 0; f < plan->n_materials; f++)
        for (int t = 0; t < plan->materials[f].n_terms; t++)
            largest = fmax(largest, plan->materials[f].made.terms[t].peak);
    return ldexp(largest * share, -100);
}

bool find_full_scale(struct lit_scene *lit, struct error *err)
{
    const struct plan *plan = lit->plan;
    double *limits;
    struct largest found = {0, -1, 0};
    bool done = MAKE_ARRAY(limits, plan->max_rows, err, "the terms of a material");
    for (int s = 0; s < plan->n_instances && done; s++)
        done = raise_largest(lit, s, limits, &found, err);
    free(limits);
    if (!done || !check_noise(lit, &found, err))
        return false;
    const double largest = found.radiance;
    if (plan->options.bits == 32 && largest > 0 && largest < (double)FLT_MIN / SINGLE_ROUNDOFF)
        return error_at(
            err, plan->instances[0].object->place,
            "the largest radiance is %.3g, so small that a float page would lose digits; "
            "lights and factors are too small",
            largest);
    double least = least_full_scale(plan), wanted = plan->options.full_scale;
    if (wanted > 0 && wanted < least)
        return error_usage(err,
                           "--full-scale: %g is too small for these lights; single precision "
                           "needs at least %.3g",
                           wanted, least);
    lit->clips = wanted > 0 && wanted < largest;
    lit->full_scale = wanted > 0 ? wanted : fmax(largest > 0 ? largest : 1, least);
    return true;
}
