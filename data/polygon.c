/* SPDX-License-Identifier: MIT */
/* Faces of any size: normals, angles, and cutting into triangles by ear clipping. It never fails
 * and always ends: a ring that is no simple polygon, within rounding, is finished as a fan. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "mesh.h"

static double largest_component(struct vector a)
{
    return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
}

/* How far the ring reaches from its first corner, along the axis where it reaches farthest, rounded
 * up to a power of two: dividing by that is exact, so that straight corners stay straight. */
static double ring_reach(const struct vector *ring, int n)
{
    double reach = 0;
    int exponent;

    for (int i = 1; i < n; i++)
        reach = fmax(reach, largest_component(vector_subtract(ring[i], ring[0])));
    frexp(reach, &exponent);
    return reach > 0 ? ldexp(1, exponent) : 0;
}

/* How far coordinates reach from 0, in units of the reach: by that much of an epsilon may relative
 * coordinates be off, since the ring's own were rounded. At least about 1/4. */
static double rounding_scale(const struct vector *ring, int n, double reach)
{
    double largest = 0;

    for (int i = 0; i < n; i++)
        largest = fmax(largest, largest_component(ring[i]));
    return largest / reach;
}

/* Relative to the first corner, in units of the reach: safe to multiply whatever the scale. */
static struct vector relative(const struct vector *ring, int i, double reach)
{
    const struct vector from = vector_subtract(ring[i], ring[0]);

    return (struct vector){from.x / reach, from.y / reach, from.z / reach};
}

struct vector polygon_normal(const struct vector *ring, int n)
{
    const struct vector none = {0, 0, 0};
    const double reach = ring_reach(ring, n);
    struct vector sum = none, last, next;

    if (reach == 0)
        return none;
    last = relative(ring, 1, reach);
    for (int i = 2; i < n; i++, last = next) {
        next = relative(ring, i, reach);
        sum = vector_add(sum, vector_cross(last, next));
    }
    /* With s the rounding scale, a coordinate, of size 1, is off by s / 2 epsilons from rounding,
     * and its difference from the first by s and 1/2. A component of a cross product has 2 products
     * of 2 such: 4 s + 2 epsilons for each of n - 2 triangles, and 3 for its own roundings. */
    const double noise = (4 * rounding_scale(ring, n, reach) + 5) * DBL_EPSILON * n;
    return largest_component(sum) > noise ? vector_normalise(sum) : none;
}

/* The angle, 0..pi, of a sine that is not negative and its cosine. Our own, since the last bits of
 * atan2 differ between C libraries. Halved three times by tan(a/2) = tan a / (1 + sqrt(1 + tan^2)),
 * tan is below 0.2, and the first term of the series left out below 0.2^22/23 < 2^-53. */
static double angle_of(double sine, double cosine)
{
    const double pi = 3.14159265358979323846;
    const double half = sine / (1 + fabs(cosine));
    const double quarter = half / (1 + sqrt(1 + half * half));
    const double eighth = quarter / (1 + sqrt(1 + quarter * quarter)), square = eighth * eighth;
    double series = 1.0 / 21;

    for (int k = 19; k > 0; k -= 2)
        series = 1.0 / k - square * series;
    const double angle = 8 * eighth * series;
    return cosine < 0 ? pi - angle : angle;
}

double polygon_angle(const struct vector *ring, int n, int i, struct vector normal)
{
    const double turn = 2 * 3.14159265358979323846;
    const struct vector *at = &ring[i], *next = &ring[i + 1 < n ? i + 1 : 0];
    const struct vector *previous = &ring[i > 0 ? i - 1 : n - 1];
    const struct vector out = vector_normalise(vector_subtract(*next, *at));
    const struct vector back = vector_normalise(vector_subtract(*previous, *at));
    const struct vector across = vector_cross(out, back);
    const double angle = angle_of(sqrt(vector_dot(across, across)), vector_dot(out, back));

    return vector_dot(across, normal) < 0 ? turn - angle : angle;
}

/* ---- cutting ---- */

/* A corner of what is left of the polygon: a ring that shrinks ear by ear. */
struct cutter_node {
    double x, y; /* in the plane of the polygon, which is counter-clockwise there */
    int32_t previous, next;
    bool convex, listed, queued, cut; /* listed: among the blockers */
};

bool cutter_open(struct cutter *out, size_t corners, struct error *err)
{
    *out = (struct cutter){.n_triangles = 0};
    if (corners > SIZE_MAX / sizeof *out->nodes)
        return error_memory(err);
    out->nodes = malloc(corners * sizeof *out->nodes);
    out->queue = malloc(corners * sizeof *out->queue);
    out->blockers = malloc(corners * sizeof *out->blockers);
    out->triangles = malloc(corners * sizeof *out->triangles);
    if (out->nodes && out->queue && out->blockers && out->triangles)
        return true;
    cutter_free(out);
    return error_memory(err);
}

