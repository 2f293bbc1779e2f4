/* SPDX-License-Identifier: MIT */
/* Lights a scene: the reference places every vertex in the window and lights it; bounds say how far
 * OpenGL may be off there. Refuses what single precision cannot hold. */
#include <float.h>
#include <math.h>

#include "raster/bounds/inside.h"

/* A homogeneous coordinate goes through: one rounding of the vertex, of the modelview and of the
 * projection entry (3), the product of the two matrices and the product with the vertex, each four
 * multiplications and three additions (4 + 4); one more for second-order terms. */
enum { TRANSFORM_ROUNDINGS = 12 };
/* Eye space: vertex, modelview, product (1 + 1 + 4), one for second-order terms. w is the eye's z,
 * negative, or 1 in a parallel view: the last row of a projection is made of 0, 1 and -1. */
enum { EYE_ROUNDINGS = 7 };

const struct surface_bounds *bounds_of(const struct lit_scene *lit,
                                       const struct screen_triangle *screen)
{
    return &lit->bounds[screen->surface - lit->surfaces];
}

/* ---- position ---- */

/* Division, scale and offset of the viewport are 4 roundings of a coordinate as large as the
 * picture; w comes in after 2 roundings. Where OpenGL draws a picture in tiles, each with a
 * projection that scales and shifts clip space, the shift adds w's error to those of x and y, at
 * most once. */
struct slack clip_slack(const struct plan *plan, const double clip[4], const double e_clip[4])
{
    const double w = clip[CLIP_W], e_w = e_clip[CLIP_W], shifted = plan->tiled ? e_w : 0;
    /* (a + e) / (b + f) - a / b = (e - (a / b) f) / (b + f), to first order */
    double e[3];
    for (int i = 0; i < 3; i++)
        e[i] = (e_clip[i] + (i < CLIP_Z ? shifted : 0) + fabs(clip[i] / w) * e_w) / fabs(w);
    return (struct slack){.px = fmax(0.5 * plan->view.width * (e[CLIP_X] + roundings(8)),
                                     0.5 * plan->view.height * (e[CLIP_Y] + roundings(8))),
                          .depth = 0.5 * e[CLIP_Z] + roundings(4),
                          .w = e_w / w + roundings(2)};
}

/* In tiles w's roundings add to those of x and y, too. */
static void bound_place(const struct plan *plan, const double magnitude[4],
                        const struct window_vertex *vertex, struct vertex_bounds *out)
{
    const bool perspective = plan->scene->camera.perspective;
    const double shift = plan->tiled, unit = roundings(TRANSFORM_ROUNDINGS),
                 e_clip[4] = {unit * (magnitude[CLIP_X] + shift * magnitude[CLIP_W]),
                              unit * (magnitude[CLIP_Y] + shift * magnitude[CLIP_W]),
                              unit * magnitude[CLIP_Z],
                              perspective ? roundings(EYE_ROUNDINGS) * magnitude[CLIP_W] : 0};
    for (int i = 0; i < 4; i++)
        out->e_clip[i] = (float)e_clip[i];
    if (!(vertex->clip[CLIP_W] > 0))
        return;
    out->slack = clip_slack(plan, vertex->clip, e_clip);
    out->slack.w = perspective ? out->slack.w : 0;
}

/* ---- exact vertices ---- */

/* True if the clip coordinates of an instance's vertices may come out exact: an orthographic
 * picture in one tile, and matrices that multiply without rounding. Their product is stored. The
 * vertices of shadow volumes are rounded themselves. */
static bool may_be_exact(const struct lit_scene *lit, const struct instance *instance,
                         struct matrix *product)
{
    const struct plan *plan = lit->plan;
    *product = matrix_product(plan->view.projection, instance->model_view);
    return !plan->scene->camera.perspective && !plan->tiled && !lit->are_volumes &&
           exact_product(&plan->view.projection, &instance->model_view);
}

/* True if the viewport keeps a coordinate exact, and puts it on the grid of 1/256 pixel. */
static bool is_on_grid(double normalised, double window, int size)
{
    double terms[2] = {normalised * 0.5 * size, 0.5 * size}, steps = window * 256;
    return exact_sum(terms, 2) && steps == floor(steps) && fabs(steps) < 1 / SINGLE_ROUNDOFF;
}

/* `object` is the vertex, `product` the matrix that may_be_exact stored. */
static bool is_exact(const struct plan *plan, const struct matrix *product, const double object[4],
                     const struct window_vertex *vertex)
{
    return exact_row(product->row[0], object) && exact_row(product->row[1], object) &&
           vertex->clip[3] == 1 && is_on_grid(vertex->clip[0], vertex->x, plan->view.width) &&
           is_on_grid(vertex->clip[1], vertex->y, plan->view.height);
}

