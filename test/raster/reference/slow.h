/* SPDX-License-Identifier: MIT */
/* A second reference, slow and simple. It shares only the plan and its structs with
 * raster/reference. A pixel is inside a triangle if the three homogeneous edge functions say so
 * (Olano and Greer, Triangle Scan Conversion using 2D Homogeneous Coordinates, 1997). So nothing is
 * clipped, no corner is divided by its w, and triangles through the eye are no special case.
 * Vertices are lit as in the OpenGL 2.1 specification, section 2.14.1.
 *
 * It computes in long double, whose 64 bits on x86 (113 elsewhere) make its own error 2^-11 of the
 * error it measures. On machines where long double is double, both references have equal errors:
 * the comparison still finds every mistake, but differences may reach twice the bounds.
 *
 * Bounds are on the error of raster/reference in double, u = 2^-53 being its unit roundoff:
 *
 * - A vertex goes through two products with a matrix, each four multiplications and three
 *   additions: 4 roundings of each term, 8 of each homogeneous coordinate, 9 with those of second
 *   order. Division and viewport add 3, relative to 1 + |x / w| halves of the picture.
 * - A corner made by clipping has 3 more roundings, relative to the ends of its edge. Its place
 *   along the edge does not matter: its weights move with it.
 * - Edge functions: a corner off by e in x and y changes a x b by e (|a|_1 + |b|_1) + 2 e^2;
 *   differences to the centre (2), products and their difference (2) round 4 times.
 * - Interpolation: with f_i = E_i / w_i, a value r = sum f_i a_i / sum f_i is off by
 *   sum |a_i - r| (e_i / w_i + |f_i| e_w) / sum f_i, over 1 minus the relative error of the sum of
 *   f. No bound exists if that error exceeds a quarter. e_i bounds the error of E_i, and e_w that
 *   of 1 / w. Weights, their sums and the corners' shares round 16 times, relative to the largest
 *   of them.
 * - Weights of vertices: the program's own bounds for OpenGL's single precision, which count
 *   roundings of the same formulas, times 2^-29. They are at most linear in u from there on down
 *   (powers of cosines are convex where exponents are at least 1), except for vertices at a
 *   light's horizon or at the edge of a spot, which may be lit or not. Sums over lights round
 *   twice for each light. */
#ifndef SLOW_H
#define SLOW_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/maths/maths.h"
#include "data/scene/scene.h"
#include "raster/bounds/bounds.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"

static const long double u = 0x1p-53L;
#define SLOW_LEAST 1e-60L /* far below the range of single precision, which ends bounds */

enum { SLOW_ATTRIBUTES = 60, SLOW_CORNERS = 5 };

/* ---- vectors ---- */

struct triple {
    long double x, y, z;
};

static struct triple triple_of(struct vector v)
{
    return (struct triple){(long double)v.x, (long double)v.y, (long double)v.z};
}

static struct triple triple_sum(struct triple a, struct triple b, long double factor)
{
    return (struct triple){a.x + b.x * factor, a.y + b.y * factor, a.z + b.z * factor};
}

