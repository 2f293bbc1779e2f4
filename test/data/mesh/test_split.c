/* SPDX-License-Identifier: MIT */
/* Cuts meshes in half, and halves their edges: neither may open a crack, lose area or depend on a
 * direction. */
#include <float.h>

#include "data/mesh/inside.h"
#include "solid.h"

static struct mesh cut(const struct mesh *mesh)
{
    struct error err = {.text = ""};
    struct mesh out;

    test_need(mesh_cut(mesh, &out, &err), err.text);
    return out;
}

static struct mesh part_of(const struct mesh *mesh, int part)
{
    struct error err = {.text = ""};
    struct mesh from = *mesh, out;

    from.division = (struct division){0};
    test_need(mesh_part(&from, part, &out, &err), err.text);
    FREE_ALL(from.division.triangles, from.division.first, from.division.number);
    return out;
}

/* Rotates all vertices, so that no coordinate is a round number, then moves them. */
static void place_mesh(struct mesh *mesh, double x, double angle_deg)
{
    const struct vector by = {x, 0, 0}, axis = {1, 2, 3};
    const struct matrix move = matrix_translation(by), turn = matrix_rotation(angle_deg, axis);
    const struct matrix all = matrix_product(move, turn);

    for (int i = 0; i < mesh->n_vertices; i++) {
        struct vertex *v = &mesh->vertices[i];
        v->position = matrix_point(&all, v->position);
        v->normal = matrix_direction(&turn, v->normal);
    }
}

static struct vector corner_of(const struct mesh *mesh, int triangle, int k)
{
    return mesh->vertices[mesh->triangles[triangle][k]].position;
}

static struct vector twice_area(const struct mesh *mesh, int i)
{
    const struct vector a = corner_of(mesh, i, 0);

    return vector_cross(vector_subtract(corner_of(mesh, i, 1), a),
                        vector_subtract(corner_of(mesh, i, 2), a));
}

static double area(const struct mesh *mesh)
{
    double sum = 0;

    for (int i = 0; i < mesh->n_triangles; i++)
        sum += vector_length(twice_area(mesh, i)) / 2;
    return sum;
}

/* Returns whether every triangle belongs to the part on its side of x = 0. */
static bool is_sorted(const struct mesh *mesh)
{
    for (int i = 0; i < mesh->n_triangles; i++)
        for (int k = 0; k < 3; k++) {
            const double x = corner_of(mesh, i, k).x;
            if (mesh->part[i] == 0 ? x > 0 : x < 0)
                return false;
        }
    return true;
}

/* Returns whether the first vertices are the old ones, and the others are at exactly x = 0 with
 * unit normals. */
static bool new_vertices_lie_on_the_plane(const struct mesh *from, const struct mesh *to)
{
    bool good = memcmp(from->vertices, to->vertices,
                       (size_t)from->n_vertices * sizeof *from->vertices) == 0;

    for (int i = from->n_vertices; i < to->n_vertices; i++) {
        const struct vertex *v = &to->vertices[i];
        good = good && v->position.x == 0 && !signbit(v->position.x) &&
               fabs(vector_length(v->normal) - 1) <= 4 * DBL_EPSILON;
    }
    return good;
}

/* Negates x, and reverses the order of each triangle's corners. */
static struct mesh mirror(const struct mesh *mesh)
{
    struct mesh out = part_of(mesh, 0);

    for (int i = 0; i < out.n_vertices; i++) {
        out.vertices[i].position.x = -out.vertices[i].position.x;
        out.vertices[i].normal.x = -out.vertices[i].normal.x;
    }
    for (int i = 0; i < out.n_triangles; i++) {
        const int32_t last = out.triangles[i][2];
        out.triangles[i][2] = out.triangles[i][1];
        out.triangles[i][1] = last;
    }
    return out;
}

static bool is_mirrored(const struct vertex *a, const struct vertex *b)
{
    return a->position.x == -b->position.x && a->position.y == b->position.y &&
           a->position.z == b->position.z && a->normal.x == -b->normal.x &&
           a->normal.y == b->normal.y && a->normal.z == b->normal.z && a->s == b->s && a->t == b->t;
}