/* ---- one vertex ---- */

/* A surface whose vertices are being lit and bounded. */
struct bounding {
    struct lit_scene *lit;
    struct surface *surface;
    struct surface_bounds *bounds;
    struct matrix product;
    bool may_be_exact;
    pthread_mutex_t lock; /* of lit->work */
};

/* A vertex out of view needs no bounds: OpenGL does not get it. */
static void make_vertex(const struct bounding *of, int index, struct light_work *work)
{
    const struct instance *instance = of->surface->instance;
    struct vector position = instance->vertices[index].position;
    struct vertex_bounds *out = &of->bounds->vertices[index];
    const double object[4] = {position.x, position.y, position.z, 1};
    double eye_magnitude[4], clip_magnitude[4];
    const struct plan *plan = of->lit->plan;
    surface_light(&plan->view, of->surface, index, work);
    if (!of->bounds->placed->in_view)
        return;
    matrix_magnitudes(&instance->model_view, object, eye_magnitude);
    matrix_magnitudes(&plan->view.projection, eye_magnitude, clip_magnitude);
    bound_place(plan, clip_magnitude, &of->surface->vertices[index], out);
    out->exact =
        of->may_be_exact && is_exact(plan, &of->product, object, &of->surface->vertices[index]);
    if (out->exact)
        out->slack.px = 0;
    double e_eye =
        roundings(EYE_ROUNDINGS) * (eye_magnitude[0] + eye_magnitude[1] + eye_magnitude[2]);
    if (!of->lit->are_volumes)
        light_bounds(of->lit, of->surface, index, e_eye, work);
}

/* ---- refusals ---- */

/* Half a texel off, OpenGL may show any of the texture's values. */
static bool check_texture(const struct surface *surface, const struct surface_bounds *bounds,
                          int index, struct error *err)
{
    size_t at = surface_attributes(surface, index, 0) + (size_t)surface->instance->n_terms;
    const double *s_t = surface->weights + at;
    struct texel_point place =
        texel_point(&surface->instance->texels, driver_of(NULL), s_t, bounds->errors + at);
    return ((double)place.e_place[0] < 0.5 && (double)place.e_place[1] < 0.5) ||
           error_at(err, bounds->placed->object->place,
                    "the texture coordinates %.6g %.6g of vertex %d are too large for single "
                    "precision; the texture must repeat less often",
                    s_t[0], s_t[1], index + 1);
}

static bool check_vertex(const struct surface *surface, const struct surface_bounds *bounds,
                         int index, struct error *err)
{
    const struct window_vertex *vertex = &surface->vertices[index];
    size_t first = surface_attributes(surface, index, 0),
           last = surface_attributes(surface, index + 1, 0);
    const double slack_px = bounds->vertices[index].slack.px;
    double sum = vertex->x + vertex->y + vertex->z + slack_px, weights = 0;
    for (int i = 0; i < 4; i++)
        sum += vertex->clip[i];
    for (size_t i = first; i < last; i++)
        weights += surface->weights[i] + (double)bounds->errors[i];
    if (!isfinite(sum) || slack_px > (double)FLT_MAX) /* as single precision has it */
        return error_at(err, bounds->placed->object->place,
                        "vertex %d of this object is not finite in the window; "
                        "coordinates and scales are too large",
                        index + 1);
    if (surface->instance->textured && !check_texture(surface, bounds, index, err))
        return false;
    return isfinite(weights) || error_at(err, bounds->placed->object->place,
                                         "vertex %d of this object reflects no finite radiance; "
                                         "a light that weakens with distance may be too near",
                                         index + 1);
}

/* The least w of the part of a triangle that lies between the sides of the view, which are widened
 * by how far OpenGL may be off; HUGE_VAL: no part does. */
static double least_w(const struct surface *surface, const struct surface_bounds *bounds,
                      const int32_t vertex[3])
{
    struct clip_plane sides[4] = {
        {{-1, 0, 0, 1}, 0}, {{1, 0, 0, 1}, 0}, {{0, -1, 0, 1}, 0}, {{0, 1, 0, 1}, 0}};
    struct corner corners[2][CLIP_CORNERS];
    double least = HUGE_VAL, offset = 0;
    int n = 3;
    for (int i = 0; i < 3; i++) {
        const float *e_clip = bounds->vertices[vertex[i]].e_clip;
        offset = fmax(offset, 2 * (double)(fmaxf(e_clip[CLIP_X], e_clip[CLIP_Y]) + e_clip[CLIP_W]));
    }
    whole_corners(surface, vertex, corners[0]);
    for (int p = 0; p < 4 && n > 0; p++) {
        sides[p].offset = offset;
        n = clip_polygon(&sides[p], corners[p % 2], n, corners[1 - p % 2]);
    }
    for (int i = 0; i < n; i++)
        least = fmin(least, corners[0][i].clip[3]);
    return least;
}

