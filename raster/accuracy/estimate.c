/* SPDX-License-Identifier: MIT */
/* The error of a picture's shading, from a lattice of its pixels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "raster/accuracy/accuracy.h"

struct judged_point {
    int object;
    float error, shading; /* with wavelengths, and without */
};
struct estimating {
    const struct plan *plan;
    const struct surface *surfaces;
    const struct measure *measure;
    struct shape *shapes;    /* of each mesh of the plan, tessellated; owned */
    struct patches *patches; /* of each mesh of the plan, once it is asked for; owned */
    double *attributes;      /* of a point, twice; owned */
    struct judged_point *points;
    int n_points;
};

/* ---- surfaces ---- */

/* Returns the patches of an instance's shape; NULL after an error. */
static const struct patches *patches_of(struct estimating *of, const struct placed_instance *placed,
                                        struct error *err)
{
    struct patches *patches = &of->patches[placed->mesh];
    struct shape *shape = &of->shapes[placed->mesh];
    if (patches->shape)
        return patches;
    *shape = shape_tessellated(&placed->object->shape, of->plan->scene->tessellation);
    return patches_open(shape, patches, err) ? patches : NULL;
}

static bool judge_surface(struct estimating *of, int surface, struct judged_surface *out,
                          struct error *err)
{
    const struct placed_instance *placed = &of->plan->instances[surface];
    const struct plan_mesh *mesh = &of->plan->meshes[placed->mesh];
    *out = (struct judged_surface){.view = &of->plan->view,
                                   .surface = &of->surfaces[surface],
                                   .parameters = mesh->mesh.parameters,
                                   .centre = mesh->centre,
                                   .unit = mesh->unit};
    if (out->parameters)
        out->patches = patches_of(of, placed, err);
    return out->patches || !out->parameters;
}

/* ---- points ---- */

double texel_estimate(const struct plan *plan, int shaded, const struct instance *instance,
                      const double *attributes)
{
    const struct texture *texture = plan->materials[shaded].texture;
    double place[2];
    if (!instance->textured)
        return 1;
    if (instance->varied)
        return 0.5 * (texture->smallest + texture->largest);
    texel_place(&instance->texels, attributes + instance->n_terms, place);
    return texel_at(&instance->texels, place);
}

static double texel_of(const struct estimating *of, int surface, const double *attributes)
{
    const struct placed_instance *placed = &of->plan->instances[surface];
    return texel_estimate(of->plan, placed->shaded, &placed->instance, attributes);
}

/* Judges a pixel of the lattice. A pixel where the true surface is not seen stays out. */
static bool judge_pixel(struct estimating *of, const struct lattice_pixel *pixel,
                        const double at[2], struct error *err)
{
    const struct placed_instance *placed = &of->plan->instances[pixel->surface];
    const struct screen_triangle *triangle = &pixel->triangle;
    double *drawn = of->attributes, *exact = drawn + of->plan->max_rows + 2, share[3];
    struct light_work ignored = {0};
    struct judged_surface surface;
    if (!judge_surface(of, pixel->surface, &surface, err))
        return false;
    shares_at(triangle, at[0], at[1], share);
    shade(&of->plan->view, triangle, share, drawn, &ignored);
    if (!exact_attributes(&surface, triangle, at, share, exact))
        return true;
    const struct shaded_point a = {drawn, texel_of(of, pixel->surface, drawn)},
                              b = {exact, texel_of(of, pixel->surface, exact)};
    of->points[of->n_points++] =
        (struct judged_point){(int)(placed->object - of->plan->scene->objects),
                              (float)measure_whole(of->measure, placed->shaded, &a, &b),
                              (float)measure_difference(of->measure, placed->shaded, &a, &b)};
    return true;
}

static bool judge_pixels(struct estimating *of, const struct seen_pixels *seen, struct error *err)
{
    const struct lattice *lattice = &seen->lattice;
    double at[2];
    for (int i = 0; i < lattice->rows * lattice->columns; i++)
        if (seen->pixels[i].surface >= 0 && lattice_place(lattice, i, at) &&
            !judge_pixel(of, &seen->pixels[i], at, err))
            return false;
    return true;
}

/* ---- conclusions ---- */

