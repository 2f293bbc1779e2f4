/* SPDX-License-Identifier: MIT */
/* The error of a picture's shading, from a lattice of its pixels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/scene/scene.h"
#include "raster/beside/accuracy/inside.h"

struct judged_point {
    int surface; /* -1: none */
    const struct object *object;
    float error;
};
struct estimating {
    const struct plan *plan;
    const struct surface *surfaces;
    const struct measure *measure;
    struct seen_pixels seen;
    struct patches *patches;     /* of each mesh of the plan that is seen; owned */
    struct judged_point *points; /* of each pixel of the lattice, and then those that are judged;
                                    owned */
    int n_points;
    struct counter failed; /* threads that found no memory */
};

/* ---- points ---- */

/* Judges a pixel of the lattice; none: background, and where the true surface is not seen. */
static void judge_pixel(const struct estimating *of, int index, double *attributes,
                        struct judged_point *out)
{
    const struct lattice_pixel *pixel = &of->seen.pixels[index];
    struct compared_point point;
    double at[2], share[3];
    out->surface = -1;
    if (pixel->surface < 0 || !lattice_place(&of->seen.lattice, index, at))
        return;
    const struct placed_instance *placed = &of->plan->instances[pixel->surface];
    const struct judged_surface surface = {of->plan, placed, &of->plan->meshes[placed->mesh],
                                           &of->surfaces[pixel->surface],
                                           &of->patches[placed->mesh]};
    shares_at(&pixel->triangle, at[0], at[1], share);
    if (compare_point(&surface, &pixel->triangle, at, share, attributes, &point))
        *out = (struct judged_point){
            pixel->surface, placed->object,
            (float)measure_difference(of->measure, placed->shaded, &point.drawn, &point.exact)};
}

static void judge_block(void *context, size_t first, size_t end)
{
    struct estimating *of = context;
    double *attributes;
    if (!memory_make(&attributes, 2 * ((size_t)of->plan->max_rows + 2), sizeof *attributes))
        counter_add(&of->failed, 1);
    for (size_t i = first; i < end && attributes; i++)
        judge_pixel(of, (int)i, attributes, &of->points[i]);
    free(attributes);
}

/* Opens the patches of all shapes that are seen. */
static bool open_seen(struct estimating *of, struct error *err)
{
    for (int i = 0; i < of->seen.n; i++) {
        if (of->seen.pixels[i].surface < 0)
            continue;
        const int index = of->plan->instances[of->seen.pixels[i].surface].mesh;
        const struct plan_mesh *mesh = &of->plan->meshes[index];
        if (mesh->mesh.parametric && !of->patches[index].shape &&
            !patches_open(&mesh->shape, &of->patches[index], err))
            return false;
    }
    return true;
}

static bool judge_pixels(struct estimating *of, struct error *err)
{
    enum { BLOCK_PIXELS = 128 };
    const int n = of->seen.n;
    if (!open_seen(of, err))
        return false;
    threads_blocks(of->plan->options.threads, (size_t)n, BLOCK_PIXELS, judge_block, of);
    for (int i = 0; i < n && of->failed.n == 0; i++)
        if (of->points[i].surface >= 0)
            of->points[of->n_points++] = of->points[i];
    return of->failed.n == 0 || memory_lacks(err, 0, "the pixels that are judged");
}

/* ---- conclusions ---- */

static int by_error(const void *a, const void *b)
{
    const float one = ((const struct judged_point *)a)->error,
                two = ((const struct judged_point *)b)->error;
    return (one > two) - (one < two);
}

static int by_object(const void *a, const void *b)
{
    const struct judged_point *one = a, *two = b;
    return one->object != two->object ? (one->object > two->object) - (one->object < two->object)
                                      : by_error(a, b);
}

static int worst_first(const void *a, const void *b)
{
    const struct accuracy_object *one = a, *two = b;
    return one->quantile_95 != two->quantile_95
               ? (one->quantile_95 < two->quantile_95) - (one->quantile_95 > two->quantile_95)
               : (one->surface > two->surface) - (one->surface < two->surface);
}

/* Returns the error that 95 % of n points, sorted, have at most. */
static double quantile(const struct judged_point *points, int n)
{
    return n > 0 ? (double)points[n - n / 20 - 1].error : 0;
}

/* Returns the first of the surfaces that n points show, so that the order of equal errors does not
 * matter. */
static int first_surface(const struct judged_point *points, int n)
{
    int first = points[0].surface;
    for (int i = 1; i < n; i++)
        first = points[i].surface < first ? points[i].surface : first;
    return first;
}

static bool conclude(struct estimating *of, struct accuracy_estimate *out, struct error *err)
{
    const size_t size = sizeof *of->points;
    qsort(of->points, (size_t)of->n_points, size, by_error);
    out->quantile_95 = quantile(of->points, of->n_points);
    out->n_points = of->n_points;
    qsort(of->points, (size_t)of->n_points, size, by_object);
    for (int i = 0, n; i < of->n_points; i += n) {
        for (n = 1; i + n < of->n_points && of->points[i + n].object == of->points[i].object; n++)
            ;
        const struct accuracy_object object = {first_surface(&of->points[i], n),
                                               quantile(&of->points[i], n), n};
        if (!array_add(&out->objects, &out->n_objects, &object, sizeof object, err))
            return false;
    }
    if (out->n_objects > 0)
        qsort(out->objects, (size_t)out->n_objects, sizeof *out->objects, worst_first);
    return true;
}

/* ---- all of it ---- */

bool estimate_measured(const struct measure *measure, const struct surface *surfaces, int wanted,
                    struct accuracy_estimate *out, struct error *err)
{
    const struct plan *plan = measure->plan;
    struct estimating of = {
        .plan = plan, .surfaces = surfaces, .measure = measure, .failed = COUNTER};
    *out = (struct accuracy_estimate){.known = true, .unit = measure->unit};
    const bool done =
        seen_find(plan, surfaces, wanted, &of.seen, err) &&
        MAKE_ARRAY(of.patches, (size_t)plan->n_meshes + 1, err, "the shapes that are judged") &&
        MAKE_ARRAY(of.points, (size_t)of.seen.n + 1, err, "the pixels that are judged") &&
        judge_pixels(&of, err) && conclude(&of, out, err);
    for (int i = 0; of.patches && i < plan->n_meshes; i++)
        patches_close(&of.patches[i]);
    free(of.patches);
    free(of.points);
    free(of.seen.pixels);
    if (!done)
        accuracy_estimate_free(out);
    return done;
}

/* ---- the estimate of a note ---- */

bool accuracy_estimate(const struct plan *plan, const struct surface *surfaces, int wanted,
                       struct accuracy_estimate *out, struct error *err)
{
    struct measure measure;
    *out = (struct accuracy_estimate){.objects = NULL};
    if (plan->view.shading != GOURAUD)
        return true;
    bool done = measure_make(plan, MEASURE_CIEDE2000, "cie1931", &measure, err);
    if (done && measure.known)
        done = estimate_measured(&measure, surfaces, wanted, out, err);
    measure_free(&measure);
    return done;
}

void accuracy_estimate_free(struct accuracy_estimate *estimate)
{
    free(estimate->objects);
    *estimate = (struct accuracy_estimate){.objects = NULL};
}
