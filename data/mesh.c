/* SPDX-License-Identifier: MIT */
/* Makes a mesh of an OBJ file's faces: vertex normals where the file has none, planar texture
 * coordinates likewise, each different corner one vertex, in order of first use. Time grows with
 * the size of the file, but at the sharp tip of a fan with the square of its facets. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mesh.h"

/* ---- the mesh itself ---- */

bool mesh_reserve(struct mesh *mesh, size_t n_vertices, size_t n_triangles, struct error *err)
{
    const size_t vertices = n_vertices + (size_t)mesh->n_vertices;
    const size_t triangles = n_triangles + (size_t)mesh->n_triangles;

    /* Indices are int32_t; the first two tests keep the sums from wrapping round. */
    if (n_vertices > INT32_MAX || n_triangles > INT32_MAX || vertices > INT32_MAX ||
        triangles > INT32_MAX || vertices > SIZE_MAX / sizeof *mesh->vertices ||
        triangles > SIZE_MAX / sizeof *mesh->triangles)
        return error_memory(err);
    void *more = realloc(mesh->vertices, (vertices ? vertices : 1) * sizeof *mesh->vertices);
    if (!more)
        return error_memory(err);
    mesh->vertices = more;
    more = realloc(mesh->triangles, (triangles ? triangles : 1) * sizeof *mesh->triangles);
    if (!more)
        return error_memory(err);
    mesh->triangles = more;
    return true;
}

void mesh_free(struct mesh *mesh)
{
    free(mesh->vertices);
    free(mesh->triangles);
    *mesh = (struct mesh){.n_vertices = 0};
}

/* ---- bounds ---- */

struct box {
    struct vector low, high;
};

static void widen(double *low, double *high, double by)
{
    *low = by < *low ? by : *low;
    *high = by > *high ? by : *high;
}

/* Of the points that faces use. */
static struct box bounds(const struct obj *obj)
{
    const struct vector *first = &obj->points[obj->corners[0].point];
    struct box box = {*first, *first};

    for (size_t i = 1; i < obj->n_corners; i++) {
        const struct vector *point = &obj->points[obj->corners[i].point];
        widen(&box.low.x, &box.high.x, point->x);
        widen(&box.low.y, &box.high.y, point->y);
        widen(&box.low.z, &box.high.z, point->z);
    }
    return box;
}

/* Half of the range as rounded, so that no coordinate leaves [-1, 1] when divided by it. */
static double half_range(double low, double high, double centre)
{
    return fmax(high - centre, centre - low);
}

/* The box has an extent, since corners beside one another differ. */
static void unitize_points(struct obj *obj)
{
    const struct box box = bounds(obj);
    const struct vector centre = vector_scale(vector_add(box.low, box.high), 0.5);
    const double half = fmax(half_range(box.low.x, box.high.x, centre.x),
                             fmax(half_range(box.low.y, box.high.y, centre.y),
                                  half_range(box.low.z, box.high.z, centre.z)));

    for (size_t i = 0; i < obj->n_points; i++) {
        const struct vector from = vector_subtract(obj->points[i], centre);
        obj->points[i] = (struct vector){from.x / half, from.y / half, from.z / half};
    }
}

/* ---- normals where the file has none ---- */

/* Facets are whole faces, so that normals do not depend on how a face is cut. */
struct facets {
    struct vector *normals;  /* of each face; 0 0 0 without area */
    double *angles;          /* at each corner */
    int32_t *faces;          /* of each corner */
    int32_t *order, *starts; /* corners sorted by point; where each point's begin, and the end */
    double cosine;           /* facets are neighbours while their normals' cosine exceeds it */
    double half_cosine;      /* of half that angle */
};

/* Facets that meet at the crease angle itself must not fall on either side by chance. Coordinates
 * are mostly written with six significant digits, so that a facet of a thirtieth of the model's
 * size may lean by 1.5e-5 radians, or 0.001 degrees; by so much less must they meet. */
static double crease_cosine(double crease_deg)
{
    const double slack_deg = 0.001;
    const struct vector axis = {0, 0, 1};

    return matrix_rotation(fmax(crease_deg - slack_deg, 0), axis).row[0][0];
}

static void facets_free(struct facets *facets)
{
    free(facets->normals);
    free(facets->angles);
    free(facets->faces);
    free(facets->order);
    free(facets->starts);
}