/* Refuses a triangle that reaches the eye unless its errors in depth are small beside the near
 * plane's distance. */
static bool check_near(const struct plan *plan, const struct surface *surface,
                       const struct surface_bounds *bounds, int triangle, struct error *err)
{
    const int32_t *vertex = surface->instance->triangles[triangle];
    const struct camera *camera = &plan->scene->camera;
    double error = 0;
    for (int i = 0; i < 3; i++)
        error = fmax(error, (double)bounds->vertices[vertex[i]].e_clip[CLIP_Z]);
    return error <= 0.125 * plan->near || least_w(surface, bounds, vertex) > 8 * error ||
           error_at(
               err, bounds->placed->object->place,
               "triangle %d of this object reaches the eye, and single precision does not know "
               "depths there better than %.3g; the camera's near plane, at %.10g, must lie "
               "farther away%s",
               triangle + 1, error * plan->unit, camera->near,
               camera->far < 1.25 * camera->near ? " from the far plane" : "");
}

/* ---- surfaces ---- */

/* Window bounds of the whole surface, or everything where a vertex is beside or behind the eye, or
 * nothing out of view. */
static void find_extent(const struct surface *surface, struct surface_bounds *bounds)
{
    bounds->left = bounds->top = HUGE_VAL;
    bounds->right = bounds->bottom = -HUGE_VAL;
    for (int i = 0; i < surface->instance->n_vertices && bounds->placed->in_view; i++) {
        const struct window_vertex *vertex = &surface->vertices[i];
        bool in_front = vertex->clip[3] > 0;
        double slack = 1 + bounds->vertices[i].slack.px; /* a pixel more costs nothing */
        bounds->left = fmin(bounds->left, in_front ? vertex->x - slack : -HUGE_VAL);
        bounds->top = fmin(bounds->top, in_front ? vertex->y - slack : -HUGE_VAL);
        bounds->right = fmax(bounds->right, in_front ? vertex->x + slack : HUGE_VAL);
        bounds->bottom = fmax(bounds->bottom, in_front ? vertex->y + slack : HUGE_VAL);
    }
}

bool surface_reaches(const struct surface_bounds *surface, const struct rectangle *at)
{
    return surface->right >= at->x && surface->left <= at->x + at->width &&
           surface->bottom >= at->y && surface->top <= at->y + at->height;
}

static bool allocate(const struct bounding *of, const struct placed_instance *placed,
                     struct error *err)
{
    const struct plan *plan = of->lit->plan;
    const char *name = plan->materials[placed->shaded].material->name;
    struct surface_bounds *bounds = of->bounds;
    bounds->placed = placed;
    bounds->shaded = &plan->materials[placed->shaded];
    bounds->e_rigid = distance_from_rigid(&placed->instance.model_view);
    matrix_cofactors(&placed->instance.model_view, &bounds->cofactors);
    const bool opened = surface_open(&placed->instance, of->surface);
    const int n = placed->instance.n_vertices;
    const size_t n_weights = surface_attributes(of->surface, n, 0);
    const bool grouped = plan->options.check && placed->in_view && plan->n_light_groups > 1;
    return (opened || memory_lacks(err, (double)n_weights * sizeof(double), "%s", name)) &&
           MAKE_ARRAY(bounds->vertices, n, err, "the vertices of %s", name) &&
           MAKE_ARRAY(bounds->errors, n_weights, err, "the bounds of %s", name) &&
           MAKE_ARRAY(bounds->jumps, n_weights, err, "the bounds of %s", name) &&
           (!grouped || MAKE_ARRAY(bounds->group_weights, n_weights * (size_t)plan->n_light_groups,
                                   err, "the bounds of %s", name));
}

/* Vertices that a thread takes at a time. To light fewer takes less time than to start a thread. */
enum { BLOCK_VERTICES = 256 };

void light_work_add(struct light_work *to, const struct light_work *from)
{
    to->vertices_lit += from->vertices_lit;
    to->points_lit += from->points_lit;
    to->specular_vertices += from->specular_vertices;
    to->power_functions += from->power_functions;
}

