/* SPDX-License-Identifier: MIT */
/* Computes the normals that an OBJ file lacks: means of the faces at a point, as far as no crease
 * divides them. At most points few faces meet, and each is compared with all others there. Where
 * many meet, as at the tip of a cone, a tree finds the neighbours of a face without a look at each.
 */
#include "data/mesh/inside.h"

/* The corners at a point. */
struct meeting {
    const struct obj_corner *corners;
    const int32_t *at; /* their numbers, in increasing order */
    int n;
    double cosine;      /* two faces are smooth neighbours if that of their angle exceeds it */
    double half_cosine; /* of half that angle */
    const struct crowd *crowd; /* of many faces that are not smooth; NULL: none */
};

static const struct obj_corner *corner_at(const struct meeting *meeting, int i)
{
    return &meeting->corners[meeting->at[i]];
}

static struct vector weighted_normal(const struct obj_corner *corner)
{
    return vector_scale(corner->normal, corner->angle);
}

/* ---- many faces at a point ---- */

/* From so many corners on, a tree finds the neighbours. */
enum { CROWD = 256, GROUP = 8 };

/* Corners, sorted by their normals, and cut into groups. A tree has the sum of each group, and of
 * each pair of nodes. */
struct crowd {
    struct sorted_normal {
        uint64_t place; /* on a curve that stays in a cube until it has met all normals there */
        int32_t corner;
    } * sorted;
    struct crowd_node {
        struct vector low, high, sum; /* of the normals, and of them weighted */
    } * nodes;                        /* the root is 1; below node k are 2 k and 2 k + 1 */
    int n, n_groups;                  /* n_groups: a power of two */
};

/* Takes 21 bits of each coordinate in turn, the highest first. */
static uint64_t curve_place(struct vector normal)
{
    const uint64_t part[3] = {(uint64_t)((normal.x + 2) * 0x1p19),
                              (uint64_t)((normal.y + 2) * 0x1p19),
                              (uint64_t)((normal.z + 2) * 0x1p19)};
    uint64_t place = 0;
    for (int bit = 20; bit >= 0; bit--)
        for (int i = 0; i < 3; i++)
            place = place << 1 | (part[i] >> bit & 1);
    return place;
}

static int compare_normals(const void *a, const void *b)
{
    const struct sorted_normal *p = a, *q = b;
    if (p->place != q->place)
        return p->place < q->place ? -1 : 1;
    return (p->corner > q->corner) - (p->corner < q->corner);
}

static void extend_node(struct crowd_node *node, const struct crowd_node *by)
{
    node->low = vector_least(node->low, by->low);
    node->high = vector_greatest(node->high, by->high);
    node->sum = vector_add(node->sum, by->sum);
}

static void fill_nodes(const struct meeting *meeting, struct crowd *crowd)
{
    const struct vector far = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    for (int k = 0; k < 2 * crowd->n_groups; k++)
        crowd->nodes[k] = (struct crowd_node){.low = far, .high = vector_scale(far, -1)};
    for (int i = 0; i < crowd->n; i++) {
        const struct obj_corner *corner = &meeting->corners[crowd->sorted[i].corner];
        const struct crowd_node one = {corner->normal, corner->normal, weighted_normal(corner)};
        extend_node(&crowd->nodes[crowd->n_groups + i / GROUP], &one);
    }
    for (int k = 2 * crowd->n_groups - 1; k > 1; k--)
        extend_node(&crowd->nodes[k / 2], &crowd->nodes[k]);
}

/* Leaves out faces without area, which have no weight. */
static bool crowd_make(const struct meeting *meeting, struct crowd *out, struct error *err)
{
    *out = (struct crowd){.n_groups = 1};
    while (out->n_groups < meeting->n / GROUP + 1)
        out->n_groups *= 2;
    if (!MAKE_ARRAY(out->sorted, meeting->n, err, "the normals of a point") ||
        !MAKE_ARRAY(out->nodes, 2 * (size_t)out->n_groups, err, "the normals of a point"))
        return false;
    for (int i = 0; i < meeting->n; i++)
        if (corner_at(meeting, i)->angle > 0)
            out->sorted[out->n++] =
                (struct sorted_normal){curve_place(corner_at(meeting, i)->normal), meeting->at[i]};
    qsort(out->sorted, (size_t)out->n, sizeof *out->sorted, compare_normals);
    fill_nodes(meeting, out);
    return true;
}

/* Returns the largest product of a normal with any in the node; with -1 as `side`, the smallest. No
 * rounded product of a normal in the node is beyond it. */
static double farthest_dot(const struct crowd_node *node, struct vector with, double side)
{
    const struct vector end = {side * with.x > 0 ? node->high.x : node->low.x,
                               side * with.y > 0 ? node->high.y : node->low.y,
                               side * with.z > 0 ? node->high.z : node->low.z};
    return vector_dot(end, with);
}

/* Adds the normals below a node that are smooth neighbours of a normal. */
static void add_neighbours(const struct meeting *meeting, struct vector normal, int k,
                           struct vector *sum)
{
    const struct crowd *crowd = meeting->crowd;
    const struct crowd_node *node = &crowd->nodes[k];
    if (!(farthest_dot(node, normal, 1) > meeting->cosine))
        return;
    if (farthest_dot(node, normal, -1) > meeting->cosine) {
        *sum = vector_add(*sum, node->sum);
        return;
    }
    if (k < crowd->n_groups) {
        add_neighbours(meeting, normal, 2 * k, sum);
        add_neighbours(meeting, normal, 2 * k + 1, sum);
        return;
    }
    const int first = (k - crowd->n_groups) * GROUP;
    for (int i = first; i < first + GROUP && i < crowd->n; i++) {
        const struct obj_corner *other = &meeting->corners[crowd->sorted[i].corner];
        if (vector_dot(other->normal, normal) > meeting->cosine)
            *sum = vector_add(*sum, weighted_normal(other));
    }
}

