/* SPDX-License-Identifier: MIT */
/* Divides the objects of a plan until its picture is as accurate as is wanted. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/text/text.h"
#include "data/threads/threads.h"
#include "raster/accuracy/accuracy.h"

/* ---- the words of the option ---- */

static bool read_wanted(const char *option, const char *text, struct wanted_accuracy *out,
                        struct error *err)
{
    static const char counts[] = "counts";
    const double finest = 1e-3, coarsest = 1e5;
    const size_t length = strlen(text), tail = strlen(counts);
    const bool in_counts = length > tail && strcmp(text + length - tail, counts) == 0;
    const struct word word = {
        .start = text, .length = length - (in_counts ? tail : 0), .place = {option, 1, 1}};
    out->unit = in_counts ? MEASURE_COUNTS : MEASURE_CIEDE2000;
    return word_number(&word, "error", finest, coarsest, &out->error, err);
}

bool accuracy_accepts(const char *option, const char *value, struct error *err)
{
    struct wanted_accuracy wanted;
    return read_wanted(option, value, &wanted, err);
}

/* ---- the error of the plan ---- */

struct refinement {
    struct plan *plan;
    struct refine_result *result;
    struct measure measure;
    int *halvings;              /* of each object of the scene; owned */
    long *triangles, *at_first; /* of each object: now, and before; owned */
};

/* Vertices of a surface, which threads place or light in blocks. */
struct lighting {
    const struct view *view;
    struct surface *surface;
};

static void light_block(void *context, size_t first, size_t end)
{
    const struct lighting *of = context;
    struct light_work ignored = {0};
    for (size_t i = first; i < end; i++)
        surface_light(of->view, of->surface, (int)i, &ignored);
}

static void light_vertices(const struct plan *plan, const struct view *view,
                           struct surface *surface)
{
    enum { BLOCK_VERTICES = 256 };
    struct lighting of = {view, surface};
    threads_blocks(plan->options.threads, (size_t)surface->instance->n_vertices, BLOCK_VERTICES,
                   light_block, &of);
}

/* Places the surfaces of all instances in view in the window. */
static bool place_surfaces(const struct plan *plan, struct surface *surfaces)
{
    struct view unlit = plan->view;
    bool done = true;
    unlit.n_lights = 0;
    for (int i = 0; done && i < plan->n_instances; i++) {
        if (!plan->instances[i].in_view)
            continue;
        done = surface_open(&plan->instances[i].instance, &surfaces[i]);
        if (done)
            light_vertices(plan, &unlit, &surfaces[i]);
    }
    return done;
}

/* Lights the corners of the triangles that are seen; for a measure that needs the brightest vertex,
 * all vertices. */
static void light_seen(const struct measure *measure, const struct seen_pixels *seen,
                       struct surface *surfaces)
{
    const struct plan *plan = measure->plan;
    struct light_work ignored = {0};
    if (measure->unit == MEASURE_COUNTS && !(plan->options.full_scale > 0)) {
        for (int i = 0; i < plan->n_instances; i++)
            if (surfaces[i].instance)
                light_vertices(plan, &plan->view, &surfaces[i]);
        return;
    }
    for (int i = 0; i < seen->n; i++)
        for (int k = 0; k < 3 && seen->pixels[i].surface >= 0; k++)
            surface_light(&plan->view, &surfaces[seen->pixels[i].surface],
                          seen->pixels[i].triangle.vertex[k], &ignored);
}

/* Judges the picture of the plan as it is now. */
static bool look(struct refinement *of, struct error *err)
{
    enum { MANY_PIXELS = 8192 };
    const struct plan *plan = of->plan;
    struct seen_pixels seen = {.pixels = NULL};
    struct surface *surfaces = calloc((size_t)plan->n_instances + 1, sizeof *surfaces);
    accuracy_estimate_free(&of->result->estimate);
    bool done = (surfaces && place_surfaces(plan, surfaces)) || error_memory(err);
    done = done && seen_find(plan, surfaces, MANY_PIXELS, &seen, err);
    if (done) {
        light_seen(&of->measure, &seen, surfaces);
        measure_scale(&of->measure, surfaces);
        done = accuracy_judge(&of->measure, surfaces, &seen, &of->result->estimate, err);
    }
    for (int i = 0; surfaces && i < plan->n_instances; i++)
        surface_close(&surfaces[i]);
    free(surfaces);
    seen_free(&seen);
    return done;
}

/* ---- division ---- */

/* Returns the index of an instance's object in the scene. */
static int object_of(const struct plan *plan, int instance)
{
    return (int)(plan->instances[instance].object - plan->scene->objects);
}

static void count_triangles(const struct plan *plan, long *triangles)
{
    memset(triangles, 0, (size_t)plan->scene->n_objects * sizeof *triangles);
    for (int i = 0; i < plan->n_instances; i++)
        triangles[object_of(plan, i)] += plan->instances[i].instance.n_triangles;
}