/* Makes the vertices of block number `block`. */
static void make_vertices(void *context, int block)
{
    struct bounding *of = context;
    const int first = block * BLOCK_VERTICES, n = of->surface->instance->n_vertices;
    struct light_work work = {0};
    for (int i = first; i < n && i < first + BLOCK_VERTICES; i++)
        make_vertex(of, i, &work);
    pthread_mutex_lock(&of->lock);
    light_work_add(&of->lit->work, &work);
    pthread_mutex_unlock(&of->lock);
}

static bool make_surface(struct lit_scene *lit, int index, struct error *err)
{
    const struct placed_instance *placed = &lit->instances[index];
    const bool checks_near = lit->plan->scene->camera.perspective && !lit->are_volumes;
    struct bounding of = {.lit = lit,
                          .surface = &lit->surfaces[index],
                          .bounds = &lit->bounds[index],
                          .lock = PTHREAD_MUTEX_INITIALIZER};
    if (!allocate(&of, placed, err))
        return false;
    of.may_be_exact = may_be_exact(lit, &placed->instance, &of.product);
    threads_each(lit->plan->options.threads,
                 (placed->instance.n_vertices + BLOCK_VERTICES - 1) / BLOCK_VERTICES, make_vertices,
                 &of);
    for (int i = 0; i < placed->instance.n_vertices; i++)
        if (!check_vertex(of.surface, of.bounds, i, err))
            return false;
    for (int i = 0; i < placed->instance.n_triangles && checks_near; i++)
        if (!check_near(lit->plan, of.surface, of.bounds, i, err))
            return false;
    find_extent(of.surface, of.bounds);
    return !(placed->in_view && lit->plan->options.use_gl) || lit->are_volumes ||
           find_hidden(lit, index, err);
}

/* Lists what throws shadows. */
static bool find_occluders(struct lit_scene *lit, struct error *err)
{
    const struct plan *plan = lit->plan;
    double size = 0;
    bool *casts;
    if (!MAKE_ARRAY(casts, plan->n_instances, err, "%d objects", plan->n_instances))
        return false;
    for (int i = 0; i < plan->n_instances; i++) {
        const struct instance *of = &plan->instances[i].instance;
        double reach = 0, sums[4];
        for (int v = 0; v < of->n_vertices; v++)
            reach = fmax(reach, vector_reach(of->vertices[v].position));
        matrix_magnitudes(&of->model_view, (const double[4]){reach, reach, reach, 1}, sums);
        size = fmax(size, most_of(sums));
        casts[i] = plan->instances[i].casts != 0;
    }
    const bool done =
        occluders_make(lit->surfaces, plan->n_instances, casts, size, &lit->occluders) ||
        memory_lacks(err, 0, "the triangles that throw shadows");
    free(casts);
    return done;
}

static bool make_surfaces(struct lit_scene *out, struct error *err)
{
    if (!MAKE_ARRAY(out->surfaces, out->n, err, "%d objects", out->n) ||
        !MAKE_ARRAY(out->bounds, out->n, err, "the bounds of %d objects", out->n))
        return false;
    for (int i = 0; i < out->n; i++)
        if (!make_surface(out, i, err))
            return false;
    return true;
}

bool lit_make(const struct plan *plan, const struct driver *driver, struct lit_scene *out,
              struct error *err)
{
    *out = (struct lit_scene){.plan = plan,
                              .driver = driver,
                              .instances = plan->instances,
                              .n = plan->n_instances,
                              .full_scale = 1};
    return make_surfaces(out, err) && (plan->view.n_shadowed == 0 || find_occluders(out, err));
}

bool lit_place_volumes(const struct lit_scene *scene, const struct placed_instance *volumes, int n,
                       struct lit_scene *out, struct error *err)
{
    *out = (struct lit_scene){.plan = scene->plan,
                              .driver = scene->driver,
                              .instances = volumes,
                              .n = n,
                              .are_volumes = true};
    return make_surfaces(out, err);
}

void lit_free(struct lit_scene *lit)
{
    for (int i = 0; lit->surfaces && lit->bounds && i < lit->n; i++) {
        surface_close(&lit->surfaces[i]);
        FREE_ALL(lit->bounds[i].vertices, lit->bounds[i].errors, lit->bounds[i].jumps,
                 lit->bounds[i].hidden, lit->bounds[i].group_weights);
    }
    occluders_free(&lit->occluders);
    FREE_ALL(lit->surfaces, lit->bounds);
    *lit = (struct lit_scene){.plan = NULL};
}