/* ---- means ---- */

/* Returns the mean normal of all faces at the point; 0 0 0 if no face there has an area. *smooth
 * means that all lie within half the crease angle of the mean, so that any two are neighbours. */
static struct vector whole_average(const struct meeting *meeting, bool *smooth)
{
    struct vector sum = {0, 0, 0};
    for (int i = 0; i < meeting->n; i++)
        sum = vector_add(sum, weighted_normal(corner_at(meeting, i)));
    sum = vector_normalise(sum);
    *smooth = true;
    for (int i = 0; *smooth && i < meeting->n; i++) {
        const struct obj_corner *corner = corner_at(meeting, i);
        *smooth = corner->angle == 0 || vector_dot(corner->normal, sum) > meeting->half_cosine;
    }
    return sum;
}

/* Returns the mean normal of the faces that are smooth neighbours of the face of corner i. The
 * corners of a face follow each other. */
static struct vector crease_average(const struct meeting *meeting, int i)
{
    const struct obj_corner *own = corner_at(meeting, i);
    const bool alone = !(vector_dot(own->normal, own->normal) > meeting->cosine);
    struct vector sum = {0, 0, 0};
    if (meeting->crowd)
        add_neighbours(meeting, own->normal, 1, &sum);
    while (meeting->crowd && alone && i > 0 && corner_at(meeting, i - 1)->face == own->face)
        i--;
    for (; meeting->crowd && alone && i < meeting->n && corner_at(meeting, i)->face == own->face;
         i++)
        sum = vector_add(sum, weighted_normal(corner_at(meeting, i)));
    for (int k = 0; !meeting->crowd && k < meeting->n; k++) {
        const struct obj_corner *other = corner_at(meeting, k);
        if (other->face == own->face || vector_dot(other->normal, own->normal) > meeting->cosine)
            sum = vector_add(sum, weighted_normal(other));
    }
    sum = vector_normalise(sum);
    return vector_dot(sum, sum) > 0 ? sum : own->normal;
}

/* ---- the normals of a point ---- */

/* Finds the normal among those of the point, in the list from `first` on, or adds it: equal normals
 * are stored once. places: finds many of them; NULL: they are few. */
static bool store_normal(struct obj_list *list, int first, struct index *places,
                         struct vector normal, int32_t *out, struct error *err)
{
    const struct vector key = vector_add(normal, (struct vector){0, 0, 0}); /* -0 becomes 0 */
    *out = places ? index_find(places, &key, sizeof key) : first;
    while (!places && *out < list->n && !same_place(list->at[*out], normal))
        ++*out;
    if (*out >= 0 && *out < list->n)
        return true;
    *out = list->n;
    return (!places || index_add(places, &key, sizeof key, *out, err)) &&
           array_add(&list->at, &list->n, &normal, sizeof normal, err);
}

/* Sets the normals that corners of the point lack. */
static bool fill_point(struct obj *obj, struct meeting *meeting, struct error *err)
{
    struct obj_list *list = &obj->list[OBJ_NORMAL];
    const bool many = meeting->n >= CROWD;
    const int first = list->n;
    struct index places = {0};
    struct crowd crowd = {.sorted = NULL};
    bool smooth;
    struct vector average = whole_average(meeting, &smooth);
    if (vector_dot(average, average) == 0)
        average.z = 1;
    meeting->crowd = !smooth && many ? &crowd : NULL;
    bool done = !meeting->crowd || crowd_make(meeting, &crowd, err);
    for (int i = 0; done && i < meeting->n; i++) {
        struct obj_corner *corner = &obj->corners[meeting->at[i]];
        if (corner->index[OBJ_NORMAL] < 0)
            done = store_normal(list, first, many ? &places : NULL,
                                smooth || corner->angle == 0 ? average : crease_average(meeting, i),
                                &corner->index[OBJ_NORMAL], err);
    }
    FREE_ALL(crowd.sorted, crowd.nodes);
    index_free(&places);
    return done;
}

/* Rounding must not decide whether faces that meet at the crease angle itself are neighbours. Most
 * files have coordinates of six significant digits. A face of a thirtieth of the model's size may
 * then lean by 1.5e-5 radians, or 0.001 degrees. Neighbours must meet at so much less. */
bool normals_fill(struct obj *obj, const int32_t *order, const int32_t *starts, double crease_deg,
                  struct error *err)
{
    const double slack_deg = 0.001;
    struct meeting meeting = {.corners = obj->corners};
    double sine;
    sine_cosine(fmax(crease_deg - slack_deg, 0), &sine, &meeting.cosine);
    meeting.half_cosine = sqrt((1 + meeting.cosine) / 2);
    for (int point = 0; point < obj->list[OBJ_POINT].n; point++) {
        meeting.at = order + starts[point];
        meeting.n = starts[point + 1] - starts[point];
        if (!fill_point(obj, &meeting, err))
            return false;
    }
    return true;
}
