/* SPDX-License-Identifier: MIT */
/* Shadows: a light reaches a point unless a triangle lies between them, or the point's own triangle
 * turns away. */
#include <math.h>

#include "raster/visibility/inside.h"

/* A point that is asked whether a light reaches it. */
struct query {
    const struct occluders *of;
    const struct seen_point *point;
    struct homogeneous light;
    bool blocked;
};

static void corners_of(const struct occluders *of, struct occluder at, struct vector out[3])
{
    const int32_t *vertex = of->surfaces[at.surface].instance->triangles[at.triangle];
    for (int i = 0; i < 3; i++)
        out[i] = of->vertices[at.surface][vertex[i]];
}

/* With n = u x v for the edges u and v from corner a, and q = p - a, the height of point p is n q.
 * Where each component of a place is off by up to e, each of q is by 2 e, and each of n by 4 e (|u|
 * + |v|), in largest components: so n q is by 6 e (|n| + 2 |q| (|u| + |v|)). A direction is no such
 * difference: it is off by its own roundings. */
int occluder_side(const struct occluders *of, struct occluder at, const struct homogeneous *point)
{
    struct vector c[3];
    corners_of(of, at, c);
    const struct vector u = vector_subtract(c[1], c[0]), v = vector_subtract(c[2], c[0]),
                        n = vector_cross(u, v),
                        q = point->infinite ? point->at : vector_subtract(point->at, c[0]);
    const double size = fmax(of->size, vector_reach(point->at)), far = vector_reach(q),
                 height = vector_dot(n, q),
                 limit = (point->infinite ? far : size) * vector_reach(n) +
                         2 * size * far * (vector_reach(u) + vector_reach(v));
    return (height > 6 * PLACE_ERROR * limit) - (height < -6 * PLACE_ERROR * limit);
}

/* The side of the segment on which an edge passes. If they meet, it is the side on which the edge
 * passes once the light is moved a little along x, or else along y, or z (Edelsbrunner and Muecke
 * 1990: Simulation of Simplicity): so a closed mesh lets nothing through its edges and vertices.
 * 0: the point lies on the line of the edge. */
static int passes(const struct query *query, struct vector a, struct vector b)
{
    static const struct homogeneous axes[3] = {
        {{1, 0, 0}, true}, {{0, 1, 0}, true}, {{0, 0, 1}, true}};
    struct homogeneous rows[4] = {query->light, query->point->eye, {a, false}, {b, false}};
    int side = side_of(rows);
    for (int i = 0; i < 3 && side == 0; i++) {
        rows[0] = axes[i];
        side = side_of(rows);
    }
    return side;
}

/* Returns whether an occluder's plane parts two points. */
static bool parts(const struct occluders *of, const struct occluder *at,
                  const struct homogeneous *a, const struct homogeneous *b)
{
    return occluder_side(of, *at, a) * occluder_side(of, *at, b) < 0;
}

static bool visit(void *context, const struct occluder *met)
{
    struct query *query = context;
    const struct occluder *own = &query->point->of;
    struct vector c[3];
    corners_of(query->of, *met, c);
    const int first = passes(query, c[0], c[1]);
    query->blocked = passes(query, c[1], c[2]) == first && passes(query, c[2], c[0]) == first &&
                     parts(query->of, met, &query->point->eye, &query->light) &&
                     (met->surface != own->surface || met->triangle != own->triangle);
    return !query->blocked;
}

/* Returns whether a point's own triangle turns one side to the light and the other to the eye. */
static bool turns_away(const struct query *query, const struct view *view)
{
    const struct occluder *own = &query->point->of;
    const bool parallel = view->projection.row[3][3] != 0;
    const struct homogeneous eye = {{0, 0, parallel}, parallel};
    return query->of->vertices[own->surface] && parts(query->of, own, &eye, &query->light);
}

/* Returns whether something lies between the point and a light. */
static bool is_blocked(const struct occluders *of, const struct view *view,
                       const struct eye_light *light, const struct seen_point *point)
{
    struct query query = {.of = of, .point = point, .light = {light->position, light->directional}};
    query.blocked = turns_away(&query, view);
    if (!query.blocked)
        occluders_along(of, point->eye.at, &query.light, visit, &query);
    return query.blocked;
}

int shown_parts(const struct view *view, const struct surface *surface, int triangle,
                struct screen_triangle out[SCREEN_TRIANGLES])
{
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
    return (struct seen_point){.eye = {matrix_point(&instance->model_view, point), false},
                               .of = {(int32_t)(of->surface - surfaces), of->triangle}};
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

const struct eye_light *shadow_light(const struct view *view, int i)
{
    return &view->lights[view->n_lights - view->n_shadowed + i];
}

uint32_t light_bit(const struct view *view, const struct term *term)
{
    for (int i = 0; i < view->n_shadowed; i++)
        if (shadow_light(view, i)->first == term->light)
            return (uint32_t)1 << i;
    return 0;
}

uint32_t lights_blocked(const struct occluders *of, const struct view *view, uint32_t asked,
                        const struct seen_point *point)
{
    uint32_t dark = 0;
    for (int i = 0; i < view->n_shadowed; i++)
        if (asked >> i & 1)
            dark |= (uint32_t)is_blocked(of, view, shadow_light(view, i), point) << i;
    return dark;
}

uint32_t lights_weighed(const struct view *view, const struct instance *instance,
                        const double *weights, size_t stride)
{
    uint32_t lights = 0;
    for (int t = 0; t < instance->n_terms; t++)
        lights |= weights[(size_t)t * stride] != 0 ? light_bit(view, &instance->terms[t]) : 0;
    return lights;
}

void lights_darken(const struct view *view, const struct instance *instance, uint32_t dark,
                   double *weights, size_t stride)
{
    for (int t = 0; t < instance->n_terms; t++)
        if ((light_bit(view, &instance->terms[t]) & dark) != 0)
            weights[(size_t)t * stride] = 0;
}

void picture_shadow(const struct view *view, const struct occluders *of, struct picture *picture,
                    uint32_t *dark)
{
    const size_t n_pixels = (size_t)picture->at.width * (size_t)picture->at.height;
    for (size_t i = 0; i < n_pixels; i++)
        if (picture->surface[i] >= 0) {
            const struct instance *instance = of->surfaces[picture->surface[i]].instance;
            const struct seen_point point = point_at(view, of, picture, i);
            double *weights = picture->rows + i;
            dark[i] =
                lights_blocked(of, view, lights_weighed(view, instance, weights, n_pixels), &point);
            lights_darken(view, instance, dark[i], weights, n_pixels);
        }
}