/* Returns a number that does not depend on the order of triangles nor on which corner is first: a
 * sum of products that identify three vertices and their cyclic order. */
static uint64_t fingerprint(const struct mesh *mesh, int part, bool turned)
{
    uint64_t sum = 0;

    for (int i = 0; i < mesh->n_triangles; i++) {
        const int32_t *corner = mesh->triangles[i];
        const uint64_t a = (uint64_t)corner[0], b = (uint64_t)corner[turned ? 2 : 1];
        const uint64_t c = (uint64_t)corner[turned ? 1 : 2];
        if (mesh->part[i] == part)
            sum += (a * 0x9e3779b97f4a7c15u ^ b) * (b * 0x9e3779b97f4a7c15u ^ c) *
                   (c * 0x9e3779b97f4a7c15u ^ a);
    }
    return sum;
}

static void check_mirrored(const struct mesh *mesh, const struct mesh *halves, const char *name)
{
    struct mesh other = mirror(mesh), others = cut(&other);
    bool good = halves->n_vertices == others.n_vertices;

    for (int i = 0; good && i < halves->n_vertices; i++)
        good = is_mirrored(&halves->vertices[i], &others.vertices[i]);
    CHECK(good, "%s: the cut of the mirrored mesh has mirrored vertices, bit for bit", name);
    CHECK(halves->n_triangles == others.n_triangles &&
              fingerprint(halves, 0, false) == fingerprint(&others, 1, true) &&
              fingerprint(halves, 1, false) == fingerprint(&others, 0, true),
          "%s: the cut of the mirrored mesh has mirrored triangles", name);
    mesh_free(&other);
    mesh_free(&others);
}

static void check_cut(const struct mesh *mesh, const char *name)
{
    const struct solid before = solid_measure(mesh);
    struct mesh halves = cut(mesh), left = part_of(&halves, 0), right = part_of(&halves, 1);
    const struct solid after = solid_measure(&halves);
    const struct solid sides[2] = {solid_measure(&left), solid_measure(&right)};

    CHECK(halves.n_parts == 2 && !halves.part_names && is_sorted(&halves),
          "%s: no triangle crosses x = 0, and each belongs to its side", name);
    CHECK(new_vertices_lie_on_the_plane(mesh, &halves), "%s: new vertices are at exactly 0", name);
    CHECK_NEAR(area(&halves) / area(mesh), 1, 1e-12, "%s: the area stays", name);
    CHECK_NEAR(area(&left) + area(&right), area(&halves), 1e-12 * area(mesh),
               "%s: both parts together are the whole", name);
    CHECK_NEAR(after.volume, before.volume, 1e-12 * fabs(before.volume), "%s: the volume stays",
               name);
    CHECK(before.open_edges == 0 && after.open_edges == 0, "%s: no crack opens", name);
    CHECK(sides[0].open_edges == sides[1].open_edges && sides[0].open_edges > 0,
          "%s: the rims of both halves match", name);
    CHECK(solid_euler(&after, &halves) == solid_euler(&before, mesh), "%s: its topology stays",
          name);
    CHECK(after.texture_inside == before.texture_inside, "%s: texture coordinates stay in range",
          name);
    check_mirrored(mesh, &halves, name);
    mesh_free(&halves);
    mesh_free(&left);
    mesh_free(&right);
}

static void check_solids(void)
{
    const struct shape shapes[] = {
        {.kind = SHAPE_SPHERE, .parameter = {1, 37, 23}},
        {.kind = SHAPE_TORUS, .parameter = {1.05, 1.65, 30, 31}},
        {.kind = SHAPE_BOX, .parameter = {1, 2, 3, 2}},
        {.kind = SHAPE_CONE, .parameter = {1, 2, 17, 5}},
    };
    const double shifts[] = {0, 0.37, -0.1};

    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++)
        for (int turned = 0; turned < 2; turned++)
            for (int k = 0; k < 3; k++) {
                char name[64];
                struct mesh mesh = solid_build(shapes[i].kind, shapes[i].parameter);
                place_mesh(&mesh, shifts[k], turned ? 33 : 0);
                snprintf(name, sizeof name, "%s %s at %g", turned ? "turned" : "upright",
                         shape_name(shapes[i].kind), shifts[k]);
                check_cut(&mesh, name);
                mesh_free(&mesh);
            }
}

