/* SPDX-License-Identifier: MIT */
/* level: first; packages: python3-numpy python3-tifffile */
/* Checks the reference: compares raster/reference in double with test/raster/reference/slow.h in
 * long double, over random scenes and hard triangles. Each pixel must show a surface that double
 * precision may show there. Its weights must be within double precision's own bound, and within the
 * program's bounds for OpenGL's single precision times 2^-29, which count more roundings of the
 * same formulas. Then it checks edges: signs are right unless rounding can turn them, and exactly
 * one of several triangles that share edges covers each pixel centre. */

#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "data/scene/inside.h"
#include "raster/bounds/bounds.h"
#include "raster/candidates/inside.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "raster/renderers/renderers.h"
#include "slow.h"
#include "spectral.h"
#include "test.h"

/* Powers of two, so that a grid in the window is one in the scene. */
enum { WIDTH = 64, HEIGHT = 32, SCENES = 200 };

static const char *const path = "reference.scene"; /* of the scene that is drawn */

static int random_below(uint64_t *state, int n)
{
    return (int)test_random(state, 0, n);
}

/* Returns ten to a random power between two. */
static double random_power(uint64_t *state, double low, double high)
{
    return exp(log(10) * test_random(state, low, high));
}

static struct vector random_point(uint64_t *state, double low, double high)
{
    struct vector out; /* in this order: the compiler chooses the order of initializers */
    out.x = test_random(state, low, high);
    out.y = test_random(state, low, high);
    out.z = test_random(state, low, high);
    return out;
}

/* ---- one picture by both references ---- */

struct both {
    struct scene scene;
    struct plan plan;
    struct lit_scene lit;
    struct slow_vertex **vertices; /* vertices of each surface */
    struct slow_triangle *triangles;
    struct slow_fragment *fragments; /* room for one fragment of each triangle */
    int n_triangles;
};

static void close_picture(struct both *picture)
{
    for (int s = 0; picture->vertices && s < picture->plan.n_instances; s++)
        free(picture->vertices[s]);
    free(picture->vertices);
    free(picture->triangles);
    free(picture->fragments);
    lit_free(&picture->lit);
    plan_free(&picture->plan);
    scene_free(&picture->scene);
}

/* Returns false if the program refuses the scene. */
static bool open_picture(const char *scene, bool exact, struct both *out)
{
    const struct plan_options options = {.check = true, .threads = 1};
    struct error err = {.text = ""};
    *out = (struct both){.triangles = NULL};
    if (!scene_read(scene, &out->scene, &err) ||
        !plan_make(&out->scene, NULL, &options, &out->plan, &err) ||
        !lit_make(&out->plan, driver_of(NULL), &out->lit, &err)) {
        printf("# refused: %s\n", err.text);
        close_picture(out);
        return false;
    }
    out->vertices = calloc((size_t)out->plan.n_instances, sizeof(struct slow_vertex *));
    out->triangles = calloc((size_t)out->plan.n_triangles, sizeof *out->triangles);
    out->fragments = calloc((size_t)out->plan.n_triangles, sizeof *out->fragments);
    test_need(out->vertices && out->triangles && out->fragments, "no memory");
    for (int s = 0; s < out->plan.n_instances; s++) {
        test_need(out->lit.surfaces[s].n_attributes <= SLOW_ATTRIBUTES, "too many attributes");
        out->vertices[s] = slow_vertices(&out->lit, s);
        test_need(out->vertices[s] != NULL, "no memory");
        for (int t = 0; t < out->lit.surfaces[s].instance->n_triangles; t++)
            out->triangles[out->n_triangles++] =
                slow_triangle(&out->scene, out->lit.surfaces, out->vertices, s, t, exact);
    }
    return true;
}

/* Draws the picture as one tile, and calls `work` with it. */
static void draw_tile(const struct both *picture, tile_work *work, void *context)
{
    const struct rectangle at = {0, 0, picture->scene.width, picture->scene.height};
    struct error err = {.status = EXIT_AGREED};
    test_need(tiles_each(&picture->lit, &at, work, context, &err), "out of memory");
}

