/* SPDX-License-Identifier: MIT */
/* Divides meshes by marks that depend on edges alone, and compares the results with closed forms.
 */
#include <float.h>

#include "data/index/index.h"
#include "data/shape/shape.h"
#include "solid.h"
#include "spectral.h"
#include "test.h"

static void stop_unless(bool good, const struct error *err)
{
    if (!good) {
        printf("Bail out! %s\n", err->text);
        exit(1);
    }
}

static const double pi = 3.14159265358979323846;

static uint64_t random_state = 1;

static uint64_t random_bits(void)
{
    random_state = hash_bits(random_state + 0x9E3779B97F4A7C15U);
    return random_state;
}

static double random_between(double low, double high)
{
    return low + (high - low) * (double)(random_bits() >> 11) * 0x1p-53;
}

static uint64_t hash_place(struct vector p)
{
    const double at[3] = {p.x + 0, p.y + 0, p.z + 0};
    uint64_t bits[3];
    memcpy(bits, at, sizeof bits);
    return hash_bits(hash_bits(hash_bits(bits[0]) + bits[1]) + bits[2]);
}

/* Marks about one of `one_in` edges, by the places of its ends and a seed. */
static void mark(const struct mesh *mesh, uint64_t seed, unsigned one_in, unsigned char *marks)
{
    for (int i = 0; i < mesh->n_triangles; i++) {
        marks[i] = 0;
        for (int k = 0; k < 3; k++) {
            const struct vertex *a = &mesh->vertices[mesh->triangles[i][k]],
                                *b = &mesh->vertices[mesh->triangles[i][(k + 1) % 3]];
            const uint64_t edge =
                hash_bits(hash_place(a->position) + hash_place(b->position) + seed);
            marks[i] = (unsigned char)(marks[i] | (edge % one_in == 0) << k);
        }
    }
}

/* Returns how many marked edges have no reverse: they lie on the border of the mesh. */
static int marked_border(const struct mesh *mesh, const unsigned char *marks)
{
    const size_t n = 3 * (size_t)mesh->n_triangles;
    int *place = malloc((size_t)mesh->n_vertices * sizeof *place), found = 0;
    int64_t *edges = malloc(n * sizeof *edges), *sorted = malloc(n * sizeof *sorted);
    if (!place || !edges || !sorted)
        abort();
    solid_merge(mesh, place);
    for (size_t i = 0; i < n; i++) {
        const int32_t *corner = mesh->triangles[i / 3];
        edges[i] = (int64_t)place[corner[i % 3]] * INT32_MAX + place[corner[(i + 1) % 3]];
    }
    memcpy(sorted, edges, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, solid_compare_edges);
    for (size_t i = 0; i < n; i++) {
        const int64_t reverse = edges[i] % INT32_MAX * INT32_MAX + edges[i] / INT32_MAX;
        found += (marks[i / 3] >> i % 3 & 1) &&
                 !bsearch(&reverse, sorted, n, sizeof *sorted, solid_compare_edges);
    }
    free(place);
    free(edges);
    free(sorted);
    return found;
}

/* Replaces a mesh by a finer one. one_in 1: all edges are halved. Returns by how much its border
 * has more edges, if no crack has opened. */
static int divide(struct mesh *mesh, const struct patches *patches, unsigned one_in)
{
    struct error err = {.text = ""};
    struct mesh finer;
    int32_t *source;
    unsigned char *marks = malloc((size_t)mesh->n_triangles + 1);
    if (!marks)
        abort();
    mark(mesh, random_bits(), one_in, marks);
    const int border = marked_border(mesh, marks);
    stop_unless(mesh_subdivide(mesh, patches, marks, &finer, &source, &err), &err);
    free(marks);
    free(source);
    mesh_free(mesh);
    *mesh = finer;
    return border;
}

