/* SPDX-License-Identifier: MIT */
/* The reference's vertices: where they stand, how much of each term they reflect, and how far
 * OpenGL's single precision may be off from both.
 *
 * Weights follow the OpenGL 2.1 specification, section 2.14.1, in double. Bounds count the
 * roundings of a single-precision pipeline in any order of operations, with or without fused
 * multiply-add; u = 2^-24 is the unit roundoff of single precision. "e_" is a bound on an absolute
 * error. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "spectral.h"

static const double u = 1.0 / 16777216;

/* A homogeneous coordinate goes through: one rounding of the vertex, of the modelview and of the
 * projection entry (3), the product of the two matrices and the product with the vertex, each four
 * multiplications and three additions (4 + 4); one more for second-order terms. */
enum { TRANSFORM_ROUNDINGS = 12 };
/* Eye space: vertex, modelview, product (1 + 1 + 4), one for second-order terms. */
enum { EYE_ROUNDINGS = 7 };

/* ---- position ---- */

/* sum_j |m_ij| |v_j|, what the rounding errors of row i are relative to. */
static void magnitudes(const struct matrix *m, const double v[4], double out[4])
{
    for (int i = 0; i < 4; i++) {
        out[i] = 0;
        for (int j = 0; j < 4; j++)
            out[i] += fabs(m->row[i][j]) * fabs(v[j]);
    }
}

static void transform(const struct matrix *m, const double v[4], double out[4])
{
    for (int i = 0; i < 4; i++)
        out[i] =
            m->row[i][0] * v[0] + m->row[i][1] * v[1] + m->row[i][2] * v[2] + m->row[i][3] * v[3];
}

/* Window coordinates and their bounds. OpenGL draws a picture in tiles, each with a projection that
 * scales and shifts clip space; in pixels of the picture the shift adds at most half the picture
 * times the error of w, whichever the tile. Division, scale and offset of the viewport: 4 roundings
 * of a coordinate as large as the picture. */
static void place_vertex(const struct plan *plan, const double magnitude[4], struct lit_vertex *out)
{
    double w = out->clip[3], half_width = 0.5 * plan->scene->width,
           half_height = 0.5 * plan->scene->height;
    double largest = fmax(fmax(magnitude[0], magnitude[1]), fmax(magnitude[2], magnitude[3]));
    out->clip_error = (float)(TRANSFORM_ROUNDINGS * u * largest);
    if (!(w > 0))
        return;
    double nx = out->clip[0] / w, ny = out->clip[1] / w, nz = out->clip[2] / w;
    out->x = (nx + 1) * half_width;
    out->y = (1 - ny) * half_height;
    out->z = (nz + 1) * 0.5;
    out->inverse_w = 1 / w;
    double unit = TRANSFORM_ROUNDINGS * u / w;
    double e_w = unit * magnitude[3];
    double e_x = half_width * (unit * magnitude[0] + (fabs(nx) + 1) * e_w + 8 * u);
    double e_y = half_height * (unit * magnitude[1] + (fabs(ny) + 1) * e_w + 8 * u);
    out->slack_px = (float)fmax(e_x, e_y);
    out->slack_depth = (float)(0.5 * (unit * magnitude[2] + fabs(nz) * e_w) + 4 * u);
    out->slack_w = plan->scene->camera.perspective ? (float)(e_w + 2 * u) : 0;
}

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

/* How far the upper 3x3 is from a rotation. Mesa takes a modelview within 1e-6 of rigid for rigid
 * (m_matrix.c) and then uses its transpose as its inverse, so such a distance is an error. */
static double distance_from_rigid(const struct matrix *m)
{
    double distance = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double dot = 0;
            for (int k = 0; k < 3; k++)
                dot += m->row[k][i] * m->row[k][j];
            distance = fmax(distance, fabs(dot - (i == j)));
        }
    return distance < 4e-6 ? distance : 0;
}

/* What the vertices of one body have in common. */
struct body_bounds {
    double cofactor[3][3]; /* of cofactor_magnitudes */
    double e_rigid;
};

static struct body_bounds body_bounds(const struct body *body)
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

/* A vertex about to be lit. */
struct vertex_view {
    struct direction normal;
    struct vector eye;
    double e_eye, e_rigid;
    bool bounded; /* whether bounds are wanted */
    struct light_work *work;
};

static struct weight product(struct weight a, struct weight b)
{
    return (struct weight){a.value * b.value, a.value * b.error + a.error * (b.value + b.error)};
}

