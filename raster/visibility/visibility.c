/* SPDX-License-Identifier: MIT */
/* Shadows: a light reaches a point unless a triangle lies between them, or the point's own triangle
 * turns away. */
#include <math.h>

#include "raster/visibility/inside.h"

/* A point that is asked whether a light reaches it. */
struct query {
    const struct occluders *of;
    const struct seen_point *point;
    struct homogeneous light, from; /* from: the point */
    bool blocked;
};

static void corners_of(const struct occluders *of, int surface, int triangle, struct vector out[3])
{
    const int32_t *vertex = of->surfaces[surface].instance->triangles[triangle];
    for (int i = 0; i < 3; i++)
        out[i] = of->vertices[surface][vertex[i]];
}

/* The side of the segment on which an edge passes. If they meet, it is the side on which the edge
 * passes once the light is moved a little along x, or else along y, or z (Edelsbrunner and Muecke
 * 1990: Simulation of Simplicity): so a closed mesh lets nothing through its edges and vertices.
 * 0: the point lies on the line of the edge. */
static int passes(const struct query *query, struct vector a, struct vector b)
{
    static const struct homogeneous axes[3] = {
        {{1, 0, 0}, true}, {{0, 1, 0}, true}, {{0, 0, 1}, true}};
    struct homogeneous rows[4] = {query->light, query->from, {a, false}, {b, false}};
    int side = side_of(rows);
    for (int i = 0; i < 3 && side == 0; i++) {
        rows[0] = axes[i];
        side = side_of(rows);
    }
    return side;
}

int side_of_plane(const struct vector corner[3], const struct homogeneous *of)
{
    const struct vector a = corner[0],
                        normal = vector_cross(vector_subtract(corner[1], a),
                                              vector_subtract(corner[2], a)),
                        from = of->infinite ? of->at : vector_subtract(of->at, a);
    const double height = vector_dot(normal, from),
                 size = of->infinite ? vector_reach(of->at)
                                     : fmax(vector_reach(of->at), vector_reach(a));
    if (!(fabs(height) > 0x1p-40 * size * (fabs(normal.x) + fabs(normal.y) + fabs(normal.z))))
        return 0;
    return height > 0 ? 1 : -1;
}

static bool blocks(const struct query *query, const struct vector c[3])
{
    const int first = passes(query, c[0], c[1]);
    return passes(query, c[1], c[2]) == first && passes(query, c[2], c[0]) == first &&
           side_of_plane(c, &query->from) * side_of_plane(c, &query->light) < 0;
}

static bool visit(void *context, const struct occluder *met)
{
    struct query *query = context;
    struct vector corners[3];
    corners_of(query->of, met->surface, met->triangle, corners);
    const bool own =
        met->surface == query->point->surface && met->triangle == query->point->triangle;
    query->blocked = !own && blocks(query, corners);
    return !query->blocked;
}

/* Returns whether a point's own triangle turns one side to the light and the other to the eye. */
static bool turns_away(const struct query *query, const struct view *view)
{
    const struct seen_point *point = query->point;
    const bool parallel = view->projection.row[3][3] != 0;
    const struct homogeneous eye = {{0, 0, parallel ? 1 : 0}, parallel};
    struct vector corners[3];
    if (!query->of->vertices[point->surface])
        return false;
    corners_of(query->of, point->surface, point->triangle, corners);
    return side_of_plane(corners, &eye) * side_of_plane(corners, &query->light) < 0;
}

/* Returns whether something lies between the point and a light. */
static bool is_blocked(const struct occluders *of, const struct view *view,
                       const struct eye_light *light, const struct seen_point *point)
{
    struct query query = {.of = of,
                          .point = point,
                          .light = {light->position, light->directional},
                          .from = {point->eye, false}};
    query.blocked = turns_away(&query, view);
    if (!query.blocked)
        occluders_along(of, point->eye, &query.light, visit, &query);
    return query.blocked;
}

int shown_parts(const struct view *view, const struct surface *surface, int triangle,
                struct screen_triangle out[SCREEN_TRIANGLES])
{
    /* near, then far */
    static const struct clip_plane depth_planes[2] = {{{0, 0, 1, 1}, 0}, {{0, 0, -1, 1}, 0}};
    return screen_triangles(view, surface, triangle, depth_planes, 2, out);
}

struct seen_point seen_point(const struct surface *surfaces, const struct screen_triangle *of,
                             const double share[3])
{
    const struct instance *instance = of->surface->instance;
    struct vector point = {0, 0, 0};
    for (int i = 0; i < 3; i++)
        point =
            vector_add(point, vector_scale(instance->vertices[of->vertex[i]].position, share[i]));
    return (struct seen_point){.eye = matrix_point(&instance->model_view, point),
                               .surface = (int32_t)(of->surface - surfaces),
                               .triangle = of->triangle};
}

/* ---- a picture ---- */

/* Finds the point of its triangle that a pixel shows. */
static struct seen_point point_at(const struct view *view, const struct occluders *of,
                                  const struct picture *picture, size_t pixel)
{
    const struct rectangle *at = &picture->at;
    const double x = at->x + (int)(pixel % (size_t)at->width) + 0.5,
                 y = at->y + (int)(pixel / (size_t)at->width) + 0.5;
    const struct surface *surface = &of->surfaces[picture->surface[pixel]];
    struct screen_triangle parts[SCREEN_TRIANGLES];
    double share[3];
    const int n = shown_parts(view, surface, picture->triangle[pixel], parts);
    int part = 0;
    while (part < n - 1 && covered_depth(&parts[part], x, y) < 0)
        part++;
    shares_at(&parts[part], x, y, share);
    return seen_point(of->surfaces, &parts[part], share);
}

uint32_t lights_blocked(const struct occluders *of, const struct view *view, int n, uint32_t asked,
                        const struct seen_point *point)
{
    const struct eye_light *lights = view->lights + view->n_lights - n;
    uint32_t dark = 0;
    for (int i = 0; i < n; i++)
        if (asked >> i & 1)
            dark |= (uint32_t)is_blocked(of, view, &lights[i], point) << i;
    return dark;
}

uint32_t light_bit(const struct view *view, int n, const struct term *term)
{
    for (int i = 0; i < n; i++)
        if (view->lights[view->n_lights - n + i].first == term->light)
            return (uint32_t)1 << i;
    return 0;
}

static uint32_t shadow_pixel(const struct view *view, const struct occluders *of, int n,
                             const struct seen_point *point, double *rows, size_t stride)
{
    const struct instance *instance = of->surfaces[point->surface].instance;
    uint32_t asked = 0;
    for (int t = 0; t < instance->n_terms; t++)
        if (rows[(size_t)t * stride] != 0)
            asked |= light_bit(view, n, &instance->terms[t]);
    const uint32_t dark = lights_blocked(of, view, n, asked, point);
    for (int t = 0; t < instance->n_terms; t++)
        if ((light_bit(view, n, &instance->terms[t]) & dark) != 0)
            rows[(size_t)t * stride] = 0;
    return dark;
}

void picture_shadow(const struct view *view, const struct occluders *of, int n,
                    struct picture *picture, uint32_t *dark)
{
    const size_t n_pixels = (size_t)picture->at.width * (size_t)picture->at.height;
    for (size_t i = 0; i < n_pixels; i++)
        if (picture->surface[i] >= 0) {
            const struct seen_point point = point_at(view, of, picture, i);
            dark[i] = shadow_pixel(view, of, n, &point, picture->rows + i, n_pixels);
        }
}
