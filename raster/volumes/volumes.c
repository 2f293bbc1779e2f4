/* SPDX-License-Identifier: MIT */
/* Makes shadow volumes. Positions are computed in double and rounded once, and each corner is the
 * same numbers wherever it occurs: so OpenGL's volumes have no gaps, and a cap lies exactly where
 * the surface lies that it repeats. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/volumes/volumes.h"

/* A triangle that throws a shadow. */
struct cap {
    struct occluder of;
    int side;          /* 1: it faces the light; -1: it turns away */
    bool is_behind;    /* beyond the far plane, or at it */
    int32_t corner[3]; /* vertices of its volume, once make_vertices has made them */
};
/* The volumes of an object while they are made. */
struct maker {
    const struct lit_scene *lit;
    const struct eye_light *light;
    struct vector towards;    /* the light's place in the mesh's space, or the direction to it */
    double farthest, nearest; /* from the light: any point in view; the caps */
    double reach;             /* the scale from the light, or the length of the shift */
    int first, end;           /* the instances of the object */
    struct cap *caps;
    int n_caps;
    struct volume *out;
    int n_near;           /* vertices of it; the far ones follow */
    struct index corners; /* by their places: vertices of it at one place are one */
};

/* An edge of caps. */
struct edge {
    int32_t ends[2], n; /* the smaller number first; how many more caps run this way than back */
};

/* ---- where a light stands, and how far shadows reach ---- */

static struct vector row_of(const struct cofactors *of, int column)
{
    return (struct vector){of->value[0][column], of->value[1][column], of->value[2][column]};
}

/* The light in the space of the object's mesh: by Cramer's rule. */
static struct vector light_in_mesh(const struct maker *maker)
{
    const struct matrix *m = &maker->lit->plan->instances[maker->first].instance.model_view;
    const struct cofactors *of = &maker->lit->bounds[maker->first].cofactors;
    const struct vector origin = {m->row[0][3], m->row[1][3], m->row[2][3]},
                        at = maker->light->position,
                        v = maker->light->directional ? at : vector_subtract(at, origin);
    const double factor = ldexp(1 / of->determinant, -of->exponent);
    return (struct vector){factor * vector_dot(row_of(of, 0), v),
                           factor * vector_dot(row_of(of, 1), v),
                           factor * vector_dot(row_of(of, 2), v)};
}

/* The distance of a point from the light; from a directional one, along its rays. */
static double distance_from(const struct eye_light *light, struct vector eye)
{
    return light->directional ? -vector_dot(light->position, eye)
                              : vector_length(vector_subtract(eye, light->position));
}

/* The distance of the farthest corner of the view: no point in view is farther from the light. */
static double farthest_in_view(const struct plan *plan, const struct eye_light *light)
{
    const double far = plan->scene->camera.far / plan->unit;
    double farthest = -HUGE_VAL;
    for (int i = 0; i < 8; i++) {
        const double depth = i & 4 ? far : plan->near,
                     size = plan->scene->camera.perspective ? depth : 1,
                     x = size / plan->view.projection.row[0][0],
                     y = size / plan->view.projection.row[1][1];
        const struct vector corner = {i & 1 ? x : -x, i & 2 ? y : -y, -depth};
        farthest = fmax(farthest, distance_from(light, corner));
    }
    return farthest;
}

/* A lower bound on the distance of a light from a triangle: from its plane, and from its box; from
 * a directional one, along its rays, the distance of the nearest corner. */
static double triangle_distance(const struct eye_light *light, const struct vector corner[3])
{
    const struct vector normal =
                            vector_normalise(vector_cross(vector_subtract(corner[1], corner[0]),
                                                          vector_subtract(corner[2], corner[0]))),
                        low = vector_least(corner[0], vector_least(corner[1], corner[2])),
                        high = vector_greatest(corner[0], vector_greatest(corner[1], corner[2])),
                        at = light->position;
    const struct vector beside = {fmax(0, fmax(low.x - at.x, at.x - high.x)),
                                  fmax(0, fmax(low.y - at.y, at.y - high.y)),
                                  fmax(0, fmax(low.z - at.z, at.z - high.z))};
    if (light->directional)
        return fmin(distance_from(light, corner[0]),
                    fmin(distance_from(light, corner[1]), distance_from(light, corner[2])));
    return fmax(fabs(vector_dot(normal, vector_subtract(at, corner[0]))), vector_length(beside));
}

