/* SPDX-License-Identifier: MIT */
/* The surfaces of built-in shapes, by parameters. Positions along a seam are computed from the same
 * numbers by the same steps. So neighbours agree in every bit, and no crack can open. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "data/mesh/inside.h"

bool patches_open(const struct shape *shape, struct patches *out, struct error *err)
{
    *out = (struct patches){.shape = shape};
    if (shape->kind != SHAPE_TEAPOT)
        return true;
    out->teapot = teapot_read(shape->place, err);
    return out->teapot != NULL;
}

void patches_close(struct patches *patches)
{
    free(patches->teapot);
    *patches = (struct patches){.shape = NULL};
}

/* ---- directions ---- */

struct direction {
    double cosine, sine;
};

/* Returns the direction at cell/cells of a full turn: rounded to 2^-18 of a cell, so that up to
 * 2^14 cells are whole numbers for sine_cosine_of_turn. */
static struct direction circle(double cell, double cells)
{
    const double fine = 0x1p18;
    struct direction at;
    sine_cosine_of_turn((int64_t)floor(cell * fine + 0.5), (int64_t)(cells * fine), &at.sine,
                        &at.cosine);
    return at;
}

/* ---- flat patches ---- */

/* A face of a box, from 0 to 5: towards x, -x, y, -y, z, -z. The texture's right and up are the
 * axes that follow in the cycle x y z. On the negative sides right is reversed, so that triangles
 * stay counter-clockwise. */
static struct vertex face_vertex(const double size[3], int face, const double cell[2], double cells)
{
    const int axis = face / 2, right = (axis + 1) % 3, up = (axis + 2) % 3;
    const double side = face % 2 ? -1 : 1;
    double normal[3] = {0, 0, 0}, at[3];
    normal[axis] = side;
    at[axis] = side * size[axis] / 2;
    at[right] = side * ((2 * cell[0] - cells) / cells) * size[right] / 2 + 0.0; /* -0 becomes 0 */
    at[up] = (2 * cell[1] - cells) / cells * size[up] / 2;
    return (struct vertex){
        {at[0], at[1], at[2]}, {normal[0], normal[1], normal[2]}, cell[0] / cells, cell[1] / cells};
}

/* A flat disk about the z axis, from its centre, v = 0, to its rim; `facing` is the z of its
 * normal, 1 or -1. */
struct disk {
    double radius, z, facing, slices, rings;
};

static struct vertex disk_vertex(const struct disk *disk, double u, double v)
{
    const struct direction at = circle(u, disk->slices);
    const double share = v / disk->rings, radius = disk->radius * share;
    return (struct vertex){{radius * at.cosine, radius * at.sine, disk->z},
                           {0, 0, disk->facing},
                           0.5 + 0.5 * share * at.cosine,
                           0.5 + 0.5 * share * disk->facing * at.sine};
}

/* ---- surfaces of revolution about z ---- */

/* A point of the turned curve, in the half-plane of radius and z. Radius 0 is a pole. */
struct profile {
    double radius, z, normal_radius, normal_z;
};

/* Returns the profile at step v of `steps`, which goes upwards on the outer side. */
static struct profile profile_at(const struct shape *shape, double v, double steps)
{
    const double share = v / steps, *p = shape->parameter;
    if (shape->kind == SHAPE_SPHERE) { /* half a turn, from the pole at -z */
        const struct direction at = circle(v, 2 * steps);
        return (struct profile){p[0] * at.sine, p[0] * (0 - at.cosine), at.sine, 0 - at.cosine};
    }
    if (shape->kind == SHAPE_TORUS) {
        const struct direction at = circle(v, steps);
        return (struct profile){p[1] + p[0] * at.cosine, p[0] * at.sine, at.cosine, at.sine};
    }
    /* A cylinder's or a cone's side, standing on z = -height / 2. */
    const double top = shape->kind == SHAPE_CONE ? 0 : 1, height = p[1];
    const struct vector normal = vector_normalise((struct vector){height, 0, p[0] * (1 - top)});
    return (struct profile){p[0] * (1 - (1 - top) * share), height * (share - 0.5), normal.x,
                            normal.z};
}

/* Products at a pole may be -0; adding 0 makes them 0, so that all vertices there have the same
 * bits. */
static struct vertex turned_vertex(const struct shape *shape, double u, double v, double slices,
                                   double steps)
{
    const struct profile point = profile_at(shape, v, steps);
    const struct direction at = circle(u, slices);
    return (struct vertex){
        {point.radius * at.cosine + 0.0, point.radius * at.sine + 0.0, point.z},
        {point.normal_radius * at.cosine, point.normal_radius * at.sine, point.normal_z},
        u / slices,
        v / steps};
}

/* ---- any patch ---- */

/* The ends of a cylinder, and the base of a cone. */
static bool is_cap(const struct shape *shape, int patch)
{
    return patch > 0 && (shape->kind == SHAPE_CYLINDER || shape->kind == SHAPE_CONE);
}

bool patch_is_flat(const struct shape *shape, int patch)
{
    return shape_is_flat(shape->kind) || is_cap(shape, patch);
}

/* Returns x in [0, cells], moved by whole turns. */
static double around(double x, double cells)
{
    return x < 0 || x > cells ? x - cells * floor(x / cells) : x;
}

static double between(double x, double cells)
{
    return fmax(0, fmin(x, cells));
}

void patch_enter(const struct shape *shape, double *u, double *v)
{
    const double *p = shape->parameter;
    if (shape->kind == SHAPE_TEAPOT) {
        *u = between(*u, p[1]);
        *v = between(*v, p[1]);
    } else if (shape->kind == SHAPE_TORUS) {
        *u = around(*u, p[3]);
        *v = around(*v, p[2]);
    } else {
        const bool is_sphere = shape->kind == SHAPE_SPHERE;
        *u = around(*u, p[is_sphere ? 1 : 2]);
        *v = between(*v, p[is_sphere ? 2 : 3]);
    }
}

struct vertex patch_vertex(const struct patches *patches, int patch, double u, double v)
{
    const struct shape *shape = patches->shape;
    const double *p = shape->parameter, plane[3] = {p[0], p[1], 0}, cell[2] = {u, v};
    switch (shape->kind) {
    case SHAPE_SPHERE:
        return turned_vertex(shape, u, v, p[1], p[2]);
    case SHAPE_TORUS:
        return turned_vertex(shape, u, v, p[3], p[2]);
    case SHAPE_BOX:
        return face_vertex(p, patch, cell, p[3]);
    case SHAPE_PLANE:
        return face_vertex(plane, 4, cell, p[2]);
    case SHAPE_CYLINDER:
    case SHAPE_CONE:
        if (patch == 0)
            return turned_vertex(shape, u, v, p[2], p[3]);
        return disk_vertex(&(struct disk){p[0], patch == 1 ? -0.5 * p[1] : 0.5 * p[1],
                                          patch == 1 ? -1 : 1, p[2], 1},
                           u, v);
    case SHAPE_DISK:
        return disk_vertex(&(struct disk){p[0], 0, 1, p[1], p[2]}, u, v);
    case SHAPE_TEAPOT:
        return teapot_vertex(&patches->teapot[patch], p[0], u, v, p[1]);
    case SHAPE_MESH:
        break;
    }
    assert(false);
    return (struct vertex){.s = 0};
}
