/* SPDX-License-Identifier: MIT */
/* Compares the OBJ reader and mesh builder with closed forms. Both renderers share them, so no
 * other test would find their errors. test/cases/bad/meshes.cases has refused ones. */
#include <float.h>
#include <time.h>

#include "data/mesh/inside.h"
#include "solid.h"

static const struct place nowhere = {NULL, 0, 0};
static const char *const obj_path = "test_mesh.obj";

static FILE *begin_obj(void)
{
    FILE *file = fopen(obj_path, "w");
    test_need(file != NULL, obj_path);
    return file;
}

/* Reads the file that was written last. */
static struct mesh read_obj(bool unitize, double crease_deg)
{
    struct error err = {.text = ""};
    struct mesh mesh;

    CHECK(mesh_read(obj_path, nowhere, unitize, crease_deg, &mesh, &err), "is read%s%s",
          err.text[0] ? ": " : "", err.text);
    return mesh;
}

static struct mesh read_text(const char *text, double crease_deg)
{
    test_write(obj_path, text);
    return read_obj(false, crease_deg);
}

static bool same_mesh(const struct mesh *a, const struct mesh *b)
{
    return a->n_vertices == b->n_vertices && a->n_triangles == b->n_triangles &&
           memcmp(a->vertices, b->vertices, (size_t)a->n_vertices * sizeof *a->vertices) == 0 &&
           memcmp(a->triangles, b->triangles, (size_t)a->n_triangles * sizeof *a->triangles) == 0;
}

/* ---- cubes ---- */

static const char cube_points[] = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\n"
                                  "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
static const char cube_squares[] =
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
static const char cube_triangles[] = "f 1 4 3\nf 1 3 2\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\n"
                                     "f 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";

static struct mesh read_cube(const char *faces, double crease_deg)
{
    char text[1024];

    snprintf(text, sizeof text, "%s%s", cube_points, faces);
    return read_text(text, crease_deg);
}

/* Returns the largest difference between the normals and the ideal ones: either face normals, along
 * one axis, or corner normals, along the diagonals. */
static double cube_normal_error(const struct mesh *mesh, bool smooth)
{
    double worst = 0;

    for (int i = 0; i < mesh->n_vertices; i++) {
        const struct vector p = mesh->vertices[i].position, n = mesh->vertices[i].normal;
        if (smooth)
            worst = fmax(worst, solid_distance(n, vector_scale(p, sqrt(1 / 3.0))));
        else
            worst = fmax(worst, fabs(fmax(fabs(n.x), fmax(fabs(n.y), fabs(n.z))) - 1));
    }
    return worst;
}

static void check_cubes(void)
{
    const char *const faces[2] = {cube_squares, cube_triangles};
    const struct {
        double crease_deg;
        bool smooth;
    } creases[] = {{0, false}, {80, false}, {90, false}, {91, true}, {180, true}};

    for (int f = 0; f < 2; f++)
        for (size_t c = 0; c < sizeof creases / sizeof *creases; c++) {
            struct mesh mesh = read_cube(faces[f], creases[c].crease_deg);
            const struct solid solid = solid_measure(&mesh);
            const char *shown = f ? "triangles" : "squares";
            CHECK(mesh.n_vertices == (creases[c].smooth ? 8 : 24) && mesh.n_triangles == 12,
                  "a cube of %s, crease %g: %s", shown, creases[c].crease_deg,
                  creases[c].smooth ? "each corner has one vertex"
                                    : "each square has its own vertices");
            CHECK_NEAR(cube_normal_error(&mesh, creases[c].smooth), 0, 4 * DBL_EPSILON,
                       "%s: normals are weighted by angles, so that diagonals do not matter",
                       shown);
            CHECK(solid.open_edges == 0 && solid_euler(&solid, &mesh) == 2,
                  "%s: the cube is closed", shown);
            CHECK_NEAR(solid.volume, 8, 8 * DBL_EPSILON, "%s: the volume is right", shown);
            mesh_free(&mesh);
        }
}

/* Right angles of a rotated cube are only nearly right once its coordinates have six digits, as
 * most programs write them. */