/* ---- triangles one by one ---- */

static struct mesh triangles(const struct vertex *vertices, int n)
{
    struct error err = {.text = ""};
    struct mesh mesh = {.n_vertices = 0};

    test_need(mesh_reserve(&mesh, (size_t)n, (size_t)n / 3, &err), err.text);
    for (int i = 0; i < n; i++) {
        mesh.vertices[mesh.n_vertices++] = vertices[i];
        mesh.triangles[i / 3][i % 3] = i;
    }
    mesh.n_triangles = n / 3;
    return mesh;
}

/* Makes triangles of all sizes; some have corners at x = 0, or at tiny or huge x. */
static void check_soup(void)
{
    enum { CORNERS = 30000 };
    struct vertex *vertices = calloc(CORNERS, sizeof *vertices);
    uint64_t seed = 3;
    double worst = 0, lost = 0, sum = 0;

    test_need(vertices != NULL, "no memory");
    for (int i = 0; i < CORNERS; i++) {
        /* a triangle with all corners at 0 is left, mirrored or not */
        const double kind = test_random(&seed, -1, 1);
        const bool zero = i % 3 > 0 && kind > 0.8 && kind < 0.9;
        const double scale = zero ? 0 : kind > 0.9 ? 1e-9 : kind < -0.9 ? 1e3 : 1;
        double at[7];
        for (int k = 0; k < 7; k++)
            at[k] = test_random(&seed, -1, 1);
        const struct vector normal = {at[3], at[4], at[5]};
        vertices[i] =
            (struct vertex){{scale * at[0], at[1], at[2]}, vector_normalise(normal), at[6], 0};
    }
    struct mesh mesh = triangles(vertices, CORNERS), halves = cut(&mesh);
    CHECK(is_sorted(&halves) && new_vertices_lie_on_the_plane(&mesh, &halves),
          "no triangle of 10000 crosses x = 0 after the cut");
    /* The parts of a triangle follow one another, and have its normal. */
    for (int i = 0, k = 0; i < mesh.n_triangles; i++) {
        const struct vector whole = twice_area(&mesh, i);
        const int32_t first = mesh.triangles[i][0];
        struct vector together = {0, 0, 0};
        for (; k < halves.n_triangles; k++) {
            const int32_t *c = halves.triangles[k];
            const int32_t least =
                c[0] < c[1] ? (c[0] < c[2] ? c[0] : c[2]) : (c[1] < c[2] ? c[1] : c[2]);
            if (least > first + 2)
                break;
            const struct vector part = twice_area(&halves, k);
            worst = fmin(worst, vector_dot(part, whole) / vector_dot(whole, whole));
            together = vector_add(together, part);
        }
        lost = fmax(lost, solid_distance(together, whole));
        sum += vector_length(whole);
    }
    CHECK(worst > -1e-12, "no part of a triangle is turned over");
    CHECK_NEAR(lost / sum, 0, 1e-12, "the parts of each triangle add up to it");
    CHECK_NEAR(area(&halves) / area(&mesh), 1, 1e-12, "the area of all triangles stays");
    check_mirrored(&mesh, &halves, "soup");
    mesh_free(&mesh);
    mesh_free(&halves);
    free(vertices);
}

