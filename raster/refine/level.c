/* SPDX-License-Identifier: MIT */
/* One level of refinement: triangles are judged, the edges that are too long become a set, and
 * every triangle halves those of its edges that are in it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/threads/threads.h"
#include "raster/refine/refine.h"

/* ---- judging ---- */

/* That a thread takes at a time. */
enum { BLOCK_TRIANGLES = 64, BLOCK_VERTICES = 256 };

/* One instance of a refined mesh: its material, on the part and the side that it shows. */
struct judging {
    const struct refinement *of;
    struct refined *refined;
    const struct placed_instance *placed;
    struct cutting cutting;
    struct instance instance;
    struct surface surface;
    struct judged_surface judged;
    unsigned char *wanted; /* of each vertex: a triangle that is to be judged has it; owned */
    unsigned char *judges; /* of each triangle: it is to be judged; owned */
    bool solid;            /* nobody sees the backs of its triangles */
    struct counter failed; /* threads that found no memory */
};

/* Returns whether the instance shows some of the triangle, which has not been judged. */
static bool is_wanted(const struct judging *judging, int triangle)
{
    const struct mesh *mesh = &judging->refined->mesh;
    const struct cutting *cutting = &judging->cutting;
    bool left = false, right = false;
    if (judging->refined->settled[triangle] ||
        (cutting->part >= 0 && mesh->part && mesh->part[triangle] != cutting->part))
        return false;
    for (int k = 0; k < 3 && cutting->side >= 0; k++) {
        const double x = mesh->vertices[mesh->triangles[triangle][k]].position.x;
        left = left || x < 0;
        right = right || x > 0;
    }
    return cutting->side < 0 || (cutting->side == 0 ? left : right);
}

static void judge_triangles(void *context, size_t first, size_t end)
{
    struct judging *judging = context;
    const struct refinement *of = judging->of;
    struct refined *refined = judging->refined;
    struct judged_mesh mesh = {.surface = &judging->judged, .mesh = &refined->mesh};
    mesh.attributes = calloc(2 * ((size_t)of->plan->max_rows + 2), sizeof *mesh.attributes);
    if (!mesh.attributes)
        counter_add(&judging->failed, 1);
    for (size_t i = first; i < end && mesh.attributes; i++) {
        struct judgement *all = &refined->judged[i], one;
        if (!judging->judges[i])
            continue;
        judge_triangle(&of->judge, &mesh, (int)i, &one);
        for (int k = 0; k < 3; k++)
            all->edges[k] = fmaxf(all->edges[k], one.edges[k]);
        all->shading = fmaxf(all->shading, one.shading);
    }
    free(mesh.attributes);
}

static bool open_judging(struct judging *judging, struct error *err)
{
    const struct refinement *of = judging->of;
    struct refined *refined = judging->refined;
    const struct mesh *mesh = &refined->mesh;
    judging->cutting = of->plan->meshes[judging->placed->mesh].cutting;
    judging->instance = judging->placed->instance;
    judging->instance.vertices = mesh->vertices;
    judging->instance.triangles = (const int32_t(*)[3])mesh->triangles;
    judging->instance.n_vertices = mesh->n_vertices;
    judging->instance.n_triangles = mesh->n_triangles;
    judging->instance.model_view = refined->model_view;
    judging->instance.normal_matrix = refined->normal_matrix;
    judging->solid = of->plan->meshes[judging->placed->mesh].solid && refined->in_front &&
                     !judging->placed->object->two_sided;
    judging->wanted = calloc((size_t)mesh->n_vertices + 1, sizeof *judging->wanted);
    judging->judges = calloc((size_t)mesh->n_triangles + 1, sizeof *judging->judges);
    if (!judging->wanted || !judging->judges ||
        !surface_open(&judging->instance, &judging->surface))
        return error_memory(err);
    judging->judged =
        (struct judged_surface){.plan = of->plan,
                                .shaded = judging->placed->shaded,
                                .surface = &judging->surface,
                                .parameters = mesh->parameters,
                                .patches = mesh->parametric ? &refined->patches : NULL,
                                .unit = 1};
    return true;
}

/* Lists the vertices of all triangles that are to be judged. Returns whether there are any. */
static bool want_corners(struct judging *judging)
{
    const struct mesh *mesh = &judging->refined->mesh;
    bool any = false;
    memset(judging->wanted, 0, (size_t)mesh->n_vertices);
    for (int i = 0; i < mesh->n_triangles; i++)
        for (int k = 0; k < 3 && judging->judges[i]; k++)
            judging->wanted[mesh->triangles[i][k]] = any = true;
    return any;
}

