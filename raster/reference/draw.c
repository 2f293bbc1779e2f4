/* SPDX-License-Identifier: MIT */
/* Draws a rectangle of the picture: each triangle is placed, cut and scanned row by row; each pixel
 * keeps the nearest triangle that covers its centre; at the end each pixel is shaded. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/reference/reference.h"

struct drawing {
    const struct view *view;
    const struct surface *surfaces;
    struct picture *picture;
    int32_t *nearest; /* of each pixel the index into `triangles`; -1: background */
    struct screen_triangle *triangles; /* those that were nearest somewhere, at their time */
    int32_t n_triangles;
    bool shown; /* some pixel shows the triangle behind the last one, which is being scanned */
    double *attributes; /* of one pixel */
};

/* ---- coverage ---- */

/* Keeps the first of fragments that are equally deep. */
static bool cover_pixel(void *context, int x, int y)
{
    struct drawing *drawing = context;
    struct picture *picture = drawing->picture;
    const struct screen_triangle *triangle = &drawing->triangles[drawing->n_triangles];
    size_t pixel =
        (size_t)(y - picture->at.y) * (size_t)picture->at.width + (size_t)(x - picture->at.x);
    double depth = covered_depth(triangle, x + 0.5, y + 0.5);
    if (depth >= 0 && depth < picture->depth[pixel]) {
        picture->depth[pixel] = depth;
        drawing->nearest[pixel] = drawing->n_triangles;
        drawing->shown = true;
    }
    return true;
}

/* The sides of a rectangle, widened by a margin, beside which a vertex lies (Cohen and Sutherland
 * 1968); 0 for a vertex that is not in front of the eye. */
int outcode(const struct window_vertex *vertex, const struct rectangle *at, double margin)
{
    if (!(vertex->clip[3] > 0))
        return 0;
    return (vertex->x + margin < at->x) | (vertex->x - margin > at->x + at->width) << 1 |
           (vertex->y + margin < at->y) << 2 | (vertex->y - margin > at->y + at->height) << 3;
}

/* Room for triangles grows where their number is a power of two, or 0. */
static bool has_room(struct drawing *drawing)
{
    const size_t n = (size_t)drawing->n_triangles;
    if ((n & (n - 1)) != 0)
        return true;
    void *moved = realloc(drawing->triangles, (2 * n + 1) * sizeof *drawing->triangles);
    drawing->triangles = moved ? moved : drawing->triangles;
    return moved && n < INT32_MAX / 2;
}

static bool draw_triangle(struct drawing *drawing, const struct surface *surface, int triangle)
{
    struct screen_triangle parts[SCREEN_TRIANGLES];
    const int32_t *vertex = surface->instance->triangles[triangle];
    int beside = ~0;
    for (int i = 0; i < 3 && beside; i++)
        beside &= outcode(&surface->vertices[vertex[i]], &drawing->picture->at, 0);
    if (beside)
        return true;
    int n = screen_triangles(drawing->view, surface, triangle, depth_planes, 2, parts);
    for (int i = 0; i < n; i++) {
        if (!has_room(drawing))
            return false;
        drawing->triangles[drawing->n_triangles] = parts[i];
        drawing->shown = false;
        scan_triangle(&parts[i], &drawing->picture->at, 0, cover_pixel, drawing);
        drawing->n_triangles += drawing->shown;
    }
    return true;
}

/* Skips a surface whose vertices all lie beside the rectangle, on one side of it. */
static bool draw_surface(struct drawing *drawing, const struct surface *surface)
{
    int beside = ~0;
    for (int i = 0; i < surface->instance->n_vertices && beside; i++)
        beside &= outcode(&surface->vertices[i], &drawing->picture->at, 0);
    for (int i = 0; i < surface->instance->n_triangles && !beside; i++)
        if (!draw_triangle(drawing, surface, i))
            return false;
    return true;
}

/* ---- pixels ---- */

static void shade_pixel(struct drawing *drawing, size_t pixel)
{
    struct picture *picture = drawing->picture;
    const struct screen_triangle *triangle = &drawing->triangles[drawing->nearest[pixel]];
    const struct instance *instance = triangle->surface->instance;
    size_t width = (size_t)picture->at.width, n_pixels = width * (size_t)picture->at.height;
    const int x = picture->at.x + (int)(pixel % width), y = picture->at.y + (int)(pixel / width);
    double share[3], place[TEXEL_PLACE] = {0};
    shares_at(triangle, x + 0.5, y + 0.5, share);
    shade(drawing->view, triangle, share, drawing->attributes, &picture->work);
    if (instance->textured)
        texel_place(&instance->texels, drawing->attributes + instance->n_terms, place);
    if (instance->textured && instance->texels.n_levels > 1)
        place[PLACE_DETAIL] = drawing->view->find_detail(triangle, x, y);
    put_rows(instance, drawing->attributes, place, picture->rows + pixel, n_pixels);
    picture->surface[pixel] = (int32_t)(triangle->surface - drawing->surfaces);
    picture->triangle[pixel] = triangle->triangle;
}

/* ---- the rectangle ---- */

static bool allocate(struct drawing *drawing, const struct rectangle *at, size_t n_rows)
{
    struct picture *out = drawing->picture;
    size_t n_pixels = (size_t)at->width * (size_t)at->height;
    out->at = *at;
    out->surface = malloc(n_pixels * 2 * sizeof *out->surface + 1);
    out->depth = malloc(n_pixels * (1 + n_rows) * sizeof *out->depth + 1);
    drawing->nearest = malloc(n_pixels * sizeof *drawing->nearest + 1);
    drawing->attributes = malloc((n_rows + 2) * sizeof *drawing->attributes);
    if (!out->surface || !out->depth || !drawing->nearest || !drawing->attributes)
        return false;
    out->triangle = out->surface + n_pixels;
    out->rows = out->depth + n_pixels;
    return true;
}

static bool draw(struct drawing *drawing, int n_surfaces)
{
    struct picture *picture = drawing->picture;
    size_t n_pixels = (size_t)picture->at.width * (size_t)picture->at.height;
    for (size_t i = 0; i < n_pixels; i++) {
        picture->surface[i] = picture->triangle[i] = drawing->nearest[i] = -1;
        picture->depth[i] = 1;
    }
    for (int s = 0; s < n_surfaces; s++)
        if (!draw_surface(drawing, &drawing->surfaces[s]))
            return false;
    for (size_t i = 0; i < n_pixels; i++)
        if (drawing->nearest[i] >= 0)
            shade_pixel(drawing, i);
    return true;
}

/* Draws surfaces whose vertices are all lit. n_rows is at least their largest pixel_rows. */
bool picture_draw(const struct view *view, const struct surface *surfaces, int n_surfaces,
                  const struct rectangle *at, int n_rows, struct picture *out)
{
    struct drawing drawing = {.view = view, .surfaces = surfaces, .picture = out};
    *out = (struct picture){.surface = NULL};
    bool done = allocate(&drawing, at, (size_t)n_rows) && draw(&drawing, n_surfaces);
    free(drawing.nearest);
    free(drawing.triangles);
    free(drawing.attributes);
    return done;
}

void picture_free(struct picture *picture)
{
    free(picture->surface);
    free(picture->depth);
    *picture = (struct picture){.surface = NULL};
}