static struct shape random_shape(void)
{
    struct shape shape = {.kind = (enum shape_kind)(random_bits() % SHAPE_MESH), .repeat = {1, 1}};
    double *p = shape.parameter;
    p[0] = random_between(0.1, 2);
    p[1] = shape.kind == SHAPE_TORUS ? p[0] + random_between(0.1, 2) : random_between(0.1, 2);
    p[2] = random_between(0.1, 2);
    p[3] = (double)(1 + random_bits() % 4);
    if (shape.kind == SHAPE_SPHERE || shape.kind == SHAPE_DISK)
        p[1] = (double)(3 + random_bits() % 9);
    if (shape.kind == SHAPE_TEAPOT)
        p[1] = (double)(2 + random_bits() % 3); /* of one division, two edges have the same ends */
    if (shape.kind == SHAPE_SPHERE || shape.kind == SHAPE_CYLINDER || shape.kind == SHAPE_CONE)
        p[2] = (double)(3 + random_bits() % 7);
    if (shape.kind == SHAPE_DISK || shape.kind == SHAPE_PLANE)
        p[2] = (double)(1 + random_bits() % 4);
    if (shape.kind == SHAPE_TORUS) {
        p[2] = (double)(3 + random_bits() % 7);
        p[3] = (double)(3 + random_bits() % 9);
    }
    return shape;
}

static void open_mesh(const struct shape *shape, struct patches *patches, struct mesh *mesh)
{
    struct error err = {.text = ""};
    stop_unless(patches_open(shape, patches, &err) && shape_build(shape, mesh, &err), &err);
}

/* A border edge that is halved has two halves, and no other edge becomes a border. */
static void check_random_shapes(int n)
{
    int cracked = 0, wrong = 0;
    for (int i = 0; i < n; i++) {
        const struct shape shape = random_shape();
        struct patches patches;
        struct mesh mesh;
        open_mesh(&shape, &patches, &mesh);
        int border = solid_measure(&mesh).open_edges;
        for (int level = 0; level < 4; level++)
            border += divide(&mesh, &patches, 2 + (unsigned)(random_bits() % 4));
        const struct solid solid = solid_measure(&mesh);
        cracked += solid.open_edges != border || solid.repeated_edges > 0;
        wrong += solid.worst_length > 4 * DBL_EPSILON || !solid.texture_inside;
        mesh_free(&mesh);
        patches_close(&patches);
    }
    CHECK(cracked == 0, "%d of %d shapes that were divided at random have cracks", cracked, n);
    CHECK(wrong == 0,
          "%d of %d have a normal of another length than 1, or a place beside the texture", wrong,
          n);
}

/* Volumes and areas of shapes whose edges are all halved again and again. */
static void check_limits(void)
{
    static const struct {
        const char *name;
        struct shape shape;
        double volume;
    } all[] = {
        {"sphere", {.kind = SHAPE_SPHERE, .parameter = {1, 5, 3, 0}, .repeat = {1, 1}}, 4.0 / 3},
        {"torus", {.kind = SHAPE_TORUS, .parameter = {0.3, 1, 4, 5}, .repeat = {1, 1}}, 0.18 * pi},
        {"cylinder", {.kind = SHAPE_CYLINDER, .parameter = {1, 2, 3, 1}, .repeat = {1, 1}}, 2},
        {"cone", {.kind = SHAPE_CONE, .parameter = {1, 3, 3, 1}, .repeat = {1, 1}}, 1},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        struct patches patches;
        struct mesh mesh;
        double error[2];
        open_mesh(&all[i].shape, &patches, &mesh);
        for (int level = 0; level < 6; level++) {
            divide(&mesh, &patches, 1);
            error[level % 2] = 1 - solid_measure(&mesh).volume / (all[i].volume * pi);
        }
        CHECK(error[1] > 0 && error[1] < 2e-3, "a %s of halved edges has its true volume: %g",
              all[i].name, error[1]);
        CHECK_NEAR(error[0] / error[1], 4, 0.1, "a %s comes near it with the square of its edges",
                   all[i].name);
        mesh_free(&mesh);
        patches_close(&patches);
    }
}

