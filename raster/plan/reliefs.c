/* SPDX-License-Identifier: MIT */
/* Reliefs: pictures that displace the vertices of meshes. */
#include "data/stack/stack.h"
#include "raster/plan/inside.h"

/* Returns the height of the surface at the texture coordinates of a vertex, as a texture that is
 * linear. */
static double height_at(const struct texels *texels, const struct shape *shape, double s, double t)
{
    const double s_t[2] = {s * shape->repeat[0], t * shape->repeat[1]};
    double place[TEXEL_PLACE] = {0};
    texel_place(texels, s_t, place);
    return shape->relief_height * texel_at(texels, place);
}

/* Compares the relief at the triangles' centres with the flat triangles there. */
static void find_loss(struct plan_mesh *whole, const struct texels *texels, const double *heights)
{
    const struct shape *shape = &whole->shape;
    const double all = shape->repeat[0] * texels->width * shape->repeat[1] * texels->height,
                 n = whole->mesh.n_triangles;
    double area = 0, squares = 0;
    for (int i = 0; i < whole->mesh.n_triangles; i++) {
        const int32_t *k = whole->mesh.triangles[i];
        const struct vertex *v = whole->mesh.vertices, *a = &v[k[0]], *b = &v[k[1]], *c = &v[k[2]];
        const double off =
            height_at(texels, shape, (a->s + b->s + c->s) / 3, (a->t + b->t + c->t) / 3) -
            (heights[k[0]] + heights[k[1]] + heights[k[2]]) / 3;
        area += fabs((b->s - a->s) * (c->t - a->t) - (c->s - a->s) * (b->t - a->t)) / 2;
        squares += off * off;
    }
    whole->relief_texels = all * area / n;
    whole->relief_missed = sqrt(squares / n);
}

bool relief_apply(struct plan_mesh *whole, struct error *err)
{
    const struct shape *shape = &whole->shape;
    struct mesh *mesh = &whole->mesh;
    struct texture relief = {.relief = true, .linear = true};
    double *heights;
    if (mesh->untextured && !shape->planar)
        return error_at(err, shape->relief_place,
                        "%.300s has corners without texture coordinates; expected vt in all faces, "
                        "or planar, which takes them from x and y",
                        shape->path);
    bool done = texture_read(shape->relief, shape->relief_place, tags_read, &relief, err) &&
                MAKE_ARRAY(heights, mesh->n_vertices, err, "the heights of a relief");
    if (done) {
        const struct texels texels = plan_texels(&relief, 0);
        for (int i = 0; i < mesh->n_vertices; i++)
            heights[i] = height_at(&texels, shape, mesh->vertices[i].s, mesh->vertices[i].t);
        find_loss(whole, &texels, heights);
        done = mesh_displace(mesh, heights, err);
        free(heights);
    }
    texture_free(&relief);
    return done;
}
