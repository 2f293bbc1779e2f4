/* SPDX-License-Identifier: MIT */
/* Makes a mesh of the faces of an OBJ file. Corners that agree in point, normal and texture
 * coordinates become one vertex, in the order of first use. Normals and texture coordinates that
 * the file lacks are computed. Time grows linearly with the size of the file. */
#include "data/mesh/inside.h"

/* ---- the mesh itself ---- */

/* Fails if there would be more items than fit into memory, or than leave room for a number of each
 * corner of a triangle in an int32_t. */
static bool reserve(void *items, int have, size_t more, size_t size, struct error *err)
{
    return (more <= (size_t)(INT32_MAX / 3 - have) &&
            memory_resize(items, (size_t)have + more, size)) ||
           memory_lacks(err, ((double)have + (double)more) * (double)size, "a mesh");
}

bool mesh_reserve(struct mesh *mesh, size_t n_vertices, size_t n_triangles, struct error *err)
{
    if (!reserve(&mesh->vertices, mesh->n_vertices, n_vertices, sizeof *mesh->vertices, err) ||
        (mesh->parametric && !reserve(&mesh->parameters, mesh->n_vertices, n_vertices,
                                      sizeof *mesh->parameters, err)) ||
        !reserve(&mesh->triangles, mesh->n_triangles, n_triangles, sizeof *mesh->triangles, err))
        return false;
    mesh->n_parts += mesh->n_parts == 0; /* a mesh that nobody divides is one part */
    return true;
}

/* A triangle with its vertices takes 70 bytes, in a plan 100, and up to 150 with OpenGL and its
 * check: measured with spheres of 500,000 to 2,000,000 triangles. */
enum { PLANNED_BYTES = 160 };

bool mesh_begin(struct mesh *mesh, size_t n_vertices, size_t n_triangles, struct error *err)
{
    return memory_suffices((double)n_triangles * PLANNED_BYTES, mesh->place, err,
                           "a mesh of %zu triangles", n_triangles) &&
           mesh_reserve(mesh, n_vertices, n_triangles, err);
}

/* The whole numbers below the middle of a triangle's texture coordinates; and the largest range of
 * these. */
struct texture_place {
    double s, t, range;
};

static struct texture_place texture_place(const struct mesh *mesh, int triangle)
{
    const int32_t *corner = mesh->triangles[triangle];
    const struct vertex *a = &mesh->vertices[corner[0]], *b = &mesh->vertices[corner[1]],
                        *c = &mesh->vertices[corner[2]];
    const double s[3] = {a->s, b->s, c->s}, t[3] = {a->t, b->t, c->t};
    return (struct texture_place){floor(0.5 * (least_of(s) + most_of(s))),
                                  floor(0.5 * (least_of(t) + most_of(t))),
                                  fmax(most_of(s) - least_of(s), most_of(t) - least_of(t))};
}

/* Moves the texture coordinates of a triangle next to 0: its vertices are added to `to` unless
 * `known` has them. */
static bool move_texture(struct mesh *mesh, int triangle, struct index *known, struct mesh *to,
                         struct error *err)
{
    const struct texture_place by = texture_place(mesh, triangle);
    for (int i = 0; i < 3; i++) {
        int32_t *corner = &mesh->triangles[triangle][i];
        const double key[3] = {*corner, by.s, by.t};
        int at = index_find(known, key, sizeof key);
        if (at < 0) {
            at = to->n_vertices++;
            to->vertices[at] = mesh->vertices[*corner];
            to->vertices[at].s -= by.s;
            to->vertices[at].t -= by.t;
            if (to->parametric)
                to->parameters[at] = mesh->parameters[*corner];
            if (!index_add(known, key, sizeof key, at, err))
                return false;
        }
        *corner = at;
    }
    return true;
}