static void check_cases(void)
{
    static const struct {
        const char *name;
        double x[3];
        int triangles, vertices, left; /* new vertices; triangles in part 0 */
    } cases[] = {{"one corner left", {-1, 1, 3}, 3, 2, 1},
                 {"one corner right", {1, -1, -3}, 3, 2, 2},
                 {"through a corner", {0, -1, 2}, 2, 1, 1},
                 {"an edge on x = 0, left", {0, 0, -1}, 1, 0, 1},
                 {"an edge on x = 0, right", {0, 0, 1}, 1, 0, 0},
                 {"a corner on x = 0", {0, 1, 2}, 1, 0, 0},
                 {"all corners at 0", {0, 0, 0}, 1, 0, 1},
                 {"all corners at 0 or -0", {-0.0, 0, -0.0}, 1, 0, 1},
                 {"left", {-1, -2, -3}, 1, 0, 1},
                 {"right", {1, 2, 3}, 1, 0, 0}};

    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int turn = 0; turn < 3; turn++) {
            struct vertex v[3] = {{{0, 0, 0}, {0, 0, 1}, 0, 0},
                                  {{0, 0, 1}, {0, 0, 1}, 0, 0},
                                  {{0, 1, 0}, {0, 0, 1}, 0, 0}};
            int left = 0;
            for (int k = 0; k < 3; k++)
                v[k].position.x = cases[i].x[(k + turn) % 3];
            struct mesh mesh = triangles(v, 3), halves = cut(&mesh);
            for (int k = 0; k < halves.n_triangles; k++)
                left += halves.part[k] == 0;
            CHECK(halves.n_triangles == cases[i].triangles && left == cases[i].left &&
                      halves.n_vertices == 3 + cases[i].vertices,
                  "%s, turned %d: %d triangles, %d of them left", cases[i].name, turn,
                  cases[i].triangles, cases[i].left);
            mesh_free(&mesh);
            mesh_free(&halves);
        }
}

/* Compares new vertices with interpolation worked by hand. */
static void check_between(void)
{
    const struct vertex v[3] = {{{-1, 0.1, 4}, {0, 1, 0}, 0, 1},
                                {{3, 0.1, 8}, {1, 0, 0}, 1, 0.3},
                                {{1, 0.1, 0}, {0, -1, 0}, 0.5, 1}};
    struct mesh mesh = triangles(v, 3), halves = cut(&mesh);

    if (CHECK(halves.n_vertices == 5, "there are two new vertices")) {
        const struct vertex *a = &halves.vertices[3], *b = &halves.vertices[4];
        CHECK(a->position.y == 0.1 && b->position.y == 0.1,
              "a coordinate that both ends share stays");
        CHECK(a->position.z == 5 && b->position.z == 2 && a->s == 0.25,
              "other coordinates and s are interpolated");
        CHECK_NEAR(a->t, 0.825, DBL_EPSILON, "t is interpolated");
        /* 3/4 of (0,1,0) and 1/4 of (1,0,0) */
        CHECK_NEAR(a->normal.x, 1 / sqrt(10), DBL_EPSILON, "normals are interpolated");
        CHECK_NEAR(a->normal.y, 3 / sqrt(10), DBL_EPSILON, "interpolated normals have unit length");
        CHECK(b->normal.y == 1,
              "half-way between opposite normals the first vertex's normal is used");
    }
    mesh_free(&mesh);
    mesh_free(&halves);
}

static void check_parts(void)
{
    struct mesh mesh = solid_build(SHAPE_BOX, (const double[]){2, 4, 6, 1}), halves, again, none;

    CHECK(mesh.n_parts == 1 && !mesh.part, "a built-in shape is one part");
    halves = cut(&mesh);
    again = cut(&halves);
    CHECK(again.n_triangles == halves.n_triangles && again.n_vertices == halves.n_vertices &&
              memcmp(again.part, halves.part, (size_t)again.n_triangles * sizeof *again.part) == 0,
          "a second cut changes nothing");
    halves.n_parts = 3;
    none = part_of(&halves, 2);
    CHECK(none.n_triangles == 0 && none.n_vertices == 0 && none.n_parts == 1,
          "a part without triangles is empty");
    mesh_free(&none);
    none = part_of(&halves, 0);
    CHECK(none.vertices[0].position.x == -1 && none.n_parts == 1 && !none.part,
          "a part has only the vertices that it uses, and has one part itself");
    mesh_planar(&mesh);
    for (int i = 0; i < mesh.n_vertices; i++) {
        const struct vertex *v = &mesh.vertices[i];
        if (v->s != (v->position.x + 1) / 2 || v->t != (v->position.y + 2) / 4)
            CHECK(false, "vertex %d has planar coordinates", i);
    }
    CHECK(mesh.vertices[0].s == 1, "planar coordinates span the bounding box");
    mesh_free(&mesh);
    mesh_free(&halves);
    mesh_free(&again);
    mesh_free(&none);
}

