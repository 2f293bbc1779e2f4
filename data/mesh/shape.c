/* SPDX-License-Identifier: MIT */
/* The built-in shapes: their words and sizes, and their triangles. Positions along a seam are
 * computed once, or from the same numbers by the same steps. So neighbours agree in every bit, and
 * no crack can open. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/mesh/mesh.h"

/* ---- the words of the scene language ---- */

/* A length lies above 0 and has highest 0. Any other size is a count, which can be refined. */
struct size {
    const char *name;
    int lowest, highest;
};
enum { MOST = 4096, MOST_DIVISIONS = 64 };

/* A shape's word, and its sizes up to a name that is NULL. */
static const struct form {
    const char *word;
    struct size sizes[5];
} forms[] = {
    [SHAPE_SPHERE] = {"sphere", {{"radius", 0, 0}, {"slices", 3, MOST}, {"stacks", 2, MOST}}},
    [SHAPE_TORUS] = {"torus",
                     {{"tube", 0, 0}, {"ring", 0, 0}, {"sides", 3, MOST}, {"rings", 3, MOST}}},
    [SHAPE_BOX] = {"box", {{"width", 0, 0}, {"height", 0, 0}, {"depth", 0, 0}}},
    [SHAPE_PLANE] = {"plane", {{"width", 0, 0}, {"height", 0, 0}}},
    [SHAPE_CYLINDER] =
        {"cylinder",
         {{"radius", 0, 0}, {"height", 0, 0}, {"slices", 3, MOST}, {"stacks", 1, MOST}}},
    [SHAPE_CONE] = {"cone",
                    {{"radius", 0, 0}, {"height", 0, 0}, {"slices", 3, MOST}, {"stacks", 1, MOST}}},
    [SHAPE_DISK] = {"disk", {{"radius", 0, 0}, {"slices", 3, MOST}}},
    [SHAPE_TEAPOT] = {"teapot", {{"size", 0, 0}, {"divisions", 1, MOST_DIVISIONS}}},
    [SHAPE_MESH] = {"mesh", {{NULL, 0, 0}}},
};
enum { N_SHAPES = SHAPE_MESH + 1 };

const char *shape_name(enum shape_kind kind)
{
    return forms[kind].word;
}

const char *shape_size_name(enum shape_kind kind, int i)
{
    return forms[kind].sizes[i].name;
}

struct shape shape_tessellated(const struct shape *shape, double factor)
{
    struct shape out = *shape;
    double *value = out.parameter;
    for (const struct size *size = forms[shape->kind].sizes; size->name; size++, value++)
        if (size->highest > 0)
            *value = fmax(size->lowest, fmin(floor(factor * *value + 0.5), size->highest));
    return out;
}

bool shape_has_counts(enum shape_kind kind)
{
    bool any = false;
    for (const struct size *size = forms[kind].sizes; size->name; size++)
        any = any || size->highest > 0;
    return any;
}

static bool read_size(struct text *text, const struct size *size, double *out, struct error *err)
{
    long count;
    if (size->highest == 0)
        return text_number(text, size->name, DBL_MIN, HUGE_VAL, out, err);
    if (!text_integer(text, size->name, size->lowest, size->highest, &count, err))
        return false;
    *out = (double)count;
    return true;
}

bool shape_read(struct text *text, struct shape *out, struct error *err)
{
    const char *words[N_SHAPES + 1] = {NULL};
    struct word word;
    int kind;
    *out = (struct shape){.crease_deg = 90, .repeat = {1, 1}, .place = text_next_place(*text)};
    for (int i = 0; i < N_SHAPES; i++)
        words[i] = forms[i].word;
    kind = text_choose(text, "a shape", words, "shape", err);
    if (kind < 0)
        return false;
    out->kind = (enum shape_kind)kind;
    for (int i = 0; forms[kind].sizes[i].name; i++)
        if (!read_size(text, &forms[kind].sizes[i], &out->parameter[i], err))
            return false;
    if (out->kind != SHAPE_MESH)
        return true;
    out->place = text_next_place(*text);
    return text_expect(text, &word, "a mesh file", err) &&
           word_file(&word, FILE_MODEL, &out->path, err);
}

/* ---- directions ---- */

struct direction {
    double cosine, sine;
};

/* Returns the direction at index/count of a full turn. */
static struct direction circle(int64_t index, int64_t count)
{
    struct direction at;

    sine_cosine_of_turn(index, count, &at.sine, &at.cosine);
    return at;
}

/* ---- building blocks ---- */