/* The side of a triangle's plane on which the light lies: 1 in front, seen from outside. */
static int light_side(const struct maker *maker, int surface, int triangle)
{
    const struct homogeneous light = {maker->light->position, maker->light->directional};
    const int side =
        occluder_side(&maker->lit->occluders, (struct occluder){surface, triangle}, &light);
    return maker->lit->plan->instances[surface].instance.mirrored ? -side : side;
}

/* ---- caps ---- */

/* Returns whether all of a solid lies on one side of the light: the triangles that face it then
 * throw all of its shadow. */
static bool is_beside(const struct maker *maker, const struct placed_instance *placed)
{
    const struct plan_mesh *of = &maker->lit->plan->meshes[placed->mesh];
    const struct vector at = maker->towards;
    struct vector low, high;
    mesh_box(&of->mesh, &low, &high);
    return of->solid && (maker->light->directional || at.x < low.x || at.x > high.x ||
                         at.y < low.y || at.y > high.y || at.z < low.z || at.z > high.z);
}

/* Returns whether OpenGL may have all of a triangle beyond the far plane, or at it. */
static bool is_behind(const struct lit_scene *lit, int instance, const int32_t vertex[3])
{
    for (int i = 0; i < 3; i++) {
        const double *clip = lit->surfaces[instance].vertices[vertex[i]].clip;
        const float *e_clip = lit->bounds[instance].vertices[vertex[i]].e_clip;
        if (clip[CLIP_Z] + (double)e_clip[CLIP_Z] < clip[CLIP_W] - (double)e_clip[CLIP_W])
            return false;
    }
    return true;
}

/* Lists the triangles of an instance that throw a shadow. A solid beside the light needs those of
 * one side only. */
static bool list_caps(struct maker *maker, int instance, struct error *err)
{
    const struct placed_instance *placed = &maker->lit->plan->instances[instance];
    const struct vector *eye = maker->lit->occluders.vertices[instance];
    const bool beside = is_beside(maker, placed);
    for (int t = 0; t < placed->instance.n_triangles; t++) {
        const int32_t *v = placed->instance.triangles[t];
        const struct vector corner[3] = {eye[v[0]], eye[v[1]], eye[v[2]]};
        const struct cap cap = {.of = {instance, t},
                                .side = light_side(maker, instance, t),
                                .is_behind = is_behind(maker->lit, instance, v)};
        if (cap.side == 0 || (cap.side < 0 && beside))
            continue;
        maker->nearest = fmin(maker->nearest, triangle_distance(maker->light, corner));
        if (!array_add(&maker->caps, &maker->n_caps, &cap, sizeof cap, err))
            return false;
    }
    return true;
}

/* Returns the place in the mesh of a corner of a cap. */
static struct vector corner_of(const struct maker *maker, const struct cap *cap, int i)
{
    const struct instance *of = &maker->lit->plan->instances[cap->of.surface].instance;
    return of->vertices[of->triangles[cap->of.triangle][i]].position;
}

/* Brings the caps to the front that reach one side of a plane through a point. Returns their
 * number. */
static int sort_caps(const struct maker *maker, struct cap *caps, int n, struct vector normal,
                     struct vector point)
{
    int kept = 0;
    for (int i = 0; i < n; i++) {
        bool reaches = false;
        for (int c = 0; c < 3; c++)
            reaches = reaches ||
                      vector_dot(normal, vector_subtract(corner_of(maker, &caps[i], c), point)) > 0;
        if (reaches) {
            const struct cap cap = caps[i];
            caps[i] = caps[kept];
            caps[kept++] = cap;
        }
    }
    return kept;
}

/* OpenGL counts the caps between a point and the light in 8 bits. */
enum { MOST_COUNTED = UINT8_MAX, MOST_PLANES = 512, MOST_LOOKS = 256 };

/* Returns whether a ray of the light may meet more caps than can be counted. Planes through the
 * light and an edge of a cap part them again and again: a ray lies on one side of each. *looks is
 * how many caps may still be looked at: where that does not suffice, they may. */
static bool may_wrap(const struct maker *maker, struct cap *caps, int n, int level, int64_t *looks)
{
    *looks -= n;
    if (n <= MOST_COUNTED || *looks < 0 || level == MOST_PLANES)
        return n > MOST_COUNTED;
    const struct cap *cap = &caps[level * 7919L % n]; /* another one at each level */
    const struct vector from = corner_of(maker, cap, level % 3),
                        to = corner_of(maker, cap, (level + 1) % 3),
                        ray = maker->light->directional ? maker->towards
                                                        : vector_subtract(from, maker->towards);
    struct vector normal = vector_cross(ray, vector_subtract(to, from));
    if (!(vector_reach(normal) > 0))
        return may_wrap(maker, caps, n, level + 1, looks);
    for (int side = 0; side < 2; side++, normal = vector_scale(normal, -1))
        if (may_wrap(maker, caps, sort_caps(maker, caps, n, normal, from), level + 1, looks))
            return true;
    return false;
}

