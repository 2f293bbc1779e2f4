/* SPDX-License-Identifier: MIT */
/* Finds the edges of a triangle that are too long: those in whose middle the shading is wrong, or
 * the outline of a curved shape too far from the true one. Where the shading is wrong inside of the
 * triangle only, all of its edges are. */
#include <math.h>
#include <string.h>

#include "raster/refine/refine.h"

/* An error is looked for in the middle of an edge, and of longer ones a quarter from the ends, too:
 * one that changes its sign may be 0 in the middle. */
static const double long_px = 8;

/* A triangle while it is judged. */
struct judged_triangle {
    const struct judge *judge;
    struct judged_mesh *of;
    const struct judged_surface *surface; /* that of the mesh */
    int triangle;
    struct screen_triangle parts[SCREEN_TRIANGLES];
    int n_parts;
    double length_px[3]; /* of its edges in the window */
    double inside;       /* the largest error at a pixel of the lattice, or in the middle */
};

/* ---- one point ---- */

/* Returns the error at a place of the window, with its barycentric coordinates; 0 where the true
 * surface is not seen. */
static double difference_at(const struct judged_triangle *of, const struct screen_triangle *part,
                            const double at[2], const double share[3])
{
    struct compared_point point;
    return compare_point(of->surface, part, at, share, of->of->attributes, &point)
               ? measure_difference(of->judge->measure, of->surface->shaded, &point.drawn,
                                    &point.exact)
               : 0;
}

/* Returns whether a fragment lies behind another surface: by more than what refined surfaces move,
 * a hundredth of its distance from the far plane. */
static bool is_behind(const struct lattice_pixel *pixel, double depth)
{
    return pixel->depth < depth - 0.01 * (1 - depth) - 1e-6;
}

/* Returns whether a point lies behind what the pixels of the lattice around it show. */
static bool is_hidden(const struct judge *judge, double x, double y, double depth)
{
    const double step = judge->lattice->step / 2.0;
    bool hidden = true;
    for (int i = 0; i < 4 && hidden; i++)
        hidden = is_behind(&judge->pixels[lattice_beside(judge->lattice, x + (i % 2 ? step : -step),
                                                         y + (i / 2 ? step : -step))],
                           depth);
    return hidden;
}

/* ---- places of a triangle ---- */

/* A point of the triangle in the window. */
struct window_point {
    double at[2], depth;
    bool in_view;
};

static struct window_point window_point(const struct judged_triangle *of, const double weights[3])
{
    const int32_t *vertex = of->surface->surface->instance->triangles[of->triangle];
    const struct view *view = &of->judge->plan->view;
    struct window_vertex window = {{0, 0, 0, 0}, 0, 0, 0, 0};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 4; i++)
            window.clip[i] += weights[k] * of->surface->surface->vertices[vertex[k]].clip[i];
    if (!(window.clip[3] > 0) || fabs(window.clip[2]) > window.clip[3])
        return (struct window_point){.in_view = false};
    window_place(view, &window);
    return (struct window_point){{window.x, window.y},
                                 window.z,
                                 window.x > -1 && window.y > -1 && window.x < view->width + 1 &&
                                     window.y < view->height + 1};
}

/* Returns the error at a point of the mesh's triangle, by its corners' weights; 0 where it is not
 * seen. */
static double point_difference(const struct judged_triangle *of, const double weights[3])
{
    const struct window_point point = window_point(of, weights);
    const struct screen_triangle *part = &of->parts[0];
    const int32_t *vertex = of->surface->surface->instance->triangles[of->triangle];
    double share[3];
    if (!point.in_view || of->n_parts == 0 ||
        is_hidden(of->judge, point.at[0], point.at[1], point.depth))
        return 0;
    for (int j = 0; j < 3; j++) /* the screen triangle may have its corners in another order */
        for (int k = 0; k < 3; k++)
            if (part->vertex[j] == vertex[k])
                share[j] = weights[k];
    return difference_at(of, part, point.at, share);
}

/* ---- outlines ---- */

/* Returns how far, in pixels, the true surface lies beside the middle of an edge in the window. For
 * an edge along the outline that is the distance from its line. */