bool mesh_repeat_texture(struct mesh *mesh, const double repeat[2], struct error *err)
{
    enum { MOST_TIMES = 8, MOST_HALVINGS = 6 };
    struct mesh moved = {.parametric = mesh->parametric};
    struct index known = {0};
    double range = 0;
    bool done = true, moves = false;
    for (int i = 0; i < mesh->n_vertices; i++) {
        mesh->vertices[i].s *= repeat[0];
        mesh->vertices[i].t *= repeat[1];
    }
    for (int i = 0; i < mesh->n_triangles; i++) {
        const struct texture_place at = texture_place(mesh, i);
        range = fmax(range, at.range);
        moves = moves || at.s != 0 || at.t != 0 || at.range > MOST_TIMES;
    }
    for (int i = 0; done && i < MOST_HALVINGS && ldexp(range, -i) > MOST_TIMES; i++)
        done = mesh_halve(mesh, err);
    if (!done || !moves)
        return done;
    done = mesh_reserve(&moved, 3 * (size_t)mesh->n_triangles, 0, err);
    for (int i = 0; done && i < mesh->n_triangles; i++)
        done = move_texture(mesh, i, &known, &moved, err);
    index_free(&known);
    FREE_ALL(mesh->vertices, mesh->parameters, moved.triangles); /* of these room for one */
    mesh->vertices = moved.vertices;
    mesh->parameters = moved.parameters;
    mesh->n_vertices = moved.n_vertices;
    return done && mesh_reserve(mesh, 0, 0, err); /* gives back what was not needed */
}

void mesh_free(struct mesh *mesh)
{
    FREE_ALL(mesh->vertices, mesh->parameters, mesh->triangles, mesh->part,
             mesh->division.triangles, mesh->division.first, mesh->division.number);
    for (int i = 0; mesh->part_names && i < mesh->n_parts; i++)
        free(mesh->part_names[i]);
    free(mesh->part_names);
    *mesh = (struct mesh){.n_vertices = 0};
}

void sort_by_key(const int32_t *key, size_t step, int n, int n_keys, int32_t *starts,
                 int32_t *order)
{
    for (int i = 0; i < n; i++)
        starts[key[(size_t)i * step]]++;
    for (int k = 0; k < n_keys; k++)
        starts[k + 1] += starts[k];
    for (int i = n; i-- > 0;)
        order[--starts[key[(size_t)i * step]]] = i;
}

/* ---- working memory ---- */

struct builder {
    struct obj obj;
    struct cutter *cutter;   /* its ring is a face */
    int32_t *order, *starts; /* corners sorted by point; where each point's begin, and the end */
    /* Vertices form chains, which end with -1. A point has as many chains as it has corners: the
     * hash of the other indices decides which of them a vertex is in. */
    int32_t *first_vertex; /* of each chain, in the order of points */
    uint64_t seed;         /* of the hash: another one in each run */
    struct link {
        int32_t next, corner;
    } * links; /* of each vertex */
};

static bool builder_allocate(struct builder *b, struct error *err)
{
    const size_t n_points = (size_t)b->obj.list[OBJ_POINT].n, n_corners = (size_t)b->obj.n_corners;
    const bool done = MAKE_ARRAY(b->cutter, 1, err, "a face") &&
                      MAKE_ARRAY(b->order, n_corners, err, "the corners of a mesh") &&
                      MAKE_ARRAY(b->starts, n_points + 1, err, "the points of a mesh") &&
                      MAKE_ARRAY(b->first_vertex, n_corners, err, "the vertices of a mesh") &&
                      MAKE_ARRAY(b->links, n_corners, err, "the vertices of a mesh");
    b->seed = (uintptr_t)b->first_vertex;
    return done;
}

/* Fills the ring with the points of a face. */
static void gather_ring(struct builder *b, const struct obj_face *face)
{
    for (int i = 0; i < face->n; i++)
        b->cutter->ring[i] = obj_point(&b->obj, face->first + i);
}

/* ---- the cube ---- */

