/* SPDX-License-Identifier: MIT */
/* Bounds the errors of the weights with which OpenGL lights a vertex.
 *
 * Bounds count the roundings of a single-precision pipeline in any order of operations, with or
 * without fused multiply-add. "e_" is a bound on an absolute error. The values that errors are
 * relative to are the reference's. */
#include <float.h>
#include <math.h>

#include "raster/bounds/inside.h"

/* (a + e)(b + f) - ab = a f + e (b + f) */
static struct bounded bounded_product(struct bounded a, struct bounded b)
{
    return (struct bounded){a.value * b.value,
                            fabs(a.value) * b.error + a.error * (fabs(b.value) + b.error)};
}

/* ---- directions ---- */

/* A unit vector, and a bound on the angle between OpenGL's vector and it, in radians. */
struct direction {
    struct vector unit;
    double e_turn;
};

/* The distance of the upper 3x3 from a rotation that is scaled alike in all directions. Mesa takes
 * it for such a rotation if the squared lengths of its columns and their products differ by less
 * than 1e-6 (m_matrix.c). Mesa then uses the transpose for the inverse, so that the distance is an
 * error.
 */
double distance_from_rigid(const struct matrix *m)
{
    double dots[3][3], distance = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            dots[i][j] = 0;
            for (int k = 0; k < 3; k++)
                dots[i][j] += m->row[k][i] * m->row[k][j];
            distance = fmax(distance, fabs(dots[i][j] - (i == j) * dots[0][0]));
        }
    if (fabs(dots[0][0] - 1) < 4e-6) /* Mesa may leave out a scale that is so near 1 */
        distance = fmax(distance, fabs(dots[0][0] - 1));
    return distance < 4e-6 ? 3 * distance / dots[0][0] : 0;
}

/* Returns a normal in eye space as OpenGL may compute it, with 14 roundings: the entries of a
 * cofactor (2), its products and difference (2), the division by the determinant (1), the product
 * with a rounded coordinate (2), the sum of three (2), the length (3), second-order terms (2). */
static struct direction eye_normal(const struct instance *instance,
                                   const struct surface_bounds *bounds, struct vector normal)
{
    struct vector turned = matrix_direction(&instance->normal_matrix, normal);
    double sum[3], length = vector_length(turned);
    for (int i = 0; i < 3; i++) {
        const double *size = bounds->cofactors.magnitude[i];
        sum[i] = size[0] * fabs(normal.x) + size[1] * fabs(normal.y) + size[2] * fabs(normal.z);
    }
    double magnitude = vector_length((struct vector){sum[0], sum[1], sum[2]});
    double turn = length > 0 ? roundings(14) * magnitude / length + bounds->e_rigid : 2;
    return (struct direction){vector_normalise(turned), fmin(turn, 2)};
}

/* A vertex, while it is lit. */
struct vertex_view {
    const struct view *view;
    const struct instance *instance;
    const struct vertex *point;
    const struct surface_bounds *bounds;
    struct direction normal;
    struct vector eye;
    double e_eye;  /* of the vertex's eye coordinates */
    bool bounded;  /* whether bounds are wanted */
    double errors; /* struct driver: of lighting */
    struct light_work *work;
};

/* From the vertex towards a light, and how far that is. */
struct path {
    struct direction towards;
    struct bounded length;
    double divisor;
};

/* Bounds the angle by which OpenGL's direction of a vector is off, if the vector is off by the
 * error of its length. Normalising takes 6 roundings. A vector that may be 0 has any direction. */
static double turn_of(struct bounded length)
{
    return length.value > length.error ? length.error / length.value + roundings(6) : 2;
}

static struct path path_to_light(const struct vertex_view *vertex, const struct eye_light *light)
{
    struct incidence incidence = incidence_at(light, vertex->eye);
    struct path path = {.towards = {incidence.towards, roundings(8) + vertex->bounds->e_rigid},
                        .divisor = incidence.divisor};
    if (light->directional)
        return path;
    path.length.value = incidence.distance;
    path.length.error = vertex->e_eye + roundings(2) * vector_length(light->position);
    path.towards.e_turn = turn_of(path.length);
    path.length.error += roundings(6) * path.length.value;
    return path;
}

static struct direction half_way(const struct vertex_view *vertex, struct direction towards)
{
    struct vector sum = half_vector(vertex->view, towards.unit, vertex->eye);
    const struct bounded distance = {vector_length(vertex->eye), vertex->e_eye};
    const double viewer_turn = vertex->view->local_viewer ? turn_of(distance) : 0;
    struct bounded length = {vector_length(sum), towards.e_turn + viewer_turn + roundings(10)};
    return (struct direction){vector_normalise(sum), turn_of(length)};
}

/* The cosine between two directions: lengths are right to 4 roundings each, the dot product adds 4,
 * and a turn changes the cosine by the sine at most, to first order. */
