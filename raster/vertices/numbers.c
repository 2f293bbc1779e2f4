/* SPDX-License-Identifier: MIT */
/* Triangles with their numbers as colours. */
#include <stdlib.h>

#include "data/mesh/mesh.h"
#include "raster/vertices/vertices.h"

/* Triangles given to OpenGL at once: few enough to stay in the second-level cache. */
enum { BATCH = 4096 };

static void number_triangle(const struct mesh *mesh, int triangle, int placed,
                            struct numbered_vertex out[3])
{
    for (int i = 0; i < 3; i++) {
        struct vector p = mesh->vertices[mesh->triangles[triangle][i]].position;
        out[i] = (struct numbered_vertex){
            {(float)p.x, (float)p.y, (float)p.z},
            {(float)(triangle & 0xffff), (float)(triangle >> 16), (float)(placed + 1)}};
    }
}

bool numbered_draw(const struct lit_scene *lit, int instance,
                   void (*draw)(void *of, const struct numbered_vertex *corners, int n), void *of,
                   struct error *err)
{
    const struct mesh *mesh = &lit->plan->meshes[lit->plan->instances[instance].mesh].mesh;
    const bool *hidden = lit->bounds[instance].hidden;
    struct numbered_vertex *batch = malloc(3 * BATCH * sizeof *batch);
    int n = 0;
    if (!batch)
        return error_memory(err);
    for (int i = 0; i < mesh->n_triangles; i++) {
        if (hidden && hidden[i])
            continue;
        number_triangle(mesh, i, instance, batch + 3 * (size_t)n++);
        if (n == BATCH) {
            draw(of, batch, 3 * n);
            n = 0;
        }
    }
    if (n > 0)
        draw(of, batch, 3 * n);
    free(batch);
    return true;
}