static int by_error(const void *a, const void *b)
{
    const float one = ((const struct judged_point *)a)->error,
                two = ((const struct judged_point *)b)->error;
    return (one > two) - (one < two);
}

static int by_shading(const void *a, const void *b)
{
    const float one = ((const struct judged_point *)a)->shading,
                two = ((const struct judged_point *)b)->shading;
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
               : (one->object > two->object) - (one->object < two->object);
}

/* Returns the last of the 95 % of n points, at least 1, that have the least errors. */
static int last_of(int n)
{
    return n - n / 20 - 1;
}

/* Returns the error that 95 % of n points, sorted, have at most. */
static double quantile(const struct judged_point *points, int n)
{
    return n > 0 ? (double)points[last_of(n)].error : 0;
}

static bool conclude(struct estimating *of, struct accuracy_estimate *out, struct error *err)
{
    const size_t size = sizeof *of->points;
    qsort(of->points, (size_t)of->n_points, size, by_shading);
    out->shading_95 = of->n_points > 0 ? (double)of->points[last_of(of->n_points)].shading : 0;
    qsort(of->points, (size_t)of->n_points, size, by_error);
    out->quantile_95 = quantile(of->points, of->n_points);
    out->n_points = of->n_points;
    qsort(of->points, (size_t)of->n_points, size, by_object);
    for (int i = 0, n; i < of->n_points; i += n) {
        for (n = 1; i + n < of->n_points && of->points[i + n].object == of->points[i].object; n++)
            ;
        const struct accuracy_object object = {of->points[i].object, quantile(&of->points[i], n),
                                               n};
        if (!array_add(&out->objects, &out->n_objects, &object, sizeof object, err))
            return false;
    }
    if (out->n_objects > 0)
        qsort(out->objects, (size_t)out->n_objects, sizeof *out->objects, worst_first);
    return true;
}

/* ---- all of it ---- */

static bool allocate(struct estimating *of, const struct lattice *lattice, struct error *err)
{
    const size_t n = (size_t)lattice->rows * (size_t)lattice->columns,
                 n_meshes = (size_t)of->plan->n_meshes;
    of->shapes = calloc(n_meshes + 1, sizeof *of->shapes);
    of->patches = calloc(n_meshes + 1, sizeof *of->patches);
    of->attributes = calloc(2 * ((size_t)of->plan->max_rows + 2), sizeof *of->attributes);
    of->points = calloc(n + 1, sizeof *of->points);
    return (of->shapes && of->patches && of->attributes && of->points) || error_memory(err);
}

static void free_all(struct estimating *of)
{
    for (int i = 0; of->patches && i < of->plan->n_meshes; i++)
        patches_close(&of->patches[i]);
    free(of->shapes);
    free(of->patches);
    free(of->attributes);
    free(of->points);
}

bool accuracy_judge(const struct measure *measure, const struct surface *surfaces,
                    const struct seen_pixels *seen, struct accuracy_estimate *out,
                    struct error *err)
{
    struct estimating of = {.plan = measure->plan, .surfaces = surfaces, .measure = measure};
    *out = (struct accuracy_estimate){.known = true, .unit = measure->unit};
    const bool done = allocate(&of, &seen->lattice, err) && judge_pixels(&of, seen, err) &&
                      conclude(&of, out, err);
    free_all(&of);
    if (!done)
        accuracy_estimate_free(out);
    return done;
}

bool accuracy_estimate(const struct plan *plan, const struct surface *surfaces, int wanted,
                       struct accuracy_estimate *out, struct error *err)
{
    struct measure measure;
    struct seen_pixels seen = {.pixels = NULL};
    bool known;
    *out = (struct accuracy_estimate){.objects = NULL};
    if (plan->view.shading != GOURAUD)
        return true;
    bool done = measure_make(plan, MEASURE_CIEDE2000, "cie1931", &measure, &known, err);
    if (done && known)
        done = seen_find(plan, surfaces, wanted, &seen, err) &&
               accuracy_judge(&measure, surfaces, &seen, out, err);
    measure_free(&measure);
    seen_free(&seen);
    return done;
}

void accuracy_estimate_free(struct accuracy_estimate *estimate)
{
    free(estimate->objects);
    *estimate = (struct accuracy_estimate){.objects = NULL};
}