/* ---- pixels ---- */

struct counted {
    long pixels, covered;
    long settled;   /* one surface must be drawn there */
    long unbounded; /* on triangles too thin for double precision */
    long wrong_surface, wrong_weight;
    long double worst;        /* difference / bound of settled pixels */
    long double worst_scaled; /* difference / bound for single precision, scaled down */
};

/* Computes a row of a pixel for this fragment, and double precision's bound (HUGE_VALL: none). */
struct expected {
    long double value, bound;
};

static struct expected expect_row(const struct both *picture, const struct slow_fragment *fragment,
                                  int side, int row)
{
    const struct shaded_material *shaded = picture->lit.bounds[fragment->triangle->surface].shaded;
    const struct slow_vertex *last = fragment->triangle->vertex[2];
    struct expected out = {0, 0};
    if (row < shaded->n_terms && picture->scene.shading == SHADING_FLAT)
        return (struct expected){last->value[side][row],
                                 last->error[side][row] + 2 * u * last->value[side][row]};
    for (int j = 0; j < 3; j++)
        out.value += fragment->share[j] * fragment->triangle->vertex[j]->value[side][row];
    out.bound = slow_bound(fragment, side, row, out.value);
    if (row < shaded->n_terms)
        return out;
    /* texels have one more rounding */
    long double texels =
        row == shaded->n_terms ? shaded->texture->image.width : shaded->texture->image.height;
    out.bound = texels * (out.bound + u * fabsl(out.value));
    out.value *= texels;
    return out;
}

/* Bounds the part of a pixel's row that rounding may turn on or off at its vertices. Flat shading
 * takes one of them whole. */
static long double doubt_of(const struct slow_fragment *fragment, int side, int row)
{
    long double sum = 0;
    for (int j = 0; j < 3; j++)
        sum += (1 + fabsl(fragment->share[j])) * fragment->triangle->vertex[j]->doubt[side][row];
    return sum;
}

/* Returns the largest difference / bound of a pixel's rows for this fragment; -1: no bound. If
 * `errors` are given, the bounds are the program's own for single precision times 2^-29, plus 16
 * roundings of the value in double that those bounds do not count. */
static long double ratio_of(const struct both *picture, const struct slow_fragment *fragment,
                            int side, const double *weights, const float *errors, size_t stride)
{
    long double worst = 0;
    for (int row = 0; row < pixel_rows(picture->lit.surfaces[fragment->triangle->surface].instance);
         row++) {
        size_t at = (size_t)row * stride;
        struct expected expected = expect_row(picture, fragment, side, row);
        long double off = fabsl((long double)weights[at] - expected.value);
        if (errors)
            expected.bound = (long double)errors[at] * 0x1p-29L + 16 * u * fabsl(expected.value) +
                             SLOW_LEAST + doubt_of(fragment, side, row);
        if (expected.bound >= HUGE_VALL)
            return -1;
        if (!(off <= 0))
            worst = fmaxl(worst, off / expected.bound);
    }
    return worst;
}

static long double ratio_of_sides(const struct both *picture, const struct slow_fragment *fragment,
                                  const double *weights, const float *errors, size_t stride)
{
    if (picture->lit.surfaces[fragment->triangle->surface].n_sides == 1)
        return ratio_of(picture, fragment, 0, weights, errors, stride);
    if (fragment->side >= 0)
        return ratio_of(picture, fragment, fragment->side, weights, errors, stride);
    return fminl(ratio_of(picture, fragment, 0, weights, errors, stride),
                 ratio_of(picture, fragment, 1, weights, errors, stride));
}

/* Counts the fragments that double precision may show at a pixel. Sets *definite if one of them
 * must be there. */
