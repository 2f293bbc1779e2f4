/* SPDX-License-Identifier: MIT */
/* Divides the objects of a plan until its picture is as accurate as is wanted; and by how much the
 * shading of objects differs from light at every point, in words. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/beside/accuracy/inside.h"
#include "raster/bounds/bounds.h"
#include "raster/renderers/renderers.h"

/* ---- the words of the option ---- */

static bool read_wanted(const char *option, const char *text, double *out, enum measure_unit *unit,
                        struct error *err)
{
    static const char counts[] = "counts";
    const double finest = 1e-3, coarsest = 1e5;
    const size_t length = strlen(text), tail = strlen(counts);
    const bool in_counts = length > tail && strcmp(text + length - tail, counts) == 0;
    const struct word word = {
        .start = text, .length = length - (in_counts ? tail : 0), .place = {option, 1, 1}};
    *unit = in_counts ? MEASURE_COUNTS : MEASURE_CIEDE2000;
    return word_number(&word, "error", finest, coarsest, out, err);
}

/* Refuses a value of --accuracy that is no error: "0.5" is in CIEDE2000, "8counts" in counts of
 * 65535. */
static bool accuracy_accepts(const char *option, const char *value, struct error *err)
{
    double error;
    enum measure_unit unit;
    return read_wanted(option, value, &error, &unit, err);
}

/* ---- the error of the plan ---- */

struct refined_object {
    int surface;        /* the first of its instances */
    long before, after; /* triangles */
};
struct shading {
    struct accuracy_estimate estimate; /* of the plan as it is now */
    bool is_refined;                   /* otherwise all that follows is zeroed */
    double wanted;                     /* error that 95 % of the pixels of each object may have */
    long most_triangles;               /* that the picture may have */
    double error_before;               /* quantile_95 of the plan that came in */
    struct refined_object *objects;    /* that were divided; owned */
    int n_objects, levels;             /* levels: how often the worst object was divided */
    long triangles_before, triangles_after; /* of the plan */
    bool stopped; /* most_triangles does not allow to divide an object that is not good enough */
};
struct refinement {
    struct plan *plan;
    struct shading *result; /* has all objects of the scene until the end */
    struct measure measure;
    int *halvings; /* of each object of the scene; owned */
};

/* Judges the picture of the plan as it is now. */
static bool look(struct refinement *of, struct error *err)
{
    enum { REFINED_PIXELS = 8192 };
    struct accuracy_estimate *estimate = &of->result->estimate;
    struct lit_scene lit;
    accuracy_estimate_free(estimate);
    bool done = lit_make(of->plan, driver_of(NULL), &lit, err);
    if (done) {
        measure_scale(&of->measure, lit.surfaces);
        done = accuracy_estimate(&of->measure, lit.surfaces, REFINED_PIXELS, estimate, err);
    }
    lit_free(&lit);
    return done;
}

/* ---- division ---- */

/* Returns the index of an instance's object in the scene. */
static int object_of(const struct plan *plan, int instance)
{
    return (int)(plan->instances[instance].object - plan->scene->objects);
}

