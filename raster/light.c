/* SPDX-License-Identifier: MIT */
/* How a vertex, or in phong shading a point between vertices, is lit: how much of each term it
 * reflects, and how far OpenGL's single precision may be off from that.
 *
 * Weights follow the OpenGL 2.1 specification, section 2.14.1, in double. Bounds count the
 * roundings of a single-precision pipeline in any order of operations, with or without fused
 * multiply-add; u = 2^-24 is the unit roundoff of single precision. "e_" is a bound on an absolute
 * error. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "light.h"

static const double u = 1.0 / 16777216;

/* ---- directions ---- */

/* A unit vector, and a bound on how far OpenGL's is turned from it, in radians. */
struct direction {
    struct vector unit;
    double e_turn;
};

/* What the rounding errors of a transformed normal are relative to: each cofactor is a difference
 * of two products. Entries are scaled as matrix_normal scales them. */
static void cofactor_magnitudes(const struct matrix *m, double out[3][3])
{
    double a[3][3], largest = 0;
    int exponent;
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, fabs(m->row[i / 3][i % 3]));
    frexp(largest, &exponent);
    for (int i = 0; i < 9; i++)
        a[i / 3][i % 3] = fabs(ldexp(m->row[i / 3][i % 3], -exponent));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            out[i][j] = a[i1][j1] * a[i2][j2] + a[i1][j2] * a[i2][j1];
        }
}

/* How far the upper 3x3 is from a rotation, scaled by the same in all directions. Mesa takes it for
 * one where the squared lengths of its columns and their products are apart by less than 1e-6
 * (m_matrix.c), and then uses its transpose for its inverse, so that such a distance is an error.
 */
static double distance_from_rigid(const struct matrix *m)
{
    double dots[3][3], distance = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            dots[i][j] = 0;
            for (int k = 0; k < 3; k++)
                dots[i][j] += m->row[k][i] * m->row[k][j];
        }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            distance = fmax(distance, fabs(dots[i][j] - (i == j) * dots[0][0]));
    if (fabs(dots[0][0] - 1) < 4e-6) /* Mesa may leave a scale away that is so near 1 */
        distance = fmax(distance, fabs(dots[0][0] - 1));
    return distance < 4e-6 ? 3 * distance / dots[0][0] : 0;
}

struct body_bounds body_bounds(const struct body *body)
{
    struct body_bounds bounds;
    bounds.e_rigid = distance_from_rigid(&body->model_view);
    cofactor_magnitudes(&body->model_view, bounds.cofactor);
    return bounds;
}

/* A normal in eye space. Entries (2), product and difference make a cofactor (2), over the
 * determinant (1) it multiplies a rounded coordinate (2), of which three are added (2); the length
 * takes 3, second-order terms 2: 14 roundings. */
static struct direction eye_normal(const struct body *body, const struct body_bounds *bounds,
                                   struct vector normal)
{
    struct vector turned = matrix_direction(&body->normal_matrix, normal);
    double sum[3], length = vector_length(turned);
    for (int i = 0; i < 3; i++)
        sum[i] = bounds->cofactor[i][0] * fabs(normal.x) + bounds->cofactor[i][1] * fabs(normal.y) +
                 bounds->cofactor[i][2] * fabs(normal.z);
    double magnitude = vector_length((struct vector){sum[0], sum[1], sum[2]});
    double turn = length > 0 ? 14 * u * magnitude / length + bounds->e_rigid : 2;
    return (struct direction){vector_normalise(turned), fmin(turn, 2)};
}

/* From the vertex towards the light, and how far that is. */
struct path {
    struct direction towards;
    double length, e_length;
};

/* e_eye bounds the error of the vertex's eye coordinates. */
static struct path path_to_light(const struct plan_light *light, struct vector eye, double e_eye,
                                 double e_rigid)
{
    if (light->light->directional)
        return (struct path){{light->eye_position, 8 * u + e_rigid}, 0, 0};
    struct vector path = vector_subtract(light->eye_position, eye);
    double length = vector_length(path);
    double e_path = e_eye + 2 * u * vector_length(light->eye_position);
    /* where the light is at the vertex any direction may come out */
    double turn = length > e_path ? 6 * u + e_path / length : 2;
    return (struct path){{vector_normalise(path), turn}, length, e_path + 6 * u * length};
}