static int legal_fragments(struct both *picture, int x, int y, bool *definite)
{
    struct slow_fragment *fragments = picture->fragments;
    long double limit = HUGE_VALL;
    int n = 0, n_legal = 0;
    for (int t = 0; t < picture->n_triangles; t++) {
        if (!slow_fragment(&picture->scene, &picture->triangles[t], x, y, &fragments[n]))
            continue;
        if (fragments[n].definite)
            limit = fminl(limit, fragments[n].depth + fragments[n].e_depth);
        n++;
    }
    for (int i = 0; i < n; i++)
        if (!(fragments[i].depth - fragments[i].e_depth > limit))
            fragments[n_legal++] = fragments[i];
    *definite = limit < HUGE_VALL;
    return n_legal;
}

/* Sets a pixel's rows and the program's bounds for single precision; errors is NULL if it has none.
 */
struct bounded_rows {
    const double *rows;
    const float *errors;
    size_t stride;
};

/* Returns the rows of the triangle that the reference shows at a pixel. An ambiguous pixel keeps
 * them with its candidates. */
static struct bounded_rows rows_of(const struct chunk *chunk, int index)
{
    const struct picture *shown = &chunk->picture;
    struct bounded_rows out = {shown->rows + index, chunk->errors + index,
                               (size_t)shown->at.width * (size_t)shown->at.height};
    if (!chunk->is_ambiguous[index])
        return out;
    out.errors = NULL;
    out.stride = 1;
    for (size_t i = 0; i < chunk->n_ambiguous; i++) {
        const struct ambiguous_pixel *pixel = &chunk->ambiguous[i];
        for (int c = pixel->first; pixel->pixel == index && c < pixel->first + pixel->count; c++) {
            const struct candidate *candidate = &chunk->candidates[c];
            if (candidate->loose || candidate->surface != shown->surface[index] ||
                candidate->triangle != shown->triangle[index])
                continue;
            out.rows = chunk->candidate_rows + candidate->first;
            out.errors = chunk->candidate_errors + candidate->first;
        }
    }
    return out;
}

static void judge_pixel(struct both *picture, const struct chunk *chunk, int index,
                        struct counted *counted)
{
    int x = chunk->picture.at.x + index % chunk->picture.at.width,
        y = chunk->picture.at.y + index / chunk->picture.at.width,
        surface = chunk->picture.surface[index];
    size_t stride = (size_t)chunk->picture.at.width * (size_t)chunk->picture.at.height;
    bool definite = false, found = false;
    int n = legal_fragments(picture, x, y, &definite);
    long double best = HUGE_VALL;
    for (int i = 0; i < n; i++)
        if (picture->fragments[i].triangle->surface == surface) {
            found = true;
            best = fminl(best, ratio_of_sides(picture, &picture->fragments[i],
                                              chunk->picture.rows + index, NULL, stride));
        }
    counted->pixels++;
    counted->covered += surface >= 0;
    counted->settled += n == 1 && definite;
    counted->unbounded += found && best < 0;
    bool wrong = surface < 0 ? definite : !found, off = found && !(best <= 1);
    if ((wrong || off) && counted->wrong_surface + counted->wrong_weight == 0)
        printf("# %s: pixel %d %d shows surface %d, legal are %d, difference / bound %Lg\n",
               picture->scene.path, x, y, surface, n, best);
    counted->wrong_surface += wrong;
    counted->wrong_weight += off;
    if (n == 1 && definite && found)
        counted->worst = fmaxl(counted->worst, best);
    struct bounded_rows bounded = rows_of(chunk, index);
    if (n == 1 && definite && found && bounded.errors)
        counted->worst_scaled = fmaxl(counted->worst_scaled,
                                      ratio_of_sides(picture, &picture->fragments[0], bounded.rows,
                                                     bounded.errors, bounded.stride));
}

struct judging {
    struct both *picture;
    struct counted *counted;
};

static bool judge_tile(void *context, const struct tile *tile, struct error *err)
{
    const struct judging *of = context;
    (void)err;
    for (int i = 0; i < tile->n_chunks; i++) {
        const struct chunk *chunk = &tile->chunks[i];
        for (int p = 0; p < chunk->picture.at.width * chunk->picture.at.height; p++)
            judge_pixel(of->picture, chunk, p, of->counted);
    }
    return true;
}