/* Returns whether the shape of an object can have more slices, stacks, ... than it has. */
static bool is_divisible(const struct refinement *of, int object)
{
    const struct scene *scene = of->plan->scene;
    const struct shape *shape = &scene->objects[object].shape;
    const double now = ldexp(scene->tessellation, of->halvings[object]);
    const struct shape a = shape_tessellated(shape, now), b = shape_tessellated(shape, 2 * now);
    return shape->kind == SHAPE_MESH || memcmp(a.parameter, b.parameter, sizeof a.parameter) != 0;
}

/* Returns at most how many more triangles an object gets when it is divided. A triangle becomes
 * four; those at poles and rims of built-in shapes become six. */
static long growth(const struct refinement *of, int object)
{
    return (of->plan->scene->objects[object].shape.kind == SHAPE_MESH ? 3 : 5) *
           of->triangles[object];
}

/* Finds the objects to divide, those of the largest errors first, as long as there is room for
 * their triangles. Returns whether there are any. */
static bool choose(const struct refinement *of)
{
    struct refine_result *result = of->result;
    const struct accuracy_estimate *estimate = &result->estimate;
    long room = result->most_triangles - of->plan->n_triangles;
    bool any = false;
    for (int i = 0; i < estimate->n_objects; i++) {
        const int object = object_of(of->plan, estimate->objects[i].surface);
        if (estimate->objects[i].quantile_95 <= result->wanted.error || !is_divisible(of, object))
            continue;
        if (growth(of, object) > room) {
            result->stopped = true;
            continue;
        }
        room -= growth(of, object);
        of->halvings[object]++;
        any = true;
    }
    return any;
}

/* Divides an object that another one hides, in the same place, as often as that one: their
 * triangles have the same depths, so that it stays hidden. */
static void divide_twins(const struct refinement *of)
{
    const struct plan *plan = of->plan;
    for (int i = 0; i < plan->n_instances; i++) {
        const struct placed_instance *placed = &plan->instances[i], *other = plan->instances;
        if (!placed->twin)
            continue;
        while (other->mesh != placed->mesh ||
               memcmp(&other->instance.model_view, &placed->instance.model_view,
                      sizeof placed->instance.model_view) != 0)
            other++;
        int *one = &of->halvings[object_of(plan, i)],
            *two = &of->halvings[other->object - plan->scene->objects];
        *one = *two = *one > *two ? *one : *two;
    }
}

/* Divides objects until all are good enough, or can be divided no more. */
static bool divide(struct refinement *of, struct error *err)
{
    bool done = look(of, err);
    of->result->error_before = of->result->estimate.quantile_95;
    count_triangles(of->plan, of->at_first);
    count_triangles(of->plan, of->triangles);
    while (done && choose(of)) {
        divide_twins(of);
        done = plan_refine(of->plan, of->halvings, err) && look(of, err);
        count_triangles(of->plan, of->triangles);
        of->result->levels++;
    }
    of->result->triangles_after = of->plan->n_triangles;
    return done;
}

/* Lists the divided objects, in the order of their first instances. */
static bool list_divided(struct refinement *of, struct error *err)
{
    struct refine_result *out = of->result;
    bool done = true;
    for (int i = 0; done && i < of->plan->n_instances; i++) {
        const int object = object_of(of->plan, i);
        const struct refined_object divided = {i, of->at_first[object], of->triangles[object]};
        if (divided.after > divided.before && (i == 0 || object != object_of(of->plan, i - 1)))
            done = array_add(&out->objects, &out->n_objects, &divided, sizeof divided, err);
    }
    return done;
}

/* ---- all of it ---- */

static bool refine(struct plan *plan, const char *observer, struct refine_result *out,
                   struct error *err)
{
    const size_t n = (size_t)plan->scene->n_objects + 1;
    struct refinement of = {.plan = plan,
                            .result = out,
                            .halvings = calloc(n, sizeof *of.halvings),
                            .triangles = calloc(n, sizeof *of.triangles),
                            .at_first = calloc(n, sizeof *of.at_first)};
    bool known = true;
    bool done = (of.halvings && of.triangles && of.at_first) || error_memory(err);
    done = done && measure_make(plan, out->wanted.unit, observer, &of.measure, &known, err) &&
           (known || error_usage(err,
                                 "--accuracy in CIEDE2000 needs an observer, and %s is none; "
                                 "expected counts, as --accuracy 8counts",
                                 plan->sampling ? plan->sampling->detector : observer)) &&
           (plan->view.shading == FLAT || (divide(&of, err) && list_divided(&of, err)));
    measure_free(&of.measure);
    free(of.halvings);
    free(of.triangles);
    free(of.at_first);
    return done;
}

bool refine_options(const struct options *options, struct plan *plan, struct refine_result *out,
                    struct error *err)
{
    enum { USUAL_TRIANGLES = 4000000 };
    if (!options->accuracy)
        return true;
    *out = (struct refine_result){
        .most_triangles = options->max_triangles > 0 ? options->max_triangles : USUAL_TRIANGLES,
        .triangles_before = plan->n_triangles,
        .triangles_after = plan->n_triangles};
    return read_wanted("--accuracy", options->accuracy, &out->wanted, err) &&
           refine(plan, options_detector(options), out, err);
}

void refine_result_free(struct refine_result *result)
{
    accuracy_estimate_free(&result->estimate);
    free(result->objects);
    *result = (struct refine_result){.objects = NULL};
}
