/* SPDX-License-Identifier: MIT */
/* Compares displaced meshes with closed forms. */
#include <float.h>

#include "solid.h"

static double spread_height(const struct vertex *at)
{
    return 0.1 * sin(7 * at->s + 3 * at->t) * cos(5 * at->t);
}

/* Displaces by a function of the vertices. */
static void displace(struct mesh *mesh, double (*height)(const struct vertex *), double by)
{
    double *heights = malloc((size_t)mesh->n_vertices * sizeof *heights);
    struct error err = {.text = ""};
    test_need(heights != NULL, "no memory");
    for (int i = 0; i < mesh->n_vertices; i++)
        heights[i] = height ? by * height(&mesh->vertices[i]) : by;
    test_need(mesh_displace(mesh, heights, &err), err.text);
    free(heights);
}

static struct mesh build(enum shape_kind kind, double a, double b, double c, double d)
{
    const double parameter[4] = {a, b, c, d};
    return solid_build(kind, parameter);
}

/* ---- planes ---- */

static double ramp(const struct vertex *at)
{
    return 0.5 + 0.75 * at->position.x - 0.25 * at->position.y;
}

static void check_ramp(void)
{
    struct mesh mesh = build(SHAPE_PLANE, 2, 3, 7, 0), flat = build(SHAPE_PLANE, 2, 3, 7, 0);
    const struct vector normal = vector_normalise((struct vector){-0.75, 0.25, 1});
    double worst = 0, turned = 0;
    displace(&mesh, ramp, 1);
    for (int i = 0; i < mesh.n_vertices; i++) {
        const struct vertex *from = &flat.vertices[i], *to = &mesh.vertices[i];
        const struct vector wanted = {from->position.x, from->position.y, ramp(from)};
        worst = fmax(worst, solid_distance(to->position, wanted));
        turned = fmax(turned, solid_distance(to->normal, normal));
    }
    CHECK_NEAR(worst, 0, 1e-12, "a plane that a ramp displaces is a tilted plane");
    CHECK_NEAR(turned, 0, 1e-12, "with the normal of the tilted plane");
    CHECK(!mesh.parametric && !mesh.parameters, "it is no longer the surface of its shape");
    mesh_free(&mesh);
    mesh_free(&flat);
}

static double wave(const struct vertex *at)
{
    return 0.1 * sin(2 * PI * at->position.x) * cos(PI * at->position.y);
}

/* Returns the largest error of normals; of those inside the plane, or on its border. */
static double wave_error(int divisions, bool border)
{
    struct mesh mesh = build(SHAPE_PLANE, 2, 2, divisions, 0);
    double worst = 0;
    displace(&mesh, wave, 1);
    for (int i = 0; i < mesh.n_vertices; i++) {
        const struct vector p = mesh.vertices[i].position;
        const struct vector wanted =
            vector_normalise((struct vector){-0.2 * PI * cos(2 * PI * p.x) * cos(PI * p.y),
                                             0.1 * PI * sin(2 * PI * p.x) * sin(PI * p.y), 1});
        if ((fmax(fabs(p.x), fabs(p.y)) > 1 - 1e-9) == border)
            worst = fmax(worst, solid_distance(mesh.vertices[i].normal, wanted));
    }
    mesh_free(&mesh);
    return worst;
}

static void check_wave(void)
{
    for (int n = 32; n <= 256; n *= 2) {
        const double inside = wave_error(n, false) / wave_error(2 * n, false),
                     border = wave_error(n, true) / wave_error(2 * n, true);
        CHECK(inside > 3.8 && inside < 4.2,
              "normals of a wave: half as wide triangles, a quarter of the error (%d)", n);
        CHECK(border > 1.9 && border < 4.2, "on the border at most half of it (%d)", n);
    }
}

/* ---- solids ---- */

static void check_sphere(void)
{
    struct mesh mesh = build(SHAPE_SPHERE, 1.5, 40, 30, 0);
    double distance = 0, turned = 0;
    displace(&mesh, NULL, 0.25);
    for (int i = 0; i < mesh.n_vertices; i++) {
        const struct vertex *at = &mesh.vertices[i];
        distance = fmax(distance, fabs(vector_length(at->position) - 1.75));
        turned = fmax(turned, solid_distance(at->normal, vector_normalise(at->position)));
    }
    CHECK_NEAR(distance, 0, 1e-12, "a sphere that a constant displaces is a larger sphere");
    CHECK_NEAR(turned, 0, 1e-12, "with the normals of that sphere");
    mesh_free(&mesh);
}