static bool judge_scene(const char *scene, bool exact, struct counted *counted)
{
    struct both picture;
    if (!open_picture(scene, exact, &picture))
        return false;
    draw_tile(&picture, judge_tile, &(struct judging){&picture, counted});
    close_picture(&picture);
    return true;
}

/* At least the given fraction of the covered pixels must have had exactly one possible surface. */
static void check_counted(const struct counted *counted, double part_settled, const char *name)
{
    CHECK(counted->wrong_surface == 0, "%s: each pixel shows what double precision may show", name);
    CHECK(counted->wrong_weight == 0, "%s: weights are within double precision's bound", name);
    if (counted->worst_scaled > 0)
        CHECK(counted->worst_scaled <= 1,
              "%s: weights are within the bounds for single precision, scaled down", name);
    CHECK(counted->covered > 300 && counted->unbounded * 100 < counted->covered &&
              (double)counted->settled >= part_settled * (double)counted->covered,
          "%s: pixels have a bound, and %.0f %% of them one possible surface", name,
          100 * part_settled);
    CHECK(counted->worst > 0.001L, "%s: the bound is not far too wide", name);
    printf("# %ld pixels, %ld covered, %ld settled, %ld unbounded, %ld + %ld wrong, worst "
           "difference / bound %.3Lf, scaled down %.3Lf\n",
           counted->pixels, counted->covered, counted->settled, counted->unbounded,
           counted->wrong_surface, counted->wrong_weight, counted->worst, counted->worst_scaled);
}

/* ---- random scenes ---- */

/* The scenes that scenes.py has written, but those that the program refuses. */
static void check_random_scenes(void)
{
    struct counted counted = {.pixels = 0};
    int refused = 0;
    for (int i = 1; i <= SCENES; i++) {
        char name[32];
        snprintf(name, sizeof name, "%d.scene", i);
        refused += !judge_scene(name, false, &counted);
    }
    CHECK(refused <= SCENES / 20, "%d of %d random scenes are refused", refused, SCENES);
    check_counted(&counted, 0.7, "random scenes");
}

/* ---- hard triangles ---- */

/* The centre of a pixel of the picture. */
static struct vector random_centre(uint64_t *state)
{
    int pixel = random_below(state, WIDTH * HEIGHT);
    return (struct vector){pixel % WIDTH + 0.5, pixel / WIDTH + 0.5, 0};
}

enum hard { SLIVERS, NEEDLES, EDGES_ON_CENTRES, CORNERS_ON_CENTRES, FAR_OFF, FAR_AWAY, ON_GRID };

/* Corners in the window, z being the distance from the eye. */
static void hard_triangle(enum hard kind, uint64_t *state, struct vector out[3])
{
    struct vector p = random_centre(state), d = random_point(state, -1, 1);
    double reach = test_random(state, 3, 30), thin = random_power(state, -12, -3);
    if (kind == NEEDLES)
        thin = random_power(state, -18, -12);
    for (int i = 0; i < 3; i++) {
        struct vector to = random_point(state, -1, 1);
        double far = random_power(state, 2, kind == FAR_AWAY ? 7 : 4),
               along = reach * (i - 1 + 0.3 * to.z);
        double beside = reach * (i == 1 ? thin : -thin);
        double x = WIDTH / 2 + 40 * to.x, y = HEIGHT / 2 + 24 * to.y;
        switch (kind) {
        case SLIVERS: /* p is inside */
        case NEEDLES:
            x = p.x + along * d.x - beside * d.y;
            y = p.y + along * d.y + beside * d.x;
            break;
        case EDGES_ON_CENTRES:
            x = i == 1 ? x : p.x + (i - 1) * reach * d.x;
            y = i == 1 ? y : p.y + (i - 1) * reach * d.y;
            break;
        case CORNERS_ON_CENTRES:
            x = i == 1 ? p.x : x;
            y = i == 1 ? p.y : y;
            break;
        case FAR_OFF:
        case FAR_AWAY:
            x = p.x + far * to.x;
            y = p.y + far * to.y;
            break;
        case ON_GRID:
            x = floor(2 * x) / 2;
            y = floor(2 * y) / 2;
            break;
        }
        double z = test_random(state, 2, 30);
        out[i] = (struct vector){x, y, kind == ON_GRID ? floor(z) : z};
    }
}

