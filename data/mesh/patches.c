/* SPDX-License-Identifier: MIT */
/* The surfaces of built-in shapes, by parameters, and the triangles that approximate them: a
 * lattice of places on each patch, and two triangles in each cell. Positions along a seam are
 * computed from the same numbers by the same steps. So neighbours agree in every bit, and no crack
 * can open. */
#include "data/mesh/inside.h"

enum { TEAPOT_PATCHES = 32 };

/* The patches of a shape: cells in columns and rows, whose numbers are sizes of the shape, then
 * disks of as many slices. A pole is a row that is one point. */
static const struct form {
    int n_patches, n_disks, columns, rows; /* the last two: indices of the sizes */
    bool low_pole, high_pole;
} forms[] = {
    [SHAPE_SPHERE] = {1, 0, 1, 2, true, true},
    [SHAPE_TORUS] = {1, 0, 3, 2, false, false},
    [SHAPE_BOX] = {6, 0, 3, 3, false, false},
    [SHAPE_PLANE] = {1, 0, 2, 2, false, false},
    [SHAPE_CYLINDER] = {1, 2, 2, 3, false, false},
    [SHAPE_CONE] = {1, 1, 2, 3, false, true},
    [SHAPE_DISK] = {0, 1, 1, 2, false, false},
    [SHAPE_TEAPOT] = {TEAPOT_PATCHES, 0, 1, 1, false, false},
    [SHAPE_MESH] = {0, 0, 0, 0, false, false},
};

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

/* A flat disk about the z axis, from its centre, v = 0, to its rim, v = rings: the shape of this
 * name, the upper end of a cylinder, or a lower end, which faces -z. */