/* ---- vertices ---- */

/* Adds a vertex, rounded as OpenGL gets it. */
static bool add_vertex(struct volume *out, struct vector at, struct error *err)
{
    const struct vertex vertex = {
        .position = {round_to_single(at.x), round_to_single(at.y), round_to_single(at.z)}};
    return array_add(&out->vertices, &out->n_vertices, &vertex, sizeof vertex, err);
}

/* Makes the vertices of n caps: where they are, and then at the far end. */
static bool make_vertices(struct maker *maker, struct cap *caps, int n, struct error *err)
{
    struct volume *out = maker->out;
    for (int i = 0; i < 3 * n; i++) {
        const struct vector at = corner_of(maker, &caps[i / 3], i % 3);
        const float key[3] = {(float)at.x + 0, (float)at.y + 0, (float)at.z + 0}; /* -0 is 0 */
        int32_t *vertex = &caps[i / 3].corner[i % 3];
        *vertex = index_find(&maker->corners, key, sizeof key);
        if (*vertex >= 0)
            continue;
        *vertex = out->n_vertices;
        if (!index_add(&maker->corners, key, sizeof key, *vertex, err) || !add_vertex(out, at, err))
            return false;
    }
    maker->n_near = out->n_vertices;
    for (int v = 0; v < maker->n_near; v++) {
        const struct vector at = out->vertices[v].position, towards = maker->towards;
        const struct vector far =
            maker->light->directional
                ? vector_subtract(at, vector_scale(towards, maker->reach))
                : vector_add(towards, vector_scale(vector_subtract(at, towards), maker->reach));
        if (!add_vertex(out, far, err))
            return false;
    }
    return true;
}

/* ---- triangles ---- */

/* A triangle of a volume that repeats no other one has this one. */
static const struct occluder no_cap = {-1, -1};

static bool add_triangle(struct maker *maker, const int32_t corners[3], struct occluder cap,
                         struct error *err)
{
    struct volume *out = maker->out;
    int n = out->n;
    return array_add(&out->triangles, &n, corners, 3 * sizeof *corners, err) &&
           array_add(&out->caps, &out->n, &cap, sizeof cap, err);
}

/* Adds the part of a cap beyond the far plane, which OpenGL cuts off the cap itself. Caps that
 * share an edge cut it at the same numbers. */
static bool add_beyond(struct maker *maker, const struct cap *cap, struct error *err)
{
    static const struct clip_plane far_plane = {{0, 0, 1, -1}, 0};
    const struct surface *surface = &maker->lit->surfaces[cap->of.surface];
    struct corner whole[3], corners[CLIP_CORNERS];
    int32_t number[CLIP_CORNERS];
    whole_corners(surface, surface->instance->triangles[cap->of.triangle], whole);
    const int n = clip_polygon(&far_plane, whole, 3, corners);
    for (int i = 0; i < n; i++) {
        struct vector point = {0, 0, 0};
        for (int c = 0; c < 3; c++)
            point = vector_add(point, vector_scale(corner_of(maker, cap, c), corners[i].share[c]));
        number[i] = corners[i].inner == corners[i].outer ? cap->corner[corners[i].inner]
                                                         : maker->out->n_vertices;
        if (number[i] == maker->out->n_vertices && !add_vertex(maker->out, point, err))
            return false;
    }
    for (int i = 2; i < n; i++) {
        const int32_t corner[3] = {number[0], number[cap->side > 0 ? i - 1 : i],
                                   number[cap->side > 0 ? i : i - 1]};
        if (!add_triangle(maker, corner, no_cap, err))
            return false;
    }
    return true;
}

/* Parts that are made of caps: caps, and what of them lies beyond the far plane; the far end; and
 * caps that are behind. */
enum cap_part { CAP_NEAR, CAP_BEYOND, CAP_FAR, CAP_BEHIND };

static bool add_cap(struct maker *maker, const struct cap *cap, enum cap_part part,
                    struct error *err)
{
    const int32_t n = part == CAP_FAR ? maker->n_near : 0, *at = cap->corner;
    const bool turned = (part == CAP_FAR && cap->side > 0) || (part == CAP_BEHIND && cap->side < 0);
    const int32_t corners[3] = {at[0] + n, at[turned ? 2 : 1] + n, at[turned ? 1 : 2] + n};
    if (part == CAP_BEYOND)
        return add_beyond(maker, cap, err);
    return add_triangle(maker, corners, part == CAP_NEAR ? cap->of : no_cap, err);
}