static struct bounded cosine_between(struct direction a, struct direction b, double errors)
{
    double value = vector_dot(a.unit, b.unit);
    double sine = sqrt(fmax(0, 1 - value * value));
    double turn = fmin(a.e_turn + b.e_turn, 2);
    return (struct bounded){value, errors * (roundings(12) + sine * turn + 0.5 * turn * turn)};
}

/* Returns whether OpenGL has 0 for the cosine between a normal and a direction, however it rounds:
 * each product that the cosine is a sum of has a factor of 0. */
static bool is_square(const struct vertex_view *vertex, struct vector towards)
{
    const struct vector normal = vertex->point->normal;
    const double n[3] = {normal.x, normal.y, normal.z}, l[3] = {towards.x, towards.y, towards.z};
    bool square = true;
    for (int i = 0; i < 9; i++)
        square = square && (l[i / 3] == 0 || n[i % 3] == 0 ||
                            (vertex->instance->model_view.row[i / 3][i % 3] == 0 &&
                             vertex->bounds->cofactors.magnitude[i / 3][i % 3] == 0));
    return square;
}

/* ---- weights ---- */

/* Returns the largest computed cosine between two vectors: their lengths are right to 4 roundings
 * each, and the product takes 4. */
static double largest_cosine(double errors)
{
    return 1 + errors * roundings(12);
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
    return 0.6931471805599453 * exponent * (2.2e-7 + roundings(2) * octaves) + 3e-7;
}

/* A weight behind gates: it is there if all of them are open, and otherwise 0. */
struct gated {
    struct bounded open;      /* the weight with open gates */
    bool is_open, is_unclear; /* in the reference; OpenGL may decide otherwise */
};

static struct gated ungated(struct bounded weight)
{
    return (struct gated){weight, true, false};
}

static struct gated gated_product(struct gated a, struct gated b)
{
    return (struct gated){bounded_product(a.open, b.open), a.is_open && b.is_open,
                          a.is_unclear || b.is_unclear};
}

/* [gate > 0] max(0, c)^exponent. A gate within its error is unclear. */
static struct gated gated_power(struct bounded gate, struct bounded c, double exponent,
                                const struct vertex_view *vertex)
{
    static const double least = 2e-38; /* results below are flushed to 0 by Mesa */
    struct gated out = {{0, 0}, gate.value > 0, fabs(gate.value) <= gate.error};
    if (gate.value + gate.error <= 0 || !vertex->bounded) {
        out.is_unclear = false;
        return out;
    }
    out.open.value = 1;
    if (exponent == 0)
        return out;
    double base = fmax(0, c.value);
    double high = fmin(fmax(0, c.value + c.error), largest_cosine(vertex->errors)),
           low = fmax(0, c.value - c.error);
    double at_high =
        counted_power(high, exponent, vertex) * (1 + vertex->errors * pow_error(high, exponent));
    double at_low =
        counted_power(low, exponent, vertex) * (1 - vertex->errors * pow_error(low, exponent));
    double value = counted_power(base, exponent, vertex);
    out.open = (struct bounded){value, fmax(at_high - value, value - at_low) + least};
    return out;
}

static struct bounded diffuse_weight(struct bounded n_l, double errors)
{
    double value = fmax(0, n_l.value), high = fmin(n_l.value + n_l.error, largest_cosine(errors));
    return (struct bounded){value, high > 0 ? fmin(n_l.error, fmax(value, high - value)) : 0};
}

/* 1 / (k0 + k1 d + k2 d^2). NaN where OpenGL's divisor may be anything: a light at the vertex. */
static struct bounded attenuation(const struct eye_light *light, const struct path *path,
                                  double errors)
{
    const double *k = light->attenuation, divisor = path->divisor;
    const struct bounded d = path->length, square = bounded_product(d, d);
    /* OpenGL may flush factors below the least normal number to 0 */
    double flushed = (double)FLT_MIN * (1 + d.value + square.value);
    double error =
        errors * (k[1] * d.error + k[2] * square.error + roundings(8) * divisor) + flushed;
    if (!(error < 0.25 * divisor))
        return (struct bounded){(double)NAN, 0};
    return (struct bounded){1 / divisor,
                            error / (divisor * (divisor - error)) + roundings(2) / divisor};
}

/* The part of a light that distance and spot leave. */
static struct gated falloff(const struct eye_light *light, const struct path *path,
                            const struct vertex_view *vertex)
{
    struct gated out = ungated((struct bounded){1, 0});
    /* Mesa multiplies by 0 / 0 where it takes light and vertex for one */
    if (path->length.value <= path->length.error)
        return ungated((struct bounded){(double)NAN, 0});
    if (light->attenuated)
        out.open = attenuation(light, path, vertex->errors);
    if (light->spot) {
        struct direction axis = {vector_scale(light->axis, -1), roundings(6)};
        struct bounded c = cosine_between(path->towards, axis, vertex->errors), gate = c;
        gate.value -= light->cutoff_cosine;
        gate.error += roundings(3); /* the cutoff in degrees, in radians, its cosine */
        out = gated_product(out, gated_power(gate, c, light->spot_exponent, vertex));
    }
    return out;
}