/* Counts the power functions that are computed. */
static double power(double base, double exponent, const struct vertex_view *view)
{
    view->work->power_functions++;
    return pow(base, exponent);
}

/* Relative error of Mesa's pow: exp2(g log2 x), log2 to 2.2e-7 plus a rounding of its value, the
 * product rounded, exp2 to 2.7e-7 (polynomials of lp_bld_arit.c, measured over their range). */
static double pow_error(double base, double exponent)
{
    double octaves = base > 0 ? fabs(log2(base)) : 0;
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
        return (struct weight){gate.value > 0 ? power(base, exponent, view) : 0, 0};
    double high = fmin(fmax(0, c.value + c.error), LARGEST_COSINE),
           low = fmax(0, c.value - c.error);
    double at_high = power(high, exponent, view) * (1 + pow_error(high, exponent));
    double at_low =
        gate.value > gate.error ? power(low, exponent, view) * (1 - pow_error(low, exponent)) : 0;
    double value = gate.value > 0 ? power(base, exponent, view) : 0;
    return (struct weight){value, fmax(at_high - value, value - at_low) + least};
}

static struct weight diffuse_weight(struct cosine n_l)
{
    double value = fmax(0, n_l.value), high = fmin(n_l.value + n_l.error, LARGEST_COSINE);
    return (struct weight){value, high > 0 ? fmin(n_l.error, fmax(value, high - value)) : 0};
}

/* 1 / (k0 + k1 d + k2 d^2). NaN where OpenGL's divisor may be anything: a light at the vertex. */
static struct weight attenuation(const struct plan_light *light, const struct path *path)
{
    const double *k = light->light->attenuation, d = path->length, e_d = path->e_length;
    double divisor = k[0] + k[1] * d + k[2] * d * d;
    /* OpenGL may flush factors below the least normal number to 0 */
    double flushed = (double)FLT_MIN * (1 + d + d * d);
    double error = k[1] * e_d + k[2] * (2 * d + e_d) * e_d + 8 * u * divisor + flushed;
    if (!(error < 0.25 * divisor))
        return (struct weight){(double)NAN, 0};
    return (struct weight){1 / divisor, error / (divisor * (divisor - error)) + 2 * u / divisor};
}

/* What distance and spot leave of a light. */
static struct weight falloff(const struct plan_light *light, const struct path *path,
                             const struct vertex_view *view)
{
    struct weight out = {1, 0};
    if (light->attenuated)
        out = attenuation(light, path);
    if (light->spot) {
        struct direction axis = {vector_scale(light->eye_spot, -1), 6 * u};
        struct cosine c = cosine_between(path->towards, axis), gate = c;
        gate.value -= light->spot_cosine;
        gate.error += 3 * u; /* the cutoff in degrees, in radians, its cosine */
        out = product(out, gated_power(gate, c, light->light->spot_exponent, view));
    }
    return out;
}

static struct weight term_weight(const struct plan *plan, const struct finish *finish,
                                 const struct term *term, const struct vertex_view *view)
{
    if (term->kind == TERM_CONSTANT)
        return (struct weight){1, 0};
    const struct plan_light *light = &plan->lights[term->light];
    struct path path = path_to_light(light, view->eye, view->e_eye, view->e_rigid);
    struct cosine n_l = cosine_between(view->normal, path.towards);
    struct weight weight;
    if (term->kind == TERM_SPECULAR) {
        struct direction half =
            half_way(path.towards, towards_viewer(plan, view->eye, view->e_eye));
        weight =
            gated_power(n_l, cosine_between(view->normal, half), finish->material->gloss, view);
        view->work->specular_vertices++;
    } else {
        weight = diffuse_weight(n_l);
    }
    return light->attenuated || light->spot ? product(weight, falloff(light, &path, view)) : weight;
}

/* Attributes of one side of a vertex: weights of all terms, then texture coordinates, which OpenGL
 * rounds once. */
static void light_side(const struct plan *plan, const struct surface *surface,
                       const struct vertex *vertex, const struct vertex_view *view, double *weights,
                       float *errors)
{
    const struct finish *finish = surface->finish;
    for (int i = 0; i < finish->n_terms; i++) {
        struct weight weight = term_weight(plan, finish, &finish->terms[i], view);
        weights[i] = weight.value;
        errors[i] = weight.error <= (double)FLT_MAX ? (float)weight.error : HUGE_VALF;
    }
    if (!finish->texture)
        return;
    double *place = weights + finish->n_terms;
    place[0] = vertex->s;
    place[1] = vertex->t;
    for (int i = 0; i < 2; i++)
        errors[finish->n_terms + i] = (float)(u * fabs(place[i]));
}

