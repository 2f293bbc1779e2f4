/* SPDX-License-Identifier: MIT */
/* Divides triangles by halving edges. A triangle with one, two or three marked edges becomes two,
 * three or four, so that its neighbours never meet a vertex inside an edge. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/shape/shape.h"

/* ---- half of an edge ---- */

static double half(int32_t a, int32_t b)
{
    return ((double)a + b) / 2;
}

static struct vertex halfway(const struct vertex *a, const struct vertex *b)
{
    return (struct vertex){vector_scale(vector_add(a->position, b->position), 0.5),
                           vector_scale(vector_add(a->normal, b->normal), 0.5), (a->s + b->s) / 2,
                           (a->t + b->t) / 2};
}

static bool is_pole(const struct patches *patches, const struct parameters *at)
{
    return patch_has_pole(patches, at->patch, (double)at->v / PARAMETER_CELL);
}

/* Finds the parameters half-way between two places of a curved patch. At a pole u may be anything:
 * the other end's is taken, so that both triangles of the edge find the same place. */
static struct parameters half_parameters(const struct patches *patches, const struct parameters *a,
                                         const struct parameters *b)
{
    const double u = is_pole(patches, a) ? b->u : is_pole(patches, b) ? a->u : half(a->u, b->u);
    return (struct parameters){a->patch, (int32_t)u, (int32_t)half(a->v, b->v)};
}

/* Finds the parameters half-way along the rim of a flat patch; false if the edge is not on it. */
static bool half_rim(const struct shape *shape, const struct parameters *a,
                     const struct parameters *b, struct parameters *out)
{
    double cells;
    if (a->v != b->v || !patch_has_rim(shape, a->patch, (double)a->v / PARAMETER_CELL, &cells))
        return false;
    const double turn = cells * PARAMETER_CELL,
                 u = half(a->u, b->u) + (fabs((double)a->u - b->u) > turn / 2 ? turn / 2 : 0);
    *out = (struct parameters){a->patch, (int32_t)(u >= turn ? u - turn : u), a->v};
    return true;
}

static struct vertex vertex_at(const struct patches *patches, const struct parameters *at)
{
    const struct shape *shape = patches->shape;
    struct vertex out = patch_vertex(patches, at->patch, (double)at->u / PARAMETER_CELL,
                                     (double)at->v / PARAMETER_CELL);
    out.s *= shape->repeat[0];
    out.t *= shape->repeat[1];
    return out;
}

struct vertex mesh_midpoint(const struct mesh *mesh, const struct patches *patches, int32_t a,
                            int32_t b, struct parameters *parameters)
{
    *parameters = (struct parameters){0, 0, 0};
    if (patches) {
        const struct parameters *p = &mesh->parameters[a], *q = &mesh->parameters[b];
        *parameters = half_parameters(patches, p, q);
        if (!patch_is_flat(patches->shape, p->patch) || half_rim(patches->shape, p, q, parameters))
            return vertex_at(patches, parameters);
    }
    return halfway(&mesh->vertices[a], &mesh->vertices[b]);
}

/* ---- edges that are halved ---- */

/* The marked edges, each once, in order; edge i has vertex first + i half-way. */
struct halved {
    int64_t *edges; /* owned */
    int n;
    int32_t first;
};

/* Returns one number for an edge, whichever of its vertices comes first. */
static int64_t edge_of(int32_t a, int32_t b)
{
    return a < b ? (int64_t)a * INT32_MAX + b : (int64_t)b * INT32_MAX + a;
}

