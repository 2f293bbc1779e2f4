/* SPDX-License-Identifier: MIT */
/* Finds whether a mesh has a border. */
#include <stdlib.h>

#include "data/mesh/mesh.h"

/* Finds the point of each vertex: the number of the first vertex in the same place. */
static bool find_points(const struct mesh *mesh, int32_t *out, struct error *err)
{
    struct index points = {.slots = NULL};
    bool done = true;
    for (int i = 0; i < mesh->n_vertices && done; i++) {
        const struct vector p = mesh->vertices[i].position;
        const double key[3] = {p.x + 0, p.y + 0, p.z + 0}; /* -0 becomes 0 */
        const int point = index_find(&points, key, sizeof key);
        done = point >= 0 || index_add(&points, key, sizeof key, i, err);
        out[i] = point >= 0 ? point : i;
    }
    index_free(&points);
    return done;
}

/* Each edge adds a random number, or the other way round the negative one. */
static bool edges_meet(const struct mesh *mesh, const int32_t *points)
{
    uint64_t sum = 0;
    for (int i = 0; i < mesh->n_triangles; i++)
        for (int j = 0; j < 3; j++) {
            const int32_t *corner = mesh->triangles[i];
            const uint64_t from = (uint64_t)points[corner[j]] + 1,
                           to = (uint64_t)points[corner[(j + 1) % 3]] + 1;
            sum += hash_bits(from << 32 | to) - hash_bits(to << 32 | from);
        }
    return sum == 0 && mesh->n_triangles > 0;
}

bool mesh_find_closed(const struct mesh *mesh, bool *closed, struct error *err)
{
    int32_t *points;
    const bool done = MAKE_ARRAY(points, mesh->n_vertices, err, "the points of a mesh") &&
                      find_points(mesh, points, err);
    *closed = done && edges_meet(mesh, points);
    free(points);
    return done;
}
