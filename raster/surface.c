/* SPDX-License-Identifier: MIT */
/* The reference's surfaces: where the vertices of each body stand in the window, how far OpenGL may
 * be off there, and what becomes of them together. u = 2^-24 is the unit roundoff of single
 * precision; "e_" is a bound on an absolute error. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "coverage.h"
#include "light.h"

static const double u = 1.0 / 16777216;

/* A homogeneous coordinate goes through: one rounding of the vertex, of the modelview and of the
 * projection entry (3), the product of the two matrices and the product with the vertex, each four
 * multiplications and three additions (4 + 4); one more for second-order terms. */
enum { TRANSFORM_ROUNDINGS = 12 };
/* Eye space: vertex, modelview, product (1 + 1 + 4), one for second-order terms. w is the eye's z,
 * negative, or 1 in a parallel view: the last row of a projection is made of 0, 1 and -1. */
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

/* Window coordinates and their bounds. Where OpenGL draws a picture in tiles, each with a
 * projection that scales and shifts clip space, the shift adds w's roundings and error to those of
 * x and y, at most once. Division, scale and offset of the viewport: 4 roundings of a coordinate as
 * large as the picture. */
static void place_vertex(const struct plan *plan, const double magnitude[4], struct lit_vertex *out)
{
    double w = out->clip[3], half_width = 0.5 * plan->scene->width,
           half_height = 0.5 * plan->scene->height, shift = plan->tiled,
           unit = TRANSFORM_ROUNDINGS * u,
           e_w = plan->scene->camera.perspective ? EYE_ROUNDINGS * u * magnitude[3] : 0;
    double e_x = unit * (magnitude[0] + shift * magnitude[3]),
           e_y = unit * (magnitude[1] + shift * magnitude[3]), e_z = unit * magnitude[2];
    out->e_clip[CLIP_XY] = (float)fmax(e_x, e_y);
    out->e_clip[CLIP_Z] = (float)e_z;
    out->e_clip[CLIP_W] = (float)e_w;
    if (!(w > 0))
        return;
    double nx = out->clip[0] / w, ny = out->clip[1] / w, nz = out->clip[2] / w;
    out->x = (nx + 1) * half_width;
    out->y = (1 - ny) * half_height;
    out->z = (nz + 1) * 0.5;
    out->inverse_w = 1 / w;
    out->slack_px = (float)fmax(half_width * ((e_x + (fabs(nx) + shift) * e_w) / w + 8 * u),
                                half_height * ((e_y + (fabs(ny) + shift) * e_w) / w + 8 * u));
    out->slack_depth = (float)(0.5 * (e_z + fabs(nz) * e_w) / w + 4 * u);
    out->slack_w = plan->scene->camera.perspective ? (float)(e_w / w + 2 * u) : 0;
}

/* ---- where no error is made ---- */

/* Whether the clip coordinates of a body's vertices may come out exact: an orthographic picture in
 * one tile, and matrices that multiply without rounding. Their product is stored. */
static bool may_be_exact(const struct plan *plan, const struct body *body, struct matrix *product)
{
    *product = matrix_product(plan->projection, body->model_view);
    return !plan->scene->camera.perspective && !plan->tiled &&
           exact_product(&plan->projection, &body->model_view);
}

/* Whether the viewport keeps a coordinate exact, and puts it on the grid of 1/256 pixel. */
static bool is_on_grid(double normalised, double window, int size)
{
    double terms[2] = {normalised * 0.5 * size, 0.5 * size}, steps = window * 256;
    return exact_sum(terms, 2) && steps == floor(steps) && fabs(steps) < 16777216;
}

/* `object` is the vertex, `product` what may_be_exact stored. */
static bool is_exact(const struct plan *plan, const struct matrix *product, const double object[4],
                     const struct lit_vertex *vertex)
{
    return exact_row(product->row[0], object) && exact_row(product->row[1], object) &&
           vertex->clip[3] == 1 && is_on_grid(vertex->clip[0], vertex->x, plan->scene->width) &&
           is_on_grid(vertex->clip[1], vertex->y, plan->scene->height);
}

/* ---- surfaces ---- */

size_t surface_attributes(const struct surface *surface, int vertex, int side)
{
    return ((size_t)vertex * (size_t)surface->n_sides + (size_t)side) *
           (size_t)surface->n_attributes;
}

