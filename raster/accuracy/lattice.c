/* SPDX-License-Identifier: MIT */
/* Finds the triangles that the picture shows at a lattice of its pixels. A triangle is scanned in
 * coordinates in which the lattice is made of whole pixels: one that lies between its pixels costs
 * next to nothing. */
#include <math.h>
#include <stdlib.h>

#include "data/base/base.h"
#include "raster/accuracy/accuracy.h"

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

/* A triangle that is scanned. */
struct lattice_scan {
    const struct lattice *lattice;
    const struct screen_triangle *triangle;
    lattice_visit *visit;
    void *context;
};

/* Passes on a pixel that the triangle covers. x, y: column and row of the lattice. */
static bool pass_pixel(void *context, int x, int y)
{
    const struct lattice_scan *scan = context;
    const struct lattice *lattice = scan->lattice;
    const int column = x - first_column(lattice, y);
    struct lattice_fragment fragment = {.triangle = scan->triangle};
    if (column < 0 || column >= lattice->columns)
        return true;
    place_of(lattice, x, y, fragment.at);
    fragment.index = y * lattice->columns + column;
    fragment.depth = covered_depth(scan->triangle, fragment.at[0], fragment.at[1]);
    if (fragment.depth >= 0)
        scan->visit(scan->context, &fragment);
    return true;
}

void lattice_scan(const struct lattice *lattice, const struct screen_triangle *triangle,
                  lattice_visit *visit, void *context)
{
    struct lattice_scan scan = {lattice, triangle, visit, context};
    const int leftmost = first_column(lattice, lattice->rows);
    const struct rectangle at = {leftmost, 0, lattice->columns - leftmost, lattice->rows};
    struct screen_triangle sheared = *triangle;
    for (int i = 0; i < 3; i++) {
        sheared.y[i] = triangle->y[i] / lattice->step;
        sheared.x[i] = (triangle->x[i] - lattice->shear * sheared.y[i]) / lattice->step;
    }
    scan_triangle(&sheared, &at, 0, pass_pixel, &scan);
}

int lattice_beside(const struct lattice *lattice, double x, double y)
{
    const int row = (int)fmax(0, fmin(floor(y / lattice->step), lattice->rows - 1));
    const double column =
        floor((x - lattice->shear * (row + 0.5)) / lattice->step) - first_column(lattice, row);
    return row * lattice->columns + (int)fmax(0, fmin(column, lattice->columns - 1));
}

/* Returns whether there is no half-integer from the least to the greatest of three numbers. */
static bool misses(double a, double b, double c)
{
    const double v[3] = {a - 0.5, b - 0.5, c - 0.5};
    return ceil(least_of(v)) > floor(most_of(v));
}

bool lattice_misses(const struct lattice *lattice, const struct surface *surface,
                    const int32_t vertex[3])
{
    const double shear = lattice->shear, step = lattice->step;
    double x[3], y[3];
    for (int i = 0; i < 3; i++) {
        const struct window_vertex *corner = &surface->vertices[vertex[i]];
        if (!(corner->clip[3] > 0))
            return false;
        y[i] = corner->y / step;
        x[i] = (corner->x - shear * y[i]) / step;
    }
    return misses(y[0], y[1], y[2]) || misses(x[0], x[1], x[2]);
}

int seen_parts(const struct view *view, const struct surface *surface, int triangle,
               struct screen_triangle out[SCREEN_TRIANGLES])
{
    /* near, then far */
    static const struct clip_plane depth_planes[2] = {{{0, 0, 1, 1}, 0}, {{0, 0, -1, 1}, 0}};
    return screen_triangles(view, surface, triangle, depth_planes, 2, out);
}

struct lattice_drawing {
    const struct lattice *lattice;
    const struct plan *plan;
    int surface;
    struct lattice_pixel *pixels;
};

/* Keeps the first of fragments that are equally deep. */
static void cover(void *context, const struct lattice_fragment *fragment)
{
    const struct lattice_drawing *drawing = context;
    struct lattice_pixel *pixel = &drawing->pixels[fragment->index];
    if (fragment->depth < pixel->depth)
        *pixel = (struct lattice_pixel){fragment->depth, drawing->surface, *fragment->triangle};
}

static void draw_surface(struct lattice_drawing *drawing, const struct surface *surface)
{
    struct screen_triangle parts[SCREEN_TRIANGLES];
    const struct instance *instance = surface->instance;
    for (int i = 0; i < instance->n_triangles; i++) {
        if (lattice_misses(drawing->lattice, surface, instance->triangles[i]))
            continue;
        const int n = seen_parts(&drawing->plan->view, surface, i, parts);
        for (int part = 0; part < n; part++)
            lattice_scan(drawing->lattice, &parts[part], cover, drawing);
    }
}

bool seen_find(const struct plan *plan, const struct surface *surfaces, int wanted,
               struct seen_pixels *out, struct error *err)
{
    *out = (struct seen_pixels){.lattice = lattice_of(&plan->view, wanted)};
    const size_t n = (size_t)out->lattice.rows * (size_t)out->lattice.columns;
    out->pixels = malloc((n + 1) * sizeof *out->pixels);
    struct lattice_drawing drawing = {
        .lattice = &out->lattice, .plan = plan, .pixels = out->pixels};
    if (!out->pixels)
        return error_memory(err);
    for (size_t i = 0; i < n; i++)
        out->pixels[i] = (struct lattice_pixel){.depth = 1, .surface = -1};
    for (int s = 0; s < plan->n_instances; s++) {
        drawing.surface = s;
        if (plan->instances[s].in_view && !plan->instances[s].twin)
            draw_surface(&drawing, &surfaces[s]);
    }
    return true;
}

void seen_free(struct seen_pixels *seen)
{
    free(seen->pixels);
    *seen = (struct seen_pixels){.pixels = NULL};
}