static void add_vertex(struct mesh *mesh, struct vector position, struct vector normal, double s,
                       double t)
{
    mesh->vertices[mesh->n_vertices++] = (struct vertex){position, normal, s, t};
}

static void add_triangle(struct mesh *mesh, int a, int b, int c)
{
    const int32_t corner[3] = {a, b, c};

    memcpy(mesh->triangles[mesh->n_triangles++], corner, sizeof corner);
}

/* Adds two triangles for each quadrilateral between a lower and an upper row. If a row is a pole,
 * its vertices lie between those of the other row, and the triangle without area is left out. */
static void add_band(struct mesh *mesh, int low, bool low_pole, int high, bool high_pole, int count)
{
    for (int i = 0; i < count; i++) {
        if (!low_pole)
            add_triangle(mesh, low + i, low + i + 1, high_pole ? high + i : high + i + 1);
        if (!high_pole)
            add_triangle(mesh, low + i, high + i + 1, high + i);
    }
}

/* ---- flat shapes ---- */

/* Adds a face of a box, from 0 to 5: towards x, -x, y, -y, z, -z. The texture's right and up are
 * the axes that follow in the cycle x y z. On the negative sides right is reversed, so that
 * triangles stay counter-clockwise. */
static bool add_face(struct mesh *mesh, const double size[3], int face, struct error *err)
{
    const int axis = face / 2, right = (axis + 1) % 3, up = (axis + 2) % 3;
    const int first = mesh->n_vertices;
    const double side = face % 2 ? -1 : 1;
    double normal[3] = {0, 0, 0}, at[3];

    if (!mesh_begin(mesh, 4, 2, err))
        return false;
    normal[axis] = side;
    at[axis] = side * size[axis] / 2;
    for (int i = 0; i < 4; i++) {
        const bool s = i == 1 || i == 2, t = i >= 2;
        at[right] = (s ? side : -side) * size[right] / 2;
        at[up] = (t ? 1 : -1) * size[up] / 2;
        add_vertex(mesh, (struct vector){at[0], at[1], at[2]},
                   (struct vector){normal[0], normal[1], normal[2]}, s, t);
    }
    add_triangle(mesh, first, first + 1, first + 2);
    add_triangle(mesh, first, first + 2, first + 3);
    return true;
}

static bool build_box(const double size[3], struct mesh *out, struct error *err)
{
    for (int face = 0; face < 6; face++)
        if (!add_face(out, size, face, err))
            return false;
    return true;
}

/* Adds a flat disk about the z axis; `facing` is the z of its normal, 1 or -1. */
static bool add_disk(struct mesh *mesh, double radius, double z, double facing, int slices,
                     struct error *err)
{
    const int centre = mesh->n_vertices, rim = centre + 1;
    const struct vector normal = {0, 0, facing};

    if (!mesh_begin(mesh, (size_t)slices + 1, (size_t)slices, err))
        return false;
    add_vertex(mesh, (struct vector){0, 0, z}, normal, 0.5, 0.5);
    for (int i = 0; i < slices; i++) {
        const struct direction at = circle(i, slices);
        add_vertex(mesh, (struct vector){radius * at.cosine, radius * at.sine, z}, normal,
                   0.5 + 0.5 * at.cosine, 0.5 + 0.5 * facing * at.sine);
    }
    for (int i = 0; i < slices; i++) {
        const int next = (i + 1) % slices;
        add_triangle(mesh, centre, rim + (facing > 0 ? i : next), rim + (facing > 0 ? next : i));
    }
    return true;
}

/* ---- surfaces of revolution about z ---- */

/* A point of the turned curve, in the half-plane of radius and z. Radius 0 is a pole. */
struct profile {
    double radius, z, normal_radius, normal_z, t;
};

/* Adds the vertices of a ring. Products at a pole may be -0; adding 0 makes them 0, so that all
 * vertices there have the same bits. */
static void add_ring(struct mesh *mesh, const struct profile *point, int slices)
{
    const bool pole = point->radius == 0;

    for (int i = 0; i < (pole ? slices : slices + 1); i++) {
        const struct direction at = circle(2 * (int64_t)i + pole, 2 * (int64_t)slices);
        const struct vector position = {point->radius * at.cosine + 0.0,
                                        point->radius * at.sine + 0.0, point->z};
        const struct vector normal = {point->normal_radius * at.cosine,
                                      point->normal_radius * at.sine, point->normal_z};
        add_vertex(mesh, position, normal, pole ? (i + 0.5) / slices : (double)i / slices,
                   point->t);
    }
}

