/* SPDX-License-Identifier: MIT */
/* Faces: normals, angles, and cutting into triangles by ear clipping. Cutting never fails and
 * always ends. If the rest of a ring is no simple polygon, within rounding, it becomes a fan. The
 * time is at most proportional to the square of the number of corners. */
#include <float.h>

#include "data/mesh/inside.h"

bool same_place(struct vector a, struct vector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* Coordinates of a ring relative to its first corner, in units of its reach. Their products neither
 * overflow nor underflow, whatever the scale of the model. */
struct frame {
    struct vector origin;
    double reach;    /* the largest distance from the first corner along an axis, rounded up to a
                        power of two: division by it is exact, so straight corners stay straight */
    double rounding; /* the largest coordinate of the ring, in units of the reach: a relative one is
                        off by so many epsilons, since the ring's own were rounded */
};

/* Returns false if all corners are at one place. */
static bool frame_make(const struct vector *ring, int n, struct frame *out)
{
    double reach = 0, largest = 0;
    int exponent;

    for (int i = 0; i < n; i++) {
        reach = fmax(reach, vector_reach(vector_subtract(ring[i], ring[0])));
        largest = fmax(largest, vector_reach(ring[i]));
    }
    frexp(reach, &exponent);
    out->origin = ring[0];
    out->reach = ldexp(1, exponent);
    out->rounding = largest / out->reach;
    return reach > 0;
}

static struct vector relative(const struct frame *frame, struct vector place)
{
    const struct vector from = vector_subtract(place, frame->origin);

    return (struct vector){from.x / frame->reach, from.y / frame->reach, from.z / frame->reach};
}

struct vector polygon_normal(const struct vector *ring, int n)
{
    const struct vector none = {0, 0, 0};
    struct vector sum = none, last = none, next;
    struct frame frame;

    if (!frame_make(ring, n, &frame))
        return none;
    for (int i = 1; i < n; i++, last = next) {
        next = relative(&frame, ring[i]);
        sum = vector_add(sum, vector_cross(last, next));
    }
    /* With s the rounding of the frame, a coordinate is off by s / 2 epsilons, and its difference
     * from the first one, of size 1, by s + 1/2. A component of a cross product has 2 products of 2
     * such differences: 4 s + 2 epsilons for each of n - 2 triangles, and 3 for its own roundings.
     */
    const double noise = (4 * frame.rounding + 5) * DBL_EPSILON * n;
    return vector_reach(sum) > noise ? vector_normalise(sum) : none;
}

double polygon_angle(const struct vector *ring, int n, int i, struct vector normal)
{
    const struct vector *at = &ring[i], *next = &ring[i + 1 < n ? i + 1 : 0];
    const struct vector *previous = &ring[i > 0 ? i - 1 : n - 1];
    const struct vector out = vector_normalise(vector_subtract(*next, *at));
    const struct vector back = vector_normalise(vector_subtract(*previous, *at));
    const struct vector across = vector_cross(out, back);
    const double angle = angle_of(sqrt(vector_dot(across, across)), vector_dot(out, back));

    return vector_dot(across, normal) < 0 ? 2 * PI - angle : angle;
}

/* ---- cutting ---- */

static void add_triangle(struct cutter *cutter, int a, int b, int c)
{
    const struct vector *ring = cutter->ring;
    const int32_t corner[3] = {a, b, c};

    if (!same_place(ring[a], ring[b]) && !same_place(ring[b], ring[c]) &&
        !same_place(ring[c], ring[a]))
        memcpy(cutter->triangles[cutter->n_triangles++], corner, sizeof corner);
}

/* Projects the ring along the normal onto the coordinate plane that faces it most, and mirrors it
 * if it would be clockwise. With s the rounding of the frame, a relative coordinate is off by s +
 * 1/2 epsilons; two of them and the roundings of the projection make 2 s + 3. */
static void flatten(struct cutter *cutter, int n, struct vector normal)
{
    const double along[3] = {normal.x, normal.y, normal.z}, largest = vector_reach(normal);
    const int axis = fabs(normal.z) == largest ? 2 : fabs(normal.y) == largest;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    struct frame frame;

    frame_make(cutter->ring, n, &frame);
    cutter->noise = (2 * frame.rounding + 3) * DBL_EPSILON;
    for (int i = 0; i < n; i++) {
        const struct vector at = relative(&frame, cutter->ring[i]);
        const double p[3] = {at.x, at.y, at.z};
        const double x = p[u] * along[axis] - p[axis] * along[u];
        const double y = p[v] * along[axis] - p[axis] * along[v];
        cutter->nodes[i] = (struct cutter_node){.x = along[axis] > 0 ? x : y,
                                                .y = along[axis] > 0 ? y : x,
                                                .previous = i > 0 ? i - 1 : n - 1,
                                                .next = i + 1 < n ? i + 1 : 0,
                                                .candidate = true};
    }
}

/* Returns twice the signed area of a b c, positive if the way from a by b to c turns left. Returns
 * 0 within rounding, which moves each end of the two steps by the noise: a straight line must not
 * turn. */
static double turn(const struct cutter *cutter, const struct cutter_node *a,
                   const struct cutter_node *b, const struct cutter_node *c)
{
    const double x = b->x - a->x, y = b->y - a->y, next_x = c->x - b->x, next_y = c->y - b->y;
    const double left = x * next_y - y * next_x;
    const double length = fabs(x) + fabs(y) + fabs(next_x) + fabs(next_y);

    return fabs(left) > 2 * cutter->noise * length ? left : 0;
}

static bool coincide(const struct cutter_node *a, const struct cutter_node *b)
{
    return a->x == b->x && a->y == b->y;
}

/* Returns whether p is in the closed triangle a b c, but not at one of its corners. */
static bool is_inside(const struct cutter *cutter, const struct cutter_node *a,
                      const struct cutter_node *b, const struct cutter_node *c,
                      const struct cutter_node *p)
{
    return turn(cutter, a, b, p) >= 0 && turn(cutter, b, c, p) >= 0 && turn(cutter, c, a, p) >= 0 &&
           !coincide(p, a) && !coincide(p, b) && !coincide(p, c);
}

/* An ear is a left turn whose triangle contains no other corner; only corners that do not turn left
 * can lie inside. A spike or a repeated place is an ear, too: it has no area to lose. */
static bool is_ear(const struct cutter *cutter, const struct cutter_node *b)
{
    const struct cutter_node *nodes = cutter->nodes, *a = &nodes[b->previous], *c = &nodes[b->next];
    const double low = fmin(a->x, fmin(b->x, c->x)), high = fmax(a->x, fmax(b->x, c->x));

    if (coincide(a, b) || coincide(b, c) || coincide(a, c))
        return true;
    if (!b->convex)
        return turn(cutter, a, b, c) == 0 &&
               (b->x - a->x) * (c->x - b->x) + (b->y - a->y) * (c->y - b->y) < 0;
    for (const struct cutter_node *p = &nodes[c->next]; p != a; p = &nodes[p->next])
        if (!p->convex && p->x >= low && p->x <= high && is_inside(cutter, a, b, c, p))
            return false;
    return true;
}

/* Sees how a corner turns. */
static void refresh(const struct cutter *cutter, struct cutter_node *node)
{
    node->candidate = true;
    node->convex =
        turn(cutter, &cutter->nodes[node->previous], node, &cutter->nodes[node->next]) > 0;
}

/* Cuts an ear off. Its neighbours turn otherwise then, and may be ears now. */
static void cut_ear(struct cutter *cutter, int ear)
{
    struct cutter_node *nodes = cutter->nodes;
    const int a = nodes[ear].previous, c = nodes[ear].next;

    add_triangle(cutter, a, ear, c);
    nodes[a].next = c;
    nodes[c].previous = a;
    refresh(cutter, &nodes[a]);
    refresh(cutter, &nodes[c]);
}

/* Walks round the ring and cuts all ears. A corner that is no ear cannot become one until a
 * neighbour is cut, since the polygon only shrinks, and so is no candidate until then. So it tests
 * at most n + 2n corners. A convex polygon becomes a fan. */
static void cut_ears(struct cutter *cutter, int n)
{
    struct cutter_node *nodes = cutter->nodes;
    int i = 1, behind_cut = 1, left = n;

    for (int k = 0; k < n; k++)
        refresh(cutter, &nodes[k]);
    for (int passed = 0; left > 3 && passed < left; i = nodes[i].next, passed++) {
        const bool cut = nodes[i].candidate && is_ear(cutter, &nodes[i]);
        nodes[i].candidate = false;
        if (cut) {
            cut_ear(cutter, i);
            behind_cut = nodes[i].next;
            left--;
            passed = -1;
        }
    }
    i = behind_cut;
    const int first = nodes[i].previous;
    for (; nodes[i].next != first; i = nodes[i].next)
        add_triangle(cutter, first, i, nodes[i].next);
}

void cutter_run(struct cutter *cutter, int n)
{
    const struct vector normal = n > 3 ? polygon_normal(cutter->ring, n) : (struct vector){0, 0, 0};

    cutter->n_triangles = 0;
    if (vector_reach(normal) > 0) {
        flatten(cutter, n, normal);
        cut_ears(cutter, n);
        return;
    }
    for (int i = 1; i + 1 < n; i++)
        add_triangle(cutter, 0, i, i + 1);
}