static bool facets_allocate(const struct obj *obj, struct facets *out, struct error *err)
{
    out->normals = calloc(obj->n_faces, sizeof *out->normals);
    out->angles = calloc(obj->n_corners, sizeof *out->angles);
    out->faces = calloc(obj->n_corners, sizeof *out->faces);
    out->order = calloc(obj->n_corners, sizeof *out->order);
    out->starts = calloc(obj->n_points + 1, sizeof *out->starts);
    if (out->normals && out->angles && out->faces && out->order && out->starts)
        return true;
    return error_memory(err);
}

static int face_corners(const struct obj *obj, size_t face, size_t *first)
{
    *first = face > 0 ? (size_t)obj->face_ends[face - 1] : 0;
    return (int)((size_t)obj->face_ends[face] - *first);
}

static int gather_ring(const struct obj *obj, size_t face, size_t *first, struct vector *ring)
{
    const int n = face_corners(obj, face, first);

    for (int i = 0; i < n; i++)
        ring[i] = obj->points[obj->corners[*first + (size_t)i].point];
    return n;
}

/* A facet without area keeps a zero normal, and angles 0: it takes part in nothing. */
static void measure_facets(const struct obj *obj, struct facets *out, struct vector *ring)
{
    size_t first;

    for (size_t face = 0; face < obj->n_faces; face++) {
        const int n = gather_ring(obj, face, &first, ring);
        const struct vector normal = polygon_normal(ring, n);
        const bool flat = vector_dot(normal, normal) == 0;
        out->normals[face] = normal;
        for (int i = 0; i < n; i++) {
            out->faces[first + (size_t)i] = (int32_t)face;
            if (!flat)
                out->angles[first + (size_t)i] = polygon_angle(ring, n, i, normal);
        }
    }
}

/* Counting sort; starts[p] runs to its point's end meanwhile. */
static void sort_corners(const struct obj *obj, struct facets *out)
{
    for (size_t i = 0; i < obj->n_corners; i++)
        out->starts[obj->corners[i].point]++;
    for (size_t p = 0; p < obj->n_points; p++)
        out->starts[p + 1] += out->starts[p];
    for (size_t i = obj->n_corners; i-- > 0;)
        out->order[--out->starts[obj->corners[i].point]] = (int32_t)i;
}

/* The corners around one point. */
struct fan {
    const int32_t *corners;
    int n;
};

static struct vector weighted_normal(const struct facets *facets, int32_t corner)
{
    return vector_scale(facets->normals[facets->faces[corner]], facets->angles[corner]);
}

/* The average of all facets about the point; 0 0 0 where there is none. */
static struct vector whole_average(const struct facets *facets, struct fan fan)
{
    struct vector sum = {0, 0, 0};

    for (int i = 0; i < fan.n; i++)
        sum = vector_add(sum, weighted_normal(facets, fan.corners[i]));
    return vector_normalise(sum);
}

/* All facets within half the crease angle of the average are neighbours of one another. */
static bool is_smooth(const struct facets *facets, struct fan fan, struct vector average)
{
    for (int i = 0; i < fan.n; i++) {
        const double weight = facets->angles[fan.corners[i]];
        const struct vector normal = facets->normals[facets->faces[fan.corners[i]]];
        if (weight > 0 && vector_dot(normal, average) <= facets->half_cosine)
            return false;
    }
    return true;
}

/* The average of those facets about the point that are neighbours of this corner's. */
static struct vector crease_average(const struct facets *facets, struct fan fan, int32_t corner,
                                    struct vector average)
{
    const struct vector own = facets->normals[facets->faces[corner]];
    const int32_t own_face = facets->faces[corner];
    struct vector sum = {0, 0, 0};

    if (facets->angles[corner] == 0)
        return average;
    for (int i = 0; i < fan.n; i++) {
        const int32_t face = facets->faces[fan.corners[i]];
        if (face == own_face || vector_dot(facets->normals[face], own) > facets->cosine)
            sum = vector_add(sum, weighted_normal(facets, fan.corners[i]));
    }
    sum = vector_normalise(sum);
    return vector_dot(sum, sum) > 0 ? sum : own;
}

