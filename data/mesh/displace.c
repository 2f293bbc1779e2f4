/* SPDX-License-Identifier: MIT */
/* Displaces the vertices of a mesh along its normals (Cook 1984: Shade Trees). */
#include "data/mesh/inside.h"

/* The vertices of one place; or, of these, those of one normal. */
struct spot {
    int n;                       /* normals of the place; vertices of the normal */
    double height;               /* of a place: the sum over its normals */
    struct vector normal;        /* likewise */
    struct vector before, after; /* of a normal: the sums of the normals of faces */
};
enum { PLACE, NORMAL };
struct displacement {
    struct mesh *mesh;
    const double *heights;
    struct index known; /* spots by place, and by place and normal */
    struct spot *spots;
    int n_spots;
    int32_t (*at)[2]; /* the spots of each vertex: PLACE, NORMAL */
};

/* Patches that meet compute the normal of a place in different ways. Rounded to 2^-20 these agree,
 * while the angles of creases are far larger. */
static double rounded(double x)
{
    return floor(x * 0x1p20 + 0.5);
}

/* Finds the two spots of a vertex, and adds those that are new. */
static bool find_spots(struct displacement *of, int vertex, struct error *err)
{
    const struct vector n = vector_normalise(of->mesh->vertices[vertex].normal);
    const struct vector key[] = {of->mesh->vertices[vertex].position,
                                 {rounded(n.x), rounded(n.y), rounded(n.z)}};
    int32_t *at = of->at[vertex];
    for (int k = PLACE; k <= NORMAL; k++) {
        const size_t length = (size_t)(k + 1) * sizeof key[0];
        at[k] = index_find(&of->known, key, length);
        if (at[k] < 0 && !index_add(&of->known, key, length, at[k] = of->n_spots++, err))
            return false;
    }
    if (of->spots[at[NORMAL]].n++ == 0) {
        struct spot *place = &of->spots[at[PLACE]];
        place->n++;
        place->normal = vector_add(place->normal, n);
    }
    return true;
}

static void move_vertices(const struct displacement *of)
{
    const double least = 1e-6; /* a mean of normals that is shorter is rounding of none */
    for (int i = 0; i < of->mesh->n_vertices; i++)
        of->spots[of->at[i][PLACE]].height += of->heights[i] / of->spots[of->at[i][NORMAL]].n;
    for (int i = 0; i < of->mesh->n_vertices; i++) {
        const struct spot *place = &of->spots[of->at[i][PLACE]];
        struct vector *position = &of->mesh->vertices[i].position;
        if (vector_reach(place->normal) > least * place->n)
            *position = vector_add(
                *position, vector_scale(vector_normalise(place->normal), place->height / place->n));
    }
}

/* Adds the normal of each face, weighted by its angle, to the spots of its corners. */
static void add_faces(const struct displacement *of, bool after)
{
    for (int i = 0; i < of->mesh->n_triangles; i++) {
        struct vector ring[3];
        for (int k = 0; k < 3; k++)
            ring[k] = of->mesh->vertices[of->mesh->triangles[i][k]].position;
        const struct vector normal = polygon_normal(ring, 3);
        for (int k = 0; k < 3 && vector_reach(normal) > 0; k++) {
            struct spot *spot = &of->spots[of->at[of->mesh->triangles[i][k]][NORMAL]];
            struct vector *sum = after ? &spot->after : &spot->before;
            *sum = vector_add(*sum, vector_scale(normal, polygon_angle(ring, 3, k, normal)));
        }
    }
}

/* Turns a normal by the difference of the mean normals of its faces, so that a smooth shape's own
 * normals stay as exact as they are. Faces that are inside out turn it the other way. */
static void turn_normal(struct vector *normal, const struct spot *spot)
{
    const struct vector before = vector_normalise(spot->before),
                        after = vector_normalise(spot->after), unit = vector_normalise(*normal);
    const double side = vector_dot(before, unit) < 0 ? -1 : 1;
    const struct vector turned =
        vector_add(unit, vector_scale(vector_subtract(after, before), side));
    if (vector_reach(before) > 0 && vector_reach(after) > 0 && vector_reach(turned) > 0)
        *normal = vector_normalise(turned);
}

bool mesh_displace(struct mesh *mesh, const double *heights, struct error *err)
{
    static const char what[] = "the vertices of a relief";
    const struct vector zero = {0, 0, 0};
    struct displacement of = {.mesh = mesh, .heights = heights};
    bool done = MAKE_ARRAY(of.spots, 2 * (size_t)mesh->n_vertices, err, what) &&
                MAKE_ARRAY(of.at, mesh->n_vertices, err, what);
    for (int i = 0; done && i < mesh->n_vertices; i++) {
        struct vector *position = &mesh->vertices[i].position;
        *position = vector_add(*position, zero); /* -0 becomes 0: places have equal bits */
        done = find_spots(&of, i, err);
    }
    if (done) {
        add_faces(&of, false);
        move_vertices(&of);
        add_faces(&of, true);
        for (int i = 0; i < mesh->n_vertices; i++)
            turn_normal(&mesh->vertices[i].normal, &of.spots[of.at[i][NORMAL]]);
        free(mesh->parameters);
        mesh->parameters = NULL;
        mesh->parametric = false;
    }
    index_free(&of.known);
    FREE_ALL(of.spots, of.at);
    return done;
}