/* ---- surfaces ---- */

size_t surface_attributes(const struct surface *surface, int vertex, int side)
{
    return ((size_t)vertex * (size_t)surface->n_sides + (size_t)side) *
           (size_t)surface->n_attributes;
}

static void process_vertex(const struct plan *plan, struct surface *surface,
                           const struct body_bounds *bounds, int index, struct light_work *work)
{
    const struct body *body = surface->body;
    const struct vertex *vertex = &surface->mesh->vertices[index];
    struct lit_vertex *out = &surface->vertices[index];
    double object[4] = {vertex->position.x, vertex->position.y, vertex->position.z, 1};
    double eye[4], eye_magnitude[4], clip_magnitude[4];
    transform(&body->model_view, object, eye);
    magnitudes(&body->model_view, object, eye_magnitude);
    transform(&plan->projection, eye, out->clip);
    magnitudes(&plan->projection, eye_magnitude, clip_magnitude);
    place_vertex(plan, clip_magnitude, out);

    struct vertex_view view = {.normal = eye_normal(body, bounds, vertex->normal),
                               .eye = {eye[0], eye[1], eye[2]},
                               .e_eye = EYE_ROUNDINGS * u *
                                        (eye_magnitude[0] + eye_magnitude[1] + eye_magnitude[2]),
                               .e_rigid = bounds->e_rigid,
                               .bounded = plan->options.check,
                               .work = work};
    for (int side = 0; side < surface->n_sides; side++) {
        size_t first = surface_attributes(surface, index, side);
        light_side(plan, surface, vertex, &view, surface->weights + first, surface->errors + first);
        view.normal.unit = vector_scale(view.normal.unit, -1);
    }
    work->vertices_lit++;
}

static bool surface_alloc(const struct plan *plan, const struct body *body, struct surface *out)
{
    out->body = body;
    out->mesh = &plan->meshes[body->mesh].mesh;
    out->finish = &plan->finishes[body->finish];
    out->n_sides = body->object->two_sided ? 2 : 1;
    out->n_attributes = out->finish->n_terms + (out->finish->texture ? 2 : 0);
    size_t n_vertices = (size_t)out->mesh->n_vertices;
    size_t n_weights = surface_attributes(out, out->mesh->n_vertices, 0) + 1;
    out->vertices = calloc(n_vertices, sizeof *out->vertices);
    out->weights = calloc(n_weights, sizeof *out->weights);
    out->errors = calloc(n_weights, sizeof *out->errors);
    return out->vertices && out->weights && out->errors;
}

/* Half a texel off, OpenGL may show any of the texture's values. */
static bool check_texture(const struct surface *surface, size_t first, int index, struct error *err)
{
    const double *s_t = surface->weights + first + surface->finish->n_terms;
    const float *e_s_t = surface->errors + first + surface->finish->n_terms;
    struct texel_point at =
        texel_point(surface->finish->texture, s_t[0], s_t[1], e_s_t[0], e_s_t[1]);
    return ((double)at.e_u < 0.5 && (double)at.e_v < 0.5) ||
           error_at(err, surface->body->object->place,
                    "the texture coordinates %.6g %.6g of vertex %d are too large for single "
                    "precision; the texture must repeat less often",
                    s_t[0], s_t[1], index + 1);
}

static bool check_vertex(const struct surface *surface, int index, struct error *err)
{
    const struct lit_vertex *vertex = &surface->vertices[index];
    size_t first = surface_attributes(surface, index, 0),
           last = surface_attributes(surface, index + 1, 0);
    double sum = vertex->x + vertex->y + vertex->z + (double)vertex->slack_px, weights = 0;
    for (int i = 0; i < 4; i++)
        sum += vertex->clip[i];
    for (size_t i = first; i < last; i++)
        weights += surface->weights[i] + (double)surface->errors[i];
    if (!isfinite(sum))
        return error_at(err, surface->body->object->place,
                        "vertex %d of this object is not finite in the window; "
                        "coordinates and scales are too large",
                        index + 1);
    if (surface->finish->texture && !check_texture(surface, first, index, err))
        return false;
    return isfinite(weights) || error_at(err, surface->body->object->place,
                                         "vertex %d of this object reflects no finite radiance; "
                                         "a light that weakens with distance may be too near",
                                         index + 1);
}