/* The area of a disk whose rim is halved: that of a regular polygon with twice as many corners. */
static void check_rim(void)
{
    const struct shape shape = {.kind = SHAPE_DISK, .parameter = {1, 3, 2, 0}, .repeat = {1, 1}};
    struct patches patches;
    struct mesh mesh;
    double area = 0;
    open_mesh(&shape, &patches, &mesh);
    for (int level = 0; level < 5; level++)
        divide(&mesh, &patches, 1);
    for (int i = 0; i < mesh.n_triangles; i++) {
        const struct vector a = mesh.vertices[mesh.triangles[i][0]].position,
                            b = mesh.vertices[mesh.triangles[i][1]].position,
                            c = mesh.vertices[mesh.triangles[i][2]].position;
        area += vector_cross(vector_subtract(b, a), vector_subtract(c, a)).z / 2;
    }
    CHECK_NEAR(area / (48 * sin(2 * pi / 96)), 1, 1e-12,
               "a triangle whose rim is halved five times is a regular polygon of 96 corners");
    mesh_free(&mesh);
    patches_close(&patches);
}

/* A facet with interpolated normals, divided, has the same normals where its corners were joined.
 */
static void check_facets(void)
{
    struct vertex corners[3] = {{{0, 0, 0}, {0, 0, 1}, 0, 0},
                                {{4, 0, 0}, {0.6, 0, 0.8}, 1, 0},
                                {{0, 4, 0}, {0, -0.28, 0.96}, 0, 1}};
    struct error err = {.text = ""};
    struct mesh mesh = {.n_vertices = 0};
    double worst = 0;
    stop_unless(mesh_reserve(&mesh, 3, 1, &err), &err);
    memcpy(mesh.vertices, corners, sizeof corners);
    mesh.n_vertices = 3;
    mesh.n_triangles = 1;
    for (int k = 0; k < 3; k++)
        mesh.triangles[0][k] = k;
    for (int level = 0; level < 6; level++)
        divide(&mesh, NULL, 2);
    for (int i = 0; i < mesh.n_vertices; i++) {
        const struct vertex *v = &mesh.vertices[i];
        const double x = v->position.x / 4, y = v->position.y / 4;
        struct vector expected = vector_scale(corners[0].normal, 1 - x - y);
        expected = vector_add(expected, vector_add(vector_scale(corners[1].normal, x),
                                                   vector_scale(corners[2].normal, y)));
        worst = fmax(worst, vector_length(vector_subtract(expected, v->normal)));
        worst = fmax(worst, fabs(v->s - x) + fabs(v->t - y) + fabs(v->position.z));
    }
    CHECK(mesh.n_triangles > 50, "the facet has %d triangles", mesh.n_triangles);
    CHECK_NEAR(worst, 0, 8 * DBL_EPSILON, "they lie in it, with its normals and its texture");
    mesh_free(&mesh);
}

/* The tip of a cone has a normal and a texture coordinate for each triangle there. */
static void check_poles(void)
{
    const struct shape shape = {.kind = SHAPE_CONE, .parameter = {3, 4, 6, 1}, .repeat = {1, 1}};
    struct patches patches;
    struct mesh mesh;
    double worst = 0;
    int tips = 0;
    open_mesh(&shape, &patches, &mesh);
    divide(&mesh, &patches, 1);
    for (int i = 0; i < mesh.n_triangles; i++)
        for (int k = 0; k < 3; k++) {
            const struct vertex *tip = &mesh.vertices[mesh.triangles[i][k]],
                                *a = &mesh.vertices[mesh.triangles[i][(k + 1) % 3]],
                                *b = &mesh.vertices[mesh.triangles[i][(k + 2) % 3]];
            if (tip->position.z != 2)
                continue;
            tips++;
            worst = fmax(worst, fabs(tip->s - (a->s + b->s) / 2));
            const struct vector both = vector_add(a->normal, b->normal);
            worst = fmax(worst, fabs(tip->normal.x * both.y - tip->normal.y * both.x));
        }
    CHECK(tips == 6, "%d triangles meet at the tip", tips);
    CHECK_NEAR(worst, 0, 1e-12,
               "each has the middle of its texture there, and of the directions of its normals");
    mesh_free(&mesh);
    patches_close(&patches);
}

int main(void)
{
    check_random_shapes(getenv("FULL") ? 3000 : 300);
    check_limits();
    check_rim();
    check_facets();
    check_poles();
    return test_end();
}