static double off_edge(const struct judged_triangle *of, int edge, bool along)
{
    const struct surface *surface = of->surface->surface;
    const int32_t *vertex = surface->instance->triangles[of->triangle], a = vertex[edge],
                  b = vertex[(edge + 1) % 3];
    struct parameters parameters;
    const struct vertex middle =
        mesh_midpoint(of->of->mesh, of->surface->patches, a, b, &parameters);
    const struct window_vertex *p = &surface->vertices[a], *q = &surface->vertices[b];
    struct window_vertex window;
    if (!(p->clip[3] > 0 && q->clip[3] > 0) || !window_of(of->surface, middle.position, &window) ||
        is_hidden(of->judge, window.x, window.y, window.z))
        return 0;
    const double x = window.x - (p->x + q->x) / 2, y = window.y - (p->y + q->y) / 2,
                 dx = q->x - p->x, dy = q->y - p->y,
                 length = vector_length((struct vector){dx, dy, 0});
    return !along       ? vector_length((struct vector){x, y, 0})
           : length > 0 ? fabs(x * dy - y * dx) / length
                        : 0;
}

/* Adds the edges that make the outline coarse. */
static void judge_outline(const struct judged_triangle *of, float out[3])
{
    const int32_t *vertex = of->surface->surface->instance->triangles[of->triangle];
    bool front[3], flat;
    if (!of->surface->parameters)
        return;
    flat = patch_is_flat(of->surface->patches->shape, of->surface->parameters[vertex[0]].patch);
    for (int k = 0; k < 3; k++)
        front[k] = is_front(of->surface, &of->surface->surface->instance->vertices[vertex[k]]);
    if (!flat && front[0] == front[1] && front[1] == front[2])
        return;
    for (int k = 0; k < 3; k++) {
        const double off = off_edge(of, k, flat || front[k] == front[(k + 1) % 3]);
        if (off > of->judge->outline_px && of->length_px[k] >= of->judge->shortest_px)
            out[k] = fmaxf(out[k], (float)(off / of->judge->outline_px));
    }
}

/* ---- shading ---- */

static void judge_fragment(void *context, const struct lattice_fragment *fragment)
{
    struct judged_triangle *of = context;
    double share[3];
    if (is_behind(&of->judge->pixels[fragment->index], fragment->depth))
        return;
    shares_at(fragment->triangle, fragment->at[0], fragment->at[1], share);
    of->inside = fmax(of->inside, difference_at(of, fragment->triangle, fragment->at, share));
}

static double edge_difference(const struct judged_triangle *of, int edge)
{
    const int first = of->length_px[edge] < long_px ? 2 : 1;
    double largest = 0;
    for (int quarter = first; quarter <= 4 - first; quarter++) {
        double weights[3] = {0, 0, 0};
        weights[edge] = quarter / 4.0;
        weights[(edge + 1) % 3] = 1 - quarter / 4.0;
        largest = fmax(largest, point_difference(of, weights));
    }
    return largest;
}

/* Returns the place for an edge among the known ones, which may hold another. */
static struct known_edge *known_at(const struct judged_triangle *of, int edge, int32_t ends[2])
{
    const int32_t *vertex = of->surface->surface->instance->triangles[of->triangle];
    const int32_t a = vertex[edge], b = vertex[(edge + 1) % 3];
    ends[0] = a < b ? a : b;
    ends[1] = a < b ? b : a;
    return &of->of->known[(7 * (uint32_t)ends[0] + (uint32_t)ends[1]) % KNOWN_EDGES];
}

/* Returns the largest error on an edge. Its two triangles have the same. */
static double edge_error(const struct judged_triangle *of, int edge)
{
    int32_t ends[2];
    struct known_edge *known = known_at(of, edge, ends);
    if (known->ends[0] != ends[0] || known->ends[1] != ends[1])
        *known = (struct known_edge){{ends[0], ends[1]}, edge_difference(of, edge)};
    return known->error;
}

/* Finds the lengths of the edges in the window; that of an edge that is not all in front of the eye
 * is infinite. */