/* Counts the triangles of each object, and finds the first of its instances. */
static void count_triangles(const struct refinement *of)
{
    const struct plan *plan = of->plan;
    struct refined_object *objects = of->result->objects;
    for (int i = 0; i < plan->scene->n_objects; i++)
        objects[i].after = 0;
    for (int i = plan->n_instances - 1; i >= 0; i--) {
        struct refined_object *object = &objects[object_of(plan, i)];
        object->after += plan->instances[i].instance.n_triangles;
        object->surface = i;
    }
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

/* Finds the objects to divide, those of the largest errors first, as long as there is room for
 * their triangles. Returns whether there are any. */
static bool choose(const struct refinement *of)
{
    struct shading *result = of->result;
    const struct accuracy_estimate *estimate = &result->estimate;
    long room = result->most_triangles - of->plan->n_triangles;
    bool any = false;
    for (int i = 0; i < estimate->n_objects; i++) {
        const int object = object_of(of->plan, estimate->objects[i].surface);
        if (estimate->objects[i].quantile_95 <= result->wanted || !is_divisible(of, object))
            continue;
        /* a triangle becomes four; at poles and rims of built-in shapes, six at most */
        const bool is_mesh = of->plan->scene->objects[object].shape.kind == SHAPE_MESH;
        const long growth = (is_mesh ? 3 : 5) * result->objects[object].after;
        if (growth > room) {
            result->stopped = true;
            continue;
        }
        room -= growth;
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
    struct shading *out = of->result;
    bool done = look(of, err);
    out->error_before = out->estimate.quantile_95;
    count_triangles(of);
    for (int i = 0; i < of->plan->scene->n_objects; i++)
        out->objects[i].before = out->objects[i].after;
    while (done && choose(of)) {
        divide_twins(of);
        done = plan_refine(of->plan, of->halvings, err) && look(of, err);
        count_triangles(of);
        out->levels++;
    }
    out->triangles_after = of->plan->n_triangles;
    for (int i = 0; i < of->plan->scene->n_objects; i++)
        if (out->objects[i].after > out->objects[i].before)
            out->objects[out->n_objects++] = out->objects[i];
    return done;
}

/* ---- all of it ---- */

static bool make_shading(struct shading **out, struct error *err)
{
    return MAKE_ARRAY(*out, 1, err, "the error of shading");
}

static bool refine(const struct options *options, struct plan *plan, struct shading **out,
                   struct error *err)
{
    enum { USUAL_TRIANGLES = 4000000 };
    const char *observer = options_detector(options), *scene = plan->scene->path;
    const size_t n = (size_t)plan->scene->n_objects + 1;
    struct refinement of = {.plan = plan};
    enum measure_unit unit;
    if (!options->accuracy)
        return true;
    if (!make_shading(out, err))
        return false;
    of.result = *out;
    **out = (struct shading){.is_refined = true,
                             .most_triangles = options->max_triangles > 0 ? options->max_triangles
                                                                          : USUAL_TRIANGLES,
                             .triangles_before = plan->n_triangles,
                             .triangles_after = plan->n_triangles};
    const bool done =
        read_wanted("--accuracy", options->accuracy, &of.result->wanted, &unit, err) &&
        MAKE_ARRAY(of.halvings, n, err, "the objects of %s", scene) &&
        MAKE_ARRAY(of.result->objects, n, err, "the objects of %s", scene) &&
        measure_make(plan, unit, observer, &of.measure, err) &&
        (of.measure.known ||
         error_usage(err,
                     "--accuracy in CIEDE2000 needs an observer, and %s is none; expected counts, "
                     "as --accuracy 8counts",
                     plan->sampling ? plan->sampling->detector : observer)) &&
        (plan->view.shading == FLAT || divide(&of, err));
    measure_free(&of.measure);
    free(of.halvings);
    return done;
}

static void free_shading(struct shading *shading)
{
    accuracy_estimate_free(&shading->estimate);
    free(shading->objects);
    free(shading);
}

/* ---- the error in words ---- */

/* A difference of 1 CIEDE2000 is about the least that an observer sees. */
static const double just_seen = 1;
/* An object of fewer judged pixels has no quantile to rely on. */
enum { FEWEST_POINTS = 20 };

static const char *unit_of(const struct accuracy_estimate *estimate)
{
    return estimate->unit == MEASURE_COUNTS ? "counts" : "CIEDE2000";
}

/* ---- notes ---- */

/* Adds a note on a refinement that did not reach the wanted error. */
static void note_refined(const struct plan *plan, struct notes *notes)
{
    const struct shading *refined = notes->shading;
    const struct accuracy_estimate *reached = &refined->estimate;
    char name[256], limit[64] = "the finest --tessellation is reached";
    if (reached->n_objects == 0 || reached->objects[0].quantile_95 <= refined->wanted)
        return;
    if (refined->stopped)
        snprintf(limit, sizeof limit, "--max-triangles %ld allows no more",
                 refined->most_triangles);
    object_text(plan, reached->objects[0].surface, name, sizeof name);
    note_add(notes, "accuracy", "the error is still %.3g %s on %s, since %s",
             reached->objects[0].quantile_95, unit_of(reached), name, limit);
}

/* Adds a note on the object whose shading is worst, if it is seen to be wrong. The worst object
 * comes first. */
static void note_shading(const struct plan *plan, struct notes *notes)
{
    const struct accuracy_estimate *shading = &notes->shading->estimate;
    char name[256];
    int worst = 0;
    while (worst < shading->n_objects && shading->objects[worst].points < FEWEST_POINTS)
        worst++;
    if (worst == shading->n_objects || !(shading->objects[worst].quantile_95 > just_seen))
        return;
    object_text(plan, shading->objects[worst].surface, name, sizeof name);
    note_add(notes, "shading",
             "the shading of %s is off by up to %.2g CIEDE2000 at 95 %% of its pixels "
             "(see --accuracy)",
             name, shading->objects[worst].quantile_95);
}

static void print_shading(const struct shading *shading, struct printed *to)
{
    const struct accuracy_estimate *estimate = &shading->estimate;
    if (shading->is_refined && estimate->known)
        print(to,
              "accuracy          %.3g %s at 95 %% of object pixels: %ld triangles became %ld, on "
              "%d object%s\n",
              estimate->quantile_95, unit_of(estimate), shading->triangles_before,
              shading->triangles_after, shading->n_objects, shading->n_objects == 1 ? "" : "s");
    else if (shading->is_refined)
        print_text(to, "accuracy          flat shading is not refined\n");
    else if (estimate->known)
        print(
            to,
            "shading           within %.2g %s of light at every point, at 95 %% of object pixels\n",
            estimate->quantile_95, unit_of(estimate));
}

/* ---- facts ---- */

/* Begins an entry on a surface's object. */
static void open_entry(const struct plan *plan, int surface, struct json *json)
{
    char name[256];
    object_text(plan, surface, name, sizeof name);
    json_open(json, NULL, '{');
    json_string(json, "object", name);
}

enum { WORST_IN_WORDS = 8 }; /* objects; JSON has them all */

static void put_accuracy(const struct plan *plan, const struct shading *shading, struct json *json)
{
    const struct accuracy_estimate *estimate = &shading->estimate;
    json_open(json, "accuracy", '{');
    json_string(json, "unit", unit_of(estimate));
    json_number(json, "error_95", estimate->known ? estimate->quantile_95 : (double)NAN);
    json_count(json, "points", (uint64_t)estimate->n_points);
    json_open(json, "objects", '[');
    for (int i = 0; i < estimate->n_objects && !(json->words && i == WORST_IN_WORDS); i++) {
        open_entry(plan, estimate->objects[i].surface, json);
        json_number(json, "error_95", estimate->objects[i].quantile_95);
        json_count(json, "points", (uint64_t)estimate->objects[i].points);
        json_close(json, '}');
    }
    json_close(json, ']');
    if (shading->is_refined) {
        json_open(json, "refined", '{');
        json_number(json, "wanted", shading->wanted);
        json_number(json, "error_95_before", shading->error_before);
        json_count(json, "triangles_before", (uint64_t)shading->triangles_before);
        json_count(json, "triangles_after", (uint64_t)shading->triangles_after);
        json_count(json, "levels", (uint64_t)shading->levels);
        json_truth(json, "stopped", shading->stopped);
        json_open(json, "objects", '[');
        for (int i = 0; i < shading->n_objects; i++) {
            open_entry(plan, shading->objects[i].surface, json);
            json_count(json, "triangles_before", (uint64_t)shading->objects[i].before);
            json_count(json, "triangles_after", (uint64_t)shading->objects[i].after);
            json_close(json, '}');
        }
        json_close(json, ']');
        json_close(json, '}');
    }
    json_close(json, '}');
}

/* ---- the judge ---- */

/* Estimates the error of a plan that was not refined. Vertices are lit only for smooth shading. */
static bool estimate(const struct lit_scene *lit, int pixels, struct accuracy_estimate *out,
                     struct error *err)
{
    struct measure measure;
    if (lit->plan->view.shading != GOURAUD)
        return true;
    bool done = measure_make(lit->plan, MEASURE_CIEDE2000, "cie1931", &measure, err);
    if (done && measure.known)
        done = accuracy_estimate(&measure, lit->surfaces, pixels, out, err);
    measure_free(&measure);
    return done;
}

static bool judge(const struct lit_scene *lit, int pixels, struct notes *notes, struct error *err)
{
    if (notes->shading && notes->shading->is_refined)
        note_refined(lit->plan, notes);
    else if (!make_shading(&notes->shading, err) ||
             !estimate(lit, pixels, &notes->shading->estimate, err))
        return false;
    else
        note_shading(lit->plan, notes);
    return true;
}

const struct shading_judge accuracy_judge = {.refine = refine,
                                             .judge = judge,
                                             .print = print_shading,
                                             .put = put_accuracy,
                                             .free = free_shading};

static const struct option accuracy_rows[] = {
    {"--accuracy ERROR",
     "at most this error for 95 % of object pixels: CIEDE2000, as 0.5, or counts, as 8counts",
     SHARED(TEXT, accuracy), .accepts = accuracy_accepts, .recorded = true},
    {"--max-triangles N", "--accuracy makes at most N (default: 4000000)",
     SHARED(COUNT, max_triangles), .lowest = 1, .highest = 1 << 30, .needs = "--accuracy",
     .recorded = true},
};
const struct option_list accuracy_options = OPTION_LIST(accuracy_rows);
