/* SPDX-License-Identifier: MIT */
/* Meshes in parts: cutting one in half, and taking a part out. */
#include <stdlib.h>
#include <string.h>

#include "spectral.h"

/* ---- cutting at x = 0 ---- */

/* An edge whose ends lie on different sides, as the indices of its vertices. */
struct crossing {
    int32_t low, high;
};
struct crossings {
    struct crossing *at; /* sorted, each once; the new vertices are in this order */
    int n;
};

static int side_of(const struct vertex *vertex)
{
    return (vertex->position.x > 0) - (vertex->position.x < 0);
}

static bool crosses(const struct mesh *mesh, int32_t a, int32_t b)
{
    return side_of(&mesh->vertices[a]) * side_of(&mesh->vertices[b]) < 0;
}

static struct crossing crossing_of(int32_t a, int32_t b)
{
    return (struct crossing){a < b ? a : b, a < b ? b : a};
}

static int compare(const void *a, const void *b)
{
    const struct crossing *p = a, *q = b;
    return p->low != q->low ? (p->low > q->low) - (p->low < q->low)
                            : (p->high > q->high) - (p->high < q->high);
}

/* *repeated counts an edge for each triangle that has it: so many triangles more are needed. */
static bool find_crossings(const struct mesh *mesh, struct crossings *out, int *repeated,
                           struct error *err)
{
    int n = 0;
    for (int i = 0; i < mesh->n_triangles; i++)
        for (int k = 0; k < 3; k++) {
            const int32_t a = mesh->triangles[i][k], b = mesh->triangles[i][(k + 1) % 3];
            struct crossing *more;
            if (!crosses(mesh, a, b))
                continue;
            more = array_more(out->at, n, sizeof *more, err);
            if (!more)
                return false;
            out->at = more;
            more[n++] = crossing_of(a, b);
        }
    *repeated = n;
    if (n > 0)
        qsort(out->at, (size_t)n, sizeof *out->at, compare);
    for (int i = 0; i < n; i++)
        if (i == 0 || compare(&out->at[i - 1], &out->at[i]) != 0)
            out->at[out->n++] = out->at[i];
    return true;
}

/* Where a value that is a at -1 and b at 1 is at `where`. Equal ones stay what they are, and seen
 * from the other end, b at -1 and a at 1, every bit is the same. */
static double between(double a, double b, double where)
{
    return 0.5 * ((a + b) + where * (b - a));
}

static struct vertex cut_edge(const struct vertex *a, const struct vertex *b)
{
    const struct vector p = a->position, q = b->position, m = a->normal, n = b->normal;
    const double where = (p.x + q.x) / (p.x - q.x);
    struct vector normal = {between(m.x, n.x, where), between(m.y, n.y, where),
                            between(m.z, n.z, where)};
    normal = vector_normalise(normal);
    return (struct vertex){{0, between(p.y, q.y, where), between(p.z, q.z, where)},
                           vector_dot(normal, normal) > 0 ? normal : m, /* opposite ones cancel */
                           between(a->s, b->s, where),
                           between(a->t, b->t, where)};
}

/* The corners of what a triangle has on one side, in its own sense of rotation; returns how many.
 * Fewer than 3 are at most an edge. */
static int clip_to_side(const struct mesh *mesh, const struct crossings *crossings,
                        const int32_t triangle[3], int side, int32_t out[4])
{
    int n = 0;
    for (int k = 0; k < 3; k++) {
        const int32_t a = triangle[k], b = triangle[(k + 1) % 3];
        if (side_of(&mesh->vertices[a]) * side >= 0)
            out[n++] = a;
        if (crosses(mesh, a, b)) {
            const struct crossing key = crossing_of(a, b);
            const struct crossing *found =
                bsearch(&key, crossings->at, (size_t)crossings->n, sizeof *crossings->at, compare);
            out[n++] = mesh->n_vertices + (int32_t)(found - crossings->at);
        }
    }
    return n;
}

static void add_triangle(struct mesh *mesh, int part, int32_t a, int32_t b, int32_t c)
{
    const int32_t corner[3] = {a, b, c};
    mesh->part[mesh->n_triangles] = part;
    memcpy(mesh->triangles[mesh->n_triangles++], corner, sizeof corner);
}

