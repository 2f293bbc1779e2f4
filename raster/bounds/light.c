/* SPDX-License-Identifier: MIT */
/* How far OpenGL's single precision may be off from the weights that the reference lights a vertex
 * with.
 *
 * Bounds count the roundings of a single-precision pipeline in any order of operations, with or
 * without fused multiply-add; u = 2^-24 is the unit roundoff of single precision. "e_" is a bound
 * on an absolute error. The values that errors are relative to are the reference's. */
#include <float.h>
#include <math.h>

#include "data/maths/maths.h"
#include "raster/bounds/bounds.h"
#include "raster/reference/reference.h"

static const double u = 1.0 / 16777216;

/* ---- directions ---- */

/* A unit vector, and a bound on the angle between OpenGL's vector and it, in radians. */
struct direction {
    struct vector unit;
    double e_turn;
};

/* Magnitudes that the errors of a transformed normal are relative to: a cofactor is a difference
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

/* How far the upper 3x3 is from a rotation, scaled alike in all directions. Mesa takes it for one
 * where the squared lengths of its columns and their products differ by less than 1e-6
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
    if (fabs(dots[0][0] - 1) < 4e-6) /* Mesa may leave out a scale that is so near 1 */
        distance = fmax(distance, fabs(dots[0][0] - 1));
    return distance < 4e-6 ? 3 * distance / dots[0][0] : 0;
}

struct normal_bounds normal_bounds(const struct instance *instance)
{
    struct normal_bounds bounds;
    bounds.e_rigid = distance_from_rigid(&instance->model_view);
    cofactor_magnitudes(&instance->model_view, bounds.cofactor);
    return bounds;
}

/* A normal in eye space. Entries (2), product and difference make a cofactor (2), over the
 * determinant (1) it multiplies a rounded coordinate (2), of which three are added (2); the length
 * takes 3, second-order terms 2: 14 roundings. */
static struct direction eye_normal(const struct instance *instance,
                                   const struct normal_bounds *bounds, struct vector normal)
{
    struct vector turned = matrix_direction(&instance->normal_matrix, normal);
    double sum[3], length = vector_length(turned);
    for (int i = 0; i < 3; i++)
        sum[i] = bounds->cofactor[i][0] * fabs(normal.x) + bounds->cofactor[i][1] * fabs(normal.y) +
                 bounds->cofactor[i][2] * fabs(normal.z);
    double magnitude = vector_length((struct vector){sum[0], sum[1], sum[2]});
    double turn = length > 0 ? 14 * u * magnitude / length + bounds->e_rigid : 2;
    return (struct direction){vector_normalise(turned), fmin(turn, 2)};
}

/* A vertex about to be lit. */
struct vertex_view {
    const struct view *view;
    const struct instance *instance;
    struct direction normal;
    struct vector eye;
    double e_eye, e_rigid; /* e_eye: of the vertex's eye coordinates */
    bool bounded;          /* whether bounds are wanted */
    struct light_work *work;
};

/* From the vertex towards a light, and how far that is. */
struct path {
    struct direction towards;
    double length, e_length, divisor;
};

static struct path path_to_light(const struct vertex_view *vertex, const struct eye_light *light)
{
    struct incidence incidence = incidence_at(light, vertex->eye);
    double length = incidence.distance;
    if (light->directional)
        return (struct path){{incidence.towards, 8 * u + vertex->e_rigid}, 0, 0, incidence.divisor};
    double e_path = vertex->e_eye + 2 * u * vector_length(light->position);
    /* where the light is at the vertex any direction may come out */
    double turn = length > e_path ? 6 * u + e_path / length : 2;
    return (struct path){
        {incidence.towards, turn}, length, e_path + 6 * u * length, incidence.divisor};
}

static double viewer_turn(const struct vertex_view *vertex)
{
    double length = vector_length(vertex->eye);
    if (!vertex->view->local_viewer)
        return 0;
    return length > vertex->e_eye ? 6 * u + vertex->e_eye / length : 2;
}

