/* SPDX-License-Identifier: MIT */
/* Compares the built-in shapes with closed forms. Both renderers share them, so no other test would
 * find their errors. */
#include <float.h>

#include "solid.h"

/* A solid to check; `holes` is the number of holes through it. */
struct closed_shape {
    const char *name;
    enum shape_kind kind;
    double parameter[4];
    int holes;
    double volume; /* of the polyhedron */
};

/* Returns the area of a regular n-gon of circumradius 1. */
static double regular_area(double n)
{
    return n / 2 * sin(2 * PI / n);
}

/* Returns the volume of a lathe of n slices, that is a stack of frusta over regular n-gons. */
static double sphere_volume(double radius, int slices, int stacks)
{
    double sum = 0;

    for (int i = 0; i < stacks; i++) {
        const double a = PI * i / stacks, b = PI * (i + 1) / stacks;
        sum += (cos(a) - cos(b)) * (sin(a) * sin(a) + sin(a) * sin(b) + sin(b) * sin(b)) / 3;
    }
    return radius * radius * radius * regular_area(slices) * sum;
}

/* Returns a volume by Pappus's theorem, with regular polygons for both circles. */
static double torus_volume(double tube, double ring, int sides, int rings)
{
    return regular_area(rings) * 2 * ring * regular_area(sides) * tube * tube;
}

static void check_closed(const struct closed_shape *shape)
{
    struct mesh mesh = solid_build(shape->kind, shape->parameter);
    const struct solid solid = solid_measure(&mesh);

    CHECK(solid.open_edges == 0 && solid.repeated_edges == 0,
          "%s: each edge meets its reverse exactly once", shape->name);
    CHECK(solid_euler(&solid, &mesh) == 2 - 2 * shape->holes, "%s: Euler characteristic %d",
          shape->name, 2 - 2 * shape->holes);
    /* Rounding adds at most a few epsilons of the whole for each triangle. */
    CHECK_NEAR(solid.volume / shape->volume, 1, 4 * DBL_EPSILON * mesh.n_triangles,
               "%s: it faces outwards and has the polyhedron's volume", shape->name);
    CHECK_NEAR(solid.worst_length, 0, 4 * DBL_EPSILON, "%s: normals have unit length", shape->name);
    CHECK(solid.worst_facing > 0, "%s: normals are on the side of their triangles' normals",
          shape->name);
    CHECK(solid.worst_area > 1e-4, "%s: every triangle has an area", shape->name);
    CHECK(solid.texture_inside, "%s: texture coordinates lie in [0, 1]", shape->name);
    CHECK(shape_is_solid(shape->kind), "%s: it counts as a solid", shape->name);
    mesh_free(&mesh);
}

static void check_solids(void)
{
    const struct closed_shape shapes[] = {
        {"sphere", SHAPE_SPHERE, {2.8, 30, 30, 0}, 0, sphere_volume(2.8, 30, 30)},
        {"odd sphere", SHAPE_SPHERE, {1, 7, 5, 0}, 0, sphere_volume(1, 7, 5)},
        {"smallest sphere", SHAPE_SPHERE, {1, 3, 2, 0}, 0, sphere_volume(1, 3, 2)},
        {"tiny sphere", SHAPE_SPHERE, {1e-30, 9, 8, 0}, 0, sphere_volume(1e-30, 9, 8)},
        {"huge sphere", SHAPE_SPHERE, {1e30, 9, 8, 0}, 0, sphere_volume(1e30, 9, 8)},
        {"torus", SHAPE_TORUS, {1.05, 1.65, 30, 30}, 1, torus_volume(1.05, 1.65, 30, 30)},
        {"odd torus", SHAPE_TORUS, {0.2, 1, 5, 7}, 1, torus_volume(0.2, 1, 5, 7)},
        {"box", SHAPE_BOX, {1, 2, 3, 1}, 0, 6},
        {"divided box", SHAPE_BOX, {1, 2, 3, 7}, 0, 6},
        {"cylinder", SHAPE_CYLINDER, {1.5, 4, 13, 6}, 0, regular_area(13) * 2.25 * 4},
        {"low cylinder", SHAPE_CYLINDER, {1, 0.3, 4, 1}, 0, 2 * 0.3},
        {"cone", SHAPE_CONE, {1.5, 4, 13, 6}, 0, regular_area(13) * 2.25 * 4 / 3},
        {"low cone", SHAPE_CONE, {1, 0.3, 3, 1}, 0, regular_area(3) * 0.1}};

    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++)
        check_closed(&shapes[i]);
}