struct eye_view {
    bool perspective;
    double scale; /* scale of everything */
};

static void put_face(FILE *file, int a, int b, int c)
{
    fprintf(file, "f %d//%d %d//%d %d//%d\n", a, a, b, b, c, c);
}

static void put_vertex(FILE *file, uint64_t *state, struct vector p)
{
    struct vector to = random_point(state, -1, 1);
    fprintf(file, "v %.17g %.17g %.17g\nvn %.4f %.4f 1\n", p.x, p.y, p.z, to.x, to.y);
}

/* Converts window coordinates to eye space: parallel, or with a vertical angle of 90 degrees. */
static struct vector unproject(struct eye_view view, struct vector p)
{
    double by = view.perspective ? 2 * p.z / HEIGHT : 1;
    return (struct vector){by * (p.x - WIDTH / 2), by * (HEIGHT / 2 - p.y), -p.z};
}

/* Opens a scene of one mesh; the caller writes the mesh next and closes the file. */
static FILE *open_mesh(struct eye_view view)
{
    FILE *file = fopen(path, "w");
    test_need(file != NULL, path);
    fprintf(file, "wavelengths 500 510 10\nsize %d %d\ncamera ", WIDTH, HEIGHT);
    if (view.perspective)
        fprintf(file, "perspective 90");
    else
        fprintf(file, "ortho %.17g", WIDTH * view.scale);
    fprintf(file, " near %.17g far %.17g eye 0 0 0 look 0 0 -1\n", view.scale, 33 * view.scale);
    fprintf(file, "ambient 1 0.1\nlight 1 1 position %g %g %g\nlight d65 1 direction 1 2 3\n",
            5 * view.scale, 7 * view.scale, 9 * view.scale);
    fprintf(
        file,
        "material m { diffuse 1 gloss 9 spectral-texture builtin:textures/picture.tif bilinear }"
        "\nobject mesh reference.obj material m two-sided scale %.17g\n",
        view.scale);
    fclose(file);
    file = fopen("reference.obj", "w");
    test_need(file != NULL, "no mesh can be written");
    return file;
}

/* Puts triangles whose corners are their own. */
static void put_hard_triangles(FILE *file, uint64_t *state, enum hard kind, struct eye_view view,
                               int n)
{
    for (int t = 0; t < n; t++) {
        struct vector corners[3];
        hard_triangle(kind, state, corners);
        for (int c = 0; c < 3; c++)
            put_vertex(file, state, unproject(view, corners[c]));
        put_face(file, 3 * t + 1, 3 * t + 2, 3 * t + 3);
    }
}

static void check_hard_triangles(enum hard kind, struct eye_view view, const char *name)
{
    enum { PICTURES = 20, TRIANGLES = 25 };
    uint64_t state = 5;
    struct counted counted = {.pixels = 0};
    for (int i = 0; i < PICTURES; i++) {
        FILE *file = open_mesh(view);
        put_hard_triangles(file, &state, kind, view, TRIANGLES);
        fclose(file);
        test_need(judge_scene(path, kind == ON_GRID, &counted), path);
    }
    check_counted(&counted, kind == ON_GRID ? 0.8 : 0.97, name);
}

/* Places corners all round the eye: in front of it, beside it and behind it. */
static void check_around_eye(void)
{
    const struct eye_view view = {true, 1};
    uint64_t state = 6;
    struct counted counted = {.pixels = 0};
    for (int i = 0; i < 40; i++) {
        FILE *file = open_mesh(view);
        for (int t = 0; t < 8; t++) {
            for (int c = 0; c < 3; c++) {
                struct vector p = random_point(&state, -9, 9);
                p.z = test_random(&state, -40, 12);
                put_vertex(file, &state, p);
            }
            put_face(file, 3 * t + 1, 3 * t + 2, 3 * t + 3);
        }
        fclose(file);
        test_need(judge_scene(path, false, &counted), path);
    }
    check_counted(&counted, 0.99, "triangles through the planes of near, far and eye");
}