/* Returns how many different normals the vertices at one place have, over all places. */
static int count_normals(const struct mesh *mesh, const int *place)
{
    int n = 0;
    for (int i = 0; i < mesh->n_vertices; i++) {
        bool known = false;
        for (int k = 0; !known && k < i; k++)
            known = place[k] == place[i] &&
                    solid_distance(mesh->vertices[k].normal, mesh->vertices[i].normal) < 1e-6;
        n += !known;
    }
    return n;
}

static void check_solid(const char *name, struct mesh mesh, int holes, bool open)
{
    int *place = malloc((size_t)mesh.n_vertices * sizeof *place);
    test_need(place != NULL, "no memory");
    const int n_places = solid_merge(&mesh, place), n_normals = count_normals(&mesh, place);
    const struct solid before = solid_measure(&mesh);
    displace(&mesh, spread_height, 1);
    const struct solid after = solid_measure(&mesh);
    CHECK(after.places == n_places && after.open_edges == before.open_edges &&
              (open || after.open_edges == 0) && after.repeated_edges == 0,
          "%s: displaced, its vertices meet where they met", name);
    CHECK(open || solid_euler(&after, &mesh) == 2 - 2 * holes, "%s: it stays closed", name);
    CHECK_NEAR(after.worst_length, 0, 4 * DBL_EPSILON, "%s: its normals have unit length", name);
    solid_merge(&mesh, place);
    CHECK(count_normals(&mesh, place) == n_normals, "%s: creases stay, and nothing else is one",
          name);
    CHECK(after.worst_facing > 0, "%s: its normals are on the side of its triangles", name);
    free(place);
    mesh_free(&mesh);
}

static void check_solids(void)
{
    check_solid("sphere", build(SHAPE_SPHERE, 1, 24, 16, 0), 0, false);
    check_solid("torus", build(SHAPE_TORUS, 0.5, 2, 12, 20), 1, false);
    check_solid("box", build(SHAPE_BOX, 2, 2, 2, 6), 0, false);
    check_solid("cylinder", build(SHAPE_CYLINDER, 1, 2, 12, 5), 0, false);
    check_solid("cone", build(SHAPE_CONE, 1, 2, 12, 5), 0, false);
    check_solid("plane", build(SHAPE_PLANE, 2, 2, 6, 0), 0, true);
}

/* The sides of a box move by the height, an edge along the mean of two normals, a corner of three.
 */
static void check_box(void)
{
    struct mesh mesh = build(SHAPE_BOX, 2, 2, 2, 4), from = build(SHAPE_BOX, 2, 2, 2, 4);
    double worst = 0;
    displace(&mesh, NULL, 0.3);
    for (int i = 0; i < mesh.n_vertices; i++) {
        const struct vector p = from.vertices[i].position, q = mesh.vertices[i].position;
        const int n = (fabs(p.x) == 1) + (fabs(p.y) == 1) + (fabs(p.z) == 1);
        const double by = 0.3 / sqrt(n);
        const struct vector wanted = {p.x + (fabs(p.x) == 1) * by * p.x,
                                      p.y + (fabs(p.y) == 1) * by * p.y,
                                      p.z + (fabs(p.z) == 1) * by * p.z};
        worst = fmax(worst, solid_distance(q, wanted));
    }
    CHECK_NEAR(worst, 0, 1e-12, "edges of a box move along the mean of their sides' normals");
    mesh_free(&mesh);
    mesh_free(&from);
}

static double side_height(const struct vertex *at)
{
    return fabs(at->normal.z) < 0.5 ? 0.2 : 0.4; /* the side of a cylinder, and its ends */
}

/* All vertices of a rim move alike, also at the seam, where the side has two. */
static void check_rim(void)
{
    struct mesh mesh = build(SHAPE_CYLINDER, 1, 2, 12, 1);
    double worst = 0;
    displace(&mesh, side_height, 1);
    for (int i = 0; i < mesh.n_vertices; i++) {
        const struct vector p = mesh.vertices[i].position;
        const double radius = sqrt(p.x * p.x + p.y * p.y);
        if (radius > 0.5)
            worst =
                fmax(worst, fabs(radius - 1 - 0.3 / sqrt(2)) + fabs(fabs(p.z) - 1 - 0.3 / sqrt(2)));
    }
    CHECK_NEAR(worst, 0, 1e-12, "a rim moves by the mean of its heights, also at the seam");
    mesh_free(&mesh);
}

/* ---- no normals, others, no height ---- */

