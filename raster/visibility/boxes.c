/* SPDX-License-Identifier: MIT */
/* A tree of boxes around the triangles that cast shadows (Rubin and Whitted 1980). It decides only
 * which triangles are asked: boxes are wider than what they hold. */
#include <math.h>
#include <stdlib.h>

#include "raster/visibility/inside.h"

enum { LEAF = 4, DEEPEST = 64 };

static const struct vector *corner_of(const struct occluders *of, const struct occluder *at, int i)
{
    return &of->vertices[at->surface]
                        [of->surfaces[at->surface].instance->triangles[at->triangle][i]];
}

/* The box of some occluders, wider than they are: by the error of a segment's points, which are
 * sums of places. */
static struct box box_of(const struct occluders *of, int first, int n)
{
    struct vector low = *corner_of(of, &of->list[first], 0), high = low;
    for (int i = 3 * first; i < 3 * (first + n); i++) {
        const struct vector at = *corner_of(of, &of->list[i / 3], i % 3);
        low = vector_least(low, at);
        high = vector_greatest(high, at);
    }
    const double by = PLACE_ERROR * of->size;
    return (struct box){{low.x - by, low.y - by, low.z - by},
                        {high.x + by, high.y + by, high.z + by}};
}

/* Three times the place of a triangle's middle along an axis. */
static double middle_of(const struct occluders *of, int number, struct vector axis)
{
    double sum = 0;
    for (int i = 0; i < 3; i++)
        sum += vector_dot(axis, *corner_of(of, &of->list[number], i));
    return sum;
}

/* Puts those of n occluders whose middles lie below the middle of the longest side of their box
 * before the others. Returns how many they are. */
static int part(struct occluders *of, const struct box *box, int first, int n)
{
    const double *low = box->low, *high = box->high, x = high[0] - low[0], y = high[1] - low[1],
                 z = high[2] - low[2];
    const struct vector axis = {x >= y && x >= z, y > x && y >= z, z > x && z > y},
                        ends = {low[0] + high[0], low[1] + high[1], low[2] + high[2]};
    const double middle = 1.5 * vector_dot(axis, ends);
    int n_below = 0;
    for (int i = first; i < first + n; i++)
        if (middle_of(of, i, axis) < middle) {
            const struct occluder below = of->list[i];
            of->list[i] = of->list[first + n_below];
            of->list[first + n_below++] = below;
        }
    return n_below;
}

/* Divides a node by space, where that leaves some occluders on each side and the tree is not deep;
 * otherwise by their number. */
static void make_node(struct occluders *of, int node, int depth, int first, int n)
{
    struct box_node *at = &of->nodes[node];
    *at = (struct box_node){.box = box_of(of, first, n), .first = first, .n = n};
    if (n <= LEAF)
        return;
    int half = depth < DEEPEST / 2 ? part(of, &at->box, first, n) : 0;
    half = half == 0 || half == n ? n / 2 : half;
    at->first = of->n_nodes;
    at->n = 0;
    of->n_nodes += 2;
    make_node(of, at->first, depth + 1, first, half);
    make_node(of, at->first + 1, depth + 1, first + half, n - half);
}

static bool place_vertices(struct occluders *out, int surface)
{
    const struct instance *instance = out->surfaces[surface].instance;
    struct vector *vertices = malloc(((size_t)instance->n_vertices + 1) * sizeof *vertices);
    out->vertices[surface] = vertices;
    for (int i = 0; vertices && i < instance->n_vertices; i++)
        vertices[i] = matrix_point(&instance->model_view, instance->vertices[i].position);
    return vertices != NULL;
}

bool occluders_make(const struct surface *surfaces, int n, const bool *casts, double size,
                    struct occluders *out)
{
    size_t n_triangles = 0;
    *out = (struct occluders){.surfaces = surfaces, .n_surfaces = n, .size = size};
    out->vertices = calloc((size_t)n + 1, sizeof(struct vector *));
    for (int i = 0; i < n && out->vertices; i++) {
        n_triangles += casts[i] ? (size_t)surfaces[i].instance->n_triangles : 0;
        if (casts[i] && !place_vertices(out, i))
            return false;
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

/* ---- a segment ---- */

/* Returns whether the points from + t along, t from 0 to `end`, meet a box (Kay and Kajiya 1986).
 * once: 1 / along. */
static bool meets(const struct box *box, const double from[3], const double once[3], double end)
{
    double enter = 0, leave = end;
    for (int i = 0; i < 3; i++) {
        const double a = (box->low[i] - from[i]) * once[i], b = (box->high[i] - from[i]) * once[i],
                     first = a < b ? a : b, last = a < b ? b : a;
        enter = first > enter ? first : enter;
        leave = last < leave ? last : leave;
    }
    return enter <= leave;
}

/* A component of 0, or nearly so, becomes so small that no box notices. */
static double inverse(double component)
{
    return 1 / (fabs(component) > 0x1p-500 ? component : 0x1p-500);
}

void occluders_along(const struct occluders *of, struct vector from, const struct homogeneous *to,
                     bool (*visit)(void *context, const struct occluder *met), void *context)
{
    const struct vector path = to->infinite ? to->at : vector_subtract(to->at, from);
    const double start[3] = {from.x, from.y, from.z},
                 once[3] = {inverse(path.x), inverse(path.y), inverse(path.z)};
    int32_t waiting[DEEPEST] = {0}, n = of->n > 0;
    while (n > 0) {
        const struct box_node *node = &of->nodes[waiting[--n]];
        if (!meets(&node->box, start, once, to->infinite ? HUGE_VAL : 1))
            continue;
        for (int i = 0; i < node->n; i++)
            if (!visit(context, &of->list[node->first + i]))
                return;
        for (int32_t i = 0; i < 2 && node->n == 0; i++)
            waiting[n++] = node->first + i;
    }
}