/* ---- triangles that share edges ---- */

static bool note_covered(void *context, const struct tile *tile, struct error *err)
{
    bool *covered = context;
    (void)err;
    for (int i = 0; i < tile->n_chunks; i++) {
        const struct picture *shown = &tile->chunks[i].picture;
        for (int p = 0; p < WIDTH * shown->at.height; p++)
            covered[shown->at.y * WIDTH + p] = shown->surface[p] >= 0;
    }
    return true;
}

/* Draws a picture of one mesh with one triangle, which replaces the first one. */
static void draw_alone(struct both *picture, int triangle, bool covered[WIDTH * HEIGHT])
{
    struct mesh *mesh = &picture->plan.meshes[0].mesh;
    struct instance *instance = &picture->plan.instances[0].instance;
    memmove(mesh->triangles[0], mesh->triangles[triangle], sizeof mesh->triangles[0]);
    instance->n_triangles = 1;
    draw_tile(picture, note_covered, covered);
    instance->n_triangles = mesh->n_triangles;
}

/* Exactly one triangle of the mesh must cover each pixel. */
static void check_once(const char *name)
{
    struct both picture;
    bool covered[WIDTH * HEIGHT];
    int counts[WIDTH * HEIGHT] = {0}, wrong = 0;
    test_need(open_picture(path, false, &picture), path);
    int n = picture.plan.meshes[0].mesh.n_triangles;
    for (int t = 0; t < n; t++) {
        draw_alone(&picture, t, covered);
        for (int p = 0; p < WIDTH * HEIGHT; p++)
            counts[p] += covered[p];
    }
    close_picture(&picture);
    for (int p = 0; p < WIDTH * HEIGHT; p++)
        wrong += counts[p] != 1;
    if (!CHECK(wrong == 0, "%s: exactly one of %d triangles covers each pixel", name, n))
        printf("# %d pixels otherwise\n", wrong);
}

/* A grid of squares cut in halves, larger than the picture: corners and edges lie on pixel centres,
 * except for one corner in `moved`. */
static void check_grid(struct eye_view view, int moved, const char *name)
{
    enum { STEP = 4, ACROSS = WIDTH / STEP + 4, DOWN = HEIGHT / STEP + 4 };
    uint64_t state = 8;
    FILE *file = open_mesh(view);
    for (int i = 0; i < ACROSS * DOWN; i++) {
        struct vector by = random_point(&state, -0.9, 0.9);
        struct vector p = {STEP * (i % ACROSS - 1) + 0.5, STEP * (i / ACROSS - 1) + 0.5, 0};
        p.z = test_random(&state, 2, 30);
        if (moved && random_below(&state, moved) == 0) {
            p.x += by.x;
            p.y += by.y;
        }
        put_vertex(file, &state, unproject(view, p));
    }
    for (int i = 0; i < ACROSS * (DOWN - 1); i++) {
        int a = i + 1, b = a + 1, c = a + ACROSS, d = c + 1;
        bool other = random_below(&state, 2);
        if (i % ACROSS == ACROSS - 1)
            continue;
        put_face(file, a, b, other ? c : d);
        put_face(file, other ? b : a, d, c);
    }
    fclose(file);
    check_once(name);
}

/* ---- signs ---- */

/* Adds a number to an expansion, whose parts go from the smallest to the largest. */
static void grow(double *parts, int *n, double more)
{
    for (int i = 0; i < *n; i++) { /* two-sum */
        double sum = parts[i] + more, other = sum - more;
        parts[i] = (parts[i] - other) + (more - (sum - other));
        more = sum;
    }
    parts[(*n)++] = more;
}

/* Returns the sign of ax by - bx ay without error if no product underflows: the largest part of the
 * expansion that is not 0 decides (Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast
 * Robust Geometric Predicates, 1997). */
