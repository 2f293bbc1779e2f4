/* SPDX-License-Identifier: MIT */
/* Finds the triangles that the picture shows at a lattice of its pixels. A triangle is scanned in
 * coordinates in which the lattice is made of whole pixels: one that lies between its pixels costs
 * next to nothing. */
#include <math.h>
#include <stdlib.h>

#include "data/maths/maths.h"
#include "raster/beside/accuracy/inside.h"

/* Returns the lattice. The step is odd and the shear even, so that the places are pixel centres;
 * the shear is near the step over the golden ratio, so that rows of pixels do not repeat soon. */
static struct lattice lattice_of(const struct view *view, int wanted)
{
    const double pixels = (double)view->width * view->height;
    const int step = 2 * (int)(sqrt(pixels / wanted) / 2) + 1;
    return (struct lattice){.width = view->width,
                            .height = view->height,
                            .step = step,
                            .shear = step > 1 ? 2 * (int)(0.309 * step + 0.5) : 0,
                            .rows = (view->height + step - 1) / step,
                            .columns = (view->width + step - 1) / step + 2};
}

/* The column of the lattice that holds the first place of a row inside the picture, or the one
 * before. */
static int first_column(const struct lattice *lattice, int row)
{
    return (int)floor(-(double)lattice->shear * (row + 0.5) / lattice->step - 0.5);
}

static void place_of(const struct lattice *lattice, int column, int row, double at[2])
{
    at[0] = lattice->step * (column + 0.5) + lattice->shear * (row + 0.5);
    at[1] = lattice->step * (row + 0.5);
}

bool lattice_place(const struct lattice *lattice, int index, double at[2])
{
    const int row = index / lattice->columns;
    place_of(lattice, index % lattice->columns + first_column(lattice, row), row, at);
    return at[0] > 0 && at[0] < lattice->width && at[1] < lattice->height;
}

/* Returns whether a triangle in front of the eye lies between two rows of the lattice. */
static bool lies_between(const struct lattice *lattice, const struct surface *surface,
                         const int32_t vertex[3])
{
    double row[3];
    for (int i = 0; i < 3; i++) {
        const struct window_vertex *corner = &surface->vertices[vertex[i]];
        if (!(corner->clip[3] > 0))
            return false;
        row[i] = corner->y / lattice->step - 0.5;
    }
    return ceil(least_of(row)) > floor(most_of(row));
}

/* A triangle that is scanned. */
struct lattice_scan {
    const struct seen_pixels *seen;
    int surface;
    const struct screen_triangle *triangle;
};

/* Draws a pixel that the triangle covers. x, y: column and row of the lattice. Keeps the first of
 * fragments that are equally deep. */
static bool draw_pixel(void *context, int x, int y)
{
    const struct lattice_scan *scan = context;
    const struct lattice *lattice = &scan->seen->lattice;
    const int column = x - first_column(lattice, y);
    double at[2];
    if (column < 0 || column >= lattice->columns)
        return true;
    place_of(lattice, x, y, at);
    const double depth = covered_depth(scan->triangle, at[0], at[1]);
    struct lattice_pixel *pixel = &scan->seen->pixels[y * lattice->columns + column];
    if (depth >= 0 && depth < pixel->depth)
        *pixel = (struct lattice_pixel){depth, scan->surface, *scan->triangle};
    return true;
}

static void draw_triangle(const struct seen_pixels *seen, int surface,
                          const struct screen_triangle *triangle)
{
    struct lattice_scan scan = {seen, surface, triangle};
    const struct lattice *lattice = &seen->lattice;
    const int leftmost = first_column(lattice, lattice->rows);
    const struct rectangle at = {leftmost, 0, lattice->columns - leftmost, lattice->rows};
    struct screen_triangle sheared = *triangle;
    for (int i = 0; i < 3; i++) {
        sheared.y[i] = triangle->y[i] / lattice->step;
        sheared.x[i] = (triangle->x[i] - lattice->shear * sheared.y[i]) / lattice->step;
    }
    scan_triangle(&sheared, &at, 0, draw_pixel, &scan);
}

static void draw_surface(const struct plan *plan, const struct surface *surfaces, int surface,
                         const struct seen_pixels *seen)
{
    /* near, then far */
    static const struct clip_plane depth_planes[2] = {{{0, 0, 1, 1}, 0}, {{0, 0, -1, 1}, 0}};
    struct screen_triangle parts[SCREEN_TRIANGLES];
    const struct instance *instance = surfaces[surface].instance;
    for (int i = 0; i < instance->n_triangles; i++) {
        if (lies_between(&seen->lattice, &surfaces[surface], instance->triangles[i]))
            continue;
        const int n = screen_triangles(&plan->view, &surfaces[surface], i, depth_planes, 2, parts);
        for (int part = 0; part < n; part++)
            draw_triangle(seen, surface, &parts[part]);
    }
}

bool seen_find(const struct plan *plan, const struct surface *surfaces, int wanted,
               struct seen_pixels *out, struct error *err)
{
    *out = (struct seen_pixels){.lattice = lattice_of(&plan->view, wanted)};
    out->n = out->lattice.rows * out->lattice.columns;
    if (!MAKE_ARRAY(out->pixels, (size_t)out->n + 1, err, "the pixels that are judged"))
        return false;
    for (int i = 0; i < out->n; i++)
        out->pixels[i] = (struct lattice_pixel){.depth = 1, .surface = -1};
    for (int s = 0; s < plan->n_instances; s++)
        if (plan->instances[s].in_view && !plan->instances[s].twin)
            draw_surface(plan, surfaces, s, out);
    return true;
}
