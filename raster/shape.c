/* SPDX-License-Identifier: MIT */
/* The built-in solids as triangles. Positions along a seam are computed once or from the same
 * numbers by the same steps, so that neighbours agree in every bit and no crack can open; sines and
 * cosines are our own, so that a shape has the same bytes on every machine. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "spectral.h"

/* ---- the circle ---- */

struct direction {
    double cosine, sine;
};

/* Of part/whole of 45 degrees, 0 <= part <= whole < 2^33. Taylor series of the angle x + rest: the
 * first term left out is below x^18/18! < 2^-58, and x + rest carries the angle to 2^-74, so that
 * what remains is the rounding of the last additions: less than 1.5 units in the last place. */
static struct direction eighth_circle(uint64_t part, uint64_t whole)
{
    /* pi/4 in two pieces; the first has 21 bits, so that its product with head is exact. */
    const double quarter_pi = 0x1.921fbp-1, quarter_pi_rest = 0x1.5110b4611a626p-23;
    const double head = (double)((part << 31) / whole) * 0x1p-31; /* 31 bits of the quotient */
    const double tail = (double)((part << 31) % whole) / (double)whole * 0x1p-31;
    const double exact = quarter_pi * head;
    const double small = quarter_pi_rest * head + (quarter_pi + quarter_pi_rest) * tail;
    const double x = exact + small, rest = small - (x - exact), square = x * x;
    double even = 1, odd = 1;

    if (part == whole) /* 45 degrees: sqrt(1/2), rounded correctly */
        return (struct direction){0x1.6a09e667f3bcdp-1, 0x1.6a09e667f3bcdp-1};
    for (int k = 15; k >= 3; k -= 2) {
        even = 1 - square / (k * (k + 1)) * even;
        odd = 1 - square / ((k + 1) * (k + 2)) * odd;
    }
    const double cosine = 1 - (square / 2 * even + rest * x);
    return (struct direction){cosine, x + (rest * cosine - x * square / 6 * odd)};
}

/* At index/count of a full turn. The same fraction gives the same bits, multiples of 90 degrees are
 * exact, and mirrored directions differ in sign or order only. */
static struct direction circle(int64_t index, int64_t count)
{
    assert(index >= 0 && count > 0);
    const int64_t eighths = 8 * (index % count), octant = eighths / count;
    const int64_t past = eighths % count, part = octant % 2 ? count - past : past;
    struct direction at = eighth_circle((uint64_t)part, (uint64_t)count);

    if (octant % 4 == 1 || octant % 4 == 2)
        at = (struct direction){at.sine, at.cosine};
    if (octant >= 2 && octant < 6) /* 0 - 0 is +0: no negative zeros */
        at.cosine = 0 - at.cosine;
    if (octant >= 4)
        at.sine = 0 - at.sine;
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
    int32_t *corner = mesh->triangles[mesh->n_triangles++];

    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
}

/* Two triangles per quadrilateral between a lower and an upper row; where a row is a pole, its
 * vertices sit between those of the other row, and the triangle without area is left out. */
static void add_band(struct mesh *mesh, int low, bool low_pole, int high, bool high_pole, int count)
{
    for (int i = 0; i < count; i++) {
        if (!low_pole)
            add_triangle(mesh, low + i, low + i + 1, high_pole ? high + i : high + i + 1);
        if (!high_pole)
            add_triangle(mesh, low + i, high + i + 1, high + i);
    }
}

/* Counter-clockwise corners, with one unit square of texture. */
static bool add_quad(struct mesh *mesh, const struct vector corner[4], struct vector normal,
                     struct error *err)
{
    const int first = mesh->n_vertices;

    if (!mesh_reserve(mesh, 4, 2, err))
        return false;
    for (int i = 0; i < 4; i++)
        add_vertex(mesh, corner[i], normal, i == 1 || i == 2, i >= 2);
    add_triangle(mesh, first, first + 1, first + 2);
    add_triangle(mesh, first, first + 2, first + 3);
    return true;
}

/* A flat disk about the z axis; `facing` is the z of its normal, 1 or -1. */
static bool add_disk(struct mesh *mesh, double radius, double z, double facing, int slices,
                     struct error *err)
{
    const int centre = mesh->n_vertices, rim = centre + 1;
    const struct vector normal = {0, 0, facing};