static int exact_sign(double ax, double ay, double bx, double by)
{
    double parts[4], p = ax * by, q = bx * ay;
    int n = 0, sign = 0;
    grow(parts, &n, fma(ax, by, -p));
    grow(parts, &n, -fma(bx, ay, -q));
    grow(parts, &n, p);
    grow(parts, &n, -q);
    while (sign == 0 && n-- > 0)
        sign = (parts[n] > 0) - (parts[n] < 0);
    return sign;
}

/* Returns 1 if a pixel's centre is inside a triangle in front of the eye, -1 if outside, 0 if on an
 * edge. */
static int turn_round(const struct surface *surface, const int32_t triangle[3], int pixel)
{
    double x[3], y[3];
    int sign[3], least = 1, most = -1;
    for (int i = 0; i < 3; i++) {
        x[i] = surface->vertices[triangle[i]].x - (pixel % WIDTH + 0.5);
        y[i] = surface->vertices[triangle[i]].y - (pixel / WIDTH + 0.5);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        sign[i] = exact_sign(x[i], y[i], x[j], y[j]);
        least = sign[i] < least ? sign[i] : least;
        most = sign[i] > most ? sign[i] : most;
    }
    if (least == -1 && most == 1)
        return -1;
    return least == most && least != 0;
}

/* Moves a number by a few units in the last place. */
static double nudged(uint64_t *state, double value)
{
    for (int i = random_below(state, 4); i > 0; i--)
        value = nextafter(value, random_below(state, 2) ? HUGE_VAL : -HUGE_VAL);
    return value;
}

static void check_signs(void)
{
    enum { POINTS = 300000 };
    uint64_t state = 10;
    int wrong = 0, unequal = 0, near = 0;
    for (int i = 0; i < POINTS; i++) {
        struct vector p = random_centre(&state);
        double size = random_power(&state, -3, 6), x[3] = {p.x + 1}, y[3] = {p.y - 2};
        struct vector to = random_point(&state, -size, size);
        for (int c = 1; c < 3; c++) { /* in line with the centre; one of four is not */
            double along = test_random(&state, -1, 1);
            x[c] = nudged(&state, p.x + (i % 4 ? along * to.x : to.z));
            y[c] = nudged(&state, p.y + along * to.y);
        }
        struct edge_functions edges, back;
        edges_at(x, y, p.x, p.y, &edges);
        double ax = x[1] - p.x, ay = y[1] - p.y, bx = x[2] - p.x, by = y[2] - p.y;
        double bound = 0x1.01p-53 * (fabs(ax * by) + fabs(bx * ay)), e = edges.e[0];
        near += fabs(e) <= 8 * bound;
        wrong += fabs(e) > bound && (e < 0 ? -1 : 1) != exact_sign(ax, ay, bx, by);
        const double x_back[3] = {x[0], x[2], x[1]}, y_back[3] = {y[0], y[2], y[1]};
        edges_at(x_back, y_back, p.x, p.y, &back);
        unequal += back.e[0] < -e || back.e[0] > -e;
    }
    CHECK(near > POINTS / 4, "many corners are in line with the centre except for a few roundings");
    CHECK(wrong == 0, "an edge function above its rounding error has the right sign");
    CHECK(unequal == 0, "the edge function from the other end is exactly the opposite");
    CHECK(exact_sign(1, 1 + 0x1p-52, 1 - 0x1p-52, 1) > 0 && exact_sign(3, 1, 6, 2) == 0 &&
              exact_sign(0x1p30 + 1, 0x1p30, 0x1p30 + 2, 0x1p30 + 1) > 0,
          "the exact sign is known even if the rounded difference is 0");
}

/* Needles through a centre, whose edge functions may all round to 0 there while the area does not.
 */