static void measure_edges(const struct surface *surface, int triangle, double length_px[3])
{
    const int32_t *vertex = surface->instance->triangles[triangle];
    for (int k = 0; k < 3; k++) {
        const struct window_vertex *a = &surface->vertices[vertex[k]],
                                   *b = &surface->vertices[vertex[(k + 1) % 3]];
        length_px[k] = a->clip[3] > 0 && b->clip[3] > 0
                           ? vector_length((struct vector){a->x - b->x, a->y - b->y, 0})
                           : HUGE_VAL;
    }
}

/* Returns twice the area of a triangle in the window, which is negative where its corners go round
 * against the clock, as those of a front do: y points down. */
static double turn(const struct surface *surface, int triangle)
{
    const struct window_vertex *corner = surface->vertices;
    const int32_t *vertex = surface->instance->triangles[triangle];
    const struct window_vertex *a = &corner[vertex[0]], *b = &corner[vertex[1]],
                               *c = &corner[vertex[2]];
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
}

/* Returns whether a triangle is narrower than an edge may be. */
static bool is_narrow(const struct judged_triangle *of)
{
    const double longest = most_of(of->length_px);
    return longest < HUGE_VAL &&
           fabs(turn(of->surface->surface, of->triangle)) < of->judge->shortest_px * longest;
}

static void judge_shading(struct judged_triangle *of, struct judgement *out)
{
    static const double middle[3] = {1 / 3.0, 1 / 3.0, 1 / 3.0};
    const double good = of->judge->error;
    if (!(good < HUGE_VAL) || is_narrow(of))
        return;
    for (int k = 0; k < 3; k++) {
        const double error = of->length_px[k] < of->judge->shortest_px ? 0 : edge_error(of, k);
        out->edges[k] = error > good ? (float)(error / good) : 0;
        out->shading = fmaxf(out->shading, (float)error);
    }
    if ((double)out->shading > good)
        return;
    of->inside = point_difference(of, middle);
    if (!lattice_misses(of->judge->lattice, of->surface->surface,
                        of->surface->surface->instance->triangles[of->triangle]))
        for (int i = 0; i < of->n_parts; i++)
            lattice_scan(of->judge->lattice, &of->parts[i], judge_fragment, of);
    out->shading = fmaxf(out->shading, (float)of->inside);
    for (int k = 0; k < 3 && of->inside > good; k++)
        if (of->length_px[k] >= of->judge->shortest_px)
            out->edges[k] = (float)(of->inside / good);
}

void judge_triangle(const struct judge *judge, struct judged_mesh *mesh, int triangle,
                    struct judgement *out)
{
    const struct surface *surface = mesh->surface->surface;
    struct judged_triangle of = {
        .judge = judge, .of = mesh, .surface = mesh->surface, .triangle = triangle};
    *out = (struct judgement){.shading = 0};
    of.n_parts = seen_parts(&judge->plan->view, surface, triangle, of.parts);
    measure_edges(surface, triangle, of.length_px);
    judge_shading(&of, out);
    judge_outline(&of, out->edges);
}

/* Returns whether a triangle is seen from behind, and none of its corners has a normal towards the
 * eye: where one has, an edge may be part of the outline. */
static bool is_back(const struct judged_surface *of, int triangle)
{
    const struct instance *instance = of->surface->instance;
    bool front = (turn(of->surface, triangle) < 0) != instance->mirrored;
    for (int i = 0; i < 3 && !front; i++)
        front = is_front(of, &instance->vertices[instance->triangles[triangle][i]]);
    return !front;
}

bool judge_concerns(const struct judge *judge, const struct judged_surface *of, int triangle,
                    bool solid)
{
    const struct view *view = &judge->plan->view;
    const struct rectangle picture = {0, 0, view->width, view->height};
    const int32_t *vertex = of->surface->instance->triangles[triangle];
    double length_px[3];
    int beside = ~0;
    for (int i = 0; i < 3 && beside; i++)
        beside &= outcode(&of->surface->vertices[vertex[i]], &picture, 1);
    if (beside)
        return false;
    measure_edges(of->surface, triangle, length_px);
    return most_of(length_px) >= judge->shortest_px && !(solid && is_back(of, triangle));
}
