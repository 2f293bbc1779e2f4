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
    int32_t n_triangles, capacity;
    bool shown; /* some pixel shows the triangle behind the last one, which is being scanned */
    double *attributes; /* of one pixel */
};

/* ---- coverage ---- */

/* Of fragments that are equally deep the first is kept. */
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

/* True where nothing of a triangle in front of the eye is in the rectangle. */
static bool is_beside(const struct surface *surface, const int32_t vertex[3],
                      const struct rectangle *at)
{
    bool left = true, right = true, above = true, below = true;
    for (int i = 0; i < 3; i++) {
        const struct window_vertex *corner = &surface->vertices[vertex[i]];
        if (!(corner->clip[3] > 0))
            return false;
        left = left && corner->x < at->x;
        right = right && corner->x > at->x + at->width;
        above = above && corner->y < at->y;
        below = below && corner->y > at->y + at->height;
    }
    return left || right || above || below;
}

static bool has_room(struct drawing *drawing)
{
    if (drawing->n_triangles < drawing->capacity)
        return true;
    if (drawing->capacity > INT32_MAX / 2 - 256)
        return false;
    int32_t capacity = drawing->capacity * 2 + 256;
    void *moved = realloc(drawing->triangles, (size_t)capacity * sizeof *drawing->triangles);
    if (!moved)
        return false;
    drawing->triangles = moved;
    drawing->capacity = capacity;
    return true;
}

static bool draw_triangle(struct drawing *drawing, int surface, int triangle)
{
    struct screen_triangle parts[SCREEN_TRIANGLES];
    const struct surface *of = &drawing->surfaces[surface];
    if (is_beside(of, of->instance->triangles[triangle], &drawing->picture->at))
        return true;
    int n = screen_triangles(drawing->view, drawing->surfaces, surface, triangle, parts);
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

/* ---- pixels ---- */

static void shade_pixel(struct drawing *drawing, size_t pixel)
{
    struct picture *picture = drawing->picture;
    const struct screen_triangle *triangle = &drawing->triangles[drawing->nearest[pixel]];
    const struct surface *surface = &drawing->surfaces[triangle->surface];
    size_t width = (size_t)picture->at.width, n_pixels = width * (size_t)picture->at.height;
    double share[3], place[2] = {0, 0};
    shares_at(triangle, picture->at.x + (int)(pixel % width) + 0.5,
              picture->at.y + (int)(pixel / width) + 0.5, share);
    shade(drawing->view, surface, triangle, share, drawing->attributes, &picture->work);
    if (surface->instance->textured)
        texel_place(&surface->instance->texels, drawing->attributes + surface->instance->n_terms,
                    place);
    put_rows(surface->instance, drawing->attributes, place, picture->rows + pixel, n_pixels);
    picture->surface[pixel] = triangle->surface;
    picture->triangle[pixel] = triangle->triangle;
}

/* ---- the rectangle ---- */

static bool allocate(struct drawing *drawing, const struct rectangle *at, int n_rows)
{
    struct picture *out = drawing->picture;
    size_t n_pixels = (size_t)at->width * (size_t)at->height;
    *out = (struct picture){.at = *at};
    out->surface = malloc(n_pixels * sizeof *out->surface + 1);
    out->triangle = malloc(n_pixels * sizeof *out->triangle + 1);
    out->depth = malloc(n_pixels * sizeof *out->depth + 1);
    out->rows = malloc(n_pixels * (size_t)n_rows * sizeof *out->rows + 1);
    drawing->nearest = malloc(n_pixels * sizeof *drawing->nearest + 1);
    drawing->attributes = malloc(((size_t)n_rows + 2) * sizeof *drawing->attributes);
    return out->surface && out->triangle && out->depth && out->rows && drawing->nearest &&
           drawing->attributes;
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
        for (int t = 0; t < drawing->surfaces[s].instance->n_triangles; t++)
            if (!draw_triangle(drawing, s, t))
                return false;
    for (size_t i = 0; i < n_pixels; i++)
        if (drawing->nearest[i] >= 0)
            shade_pixel(drawing, i);
    return true;
}

bool picture_draw(const struct view *view, const struct surface *surfaces, int n_surfaces,
                  const struct rectangle *at, int n_rows, struct picture *out)
{
    struct drawing drawing = {.view = view, .surfaces = surfaces, .picture = out};
    bool done = allocate(&drawing, at, n_rows) && draw(&drawing, n_surfaces);
    free(drawing.nearest);
    free(drawing.triangles);
    free(drawing.attributes);
    return done;
}

void picture_free(struct picture *picture)
{
    free(picture->surface);
    free(picture->triangle);
    free(picture->depth);
    free(picture->rows);
    *picture = (struct picture){.surface = NULL};
}
