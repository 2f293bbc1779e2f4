/* SPDX-License-Identifier: MIT */
/* Faces of any size: normals, angles, and cutting into triangles by ear clipping. Cutting never
 * fails and always ends. If the rest of a ring is no simple polygon, within rounding, it becomes a
 * fan. A list of the corners that may be ears, and a tree of boxes round those that may lie inside
 * of one, keep the time near n log n for n corners. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/polygon/polygon.h"

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

/* A corner of the rest of the polygon, a ring that shrinks ear by ear. */
struct cutter_node {
    double x, y; /* in the plane of the polygon, which is counter-clockwise there */
    int32_t previous, next;
    int32_t earlier, later; /* in the ring of candidates */
    bool convex, candidate; /* candidate: may be an ear */
};

/* Blockers are corners that do not turn left: only they can lie inside of an ear. The corners are
 * sorted along a curve that stays in a square until it has met all corners there, and cut into
 * groups. A tree has a box round each group, and round the boxes of two nodes. */
enum { GROUP = 8 };
struct box {
    double low_x, low_y, high_x, high_y;
    int32_t n; /* blockers inside */
};
struct blockers {
    struct sorted_corner {
        uint64_t x, y; /* integers, in the order of the coordinates */
        int32_t corner;
    } * sorted;
    int32_t *place;    /* of each corner among the sorted ones */
    bool *listed;      /* the corner is a blocker */
    struct box *boxes; /* the root is 1; below node k are 2 k and 2 k + 1 */
    int n, n_groups;   /* n_groups: a power of two; they are the nodes from n_groups on */
};

static int count_groups(int corners)
{
    int n = 1;
    while (n < (corners - 1) / GROUP + 1)
        n *= 2;
    return n;
}

bool cutter_open(struct cutter *out, int corners, struct error *err)
{
    const size_t n = (size_t)corners, n_boxes = 2 * (size_t)count_groups(corners);
    struct blockers *blockers = out->blockers = calloc(1, sizeof *out->blockers);

    if (!blockers)
        return error_memory(err);
    blockers->sorted = calloc(n, sizeof *blockers->sorted);
    blockers->place = calloc(n, sizeof *blockers->place);
    blockers->listed = calloc(n, sizeof *blockers->listed);
    blockers->boxes = calloc(n_boxes, sizeof *blockers->boxes);
    out->nodes = calloc(n, sizeof *out->nodes);
    out->triangles = calloc(n, sizeof *out->triangles);
    return (blockers->sorted && blockers->place && blockers->listed && blockers->boxes &&
            out->nodes && out->triangles) ||
           error_memory(err);
}

void cutter_free(struct cutter *cutter)
{
    if (cutter->blockers) {
        free(cutter->blockers->sorted);
        free(cutter->blockers->place);
        free(cutter->blockers->listed);
        free(cutter->blockers->boxes);
    }
    free(cutter->blockers);
    free(cutter->nodes);
    free(cutter->triangles);
    *cutter = (struct cutter){.n_triangles = 0};
}

static void add_triangle(struct cutter *cutter, const struct vector *ring, int a, int b, int c)
{
    const int32_t corner[3] = {a, b, c};

    if (!same_place(ring[a], ring[b]) && !same_place(ring[b], ring[c]) &&
        !same_place(ring[c], ring[a]))
        memcpy(cutter->triangles[cutter->n_triangles++], corner, sizeof corner);
}

/* Projects the ring along the normal onto the coordinate plane that faces it most, and mirrors it
 * if it would be clockwise. With s the rounding of the frame, a relative coordinate is off by s +
 * 1/2 epsilons; two of them and the roundings of the projection make 2 s + 3. */
