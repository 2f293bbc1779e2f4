/* SPDX-License-Identifier: MIT */
/* Cuts a mesh in half, halves its edges, and takes a part out of a mesh. */
#include "data/mesh/inside.h"

/* ---- edges that get a vertex ---- */

/* Returns one number for an edge, whichever of its vertices comes first. */
static int64_t edge_of(int32_t a, int32_t b)
{
    return a < b ? (int64_t)a * INT32_MAX + b : (int64_t)b * INT32_MAX + a;
}

static int compare_numbers(const void *a, const void *b)
{
    const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

static int side_of(const struct vertex *vertex)
{
    return (vertex->position.x > 0) - (vertex->position.x < 0);
}

static bool crosses(const struct mesh *mesh, int32_t a, int32_t b)
{
    return side_of(&mesh->vertices[a]) * side_of(&mesh->vertices[b]) < 0;
}

/* Interpolates a value that is a at -1 and b at 1. Equal values stay the same; with a and b
 * exchanged and `where` negated, the result has the same bits. */
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

/* Sets the parameters of a vertex on the edge from a to b, or in its middle, near enough for an
 * estimate of shading. */
static void cut_parameters(struct mesh *mesh, int32_t a, int32_t b, bool cutting, int32_t at)
{
    const struct parameters p = mesh->parameters[a], q = mesh->parameters[b];
    const double x = mesh->vertices[a].position.x, y = mesh->vertices[b].position.x,
                 share = cutting ? x / (x - y) : 0.5;
    mesh->parameters[at] = (struct parameters){p.patch, p.u + (int32_t)(share * (q.u - p.u)),
                                               p.v + (int32_t)(share * (q.v - p.v))};
}

/* Returns the middle of an edge. Its normal is not brought to unit length: so the normals that are
 * interpolated on the facet stay as they are. */
static struct vertex middle_of(const struct vertex *a, const struct vertex *b)
{
    return (struct vertex){vector_scale(vector_add(a->position, b->position), 0.5),
                           vector_scale(vector_add(a->normal, b->normal), 0.5), (a->s + b->s) / 2,
                           (a->t + b->t) / 2};
}

/* Adds a vertex for each edge of the triangles of *from: where it crosses x = 0, or, without
 * `cutting`, in the middle. They come in the order of the edges, which are sorted. Returns their
 * number. */
static int add_vertices(struct mesh *mesh, const struct mesh *from, bool cutting, int64_t *edges)
{
    int n = 0, kept = 0;
    for (int i = 0; i < 3 * from->n_triangles; i++) {
        const int32_t *corner = from->triangles[i / 3], a = corner[i % 3], b = corner[(i + 1) % 3];
        if (!cutting || crosses(from, a, b))
            edges[n++] = edge_of(a, b);
    }
    qsort(edges, (size_t)n, sizeof *edges, compare_numbers);
    for (int i = 0; i < n; i++) {
        const int32_t a = (int32_t)(edges[i] / INT32_MAX), b = (int32_t)(edges[i] % INT32_MAX);
        const struct vertex *p = &mesh->vertices[a], *q = &mesh->vertices[b];
        if (i > 0 && edges[i] == edges[kept - 1])
            continue;
        edges[kept++] = edges[i];
        if (mesh->parametric)
            cut_parameters(mesh, a, b, cutting, mesh->n_vertices);
        mesh->vertices[mesh->n_vertices++] = cutting ? cut_edge(p, q) : middle_of(p, q);
    }
    return kept;
}

/* Returns the new vertex of an edge: the last n vertices of the mesh are those of n sorted edges.
 */
static int32_t vertex_on(const struct mesh *mesh, const int64_t *edges, int n, int32_t a, int32_t b)
{
    const int64_t edge = edge_of(a, b),
                  *found = bsearch(&edge, edges, (size_t)n, sizeof *edges, compare_numbers);
    return mesh->n_vertices - n + (int32_t)(found - edges);
}

/* Begins a mesh, which has room, with the vertices of another. */
static void copy_vertices(const struct mesh *from, struct mesh *to)
{
    const size_t n = (size_t)from->n_vertices;
    memcpy(to->vertices, from->vertices, n * sizeof *to->vertices);
    if (to->parametric)
        memcpy(to->parameters, from->parameters, n * sizeof *to->parameters);
    to->n_vertices = from->n_vertices;
}

/* ---- cutting at x = 0 ---- */

/* Adds the polygon that a triangle has on one side, of 3 or 4 corners; fewer have no area. Divides
 * a quadrilateral from its vertex of the lowest number, so that a mirrored mesh is cut alike. */
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

/* Cuts a triangle. The last n_edges vertices of the mesh are the new ones. */
static void cut_triangle(const int32_t triangle[3], const int64_t *edges, int n_edges,
                         struct mesh *mesh)
{
    int32_t corner[2][4]; /* of each side */
    int n[2] = {0, 0};
    bool cut = false;
    for (int k = 0; k < 3; k++) {
        const int32_t a = triangle[k], b = triangle[(k + 1) % 3];
        const int side = side_of(&mesh->vertices[a]);
        if (side <= 0)
            corner[0][n[0]++] = a;
        if (side >= 0)
            corner[1][n[1]++] = a;
        if (!crosses(mesh, a, b))
            continue;
        corner[0][n[0]++] = corner[1][n[1]++] = vertex_on(mesh, edges, n_edges, a, b);
        cut = true;
    }
    add_side(mesh, 0, corner[0], n[0]);
    if (cut || n[0] < 3) /* a triangle in the plane itself goes to part 0 only */
        add_side(mesh, 1, corner[1], n[1]);
}

/* ---- halving edges ---- */

/* Adds the four quarters of a triangle. The last n_edges vertices of the mesh are the new ones. */
static void add_quarters(const int32_t corner[3], const int64_t *edges, int n_edges,
                         struct mesh *mesh)
{
    int32_t middle[3];
    for (int k = 0; k < 3; k++)
        middle[k] = vertex_on(mesh, edges, n_edges, corner[k], corner[(k + 1) % 3]);
    for (int k = 0; k < 3; k++) {
        const int32_t quarter[3] = {middle[(k + 2) % 3], corner[k], middle[k]};
        memcpy(mesh->triangles[mesh->n_triangles++], quarter, sizeof quarter);
    }
    memcpy(mesh->triangles[mesh->n_triangles++], middle, sizeof middle);
}

/* ---- all triangles of a mesh ---- */

/* Divides each triangle of *from: at x = 0, into at most 3, with 2 new vertices; or, without
 * `cutting`, into 4, with 3. *out has no vertices yet. */
static bool divide_edges(const struct mesh *from, bool cutting, struct mesh *out, struct error *err)
{
    const size_t n = (size_t)from->n_triangles, more = cutting ? 2 : 3;
    int64_t *edges;
    bool done = MAKE_ARRAY(edges, more * n, err, "the edges of a mesh") &&
                mesh_reserve(out, (size_t)from->n_vertices + more * n, (more + 1) * n, err);
    if (done) {
        copy_vertices(from, out);
        const int n_edges = add_vertices(out, from, cutting, edges);
        for (int i = 0; i < from->n_triangles; i++)
            (cutting ? cut_triangle : add_quarters)(from->triangles[i], edges, n_edges, out);
        done = mesh_reserve(out, 0, 0, err); /* gives back what was not needed */
    }
    free(edges);
    return done;
}

bool mesh_cut(const struct mesh *from, struct mesh *out, struct error *err)
{
    *out = (struct mesh){.parametric = from->parametric, .n_parts = 2};
    return MAKE_ARRAY(out->part, 3 * (size_t)from->n_triangles, err, "the parts of a cut mesh") &&
           divide_edges(from, true, out, err);
}

/* Takes over the names of the parts. The four quarters of a triangle belong to its part. */
static bool take_parts(struct mesh *from, struct mesh *to, struct error *err)
{
    to->n_parts = from->n_parts;
    to->part_names = from->part_names;
    from->part_names = NULL;
    if (!from->part)
        return true;
    if (!MAKE_ARRAY(to->part, to->n_triangles, err, "the parts of a halved mesh"))
        return false;
    for (int i = 0; i < to->n_triangles; i++)
        to->part[i] = from->part[i / 4];
    return true;
}

bool mesh_halve(struct mesh *mesh, struct error *err)
{
    struct mesh finer = {.place = mesh->place, .parametric = mesh->parametric};
    const bool done = mesh_begin(&finer, 0, 4 * (size_t)mesh->n_triangles, err) &&
                      divide_edges(mesh, false, &finer, err) && take_parts(mesh, &finer, err);
    mesh_free(mesh);
    *mesh = finer;
    return done;
}

/* ---- taking a part out ---- */

/* Makes the division of the mesh, which has parts. */
static bool divide(struct mesh *mesh, struct error *err)
{
    static const char what[] = "the parts of a mesh";
    struct division *division = &mesh->division;
    if (!MAKE_ARRAY(division->triangles, mesh->n_triangles, err, what) ||
        !MAKE_ARRAY(division->first, (size_t)mesh->n_parts + 1, err, what) ||
        !MAKE_ARRAY(division->number, mesh->n_vertices, err, what))
        return false;
    for (int i = 0; i < mesh->n_vertices; i++)
        division->number[i] = -1;
    sort_by_key(mesh->part, 1, mesh->n_triangles, mesh->n_parts, division->first,
                division->triangles);
    return true;
}

/* Copies n triangles with their vertices. While it runs, vertices that are copied have numbers. */
static void take(const struct mesh *from, const int32_t *triangles, int n, struct mesh *out)
{
    int32_t *number = from->division.number;
    out->n_triangles = n;
    for (int i = 0; i < 3 * n; i++) {
        const int32_t vertex = from->triangles[triangles[i / 3]][i % 3];
        if (number[vertex] < 0) {
            number[vertex] = out->n_vertices;
            if (from->parametric)
                out->parameters[out->n_vertices] = from->parameters[vertex];
            out->vertices[out->n_vertices++] = from->vertices[vertex];
        }
        out->triangles[i / 3][i % 3] = number[vertex];
    }
    for (int i = 0; i < 3 * n; i++)
        number[from->triangles[triangles[i / 3]][i % 3]] = -1;
}

static bool copy_mesh(const struct mesh *from, struct mesh *out, struct error *err)
{
    const size_t n = (size_t)from->n_triangles;
    if (!mesh_reserve(out, (size_t)from->n_vertices, n, err))
        return false;
    copy_vertices(from, out);
    memcpy(out->triangles, from->triangles, n * sizeof *out->triangles);
    out->n_triangles = from->n_triangles;
    return true;
}

bool mesh_part(struct mesh *from, int part, struct mesh *out, struct error *err)
{
    const struct division *division = &from->division;
    *out = (struct mesh){.parametric = from->parametric};
    if (part < 0 || !from->part)
        return copy_mesh(from, out, err);
    if (!division->number && !divide(from, err))
        return false;
    const int32_t *triangles = division->triangles + division->first[part];
    const int n = division->first[part + 1] - division->first[part];
    const int most = n < from->n_vertices / 3 ? 3 * n : from->n_vertices;
    if (!mesh_reserve(out, (size_t)most, (size_t)n, err))
        return false;
    take(from, triangles, n, out);
    return mesh_reserve(out, 0, 0, err); /* gives back what was not needed */
}