static struct direction towards_viewer(const struct plan *plan, struct vector eye, double e_eye)
{
    if (!plan->scene->local_viewer)
        return (struct direction){{0, 0, 1}, 0};
    double length = vector_length(eye);
    struct vector back = vector_normalise(vector_scale(eye, -1));
    return (struct direction){back, length > e_eye ? 6 * u + e_eye / length : 2};
}

static struct direction half_way(struct direction a, struct direction b)
{
    struct vector sum = vector_add(a.unit, b.unit);
    double length = vector_length(sum);
    double e_sum = a.e_turn + b.e_turn + 10 * u;
    return (struct direction){vector_normalise(sum), length > e_sum ? e_sum / length + 6 * u : 2};
}

/* The cosine between two directions and its bound: lengths are right to 4 roundings each, the dot
 * product adds 4, and a turn changes the cosine by the sine at most, to first order. */
struct cosine {
    double value, error;
};

static struct cosine cosine_between(struct direction a, struct direction b)
{
    double value = vector_dot(a.unit, b.unit);
    double sine = sqrt(fmax(0, 1 - value * value));
    double turn = fmin(a.e_turn + b.e_turn, 2);
    return (struct cosine){value, 12 * u + sine * turn + 0.5 * turn * turn};
}

/* ---- weights ---- */

/* Of two vectors whose lengths are right to 4 roundings each, and 4 of the product. */
#define LARGEST_COSINE (1 + 12 * u)

struct weight {
    double value, error;
};

/* A vertex about to be lit, or a point. */
struct vertex_view {
    struct direction normal;
    struct vector eye;
    double e_eye, e_rigid;
    bool bounded;   /* whether bounds are wanted */
    bool reference; /* no OpenGL lights it as well */
    struct light_work *work;
};

static struct weight product(struct weight a, struct weight b)
{
    return (struct weight){a.value * b.value, a.value * b.error + a.error * (b.value + b.error)};
}

/* Counts the power functions that are computed. */
static double counted_power(double base, double exponent, const struct vertex_view *view)
{
    view->work->power_functions++;
    return power(base, exponent);
}

/* Relative error of Mesa's pow: exp2(g log2 x), log2 to 2.2e-7 plus a rounding of its value, the
 * product rounded, exp2 to 2.7e-7 (polynomials of lp_bld_arit.c, measured over their range). */
static double pow_error(double base, double exponent)
{
    double octaves = base > 0 ? fabs(binary_logarithm(base)) : 0;
    return 0.6931471805599453 * exponent * (2.2e-7 + 2 * u * octaves) + 3e-7;
}

/* [on] max(0, c)^exponent, where the gate is on for a value above 0 and open within its error: both
 * outcomes may be OpenGL's then. */
static struct weight gated_power(struct cosine gate, struct cosine c, double exponent,
                                 const struct vertex_view *view)
{
    static const double least = 2e-38; /* results below are flushed to 0 by Mesa */
    if (gate.value + gate.error <= 0)
        return (struct weight){0, 0};
    if (exponent == 0)
        return (struct weight){gate.value > 0, fabs(gate.value) > gate.error ? 0 : 1};
    double base = fmax(0, c.value);
    if (!view->bounded)
        return (struct weight){gate.value > 0 ? counted_power(base, exponent, view) : 0, 0};
    double high = fmin(fmax(0, c.value + c.error), LARGEST_COSINE),
           low = fmax(0, c.value - c.error);
    double at_high = counted_power(high, exponent, view) * (1 + pow_error(high, exponent));
    double at_low = gate.value > gate.error
                        ? counted_power(low, exponent, view) * (1 - pow_error(low, exponent))
                        : 0;
    double value = gate.value > 0 ? counted_power(base, exponent, view) : 0;
    return (struct weight){value, fmax(at_high - value, value - at_low) + least};
}

static struct weight diffuse_weight(struct cosine n_l)
{
    double value = fmax(0, n_l.value), high = fmin(n_l.value + n_l.error, LARGEST_COSINE);
    return (struct weight){value, high > 0 ? fmin(n_l.error, fmax(value, high - value)) : 0};
}