static void check_shares(void)
{
    enum { TRIANGLES = 300000 };
    uint64_t state = 12;
    int none = 0, flat = 0;
    for (int i = 0; i < TRIANGLES; i++) {
        const struct vector p = random_centre(&state), to = random_point(&state, -8, 8);
        struct screen_triangle needle = {.inverse_w = {1, 1, 1}, .share = {{1}, {0, 1}, {0, 0, 1}}};
        struct edge_functions at;
        double share[3], *x = needle.x, *y = needle.y;
        for (int c = 0; c < 3; c++) {
            const double along = test_random(&state, -1, 1);
            x[c] = nudged(&state, p.x + along * to.x);
            y[c] = nudged(&state, p.y + along * to.y);
        }
        needle.twice_area = fabs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]));
        edges_at(x, y, p.x, p.y, &at);
        flat += needle.twice_area > 0 && at.e[0] == 0 && at.e[1] == 0 && at.e[2] == 0;
        none += !isfinite(shares_at(&needle, p.x, p.y, share)) || !isfinite(share[0]) ||
                !isfinite(share[1]) || !isfinite(share[2]);
    }
    CHECK(none == 0 && flat > 30,
          "a centre has shares in a needle: %d have none; of %d no area is left", none, flat);
}

/* Triangles are so thin that the rounded corners decide: a centre is covered exactly if the corners
 * in the window, moved by the centre, turn round it. On an edge both results are allowed here; the
 * grids check which is right. */
static void check_needles(struct eye_view view, const char *name)
{
    enum { TRIANGLES = 1000 };
    uint64_t state = 11;
    int inside = 0, wrong = 0;
    bool covered[WIDTH * HEIGHT];
    struct both picture;
    FILE *file = open_mesh(view);
    put_hard_triangles(file, &state, NEEDLES, view, TRIANGLES);
    fclose(file);
    test_need(open_picture(path, false, &picture), path);
    const struct instance *instance = picture.lit.surfaces[0].instance;
    for (int t = 0; t < instance->n_triangles; t++) {
        draw_alone(&picture, t, covered);
        for (int p = 0; p < WIDTH * HEIGHT; p++) {
            int turn = turn_round(&picture.lit.surfaces[0], instance->triangles[t], p);
            inside += turn > 0;
            wrong += (turn > 0 && !covered[p]) || (turn < 0 && covered[p]);
        }
    }
    close_picture(&picture);
    CHECK(inside > TRIANGLES / 10, "%s: some triangles cover a centre", name);
    CHECK(wrong == 0, "%s: a triangle covers exactly the centres inside it without rounding", name);
    printf("# %d inside, %d otherwise\n", inside, wrong);
}

int main(void)
{
    char command[600];
    const char *folder = test_folder();
    snprintf(command, sizeof command,
             "/usr/bin/python3 -B test/raster/reference/scenes.py '%s/test_reference.c' %d %d %d",
             folder, SCENES, WIDTH, HEIGHT);
    test_need(system(command) == 0, "random_scenes.py writes no scenes");
    test_enter();
    const struct eye_view parallel = {false, 1}, perspective = {true, 1}, tiny = {false, 0x1p-20},
                          huge = {true, 1e6};
    check_random_scenes();
    check_hard_triangles(SLIVERS, parallel, "slivers");
    check_hard_triangles(SLIVERS, perspective, "slivers in perspective");
    check_hard_triangles(EDGES_ON_CENTRES, parallel, "edges through pixel centres");
    check_hard_triangles(EDGES_ON_CENTRES, huge,
                         "edges through pixel centres, far larger and in perspective");
    check_hard_triangles(CORNERS_ON_CENTRES, perspective, "corners on pixel centres");
    check_hard_triangles(CORNERS_ON_CENTRES, tiny, "corners on pixel centres, far smaller");
    check_hard_triangles(FAR_OFF, parallel, "distant corners");
    check_hard_triangles(FAR_OFF, perspective, "distant corners in perspective");
    check_hard_triangles(FAR_AWAY, parallel, "corners where single precision has no bound");
    check_hard_triangles(ON_GRID, parallel, "corners on a grid, without error");
    check_around_eye();
    check_grid(parallel, 0, "a grid on pixel centres");
    check_grid(parallel, 3, "a grid with moved corners");
    check_grid(perspective, 3, "a grid with moved corners in perspective");
    check_grid(huge, 0, "a huge grid in perspective");
    check_signs();
    check_shares();
    check_needles(parallel, "needles");
    check_needles(perspective, "needles in perspective");
    return test_end();
}
