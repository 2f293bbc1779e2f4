/* SPDX-License-Identifier: MIT */
/* level: first */
/* Checks visibility: by closed forms, by whole numbers, where each sign of a determinant is exact,
 * and where doubles do not decide. brute.py has a second implementation over random triangles. */
#include "data/maths/maths.h"
#include "raster/visibility/inside.h"
#include "test.h"

enum { MOST = 12 };

/* A mesh in eye space, whose surface is all that there is. */
struct solid {
    struct vertex vertices[MOST];
    int32_t triangles[MOST][3];
    int n_vertices, n_triangles;
    struct instance instance;
    struct surface surface;
    struct occluders occluders;
};

static void solid_make(struct solid *of)
{
    const bool casts[1] = {true};
    of->instance = (struct instance){.vertices = of->vertices,
                                     .triangles = (const int32_t(*)[3])of->triangles,
                                     .n_vertices = of->n_vertices,
                                     .n_triangles = of->n_triangles,
                                     .model_view = matrix_identity(),
                                     .normal_matrix = matrix_identity()};
    of->surface = (struct surface){.instance = &of->instance};
    test_need(occluders_make(&of->surface, 1, casts, 16, &of->occluders), "no memory");
}

/* Finds the lights that do not reach some points, which belong to no triangle. The eye looks along
 * -z, from far away. */
static void block(const struct solid *of, const struct eye_light *lights, int n_lights,
                  struct seen_point *points, int n)
{
    const struct surface beside = {.instance = &of->instance};
    const struct view view = {.projection = matrix_identity(),
                              .lights = lights,
                              .n_lights = n_lights,
                              .n_shadowed = n_lights};
    const struct surface surfaces[2] = {of->surface, beside};
    struct vector *vertices[2] = {of->occluders.vertices[0], NULL};
    struct occluders occluders = of->occluders;
    occluders.surfaces = surfaces;
    occluders.vertices = vertices;
    occluders.n_surfaces = 2;
    lights_block(&occluders, &view, points, n);
}

/* A point of a surface that casts no shadow, asked for two lights. */
static struct seen_point point_at(struct vector at)
{
    return (struct seen_point){{at, false}, {1, 0}, 3, 0};
}

/* Returns whether the light at a place, or in a direction, reaches a point. */
static bool reaches(const struct solid *of, struct vector light, bool directional,
                    struct vector point)
{
    const struct eye_light lights[1] = {{.directional = directional, .position = light}};
    struct seen_point at = point_at(point);
    block(of, lights, 1, &at, 1);
    return at.dark == 0;
}

static int32_t add_vertex(struct solid *of, double x, double y, double z)
{
    of->vertices[of->n_vertices] = (struct vertex){.position = {x, y, z}};
    return of->n_vertices++;
}

static void add_triangle(struct solid *of, int32_t a, int32_t b, int32_t c)
{
    const int32_t corners[3] = {a, b, c};
    memcpy(of->triangles[of->n_triangles++], corners, sizeof corners);
}

/* A box from -1 to 1, each side in two triangles. */
static void add_box(struct solid *of, double size)
{
    static const int sides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    const int32_t first = of->n_vertices;
    for (int i = 0; i < 8; i++)
        add_vertex(of, i & 1 ? size : -size, i & 2 ? size : -size, i & 4 ? size : -size);
    for (int i = 0; i < 6; i++) {
        const int *v = sides[i];
        add_triangle(of, first + v[0], first + v[1], first + v[2]);
        add_triangle(of, first + v[0], first + v[2], first + v[3]);
    }
}

/* ---- closed forms ---- */

/* Finds the last point of a line that the light does not reach, by halving. */
static double edge_along(const struct solid *of, struct vector light, bool directional,
                         struct vector from, struct vector along)
{
    double dark = 0, lit = 1;
    for (int i = 0; i < 60; i++) {
        const double middle = 0.5 * (dark + lit);
        *(reaches(of, light, directional, vector_add(from, vector_scale(along, middle))) ? &lit
                                                                                         : &dark) =
            middle;
    }
    return dark;
}

/* A box from -1 to 1 in a light at height h throws the shadow of its upper face onto the plane at
 * -1: a square of half the side (h + 1) / (h - 1). */
static void box_shadow(void)
{
    static struct solid box;
    add_box(&box, 1);
    solid_make(&box);
    for (double height = 1.5; height < 200; height *= 3) {
        const struct vector light = {0, 0, height}, below = {0, 0, -1.5}, along = {100, 37, 0};
        const double half = (height + 1.5) / (height - 1);
        CHECK_NEAR(100 * edge_along(&box, light, false, below, along) / half, 1, 1e-9,
                   "a box below a light at height %g: the edge of its shadow", height);
    }
    const struct vector slanted = vector_normalise((struct vector){3, 0, 4});
    CHECK_NEAR(100 * edge_along(&box, slanted, true, (struct vector){0, 0, -2},
                                (struct vector){-100, 0, 0}),
               1 + 3 * 0.75, 1e-8,
               "a box in a slanted light: its shadow is as long as its height "
               "calls for");
    occluders_free(&box.occluders);
}