static struct vertex disk_vertex(const struct shape *shape, int patch, double u, double v)
{
    const struct form *form = &forms[shape->kind];
    const double *p = shape->parameter, facing = patch == 1 ? -1 : 1,
                 z = form->n_patches > 0 ? facing * 0.5 * p[1] : 0;
    const struct direction at = circle(u, p[form->columns]);
    const double rings = form->n_patches > 0 ? 1 : p[form->rows], share = v / rings,
                 radius = p[0] * share;
    return (struct vertex){{radius * at.cosine, radius * at.sine, z},
                           {0, 0, facing},
                           0.5 + 0.5 * share * at.cosine,
                           0.5 + 0.5 * share * facing * at.sine};
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

/* ---- the Utah teapot: bicubic Bézier patches ---- */

enum { PATCH_POINTS = 16 };
struct teapot_patch {
    struct vector point[PATCH_POINTS];
};

/* Returns whether the first row of a patch is one point. */
static bool begins_at_pole(const struct teapot_patch *patch)
{
    return same_place(patch->point[0], patch->point[1]);
}

/* Cubic Bernstein weights at index/count, and a third of their derivatives. Mirrored indices give
 * mirrored weights in every bit. */
struct bernstein {
    double value[4], slope[4];
};

static struct bernstein bernstein_at(double index, double count)
{
    const double u = index / count, v = (count - index) / count;
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

/* Turns the teapot from z up to y up, as in glutSolidTeapot. Adding 0 makes -0 into 0, so that
 * seams agree in that bit, too. */
static struct vector upright(struct vector a)
{
    return (struct vector){a.x + 0.0, a.z + 0.0, 0.0 - a.y};
}

/* Returns the place at row/count and column/count of a patch. */
static struct vertex teapot_vertex(const struct teapot_patch *patch, double size, double column,
                                   double row, double count)
{
    const struct vector *point = patch->point;
    const struct bernstein rows = bernstein_at(row, count), columns = bernstein_at(column, count);
    const bool pole = row == 0 && begins_at_pole(patch);
    struct vector across[4], along[4];
    for (int i = 0; i < 4; i++) {
        across[i] = weigh(&point[4 * i], columns.value);
        along[i] = weigh(&point[4 * i], columns.slope);
    }
    /* Weights add up to 1 within rounding only, but a pole is one exact point. */
    struct vector position = pole ? point[0] : weigh(across, rows.value);
    /* Where the first row is one point, the tangents along the two sides span the tangent plane. */
    const struct vector normal =
        pole
            ? vector_cross(vector_subtract(point[7], point[0]), vector_subtract(point[4], point[0]))
            : vector_cross(weigh(along, rows.value), weigh(across, rows.slope));
    position.z -= 1.5;
    return (struct vertex){vector_scale(upright(position), size / 2),
                           vector_normalise(upright(normal)), 1 - column / count, 1 - row / count};
}

/* ---- any patch ---- */

bool patches_open(const struct shape *shape, struct patches *out, struct error *err)
{
    struct text text;
    struct word word;
    bool done = true;
    *out = (struct patches){.shape = shape};
    if (shape->kind != SHAPE_TEAPOT)
        return true;
    if (!MAKE_ARRAY(out->teapot, TEAPOT_PATCHES, err, "the teapot") ||
        !text_open(&text, "builtin:models/teapot.txt", shape->place, 0, err))
        return false;
    for (int n = 0; done && n < TEAPOT_PATCHES * PATCH_POINTS && text_next_line(&text);)
        for (; done && text_peek(text, &word); n++)
            done = text_vector(&text, "point",
                               &out->teapot[n / PATCH_POINTS].point[n % PATCH_POINTS], err);
    text_free(&text);
    return done;
}

void patches_close(struct patches *patches)
{
    free(patches->teapot);
    *patches = (struct patches){.shape = NULL};
}

/* The ends of a cylinder, the base of a cone, and a disk. */
static bool is_disk(const struct shape *shape, int patch)
{
    return patch >= forms[shape->kind].n_patches;
}

bool patch_is_flat(const struct shape *shape, int patch)
{
    return shape->kind == SHAPE_BOX || shape->kind == SHAPE_PLANE || is_disk(shape, patch);
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
    const struct form *form = &forms[shape->kind];
    const double columns = shape->parameter[form->columns], rows = shape->parameter[form->rows];
    *u = shape->kind == SHAPE_TEAPOT ? between(*u, columns) : around(*u, columns);
    *v = shape->kind == SHAPE_TORUS ? around(*v, rows) : between(*v, rows);
}

struct vertex patch_vertex(const struct patches *patches, int patch, double u, double v)
{
    const struct shape *shape = patches->shape;
    const struct form *form = &forms[shape->kind];
    const double *p = shape->parameter, columns = p[form->columns], rows = p[form->rows];
    const double plane[3] = {p[0], p[1], 0}, cell[2] = {u, v};
    if (shape->kind == SHAPE_TEAPOT)
        return teapot_vertex(&patches->teapot[patch], p[0], u, v, columns);
    if (shape->kind == SHAPE_BOX)
        return face_vertex(p, patch, cell, columns);
    if (shape->kind == SHAPE_PLANE)
        return face_vertex(plane, 4, cell, columns);
    if (is_disk(shape, patch))
        return disk_vertex(shape, patch, u, v);
    return turned_vertex(shape, u, v, columns, rows);
}

/* ---- triangles ---- */

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

/* Adds a patch. The vertices of a pole lie between those of the next row, and its triangles without
 * area are left out. */
static void add_patch(struct mesh *mesh, const struct patches *patches, int patch, int columns,
                      int rows)
{
    const struct form *form = &forms[patches->shape->kind];
    const bool low_pole =
        form->low_pole || (patches->teapot && begins_at_pole(&patches->teapot[patch]));
    int below = 0;
    for (int v = 0; v <= rows; v++) {
        const bool high = form->high_pole && v == rows, pole = high || (low_pole && v == 0);
        const int row = mesh->n_vertices;
        for (int u = 0; u < columns + !pole; u++)
            add_vertex(mesh, patches, patch, u + (pole ? 0.5 : 0), v);
        if (v > 0)
            add_band(mesh, below, low_pole && v == 1, row, high, columns);
        below = row;
    }
}

/* Adds a disk: rings of triangles about its centre. */
static void add_disk(struct mesh *mesh, const struct patches *patches, int patch, int slices,
                     int rings)
{
    const int centre = mesh->n_vertices;
    add_vertex(mesh, patches, patch, 0, 0);
    const bool up = mesh->vertices[centre].normal.z > 0;
    for (int ring = 1; ring <= rings; ring++) {
        for (int i = 0; i < slices; i++)
            add_vertex(mesh, patches, patch, i, ring);
        for (int i = 0; i < slices; i++) {
            const int outer = centre + 1 + (ring - 1) * slices, inner = outer - slices;
            const int from = up ? i : (i + 1) % slices, to = up ? (i + 1) % slices : i;
            add_triangle(mesh, ring == 1 ? centre : inner + from, outer + from, outer + to);
            if (ring > 1)
                add_triangle(mesh, inner + from, outer + to, inner + to);
        }
    }
}

static bool add_all(struct mesh *mesh, const struct patches *patches, struct error *err)
{
    const struct form *form = &forms[patches->shape->kind];
    const int columns = (int)patches->shape->parameter[form->columns],
              rows = (int)patches->shape->parameter[form->rows],
              rings = form->n_patches > 0 ? 1 : rows;
    const size_t n = (size_t)form->n_patches, n_disks = (size_t)form->n_disks, u = (size_t)columns,
                 v = (size_t)rows, w = (size_t)rings;
    if (!mesh_begin(mesh, n * (u + 1) * (v + 1) + n_disks * (u * w + 1),
                    n * 2 * u * v + n_disks * u * (2 * w - 1), err))
        return false;
    for (int i = 0; i < form->n_patches; i++)
        add_patch(mesh, patches, i, columns, rows);
    for (int i = 0; i < form->n_disks; i++)
        add_disk(mesh, patches, form->n_patches + i, columns, rings);
    return true;
}

bool shape_build(const struct shape *shape, struct mesh *out, struct error *err)
{
    struct patches patches;
    if (shape->kind == SHAPE_MESH)
        return mesh_read(shape->path, shape->place, shape->unitize, shape->crease_deg, out, err);
    *out = (struct mesh){.place = shape->place, .parametric = true};
    const bool done = patches_open(shape, &patches, err) && add_all(out, &patches, err);
    patches_close(&patches);
    return done;
}
