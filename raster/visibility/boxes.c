/* SPDX-License-Identifier: MIT */
/* A tree of boxes around the triangles that cast shadows (Rubin and Whitted 1980). It decides only
 * which triangles are asked: boxes are wider than what they hold. */
#include <math.h>
#include <stdlib.h>

#include "raster/visibility/inside.h"

enum { DEEPEST = 64 };

struct vector occluder_corner(const struct occluders *of, struct occluder at, int i)
{
    const struct instance *instance = of->surfaces[at.surface].instance;
    return of->vertices[at.surface][instance->triangles[at.triangle][i]];
}

/* Returns a node with some occluders. Its box is wider than they are: by the error of a segment's
 * points, which are sums of places. */
static struct box_node node_of(const struct occluders *of, int first, int n)
{
    struct vector low = occluder_corner(of, of->list[first], 0), high = low;
    for (int i = 3 * first; i < 3 * (first + n); i++) {
        const struct vector at = occluder_corner(of, of->list[i / 3], i % 3);
        low = vector_least(low, at);
        high = vector_greatest(high, at);
    }
    const double by = PLACE_ERROR * of->size;
    return (struct box_node){
        {high.x + by, high.y + by, high.z + by, low.x - by, low.y - by, low.z - by}, first, n};
}

/* Puts those occluders of a node whose middles lie below the middle of the longest side of its box
 * before the others. Returns how many they are. */
static int part(struct occluders *of, const struct box_node *at)
{
    const double *high = at->side, *low = high + 3, x = high[0] - low[0], y = high[1] - low[1],
                 z = high[2] - low[2];
    const struct vector axis = {x >= y && x >= z, y > x && y >= z, z > x && z > y},
                        ends = {low[0] + high[0], low[1] + high[1], low[2] + high[2]};
    struct occluder *list = of->list + at->first;
    int n_below = 0;
    for (int i = 0; i < at->n; i++) {
        const struct occluder moved = list[i];
        double sum = 0; /* three times the place of its middle */
        for (int k = 0; k < 3; k++)
            sum += vector_dot(axis, occluder_corner(of, moved, k));
        if (sum < 1.5 * vector_dot(axis, ends)) {
            list[i] = list[n_below];
            list[n_below++] = moved;
        }
    }
    return n_below;
}

/* Divides a node by space, where that leaves some occluders on each side and the tree is not deep;
 * otherwise by their number; until each has one. */
static void make_node(struct occluders *of, int node, int depth, int first, int n)
{
    struct box_node *at = &of->nodes[node];
    *at = node_of(of, first, n);
    if (n == 1)
        return;
    int half = depth < DEEPEST / 2 ? part(of, at) : 0;
    half = half == 0 || half == n ? n / 2 : half;
    at->first = of->n_nodes;
    at->n = 0;
    of->n_nodes += 2;
    make_node(of, at->first, depth + 1, first, half);
    make_node(of, at->first + 1, depth + 1, first + half, n - half);
}

bool occluders_make(const struct surface *surfaces, int n, const bool *casts, double size,
                    struct occluders *out)
{
    size_t n_triangles = 0;
    *out = (struct occluders){.surfaces = surfaces, .n_surfaces = n, .size = size};
    out->vertices = calloc((size_t)n + 1, sizeof(struct vector *));
    for (int i = 0; i < n && out->vertices; i++) {
        const struct instance *instance = surfaces[i].instance;
        if (!casts[i])
            continue;
        n_triangles += (size_t)instance->n_triangles;
        out->vertices[i] = malloc(((size_t)instance->n_vertices + 1) * sizeof *out->vertices[i]);
        if (!out->vertices[i])
            return false;
        for (int v = 0; v < instance->n_vertices; v++)
            out->vertices[i][v] =
                matrix_point(&instance->model_view, instance->vertices[v].position);
    }
    out->list = malloc((n_triangles + 1) * sizeof *out->list);
    out->nodes = malloc((2 * n_triangles + 1) * sizeof *out->nodes);
    if (!out->vertices || !out->list || !out->nodes || n_triangles > INT32_MAX / 2)
        return false;
    for (int i = 0; i < n; i++)
        for (int t = 0; casts[i] && t < surfaces[i].instance->n_triangles; t++)
            out->list[out->n++] = (struct occluder){i, t};
    out->n_nodes = 1;
    if (out->n > 0)
        make_node(out, 0, 0, 0, out->n);
    return true;
}

void occluders_free(struct occluders *occluders)
{
    for (int i = 0; occluders->vertices && i < occluders->n_surfaces; i++)
        free(occluders->vertices[i]);
    free(occluders->vertices);
    free(occluders->list);
    free(occluders->nodes);
    *occluders = (struct occluders){.n = 0};
}

/* ---- segments ---- */

/* Segments from the points of a box to one end. Each component of a segment lies between those of
 * two, from the lowest and from the highest point. */
struct shaft {
    double from[6], once[6]; /* lowest x, y, z, then highest; 1 / way */
    double end;              /* the part of the way where the end is */
};

static struct shaft shaft_of(struct vector low, struct vector high, const struct homogeneous *to)
{
    struct shaft out = {{low.x, low.y, low.z, high.x, high.y, high.z},
                        .end = to->infinite ? HUGE_VAL : 1};
    const double end[3] = {to->at.x, to->at.y, to->at.z};
    for (int i = 0; i < 6; i++) {
        const double way = end[i % 3] - (to->infinite ? 0 : out.from[i]);
        /* 0, or nearly so, becomes so small that no box notices */
        out.once[i] = 1 / (fabs(way) > 0x1p-500 ? way : 0x1p-500);
    }
    return out;
}

/* Returns whether a segment may meet a box (Kay and Kajiya 1986): at some part of their ways the
 * lowest is not above it, nor the highest below it. */
static bool meets(const struct box_node *box, const struct shaft *of)
{
    double enter = 0, leave = of->end;
    for (int i = 0; i < 6; i++) {
        const double at = (box->side[i] - of->from[i]) * of->once[i];
        if ((of->once[i] > 0) == (i < 3))
            leave = at < leave ? at : leave;
        else
            enter = at > enter ? at : enter;
    }
    return enter <= leave;
}

void occluders_along(const struct occluders *of, struct seen_point *const points[], int n_points,
                     const struct homogeneous *to, occluder_visitor *visit, void *context)
{
    struct shaft each[TOGETHER];
    struct vector low = points[0]->eye.at, high = low;
    for (int i = 0; i < n_points; i++) {
        each[i] = shaft_of(points[i]->eye.at, points[i]->eye.at, to);
        low = vector_least(points[i]->eye.at, low); /* NaN leaves it as it is */
        high = vector_greatest(points[i]->eye.at, high);
    }
    const struct shaft all = shaft_of(low, high, to);
    int32_t waiting[DEEPEST] = {0}, n = of->n > 0;
    while (n > 0) {
        const struct box_node *node = &of->nodes[waiting[--n]];
        if (!meets(node, &all))
            continue;
        for (int32_t i = 0; i < 2 && node->n == 0; i++)
            waiting[n++] = node->first + i;
        uint32_t met = 0;
        for (int i = 0; i < n_points && node->n > 0; i++)
            met |= (uint32_t)meets(node, &each[i]) << i;
        if (met != 0 && !visit(context, &of->list[node->first], met))
            return;
    }
}