static bool same_vector(struct vector a, struct vector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* Gives every corner about the point that lacks a normal one; equal ones are stored once. */
static bool fill_point(struct obj *obj, const struct facets *facets, struct fan fan,
                       struct error *err)
{
    const size_t first = obj->n_normals;
    struct vector average = whole_average(facets, fan);
    const bool smooth = is_smooth(facets, fan, average);

    if (vector_dot(average, average) == 0)
        average.z = 1;
    for (int i = 0; i < fan.n; i++) {
        struct obj_corner *corner = &obj->corners[fan.corners[i]];
        if (corner->normal >= 0)
            continue;
        const struct vector normal =
            smooth ? average : crease_average(facets, fan, fan.corners[i], average);
        size_t index = first;
        while (index < obj->n_normals && !same_vector(obj->normals[index], normal))
            index++;
        if (index == obj->n_normals && !obj_add_normal(obj, normal, err))
            return false;
        corner->normal = (int32_t)index;
    }
    return true;
}

static bool lacks_normals(const struct obj *obj)
{
    for (size_t i = 0; i < obj->n_corners; i++)
        if (obj->corners[i].normal < 0)
            return true;
    return false;
}

/* Afterwards no corner lacks a normal. ring has room for every face. */
static bool fill_normals(struct obj *obj, double crease_deg, struct vector *ring,
                         struct error *err)
{
    struct facets facets = {.cosine = crease_cosine(crease_deg)};
    bool good;

    if (!lacks_normals(obj))
        return true;
    facets.half_cosine = sqrt((1 + facets.cosine) / 2);
    good = facets_allocate(obj, &facets, err);
    if (good) {
        measure_facets(obj, &facets, ring);
        sort_corners(obj, &facets);
    }
    for (size_t p = 0; good && p < obj->n_points; p++) {
        const int32_t start = facets.starts[p];
        good = fill_point(obj, &facets,
                          (struct fan){facets.order + start, facets.starts[p + 1] - start}, err);
    }
    facets_free(&facets);
    return good;
}

/* ---- vertices ---- */

/* Finds the vertex of a corner: an open hash table of vertices, at most half full. */
struct registry {
    int32_t *slots;           /* vertex, or -1 */
    struct obj_corner *known; /* the corner of each vertex */
    size_t n_slots;           /* a power of two */
    size_t room;              /* vertices that `known` and the mesh have room for */
};

static size_t slot_of(const struct registry *registry, const struct obj_corner *corner)
{
    /* Odd multipliers (2^64 over the golden ratio, and its like) spread neighbouring indices. */
    const uint64_t key = (uint64_t)(uint32_t)corner->point * 0x9E3779B97F4A7C15u ^
                         (uint64_t)(uint32_t)corner->texture * 0xC2B2AE3D27D4EB4Fu ^
                         (uint64_t)(uint32_t)corner->normal * 0x165667B19E3779F9u;
    size_t slot = (size_t)((key ^ key >> 32) & (registry->n_slots - 1));

    for (; registry->slots[slot] >= 0; slot = (slot + 1) & (registry->n_slots - 1)) {
        const struct obj_corner *other = &registry->known[registry->slots[slot]];
        if (other->point == corner->point && other->texture == corner->texture &&
            other->normal == corner->normal)
            break;
    }
    return slot;
}

/* What becoming a mesh needs: the statements, how far they reach, and working memory. */
struct builder {
    struct obj obj;
    struct box box;
    struct registry registry;
    size_t most_triangles; /* a face of n corners has at most n - 2 */
    struct vector *ring;
    struct cutter cutter;
};

/* Doubles the room for vertices, in the mesh too. */
static bool registry_grow(struct builder *builder, struct mesh *mesh, struct error *err)
{
    struct registry *registry = &builder->registry;
    const size_t room = registry->room ? 2 * registry->room : 256, n_slots = 2 * room;
    int32_t *slots = malloc(n_slots * sizeof *slots);
    struct obj_corner *known = realloc(registry->known, room * sizeof *known);

    if (known)
        registry->known = known;
    if (!slots || !known ||
        !mesh_reserve(mesh, room - (size_t)mesh->n_vertices,
                      builder->most_triangles - (size_t)mesh->n_triangles, err)) {
        free(slots);
        return error_memory(err);
    }
    free(registry->slots);
    registry->slots = slots;
    registry->n_slots = n_slots;
    registry->room = room;
    for (size_t i = 0; i < n_slots; i++)
        slots[i] = -1;
    for (int32_t i = 0; i < mesh->n_vertices; i++)
        slots[slot_of(registry, &registry->known[i])] = i;
    return true;
}

static double share(double at, double low, double high)
{
    return high > low ? (at - low) / (high - low) : 0;
}

static struct vertex make_vertex(const struct builder *builder, const struct obj_corner *corner)
{
    const struct box *box = &builder->box;
    struct vertex vertex = {.position = builder->obj.points[corner->point],
                            .normal = builder->obj.normals[corner->normal]};

    if (corner->texture >= 0) {
        vertex.s = builder->obj.textures[corner->texture][0];
        vertex.t = builder->obj.textures[corner->texture][1];
    } else {
        vertex.s = share(vertex.position.x, box->low.x, box->high.x);
        vertex.t = share(vertex.position.y, box->low.y, box->high.y);
    }
    return vertex;
}

static bool find_vertex(struct builder *builder, const struct obj_corner *corner,
                        struct mesh *mesh, int32_t *out, struct error *err)
{
    struct registry *registry = &builder->registry;

    if ((size_t)mesh->n_vertices == registry->room && !registry_grow(builder, mesh, err))
        return false;
    int32_t *slot = &registry->slots[slot_of(registry, corner)];
    if (*slot < 0) {
        *slot = mesh->n_vertices;
        registry->known[*slot] = *corner;
        mesh->vertices[mesh->n_vertices++] = make_vertex(builder, corner);
    }
    *out = *slot;
    return true;
}

static bool add_face(struct builder *builder, size_t face, struct mesh *mesh, struct error *err)
{
    struct cutter *cutter = &builder->cutter;
    size_t first;

    cutter_run(cutter, builder->ring, gather_ring(&builder->obj, face, &first, builder->ring));
    for (int i = 0; i < cutter->n_triangles; i++) {
        int32_t vertex[3];
        for (int k = 0; k < 3; k++)
            if (!find_vertex(builder,
                             &builder->obj.corners[first + (size_t)cutter->triangles[i][k]], mesh,
                             &vertex[k], err))
                return false;
        /* Only now: a new vertex may have moved the triangles. */
        memcpy(mesh->triangles[mesh->n_triangles++], vertex, sizeof vertex);
    }
    return true;
}

static bool add_faces(struct builder *builder, struct mesh *mesh, struct error *err)
{
    const struct obj *obj = &builder->obj;

    builder->most_triangles = obj->n_corners - 2 * obj->n_faces;
    if (!registry_grow(builder, mesh, err))
        return false;
    for (size_t face = 0; face < obj->n_faces; face++)
        if (!add_face(builder, face, mesh, err))
            return false;
    return mesh_reserve(mesh, 0, 0, err); /* gives back what was not needed */
}

static bool builder_allocate(struct builder *out, struct error *err)
{
    size_t first, longest = 0;

    for (size_t face = 0; face < out->obj.n_faces; face++) {
        const size_t n = (size_t)face_corners(&out->obj, face, &first);
        longest = n > longest ? n : longest;
    }
    out->ring = calloc(longest, sizeof *out->ring);
    if (!out->ring)
        return error_memory(err);
    return cutter_open(&out->cutter, longest, err);
}

static void builder_free(struct builder *builder)
{
    obj_free(&builder->obj);
    free(builder->registry.slots);
    free(builder->registry.known);
    free(builder->ring);
    cutter_free(&builder->cutter);
}

bool mesh_read(const char *path, struct place from, bool unitize, double crease_deg,
               struct mesh *out, struct error *err)
{
    struct builder builder = {.ring = NULL};
    bool good = obj_read(path, from, &builder.obj, err) && builder_allocate(&builder, err);

    *out = (struct mesh){.n_vertices = 0};
    if (good && unitize)
        unitize_points(&builder.obj);
    if (good)
        builder.box = bounds(&builder.obj);
    good = good && fill_normals(&builder.obj, crease_deg, builder.ring, err) &&
           add_faces(&builder, out, err);
    builder_free(&builder);
    if (!good)
        mesh_free(out);
    return good;
}