/* Window bounds of the whole surface, or everything where a vertex is beside or behind the eye. */
static void surface_bounds(struct surface *surface)
{
    surface->left = surface->top = HUGE_VAL;
    surface->right = surface->bottom = -HUGE_VAL;
    for (int i = 0; i < surface->mesh->n_vertices; i++) {
        const struct lit_vertex *vertex = &surface->vertices[i];
        bool in_front = vertex->clip[3] > 0;
        double slack = 1 + (double)vertex->slack_px; /* a pixel more costs nothing */
        surface->left = fmin(surface->left, in_front ? vertex->x - slack : -HUGE_VAL);
        surface->top = fmin(surface->top, in_front ? vertex->y - slack : -HUGE_VAL);
        surface->right = fmax(surface->right, in_front ? vertex->x + slack : HUGE_VAL);
        surface->bottom = fmax(surface->bottom, in_front ? vertex->y + slack : HUGE_VAL);
    }
}

bool surface_reaches(const struct surface *surface, const struct tile *tile)
{
    return surface->right >= tile->x && surface->left <= tile->x + tile->width &&
           surface->bottom >= tile->y && surface->top <= tile->y + tile->height;
}

static bool surface_light(const struct plan *plan, const struct body *body, struct surface *out,
                          struct light_work *work, struct error *err)
{
    if (!surface_alloc(plan, body, out))
        return error_memory(err);
    struct body_bounds bounds = body_bounds(body);
    long lit = 0, specular = 0, powers = 0;
    int n_vertices = out->mesh->n_vertices, n_threads = plan->options.threads;
#pragma omp parallel for reduction(+ : lit, specular, powers) num_threads(n_threads)
    for (int i = 0; i < n_vertices; i++) {
        struct light_work own = {0, 0, 0};
        process_vertex(plan, out, &bounds, i, &own);
        lit += own.vertices_lit;
        specular += own.specular_vertices;
        powers += own.power_functions;
    }
    work->vertices_lit += lit;
    work->specular_vertices += specular;
    work->power_functions += powers;
    for (int i = 0; i < n_vertices; i++)
        if (!check_vertex(out, i, err))
            return false;
    surface_bounds(out);
    return true;
}

bool surfaces_light(const struct plan *plan, struct surface **out, struct light_work *work,
                    struct error *err)
{
    *work = (struct light_work){0, 0, 0};
    *out = calloc((size_t)plan->n_bodies + 1, sizeof **out);
    if (!*out)
        return error_memory(err);
    for (int i = 0; i < plan->n_bodies; i++)
        if (!surface_light(plan, &plan->bodies[i], &(*out)[i], work, err))
            return false;
    return true;
}

/* The largest radiance of one surface's vertices in one band, and which vertex has it. */
static double largest_radiance(const struct plan *plan, const struct surface *surface, int band,
                               int *vertex)
{
    const struct finish *finish = surface->finish;
    size_t n_terms = (size_t)finish->n_terms, n_bands = (size_t)plan->n_bands;
    double largest = -1;
    for (size_t i = 0; i < (size_t)surface->mesh->n_vertices * (size_t)surface->n_sides; i++) {
        const double *weights = surface->weights + i * (size_t)surface->n_attributes;
        double radiance = 0;
        for (size_t t = 0; t < n_terms; t++)
            radiance += weights[t] * finish->spectra[t * n_bands + (size_t)band];
        if (!(radiance <= largest)) { /* NaN counts as larger, so that it is found */
            largest = radiance;
            *vertex = (int)(i / (size_t)surface->n_sides);
        }
        if (!isfinite(largest))
            break;
    }
    return finish->texture ? largest * finish->texture->largest : largest;
}

bool surfaces_full_scale(const struct plan *plan, const struct surface *surfaces, double *out,
                         struct error *err)
{
    double largest = 0;
    for (int s = 0; s < plan->n_bodies; s++)
        for (int band = 0; band < plan->n_bands; band++) {
            int vertex = 0;
            double radiance = largest_radiance(plan, &surfaces[s], band, &vertex);
            if (!isfinite(radiance))
                return error_at(err, surfaces[s].body->object->place,
                                "the radiance of vertex %d at %.10g nm is not finite; lights and "
                                "factors are too large",
                                vertex + 1, plan->scene->wavelengths_nm[band]);
            largest = fmax(largest, radiance);
        }
    *out = largest > 0 ? largest : 1;
    return true;
}

void surfaces_free(const struct plan *plan, struct surface *surfaces)
{
    if (!surfaces)
        return;
    for (int i = 0; i < plan->n_bodies; i++) {
        free(surfaces[i].vertices);
        free(surfaces[i].weights);
        free(surfaces[i].errors);
    }
    free(surfaces);
}