static void check_nothing(void)
{
    struct mesh mesh = build(SHAPE_TEAPOT, 1, 6, 0, 0), from = build(SHAPE_TEAPOT, 1, 6, 0, 0);
    double moved = 0, turned = 0;
    displace(&mesh, NULL, 0);
    for (int i = 0; i < mesh.n_vertices; i++) {
        moved += solid_distance(mesh.vertices[i].position, from.vertices[i].position);
        turned = fmax(turned, solid_distance(mesh.vertices[i].normal, from.vertices[i].normal));
    }
    CHECK(moved == 0, "height 0 moves nothing");
    CHECK_NEAR(turned, 0, 2 * DBL_EPSILON, "and turns no normal");
    mesh_free(&mesh);
    mesh_free(&from);
}

static struct mesh two_triangles(struct vertex vertices[6], int32_t triangles[2][3])
{
    return (struct mesh){.vertices = vertices,
                         .triangles = triangles,
                         .n_vertices = 6,
                         .n_triangles = 2,
                         .n_parts = 1};
}

/* They lie back to back. */
static void check_sheet(void)
{
    struct vertex vertices[6];
    int32_t triangles[2][3] = {{0, 1, 2}, {3, 5, 4}};
    const struct vector corner[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    struct mesh mesh = two_triangles(vertices, triangles);
    for (int i = 0; i < 6; i++)
        vertices[i] = (struct vertex){corner[i % 3], {0, 0, i < 3 ? 1 : -1}, 0, 0};
    displace(&mesh, NULL, 0.5);
    bool same = true;
    for (int i = 0; i < 6; i++)
        same = same && solid_distance(vertices[i].position, corner[i % 3]) == 0 &&
               vertices[i].normal.z == (i < 3 ? 1 : -1);
    CHECK(same, "where normals are opposite, nothing moves");
}

static double by_texture(const struct vertex *at)
{
    return at->s;
}

/* Files write -0, too: that is the same place as 0. */
static void check_minus_zero(void)
{
    struct vertex vertices[6];
    int32_t triangles[2][3] = {{0, 1, 2}, {3, 4, 5}};
    const struct vector corner[6] = {{0.0, 0, 0},  {1, 0, 0},    {0.0, 1, 0},
                                     {-0.0, 0, 0}, {-0.0, 1, 0}, {-1, 0, 0}};
    struct mesh mesh = two_triangles(vertices, triangles);
    for (int i = 0; i < 6; i++)
        vertices[i] = (struct vertex){corner[i], {0, 0, 1}, i < 3 ? 0.2 : 0.4, 0};
    displace(&mesh, by_texture, 1);
    CHECK_NEAR(vertices[0].position.z, 0.3, 1e-15, "-0 is the place of 0");
    CHECK(memcmp(&vertices[0].position, &vertices[3].position, sizeof(struct vector)) == 0 &&
              memcmp(&vertices[2].position, &vertices[4].position, sizeof(struct vector)) == 0,
          "and moves to the same bits");
}

/* Turns all triangles over: their faces are then inside out, while normals stay outward. */
static void check_inside_out(void)
{
    struct mesh mesh = build(SHAPE_TORUS, 0.5, 2, 12, 20),
                other = build(SHAPE_TORUS, 0.5, 2, 12, 20);
    double worst = 0;
    for (int i = 0; i < other.n_triangles; i++) {
        const int32_t kept = other.triangles[i][0];
        other.triangles[i][0] = other.triangles[i][1];
        other.triangles[i][1] = kept;
    }
    displace(&mesh, spread_height, 1);
    displace(&other, spread_height, 1);
    for (int i = 0; i < mesh.n_vertices; i++)
        worst = fmax(worst, solid_distance(mesh.vertices[i].position, other.vertices[i].position) +
                                solid_distance(mesh.vertices[i].normal, other.vertices[i].normal));
    CHECK_NEAR(worst, 0, 1e-12, "faces that are inside out change no normal");
    mesh_free(&mesh);
    mesh_free(&other);
}

/* Heights as large as a scene can have keep normals numbers of unit length. */
static void check_large(void)
{
    const double heights[] = {1e30, -1e30, 1e68, 1e-300};
    for (size_t i = 0; i < sizeof heights / sizeof *heights; i++) {
        struct mesh mesh = build(SHAPE_SPHERE, 1, 12, 8, 0);
        displace(&mesh, spread_height, heights[i]);
        const struct solid solid = solid_measure(&mesh);
        CHECK_NEAR(solid.worst_length, 0, 4 * DBL_EPSILON, "height %g: normals have unit length",
                   heights[i]);
        mesh_free(&mesh);
    }
}

int main(void)
{
    check_ramp();
    check_wave();
    check_sphere();
    check_solids();
    check_box();
    check_rim();
    check_nothing();
    check_sheet();
    check_minus_zero();
    check_inside_out();
    check_large();
    return test_end();
}