static struct direction half_way(const struct vertex_view *vertex, struct direction towards)
{
    struct vector sum = half_vector(vertex->view, towards.unit, vertex->eye);
    double length = vector_length(sum), e_sum = towards.e_turn + viewer_turn(vertex) + 10 * u;
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

/* For two vectors whose lengths are right to 4 roundings each, and 4 of the product. */
#define LARGEST_COSINE (1 + 12 * u)

struct weight {
    double value, error;
};

static struct weight product(struct weight a, struct weight b)
{
    return (struct weight){a.value * b.value, a.value * b.error + a.error * (b.value + b.error)};
}

/* Counts the power functions that are computed. */
static double counted_power(double base, double exponent, const struct vertex_view *vertex)
{
    vertex->work->power_functions++;
    return power(base, exponent);
}

/* Relative error of Mesa's pow: exp2(g log2 x), log2 to 2.2e-7 plus a rounding of its value, the
 * product rounded, exp2 to 2.7e-7 (polynomials of lp_bld_arit.c, measured over their range). */
static double pow_error(double base, double exponent)
{
    double octaves = base > 0 ? fabs(binary_logarithm(base)) : 0;
    return 0.6931471805599453 * exponent * (2.2e-7 + 2 * u * octaves) + 3e-7;
}

/* [gate > 0] max(0, c)^exponent. Where the gate is open within its error, both outcomes may be
 * OpenGL's. */
static struct weight gated_power(struct cosine gate, struct cosine c, double exponent,
                                 const struct vertex_view *vertex)
{
    static const double least = 2e-38; /* results below are flushed to 0 by Mesa */
    if (gate.value + gate.error <= 0 || !vertex->bounded)
        return (struct weight){0, 0};
    if (exponent == 0)
        return (struct weight){gate.value > 0, fabs(gate.value) > gate.error ? 0 : 1};
    double base = fmax(0, c.value);
    double high = fmin(fmax(0, c.value + c.error), LARGEST_COSINE),
           low = fmax(0, c.value - c.error);
    double at_high = counted_power(high, exponent, vertex) * (1 + pow_error(high, exponent));
    double at_low = gate.value > gate.error
                        ? counted_power(low, exponent, vertex) * (1 - pow_error(low, exponent))
                        : 0;
    double value = gate.value > 0 ? counted_power(base, exponent, vertex) : 0;
    return (struct weight){value, fmax(at_high - value, value - at_low) + least};
}

static struct weight diffuse_weight(struct cosine n_l)
{
    double value = fmax(0, n_l.value), high = fmin(n_l.value + n_l.error, LARGEST_COSINE);
    return (struct weight){value, high > 0 ? fmin(n_l.error, fmax(value, high - value)) : 0};
}

/* 1 / (k0 + k1 d + k2 d^2). NaN where OpenGL's divisor may be anything: a light at the vertex. */
static struct weight attenuation(const struct eye_light *light, const struct path *path)
{
    const double *k = light->attenuation, d = path->length, e_d = path->e_length,
                 divisor = path->divisor;
    /* OpenGL may flush factors below the least normal number to 0 */
    double flushed = (double)FLT_MIN * (1 + d + d * d);
    double error = k[1] * e_d + k[2] * (2 * d + e_d) * e_d + 8 * u * divisor + flushed;
    if (!(error < 0.25 * divisor))
        return (struct weight){(double)NAN, 0};
    return (struct weight){1 / divisor, error / (divisor * (divisor - error)) + 2 * u / divisor};
}

/* The part of a light that distance and spot leave. */
static struct weight falloff(const struct eye_light *light, const struct path *path,
                             const struct vertex_view *vertex)
{
    struct weight out = {1, 0};
    /* Mesa multiplies by 0 / 0 where it takes light and vertex for one */
    if (path->length <= path->e_length)
        return (struct weight){(double)NAN, 0};
    if (light->attenuated)
        out = attenuation(light, path);
    if (light->spot) {
        struct direction axis = {vector_scale(light->axis, -1), 6 * u};
        struct cosine c = cosine_between(path->towards, axis), gate = c;
        gate.value -= light->cutoff_cosine;
        gate.error += 3 * u; /* the cutoff in degrees, in radians, its cosine */
        out = product(out, gated_power(gate, c, light->spot_exponent, vertex));
    }
    return out;
}

/* Errors that are not finite in single precision are refused later. */
static void add_error(struct weight weight, double share, float *error)
{
    double sum = (double)*error + share * weight.error;
    *error = sum <= (double)FLT_MAX ? (float)sum : HUGE_VALF;
}

/* Adds a light's errors to those of the terms of its spectrum. */
static void add_light(const struct eye_light *light, const struct vertex_view *vertex,
                      float *errors)
{
    const struct instance *instance = vertex->instance;
    struct path path = path_to_light(vertex, light);
    struct cosine n_l = cosine_between(vertex->normal, path.towards);
    bool weakened = light->attenuated || light->spot;
    struct weight left = weakened ? falloff(light, &path, vertex) : (struct weight){1, 0};
    for (int t = 0; t < instance->n_terms; t++) {
        if (instance->terms[t].light != light->first)
            continue;
        struct weight weight = diffuse_weight(n_l);
        if (instance->terms[t].reflection == SPECULAR)
            weight =
                gated_power(n_l, cosine_between(vertex->normal, half_way(vertex, path.towards)),
                            instance->gloss, vertex);
        add_error(weakened ? product(weight, left) : weight, light->share, &errors[t]);
    }
}

/* True if any term belongs to this light's spectrum. */
bool reflects(const struct instance *instance, const struct eye_light *light)
{
    for (int t = 0; t < instance->n_terms; t++)
        if (instance->terms[t].light == light->first)
            return true;
    return false;
}

/* OpenGL rounds texture coordinates once. */
void light_bounds(const struct lit_scene *lit, int surface, int index,
                  const struct normal_bounds *normals, double e_eye, struct light_work *work)
{
    const struct view *view = &lit->plan->view;
    const struct surface *of = &lit->surfaces[surface];
    const struct vertex *point = &of->instance->vertices[index];
    struct vertex_view vertex = {.view = view,
                                 .instance = of->instance,
                                 .normal = eye_normal(of->instance, normals, point->normal),
                                 .eye = matrix_point(&of->instance->model_view, point->position),
                                 .e_eye = e_eye,
                                 .e_rigid = normals->e_rigid,
                                 .bounded = lit->plan->options.check,
                                 .work = work};
    for (int side = 0; side < of->n_sides; side++) {
        float *errors = lit->bounds[surface].errors + surface_attributes(of, index, side);
        for (int i = 0; i < view->n_lights && view->shading != PHONG; i++)
            if (reflects(of->instance, &view->lights[i]))
                add_light(&view->lights[i], &vertex, errors);
        if (of->instance->textured) {
            errors[of->instance->n_terms] = (float)(u * fabs(point->s));
            errors[of->instance->n_terms + 1] = (float)(u * fabs(point->t));
        }
        vertex.normal.unit = vector_scale(vertex.normal.unit, -1);
    }
}