/* ---- halved edges ---- */

static void halve(struct mesh *mesh, int times)
{
    struct error err = {.text = ""};
    mesh->parametric = false;
    for (; times > 0; times--)
        test_need(mesh_halve(mesh, &err), err.text);
}

/* A facet with interpolated normals has the same normals where its corners are joined. */
static void check_halved_facet(void)
{
    const struct vertex v[3] = {{{0, 0, 0}, {0, 0, 1}, 0, 0},
                                {{4, 0, 0}, {0.6, 0, 0.8}, 1, 0},
                                {{0, 4, 0}, {0, -0.28, 0.96}, 0, 1}};
    struct mesh mesh = triangles(v, 3);
    double worst = 0;
    halve(&mesh, 4);
    for (int i = 0; i < mesh.n_vertices; i++) {
        const struct vertex *at = &mesh.vertices[i];
        const double x = at->position.x / 4, y = at->position.y / 4;
        struct vector expected = vector_scale(v[0].normal, 1 - x - y);
        expected = vector_add(
            expected, vector_add(vector_scale(v[1].normal, x), vector_scale(v[2].normal, y)));
        worst = fmax(worst, solid_distance(expected, at->normal));
        worst = fmax(worst, fabs(at->s - x) + fabs(at->t - y) + fabs(at->position.z));
    }
    CHECK(mesh.n_triangles == 256 && mesh.n_vertices == 17 * 18 / 2,
          "a triangle of four times halved edges has 256: %d, and shares their corners: %d",
          mesh.n_triangles, mesh.n_vertices);
    CHECK_NEAR(worst, 0, 8 * DBL_EPSILON, "they lie in it, with its normals and its texture");
    mesh_free(&mesh);
}

/* Each half of a box is a part; a quarter of a triangle lies on the side of its part. */
static void check_halved_solids(void)
{
    const struct shape shapes[] = {{.kind = SHAPE_SPHERE, .parameter = {1, 11, 7}},
                                   {.kind = SHAPE_TORUS, .parameter = {0.4, 1, 7, 9}},
                                   {.kind = SHAPE_BOX, .parameter = {2, 4, 6, 1}}};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        struct mesh mesh = solid_build(shapes[i].kind, shapes[i].parameter), halves;
        place_mesh(&mesh, 0.1, 33);
        halves = cut(&mesh);
        const struct solid before = solid_measure(&mesh);
        const double part_area = area(&halves);
        const int n = halves.n_triangles;
        bool in_place = true;
        halve(&mesh, 2);
        halve(&halves, 2);
        const struct solid after = solid_measure(&mesh);
        CHECK(after.open_edges == 0 && after.repeated_edges == 0 && before.open_edges == 0,
              "a %s of halved edges has no crack", shape_name(shapes[i].kind));
        CHECK_NEAR(after.volume / before.volume, 1, 1e-12, "its volume stays");
        CHECK_NEAR(area(&halves) / part_area, 1, 1e-12, "the area of its halves stays");
        for (int k = 0; k < 3 * halves.n_triangles; k++)
            in_place =
                in_place && (halves.part[k / 3] - 0.5) * corner_of(&halves, k / 3, k % 3).x >= 0;
        CHECK(halves.n_triangles == 16 * n && halves.n_parts == 2 && in_place,
              "quarters belong to the parts of their triangles");
        mesh_free(&mesh);
        mesh_free(&halves);
    }
}

int main(void)
{
    check_solids();
    check_soup();
    check_cases();
    check_between();
    check_parts();
    check_halved_facet();
    check_halved_solids();
    return test_end();
}