/* Adds this part of n caps: of those on one side, or, side 0, of all. */
static bool add_caps(struct maker *maker, const struct cap *caps, int n, int side,
                     enum cap_part part, struct error *err)
{
    for (int i = 0; i < n; i++)
        if ((side == 0 || caps[i].side == side) &&
            (part == CAP_FAR || caps[i].is_behind == (part == CAP_BEHIND)) &&
            !add_cap(maker, &caps[i], part, err))
            return false;
    return true;
}

static int compare_edges(const void *one, const void *other)
{
    const int32_t *a = ((const struct edge *)one)->ends, *b = ((const struct edge *)other)->ends;
    return a[0] != b[0] ? (a[0] > b[0]) - (a[0] < b[0]) : (a[1] > b[1]) - (a[1] < b[1]);
}

static bool add_side(struct maker *maker, const struct edge *edge, struct error *err)
{
    const int32_t a = edge->ends[edge->n < 0], b = edge->ends[edge->n > 0], n = maker->n_near;
    const int32_t one[3] = {b, a, a + n}, other[3] = {b, a + n, b + n};
    for (int k = abs(edge->n); k > 0; k--)
        if (!add_triangle(maker, one, no_cap, err) || !add_triangle(maker, other, no_cap, err))
            return false;
    return true;
}

/* Adds the sides of the volume of n caps: at edges that caps do not share. They go round the light
 * alike: a triangle that turns away is taken from behind. */
static bool add_sides(struct maker *maker, const struct cap *caps, int n, struct error *err)
{
    struct edge *list;
    bool done = MAKE_ARRAY(list, 3 * (size_t)n, err, "the edges of a shadow");
    for (int i = 0; done && i < 3 * n; i++) {
        const int32_t *corner = caps[i / 3].corner, from = corner[i % 3], to = corner[(i + 1) % 3];
        list[i] = (struct edge){{from < to ? from : to, from < to ? to : from},
                                caps[i / 3].side * ((from < to) - (from > to))};
    }
    if (done)
        qsort(list, 3 * (size_t)n, sizeof *list, compare_edges);
    for (int i = 0; done && i < 3 * n; i++)
        if (i + 1 < 3 * n && compare_edges(&list[i], &list[i + 1]) == 0)
            list[i + 1].n += list[i].n;
        else
            done = add_side(maker, &list[i], err);
    free(list);
    return done;
}

/* Caps that do not face the light come last, with the order of their corners. */
static bool add_triangles(struct maker *maker, const struct cap *caps, int n, struct error *err)
{
    struct volume *out = maker->out;
    if (!add_caps(maker, caps, n, 1, CAP_NEAR, err))
        return false;
    out->n_caps = out->n;
    if (!add_sides(maker, caps, n, err))
        return false;
    out->first_beyond = out->n;
    if (!add_caps(maker, caps, n, 0, CAP_BEYOND, err))
        return false;
    out->first_far = out->n;
    if (!add_caps(maker, caps, n, 0, CAP_FAR, err) || !add_caps(maker, caps, n, 0, CAP_BEHIND, err))
        return false;
    out->n_outward = out->n;
    return add_caps(maker, caps, n, -1, CAP_NEAR, err);
}

/* ---- volumes ---- */

void volume_corners(const struct volume *volume, int first, int n, size_t step, float *out)
{
    for (int i = 3 * first; i < 3 * (first + n); i++, out += step) {
        const struct vector p = volume->vertices[volume->triangles[i / 3][i % 3]].position;
        out[0] = (float)p.x;
        out[1] = (float)p.y;
        out[2] = (float)p.z;
    }
}

/* Returns whether the far end lies beyond all in view as OpenGL has it, too: what it rounds of a
 * vertex, 12 roundings in each of x, y and z (see bounds/vertex.c), is less than half of the way.
 */
static bool ends_beyond(const struct maker *maker)
{
    const struct volume *out = maker->out;
    const struct matrix *m = &maker->lit->plan->instances[maker->first].instance.model_view;
    const double spare = maker->light->directional ? maker->reach / 2 : maker->farthest;
    double largest = 0;
    for (int i = maker->n_near; i < 2 * maker->n_near; i++) {
        const struct vector at = out->vertices[i].position;
        const double far[4] = {at.x, at.y, at.z, 1};
        double magnitude[4];
        matrix_magnitudes(m, far, magnitude);
        largest = fmax(largest, magnitude[0] + magnitude[1] + magnitude[2]);
    }
    return roundings(12) * largest < spare;
}