/* The rim of a disk of radius 1 has the cosines and sines that test_elementary.c compares. */
static void check_circle(void)
{
    int wrong = 0;
    for (int n = 3; n < 400; n++) {
        struct mesh mesh = solid_build(SHAPE_DISK, (const double[4]){1, n, 1, 0});
        for (int i = 0; i < n; i++) {
            const struct vector p = mesh.vertices[1 + i].position;
            double sine, cosine;
            sine_cosine_of_turn(i, n, &sine, &cosine);
            wrong += p.x != cosine || p.y != sine;
        }
        mesh_free(&mesh);
    }
    CHECK(wrong == 0, "3 to 399 slices lie at equal parts of a turn, to the bit (%d do not)",
          wrong);
}

static void check_curved_normals(void)
{
    const double sphere[4] = {2.8, 30, 30, 0}, torus[4] = {1.05, 1.65, 30, 30};
    struct mesh mesh = solid_build(SHAPE_SPHERE, sphere);
    double worst = 0;

    for (int i = 0; i < mesh.n_vertices; i++)
        worst = fmax(worst, solid_distance(vector_scale(mesh.vertices[i].position, 1 / 2.8),
                                           mesh.vertices[i].normal));
    CHECK_NEAR(worst, 0, 4 * DBL_EPSILON, "sphere: a normal is the position over the radius");
    mesh_free(&mesh);
    mesh = solid_build(SHAPE_TORUS, torus);
    worst = 0;
    for (int i = 0; i < mesh.n_vertices; i++) {
        const struct vector p = mesh.vertices[i].position;
        const double from_axis = hypot(p.x, p.y);
        const struct vector core = {1.65 * p.x / from_axis, 1.65 * p.y / from_axis, 0};
        worst = fmax(worst, solid_distance(vector_scale(vector_subtract(p, core), 1 / 1.05),
                                           mesh.vertices[i].normal));
    }
    CHECK_NEAR(worst, 0, 16 * DBL_EPSILON, "torus: a normal points from the ring's core");
    mesh_free(&mesh);
}

static void check_cone_normals(void)
{
    const double cone[4] = {3, 4, 12, 2};
    struct mesh mesh = solid_build(SHAPE_CONE, cone);
    const struct vector apex = {0, 0, 2};
    double worst = 0;
    int tips = 0;

    for (int i = 0; i < mesh.n_vertices; i++) {
        const struct vertex *v = &mesh.vertices[i];
        if (v->normal.z < 0)
            continue;
        tips += v->position.z == 2;
        worst = fmax(worst, fabs(vector_dot(v->normal, vector_subtract(v->position, apex))));
        worst = fmax(worst, fabs(v->normal.z - 0.6)); /* 3-4-5 triangle */
    }
    CHECK_NEAR(worst, 0, 16 * DBL_EPSILON, "cone: normals are perpendicular to its lines");
    CHECK(tips == 12, "cone: each slice has its own tip, with the normal of its middle");
    mesh_free(&mesh);
}

static void check_flat(void)
{
    const struct {
        const char *name;
        enum shape_kind kind;
        double parameter[4], area;
        int triangles;
    } shapes[] = {{"plane", SHAPE_PLANE, {4, 3, 2, 0}, 12, 8},
                  {"disk", SHAPE_DISK, {2, 5, 3, 0}, 4 * regular_area(5), 25}};

    for (int i = 0; i < 2; i++) {
        struct mesh mesh = solid_build(shapes[i].kind, shapes[i].parameter);
        bool upright = true;
        for (int k = 0; k < mesh.n_vertices; k++) {
            const struct vector n = mesh.vertices[k].normal;
            upright = upright && n.x == 0 && n.y == 0 && n.z == 1;
        }
        CHECK(upright && mesh.n_triangles == shapes[i].triangles, "%s faces +z with %d triangles",
              shapes[i].name, shapes[i].triangles);
        CHECK_NEAR(solid_measure(&mesh).area_z, shapes[i].area, 16 * DBL_EPSILON,
                   "%s has its area, counter-clockwise", shapes[i].name);
        mesh_free(&mesh);
    }
}