/* 1 / (k0 + k1 d + k2 d^2). NaN where OpenGL's divisor may be anything: a light at the vertex. */
static struct weight attenuation(const struct plan_light *light, const struct path *path,
                                 const struct vertex_view *view)
{
    const double *k = light->attenuation, d = path->length, e_d = path->e_length;
    double divisor = k[0] + k[1] * d + k[2] * d * d;
    /* OpenGL may flush factors below the least normal number to 0 */
    double flushed = (double)FLT_MIN * (1 + d + d * d);
    double error = k[1] * e_d + k[2] * (2 * d + e_d) * e_d + 8 * u * divisor + flushed;
    if (!view->reference && !(error < 0.25 * divisor))
        return (struct weight){(double)NAN, 0};
    return (struct weight){1 / divisor, error / (divisor * (divisor - error)) + 2 * u / divisor};
}

/* What distance and spot leave of a light. */
static struct weight falloff(const struct plan_light *light, const struct path *path,
                             const struct vertex_view *view)
{
    struct weight out = {1, 0};
    /* Mesa multiplies by 0 / 0 where it takes light and vertex for one */
    if (!view->reference && path->length <= path->e_length)
        return (struct weight){(double)NAN, 0};
    if (light->attenuated)
        out = attenuation(light, path, view);
    if (light->spot) {
        struct direction axis = {vector_scale(light->eye_spot, -1), 6 * u};
        struct cosine c = cosine_between(path->towards, axis), gate = c;
        gate.value -= light->spot_cosine;
        gate.error += 3 * u; /* the cutoff in degrees, in radians, its cosine */
        out = product(out, gated_power(gate, c, light->light->spot_exponent, view));
    }
    return out;
}

static struct weight specular_weight(const struct plan *plan, double gloss, struct cosine n_l,
                                     struct direction towards, const struct vertex_view *view)
{
    struct direction half = half_way(towards, towards_viewer(plan, view->eye, view->e_eye));
    view->work->specular_vertices++;
    return gated_power(n_l, cosine_between(view->normal, half), gloss, view);
}

/* What is not finite in single precision is refused later. */
static void add_weight(struct weight weight, double share, double *sum, float *error)
{
    double e_sum = (double)*error + share * weight.error;
    *sum += share * weight.value;
    *error = e_sum <= (double)FLT_MAX ? (float)e_sum : HUGE_VALF;
}

/* Adds a light to the terms of its spectrum, of which there is one at least. */
static void add_light(const struct plan *plan, const struct finish *finish,
                      const struct plan_light *light, const struct vertex_view *view,
                      double *weights, float *errors)
{
    struct path path = path_to_light(light, view->eye, view->e_eye, view->e_rigid);
    struct cosine n_l = cosine_between(view->normal, path.towards);
    bool weakened = light->attenuated || light->spot;
    struct weight left = weakened ? falloff(light, &path, view) : (struct weight){1, 0};
    for (int t = 0; t < finish->n_terms; t++) {
        const struct term *term = &finish->terms[t];
        if (term->light != light->first)
            continue;
        struct weight weight =
            term->kind == TERM_DIFFUSE
                ? diffuse_weight(n_l)
                : specular_weight(plan, finish->material->gloss, n_l, path.towards, view);
        add_weight(weakened ? product(weight, left) : weight, light->share, &weights[t],
                   &errors[t]);
    }
}

static bool reflects(const struct finish *finish, const struct plan_light *light)
{
    for (int t = 0; t < finish->n_terms; t++)
        if (finish->terms[t].light == light->first)
            return true;
    return false;
}

/* Weights of all terms on one side of a vertex, whose errors are 0 before. */
static void light_side(const struct plan *plan, const struct finish *finish,
                       const struct vertex_view *view, double *weights, float *errors)
{
    for (int t = 0; t < finish->n_terms; t++)
        weights[t] = finish->terms[t].kind == TERM_CONSTANT;
    for (int i = 0; i < plan->n_lights; i++)
        if (reflects(finish, &plan->lights[i]))
            add_light(plan, finish, &plan->lights[i], view, weights, errors);
}

/* Texture coordinates, which OpenGL rounds once, follow the weights. */
static void put_place(const struct finish *finish, const struct vertex *vertex, double *weights,
                      float *errors)
{
    double *place = weights + finish->n_terms;
    if (!finish->texture)
        return;
    place[0] = vertex->s;
    place[1] = vertex->t;
    for (int i = 0; i < 2; i++)
        errors[finish->n_terms + i] = (float)(u * fabs(place[i]));
}