    if (!mesh_reserve(mesh, (size_t)slices + 1, (size_t)slices, err))
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

/* A pole's products may be -0; adding 0 makes them 0: all its vertices have the same bits. */
static void add_ring(struct mesh *mesh, const struct profile *point,
                     const struct direction *half_steps, int slices)
{
    const bool pole = point->radius == 0;

    for (int i = 0; i < (pole ? slices : slices + 1); i++) {
        const struct direction at = half_steps[pole ? 2 * i + 1 : 2 * (i % slices)];
        const struct vector position = {point->radius * at.cosine + 0.0,
                                        point->radius * at.sine + 0.0, point->z};
        const struct vector normal = {point->normal_radius * at.cosine,
                                      point->normal_radius * at.sine, point->normal_z};
        add_vertex(mesh, position, normal, pole ? (i + 0.5) / slices : (double)i / slices,
                   point->t);
    }
}

/* Turns the profile, which runs upwards on the outer side, about the z axis. */
static bool add_revolution(struct mesh *mesh, const struct profile *profile, int count, int slices,
                           struct error *err)
{
    const size_t n = (size_t)slices;
    struct direction *half_steps;

    if (n > INT32_MAX / 2 || !(half_steps = malloc(2 * n * sizeof *half_steps)))
        return error_memory(err);
    if (!mesh_reserve(mesh, (size_t)count * (n + 1), 2 * (size_t)(count - 1) * n, err)) {
        free(half_steps);
        return false;
    }
    for (int i = 0; i < 2 * slices; i++)
        half_steps[i] = circle(i, 2 * slices);
    for (int i = 0, previous = 0; i < count; i++) {
        const int ring = mesh->n_vertices;
        add_ring(mesh, &profile[i], half_steps, slices);
        if (i > 0)
            add_band(mesh, previous, profile[i - 1].radius == 0, ring, profile[i].radius == 0,
                     slices);
        previous = ring;
    }
    free(half_steps);
    return true;
}

static struct profile *profile_allocate(int count, struct error *err)
{
    struct profile *profile = malloc((size_t)count * sizeof *profile);

    if (!profile)
        error_memory(err);
    return profile;
}

static bool build_sphere(double radius, int slices, int stacks, struct mesh *out,
                         struct error *err)
{
    struct profile *profile = profile_allocate(stacks + 1, err);

    if (!profile)
        return false;
    for (int i = 0; i <= stacks; i++) { /* half a turn, from the pole at -z */
        const struct direction at = circle(i, 2 * (int64_t)stacks);
        profile[i] = (struct profile){radius * at.sine, radius * (0 - at.cosine), at.sine,
                                      0 - at.cosine, (double)i / stacks};
    }
    const bool built = add_revolution(out, profile, stacks + 1, slices, err);
    free(profile);
    return built;
}

static bool build_torus(double tube, double ring, int sides, int rings, struct mesh *out,
                        struct error *err)
{
    struct profile *profile = profile_allocate(sides + 1, err);

    if (!profile)
        return false;
    for (int i = 0; i <= sides; i++) {
        const struct direction at = circle(i, sides);
        profile[i] = (struct profile){ring + tube * at.cosine, tube * at.sine, at.cosine, at.sine,
                                      (double)i / sides};
    }
    const bool built = add_revolution(out, profile, sides + 1, rings, err);
    free(profile);
    return built;
}

/* The side of a cylinder (top_share 1) or a cone (top_share 0) standing on z = -height / 2. */
static bool add_side(double radius, double top_share, double height, int slices, int stacks,
                     struct mesh *out, struct error *err)
{
    const double narrowing = radius * (1 - top_share);
    const struct vector normal = vector_normalise((struct vector){height, 0, narrowing});
    struct profile *profile = profile_allocate(stacks + 1, err);

