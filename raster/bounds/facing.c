/* SPDX-License-Identifier: MIT */
/* Finds the faces whose backs nobody sees. A view ray enters a solid through a front before it
 * leaves it through a back, so backs are hidden, and OpenGL need not draw them. */
#include <math.h>
#include <stdlib.h>

#include "raster/bounds/bounds.h"

double edge_error(const struct driver *driver, int width, int height)
{
    return driver->grid_px + roundings(driver->edge_roundings) * fmax(width, height);
}

/* Moving a corner by e in x and y changes twice the area by at most e times the 1-norm of the edge
 * opposite, all together by 8 e^2 more. */
bool may_turn(const struct screen_triangle *triangle, const double e[3])
{
    const double *x = triangle->x, *y = triangle->y;
    double worst = most_of(e), change = 8 * worst * worst;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        change += e[i] * (fabs(x[k] - x[j]) + fabs(y[k] - y[j]));
    }
    return triangle->twice_area <= change;
}

/* Returns whether single precision cuts nothing of the surface off in depth. */
static bool is_between_planes(const struct driver *driver, const struct surface *surface,
                              const struct surface_bounds *bounds)
{
    for (int i = 0; i < surface->instance->n_vertices; i++) {
        const struct window_vertex *vertex = &surface->vertices[i];
        const double slack =
            (double)bounds->vertices[i].slack_depth + roundings(driver->depth_roundings);
        if (!(vertex->clip[3] > 0 && vertex->z > slack && vertex->z < 1 - slack))
            return false;
    }
    return true;
}

/* Returns whether OpenGL, too, sees the back of a triangle. */
static bool shows_back(const struct lit_scene *lit, int surface, int triangle)
{
    const struct surface *of = &lit->surfaces[surface];
    struct screen_triangle screen[SCREEN_TRIANGLES];
    double e[3];
    if (screen_triangles(&lit->plan->view, of, triangle, NULL, 0, screen) == 0)
        return false;
    for (int i = 0; i < 3; i++)
        e[i] = (double)lit->bounds[surface].vertices[screen->vertex[i]].slack_px +
               edge_error(lit->driver, lit->plan->tile_width, lit->plan->tile_height);
    return screen->clockwise != of->instance->mirrored && !may_turn(screen, e);
}

/* Where a front and a back meet, both have the same depth, and OpenGL shows the one that is drawn
 * first. So a back is drawn, too, where it touches a triangle that is no back. */
static bool hide_backs(const struct instance *instance, const int32_t *points,
                       struct surface_bounds *bounds)
{
    bool *touched = calloc((size_t)instance->n_vertices + 1, sizeof *touched); /* of each point */
    const bool done = touched != NULL;
    for (int i = 0; i < instance->n_triangles && done; i++)
        for (int j = 0; j < 3 && !bounds->hidden[i]; j++)
            touched[points[instance->triangles[i][j]]] = true;
    for (int i = 0; i < instance->n_triangles && done; i++) {
        const int32_t *vertex = instance->triangles[i];
        for (int j = 0; j < 3; j++)
            bounds->hidden[i] = bounds->hidden[i] && !touched[points[vertex[j]]];
        bounds->n_hidden += bounds->hidden[i];
    }
    free(touched);
    return done;
}

bool find_hidden(const struct lit_scene *lit, int surface, struct error *err)
{
    const struct placed_instance *placed = &lit->plan->instances[surface];
    const int32_t *points = lit->plan->meshes[placed->mesh].points;
    struct surface_bounds *bounds = &lit->bounds[surface];
    const int n = placed->instance.n_triangles;
    if (!points || placed->object->two_sided ||
        !is_between_planes(lit->driver, &lit->surfaces[surface], bounds))
        return true;
    bounds->hidden = calloc((size_t)n, sizeof *bounds->hidden);
    for (int i = 0; i < n && bounds->hidden; i++)
        bounds->hidden[i] = shows_back(lit, surface, i);
    return (bounds->hidden && hide_backs(&placed->instance, points, bounds)) || error_memory(err);
}