/* Returns the profile at `step` of `steps`, which goes upwards on the outer side. */
static struct profile profile_at(const struct shape *shape, int step, int steps)
{
    const double share = (double)step / steps, *p = shape->parameter;

    if (shape->kind == SHAPE_SPHERE) { /* half a turn, from the pole at -z */
        const struct direction at = circle(step, 2 * (int64_t)steps);
        return (struct profile){p[0] * at.sine, p[0] * (0 - at.cosine), at.sine, 0 - at.cosine,
                                share};
    }
    if (shape->kind == SHAPE_TORUS) {
        const struct direction at = circle(step, steps);
        return (struct profile){p[1] + p[0] * at.cosine, p[0] * at.sine, at.cosine, at.sine, share};
    }
    /* A cylinder's or a cone's side, standing on z = -height / 2. */
    const double top = shape->kind == SHAPE_CONE ? 0 : 1, height = p[1];
    const struct vector normal = vector_normalise((struct vector){height, 0, p[0] * (1 - top)});
    return (struct profile){p[0] * (1 - (1 - top) * share), height * (share - 0.5), normal.x,
                            normal.z, share};
}

/* Turns the shape's profile about the z axis. */
static bool add_revolution(const struct shape *shape, int steps, int slices, struct mesh *mesh,
                           struct error *err)
{
    const size_t n = (size_t)slices, rows = (size_t)steps;
    struct profile last = {.radius = 0};

    if (!mesh_begin(mesh, (rows + 1) * (n + 1), 2 * rows * n, err))
        return false;
    for (int i = 0, below = 0; i <= steps; i++) {
        const int ring = mesh->n_vertices;
        const struct profile point = profile_at(shape, i, steps);
        add_ring(mesh, &point, slices);
        if (i > 0)
            add_band(mesh, below, last.radius == 0, ring, point.radius == 0, slices);
        below = ring;
        last = point;
    }
    return true;
}

/* ---- the teapot ---- */

enum { TEAPOT_POINTS = 290, TEAPOT_PATCHES = 32 };

/* Cubic Bernstein weights at index/count, and a third of their derivatives. Mirrored indices give
 * mirrored weights in every bit. */
struct bernstein {
    double value[4], slope[4];
};

static struct bernstein bernstein_at(int index, int count)
{
    const double u = (double)index / count, v = (double)(count - index) / count;

    return (struct bernstein){{v * v * v, 3 * (v * v * u), 3 * (u * u * v), u * u * u},
                              {-(v * v), v * v - 2 * (u * v), 2 * (u * v) - u * u, u * u}};
}

/* Returns the sum of the weighted points, in an order that gives the same bits for the reversed
 * curve: patches that share an edge may run along it in opposite directions. */
static struct vector weigh(const struct vector point[4], const double weight[4])
{
    return vector_add(
        vector_add(vector_scale(point[0], weight[0]), vector_scale(point[3], weight[3])),
        vector_add(vector_scale(point[1], weight[1]), vector_scale(point[2], weight[2])));
}

/* Returns the outward normal of a patch whose first row is one point. The tangents there, along the
 * two sides of the patch, span the tangent plane. */
static struct vector pole_normal(const struct vector point[16])
{
    return vector_cross(vector_subtract(point[7], point[0]), vector_subtract(point[4], point[0]));
}

/* Returns a vertex of a patch in the teapot's own coordinates; the normal has any length. */
static struct vertex patch_vertex(const struct vector point[16], const struct bernstein *row,
                                  const struct bernstein *column, bool pole)
{
    struct vector across[4], along[4];
    struct vertex out = {.s = 0};

    for (int i = 0; i < 4; i++) {
        across[i] = weigh(&point[4 * i], column->value);
        along[i] = weigh(&point[4 * i], column->slope);
    }
    /* Weights add up to 1 within rounding only, but a pole is one exact point. */
    out.position = pole ? point[0] : weigh(across, row->value);
    out.normal = pole ? pole_normal(point)
                      : vector_cross(weigh(along, row->value), weigh(across, row->slope));
    return out;
}

/* Turns the teapot from z up to y up, as in glutSolidTeapot. Adding 0 makes -0 into 0, so that
 * seams agree in that bit, too. */
static struct vector teapot_upright(struct vector a)
{
    return (struct vector){a.x + 0.0, a.z + 0.0, 0.0 - a.y};
}

/* Adds a patch of so many divisions along each side. `pole` means that its first row is one point.
 */