static int compare_edges(const void *a, const void *b)
{
    const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

static bool list_edges(const struct mesh *mesh, const unsigned char *marks, struct halved *out,
                       struct error *err)
{
    size_t most = 0;
    for (int i = 0; i < mesh->n_triangles; i++)
        most += (size_t)((marks[i] & 1) + (marks[i] >> 1 & 1) + (marks[i] >> 2 & 1));
    *out = (struct halved){.first = mesh->n_vertices};
    if (!MAKE_ARRAY(out->edges, most, err, "the edges of a divided mesh"))
        return false;
    int n = 0;
    for (int i = 0; i < mesh->n_triangles; i++)
        for (int k = 0; k < 3; k++)
            if (marks[i] >> k & 1)
                out->edges[n++] = edge_of(mesh->triangles[i][k], mesh->triangles[i][(k + 1) % 3]);
    qsort(out->edges, (size_t)n, sizeof *out->edges, compare_edges);
    for (int i = 0; i < n; i++)
        if (i == 0 || out->edges[i] != out->edges[out->n - 1])
            out->edges[out->n++] = out->edges[i];
    return true;
}

static int32_t half_vertex(const struct halved *halved, int32_t a, int32_t b)
{
    const int64_t edge = edge_of(a, b), *found = bsearch(&edge, halved->edges, (size_t)halved->n,
                                                         sizeof *halved->edges, compare_edges);
    return halved->first + (int32_t)(found - halved->edges);
}

/* ---- triangles ---- */

struct subdivision {
    const struct patches *patches;
    struct halved halved;
    struct mesh *out;
    int32_t *source;
};

/* Gives a triangle at a pole a vertex of its own there, with the parameter u of its middle. It has
 * room: see mesh_subdivide. */
static void turn_pole(struct subdivision *of, int32_t triangle[3])
{
    struct mesh *out = of->out;
    for (int k = 0; k < 3; k++) {
        const struct parameters *corner = &out->parameters[triangle[k]],
                                *next = &out->parameters[triangle[(k + 1) % 3]],
                                *last = &out->parameters[triangle[(k + 2) % 3]];
        if (!is_pole(of->patches, corner))
            continue;
        const struct parameters turned = {corner->patch, (int32_t)half(next->u, last->u),
                                          corner->v};
        if (turned.u == corner->u)
            return;
        out->parameters[out->n_vertices] = turned;
        out->vertices[out->n_vertices] = vertex_at(of->patches, &turned);
        triangle[k] = out->n_vertices++;
        return;
    }
}

static void add(struct subdivision *of, int32_t source, int32_t a, int32_t b, int32_t c)
{
    struct mesh *out = of->out;
    int32_t *triangle = out->triangles[out->n_triangles];
    triangle[0] = a;
    triangle[1] = b;
    triangle[2] = c;
    if (of->patches)
        turn_pole(of, triangle);
    of->source[out->n_triangles++] = source;
}

static double squared_length(const struct mesh *mesh, int32_t a, int32_t b)
{
    const struct vector along =
        vector_subtract(mesh->vertices[a].position, mesh->vertices[b].position);
    return vector_dot(along, along);
}

/* Divides a triangle by two marked edges, from c[0] to c[1] and on to c[2], with their halves m.
 * The rest beside c[1] is cut along its shorter diagonal. */
static void add_three(struct subdivision *of, int32_t source, const int32_t c[3],
                      const int32_t m[2])
{
    add(of, source, m[0], c[1], m[1]);
    if (squared_length(of->out, c[0], m[1]) <= squared_length(of->out, m[0], c[2])) {
        add(of, source, c[0], m[0], m[1]);
        add(of, source, c[0], m[1], c[2]);
    } else {
        add(of, source, c[0], m[0], c[2]);
        add(of, source, m[0], m[1], c[2]);
    }
}

static void divide(struct subdivision *of, const int32_t corner[3], unsigned marks, int32_t source)
{
    const int n = (int)((marks & 1) + (marks >> 1 & 1) + (marks >> 2 & 1));
    int turn = 0; /* until edge 0 is marked; of two marked ones it is the first */
    while (n > 0 && n < 3 && !((marks >> turn & 1U) && (n == 1 || (marks >> (turn + 1) % 3 & 1))))
        turn++;
    int32_t c[3], m[3] = {-1, -1, -1};
    for (int k = 0; k < 3; k++)
        c[k] = corner[(k + turn) % 3];
    for (int k = 0; k < n; k++)
        m[k] = half_vertex(&of->halved, c[k], c[(k + 1) % 3]);
    if (n == 0) {
        add(of, source, c[0], c[1], c[2]);
    } else if (n == 1) {
        add(of, source, c[0], m[0], c[2]);
        add(of, source, m[0], c[1], c[2]);
    } else if (n == 2) {
        add_three(of, source, c, m);
    } else {
        for (int k = 0; k < 3; k++)
            add(of, source, m[(k + 2) % 3], c[k], m[k]);
        add(of, source, m[0], m[1], m[2]);
    }
}

/* ---- parts ---- */

static bool copy_parts(const struct mesh *from, const int32_t *source, struct mesh *out,
                       struct error *err)
{
    out->n_parts = from->n_parts;
    if (!from->part)
        return true;
    if (!MAKE_ARRAY(out->part, (size_t)out->n_triangles, err, "the parts of a mesh") ||
        !MAKE_ARRAY(out->part_names, (size_t)from->n_parts, err, "the parts of a mesh"))
        return false;
    for (int i = 0; i < out->n_triangles; i++)
        out->part[i] = from->part[source[i]];
    for (int i = 0; i < from->n_parts && from->part_names; i++)
        if (!string_copy(from->part_names[i], &out->part_names[i], err))
            return false;
    return true;
}

/* ---- all of it ---- */

/* Copies the vertices, and adds the half of each marked edge. */
static void add_vertices(const struct mesh *from, struct subdivision *of)
{
    struct mesh *out = of->out;
    memcpy(out->vertices, from->vertices, (size_t)from->n_vertices * sizeof *out->vertices);
    if (from->parametric)
        memcpy(out->parameters, from->parameters,
               (size_t)from->n_vertices * sizeof *out->parameters);
    out->n_vertices = from->n_vertices;
    for (int i = 0; i < of->halved.n; i++) {
        struct parameters parameters;
        const int32_t a = (int32_t)(of->halved.edges[i] / INT32_MAX),
                      b = (int32_t)(of->halved.edges[i] % INT32_MAX);
        out->vertices[out->n_vertices] = mesh_midpoint(from, of->patches, a, b, &parameters);
        if (from->parametric)
            out->parameters[out->n_vertices] = parameters;
        out->n_vertices++;
    }
}

/* A triangle becomes at most 4. A triangle at a pole has at most 3 new ones there. */
bool mesh_subdivide(const struct mesh *from, const struct patches *patches,
                    const unsigned char *marks, struct mesh *out, int32_t **source,
                    struct error *err)
{
    struct subdivision of = {.patches = patches, .out = out};
    size_t n = 0, poles = 0;
    *out = (struct mesh){.place = from->place, .parametric = from->parametric};
    *source = NULL;
    for (int i = 0; i < from->n_triangles; i++)
        n += (size_t)(1 + (marks[i] & 1) + (marks[i] >> 1 & 1) + (marks[i] >> 2 & 1));
    for (int i = 0; patches && i < from->n_triangles; i++)
        for (int k = 0; k < 3 && marks[i]; k++)
            poles += is_pole(patches, &from->parameters[from->triangles[i][k]]) ? 4 : 0;
    bool done = list_edges(from, marks, &of.halved, err) &&
                mesh_begin(out, (size_t)from->n_vertices + (size_t)of.halved.n + poles, n, err);
    done = done && MAKE_ARRAY(of.source, n, err, "the triangles of a divided mesh");
    if (done) {
        add_vertices(from, &of);
        for (int i = 0; i < from->n_triangles; i++)
            divide(&of, from->triangles[i], marks[i], i);
        done = copy_parts(from, of.source, out, err);
    }
    free(of.halved.edges);
    *source = of.source;
    if (!done)
        mesh_free(out);
    return done;
}
