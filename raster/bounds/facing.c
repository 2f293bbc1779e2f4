/* SPDX-License-Identifier: MIT */
/* Finds the faces whose backs nobody sees. A view ray enters a solid through a front before it
 * leaves it through a back, so backs are hidden, and OpenGL need not draw them. */
#include <math.h>

#include "raster/bounds/inside.h"

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

/* Finds the largest error of a depth. Returns whether single precision cuts nothing of the surface
 * off in depth. */
static bool is_between_planes(const struct driver *driver, const struct surface *surface,
                              const struct surface_bounds *bounds, double *error)
{
    *error = 0;
    for (int i = 0; i < surface->instance->n_vertices; i++) {
        const struct window_vertex *vertex = &surface->vertices[i];
        const double slack = bounds->vertices[i].slack.depth +
                             roundings(driver->depth_roundings); /* as it is stored */
        if (!(vertex->clip[3] > 0 && vertex->z > slack && vertex->z < 1 - slack))
            return false;
        *error = fmax(*error, slack);
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
        e[i] = lit->bounds[surface].vertices[screen->vertex[i]].slack.px +
               edge_error(lit->driver, lit->plan->tile_width, lit->plan->tile_height);
    return screen->clockwise != of->instance->mirrored && !may_turn(screen, e);
}

static void depths_of(const struct surface *of, int triangle, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = of->vertices[of->instance->triangles[triangle][i]].z;
}

/* Where a front and a back have the same depth, OpenGL shows the one that is drawn first. So a back
 * is drawn, too, unless all its stored depths are larger than those of all fronts. */
static void hide_backs(const struct surface *of, struct surface_bounds *bounds, double depth_error)
{
    double depths[3], deepest = 0;
    for (int i = 0; i < of->instance->n_triangles; i++) {
        depths_of(of, i, depths);
        deepest = bounds->hidden[i] ? deepest : fmax(deepest, most_of(depths));
    }
    for (int i = 0; i < of->instance->n_triangles; i++) {
        depths_of(of, i, depths);
        bounds->hidden[i] = bounds->hidden[i] && least_of(depths) > deepest + 2 * depth_error;
        bounds->n_hidden += bounds->hidden[i];
    }
}

bool find_hidden(const struct lit_scene *lit, int surface, struct error *err)
{
    const struct placed_instance *placed = &lit->plan->instances[surface];
    struct surface_bounds *bounds = &lit->bounds[surface];
    const int n = placed->instance.n_triangles;
    double error;
    if (lit->plan->options.complete || !lit->plan->meshes[placed->mesh].solid ||
        placed->object->two_sided ||
        !is_between_planes(lit->driver, &lit->surfaces[surface], bounds, &error))
        return true;
    if (!MAKE_ARRAY(bounds->hidden, n, err, "the backs of %s", object_name(lit->plan, surface)))
        return false;
    for (int i = 0; i < n; i++)
        bounds->hidden[i] = shows_back(lit, surface, i);
    hide_backs(&lit->surfaces[surface], bounds, error);
    return true;
}