static void check_turned_cube(void)
{
    const struct vector axis = {1, 2, 3};
    const struct matrix turned = matrix_rotation(33, axis);

    for (int crease = 89; crease <= 91; crease++) {
        FILE *file = begin_obj();
        for (int i = 0; i < 8; i++) {
            const struct vector corner = {(i ^ i >> 1) & 1 ? 1 : -1, i & 2 ? 1 : -1,
                                          i & 4 ? 1 : -1};
            const struct vector p = matrix_point(&turned, corner);
            fprintf(file, "v %.6f %.6f %.6f\n", p.x, p.y, p.z);
        }
        fputs(cube_squares, file);
        fclose(file);
        struct mesh mesh = read_obj(false, crease);
        CHECK(mesh.n_vertices == (crease <= 90 ? 24 : 8),
              "a rotated cube has the same edges at crease %d as an upright one", crease);
        mesh_free(&mesh);
    }
}

/* ---- polygons ---- */

static void write_polygon(const double (*at)[2], int n)
{
    FILE *file = begin_obj();

    for (int i = 0; i < n;
         i++) /* in the plane z = 2 x - y, so that no edge is parallel to an axis */
        fprintf(file, "v %.17g %.17g %.17g\n", at[i][0], at[i][1], 2 * at[i][0] - at[i][1]);
    fputs("f", file);
    for (int i = 1; i <= n; i++)
        fprintf(file, " %d", i);
    fputs("\n", file);
    fclose(file);
}

/* Checks a triangulation: no triangle is turned over, and the border of all triangles is the
 * polygon's own edges, so that they cover each point inside once and no point outside. The sum of
 * areas confirms this. */
static void check_polygon(const double (*at)[2], int n, const char *name)
{
    double shoelace = 0;

    write_polygon(at, n);
    struct mesh mesh = read_obj(false, 90);
    const struct solid solid = solid_measure(&mesh);
    for (int i = 0; i < n; i++) {
        const double *a = at[i], *b = at[(i + 1) % n];
        shoelace += (a[0] * b[1] - a[1] * b[0]) / 2;
    }
    CHECK(mesh.n_triangles == n - 2, "%s: there are n - 2 triangles", name);
    CHECK(solid.least_area_z > 0, "%s: no triangle is turned over or without area", name);
    CHECK_NEAR(solid.area_z / shoelace, 1, 4 * DBL_EPSILON * n, "%s: areas add up", name);
    CHECK(solid.open_edges == n && solid.repeated_edges == 0, "%s: its border is the polygon's",
          name);
    mesh_free(&mesh);
}

