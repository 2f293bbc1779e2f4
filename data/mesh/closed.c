/* SPDX-License-Identifier: MIT */
/* Finds the points of a mesh, and whether it has a border. */
#include <stdlib.h>

#include "data/mesh/mesh.h"

bool mesh_points(const struct mesh *mesh, int32_t **out, struct error *err)
{
    struct index points = {.slots = NULL};
    bool done = true;
    *out = malloc((size_t)mesh->n_vertices * sizeof **out + 1);
    for (int i = 0; i < mesh->n_vertices && *out && done; i++) {
        const struct vector p = mesh->vertices[i].position;
        const double key[3] = {p.x + 0, p.y + 0, p.z + 0}; /* -0 becomes 0 */
        int point = index_find(&points, key, sizeof key);
        done = point >= 0 || index_add(&points, key, sizeof key, i, err);
        (*out)[i] = point >= 0 ? point : i;
    }
    index_free(&points);
    if (!*out)
        return error_memory(err);
    return done;
}

/* Each edge adds a random number, or the other way round the negative one. */
bool mesh_is_closed(const struct mesh *mesh, const int32_t *points)
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