/* ---- whole numbers ---- */

/* The segment from a point inside of a closed mesh to a light outside of it meets the mesh, also
 * through edges and vertices, and along faces. All coordinates are whole. */
static void no_leaks(void)
{
    static struct solid box;
    long asked = 0, leaks = 0;
    add_box(&box, 2);
    solid_make(&box);
    for (int x = -1; x <= 1; x++)
        for (int y = -1; y <= 1; y++)
            for (int z = -1; z <= 1; z++)
                for (int light = 0; light < 9 * 9 * 9; light++) {
                    const struct vector at = {light % 9 - 4, light / 9 % 9 - 4, light / 81 - 4};
                    if (vector_reach(at) <= 2)
                        continue;
                    for (int directional = 0; directional < 2; directional++, asked++)
                        leaks += reaches(&box, at, directional, (struct vector){x, y, z});
                }
    CHECK(leaks == 0, "of %ld segments from inside of a box, %ld leave it by an edge or a vertex",
          asked, leaks);
    occluders_free(&box.occluders);
}

/* ---- near a plane ---- */

/* A plate throws its shadow on all below it, however near above it the lamp stands, down to what
 * doubles round; but a lamp that stands in its plane for all that roundings say throws none. A
 * turned and a moved plate have corners that are rounded. */
static void lamp_at_plate(void)
{
    struct vector axis = {1, 2, 3};
    for (int turned = 0; turned < 2; turned++) {
        static struct solid plate;
        const struct matrix m =
            matrix_product(matrix_translation((struct vector){turned * 7.3, turned * -2.1, 0}),
                           matrix_rotation(turned * 37, axis));
        long wrong = 0;
        plate.n_vertices = plate.n_triangles = 0;
        for (int i = 0; i < 4; i++) {
            const struct vector at =
                matrix_point(&m, (struct vector){i & 1 ? 1 : -1, i & 2 ? 1 : -1, 0});
            add_vertex(&plate, at.x, at.y, at.z);
        }
        add_triangle(&plate, 0, 1, 3);
        add_triangle(&plate, 0, 3, 2);
        solid_make(&plate);
        for (int exponent = 0; exponent < 40; exponent++) {
            const struct vector above = matrix_point(
                                    &m, (struct vector){0.3, -0.1, ldexp(1, -exponent)}),
                                below = matrix_point(
                                    &m, (struct vector){0.31, -0.12, -ldexp(1, -exponent)}),
                                deep = matrix_point(
                                    &m, (struct vector){5, 3, -40 * ldexp(1, -exponent)});
            wrong += reaches(&plate, above, false, below) +
                     (exponent < 4 && reaches(&plate, above, false, deep));
        }
        CHECK(wrong == 0, "a lamp near a plate throws its shadow: %ld of 40 distances do not",
              wrong);
        CHECK(reaches(&plate, matrix_point(&m, (struct vector){0.3, -0.1, 0x1p-51}), false,
                      matrix_point(&m, (struct vector){0.3, -0.1, -1})),
              "a lamp in the plane of a plate throws no shadow");
        CHECK(reaches(&plate, matrix_point(&m, (struct vector){0.3, -0.1, 1}), false,
                      matrix_point(&m, (struct vector){0.3, -0.1, -0x1p-51})),
              "a point in the plane of a plate has no shadow from it");
        occluders_free(&plate.occluders);
    }
}

/* ---- points together ---- */

static struct vector somewhere(uint64_t *state, double size)
{
    return (struct vector){test_random(state, -size, size), test_random(state, -size, size),
                           test_random(state, -size, size)};
}

/* Points that are asked together get what each gets alone: near each other and far apart, on all
 * sides of the lights, some of them asked for one light or none. */
