/* SPDX-License-Identifier: MIT */
/* Vertices go from the mesh through eye space and clip space to the window. */
#include <stdlib.h>

#include "raster/reference/reference.h"

/* Returns where the attributes of one side of a vertex begin in weights. */
size_t surface_attributes(const struct surface *surface, int vertex, int side)
{
    return ((size_t)vertex * (size_t)surface->n_sides + (size_t)side) *
           (size_t)surface->n_attributes;
}

/* Allocates *out for an instance, which must outlive it. False: no memory; close it all the same.
 */
bool surface_open(const struct instance *instance, struct surface *out)
{
    *out = (struct surface){.instance = instance,
                            .n_sides = instance->two_sided ? 2 : 1,
                            .n_attributes = instance->n_terms + (instance->textured ? 2 : 0)};
    size_t n_weights = surface_attributes(out, instance->n_vertices, 0);
    out->vertices = calloc((size_t)instance->n_vertices + 1, sizeof *out->vertices);
    out->weights = calloc(n_weights + 1, sizeof *out->weights);
    return out->vertices && out->weights;
}

void surface_close(struct surface *surface)
{
    free(surface->vertices);
    free(surface->weights);
    *surface = (struct surface){.instance = NULL};
}

/* Divides clip coordinates by w, which is above 0, and fills in x, y, z and 1 / w. */
void window_place(const struct view *view, struct window_vertex *vertex)
{
    const double *clip = vertex->clip, w = clip[3];
    vertex->x = (clip[0] / w + 1) * 0.5 * view->width;
    vertex->y = (1 - clip[1] / w) * 0.5 * view->height;
    vertex->z = (clip[2] / w + 1) * 0.5;
    vertex->inverse_w = 1 / w;
}

/* Places vertex i in the window and lights both of its sides, or its one. */
void surface_light(const struct view *view, struct surface *of, int i, struct light_work *work)
{
    const struct instance *instance = of->instance;
    const struct vertex *point = &instance->vertices[i];
    struct window_vertex *out = &of->vertices[i];
    const struct vector eye = matrix_point(&instance->model_view, point->position);
    for (int r = 0; r < 4; r++) {
        const double *row = view->projection.row[r];
        out->clip[r] = row[0] * eye.x + row[1] * eye.y + row[2] * eye.z + row[3];
    }
    if (out->clip[3] > 0)
        window_place(view, out);
    for (int side = 0; side < of->n_sides; side++)
        light_point(view, instance, point, side, of->weights + surface_attributes(of, i, side),
                    work);
    work->vertices_lit += view->shading != PHONG;
}