/* Moves and scales the points that faces use into [-1, 1]^3. No point leaves the cube, since `half`
 * is the largest distance from the centre as it was rounded. `half` is above 0, since neighbouring
 * corners differ. */
static void unitize_points(struct builder *b)
{
    struct vector *points = b->obj.list[OBJ_POINT].at;
    struct vector low = obj_point(&b->obj, 0), high = low;
    for (int i = 1; i < b->obj.n_corners; i++) {
        low = vector_least(low, obj_point(&b->obj, i));
        high = vector_greatest(high, obj_point(&b->obj, i));
    }
    const struct vector centre = vector_scale(vector_add(low, high), 0.5);
    const double half = fmax(vector_reach(vector_subtract(high, centre)),
                             vector_reach(vector_subtract(centre, low)));
    for (int i = 0; i < b->obj.list[OBJ_POINT].n; i++) {
        const struct vector from = vector_subtract(points[i], centre);
        points[i] = (struct vector){from.x / half, from.y / half, from.z / half};
    }
}

/* ---- normals where the file has none ---- */

/* Measures all faces at their corners, and gives normals to those that lack them. */
static bool add_normals(struct builder *b, double crease_deg, struct error *err)
{
    for (int k = 0; k < b->obj.n_faces; k++) {
        const struct obj_face *face = &b->obj.faces[k];
        gather_ring(b, face);
        const struct vector normal = polygon_normal(b->cutter->ring, face->n);
        const bool flat = vector_dot(normal, normal) == 0;
        for (int i = 0; i < face->n; i++) {
            struct obj_corner *corner = &b->obj.corners[face->first + i];
            corner->normal = normal;
            corner->angle = flat ? 0 : polygon_angle(b->cutter->ring, face->n, i, normal);
        }
    }
    return normals_fill(&b->obj, b->order, b->starts, crease_deg, err);
}

/* ---- vertices ---- */

static double share(double at, double low, double high)
{
    return high > low ? (at - low) / (high - low) : 0;
}

void mesh_box(const struct mesh *mesh, struct vector *low, struct vector *high)
{
    *low = (struct vector){HUGE_VAL, HUGE_VAL, HUGE_VAL};
    *high = vector_scale(*low, -1);
    for (int i = 0; i < mesh->n_vertices; i++) {
        *low = vector_least(*low, mesh->vertices[i].position);
        *high = vector_greatest(*high, mesh->vertices[i].position);
    }
}

void mesh_planar(struct mesh *mesh)
{
    struct vector low, high;
    mesh_box(mesh, &low, &high);
    for (int i = 0; i < mesh->n_vertices; i++) {
        struct vertex *vertex = &mesh->vertices[i];
        vertex->s = share(vertex->position.x, low.x, high.x);
        vertex->t = share(vertex->position.y, low.y, high.y);
    }
}

/* Sets the texture coordinates: planar ones if the file has none. */
static void fill_texture(const struct builder *b, struct mesh *mesh)
{
    mesh_planar(mesh);
    for (int i = 0; i < mesh->n_vertices; i++) {
        const int32_t index = b->obj.corners[b->links[i].corner].index[OBJ_TEXTURE];
        mesh->untextured = mesh->untextured || index < 0;
        if (index >= 0) {
            mesh->vertices[i].s = b->obj.list[OBJ_TEXTURE].at[index].x;
            mesh->vertices[i].t = b->obj.list[OBJ_TEXTURE].at[index].y;
        }
    }
}

/* Returns the chain that the vertex of a corner is in. */
static int32_t *chain_of(const struct builder *b, const int32_t index[3])
{
    const int32_t start = b->starts[index[OBJ_POINT]], n = b->starts[index[OBJ_POINT] + 1] - start;
    const uint64_t others =
        (uint64_t)(uint32_t)index[OBJ_TEXTURE] << 32 | (uint32_t)index[OBJ_NORMAL];
    return &b->first_vertex[start + (int32_t)(hash_bits(others ^ b->seed) % (uint64_t)n)];
}

