/* SPDX-License-Identifier: MIT */
/* Shades a pixel: attributes interpolated between the vertices, perspective-correct, as
 * Gouraud interpolates colours; or positions and normals, and the point lit (Bui Tuong Phong 1975).
 */
#include <math.h>

#include "raster/reference/reference.h"

static void shade_phong(const struct view *view, const struct screen_triangle *triangle,
                        const double share[3], double *attributes, struct light_work *work)
{
    const struct instance *instance = triangle->surface->instance;
    struct vertex point = {.s = 0};
    for (int j = 0; j < 3; j++) {
        const struct vertex *vertex = &instance->vertices[triangle->vertex[j]];
        point.position = vector_add(point.position, vector_scale(vertex->position, share[j]));
        point.normal = vector_add(point.normal, vector_scale(vertex->normal, share[j]));
        point.s += share[j] * vertex->s;
        point.t += share[j] * vertex->t;
    }
    light_point(view, instance, &point, triangle->side, attributes, work);
    work->points_lit++;
}

/* Finds the attributes at barycentric coordinates `share` of the whole triangle.
 * In flat shading one vertex colours the whole triangle; its texture is smooth all the same. */
void shade(const struct view *view, const struct screen_triangle *triangle, const double share[3],
           double *attributes, struct light_work *work)
{
    const struct surface *of = triangle->surface;
    const int32_t *v = triangle->vertex, vertex[4] = {v[0], v[1], v[2], triangle->provoking};
    const double *corner[4];
    if (view->shading == PHONG) {
        shade_phong(view, triangle, share, attributes, work);
        return;
    }
    for (int j = 0; j < 4; j++)
        corner[j] = of->weights + surface_attributes(of, vertex[j], triangle->side);
    for (int a = 0; a < of->n_attributes; a++)
        attributes[a] =
            view->shading == FLAT && a < of->instance->n_terms
                ? corner[3][a]
                : share[0] * corner[0][a] + share[1] * corner[1][a] + share[2] * corner[2][a];
}

/* Returns how many numbers a pixel of the instance keeps. */
int pixel_rows(const struct instance *instance)
{
    return instance->n_terms + (instance->varied ? place_rows(&instance->texels) : 0);
}

/* Writes these numbers: weights times the texture at a place, or weights and the place. */
void put_rows(const struct instance *instance, const double *attributes,
              const double place[TEXEL_PLACE], double *rows, size_t stride)
{
    bool constant = instance->textured && !instance->varied;
    double value = constant ? texel_at(&instance->texels, place) : 1;
    size_t n_terms = (size_t)instance->n_terms, n_rows = (size_t)pixel_rows(instance);
    for (size_t t = 0; t < n_terms; t++)
        rows[t * stride] = attributes[t] * value;
    for (size_t i = n_terms; i < n_rows; i++)
        rows[i * stride] = place[i - n_terms];
}

/* Adds weight x spectrum of a term, whose weights are in a row, to the radiance of n pixels. */
VECTORIZED void add_term(const double *row, double spectrum, size_t n, double *restrict radiance)
{
    for (size_t i = 0; i < n; i++)
        radiance[i] += row[i] * spectrum;
}