    if (!profile)
        return false;
    for (int i = 0; i <= stacks; i++) {
        const double share = (double)i / stacks;
        profile[i] = (struct profile){radius * (1 - (1 - top_share) * share),
                                      height * (share - 0.5), normal.x, normal.z, share};
    }
    const bool built = add_revolution(out, profile, stacks + 1, slices, err);
    free(profile);
    return built;
}

/* ---- flat shapes ---- */

static bool build_plane(double width, double height, struct mesh *out, struct error *err)
{
    const double x = width / 2, y = height / 2;
    const struct vector corner[4] = {{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}};

    return add_quad(out, corner, (struct vector){0, 0, 1}, err);
}

/* Faces along x, y and z in turn; the right and up of a face's texture follow the face's axis in
 * the cycle x y z, the right one turned round on the negative side to stay counter-clockwise. */
static bool build_box(const double size[3], struct mesh *out, struct error *err)
{
    for (int face = 0; face < 6; face++) {
        const int axis = face / 2, right = (axis + 1) % 3, up = (axis + 2) % 3;
        const double side = face % 2 ? -1 : 1;
        double normal[3] = {0, 0, 0}, at[3];
        struct vector corner[4];

        normal[axis] = side;
        at[axis] = side * size[axis] / 2;
        for (int i = 0; i < 4; i++) {
            at[right] = (i == 1 || i == 2 ? side : -side) * size[right] / 2;
            at[up] = (i >= 2 ? 1 : -1) * size[up] / 2;
            corner[i] = (struct vector){at[0], at[1], at[2]};
        }
        if (!add_quad(out, corner, (struct vector){normal[0], normal[1], normal[2]}, err))
            return false;
    }
    return true;
}

/* ---- the teapot ---- */

enum { TEAPOT_POINTS = 290, TEAPOT_PATCHES = 32 };

struct teapot {
    struct vector point[TEAPOT_POINTS];
    int patch[TEAPOT_PATCHES][16];
    int n_points, n_patches;
};

static bool read_teapot_line(struct text *text, struct teapot *out, struct error *err)
{
    struct word word;
    long index;

    if (!text_word(text, &word))
        return true;
    if (word_is(&word, "point") && out->n_points < TEAPOT_POINTS) {
        struct vector *point = &out->point[out->n_points++];
        return text_number(text, "x", -HUGE_VAL, HUGE_VAL, &point->x, err) &&
               text_number(text, "y", -HUGE_VAL, HUGE_VAL, &point->y, err) &&
               text_number(text, "z", -HUGE_VAL, HUGE_VAL, &point->z, err) &&
               text_end(text, "a point", err);
    }
    if (!word_is(&word, "patch") || out->n_patches == TEAPOT_PATCHES)
        return error_at(err, word.place, "expected %d points, then %d patches", TEAPOT_POINTS,
                        TEAPOT_PATCHES);
    for (int i = 0; i < 16; i++) {
        if (!text_integer(text, "point of a patch", 0, out->n_points - 1, &index, err))
            return false;
        out->patch[out->n_patches][i] = (int)index;
    }
    out->n_patches++;
    return text_end(text, "a patch", err);
}

static bool read_teapot(struct place from, struct teapot *out, struct error *err)
{
    struct text text;
    bool good = true;

    if (!text_open(&text, "builtin:models/teapot.txt", from, err))
        return false;
    while (good && text_next_line(&text))
        good = read_teapot_line(&text, out, err);
    if (good && out->n_patches < TEAPOT_PATCHES)
        good = error_at(err, text_whole(&text), "ends after %d patches of %d", out->n_patches,
                        TEAPOT_PATCHES);
    text_free(&text);
    return good;
}

static bool same_point(struct vector a, struct vector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool all_the_same(const struct vector point[4])
{
    return same_point(point[0], point[1]) && same_point(point[0], point[2]) &&
           same_point(point[0], point[3]);
}

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

/* The sum of the weighted points, in an order in which a curve run backwards has the same bits:
 * patches that share an edge may run along it in opposite directions. */
static struct vector weigh(const struct vector point[4], const double weight[4])
{
    return vector_add(vector_add(vector_scale(point[0], weight[0]),
                                 vector_scale(point[3], weight[3])),
                      vector_add(vector_scale(point[1], weight[1]),
                                 vector_scale(point[2], weight[2])));
}

/* The outward normal where a patch's first row is one point: that point's tangents along the two
 * sides of the patch span the tangent plane. */
static struct vector pole_normal(const struct vector point[16])
{
    return vector_cross(vector_subtract(point[7], point[0]), vector_subtract(point[4], point[0]));
}

/* A vertex of a patch, in the teapot's own coordinates, the normal of any length. */
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

/* z up about 1.5 becomes y up about the origin, at half the size: as glutSolidTeapot has it.
 * Adding 0 makes -0 into 0, so that seams agree in that bit too. */
static struct vector teapot_upright(struct vector a)
{
    return (struct vector){a.x + 0.0, a.z + 0.0, 0.0 - a.y};
}

static void add_patch(struct mesh *mesh, const struct vector point[16],
                      const struct bernstein *steps, int divisions, double size)
{
    const bool pole = all_the_same(point);
    int previous = 0;

    for (int row = 0; row <= divisions; row++) {
        const bool at_pole = pole && row == 0;
        const int first = mesh->n_vertices;
        for (int column = 0; column < divisions + !at_pole; column++) {
            struct vertex vertex = patch_vertex(point, &steps[row], &steps[column], at_pole);
            vertex.position.z -= 1.5;
            add_vertex(mesh, vector_scale(teapot_upright(vertex.position), size / 2),
                       vector_normalise(teapot_upright(vertex.normal)),
                       1 - (column + (at_pole ? 0.5 : 0)) / divisions,
                       1 - (double)row / divisions);
        }
        if (row > 0)
            add_band(mesh, previous, pole && row == 1, first, false, divisions);
        previous = first;
    }
}

static bool build_teapot(double size, int divisions, struct place place, struct mesh *out,
                         struct error *err)
{
    const size_t n = (size_t)divisions;
    struct teapot teapot = {.n_points = 0};
    struct bernstein *steps;

    if (!read_teapot(place, &teapot, err))
        return false;
    if (!mesh_reserve(out, TEAPOT_PATCHES * (n + 1) * (n + 1), TEAPOT_PATCHES * 2 * n * n, err))
        return false;
    if (!(steps = malloc((n + 1) * sizeof *steps)))
        return error_memory(err);
    for (int i = 0; i <= divisions; i++)
        steps[i] = bernstein_at(i, divisions);
    for (int i = 0; i < TEAPOT_PATCHES; i++) {
        struct vector point[16];
        for (int j = 0; j < 16; j++)
            point[j] = teapot.point[teapot.patch[i][j]];
        add_patch(out, point, steps, divisions, size);
    }
    free(steps);
    return true;
}

/* ---- any shape ---- */

static bool build(const struct shape *shape, struct mesh *out, struct error *err)
{
    const double *p = shape->parameter;

    switch (shape->kind) {
    case SHAPE_SPHERE:
        return build_sphere(p[0], (int)p[1], (int)p[2], out, err);
    case SHAPE_TORUS:
        return build_torus(p[0], p[1], (int)p[2], (int)p[3], out, err);
    case SHAPE_BOX:
        return build_box(p, out, err);
    case SHAPE_PLANE:
        return build_plane(p[0], p[1], out, err);
    case SHAPE_CYLINDER:
        return add_side(p[0], 1, p[1], (int)p[2], (int)p[3], out, err) &&
               add_disk(out, p[0], -0.5 * p[1], -1, (int)p[2], err) &&
               add_disk(out, p[0], 0.5 * p[1], 1, (int)p[2], err);
    case SHAPE_CONE:
        return add_side(p[0], 0, p[1], (int)p[2], (int)p[3], out, err) &&
               add_disk(out, p[0], -0.5 * p[1], -1, (int)p[2], err);
    case SHAPE_DISK:
        return add_disk(out, p[0], 0, 1, (int)p[1], err);
    case SHAPE_TEAPOT:
        return build_teapot(p[0], (int)p[1], shape->place, out, err);
    case SHAPE_MESH:
        return mesh_read(shape->path, shape->place, shape->unitize, shape->crease_deg, out, err);
    }
    assert(false);
    return false;
}

bool shape_build(const struct shape *shape, struct mesh *out, struct error *err)
{
    *out = (struct mesh){.n_vertices = 0};
    if (build(shape, out, err))
        return true;
    mesh_free(out);
    return false;
}