void cutter_free(struct cutter *cutter)
{
    free(cutter->nodes);
    free(cutter->queue);
    free(cutter->blockers);
    free(cutter->triangles);
    *cutter = (struct cutter){.n_triangles = 0};
}

static bool same_point(struct vector a, struct vector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static void add_triangle(struct cutter *cutter, const struct vector *ring, int a, int b, int c)
{
    if (same_point(ring[a], ring[b]) || same_point(ring[b], ring[c]) ||
        same_point(ring[c], ring[a]))
        return;
    int32_t *corner = cutter->triangles[cutter->n_triangles++];
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
}

/* Projects along the normal onto the coordinate plane that faces it most, mirrored where needed to
 * be counter-clockwise. With s the rounding scale, a relative coordinate is off by s + 1/2
 * epsilons; two of them and the projection's own roundings make 2 s + 3. */
static void flatten(struct cutter *cutter, const struct vector *ring, int n, struct vector normal)
{
    const double reach = ring_reach(ring, n), largest = largest_component(normal);

    cutter->noise = (2 * rounding_scale(ring, n, reach) + 3) * DBL_EPSILON;
    for (int i = 0; i < n; i++) {
        const struct vector p = relative(ring, i, reach);
        double x, y, towards;
        if (fabs(normal.z) == largest) {
            towards = normal.z;
            x = p.x * normal.z - p.z * normal.x;
            y = p.y * normal.z - p.z * normal.y;
        } else if (fabs(normal.y) == largest) {
            towards = normal.y;
            x = p.z * normal.y - p.y * normal.z;
            y = p.x * normal.y - p.y * normal.x;
        } else {
            towards = normal.x;
            x = p.y * normal.x - p.x * normal.y;
            y = p.z * normal.x - p.x * normal.z;
        }
        cutter->nodes[i] = (struct cutter_node){.x = towards > 0 ? x : y,
                                                .y = towards > 0 ? y : x,
                                                .previous = i > 0 ? i - 1 : n - 1,
                                                .next = i + 1 < n ? i + 1 : 0};
    }
}

/* Twice the signed area of a b c: positive where the way a b c turns left. 0 within rounding, which
 * moves each end of the two steps by the noise: a straight line must not turn by chance. */
static double turn(const struct cutter *cutter, const struct cutter_node *a,
                   const struct cutter_node *b, const struct cutter_node *c)
{
    const double x = b->x - a->x, y = b->y - a->y, next_x = c->x - b->x, next_y = c->y - b->y;
    const double left = x * next_y - y * next_x;
    const double length = fabs(x) + fabs(y) + fabs(next_x) + fabs(next_y);

    return fabs(left) > 2 * cutter->noise * length ? left : 0;
}

static double turn_at(const struct cutter *cutter, int i)
{
    const struct cutter_node *nodes = cutter->nodes;

    return turn(cutter, &nodes[nodes[i].previous], &nodes[i], &nodes[nodes[i].next]);
}

static bool turns_back(const struct cutter *cutter, int i)
{
    const struct cutter_node *nodes = cutter->nodes, *b = &nodes[i];
    const struct cutter_node *a = &nodes[b->previous], *c = &nodes[b->next];

    return (b->x - a->x) * (c->x - b->x) + (b->y - a->y) * (c->y - b->y) < 0;
}

/* Never turns right, never turns back, and goes round once: x grows and falls once. */
static bool is_convex(struct cutter *cutter, int n)
{
    struct cutter_node *nodes = cutter->nodes;
    int changes = 0, direction = 0, first = 0;

    for (int i = 0; i < n; i++) {
        const double step = nodes[nodes[i].next].x - nodes[i].x;
        const double left = turn_at(cutter, i);
        const int sign = (step > 0) - (step < 0);
        nodes[i].convex = left > 0;
        if (left < 0 || (left == 0 && turns_back(cutter, i)))
            return false;
        if (sign == 0)
            continue;
        changes += direction != 0 && sign != direction;
        if (first == 0)
            first = sign;
        direction = sign;
    }
    return changes + (first != direction) == 2;
}

/* A fan whose first corner lies between two true corners has no triangle without area, even where
 * other corners are straight. */
static bool cut_convex(struct cutter *cutter, const struct vector *ring, int n)
{
    struct cutter_node *nodes = cutter->nodes;

    if (!is_convex(cutter, n))
        return false;
    for (int i = 0; i < n; i++) {
        if (!nodes[nodes[i].previous].convex || !nodes[nodes[i].next].convex)
            continue;
        for (int b = nodes[i].next; nodes[b].next != i; b = nodes[b].next)
            add_triangle(cutter, ring, i, b, nodes[b].next);
        return true;
    }
    return false;
}

static bool coincide(const struct cutter_node *a, const struct cutter_node *b)
{
    return a->x == b->x && a->y == b->y;
}

/* p in the closed triangle a b c, though not at one of its corners. */
static bool is_inside(const struct cutter *cutter, const struct cutter_node *a,
                      const struct cutter_node *b, const struct cutter_node *c,
                      const struct cutter_node *p)
{
    return turn(cutter, a, b, p) >= 0 && turn(cutter, b, c, p) >= 0 &&
           turn(cutter, c, a, p) >= 0 && !coincide(p, a) && !coincide(p, b) && !coincide(p, c);
}

/* An ear is a left turn whose triangle holds no other corner; only a corner that does not turn left
 * need be looked at. A spike or a repeated place is one too: cutting it off loses nothing. Blockers
 * that became convex or were cut leave the list on the way. */
static bool is_ear(struct cutter *cutter, int *n_blockers, int i)
{
    struct cutter_node *nodes = cutter->nodes;
    const struct cutter_node *a = &nodes[nodes[i].previous], *b = &nodes[i];
    const struct cutter_node *c = &nodes[b->next];

    if (coincide(a, b) || coincide(b, c) || coincide(a, c))
        return true;
    if (!b->convex)
        return turn_at(cutter, i) == 0 && turns_back(cutter, i);
    const double left = fmin(a->x, fmin(b->x, c->x)), right = fmax(a->x, fmax(b->x, c->x));
    for (int k = 0; k < *n_blockers;) {
        struct cutter_node *p = &nodes[cutter->blockers[k]];
        if (p->cut || p->convex) {
            p->listed = false;
            cutter->blockers[k] = cutter->blockers[--*n_blockers];
            continue;
        }
        if (p->x >= left && p->x <= right && p != a && p != c && is_inside(cutter, a, b, c, p))
            return false;
        k++;
    }
    return true;
}

/* A ring buffer of corners to look at; `queued` keeps each in it at most once. */
struct queue {
    int first, n, room;
};

/* Looks at a corner's new turn and queues it: only its neighbours can make it an ear. */
static void refresh(struct cutter *cutter, struct queue *queue, int *n_blockers, int i)
{
    struct cutter_node *node = &cutter->nodes[i];

    node->convex = turn_at(cutter, i) > 0;
    if (!node->convex && !node->listed) {
        node->listed = true;
        cutter->blockers[(*n_blockers)++] = i;
    }
    if (!node->queued) {
        node->queued = true;
        cutter->queue[(queue->first + queue->n++) % queue->room] = i;
    }
}

/* An ear that is none stays none until a neighbour is cut, since what is left of the polygon only
 * shrinks; so each corner is looked at once, and again after each cut beside it: n + 2n times. */
static void cut_ears(struct cutter *cutter, const struct vector *ring, int n)
{
    struct cutter_node *nodes = cutter->nodes;
    struct queue queue = {0, 0, n};
    int n_blockers = 0, left = n, last = 0;

    for (int i = 0; i < n; i++)
        refresh(cutter, &queue, &n_blockers, i);
    while (left > 3 && queue.n > 0) {
        const int i = cutter->queue[queue.first];
        queue.first = (queue.first + 1) % n;
        queue.n--;
        nodes[i].queued = false;
        if (nodes[i].cut || !is_ear(cutter, &n_blockers, i))
            continue;
        const int a = nodes[i].previous, c = nodes[i].next;
        add_triangle(cutter, ring, a, i, c);
        nodes[i].cut = true;
        nodes[a].next = c;
        nodes[c].previous = a;
        left--;
        last = a;
        refresh(cutter, &queue, &n_blockers, a);
        refresh(cutter, &queue, &n_blockers, c);
    }
    for (int b = nodes[last].next; nodes[b].next != last; b = nodes[b].next)
        add_triangle(cutter, ring, last, b, nodes[b].next);
}

void cutter_run(struct cutter *cutter, const struct vector *ring, int n)
{
    const struct vector normal = n > 3 ? polygon_normal(ring, n) : (struct vector){0, 0, 0};

    cutter->n_triangles = 0;
    if (largest_component(normal) == 0) {
        for (int i = 1; i + 1 < n; i++)
            add_triangle(cutter, ring, 0, i, i + 1);
        return;
    }
    flatten(cutter, ring, n, normal);
    if (!cut_convex(cutter, ring, n))
        cut_ears(cutter, ring, n);
}