static long double triple_dot(struct triple a, struct triple b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static struct triple triple_unit(struct triple a)
{
    const struct triple none = {0, 0, 0};
    long double length = sqrtl(triple_dot(a, a));
    return length > 0 ? triple_sum(none, a, 1 / length) : none;
}

/* Computes the product of a matrix with a column, and the sum of its terms' magnitudes. */
static void slow_transform(const struct matrix *m, const long double in[4],
                           const long double in_magnitude[4], long double out[4],
                           long double magnitude[4])
{
    for (int i = 0; i < 4; i++) {
        out[i] = magnitude[i] = 0;
        for (int j = 0; j < 4; j++) {
            out[i] += (long double)m->row[i][j] * in[j];
            magnitude[i] += fabsl((long double)m->row[i][j]) * in_magnitude[j];
        }
    }
}

/* Computes the cofactors of the upper left 3x3: its inverse transpose times its determinant. */
static long double cofactor(const struct matrix *m, int i, int j)
{
    int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    return (long double)m->row[i1][j1] * (long double)m->row[i2][j2] -
           (long double)m->row[i1][j2] * (long double)m->row[i2][j1];
}

static bool slow_mirrored(const struct matrix *m)
{
    long double determinant = 0;
    for (int j = 0; j < 3; j++)
        determinant += (long double)m->row[0][j] * cofactor(m, 0, j);
    return determinant < 0;
}

/* ---- vertices ---- */

struct slow_vertex {
    long double clip[4], e_clip[4];
    long double value[2][SLOW_ATTRIBUTES], error[2][SLOW_ATTRIBUTES],
        doubt[2][SLOW_ATTRIBUTES]; /* weights of front and back; the part that may be lit or not */
};

static struct triple slow_normal(const struct matrix *m, struct vector normal)
{
    long double sign = slow_mirrored(m) ? -1 : 1, out[3];
    for (int i = 0; i < 3; i++)
        out[i] = sign * (cofactor(m, i, 0) * (long double)normal.x +
                         cofactor(m, i, 1) * (long double)normal.y +
                         cofactor(m, i, 2) * (long double)normal.z);
    return triple_unit((struct triple){out[0], out[1], out[2]});
}

/* Returns the value if its gate is above 0, else 0. If the gate is so near to 0 that rounding may
 * decide, the whole value is in doubt; no error of the gate reaches 2^-40 unless a triangle is
 * flattened a thousandfold. */
static long double slow_gate(long double gate, long double value, long double *doubt)
{
    if (fabsl(gate) < 0x1p-40L)
        *doubt = fmaxl(*doubt, value);
    return gate > 0 ? value : 0;
}

/* Returns the fraction of a light that is left by distance and spot. */
static long double slow_falloff(const struct plan *plan, int index, struct triple path,
                                long double *doubt)
{
    const struct light *light = plan->sources[index];
    const struct eye_light *from = &plan->lights[index];
    long double distance = sqrtl(triple_dot(path, path)) * (long double)plan->unit;
    if (light->directional)
        return 1;
    long double left =
        1 / ((long double)light->attenuation[0] + (long double)light->attenuation[1] * distance +
             (long double)light->attenuation[2] * distance * distance);
    if (!light->spot || light->spot_cutoff_deg > 90)
        return left;
    long double cosine = -triple_dot(triple_unit(path), triple_of(from->axis));
    long double in_cone = powl(fmaxl(cosine, 0), (long double)light->spot_exponent);
    return slow_gate(cosine - (long double)from->cutoff_cosine, left * in_cone, doubt);
}

/* Returns the weight of one light in a diffuse or specular term. *doubt is the part that rounding
 * may turn on or off. */
static long double slow_weight(const struct plan *plan, int index, enum reflection reflection,
                               double gloss, struct triple normal, struct triple eye,
                               long double *doubt)
{
    const struct eye_light *light = &plan->lights[index];
    struct triple path = triple_of(light->position), view = {0, 0, 1}, none = {0, 0, 0};
    if (!plan->sources[index]->directional)
        path = triple_sum(path, eye, -1);
    struct triple towards = triple_unit(path);
    if (plan->scene->local_viewer)
        view = triple_unit(triple_sum(none, eye, -1));
    struct triple half = triple_unit(triple_sum(towards, view, 1));
    long double n_l = triple_dot(normal, towards), in_spot = 0;
    long double left = (long double)light->share * slow_falloff(plan, index, path, &in_spot);
    long double factor = fmaxl(n_l, 0);
    if (reflection == SPECULAR)
        factor = powl(fmaxl(triple_dot(normal, half), 0), (long double)gloss);
    long double value = slow_gate(n_l, factor * left, doubt);
    *doubt = fmaxl(*doubt, factor * in_spot);
    return value;
}

static void slow_light(const struct lit_scene *lit, int s, int index, struct triple eye,
                       struct slow_vertex *out)
{
    const struct plan *plan = lit->plan;
    const struct surface *surface = &lit->surfaces[s];
    const struct vertex *vertex = &surface->instance->vertices[index];
    const struct shaded_material *shaded = lit->bounds[s].shaded;
    struct triple front = slow_normal(&surface->instance->model_view, vertex->normal),
                  none = {0, 0, 0};
    for (int side = 0; side < surface->n_sides; side++) {
        size_t at = surface_attributes(surface, index, side);
        struct triple normal = triple_sum(none, front, side ? -1 : 1);
        for (int t = 0; t < shaded->n_terms; t++) {
            const struct term *term = &shaded->terms[t];
            long double sum = term->reflection == CONSTANT, doubts = 0;
            for (int i = 0; i < plan->n_lights; i++) {
                long double doubt = 0;
                if (plan->lights[i].first == term->light)
                    sum += slow_weight(plan, i, term->reflection, shaded->material->gloss, normal,
                                       eye, &doubt);
                doubts += doubt;
            }
            out->value[side][t] = sum;
            out->doubt[side][t] = doubts;
            out->error[side][t] = (long double)lit->bounds[s].errors[at + (size_t)t] * 0x1p-29L +
                                  2 * u * plan->n_lights * sum + doubts + SLOW_LEAST;
        }
        out->value[side][shaded->n_terms] = (long double)vertex->s;
        out->value[side][shaded->n_terms + 1] = (long double)vertex->t;
    }
}

/* Returns all vertices of a surface; NULL: no memory. */
static struct slow_vertex *slow_vertices(const struct lit_scene *lit, int s)
{
    const struct instance *instance = lit->surfaces[s].instance;
    struct slow_vertex *out = calloc((size_t)instance->n_vertices, sizeof *out);
    for (int v = 0; out && v < instance->n_vertices; v++) {
        struct vector p = instance->vertices[v].position;
        long double object[4] = {(long double)p.x, (long double)p.y, (long double)p.z, 1};
        long double reach[4] = {fabsl(object[0]), fabsl(object[1]), fabsl(object[2]), 1};
        long double eye[4], e_eye[4];
        slow_transform(&instance->model_view, object, reach, eye, e_eye);
        slow_transform(&lit->plan->view.projection, eye, e_eye, out[v].clip, out[v].e_clip);
        for (int i = 0; i < 4; i++)
            out[v].e_clip[i] *= 9 * u;
        slow_light(lit, s, v, (struct triple){eye[0], eye[1], eye[2]}, &out[v]);
    }
    return out;
}

/* ---- triangles as raster/ may compute them; only the bounds need them ---- */

/* A corner of the triangle clipped by the near and far plane. */
struct slow_corner {
    long double clip[4], e_clip[4], share[3];
    long double x, y, z, inverse_w, e_px, e_z, e_w; /* in the window; e_w is relative */
};

struct slow_triangle {
    int surface;
    bool mirrored; /* outsides are clockwise */
    const struct slow_vertex *vertex[3];
    struct slow_corner corner[SLOW_CORNERS];
    int n_corners;
    long double left, right, top, bottom; /* range of all pixel centres that it may touch */
};

static struct slow_corner slow_cut(const struct slow_corner *a, const struct slow_corner *b,
                                   long double t)
{
    struct slow_corner out = *a;
    for (int i = 0; i < 4; i++) {
        out.clip[i] += t * (b->clip[i] - a->clip[i]);
        out.e_clip[i] =
            fmaxl(a->e_clip[i], b->e_clip[i]) + 3 * u * (fabsl(a->clip[i]) + fabsl(b->clip[i]));
    }
    for (int i = 0; i < 3; i++)
        out.share[i] += t * (b->share[i] - a->share[i]);
    return out;
}

/* Keeps the part on the inner side of the near (sign 1) or far (sign -1) plane. */
static void slow_clip(struct slow_triangle *triangle, int sign)
{
    struct slow_corner in[SLOW_CORNERS];
    int n = triangle->n_corners, n_out = 0;
    memcpy(in, triangle->corner, sizeof in);
    for (int i = 0; i < n; i++) {
        const struct slow_corner *a = &in[i], *b = &in[(i + 1) % n];
        long double d_a = a->clip[3] + sign * a->clip[2], d_b = b->clip[3] + sign * b->clip[2];
        if (d_a >= 0)
            triangle->corner[n_out++] = *a;
        if ((d_a >= 0) != (d_b >= 0))
            triangle->corner[n_out++] = slow_cut(a, b, d_a / (d_a - d_b));
    }
    triangle->n_corners = n_out;
}

static void slow_place(const struct scene *scene, struct slow_corner *c)
{
    long double w = c->clip[3], half_width = 0.5L * scene->width,
                half_height = 0.5L * scene->height;
    long double nx = c->clip[0] / w, ny = c->clip[1] / w, nz = c->clip[2] / w;
    c->x = (nx + 1) * half_width;
    c->y = (1 - ny) * half_height;
    c->z = (nz + 1) / 2;
    c->inverse_w = 1 / w;
    c->e_w = c->e_clip[3] / w + u;
    c->e_px =
        fmaxl(half_width * (c->e_clip[0] / w + fabsl(nx) * c->e_w + 3 * u * (1 + fabsl(nx))),
              half_height * (c->e_clip[1] / w + fabsl(ny) * c->e_w + 3 * u * (1 + fabsl(ny))));
    c->e_z = (c->e_clip[2] / w + fabsl(nz) * c->e_w) / 2 + 3 * u;
}

/* In an exact scene every homogeneous and window coordinate is a short binary fraction. */
static struct slow_triangle slow_triangle(const struct scene *scene, const struct surface *surfaces,
                                          struct slow_vertex *const *vertices, int surface,
                                          int index, bool exact)
{
    struct slow_triangle out = {.surface = surface,
                                .mirrored = slow_mirrored(&surfaces[surface].instance->model_view),
                                .n_corners = 3,
                                .left = HUGE_VALL,
                                .right = -HUGE_VALL,
                                .top = HUGE_VALL,
                                .bottom = -HUGE_VALL};
    for (int i = 0; i < 3; i++) {
        struct slow_corner *corner = &out.corner[i];
        out.vertex[i] = &vertices[surface][surfaces[surface].instance->triangles[index][i]];
        memcpy(corner->clip, out.vertex[i]->clip, sizeof corner->clip);
        memcpy(corner->e_clip, out.vertex[i]->e_clip, sizeof corner->e_clip);
        corner->share[i] = 1;
    }
    slow_clip(&out, 1);
    slow_clip(&out, -1);
    for (int i = 0; i < out.n_corners; i++) {
        struct slow_corner *corner = &out.corner[i];
        slow_place(scene, corner);
        if (exact)
            corner->e_px = corner->e_z = corner->e_w = 0;
        out.left = fminl(out.left, corner->x - corner->e_px);
        out.right = fmaxl(out.right, corner->x + corner->e_px);
        out.top = fminl(out.top, corner->y - corner->e_px);
        out.bottom = fmaxl(out.bottom, corner->y + corner->e_px);
    }
    return out;
}

/* Computes the edge function in the window from a to b, and the bound on its error. */
struct slow_edge {
    long double value, error;
};

static struct slow_edge slow_edge(const struct slow_corner *a, const struct slow_corner *b,
                                  long double px, long double py)
{
    long double ax = a->x - px, ay = a->y - py, bx = b->x - px, by = b->y - py;
    long double e = fmaxl(a->e_px, b->e_px);
    struct slow_edge out = {ax * by - bx * ay, 0};
    if (e > 0)
        out.error = e * (fabsl(ax) + fabsl(ay) + fabsl(bx) + fabsl(by)) + 2 * e * e +
                    4 * u * (fabsl(ax * by) + fabsl(bx * ay));
    return out;
}

/* A triangle at a pixel, from the fan that raster/ makes of the corners. The factors multiply the
 * differences between the corners and a value there, and give its error. */
struct slow_fan_triangle {
    const struct slow_corner *corner[3];
    long double factor[3], linear_factor[3]; /* with perspective, and without */
    bool bounded;
};

/* Returns false if the pixel is surely outside this triangle of the fan. */
static bool slow_fan_triangle(const struct slow_triangle *triangle, int index, long double px,
                              long double py, struct slow_fan_triangle *out)
{
    struct slow_edge edge[3];
    long double sum = 0, linear_sum = 0, error = 0, linear_error = 0, sign = 0;
    out->corner[0] = &triangle->corner[0];
    out->corner[1] = &triangle->corner[index + 1];
    out->corner[2] = &triangle->corner[index + 2];
    for (int i = 0; i < 3; i++) {
        edge[i] = slow_edge(out->corner[(i + 1) % 3], out->corner[(i + 2) % 3], px, py);
        linear_sum += edge[i].value;
    }
    sign = linear_sum < 0 ? -1 : 1;
    for (int i = 0; i < 3; i++) {
        const struct slow_corner *corner = out->corner[i];
        if (sign * edge[i].value < -edge[i].error)
            return false;
        out->linear_factor[i] = edge[i].error;
        out->factor[i] =
            corner->inverse_w * (edge[i].error + fabsl(edge[i].value) * (corner->e_w + u));
        sum += edge[i].value * corner->inverse_w;
        error += out->factor[i];
        linear_error += edge[i].error;
    }
    out->bounded = 4 * error < fabsl(sum) && 4 * linear_error < fabsl(linear_sum);
    for (int i = 0; i < 3; i++) {
        out->factor[i] /= fabsl(sum) - error;
        out->linear_factor[i] /= fabsl(linear_sum) - linear_error;
    }
    return true;
}

/* ---- pixels ---- */

/* A triangle's fragment at a pixel centre. */
struct slow_fragment {
    const struct slow_triangle *triangle;
    long double share[3]; /* barycentric coordinates, correct in perspective */
    long double px, py, depth, e_depth;
    bool definite; /* drawn however double precision rounds */
    int side;      /* 1: seen from behind; -1: rounding may choose */
};

/* Compares the pixel with the edges that the planes have left, in double precision: -1 if surely
 * outside one, 1 if surely inside all, otherwise 0. */
static int slow_clearance(const struct slow_triangle *triangle, long double turn, long double px,
                          long double py)
{
    int clearance = 1;
    for (int i = 0; i < triangle->n_corners; i++) {
        const struct slow_corner *a = &triangle->corner[i],
                                 *b = &triangle->corner[(i + 1) % triangle->n_corners];
        bool own = false;
        for (int k = 0; k < 3; k++)
            own = own || (a->share[k] <= 0 && b->share[k] <= 0);
        struct slow_edge edge = slow_edge(a, b, px, py);
        if (own && turn * edge.value < -edge.error)
            return -1;
        if (own && turn * edge.value <= edge.error)
            clearance = 0;
    }
    return clearance;
}

/* Returns the largest error of depth in the fan's triangles at the pixel. */
static long double slow_depth_error(const struct slow_triangle *triangle, long double px,
                                    long double py, long double depth)
{
    long double worst = 0;
    for (int p = 0; p + 2 < triangle->n_corners; p++) {
        struct slow_fan_triangle fan;
        if (!slow_fan_triangle(triangle, p, px, py, &fan))
            continue;
        if (!fan.bounded)
            return HUGE_VALL;
        long double error = 8 * u * fabsl(depth);
        for (int i = 0; i < 3; i++)
            error += fan.linear_factor[i] * fabsl(fan.corner[i]->z - depth) + fan.corner[i]->e_z;
        worst = fmaxl(worst, error);
    }
    return worst;
}

/* Returns the side that is seen. y points downwards, so a triangle that is counter-clockwise in
 * OpenGL's window is clockwise here. -1 if double precision may find no area, or the other side. */
static int slow_side(const struct slow_triangle *triangle, bool clockwise, long double px,
                     long double py)
{
    long double area = 0, error = 0;
    for (int i = 0; i < triangle->n_corners; i++) {
        struct slow_edge edge = slow_edge(&triangle->corner[i],
                                          &triangle->corner[(i + 1) % triangle->n_corners], px, py);
        area += edge.value;
        error += edge.error;
    }
    return fabsl(area) <= error ? -1 : clockwise == triangle->mirrored;
}

/* Computes the edge functions of the corners (X, Y, w), moved so that the pixel centre is the
 * origin; returns their determinant. */
static long double slow_edges(const struct scene *scene, const struct slow_triangle *triangle,
                              long double px, long double py, long double out[3])
{
    long double x[3], y[3], determinant = 0;
    for (int i = 0; i < 3; i++) {
        const long double *c = triangle->vertex[i]->clip;
        x[i] = (c[0] + c[3]) * 0.5L * scene->width - px * c[3];
        y[i] = (c[3] - c[1]) * 0.5L * scene->height - py * c[3];
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = x[j] * y[k] - x[k] * y[j];
        determinant += out[i] * triangle->vertex[i]->clip[3];
    }
    return determinant;
}

/* The shares b of the corners solve sum b_i (X_i, Y_i, w_i) = (0, 0, 1): they are the edge
 * functions over the determinant, their sum is 1 / w at the pixel, and depth is linear in them.
 * Returns false if no fragment can be drawn. */
static bool slow_fragment(const struct scene *scene, const struct slow_triangle *triangle, int x,
                          int y, struct slow_fragment *out)
{
    long double px = x + 0.5L, py = y + 0.5L, e[3], one_over_w = 0;
    if (triangle->n_corners < 3 || px < triangle->left || px > triangle->right ||
        py < triangle->top || py > triangle->bottom)
        return false;
    long double determinant = slow_edges(scene, triangle, px, py, e);
    long double turn = determinant < 0 ? -1 : 1;
    int clearance = slow_clearance(triangle, turn, px, py);
    if (clearance < 0)
        return false;
    *out = (struct slow_fragment){.triangle = triangle, .px = px, .py = py};
    for (int i = 0; i < 3; i++) {
        const long double *c = triangle->vertex[i]->clip;
        one_over_w += e[i] / determinant;
        out->depth += e[i] / determinant * (c[2] + c[3]) / 2;
        clearance = turn * e[i] > 0 ? clearance : 0;
    }
    for (int i = 0; i < 3; i++)
        out->share[i] = e[i] / determinant / one_over_w;
    out->e_depth = slow_depth_error(triangle, px, py, out->depth);
    out->side = slow_side(triangle, turn < 0, px, py);
    out->definite = clearance > 0 && out->depth > out->e_depth && out->depth < 1 - out->e_depth;
    return out->e_depth >= HUGE_VALL ||
           (out->depth >= -out->e_depth && out->depth <= 1 + out->e_depth);
}

/* Returns the error of interpolation in a triangle of the fan at the pixel. */
static long double slow_off(const struct slow_triangle *triangle,
                            const struct slow_fan_triangle *fan, int side, int attribute,
                            long double value)
{
    long double off = 0;
    for (int i = 0; i < 3; i++) {
        long double at_corner = 0;
        for (int j = 0; j < 3; j++)
            at_corner += fan->corner[i]->share[j] * triangle->vertex[j]->value[side][attribute];
        off += fan->factor[i] * fabsl(at_corner - value);
    }
    return off;
}

/* Returns the bound on an attribute of one side; HUGE_VALL: no bound. */
static long double slow_bound(const struct slow_fragment *fragment, int side, int attribute,
                              long double value)
{
    const struct slow_triangle *triangle = fragment->triangle;
    long double worst = 0, error = 0, largest = 0;
    for (int j = 0; j < 3; j++) {
        const struct slow_vertex *vertex = triangle->vertex[j];
        error += fabsl(fragment->share[j]) * vertex->error[side][attribute];
        largest = fmaxl(largest, fabsl(vertex->value[side][attribute]));
    }
    for (int p = 0; p + 2 < triangle->n_corners; p++) {
        struct slow_fan_triangle fan;
        if (!slow_fan_triangle(triangle, p, fragment->px, fragment->py, &fan))
            continue;
        if (!fan.bounded)
            return HUGE_VALL;
        worst = fmaxl(worst, slow_off(triangle, &fan, side, attribute, value));
    }
    return worst + error + 16 * u * largest;
}

#endif