/* `exact` is NULL where none of the body's vertices can be. */
static void process_vertex(const struct plan *plan, struct surface *surface,
                           const struct body_bounds *bounds, const struct matrix *exact, int index,
                           struct light_work *work)
{
    const struct body *body = surface->body;
    struct vector position = surface->mesh->vertices[index].position;
    struct lit_vertex *out = &surface->vertices[index];
    double object[4] = {position.x, position.y, position.z, 1};
    double eye[4], eye_magnitude[4], clip_magnitude[4];
    transform(&body->model_view, object, eye);
    magnitudes(&body->model_view, object, eye_magnitude);
    transform(&plan->projection, eye, out->clip);
    magnitudes(&plan->projection, eye_magnitude, clip_magnitude);
    place_vertex(plan, clip_magnitude, out);
    out->exact = exact && is_exact(plan, exact, object, out);
    if (out->exact)
        out->slack_px = 0;
    double e_eye = EYE_ROUNDINGS * u * (eye_magnitude[0] + eye_magnitude[1] + eye_magnitude[2]);
    light_vertex(plan, surface, bounds, index, (struct vector){eye[0], eye[1], eye[2]}, e_eye,
                 work);
}

static bool surface_alloc(const struct plan *plan, const struct driver *driver,
                          const struct body *body, struct surface *out)
{
    out->driver = driver;
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

/* The least w of what the sides of the view, widened by how far OpenGL may be off, leave of a
 * triangle; HUGE_VAL: nothing. */
static double least_w(const struct surface *surface, const int32_t vertex[3])
{
    struct clip_plane sides[4] = {
        {{-1, 0, 0, 1}, 0}, {{1, 0, 0, 1}, 0}, {{0, -1, 0, 1}, 0}, {{0, 1, 0, 1}, 0}};
    struct corner whole[3], left[CLIP_CORNERS];
    double least = HUGE_VAL;
    for (int i = 0; i < 3; i++) {
        const struct lit_vertex *corner = &surface->vertices[vertex[i]];
        whole[i] = (struct corner){.whole = i};
        memcpy(whole[i].clip, corner->clip, sizeof whole[i].clip);
        for (int p = 0; p < 4; p++)
            sides[p].offset = fmax(sides[p].offset,
                                   2 * (double)(corner->e_clip[CLIP_XY] + corner->e_clip[CLIP_W]));
    }
    int n = clip_triangle(whole, sides, 4, left);
    for (int i = 0; i < n; i++)
        least = fmin(least, left[i].clip[3]);
    return least;
}

/* Where a triangle reaches the eye, OpenGL must know depths better than where the near plane is. */
static bool check_near(const struct plan *plan, const struct surface *surface, int triangle,
                       struct error *err)
{
    const int32_t *vertex = surface->mesh->triangles[triangle];
    double error = 0;
    for (int i = 0; i < 3; i++)
        error = fmax(error, (double)surface->vertices[vertex[i]].e_clip[CLIP_Z]);
    return error <= 0.125 * plan->near || least_w(surface, vertex) > 8 * error ||
           error_at(
               err, surface->body->object->place,
               "triangle %d of this object reaches the eye, and single precision does not know "
               "depths there better than %.3g; the camera's near plane, at %.6g, must lie "
               "farther away",
               triangle + 1, error * plan->unit, plan->scene->camera.near);
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

static bool surface_light(const struct plan *plan, const struct driver *driver,
                          const struct body *body, struct surface *out, struct light_work *work,
                          struct error *err)
{
    if (!surface_alloc(plan, driver, body, out))
        return error_memory(err);
    struct matrix product;
    const struct matrix *exact = may_be_exact(plan, body, &product) ? &product : NULL;
    struct body_bounds bounds = body_bounds(body);
    long lit = 0, specular = 0, powers = 0;
    int n_vertices = out->mesh->n_vertices;
#pragma omp parallel for reduction(+ : lit, specular, powers) num_threads(plan->options.threads)
    for (int i = 0; i < n_vertices; i++) {
        struct light_work own = {0};
        process_vertex(plan, out, &bounds, exact, i, &own);
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
    for (int i = 0; i < out->mesh->n_triangles && plan->scene->camera.perspective; i++)
        if (!check_near(plan, out, i, err))
            return false;
    surface_bounds(out);
    return true;
}

bool surfaces_light(const struct plan *plan, const struct driver *driver, struct surface **out,
                    struct light_work *work, struct error *err)
{
    *work = (struct light_work){0};
    *out = calloc((size_t)plan->n_bodies + 1, sizeof **out);
    if (!*out)
        return error_memory(err);
    for (int i = 0; i < plan->n_bodies; i++)
        if (!surface_light(plan, driver, &plan->bodies[i], &(*out)[i], work, err))
            return false;
    return true;
}

/* Where a surface may be brightest: weights of both sides of its vertices; in phong shading upper
 * bounds on those of all its points. */
struct brightest {
    const double *weights;
    size_t n, stride;
};

/* The largest radiance in one band, and which of the brightest has it. */
static double largest_radiance(const struct plan *plan, const struct finish *finish,
                               const struct brightest *of, int band, size_t *at)
{
    size_t n_terms = (size_t)finish->n_terms, n_bands = (size_t)plan->n_bands;
    double largest = -1;
    for (size_t i = 0; i < of->n; i++) {
        const double *weights = of->weights + i * of->stride;
        double radiance = 0;
        for (size_t t = 0; t < n_terms; t++)
            radiance += weights[t] * finish->spectra[t * n_bands + (size_t)band];
        if (!(radiance <= largest)) { /* NaN counts as larger, so that it is found */
            largest = radiance;
            *at = i;
        }
        if (!isfinite(largest))
            break;
    }
    return finish->texture ? largest * finish->texture->largest : largest;
}

static bool check_radiance(const struct plan *plan, const struct surface *surface, int band,
                           size_t at, double radiance, struct error *err)
{
    char page[PAGE_NAME], vertex[32] = "this object";
    if (isfinite(radiance) && !(plan->options.bits == 32 && radiance > (double)FLT_MAX))
        return true;
    if (plan->scene->shading != SHADING_PHONG)
        snprintf(vertex, sizeof vertex, "vertex %d", (int)at / surface->n_sides + 1);
    page_name(plan, band, page);
    return isfinite(radiance)
               ? error_at(err, surface->body->object->place,
                          "the radiance of %s at %s is %.3g, above what a float page holds", vertex,
                          page, radiance)
               : error_at(
                     err, surface->body->object->place,
                     "the radiance of %s at %s is not finite; lights and factors are too large",
                     vertex, page);
}

/* False where phong shading has no bound: that of the light `*light`. limits has room for the
 * surface's terms. */
static bool find_brightest(const struct plan *plan, const struct surface *surface, double *limits,
                           struct brightest *out, int *light)
{
    *light = -1;
    *out = (struct brightest){surface->weights,
                              (size_t)surface->mesh->n_vertices * (size_t)surface->n_sides,
                              (size_t)surface->n_attributes};
    if (plan->scene->shading != SHADING_PHONG)
        return true;
    *out = (struct brightest){limits, 1, 0};
    light_limits(plan, surface, limits, light);
    return *light < 0;
}

/* Raises *largest to the largest radiance of a surface. What has no bound needs a full scale that
 * is asked for. */
static bool raise_largest(const struct plan *plan, const struct surface *surface, double *limits,
                          double *largest, struct error *err)
{
    struct brightest brightest;
    int light;
    if (!find_brightest(plan, surface, limits, &brightest, &light))
        return plan->options.full_scale > 0 ||
               error_at(err, plan->lights[light].light->attenuation_place,
                        "this light has no limit where it touches %s, so that phong shading has no "
                        "largest radiance; --full-scale can set one, or a constant attenuation",
                        surface->finish->material->name);
    for (int band = 0; band < plan->n_bands; band++) {
        size_t at = 0;
        double radiance = largest_radiance(plan, surface->finish, &brightest, band, &at);
        if (!check_radiance(plan, surface, band, at, radiance, err))
            return false;
        *largest = fmax(*largest, radiance);
    }
    return true;
}

static bool surfaces_largest(const struct plan *plan, const struct surface *surfaces,
                             double *largest, struct error *err)
{
    double *limits = malloc(((size_t)plan->max_rows + 1) * sizeof *limits);
    bool done = limits || error_memory(err);
    *largest = 0;
    for (int s = 0; s < plan->n_bodies && done; s++)
        done = raise_largest(plan, &surfaces[s], limits, largest, err);
    free(limits);
    return done;
}

/* The colours that OpenGL is given are spectra over full scale: below 2^100 they, and their sums,
 * are numbers in single precision. What is seen beside such light is black. */
static double least_full_scale(const struct plan *plan)
{
    double largest = 0, share = 1;
    for (int i = 0; i < plan->n_lights; i++)
        share = fmax(share, plan->lights[i].share);
    for (int f = 0; f < plan->n_finishes; f++)
        for (int t = 0; t < plan->finishes[f].n_terms; t++)
            largest = fmax(largest, plan->finishes[f].terms[t].peak);
    return ldexp(largest * share, -100);
}

bool surfaces_full_scale(const struct plan *plan, const struct surface *surfaces, double *out,
                         bool *clips, struct error *err)
{
    double largest;
    if (!surfaces_largest(plan, surfaces, &largest, err))
        return false;
    if (plan->options.bits == 32 && largest > 0 && largest < (double)FLT_MIN / u)
        return error_at(
            err, surfaces[0].body->object->place,
            "the largest radiance is %.3g, so small that a float page would lose digits; "
            "lights and factors are too small",
            largest);
    double least = least_full_scale(plan), wanted = plan->options.full_scale;
    if (wanted > 0 && wanted < least)
        return error_usage(err,
                           "--full-scale: %g is too small beside the lights; the least that single "
                           "precision can show is %.3g",
                           wanted, least);
    *clips = wanted > 0 && wanted < largest;
    largest = fmax(largest, least);
    *out = wanted > 0 ? wanted : largest > 0 ? largest : 1;
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