void light_vertex(const struct plan *plan, struct surface *surface,
                  const struct body_bounds *bounds, int index, struct vector eye, double e_eye,
                  struct light_work *work)
{
    const struct vertex *vertex = &surface->mesh->vertices[index];
    struct vertex_view view = {.normal = eye_normal(surface->body, bounds, vertex->normal),
                               .eye = eye,
                               .e_eye = e_eye,
                               .e_rigid = bounds->e_rigid,
                               .bounded = plan->options.check,
                               .work = work};
    bool lit = plan->scene->shading != SHADING_PHONG;
    for (int side = 0; side < surface->n_sides; side++) {
        size_t first = surface_attributes(surface, index, side);
        if (lit)
            light_side(plan, surface->finish, &view, surface->weights + first,
                       surface->errors + first);
        put_place(surface->finish, vertex, surface->weights + first, surface->errors + first);
        view.normal.unit = vector_scale(view.normal.unit, -1);
    }
    work->vertices_lit += lit;
}

/* ---- points of phong shading ---- */

void light_point(const struct plan *plan, const struct surface *surface, const struct vertex *point,
                 int side, double *weights, float *errors, struct light_work *work)
{
    static const struct body_bounds exact = {.e_rigid = 0};
    struct vertex_view view = {.normal = eye_normal(surface->body, &exact, point->normal),
                               .eye = matrix_point(&surface->body->model_view, point->position),
                               .reference = true,
                               .work = work};
    if (side == 1)
        view.normal.unit = vector_scale(view.normal.unit, -1);
    memset(errors, 0, (size_t)surface->n_attributes * sizeof *errors);
    light_side(plan, surface->finish, &view, weights, errors);
    put_place(surface->finish, point, weights, errors);
    work->points_lit++;
}

/* The point of a triangle that is nearest to p is that of its plane, or lies on an edge. */
static double distance_to_edge(struct vector p, struct vector a, struct vector b)
{
    struct vector edge = vector_subtract(b, a), to = vector_subtract(p, a);
    double squared = vector_dot(edge, edge);
    double part = squared > 0 ? fmin(fmax(vector_dot(to, edge) / squared, 0), 1) : 0;
    return vector_length(vector_subtract(to, vector_scale(edge, part)));
}

static double distance_to_triangle(struct vector p, const struct vector corner[3])
{
    struct vector normal = vector_normalise(
        vector_cross(vector_subtract(corner[1], corner[0]), vector_subtract(corner[2], corner[0])));
    double least = HUGE_VAL;
    bool above = vector_length(normal) > 0;
    for (int i = 0; i < 3; i++) {
        struct vector a = corner[i], b = corner[(i + 1) % 3];
        struct vector inwards = vector_cross(normal, vector_subtract(b, a));
        above = above && vector_dot(inwards, vector_subtract(p, a)) > 0;
        least = fmin(least, distance_to_edge(p, a, b));
    }
    return above ? fabs(vector_dot(normal, vector_subtract(p, corner[0]))) : least;
}

/* How near a light is to the surface, less the roundings of points on it. */
static double least_distance(const struct surface *surface, const struct plan_light *light)
{
    const struct mesh *mesh = surface->mesh;
    double least = HUGE_VAL, largest = vector_length(light->eye_position);
    for (int i = 0; i < mesh->n_triangles; i++) {
        struct vector corner[3];
        for (int j = 0; j < 3; j++) {
            corner[j] = matrix_point(&surface->body->model_view,
                                     mesh->vertices[mesh->triangles[i][j]].position);
            largest = fmax(largest, vector_length(corner[j]));
        }
        least = fmin(least, distance_to_triangle(light->eye_position, corner));
    }
    return fmax(0, least - 1e-12 * largest);
}

void light_limits(const struct plan *plan, const struct surface *surface, double *limits,
                  int *light)
{
    const struct finish *finish = surface->finish;
    for (int t = 0; t < finish->n_terms; t++)
        limits[t] = finish->terms[t].kind == TERM_CONSTANT;
    for (int i = 0; i < plan->n_lights; i++) {
        const struct plan_light *from = &plan->lights[i];
        const double *k = from->attenuation;
        double d, most = from->share;
        if (!reflects(finish, from))
            continue;
        if (from->attenuated) {
            d = least_distance(surface, from);
            most /= k[0] + k[1] * d + k[2] * d * d;
        }
        if (!isfinite(most))
            *light = i;
        for (int t = 0; t < finish->n_terms; t++)
            limits[t] += finish->terms[t].light == from->first ? most : 0;
    }
}
