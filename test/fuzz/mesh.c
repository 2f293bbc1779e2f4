/* SPDX-License-Identifier: MIT */
/* Fuzz target: an OBJ file becomes a mesh, which is cut. */
#include <math.h>

#include "data/maths/maths.h"
#include "data/mesh/inside.h"
#include "test/fuzz/fuzz.h"

static void check_mesh(const struct mesh *mesh)
{
    for (int i = 0; i < mesh->n_vertices; i++) {
        const struct vertex *vertex = &mesh->vertices[i];
        fuzz_holds(isfinite(vertex->position.x) && isfinite(vertex->position.y) &&
                       isfinite(vertex->position.z),
                   "a vertex is at a finite place");
        fuzz_holds(isfinite(vertex->normal.x) && isfinite(vertex->normal.y) &&
                       isfinite(vertex->normal.z),
                   "a normal is finite");
        fuzz_holds(isfinite(vertex->s) && isfinite(vertex->t), "texture coordinates are finite");
    }
    for (int i = 0; i < mesh->n_triangles; i++) {
        for (int corner = 0; corner < 3; corner++)
            fuzz_holds(mesh->triangles[i][corner] >= 0 &&
                           mesh->triangles[i][corner] < mesh->n_vertices,
                       "a corner is a vertex of the mesh");
        fuzz_holds(mesh->part == NULL || (mesh->part[i] >= 0 && mesh->part[i] < mesh->n_parts),
                   "a part of a triangle is one of the mesh");
    }
}

static void cut_mesh(const struct mesh *mesh)
{
    struct error err = {.status = EXIT_AGREED};
    struct mesh cut = {.vertices = NULL}, half = {.vertices = NULL};
    if (fuzz_ends(mesh_cut(mesh, &cut, &err), &err)) {
        check_mesh(&cut);
        if (fuzz_ends(mesh_part(&cut, 1, &half, &err), &err))
            check_mesh(&half);
    }
    mesh_free(&half);
    mesh_free(&cut);
}

void fuzz_mesh(const struct fuzz_input *input)
{
    const struct place nowhere = {0};
    bool done = true;
    for (int unitize = 0; unitize < 2 && done; unitize++) {
        struct error err = {.status = EXIT_AGREED};
        struct mesh mesh = {.vertices = NULL};
        done = fuzz_ends(mesh_read(input->path, nowhere, unitize, unitize ? 30 : 90, &mesh, &err),
                         &err);
        if (done) {
            check_mesh(&mesh);
            cut_mesh(&mesh);
        }
        mesh_free(&mesh);
    }
}
