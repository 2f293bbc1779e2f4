/* SPDX-License-Identifier: MIT */
/* The triangles of shapes: a lattice of places on each patch, and two triangles in each cell. */
#include <assert.h>
#include <string.h>

#include "data/mesh/inside.h"

/* ---- building blocks ---- */

static void add_vertex(struct mesh *mesh, const struct patches *patches, int patch, double u,
                       double v)
{
    mesh->parameters[mesh->n_vertices] =
        (struct parameters){patch, (int32_t)(u * PARAMETER_CELL), (int32_t)(v * PARAMETER_CELL)};
    mesh->vertices[mesh->n_vertices++] = patch_vertex(patches, patch, u, v);
}

static void add_triangle(struct mesh *mesh, int a, int b, int c)
{
    const int32_t corner[3] = {a, b, c};
    memcpy(mesh->triangles[mesh->n_triangles++], corner, sizeof corner);
}

/* A patch as cells. The vertices of a pole, a row that is one point, lie between those of the next
 * row, and its triangles without area are left out. */
struct lattice {
    int columns, rows;
    bool low_pole, high_pole;
};

/* Adds two triangles for each quadrilateral between a lower and an upper row. */
static void add_band(struct mesh *mesh, int low, bool low_pole, int high, bool high_pole, int count)
{
    for (int i = 0; i < count; i++) {
        if (!low_pole)
            add_triangle(mesh, low + i, low + i + 1, high_pole ? high + i : high + i + 1);
        if (!high_pole)
            add_triangle(mesh, low + i, high + i + 1, high + i);
    }
}

static void add_lattice(struct mesh *mesh, const struct patches *patches, int patch,
                        const struct lattice *lattice)
{
    int below = 0;
    for (int v = 0; v <= lattice->rows; v++) {
        const bool low = lattice->low_pole && v == 0, below_low = lattice->low_pole && v == 1,
                   high = lattice->high_pole && v == lattice->rows;
        const int row = mesh->n_vertices;
        for (int u = 0; u < lattice->columns + !(low || high); u++)
            add_vertex(mesh, patches, patch, u + (low || high ? 0.5 : 0), v);
        if (v > 0)
            add_band(mesh, below, below_low, row, high, lattice->columns);
        below = row;
    }
}

/* Adds n patches that all have the same lattice. */
static bool add_patches(struct mesh *mesh, const struct patches *patches, int n,
                        const struct lattice *lattice, struct error *err)
{
    const size_t columns = (size_t)lattice->columns, rows = (size_t)lattice->rows, all = (size_t)n;
    if (!mesh_begin(mesh, all * (rows + 1) * (columns + 1), all * 2 * rows * columns, err))
        return false;
    for (int i = 0; i < n; i++) {
        struct lattice own = *lattice;
        own.low_pole = own.low_pole || (patches->teapot && patches->teapot[i].pole);
        add_lattice(mesh, patches, i, &own);
    }
    return true;
}

/* Adds a disk: rings of triangles about its centre. */
static bool add_disk(struct mesh *mesh, const struct patches *patches, int patch, int slices,
                     int rings, struct error *err)
{
    const int centre = mesh->n_vertices;
    const size_t n = (size_t)slices, n_rings = (size_t)rings;
    if (!mesh_begin(mesh, n * n_rings + 1, n * (2 * n_rings - 1), err))
        return false;
    add_vertex(mesh, patches, patch, 0, 0);
    const bool up = mesh->vertices[centre].normal.z > 0;
    for (int ring = 1; ring <= rings; ring++)
        for (int i = 0; i < slices; i++)
            add_vertex(mesh, patches, patch, i, ring);
    for (int ring = 1; ring <= rings; ring++)
        for (int i = 0; i < slices; i++) {
            const int outer = centre + 1 + (ring - 1) * slices, inner = outer - slices;
            const int from = up ? i : (i + 1) % slices, to = up ? (i + 1) % slices : i;
            add_triangle(mesh, ring == 1 ? centre : inner + from, outer + from, outer + to);
            if (ring > 1)
                add_triangle(mesh, inner + from, outer + to, inner + to);
        }
    return true;
}

/* ---- any shape ---- */

static bool add_all(struct mesh *mesh, const struct patches *patches, struct error *err)
{
    const int p[4] = {0, (int)patches->shape->parameter[1], (int)patches->shape->parameter[2],
                      (int)patches->shape->parameter[3]};
    switch (patches->shape->kind) {
    case SHAPE_SPHERE:
        return add_patches(mesh, patches, 1, &(struct lattice){p[1], p[2], true, true}, err);
    case SHAPE_TORUS:
        return add_patches(mesh, patches, 1, &(struct lattice){p[3], p[2], false, false}, err);
    case SHAPE_BOX:
        return add_patches(mesh, patches, 6, &(struct lattice){p[3], p[3], false, false}, err);
    case SHAPE_PLANE:
        return add_patches(mesh, patches, 1, &(struct lattice){p[2], p[2], false, false}, err);
    case SHAPE_CYLINDER:
        return add_patches(mesh, patches, 1, &(struct lattice){p[2], p[3], false, false}, err) &&
               add_disk(mesh, patches, 1, p[2], 1, err) && add_disk(mesh, patches, 2, p[2], 1, err);
    case SHAPE_CONE:
        return add_patches(mesh, patches, 1, &(struct lattice){p[2], p[3], false, true}, err) &&
               add_disk(mesh, patches, 1, p[2], 1, err);
    case SHAPE_DISK:
        return add_disk(mesh, patches, 0, p[1], p[2], err);
    case SHAPE_TEAPOT:
        return add_patches(mesh, patches, TEAPOT_PATCHES,
                           &(struct lattice){p[1], p[1], false, false}, err);
    case SHAPE_MESH:
        break;
    }
    assert(false);
    return false;
}

bool shape_build(const struct shape *shape, struct mesh *out, struct error *err)
{
    struct patches patches;
    if (shape->kind == SHAPE_MESH)
        return mesh_read(shape->path, shape->place, shape->unitize, shape->crease_deg, out, err);
    *out = (struct mesh){.place = shape->place, .parametric = true};
    const bool done = patches_open(shape, &patches, err) && add_all(out, &patches, err);
    patches_close(&patches);
    if (!done)
        mesh_free(out);
    return done;
}

void shape_repeat_texture(const struct shape *shape, struct mesh *mesh)
{
    for (int i = 0; i < mesh->n_vertices; i++) {
        mesh->vertices[i].s *= shape->repeat[0];
        mesh->vertices[i].t *= shape->repeat[1];
    }
}