static void add_patch(struct mesh *mesh, const struct vector point[16], bool pole, int divisions,
                      double size)
{
    int previous = 0;

    for (int row = 0; row <= divisions; row++) {
        const struct bernstein rows = bernstein_at(row, divisions);
        const bool at_pole = pole && row == 0;
        const int first = mesh->n_vertices;
        for (int column = 0; column < divisions + !at_pole; column++) {
            const struct bernstein columns = bernstein_at(column, divisions);
            struct vertex vertex = patch_vertex(point, &rows, &columns, at_pole);
            vertex.position.z -= 1.5;
            add_vertex(mesh, vector_scale(teapot_upright(vertex.position), size / 2),
                       vector_normalise(teapot_upright(vertex.normal)),
                       1 - (column + (at_pole ? 0.5 : 0)) / divisions, 1 - (double)row / divisions);
        }
        if (row > 0)
            add_band(mesh, previous, pole && row == 1, first, false, divisions);
        previous = first;
    }
}

static bool read_patch(struct text *text, const struct vector *points, int n_points,
                       struct vector patch[16], bool *pole, struct error *err)
{
    long index, last = -1;

    for (int i = 0; i < 16; i++, last = index) {
        if (!text_integer(text, "point of a patch", 0, n_points - 1, &index, err))
            return false;
        patch[i] = points[index];
        if (i == 1)
            *pole = index == last;
    }
    return text_end(text, "a patch", err);
}

static bool read_teapot(struct text *text, const struct shape *shape, struct mesh *out,
                        struct error *err)
{
    struct vector points[TEAPOT_POINTS], patch[16];
    struct word word;
    int n_points = 0, n_patches = 0;
    bool good = true, pole = false;

    while (good && text_next_line(text)) {
        if (!text_word(text, &word))
            continue;
        if (word_is(&word, "point") && n_points < TEAPOT_POINTS) {
            good = text_vector(text, "point", &points[n_points++], err) &&
                   text_end(text, "a point", err);
        } else if (n_patches++ < TEAPOT_PATCHES) {
            good = read_patch(text, points, n_points, patch, &pole, err);
            if (good)
                add_patch(out, patch, pole, (int)shape->parameter[1], shape->parameter[0]);
        }
    }
    return good && (n_patches == TEAPOT_PATCHES ||
                    error_at(err, text_whole(text), "expected %d patches, found %d", TEAPOT_PATCHES,
                             n_patches));
}

static bool build_teapot(const struct shape *shape, struct mesh *out, struct error *err)
{
    const size_t n = (size_t)shape->parameter[1];
    struct text text;

    if (!text_open(&text, "builtin:models/teapot.txt", shape->place, err))
        return false;
    const bool good =
        mesh_begin(out, TEAPOT_PATCHES * (n + 1) * (n + 1), TEAPOT_PATCHES * 2 * n * n, err) &&
        read_teapot(&text, shape, out, err);
    text_free(&text);
    return good;
}

/* ---- any shape ---- */

static bool build(const struct shape *shape, struct mesh *out, struct error *err)
{
    const double *p = shape->parameter;

    switch (shape->kind) {
    case SHAPE_SPHERE:
        return add_revolution(shape, (int)p[2], (int)p[1], out, err);
    case SHAPE_TORUS:
        return add_revolution(shape, (int)p[2], (int)p[3], out, err);
    case SHAPE_BOX:
        return build_box(p, out, err);
    case SHAPE_PLANE:
        return add_face(out, p, 4, err); /* its depth is 0 */
    case SHAPE_CYLINDER:
        return add_revolution(shape, (int)p[3], (int)p[2], out, err) &&
               add_disk(out, p[0], -0.5 * p[1], -1, (int)p[2], err) &&
               add_disk(out, p[0], 0.5 * p[1], 1, (int)p[2], err);
    case SHAPE_CONE:
        return add_revolution(shape, (int)p[3], (int)p[2], out, err) &&
               add_disk(out, p[0], -0.5 * p[1], -1, (int)p[2], err);
    case SHAPE_DISK:
        return add_disk(out, p[0], 0, 1, (int)p[1], err);
    case SHAPE_TEAPOT:
        return build_teapot(shape, out, err);
    case SHAPE_MESH:
        return mesh_read(shape->path, shape->place, shape->unitize, shape->crease_deg, out, err);
    }
    assert(false);
    return false;
}

bool shape_build(const struct shape *shape, struct mesh *out, struct error *err)
{
    *out = (struct mesh){.place = shape->place};
    if (build(shape, out, err))
        return true;
    mesh_free(out);
    return false;
}

void shape_free(struct shape *shape)
{
    free(shape->path);
    *shape = (struct shape){.path = NULL};
}