/* Seen from outside, s runs to the right and t upwards: s, t and normal are right-handed. */
static void check_texture_direction(void)
{
    const struct {
        const char *name;
        enum shape_kind kind;
        double parameter[4];
    } shapes[] = {
        {"sphere", SHAPE_SPHERE, {1, 12, 6, 0}}, {"torus", SHAPE_TORUS, {1, 3, 9, 9}},
        {"box", SHAPE_BOX, {1, 2, 3, 3}},        {"plane", SHAPE_PLANE, {1, 2, 3, 0}},
        {"disk", SHAPE_DISK, {1, 9, 3, 0}},      {"cone", SHAPE_CONE, {1, 2, 9, 3}},
        {"teapot", SHAPE_TEAPOT, {1, 4, 0, 0}},  {"cylinder", SHAPE_CYLINDER, {1, 2, 9, 3}}};

    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        struct mesh mesh = solid_build(shapes[i].kind, shapes[i].parameter);
        bool right_handed = true;
        for (int k = 0; k < mesh.n_triangles; k++) {
            const struct vertex *a = &mesh.vertices[mesh.triangles[k][0]];
            const struct vertex *b = &mesh.vertices[mesh.triangles[k][1]];
            const struct vertex *c = &mesh.vertices[mesh.triangles[k][2]];
            right_handed =
                right_handed && (b->s - a->s) * (c->t - a->t) > (b->t - a->t) * (c->s - a->s);
        }
        CHECK(right_handed, "%s: no texture is mirrored", shapes[i].name);
        mesh_free(&mesh);
    }
}

/* Counts the vertices on the axis with a normal exactly along it, upwards at the top. */
static int true_poles(const struct mesh *mesh)
{
    int n = 0;

    for (int i = 0; i < mesh->n_vertices; i++) {
        const struct vertex *v = &mesh->vertices[i];
        n += v->position.x == 0 && v->position.z == 0 && v->normal.x == 0 && v->normal.z == 0 &&
             v->normal.y == (v->position.y > 0 ? 1 : -1);
    }
    return n;
}

static void check_teapot(int divisions)
{
    const double parameter[4] = {2, divisions, 0, 0};
    struct mesh mesh = solid_build(SHAPE_TEAPOT, parameter);
    const struct solid solid = solid_measure(&mesh);
    double lowest = HUGE_VAL, highest = -HUGE_VAL, skew = 0;

    for (int i = 0; i < mesh.n_vertices; i++) {
        lowest = fmin(lowest, mesh.vertices[i].position.y);
        highest = fmax(highest, mesh.vertices[i].position.y);
        skew += mesh.vertices[i].position.z;
    }
    CHECK(mesh.n_triangles == 64 * divisions * divisions - 8 * divisions,
          "teapot %d: each square has two triangles, and one at the poles", divisions);
    /* The lid, the pot's rim, and both ends of handle and spout are open. */
    CHECK(!shape_is_solid(SHAPE_TEAPOT) && solid.open_edges == 16 * divisions &&
              solid.repeated_edges == 0,
          "teapot %d: patches meet along all their edges", divisions);
    CHECK(true_poles(&mesh) == 8 * divisions,
          "teapot %d: poles sit on the axis with normals along it", divisions);
    CHECK_NEAR(solid.worst_length, 0, 4 * DBL_EPSILON, "teapot %d: normals have unit length",
               divisions);
    CHECK(solid.worst_area > 1e-4, "teapot %d: every triangle has an area", divisions);
    CHECK(solid.volume > 0 && solid.texture_inside, "teapot %d: it faces outwards", divisions);
    /* glutSolidTeapot(2): heights 0 to 3.15 less 1.5. */
    CHECK_NEAR(lowest, -1.5, DBL_EPSILON, "teapot %d: its foot is at -0.75 of its size", divisions);
    CHECK_NEAR(highest, 1.65, 2 * DBL_EPSILON, "teapot %d: its top is at 0.825 of its size",
               divisions);
    CHECK_NEAR(skew, 0, 1e-12 * mesh.n_vertices, "teapot %d: both sides are symmetric", divisions);
    if (divisions == 40) /* fewer cut the spout's sharp lip short */
        CHECK(solid.worst_facing > 0.9, "teapot %d: normals are close to their triangles' normals",
              divisions);
    mesh_free(&mesh);
}

int main(void)
{
    const int divisions[] = {2, 3, 7, 14, 40};

    CHECK(!shape_is_solid(SHAPE_PLANE) && !shape_is_solid(SHAPE_DISK) &&
              !shape_is_solid(SHAPE_MESH),
          "what has a border, or may have one, is no solid");
    check_solids();
    check_circle();
    check_curved_normals();
    check_cone_normals();
    check_flat();
    check_texture_direction();
    for (size_t i = 0; i < sizeof divisions / sizeof *divisions; i++)
        check_teapot(divisions[i]);
    return test_end();
}