/* A quadrilateral is divided from its lowest vertex, so that a mirrored mesh is cut alike. */
static void add_side(struct mesh *mesh, int part, const int32_t corner[4], int n)
{
    int low = 0;
    for (int i = 1; n == 4 && i < 4; i++)
        low = corner[i] < corner[low] ? i : low;
    for (int i = 1; i + 1 < n; i++)
        add_triangle(mesh, part, corner[low], corner[(low + i) % n], corner[(low + i + 1) % n]);
}

/* Both sides would take a triangle in the plane itself. */
static void cut_triangle(const struct mesh *from, const struct crossings *crossings,
                         const int32_t triangle[3], struct mesh *out)
{
    int32_t corner[4];
    bool flat = true;
    for (int k = 0; k < 3; k++)
        flat = flat && side_of(&from->vertices[triangle[k]]) == 0;
    for (int part = 0; part < (flat ? 1 : 2); part++)
        add_side(out, part, corner,
                 clip_to_side(from, crossings, triangle, part == 0 ? -1 : 1, corner));
}

static bool cut(const struct mesh *from, struct crossings *crossings, struct mesh *out,
                struct error *err)
{
    int more;
    if (!find_crossings(from, crossings, &more, err) ||
        !mesh_reserve(out, (size_t)from->n_vertices + (size_t)crossings->n,
                      (size_t)from->n_triangles + (size_t)more, err))
        return false;
    out->part = calloc((size_t)from->n_triangles + (size_t)more + 1, sizeof *out->part);
    if (!out->part)
        return error_memory(err);
    out->n_parts = 2;
    for (int i = 0; i < from->n_vertices; i++)
        out->vertices[out->n_vertices++] = from->vertices[i];
    for (int i = 0; i < crossings->n; i++)
        out->vertices[out->n_vertices++] =
            cut_edge(&from->vertices[crossings->at[i].low], &from->vertices[crossings->at[i].high]);
    for (int i = 0; i < from->n_triangles; i++)
        cut_triangle(from, crossings, from->triangles[i], out);
    return true;
}

bool mesh_cut(const struct mesh *from, struct mesh *out, struct error *err)
{
    struct crossings crossings = {.n = 0};
    *out = (struct mesh){.n_vertices = 0};
    const bool good = cut(from, &crossings, out, err);
    free(crossings.at);
    if (!good)
        mesh_free(out);
    return good;
}

/* ---- taking a part out ---- */

static bool in_part(const struct mesh *mesh, int triangle, int part)
{
    return (mesh->part ? mesh->part[triangle] : 0) == part;
}

/* number[v]: that of vertex v in the part, once it is known that the part uses it. */
static void take(const struct mesh *from, int part, int32_t *number, struct mesh *out)
{
    for (int i = 0; i < from->n_triangles; i++)
        for (int k = 0; k < 3 && in_part(from, i, part); k++)
            number[from->triangles[i][k]] = 1;
    for (int i = 0; i < from->n_vertices; i++)
        if (number[i]) {
            number[i] = out->n_vertices;
            out->vertices[out->n_vertices++] = from->vertices[i];
        }
    for (int i = 0; i < from->n_triangles; i++)
        if (in_part(from, i, part)) {
            for (int k = 0; k < 3; k++)
                out->triangles[out->n_triangles][k] = number[from->triangles[i][k]];
            out->n_triangles++;
        }
}

bool mesh_part(const struct mesh *from, int part, struct mesh *out, struct error *err)
{
    int32_t *number = calloc((size_t)from->n_vertices + 1, sizeof *number);
    *out = (struct mesh){.n_vertices = 0};
    const bool good = (number || error_memory(err)) &&
                      mesh_reserve(out, (size_t)from->n_vertices, (size_t)from->n_triangles, err);
    if (good)
        take(from, part, number, out);
    free(number);
    if (!good || !mesh_reserve(out, 0, 0, err)) { /* gives back what was not needed */
        mesh_free(out);
        return false;
    }
    return true;
}