/* Adds the volume of n caps to the list. */
static bool make_volume(struct maker *maker, struct cap *caps, int n, int shadowed,
                        struct volumes *list, struct error *err)
{
    const struct volume fresh = {.shadowed = shadowed, .instance = maker->first};
    if (!array_add(&list->list, &list->n, &fresh, sizeof fresh, err))
        return false;
    maker->out = &list->list[list->n - 1];
    const bool done = make_vertices(maker, caps, n, err) && add_triangles(maker, caps, n, err);
    maker->out->is_doubtful = done && !ends_beyond(maker);
    index_free(&maker->corners);
    return done;
}

/* Makes the volumes of an object: one, or where OpenGL could not count its caps, several. They end
 * beyond all in view, by as much again for roundings. */
static bool make_volumes(struct maker *maker, int shadowed, struct volumes *list, struct error *err)
{
    maker->towards = light_in_mesh(maker);
    for (int i = maker->first; i < maker->end; i++)
        if (!list_caps(maker, i, err))
            return false;
    maker->reach = maker->light->directional ? 2 * fmax(0, maker->farthest - maker->nearest)
                                             : fmax(2, 2 * maker->farthest / maker->nearest);
    int64_t looks = (int64_t)MOST_LOOKS * maker->n_caps;
    const int most =
        may_wrap(maker, maker->caps, maker->n_caps, 0, &looks) ? MOST_COUNTED : maker->n_caps;
    for (int i = 0, n; i < maker->n_caps; i += n) {
        n = maker->n_caps - i < most ? maker->n_caps - i : most;
        if (!make_volume(maker, maker->caps + i, n, shadowed, list, err))
            return false;
    }
    return true;
}

/* Makes the volumes of a light. Instances of one object follow each other. */
static bool list_volumes(const struct lit_scene *lit, int shadowed, struct volumes *out,
                         struct error *err)
{
    const struct plan *plan = lit->plan;
    const struct eye_light *light = shadow_light(&plan->view, shadowed);
    const double farthest = farthest_in_view(plan, light);
    const struct placed_instance *of = plan->instances;
    bool done = true;
    for (int first = 0, end; done && first < plan->n_instances; first = end) {
        struct maker maker = {
            .lit = lit, .light = light, .farthest = farthest, .nearest = HUGE_VAL, .first = first};
        for (end = first; end < plan->n_instances && of[end].object == of[first].object;)
            end++;
        maker.end = end;
        done = (of[first].casts >> shadowed & 1) == 0 || make_volumes(&maker, shadowed, out, err);
        free(maker.caps);
    }
    return done;
}

/* A volume as a mesh that is placed like the object that throws the shadow. */
static struct placed_instance place_volume(const struct plan *plan, const struct volume *volume)
{
    const struct placed_instance *of = &plan->instances[volume->instance];
    return (struct placed_instance){
        .object = of->object,
        .shaded = of->shaded,
        .in_view = true,
        .instance = {.vertices = volume->vertices,
                     .triangles = (const int32_t(*)[3])volume->triangles,
                     .n_vertices = volume->n_vertices,
                     .n_triangles = volume->n,
                     .model_view = of->instance.model_view,
                     .normal_matrix = of->instance.normal_matrix,
                     .mirrored = of->instance.mirrored}};
}

bool volumes_make(const struct lit_scene *lit, struct volumes *out, struct error *err)
{
    *out = (struct volumes){.n = 0};
    for (int i = 0; i < lit->plan->view.n_shadowed; i++)
        if (!list_volumes(lit, i, out, err))
            return false;
    if (!MAKE_ARRAY(out->instances, out->n, err, "%d shadows", out->n))
        return false;
    for (int i = 0; i < out->n; i++)
        out->instances[i] = place_volume(lit->plan, &out->list[i]);
    return lit_place_volumes(lit, out->instances, out->n, &out->lit, err);
}

void volumes_free(struct volumes *volumes)
{
    lit_free(&volumes->lit);
    for (int i = 0; i < volumes->n; i++) {
        struct volume *volume = &volumes->list[i];
        FREE_ALL(volume->caps, volume->vertices, volume->triangles);
    }
    FREE_ALL(volumes->list, volumes->instances);
    *volumes = (struct volumes){.n = 0};
}
