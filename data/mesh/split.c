/* SPDX-License-Identifier: MIT */
/* Meshes in parts: cutting one in half, and taking a part out. */
#include <stdlib.h>
#include <string.h>

#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "spectral.h"

/* ---- cutting at x = 0 ---- */

static int side_of(const struct vertex *vertex)
{
    return (vertex->position.x > 0) - (vertex->position.x < 0);
}

static bool crosses(const struct mesh *mesh, int32_t a, int32_t b)
{
    return side_of(&mesh->vertices[a]) * side_of(&mesh->vertices[b]) < 0;
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

/* An edge by its vertices, the lower one first. */
static int64_t edge_of(int32_t a, int32_t b)
{
    return a < b ? (int64_t)a * INT32_MAX + b : (int64_t)b * INT32_MAX + a;
}

static int compare_edges(const void *a, const void *b)
{
    const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

/* Adds a vertex for each edge that crosses, in the order of the edges; returns how many. */
static int cut_edges(struct mesh *mesh, const struct mesh *from, int64_t *edges)
{
    int n = 0, n_cut = 0;
    for (int i = 0; i < from->n_triangles; i++)
        for (int k = 0; k < 3; k++) {
            const int32_t a = from->triangles[i][k], b = from->triangles[i][(k + 1) % 3];
            if (crosses(mesh, a, b))
                edges[n++] = edge_of(a, b);
        }
    qsort(edges, (size_t)n, sizeof *edges, compare_edges);
    for (int i = 0; i < n; i++) {
        if (i > 0 && edges[i] == edges[n_cut - 1])
            continue;
        mesh->vertices[mesh->n_vertices++] =
            cut_edge(&mesh->vertices[edges[i] / INT32_MAX], &mesh->vertices[edges[i] % INT32_MAX]);
        edges[n_cut++] = edges[i];
    }
    return n_cut;
}

/* Adds a triangle's part on one side: 3 or 4 corners, fewer are at most an edge. A quadrilateral is
 * divided from its lowest vertex, so that a mirrored mesh is cut alike. */
static void add_side(struct mesh *mesh, int part, const int32_t *corner, int n)
{
    int low = 0;
    for (int i = 1; n == 4 && i < 4; i++)
        low = corner[i] < corner[low] ? i : low;
    for (int i = 1; i + 1 < n; i++) {
        int32_t *triangle = mesh->triangles[mesh->n_triangles];
        mesh->part[mesh->n_triangles++] = part;
        triangle[0] = corner[low];
        triangle[1] = corner[(low + i) % n];
        triangle[2] = corner[(low + i + 1) % n];
    }
}

/* The new vertices are the mesh's last n_edges. */
static void cut_triangle(const int32_t triangle[3], const int64_t *edges, int n_edges,
                         struct mesh *mesh)
{
    int32_t corner[2][4]; /* of each side */
    int n[2] = {0, 0};
    bool cut = false;
    for (int k = 0; k < 3; k++) {
        const int32_t a = triangle[k], b = triangle[(k + 1) % 3];
        const int side = side_of(&mesh->vertices[a]);
        const int64_t edge = edge_of(a, b), *found;
        if (side <= 0)
            corner[0][n[0]++] = a;
        if (side >= 0)
            corner[1][n[1]++] = a;
        if (!crosses(mesh, a, b))
            continue;
        found = bsearch(&edge, edges, (size_t)n_edges, sizeof *edges, compare_edges);
        corner[0][n[0]++] = corner[1][n[1]++] =
            mesh->n_vertices - n_edges + (int32_t)(found - edges);
        cut = true;
    }
    add_side(mesh, 0, corner[0], n[0]);
    if (cut || n[0] < 3) /* both sides have a triangle in the plane itself */
        add_side(mesh, 1, corner[1], n[1]);
}

/* A triangle becomes at most 3, with 2 new vertices. */
bool mesh_cut(const struct mesh *from, struct mesh *out, struct error *err)
{
    const size_t n = (size_t)from->n_triangles;
    int64_t *edges;
    *out = (struct mesh){.n_vertices = 0};
    if (!mesh_reserve(out, (size_t)from->n_vertices + 2 * n, 3 * n, err))
        return false;
    out->part = calloc(3 * n + 1, sizeof *out->part);
    edges = malloc((2 * n + 1) * sizeof *edges);
    if (!out->part || !edges) {
        free(edges);
        return error_memory(err);
    }
    out->n_parts = 2;
    out->n_vertices = from->n_vertices;
    memcpy(out->vertices, from->vertices, (size_t)from->n_vertices * sizeof *out->vertices);
    const int n_edges = cut_edges(out, from, edges);
    for (int i = 0; i < from->n_triangles; i++)
        cut_triangle(from->triangles[i], edges, n_edges, out);
    free(edges);
    return mesh_reserve(out, 0, 0, err); /* gives back what was not needed */
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
    return good && mesh_reserve(out, 0, 0, err); /* gives back what was not needed */
}