static void flatten(struct cutter *cutter, const struct vector *ring, int n, struct vector normal)
{
    const double along[3] = {normal.x, normal.y, normal.z}, largest = vector_reach(normal);
    const int axis = fabs(normal.z) == largest ? 2 : fabs(normal.y) == largest;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    struct frame frame;

    frame_make(ring, n, &frame);
    cutter->noise = (2 * frame.rounding + 3) * DBL_EPSILON;
    for (int i = 0; i < n; i++) {
        const struct vector at = relative(&frame, ring[i]);
        const double p[3] = {at.x, at.y, at.z};
        const double x = p[u] * along[axis] - p[axis] * along[u];
        const double y = p[v] * along[axis] - p[axis] * along[v];
        const int32_t previous = i > 0 ? i - 1 : n - 1, next = i + 1 < n ? i + 1 : 0;
        cutter->nodes[i] = (struct cutter_node){.x = along[axis] > 0 ? x : y,
                                                .y = along[axis] > 0 ? y : x,
                                                .previous = previous,
                                                .next = next,
                                                .earlier = previous,
                                                .later = next,
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

/* ---- blockers ---- */

/* Coordinates lie between -2 and 2, as flatten() makes them. */
static uint64_t curve_coordinate(double at)
{
    return (uint64_t)((at + 2) * 0x1p61);
}

/* Compares places on the curve: that of the coordinate which differs in the highest bit decides. If
 * both differ there, x does. */
static int compare_places(const void *a, const void *b)
{
    const struct sorted_corner *p = a, *q = b;
    const uint64_t x = p->x ^ q->x, y = p->y ^ q->y;

    if (x < y && x < (x ^ y))
        return p->y < q->y ? -1 : 1;
    if (x != 0)
        return p->x < q->x ? -1 : 1;
    return (p->corner > q->corner) - (p->corner < q->corner);
}

static void sort_corners(const struct cutter *cutter, int n)
{
    struct blockers *blockers = cutter->blockers;

    for (int i = 0; i < n; i++)
        blockers->sorted[i] = (struct sorted_corner){curve_coordinate(cutter->nodes[i].x),
                                                     curve_coordinate(cutter->nodes[i].y), i};
    if (n > GROUP)
        qsort(blockers->sorted, (size_t)n, sizeof *blockers->sorted, compare_places);
    for (int i = 0; i < n; i++)
        blockers->place[blockers->sorted[i].corner] = i;
}

static void extend_box(struct box *box, const struct box *by)
{
    box->low_x = fmin(box->low_x, by->low_x);
    box->low_y = fmin(box->low_y, by->low_y);
    box->high_x = fmax(box->high_x, by->high_x);
    box->high_y = fmax(box->high_y, by->high_y);
}

/* Starts with no blockers. */
static void start_blockers(const struct cutter *cutter, int n)
{
    const struct box empty = {HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL, 0};
    struct blockers *blockers = cutter->blockers;

    blockers->n = n;
    blockers->n_groups = count_groups(n);
    sort_corners(cutter, n);
    for (int k = 0; k < 2 * blockers->n_groups; k++)
        blockers->boxes[k] = empty;
    for (int i = 0; i < n; i++) {
        const struct cutter_node *node = &cutter->nodes[i];
        const struct box place = {node->x, node->y, node->x, node->y, 0};
        extend_box(&blockers->boxes[blockers->n_groups + blockers->place[i] / GROUP], &place);
        blockers->listed[i] = false;
    }
    for (int k = 2 * blockers->n_groups - 1; k > 1; k--)
        extend_box(&blockers->boxes[k / 2], &blockers->boxes[k]);
}

/* Adds a corner to the blockers, or takes it out. */
static void list_blocker(struct blockers *blockers, int corner, bool listed)
{
    const int by = listed - blockers->listed[corner];

    blockers->listed[corner] = listed;
    for (int k = blockers->n_groups + blockers->place[corner] / GROUP; by != 0 && k > 0; k /= 2)
        blockers->boxes[k].n += by;
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* Returns whether the way from a by b to any place in the box certainly turns right. The next step
 * of this way that turns left most is that to one of the corners of the box. Roundings change
 * nothing: a rounded difference or product does not fall when its exact value grows. */
static bool is_right_of(const struct cutter *cutter, const struct cutter_node *a,
                        const struct cutter_node *b, const struct box *box)
{
    const double x = b->x - a->x, y = b->y - a->y;
    const double next_x = (y > 0 ? box->low_x : box->high_x) - b->x;
    const double next_y = (x > 0 ? box->high_y : box->low_y) - b->y;
    const double reach_x = larger(fabs(box->low_x - b->x), fabs(box->high_x - b->x));
    const double reach_y = larger(fabs(box->low_y - b->y), fabs(box->high_y - b->y));
    const double length = fabs(x) + fabs(y) + reach_x + reach_y;

    return x * next_y - y * next_x < -2 * cutter->noise * length;
}

/* A triangle that may be an ear. */
struct ear {
    const struct cutter_node *a, *b, *c;
    double left, right;
};

/* Returns whether no place in the box is inside the triangle. A box of one place may lie at a
 * corner, as where many corners of a polygon meet. */
static bool is_clear(const struct cutter *cutter, const struct ear *ear, const struct box *box)
{
    const struct cutter_node place = {.x = box->low_x, .y = box->low_y};

    if (box->high_x < ear->left || box->low_x > ear->right ||
        is_right_of(cutter, ear->a, ear->b, box) || is_right_of(cutter, ear->b, ear->c, box) ||
        is_right_of(cutter, ear->c, ear->a, box))
        return true;
    return box->low_x == box->high_x && box->low_y == box->high_y &&
           (coincide(&place, ear->a) || coincide(&place, ear->b) || coincide(&place, ear->c));
}

/* Returns whether a blocker of a group, or of the groups below a node, is inside the triangle. */
static bool is_blocked(const struct cutter *cutter, const struct ear *ear, int k)
{
    const struct blockers *blockers = cutter->blockers;
    const struct box *box = &blockers->boxes[k];

    if (box->n == 0 || is_clear(cutter, ear, box))
        return false;
    if (k < blockers->n_groups)
        return is_blocked(cutter, ear, 2 * k) || is_blocked(cutter, ear, 2 * k + 1);
    const int first = (k - blockers->n_groups) * GROUP;
    for (int i = first; i < first + GROUP && i < blockers->n; i++) {
        const int corner = blockers->sorted[i].corner;
        const struct cutter_node *p = &cutter->nodes[corner];
        if (blockers->listed[corner] && p->x >= ear->left && p->x <= ear->right && p != ear->a &&
            p != ear->c && is_inside(cutter, ear->a, ear->b, ear->c, p))
            return true;
    }
    return false;
}

/* ---- ears ---- */

/* An ear is a left turn whose triangle contains no other corner. A spike or a repeated place is an
 * ear, too: it has no area to lose. */
static bool is_ear(const struct cutter *cutter, const struct cutter_node *b)
{
    const struct cutter_node *a = &cutter->nodes[b->previous], *c = &cutter->nodes[b->next];

    if (coincide(a, b) || coincide(b, c) || coincide(a, c))
        return true;
    if (!b->convex)
        return turn(cutter, a, b, c) == 0 &&
               (b->x - a->x) * (c->x - b->x) + (b->y - a->y) * (c->y - b->y) < 0;
    const struct ear ear = {a, b, c, fmin(a->x, fmin(b->x, c->x)), fmax(a->x, fmax(b->x, c->x))};
    return !is_blocked(cutter, &ear, 1);
}

/* Puts a corner between two neighbours in the ring of candidates, unless it is a candidate. */
static void add_candidate(struct cutter_node *nodes, int corner, int earlier, int later)
{
    if (nodes[corner].candidate)
        return;
    nodes[corner].candidate = true;
    nodes[corner].earlier = earlier;
    nodes[corner].later = later;
    nodes[earlier].later = nodes[later].earlier = corner;
}

static void remove_candidate(struct cutter_node *nodes, int corner)
{
    struct cutter_node *node = &nodes[corner];

    node->candidate = false;
    nodes[node->earlier].later = node->later;
    nodes[node->later].earlier = node->earlier;
}

/* Sees how a corner turns. */
static void refresh(const struct cutter *cutter, int i)
{
    struct cutter_node *node = &cutter->nodes[i];

    node->convex =
        turn(cutter, &cutter->nodes[node->previous], node, &cutter->nodes[node->next]) > 0;
    list_blocker(cutter->blockers, i, !node->convex);
}

/* Cuts an ear off. Its neighbours turn otherwise then, and may be ears now. */
static void cut_ear(struct cutter *cutter, int ear)
{
    struct cutter_node *nodes = cutter->nodes;
    const int a = nodes[ear].previous, c = nodes[ear].next;

    nodes[a].next = c;
    nodes[c].previous = a;
    add_candidate(nodes, a, nodes[ear].earlier, ear);
    add_candidate(nodes, c, ear, nodes[ear].later);
    list_blocker(cutter->blockers, ear, false);
    refresh(cutter, a);
    refresh(cutter, c);
}

/* Walks round the ring and cuts all ears. A corner that is no ear cannot become one until a
 * neighbour is cut, since the polygon only shrinks, and so is no candidate until then. So it tests
 * at most n + 2n corners. A convex polygon becomes a fan. */
static void cut_ears(struct cutter *cutter, const struct vector *ring, int n)
{
    struct cutter_node *nodes = cutter->nodes;
    int i = 1, behind_cut = 1, left = n;

    start_blockers(cutter, n);
    for (int k = 0; k < n; k++)
        refresh(cutter, k);
    while (left > 3 && nodes[i].candidate) {
        const int c = nodes[i].next, later = nodes[i].later;
        const bool cut = is_ear(cutter, &nodes[i]);
        if (cut) {
            add_triangle(cutter, ring, nodes[i].previous, i, c);
            cut_ear(cutter, i);
            behind_cut = c;
            left--;
        }
        remove_candidate(nodes, i);
        i = cut ? c : later;
    }
    i = behind_cut;
    const int first = nodes[i].previous;
    for (; nodes[i].next != first; i = nodes[i].next)
        add_triangle(cutter, ring, first, i, nodes[i].next);
}

void cutter_run(struct cutter *cutter, const struct vector *ring, int n)
{
    const struct vector normal = n > 3 ? polygon_normal(ring, n) : (struct vector){0, 0, 0};

    cutter->n_triangles = 0;
    if (vector_reach(normal) > 0) {
        flatten(cutter, ring, n, normal);
        cut_ears(cutter, ring, n);
        return;
    }
    for (int i = 1; i + 1 < n; i++)
        add_triangle(cutter, ring, 0, i, i + 1);
}
