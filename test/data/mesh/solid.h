/* SPDX-License-Identifier: MIT */
/* Measures a mesh without trusting its builder: merges vertices whose positions are equal to the
 * bit, then measures the volume and counts edges. */
#ifndef SOLID_H
#define SOLID_H

#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "spectral.h"
#include "test.h"

/* Returns the mesh of a built-in shape. */
static inline struct mesh solid_build(enum shape_kind kind, const double parameter[4])
{
    struct shape shape = {.kind = kind};
    struct error err = {.text = ""};
    struct mesh mesh;
    memcpy(shape.parameter, parameter, sizeof shape.parameter);
    test_need(shape_build(&shape, &mesh, &err), err.text);
    return mesh;
}

static inline double solid_distance(struct vector a, struct vector b)
{
    return vector_length(vector_subtract(a, b));
}

struct solid {
    int places;          /* different positions */
    int edges;           /* undirected, between places */
    int open_edges;      /* directed edges without their reverse */
    int repeated_edges;  /* directed edges that occur more than once */
    double volume;       /* by the divergence theorem, positive when facing outwards */
    double worst_area;   /* the smallest triangle area over its longest edge squared */
    double area_z;       /* seen from +z: negative where a triangle is turned over */
    double least_area_z; /* of a triangle */
    double worst_length; /* the largest | |normal| - 1 | */
    double worst_facing; /* the smallest cosine between a vertex normal and its triangle's normal */
    bool texture_inside; /* all s and t in [0, 1] */
};

static inline int solid_compare_places(const void *a, const void *b)
{
    return memcmp(&(*(const struct vertex *const *)a)->position,
                  &(*(const struct vertex *const *)b)->position, sizeof(struct vector));
}

static inline int solid_compare_edges(const void *a, const void *b)
{
    const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

/* Sets place[v] to the number of vertex v's position. Returns the number of positions. */
static inline int solid_merge(const struct mesh *mesh, int *place)
{
    const struct vertex **sorted = malloc((size_t)mesh->n_vertices * sizeof *sorted);
    int n = 0;

    test_need(sorted != NULL, "no memory");
    for (int i = 0; i < mesh->n_vertices; i++)
        sorted[i] = &mesh->vertices[i];
    qsort(sorted, (size_t)mesh->n_vertices, sizeof *sorted, solid_compare_places);
    for (int i = 0; i < mesh->n_vertices; i++) {
        n += i == 0 || solid_compare_places(&sorted[i - 1], &sorted[i]) != 0;
        place[sorted[i] - mesh->vertices] = n - 1;
    }
    free(sorted);
    return n;
}

static inline void solid_count_edges(const struct mesh *mesh, const int *place, struct solid *out)
{
    const size_t n = 3 * (size_t)mesh->n_triangles;
    int64_t *edges = malloc((n + 1) * sizeof *edges);

    test_need(edges != NULL, "no memory");
    for (size_t i = 0; i < n; i++) {
        const int32_t *corner = mesh->triangles[i / 3];
        edges[i] = (int64_t)place[corner[i % 3]] * INT32_MAX + place[corner[(i + 1) % 3]];
    }
    qsort(edges, n, sizeof *edges, solid_compare_edges);
    for (size_t i = 0; i < n; i++) {
        const int64_t reverse = edges[i] % INT32_MAX * INT32_MAX + edges[i] / INT32_MAX;
        out->repeated_edges += i > 0 && edges[i] == edges[i - 1];
        out->open_edges += !bsearch(&reverse, edges, n, sizeof *edges, solid_compare_edges);
    }
    out->edges = ((int)n + out->open_edges) / 2;
    free(edges);
}

static inline void solid_measure_triangle(const struct mesh *mesh, int i, struct solid *out)
{
    const int32_t *corner = mesh->triangles[i];
    const struct vector a = mesh->vertices[corner[0]].position;
    const struct vector b = mesh->vertices[corner[1]].position;
    const struct vector c = mesh->vertices[corner[2]].position;
    const struct vector ab = vector_subtract(b, a), bc = vector_subtract(c, b);
    const struct vector ca = vector_subtract(a, c);
    const double longest = fmax(vector_length(ab), fmax(vector_length(bc), vector_length(ca)));
    const struct vector across =
        vector_cross(vector_scale(ab, 1 / longest), vector_scale(bc, 1 / longest));
    const double area_z = vector_cross(ab, bc).z / 2;

    out->volume += vector_dot(a, vector_cross(b, c)) / 6;
    out->area_z += area_z;
    out->least_area_z = fmin(out->least_area_z, area_z);
    out->worst_area = fmin(out->worst_area, vector_length(across) / 2);
    for (int k = 0; k < 3; k++)
        out->worst_facing = fmin(out->worst_facing, vector_dot(mesh->vertices[corner[k]].normal,
                                                               vector_normalise(across)));
}

static inline struct solid solid_measure(const struct mesh *mesh)
{
    struct solid out = {.worst_area = HUGE_VAL,
                        .least_area_z = HUGE_VAL,
                        .worst_facing = 1,
                        .texture_inside = true};
    int *place = malloc(((size_t)mesh->n_vertices + 1) * sizeof *place);

    test_need(place != NULL, "no memory");
    out.places = solid_merge(mesh, place);
    solid_count_edges(mesh, place, &out);
    free(place);
    for (int i = 0; i < mesh->n_triangles; i++)
        solid_measure_triangle(mesh, i, &out);
    for (int i = 0; i < mesh->n_vertices; i++) {
        const struct vertex *v = &mesh->vertices[i];
        out.worst_length = fmax(out.worst_length, fabs(vector_length(v->normal) - 1));
        out.texture_inside = out.texture_inside && v->s >= 0 && v->s <= 1 && v->t >= 0 && v->t <= 1;
    }
    return out;
}

/* Returns vertices - edges + faces, with vertices counted by position. */
static inline int solid_euler(const struct solid *solid, const struct mesh *mesh)
{
    return solid->places - solid->edges + mesh->n_triangles;
}

#endif
