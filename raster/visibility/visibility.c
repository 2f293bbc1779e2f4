/* SPDX-License-Identifier: MIT */
/* Shadows: a light reaches a point unless a triangle lies between them, or the point's own triangle
 * turns away. */
#include <math.h>

#include "raster/visibility/inside.h"

/* Points that are asked whether a light reaches them. */
struct query {
    const struct occluders *of;
    struct seen_point *points[TOGETHER];
    uint32_t bit; /* of the light */
    struct homogeneous light;
    int n, n_reached; /* points; those that it reaches, as far as is known */
};

/* A triangle's corners, its normal u x v for the edges u and v from corner 0, and |u| + |v| in
 * largest components. */
struct plane {
    struct vector corner[3], normal;
    double edges;
};

static struct plane plane_of(const struct occluders *of, struct occluder at)
{
    struct plane out;
    for (int i = 0; i < 3; i++)
        out.corner[i] = occluder_corner(of, at, i);
    const struct vector u = vector_subtract(out.corner[1], out.corner[0]),
                        v = vector_subtract(out.corner[2], out.corner[0]);
    out.normal = vector_cross(u, v);
    out.edges = vector_reach(u) + vector_reach(v);
    return out;
}

/* With normal n and q = p - corner, the height of point p is n q. Where each component of a place
 * is off by up to e, each of q is by 2 e, and each of n by 4 e (|u| + |v|): so n q is by 6 e (|n| +
 * 2 |q| (|u| + |v|)). A direction is no such difference: it is off by its own roundings. */
static int side(const struct occluders *of, const struct plane *plane,
                const struct homogeneous *point)
{
    const struct vector q =
        point->infinite ? point->at : vector_subtract(point->at, plane->corner[0]);
    const double size = fmax(of->size, vector_reach(point->at)), far = vector_reach(q),
                 height = vector_dot(plane->normal, q),
                 limit = (point->infinite ? far : size) * vector_reach(plane->normal) +
                         2 * size * far * plane->edges;
    return (height > 6 * PLACE_ERROR * limit) - (height < -6 * PLACE_ERROR * limit);
}

int occluder_side(const struct occluders *of, struct occluder at, const struct homogeneous *point)
{
    const struct plane plane = plane_of(of, at);
    return side(of, &plane, point);
}

/* The side of the segment on which an edge passes. If they meet, it is the side on which the edge
 * passes once the light is moved a little along x, or else along y, or z (Edelsbrunner and Muecke
 * 1990: Simulation of Simplicity): so a closed mesh lets nothing through its edges and vertices.
 * 0: the point lies on the line of the edge. */
static int passes(const struct query *query, const struct homogeneous *eye, struct vector a,
                  struct vector b)
{
    static const struct homogeneous axes[3] = {
        {{1, 0, 0}, true}, {{0, 1, 0}, true}, {{0, 0, 1}, true}};
    struct homogeneous rows[4] = {query->light, *eye, {a, false}, {b, false}};
    int side = side_of(rows);
    for (int i = 0; i < 3 && side == 0; i++) {
        rows[0] = axes[i];
        side = side_of(rows);
    }
    return side;
}

/* Asks an occluder that may lie between the light and some of the points. Goes on while the light
 * may reach one. */
static bool visit(void *context, const struct occluder *met, uint32_t segments)
{
    struct query *query = context;
    const struct plane plane = plane_of(query->of, *met);
    const struct vector *c = plane.corner;
    const int lit = side(query->of, &plane, &query->light);
    for (int i = 0; lit != 0 && i < query->n; i++) {
        struct seen_point *point = query->points[i];
        if (!(segments >> i & 1) || (point->dark & query->bit) != 0 ||
            side(query->of, &plane, &point->eye) != -lit ||
            (met->surface == point->of.surface && met->triangle == point->of.triangle))
            continue;
        const int first = passes(query, &point->eye, c[0], c[1]);
        if (passes(query, &point->eye, c[1], c[2]) == first &&
            passes(query, &point->eye, c[2], c[0]) == first) {
            point->dark |= query->bit;
            query->n_reached--;
        }
    }
    return query->n_reached > 0;
}

/* Returns whether a point's own triangle turns one side to the light and the other to the eye. */
static bool turns_away(const struct query *query, const struct view *view,
                       const struct occluder *own)
{
    const bool parallel = view->projection.row[3][3] != 0;
    const struct homogeneous eye = {{0, 0, parallel}, parallel};
    return query->of->vertices[own->surface] &&
           occluder_side(query->of, *own, &eye) * occluder_side(query->of, *own, &query->light) < 0;
}

void lights_block(const struct occluders *of, const struct view *view, struct seen_point points[],
                  int n)
{
    for (int i = 0; i < view->n_shadowed; i++) {
        const struct eye_light *light = shadow_light(view, i);
        struct query query = {
            .of = of, .bit = (uint32_t)1 << i, .light = {light->position, light->directional}};
        for (struct seen_point *point = points; point < points + n; point++)
            if ((point->asked & query.bit) != 0 && turns_away(&query, view, &point->of)) {
                point->dark |= query.bit;
            } else if ((point->asked & query.bit) != 0) {
                query.points[query.n++] = point;
            }
        query.n_reached = query.n;
        if (query.n > 0)
            occluders_along(of, query.points, query.n, &query.light, visit, &query);
    }
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

const struct eye_light *shadow_light(const struct view *view, int i)
{
    return &view->lights[view->n_lights - view->n_shadowed + i];
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
    const int n = screen_triangles(view, surface, picture->triangle[pixel], depth_planes, 2, parts);
    int part = 0;
    while (part < n - 1 && covered_depth(&parts[part], x, y) < 0)
        part++;
    shares_at(&parts[part], x, y, share);
    struct seen_point point = seen_point(of->surfaces, &parts[part], share);
    point.asked = lights_weighed(view, surface->instance, picture->rows + pixel,
                                 (size_t)at->width * (size_t)at->height);
    return point;
}

uint32_t light_bit(const struct view *view, const struct term *term)
{
    for (int i = 0; i < view->n_shadowed; i++)
        if (shadow_light(view, i)->first == term->light)
            return (uint32_t)1 << i;
    return 0;
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

/* Pixels of one surface that follow one another are asked together. */
void picture_shadow(const struct view *view, const struct occluders *of, struct picture *picture,
                    uint32_t *dark)
{
    const size_t n_pixels = (size_t)picture->at.width * (size_t)picture->at.height;
    const int32_t *surface = picture->surface;
    struct seen_point points[TOGETHER];
    int n = 0;
    for (size_t i = 0; i < n_pixels; i++) {
        if (surface[i] < 0)
            continue;
        points[n++] = point_at(view, of, picture, i);
        if (n < TOGETHER && i < n_pixels - 1 && surface[i + 1] == surface[i])
            continue;
        lights_block(of, view, points, n);
        for (size_t at = i; n > 0; at--) {
            dark[at] = points[--n].dark;
            lights_darken(view, of->surfaces[surface[at]].instance, dark[at], picture->rows + at,
                          n_pixels);
        }
    }
}
