/* SPDX-License-Identifier: MIT */
/* Triangles with their numbers as colours. */
#include <stdlib.h>

#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "raster/gl/gl.h"

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

static void draw_instance(struct drawing *of, int instance, const struct numbered_draw *by,
                          struct numbered_vertex batch[3 * BATCH])
{
    const struct mesh *mesh = &of->plan->meshes[of->plan->instances[instance].mesh].mesh;
    const bool *hidden = of->lit->bounds[instance].hidden;
    int n = 0;
    by->place(of, instance);
    for (int i = 0; i < mesh->n_triangles; i++) {
        if (hidden && hidden[i])
            continue;
        number_triangle(mesh, i, instance, batch + 3 * (size_t)n++);
        if (n == BATCH) {
            by->draw(of, batch, 3 * n);
            n = 0;
        }
    }
    if (n > 0)
        by->draw(of, batch, 3 * n);
}

bool numbers_draw(struct drawing *of, const struct numbered_draw *by, struct error *err)
{
    struct numbered_vertex *batch;
    if (!MAKE_ARRAY(batch, 3 * BATCH, err, "%d triangles", BATCH))
        return false;
    for (int i = 0; i < of->plan->n_instances; i++)
        if (surface_reaches(&of->lit->bounds[i], &of->tile))
            draw_instance(of, i, by, batch);
    free(batch);
    return true;
}