static void place_block(void *context, size_t first, size_t end)
{
    struct judging *judging = context;
    for (size_t i = first; i < end; i++)
        if (judging->wanted[i])
            window_of(&judging->judged, judging->refined->mesh.vertices[i].position,
                      &judging->surface.vertices[i]);
}

/* Finds the triangles that are to be judged, before their vertices are lit. */
static bool choose_triangles(struct judging *judging)
{
    const struct mesh *mesh = &judging->refined->mesh;
    const struct judge *judge = &judging->of->judge;
    for (int i = 0; i < mesh->n_triangles; i++)
        judging->judges[i] = is_wanted(judging, i);
    if (!want_corners(judging))
        return false;
    threads_blocks(judging->of->plan->options.threads, (size_t)mesh->n_vertices, BLOCK_VERTICES,
                   place_block, judging);
    for (int i = 0; i < mesh->n_triangles; i++)
        judging->judges[i] =
            judging->judges[i] && judge_concerns(judge, &judging->judged, i, judging->solid);
    return want_corners(judging);
}

static bool judge_instance(const struct refinement *of, int index, struct error *err)
{
    const struct placed_instance *placed = &of->plan->instances[index];
    struct judging judging = {.of = of,
                              .refined = &of->list[of->of_object[object_of(of->plan, index)]],
                              .placed = placed,
                              .failed = COUNTER};
    const struct mesh *mesh = &judging.refined->mesh;
    const bool done = open_judging(&judging, err);
    if (done && choose_triangles(&judging)) {
        light_vertices(of->plan, &of->plan->view, &judging.surface, judging.wanted);
        threads_blocks(of->plan->options.threads, (size_t)mesh->n_triangles, BLOCK_TRIANGLES,
                       judge_triangles, &judging);
    }
    free(judging.wanted);
    free(judging.judges);
    surface_close(&judging.surface);
    return done && (judging.failed.n == 0 || error_memory(err));
}

/* ---- the edges to halve ---- */

static uint64_t edge_at(const struct refined *refined, int triangle, int k)
{
    const int32_t *corner = refined->mesh.triangles[triangle];
    return edge_between(refined->ends[corner[k]], refined->ends[corner[(k + 1) % 3]]);
}

static bool find_ends(struct refined *refined, struct error *err)
{
    const struct mesh *mesh = &refined->mesh;
    free(refined->ends);
    refined->ends = malloc(((size_t)mesh->n_vertices + 1) * sizeof *refined->ends);
    if (!refined->ends)
        return error_memory(err);
    for (int i = 0; i < mesh->n_vertices; i++)
        refined->ends[i] = edge_end(matrix_point(&refined->model_view, mesh->vertices[i].position));
    return true;
}

static bool mark_edges(struct refinement *of, const struct refined *refined, struct error *err)
{
    for (int i = 0; i < refined->mesh.n_triangles; i++)
        for (int k = 0; k < 3 && !refined->settled[i]; k++)
            if (refined->judged[i].edges[k] > 0 &&
                !edges_add(&of->marked, edge_at(refined, i, k), refined->judged[i].edges[k], err))
                return false;
    return true;
}

/* Returns the marks of a triangle's edges, as mesh_subdivide takes them. */
static unsigned char marks_of(const struct refinement *of, const struct refined *refined,
                              int triangle)
{
    unsigned marks = 0;
    for (int k = 0; k < 3; k++)
        marks |= (unsigned)edges_have(&of->marked, edge_at(refined, triangle, k)) << k;
    return (unsigned char)marks;
}

/* A triangle that is divided also halves its longest edge, if that is so many times as long as a
 * marked one: otherwise triangles would become needles. */
static const double most_slender = 2;

static bool mark_longest(struct refinement *of, const struct refined *refined, bool *any,
                         struct error *err)
{
    const struct mesh *mesh = &refined->mesh;
    for (int i = 0; i < mesh->n_triangles; i++) {
        const int32_t *corner = mesh->triangles[i];
        double length[3], shortest = HUGE_VAL;
        float error = 0;
        int longest = 0;
        if (marks_of(of, refined, i) == 0)
            continue;
        for (int k = 0; k < 3; k++) {
            const uint64_t edge = edge_at(refined, i, k);
            const struct vector along = vector_subtract(
                mesh->vertices[corner[k]].position, mesh->vertices[corner[(k + 1) % 3]].position);
            length[k] = vector_length(matrix_direction(&refined->model_view, along));
            longest = length[k] > length[longest] ? k : longest;
            if (edges_have(&of->marked, edge)) {
                shortest = fmin(shortest, length[k]);
                error = fmaxf(error, edges_error(&of->marked, edge));
            }
        }
        const uint64_t edge = edge_at(refined, i, longest);
        if (!(length[longest] > most_slender * shortest) || edges_have(&of->marked, edge))
            continue;
        if (!edges_add(&of->marked, edge, error, err))
            return false;
        *any = true;
    }
    return true;
}