static void together(void)
{
    uint64_t state = 13;
    long wrong = 0, dark = 0;
    enum { SCENES = 20000 };
    for (int k = 0; k < SCENES; k++) {
        static struct solid soup;
        soup.n_vertices = soup.n_triangles = 0;
        for (int i = 0; i < MOST; i++) {
            const struct vector at = somewhere(&state, 4);
            add_vertex(&soup, at.x, at.y, at.z);
        }
        for (int i = 0; i + 2 < MOST; i++)
            add_triangle(&soup, i, i + 1, i + 2);
        solid_make(&soup);
        const struct eye_light lights[2] = {
            {.position = somewhere(&state, 6)},
            {.directional = true, .position = vector_normalise(somewhere(&state, 1))}};
        const struct vector middle = somewhere(&state, 6);
        const double spread = test_random(&state, 0, 1) < 0.5 ? 0.1 : 8;
        struct seen_point all[TOGETHER], one;
        for (int i = 0; i < TOGETHER; i++) {
            all[i] = point_at(vector_add(middle, somewhere(&state, spread)));
            all[i].asked = (uint32_t)test_random(&state, 0, 4);
            if (k % 4 == 0 && i % 3 == 1) /* a place that is no number stands in no other's way */
                all[i] = point_at((struct vector){(double)NAN, (double)NAN, (double)NAN});
        }
        const int n = 1 + (int)test_random(&state, 0, TOGETHER);
        block(&soup, lights, 2, all, n);
        for (int i = 0; i < n; i++) {
            one = all[i];
            one.dark = 0;
            block(&soup, lights, 2, &one, 1);
            wrong += one.dark != all[i].dark || (one.dark & ~one.asked) != 0;
            dark += one.dark != 0;
        }
        occluders_free(&soup.occluders);
    }
    CHECK(wrong == 0 && dark > SCENES / 4,
          "points get what they get alone: %ld do not; a light is dark at %ld", wrong, dark);
}

/* ---- coordinates where doubles do not decide ---- */

/* A light, a point and two corners in one plane: rounded products do not say on which side of an
 * edge the segment passes. It passes on one side or the other of both triangles that share the
 * edge. */
static void edges_are_shared(void)
{
    static struct solid pair;
    uint64_t state = 7;
    long both = 0, none = 0, asked = 0;
    for (int i = 0; i < 20000; i++, asked++) {
        struct vector a, b, light, point;
        double share = test_random(&state, 0.1, 0.9), reach = test_random(&state, 0.2, 3);
        a.x = test_random(&state, -1, 1);
        a.y = test_random(&state, -1, 1);
        a.z = 0;
        b.x = test_random(&state, -1, 1);
        b.y = test_random(&state, -1, 1);
        b.z = test_random(&state, -0.1, 0.1);
        light = (struct vector){test_random(&state, -1, 1), 0.25, 5};
        const struct vector on = vector_add(vector_scale(a, 1 - share), vector_scale(b, share));
        point = vector_add(on, vector_scale(vector_subtract(on, light), reach));
        const struct vector across = {-(b.y - a.y), b.x - a.x, 0};
        pair.n_vertices = pair.n_triangles = 0;
        add_vertex(&pair, a.x, a.y, a.z);
        add_vertex(&pair, b.x, b.y, b.z);
        add_vertex(&pair, a.x + 9 * across.x, a.y + 9 * across.y, a.z);
        add_vertex(&pair, a.x - 9 * across.x, a.y - 9 * across.y, a.z);
        int met[2];
        for (int k = 0; k < 2; k++) {
            pair.n_triangles = 0;
            if (k == 0)
                add_triangle(&pair, 0, 1, 2);
            else
                add_triangle(&pair, 1, 0, 3);
            solid_make(&pair);
            met[k] = !reaches(&pair, light, false, point);
            occluders_free(&pair.occluders);
        }
        both += met[0] && met[1];
        none += !met[0] && !met[1];
    }
    CHECK(both == 0 && none == 0,
          "of %ld segments through an edge that two triangles share, %ld meet both, %ld none",
          asked, both, none);
}

/* Three directions and a point: with a b c for the one product of the determinant and x b c for the
 * other, its sign is that of a - x, though both products round, and may round to one number. */
static void signs_are_exact(void)
{
    enum { MANY = 2000 };
    uint64_t state = 11;
    int wrong = 0;
    for (int i = 0; i < MANY; i++) {
        const double a = test_random(&state, 1, 2), b = test_random(&state, 1, 2),
                     c = test_random(&state, 1, 2);
        const double x[5] = {1.5 * a, nextafter(a, 3), a, nextafter(a, 0), 0.5 * a};
        int side[5];
        for (int k = 0; k < 5; k++) {
            const struct homogeneous rows[4] = {
                {{a, 0, x[k]}, true}, {{0, b, 0}, true}, {{c, 0, c}, true}, {{0, 0, 0}, false}};
            side[k] = side_of(rows);
        }
        wrong += side[0] == 0 || side[1] != side[0] || side[2] != 0 || side[3] != -side[0] ||
                 side[4] != -side[0];
    }
    CHECK(wrong == 0, "signs are right where products differ in their last digit: %d of %d wrong",
          wrong, MANY);
}

int main(void)
{
    box_shadow();
    no_leaks();
    lamp_at_plate();
    together();
    edges_are_shared();
    signs_are_exact();
    return test_end();
}