/* Where the bounds of one side of a vertex are collected: see struct surface_bounds. */
struct side_bounds {
    float *errors, *jumps, *group; /* the last one may be NULL */
    int gated;                     /* the light whose gate is unclear there; -1: none */
};

/* Adds a weight. One unclear light at a vertex gets a jump to the other outcome. A second one gets
 * an error that takes in both. */
static void add_weight(struct gated weight, const struct eye_light *light, int index, int term,
                       struct side_bounds *out)
{
    struct bounded shown = {weight.is_open ? weight.open.value : 0, weight.open.error};
    if (!weight.is_open && !weight.is_unclear)
        shown.error = 0;
    if (weight.is_unclear && (out->gated < 0 || out->gated == index)) {
        const double jump = light->share * weight.open.value;
        out->jumps[term] += (float)(weight.is_open ? -jump : jump);
        out->gated = index;
    } else if (weight.is_unclear) {
        shown.error = weight.open.error + weight.open.value;
    }
    /* check_vertex refuses an error that is not finite in single precision */
    const double sum = (double)out->errors[term] + light->share * shown.error;
    out->errors[term] = sum <= (double)FLT_MAX ? (float)sum : HUGE_VALF;
    if (out->group)
        out->group[term] += (float)(light->share * shown.value);
}

/* Adds a light's weights to the terms of its spectrum. */
static void add_light(const struct eye_light *light, int index, const struct vertex_view *vertex,
                      struct side_bounds *out)
{
    const struct instance *instance = vertex->instance;
    struct path path = path_to_light(vertex, light);
    struct bounded n_l = cosine_between(vertex->normal, path.towards, vertex->errors);
    if (light->directional && is_square(vertex, light->position))
        n_l = (struct bounded){0, 0};
    bool weakened = light->attenuated || light->spot;
    struct gated left = weakened ? falloff(light, &path, vertex) : ungated((struct bounded){1, 0});
    for (int t = 0; t < instance->n_terms; t++) {
        if (instance->terms[t].light != light->first)
            continue;
        struct gated weight = ungated(diffuse_weight(n_l, vertex->errors));
        if (instance->terms[t].reflection == SPECULAR)
            weight = gated_power(
                n_l, cosine_between(vertex->normal, half_way(vertex, path.towards), vertex->errors),
                instance->gloss, vertex);
        add_weight(weakened ? gated_product(weight, left) : weight, light, index, t, out);
    }
}

float *group_weights(const struct surface *surface, const struct surface_bounds *bounds, int group)
{
    size_t n_weights = surface_attributes(surface, surface->instance->n_vertices, 0);
    return bounds->group_weights ? bounds->group_weights + (size_t)group * n_weights : NULL;
}

/* OpenGL rounds texture coordinates once. */
void light_bounds(const struct lit_scene *lit, const struct surface *of, int index, double e_eye,
                  struct light_work *work)
{
    const struct view *view = &lit->plan->view;
    const struct surface_bounds *bounds = &lit->bounds[of - lit->surfaces];
    const struct vertex *point = &of->instance->vertices[index];
    struct vertex_view vertex = {.view = view,
                                 .instance = of->instance,
                                 .point = point,
                                 .bounds = bounds,
                                 .normal = eye_normal(of->instance, bounds, point->normal),
                                 .eye = matrix_point(&of->instance->model_view, point->position),
                                 .e_eye = e_eye,
                                 .bounded = lit->plan->options.check,
                                 .errors = lit->driver->lighting,
                                 .work = work};
    for (int side = 0; side < of->n_sides; side++) {
        const size_t at = surface_attributes(of, index, side);
        float *errors = bounds->errors + at;
        struct side_bounds out = {.errors = errors, .jumps = bounds->jumps + at, .gated = -1};
        for (int i = 0; i < view->n_lights && view->shading != PHONG; i++) {
            float *group = group_weights(of, bounds, group_of(lit->plan, i));
            out.group = group ? group + at : NULL;
            if (!lit->plan->is_idle[i] && reflects(of->instance, &view->lights[i]))
                add_light(&view->lights[i], i, &vertex, &out);
        }
        bounds->vertices[index].gated[side] = out.gated >= 0;
        if (of->instance->textured) {
            errors[of->instance->n_terms] = (float)(roundings(1) * fabs(point->s));
            errors[of->instance->n_terms + 1] = (float)(roundings(1) * fabs(point->t));
        }
        vertex.normal.unit = vector_scale(vertex.normal.unit, -1);
    }
}
