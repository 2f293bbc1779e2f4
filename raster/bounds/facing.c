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
        const double slack = (double)bounds->vertices[i].slack_depth +
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
        e[i] = (double)lit->bounds[surface].vertices[screen->vertex[i]].slack_px +
               edge_error(lit->driver, lit->plan->tile_width, lit->plan->tile_height);
    return screen->clockwise != of->instance->mirrored && !may_turn(screen, e);
}

/* ---- depths of fronts ---- */

enum { CELLS = 32 };
/* The part of the window that a surface takes, cut into cells. Each has the largest depth of the
 * triangles that reach it and are not hidden. */
struct cells {
    double origin[2], size[2]; /* of the cell at 0, 0; in pixels */
    double deepest[CELLS][CELLS];
};
/* The cells that a triangle reaches, and its smallest and largest depth. */
struct reached {
    int from[2], to[2]; /* both included */
    double depth[2];
};

static void make_cells(const struct surface_bounds *bounds, const struct view *view,
                       struct cells *out)
{
    const double low[2] = {fmax(bounds->left, 0), fmax(bounds->top, 0)};
    const double high[2] = {fmin(bounds->right, view->width), fmin(bounds->bottom, view->height)};
    for (int axis = 0; axis < 2; axis++) {
        out->origin[axis] = low[axis];
        out->size[axis] = fmax((high[axis] - low[axis]) / CELLS, 1);
    }
    for (int i = 0; i < CELLS * CELLS; i++)
        out->deepest[i / CELLS][i % CELLS] = 0;
}

/* Cells at the border hold all that lies beyond. */
static int cell_at(const struct cells *cells, int axis, double place)
{
    const double cell = (place - cells->origin[axis]) / cells->size[axis];
    return cell < 0 ? 0 : cell < CELLS - 1 ? (int)cell : CELLS - 1;
}

/* A triangle reaches a pixel more to each side than its corners do: OpenGL moves them. */
static struct reached cells_of(const struct cells *cells, const struct surface *of, int triangle)
{
    const int32_t *vertex = of->instance->triangles[triangle];
    double low[3], high[3]; /* of x, y and depth */
    for (int i = 0; i < 3; i++) {
        const struct window_vertex *at = &of->vertices[vertex[i]];
        const double place[3] = {at->x, at->y, at->z};
        for (int axis = 0; axis < 3; axis++) {
            low[axis] = i == 0 || place[axis] < low[axis] ? place[axis] : low[axis];
            high[axis] = i == 0 || place[axis] > high[axis] ? place[axis] : high[axis];
        }
    }
    struct reached out = {.depth = {low[2], high[2]}};
    for (int axis = 0; axis < 2; axis++) {
        out.from[axis] = cell_at(cells, axis, low[axis] - 1);
        out.to[axis] = cell_at(cells, axis, high[axis] + 1);
    }
    return out;
}

/* Returns the largest depth of a triangle in the cells that is not hidden. */
static double deepest_in(const struct cells *cells, const struct reached *at)
{
    double deepest = 0;
    for (int y = at->from[1]; y <= at->to[1]; y++)
        for (int x = at->from[0]; x <= at->to[0]; x++)
            deepest = fmax(deepest, cells->deepest[y][x]);
    return deepest;
}

static void add_front(struct cells *cells, const struct reached *at)
{
    for (int y = at->from[1]; y <= at->to[1]; y++)
        for (int x = at->from[0]; x <= at->to[0]; x++)
            cells->deepest[y][x] = fmax(cells->deepest[y][x], at->depth[1]);
}

/* Where a front and a back have the same depth, OpenGL shows the one that is drawn first. So a back
 * is drawn, too, unless all its stored depths are larger than those of all fronts near it. */
static void hide_backs(const struct lit_scene *lit, int surface, double depth_error)
{
    const struct surface *of = &lit->surfaces[surface];
    struct surface_bounds *bounds = &lit->bounds[surface];
    struct cells cells;
    make_cells(bounds, &lit->plan->view, &cells);
    for (int i = 0; i < of->instance->n_triangles; i++)
        if (!bounds->hidden[i]) {
            const struct reached at = cells_of(&cells, of, i);
            add_front(&cells, &at);
        }
    for (int i = 0; i < of->instance->n_triangles; i++) {
        const struct reached at = cells_of(&cells, of, i);
        bounds->hidden[i] =
            bounds->hidden[i] && at.depth[0] > deepest_in(&cells, &at) + 2 * depth_error;
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
    hide_backs(lit, surface, error);
    return true;
}