/* Marks the edges of all triangles that are not good enough. */
static bool mark_all(struct refinement *of, struct error *err)
{
    enum { MOST_ROUNDS = 4 };
    bool any = true, done = true;
    edges_free(&of->marked);
    for (int i = 0; done && i < of->n; i++)
        done = find_ends(&of->list[i], err) && mark_edges(of, &of->list[i], err);
    for (int round = 0; done && any && of->marked.n > 0 && round < MOST_ROUNDS; round++) {
        any = false;
        for (int i = 0; done && i < of->n; i++)
            done = mark_longest(of, &of->list[i], &any, err);
    }
    return done;
}

/* ---- one level ---- */

static bool judge_level(const struct refinement *of, struct error *err)
{
    for (int i = 0; i < of->n; i++) {
        const struct refined *refined = &of->list[i];
        for (int k = 0; k < refined->mesh.n_triangles; k++)
            if (!refined->settled[k])
                refined->judged[k] = (struct judgement){.shading = 0};
    }
    for (int i = 0; i < of->plan->n_instances; i++) {
        const struct placed_instance *placed = &of->plan->instances[i];
        if (placed->in_view && !placed->twin && of->of_object[object_of(of->plan, i)] >= 0 &&
            !judge_instance(of, i, err))
            return false;
    }
    return true;
}

/* Settles the n triangles of a finer mesh that are those of the mesh, with their judgements. */
static bool keep_judgements(struct refined *refined, const unsigned char *marks,
                            const int32_t *source, int n, struct error *err)
{
    unsigned char *settled = calloc((size_t)n + 1, sizeof *settled);
    struct judgement *judged = calloc((size_t)n + 1, sizeof *judged);
    if (!settled || !judged) {
        free(settled);
        free(judged);
        return error_memory(err);
    }
    for (int i = 0; i < n; i++) {
        settled[i] = marks[source[i]] == 0;
        if (settled[i])
            judged[i] = refined->judged[source[i]];
    }
    free(refined->settled);
    free(refined->judged);
    refined->settled = settled;
    refined->judged = judged;
    return true;
}

/* Makes a mesh finer, whose triangles have these marks. */
static bool divide_mesh(struct refined *refined, const unsigned char *marks, struct error *err)
{
    struct mesh finer;
    int32_t *source;
    const struct patches *patches = refined->mesh.parametric ? &refined->patches : NULL;
    bool done = mesh_subdivide(&refined->mesh, patches, marks, &finer, &source, err);
    if (!done || !keep_judgements(refined, marks, source, finer.n_triangles, err)) {
        if (done)
            mesh_free(&finer);
        free(source);
        return false;
    }
    free(source);
    mesh_free(&refined->mesh);
    refined->mesh = finer;
    if (refined->shape.planar) {
        mesh_planar(&refined->mesh);
        shape_repeat_texture(&refined->shape, &refined->mesh);
    }
    return true;
}

static bool divide_marked(struct refinement *of, struct refined *refined, struct error *err)
{
    const int n = refined->mesh.n_triangles;
    unsigned char *marks = malloc((size_t)n + 1);
    bool any = false;
    if (!marks)
        return error_memory(err);
    for (int i = 0; i < n; i++) {
        marks[i] = marks_of(of, refined, i);
        any = any || marks[i] > 0;
    }
    bool done = true;
    if (any)
        done = divide_mesh(refined, marks, err);
    else
        memset(refined->settled, 1, (size_t)n);
    of->changed = of->changed || any;
    free(marks);
    return done;
}

static long count_triangles(const struct refinement *of)
{
    long n = 0;
    for (int i = 0; i < of->n; i++)
        n += of->list[i].mesh.n_triangles;
    return n;
}

/* Forgets the least wrong of the marked edges, if the triangles that they make would be too many. A
 * halved edge makes one triangle on each side. */
static bool limit(struct refinement *of, struct error *err)
{
    const long room = of->result->wanted.most_triangles - count_triangles(of);
    if (2 * (double)of->marked.n <= (double)room)
        return true;
    of->result->stopped = true;
    return edges_keep_worst(&of->marked, room > 0 ? (size_t)room / 2 : 0, err);
}

/* Judges the triangles that are not settled, and divides those that are not good enough. */
bool refine_level(struct refinement *of, struct error *err)
{
    bool done = judge_level(of, err) && mark_all(of, err) && limit(of, err);
    of->changed = false;
    for (int i = 0; done && i < of->n; i++)
        done = divide_marked(of, &of->list[i], err);
    of->result->levels += of->changed;
    return done;
}