/* Returns the vertex of a corner, and adds it if there is none yet; -1: no memory. */
static int32_t find_vertex(struct builder *b, int32_t corner, struct mesh *mesh, struct error *err)
{
    const struct obj_corner *corners = b->obj.corners, *wanted = &corners[corner];
    int32_t *link = chain_of(b, wanted->index);
    for (; *link >= 0; link = &b->links[*link].next)
        if (memcmp(corners[b->links[*link].corner].index, wanted->index, sizeof wanted->index) == 0)
            return *link;
    const struct vertex vertex = {
        .position = obj_point(&b->obj, corner),
        .normal = b->obj.list[OBJ_NORMAL].at[wanted->index[OBJ_NORMAL]],
    };
    if (!array_add(&mesh->vertices, &mesh->n_vertices, &vertex, sizeof vertex, err))
        return -1;
    *link = mesh->n_vertices - 1;
    b->links[*link] = (struct link){-1, corner};
    return *link;
}

static bool add_face(struct builder *b, const struct obj_face *face, struct mesh *mesh,
                     struct error *err)
{
    gather_ring(b, face);
    cutter_run(b->cutter, face->n);
    for (int i = 0; i < b->cutter->n_triangles; i++) {
        int32_t *vertices = mesh->triangles[mesh->n_triangles];
        if (mesh->part)
            mesh->part[mesh->n_triangles] = face->name;
        mesh->n_triangles++;
        for (int k = 0; k < 3; k++) {
            vertices[k] = find_vertex(b, face->first + b->cutter->triangles[i][k], mesh, err);
            if (vertices[k] < 0)
                return false;
        }
    }
    return true;
}

/* Makes parts of the mesh, which takes the names over. If no face has a name, all are part 0. */
static bool divide(struct obj *obj, size_t n_triangles, struct mesh *mesh, struct error *err)
{
    if ((obj->n_names > 1 || obj->names[0][0] != '\0') &&
        !MAKE_ARRAY(mesh->part, n_triangles, err, "the parts of a mesh"))
        return false;
    mesh->part_names = obj->names;
    mesh->n_parts = obj->n_names;
    obj->names = NULL;
    obj->n_names = 0;
    return true;
}

/* A face of n corners has at most n - 2 triangles. */
static bool add_faces(struct builder *b, struct mesh *mesh, struct error *err)
{
    const size_t most = (size_t)(b->obj.n_corners - 2 * b->obj.n_faces);
    for (int i = 0; i < b->obj.n_corners; i++)
        b->first_vertex[i] = -1;
    if (!mesh_begin(mesh, 0, most, err) || !divide(&b->obj, most, mesh, err))
        return false;
    for (int i = 0; i < b->obj.n_faces; i++)
        if (!add_face(b, &b->obj.faces[i], mesh, err))
            return false;
    fill_texture(b, mesh);
    return mesh_reserve(mesh, 0, 0, err); /* gives back what was not needed */
}

bool mesh_read(const char *path, struct place from, bool unitize, double crease_deg,
               struct mesh *out, struct error *err)
{
    struct builder builder = {.cutter = NULL};
    bool good = obj_read(path, from, &builder.obj, err) && builder_allocate(&builder, err);
    *out = (struct mesh){.place = from};
    if (good && unitize)
        unitize_points(&builder);
    if (good)
        sort_by_key(builder.obj.corners->index, sizeof *builder.obj.corners / sizeof(int32_t),
                    builder.obj.n_corners, builder.obj.list[OBJ_POINT].n, builder.starts,
                    builder.order);
    good = good && (!builder.obj.lacks_normals || add_normals(&builder, crease_deg, err)) &&
           add_faces(&builder, out, err);
    FREE_ALL(builder.cutter, builder.order, builder.starts, builder.first_vertex, builder.links);
    obj_free(&builder.obj);
    return good;
}