static void check_polygons(void)
{
    const double l_shape[][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    const double straight[][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    const double arrow[][2] = {{0, 0}, {2, 1}, {0, 2}, {1, 1}};
    const double arrow_later[][2] = {{1, 1}, {0, 0}, {2, 1}, {0, 2}};
    const double notch[][2] = {{0, 0}, {4, 0}, {4, 4}, {2, 4}, {2, 1}, {1, 1}, {1, 4}, {0, 4}};
    const double chance[][2] = {{1, 2}, {3, 2}, {4, 2}, {5, 3}, {4, 3}, {5, 4}, {3, 4},
                                {5, 5}, {3, 5}, {2, 5}, {1, 5}, {1, 4}, {1, 3}, {0, 2},
                                {0, 1}, {1, 1}, {3, 0}, {4, 0}, {5, 1}, {3, 1}};
    double star[300][2], comb[402][2], spiral[200][2];
    uint64_t seed = 1;

    check_polygon(l_shape, 6, "L");
    check_polygon(straight, 8, "square with straight corners");
    check_polygon(arrow, 4, "arrowhead");
    check_polygon(arrow_later, 4, "arrowhead from its dent");
    check_polygon(notch, 8, "notched square");
    check_polygon(chance, 20, "straight corners that rounding would bend");
    for (int n = 5; n <= 300; n += 59) {
        for (int i = 0; i < n; i++) {
            const double radius = 0.1 + test_random(&seed, 0, 1), angle = 2 * PI * i / n;
            star[i][0] = radius * cos(angle);
            star[i][1] = radius * sin(angle);
        }
        check_polygon((const double(*)[2])star, n, "random star");
    }
    for (int i = 0; i < 400; i++) { /* teeth, from right to left above the base */
        comb[2 + i][0] = 400 - i;
        comb[2 + i][1] = i % 2 ? 50 : 1;
    }
    comb[0][0] = 1;
    comb[0][1] = comb[1][1] = 0;
    comb[1][0] = 400;
    check_polygon((const double(*)[2])comb, 402, "comb");
    for (int i = 0; i < 100; i++) { /* out along the outer side, back along the inner one */
        const double angle = 0.2 * i, radius = 1 + angle;
        spiral[i][0] = (radius + 1) * cos(angle);
        spiral[i][1] = (radius + 1) * sin(angle);
        spiral[199 - i][0] = (radius - 0.5) * cos(angle);
        spiral[199 - i][1] = (radius - 0.5) * sin(angle);
    }
    check_polygon((const double(*)[2])spiral, 200, "spiral");
}

/* An L of area 3 in each of the three coordinate planes, which no fan from its first corner covers:
 * no triangle of it is turned over. */
static void check_upright(void)
{
    static const int at[6][2] = {{2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}, {0, 0}};
    for (int axis = 0; axis < 3; axis++) {
        FILE *file = begin_obj();
        for (int i = 0; i < 6; i++) {
            int place[3] = {0, 0, 0};
            place[(axis + 1) % 3] = at[i][0];
            place[(axis + 2) % 3] = at[i][1];
            fprintf(file, "v %d %d %d\n", place[0], place[1], place[2]);
        }
        fputs("f 1 2 3 4 5 6\n", file);
        fclose(file);
        struct mesh mesh = read_obj(false, 90);
        for (int i = 0; i < mesh.n_vertices; i++) { /* the axis becomes z */
            const struct vector p = mesh.vertices[i].position;
            const double of[3] = {p.x, p.y, p.z};
            mesh.vertices[i].position =
                (struct vector){of[(axis + 1) % 3], of[(axis + 2) % 3], of[axis]};
        }
        const struct solid solid = solid_measure(&mesh);
        CHECK(mesh.n_triangles == 4 && solid.least_area_z > 0,
              "a polygon across axis %d: four triangles", axis);
        CHECK_NEAR(solid.area_z, 3, 0, "a polygon across axis %d: areas add up", axis);
        mesh_free(&mesh);
    }
}

/* A hole is joined to the border by a bridge that the outline runs along twice, as many programs
 * write it. */
static void check_hole(void)
{
    struct mesh mesh = read_text("v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\n"
                                 "v 1 1 0\nv 1 3 0\nv 3 3 0\nv 3 1 0\n"
                                 "f 1 2 3 4 1 5 6 7 8 5\n",
                                 90);
    const struct solid solid = solid_measure(&mesh);

    CHECK(mesh.n_triangles == 8 && solid.least_area_z > 0,
          "a square ring: 8 triangles, none turned over");
    CHECK_NEAR(solid.area_z, 12, 0, "a square ring: its hole stays open");
    CHECK(solid.open_edges == 8, "a square ring: the bridge is closed");
    mesh_free(&mesh);
}

/* The time is at most the square of the number of corners. */
static void check_long_polygons(void)
{
    static double at[LONGEST_FACE][2];
    uint64_t seed = 7;

    for (int round = 0; round < 3; round++) {
        const int n = LONGEST_FACE;
        for (int i = 0; i < n; i++) {
            const double comb = i % 2 ? 0.5 : 1;
            at[i][0] = cos(2 * PI * i / n) *
                       (round == 2 ? comb : 1 - 0.1 * round * test_random(&seed, 0, 1));
            at[i][1] = sin(2 * PI * i / n) * (round == 2 ? comb : 1);
        }
        const clock_t start = clock();
        check_polygon((const double(*)[2])at, n, "long polygon");
        const double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
        CHECK(seconds < 10, "the cut takes a short time: %.2f s", seconds);
    }
}

/* Degenerate polygons must not loop for ever, and must have finite unit normals. */
static void check_senseless(void)
{
    const struct {
        const char *name, *text;
        int most;
    } cases[] = {
        {"collinear", "v 0 0 0\nv 1 1 1\nv 2 2 2\nv 3 3 3\nf 1 2 3 4\n", 2},
        {"nearly collinear", "v 0.1 0 0\nv 0.2 0 0\nv 0.3 1e-17 0\nf 1 2 3\n", 1},
        {"bow tie", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n", 2},
        {"there and back", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 1 0\nf 1 2 3 4 3 2\n", 4},
        {"repeated corners", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 1 0\nf 1 1 2 2 3 4 1\n", 1},
        {"spike", "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 4 9 0\nv 0 4 0\nf 1 2 3 4 3 5\n", 4},
        {"five-pointed star walked twice round",
         "v 0 1 0\nv -0.6 -0.8 0\nv 0.95 0.3 0\nv -0.95 0.3 0\nv 0.6 -0.8 0\nf 1 2 3 4 5\n", 3}};

    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct mesh mesh = read_text(cases[i].text, 90);
        double worst = 0;
        for (int k = 0; k < mesh.n_vertices; k++) {
            const struct vector up = {0, 0, 1};
            worst = fmax(worst, solid_distance(mesh.vertices[k].normal, up));
        }
        CHECK(mesh.n_triangles > 0 && mesh.n_triangles <= cases[i].most,
              "%s: at most n - 2 triangles", cases[i].name);
        CHECK(worst == 0, "%s: normals 0 0 1", cases[i].name);
        mesh_free(&mesh);
    }
}

/* A triangle without area takes its neighbours' normals and does not change them. */
static void check_zero_area(void)
{
    struct mesh mesh = read_text("v 0 0 0\nv 0 1 0\nv 0 0 1\nv 0 2 0\nf 1 2 3\nf 1 2 4\n", 90);
    bool all = true;

    for (int i = 0; i < 3; i++)
        all = all && mesh.vertices[i].normal.x == 1;
    CHECK(all && mesh.n_vertices == 4, "a triangle without area shares its neighbours' normals");
    CHECK(mesh.vertices[3].normal.z == 1, "without a neighbour its normal is 0 0 1");
    mesh_free(&mesh);
}

/* ---- the file ---- */

static struct mesh read_faces(const char *faces)
{
    char text[400];
    snprintf(text, sizeof text, "v 0 0 0\nv 2 0 0\nv 0 1 0\nvt 0.25 0.5\nvn 0 0 3\nvn 0 0 0\n%s",
             faces);
    return read_text(text, 90);
}

static void check_forms(void)
{
    static const char *const same[][2] = {
        {"f -3/-1/-2 -2/-1/-2 -1/-1/-2\n", "indices that count back mean the same"},
        {"f 1/1/1 2/1/1 \\\r\n \t3/1/1\\\r\n# a comment \\\r\n", "a backslash continues the line"},
        {"# all that may be skipped\nmtllib a b\no \"x\ng a b\ns off\nusemtl #3\nl 1 2\np 1\n"
         "f 1/1/1 2/1/1 3/1/1",
         "other known statements change nothing"},
        {"f 1\nf 1 2\nf 1//\nfo 1/1/1 2/1/1 3/1/1\nvw 1 2\nt 1 2\nbevel on\n",
         "points, edges and old statements change nothing"},
        {"f 1/2/3 2/2/3 3/2/3\nvt 0.25 0.5\nvn 0 0 1\n", "items of later lines count"},
        {"vn nan -nan(ind) 1.#QNAN\nv 7 7 7 nan inf nan\nvt inf -1.#IND\nf 1/1/1 2/1/1 3/1/1\n",
         "items that are no numbers, and that no face uses, change nothing"}};
    struct mesh plain = read_faces("f 1/1/1 2/1/1 3/1/1\n"),
                other = read_faces("f 1//2 2//2 3//2\n");

    CHECK(plain.n_vertices == 3 && plain.vertices[1].s == 0.25 && plain.vertices[1].t == 0.5 &&
              plain.vertices[1].normal.z == 1,
          "coordinates are as written, and normals have unit length");
    CHECK(other.n_vertices == 3 && other.vertices[0].normal.z == 1,
          "vn 0 0 0 means no normal: the triangle's own is used");
    CHECK(other.vertices[0].s == 0 && other.vertices[1].s == 1 && other.vertices[2].s == 0 &&
              other.vertices[0].t == 0 && other.vertices[2].t == 1,
          "without vt, texture spans the bounding box");
    struct mesh open = read_faces("f 1// 2/ 3/\n"),
                none = read_faces("vn nan 0 1\nvt nan 0\nf 1/-1/-1 2/-1/-1 3/-1/-1\n");
    CHECK(same_mesh(&open, &other) && same_mesh(&none, &other),
          "nothing behind a slash, and a normal or texture coordinate of NaN, are none");
    mesh_free(&open);
    mesh_free(&none);
    for (size_t i = 0; i < sizeof same / sizeof *same; i++) {
        mesh_free(&other);
        other = read_faces(same[i][0]);
        CHECK(same_mesh(&plain, &other), "%s", same[i][1]);
    }
    mesh_free(&plain);
    mesh_free(&other);
}

static void check_sharing(void)
{
    struct mesh mesh = read_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1\nv 5 5 5 0.1 0.2 0.3\n"
                                 "vt 0\nvt 1 0 0\nvn 0 0 1\n"
                                 "f 4/1/1 1/1/1 2/1/1\nf 4/1/1 2/2/1 3/1/1\n",
                                 90);

    CHECK(mesh.n_vertices == 5 && mesh.triangles[1][0] == mesh.triangles[0][0] &&
              mesh.triangles[1][1] != mesh.triangles[0][2],
          "equal corners share a vertex, others do not");
    CHECK(mesh.triangles[0][0] == 0 && mesh.triangles[0][1] == 1 && mesh.triangles[0][2] == 2 &&
              mesh.triangles[1][1] == 3 && mesh.triangles[1][2] == 4,
          "vertices are in order of first use");
    mesh_free(&mesh);
}

/* A file with two squares, the second made of two triangles, and an edge that is not drawn. */
static void check_parts(void)
{
    struct mesh mesh = read_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                 "usemtl never\nusemtl edge\nf 1 2 1\nusemtl\nf 1 2 3 4\n"
                                 "usemtl red # not blue\nf 1 2 3\nusemtl  two words \nf 1 3 4\n"
                                 "usemtl red\nf 4 3 1\n",
                                 90);
    const int32_t parts[] = {0, 0, 1, 2, 1};
    struct mesh plain;

    if (CHECK(mesh.n_parts == 3 && mesh.n_triangles == 5 && mesh.part && mesh.part_names,
              "names of usemtl divide a mesh")) {
        CHECK(memcmp(mesh.part, parts, sizeof parts) == 0,
              "each triangle belongs to its face's part");
        CHECK_TEXT(mesh.part_names[0], "", "faces without a name are a part");
        CHECK_TEXT(mesh.part_names[1], "red", "parts are in order of first use by a face");
        CHECK_TEXT(mesh.part_names[2], "two words", "a name is the rest of its line");
    }
    mesh_free(&mesh);
    CHECK(!mesh.part && !mesh.part_names && mesh.n_parts == 0, "a freed mesh is empty");
    mesh = read_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl only\nf 1 2 3\n", 90);
    CHECK(mesh.n_parts == 1 && mesh.part && strcmp(mesh.part_names[0], "only") == 0,
          "a single part keeps its name");
    plain = read_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nusemtl late\n", 90);
    CHECK(plain.n_parts == 1 && !plain.part && plain.part_names[0][0] == '\0',
          "without named faces the mesh is one part");
    CHECK(same_mesh(&mesh, &plain), "names change nothing else");
    mesh_free(&mesh);
    mesh_free(&plain);
}

static void check_unitize(void)
{
    const double scales[] = {1, 1e-30, 1e30, 3e-7};

    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        FILE *file = begin_obj();
        fprintf(file, "v %.17g %.17g %.17g\n", 0.1 * scales[i], 5 * scales[i], 7 * scales[i]);
        fprintf(file, "v %.17g %.17g %.17g\n", 3.3 * scales[i], 5 * scales[i], 7.7 * scales[i]);
        fprintf(file, "v %.17g %.17g %.17g\n", 3.3 * scales[i], 6 * scales[i], 7 * scales[i]);
        fputs("v 1e38 0 0\nf 1 2 3\n", file); /* a point that no face uses */
        fclose(file);
        struct mesh mesh = read_obj(true, 90);
        const struct vector a = mesh.vertices[0].position, b = mesh.vertices[1].position;
        const struct vector c = mesh.vertices[2].position;
        CHECK(fmax(-a.x, b.x) == 1 && c.x == b.x, "unitized at %g: the longest side reaches 1",
              scales[i]);
        CHECK_NEAR(b.x - a.x, 2, 2 * DBL_EPSILON, "unitized: it is 2 long");
        CHECK_NEAR(c.y - a.y, 2 / 3.2, 4 * DBL_EPSILON, "unitized: other sides are in proportion");
        CHECK_NEAR(c.y + a.y, 0, 4 * DBL_EPSILON, "unitized: its centre is the origin");
        CHECK_NEAR(vector_length(mesh.vertices[0].normal), 1, 2 * DBL_EPSILON,
                   "unitized: normals have unit length");
        mesh_free(&mesh);
    }
}

static void check_reserve(void)
{
    struct error err = {.text = ""};
    struct mesh mesh = {.n_vertices = 0};

    CHECK(!mesh_reserve(&mesh, INT32_MAX, 0, &err) && err.status == EXIT_SYSTEM &&
              strstr(err.text, " MiB for a mesh; --memory sets the limit"),
          "more vertices than a number can count are refused as out of memory: %s", err.text);
    mesh_free(&mesh);
}

/* ---- many faces at a point ---- */

enum { CROWD = 1000 };

/* Writes a sharp, tiny cone without normals, and reads it. Its first point is the tip. Each face is
 * one triangle, or two halves in one plane. */
static struct mesh read_cone(double crease_deg, int halves)
{
    FILE *file = begin_obj();
    fprintf(file, "v 0 0 0\n");
    for (int i = 0; i < 2 * CROWD; i++) {
        const double angle = PI * i / CROWD, reach = i % 2 == 0 ? 1 : cos(PI / CROWD);
        fprintf(file, "v %.15g %.15g -3e-30\n", 1e-30 * reach * cos(angle),
                1e-30 * reach * sin(angle));
    }
    for (int i = 0; i < 2 * CROWD; i += 2 / halves)
        fprintf(file, "f 1 %d %d\n", i + 2, (i + 2 / halves) % (2 * CROWD) + 2);
    fclose(file);
    return read_obj(false, crease_deg);
}

/* Compares each normal at the tip with the mean of all faces that meet this one at less than the
 * crease. All faces have one angle there. Sums of 2000 unit vectors are off by 2000 roundings. */
static void check_cone(double crease_deg, int halves)
{
    const double least = cos((fmax(crease_deg - 0.001, 0)) * PI / 180);
    struct mesh mesh = read_cone(crease_deg, halves);
    struct vector face[CROWD];
    double worst = 0;
    for (int i = 0; i < CROWD; i++) {
        const double angle = 2 * PI * (i + 0.5) / CROWD, across = cos(PI / CROWD);
        face[i] = vector_normalise((struct vector){cos(angle), sin(angle), across / 3});
    }
    for (int i = 0; i < halves * CROWD; i++) {
        const struct vector seen = mesh.vertices[mesh.triangles[i][0]].normal;
        const int own = i / halves;
        struct vector sum = face[own];
        for (int k = 0; k < CROWD; k++)
            if (k != own && vector_dot(face[own], face[k]) > least)
                sum = vector_add(sum, face[k]);
        worst = fmax(worst, vector_reach(vector_subtract(seen, vector_normalise(sum))));
    }
    CHECK_NEAR(worst, 0, 1000 * halves * DBL_EPSILON,
               "the tip of a cone of %d triangles, crease %g", halves * CROWD, crease_deg);
    mesh_free(&mesh);
}

static void check_crowd(void)
{
    static const double creases[] = {0, 5, 30, 37.5, 90, 120};
    for (size_t c = 0; c < sizeof creases / sizeof creases[0]; c++) {
        check_cone(creases[c], 1);
        check_cone(creases[c], 2);
    }
}

int main(void)
{
    test_enter();
    check_cubes();
    check_turned_cube();
    check_polygons();
    check_upright();
    check_hole();
    check_long_polygons();
    check_senseless();
    check_zero_area();
    check_forms();
    check_sharing();
    check_parts();
    check_unitize();
    check_reserve();
    check_crowd();
    remove(obj_path);
    return test_end();
}
