/* SPDX-License-Identifier: MIT */
/* Divides the objects of a plan until its picture is as accurate as is wanted; and by how much the
 * shading of objects differs from light at every point, in words. */
#include "raster/beside/accuracy/inside.h"

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

struct shading {
    struct accuracy_estimate estimate; /* of the plan as it is now */
    bool is_refined;                   /* otherwise all that follows is zeroed */
    double wanted;                     /* error that 95 % of the pixels of each object may have */
    long most_triangles;               /* that the picture may have */
    double error_before;               /* quantile_95 of the plan that came in */
    int levels;                        /* how often all objects were divided */
    long triangles_before, triangles_after; /* of the plan */
    bool stopped; /* most_triangles allows no more, though an object is not good enough */
};

/* A difference of 1 CIEDE2000 is about the least that an observer sees. */
static const double just_seen = 1;
/* An object of fewer judged pixels has no quantile to rely on. */
enum { FEWEST_POINTS = 20 };

/* Returns the object whose shading is worst; without an error: none has enough pixels. The worst
 * one comes first. */
static const struct accuracy_object *worst_of(const struct accuracy_estimate *estimate)
{
    static const struct accuracy_object none = {.quantile_95 = 0};
    for (int i = 0; i < estimate->n_objects; i++)
        if (estimate->objects[i].points >= FEWEST_POINTS)
            return &estimate->objects[i];
    return &none;
}

/* Judges the picture of a plan. */
static bool look(const struct plan *plan, const char *observer, struct accuracy_estimate *out,
                 struct error *err)
{
    enum { REFINED_PIXELS = 8192 };
    const bool flat = plan->view.shading == FLAT;
    struct lit_scene lit = {.plan = plan};
    const bool done = (flat || (lit_make(plan, driver_of(NULL), &lit, err) &&
                                (out->unit != MEASURE_COUNTS || find_full_scale(&lit, err)))) &&
                      accuracy_estimate(&lit, observer, REFINED_PIXELS, out, err);
    lit_free(&lit);
    if (done && !out->known)
        return error_usage(
            err,
            "--accuracy in CIEDE2000 needs an observer, and %s is none; expected counts, "
            "as --accuracy 8counts",
            plan->sampling ? plan->sampling->detector : observer);
    out->known = !flat;
    return done;
}

/* ---- division ---- */

/* Divides all objects of a plan, which is made once more, if it has more triangles then, and no
 * more than result->most_triangles. *divided: it was. */
static bool divide(struct plan *plan, struct shading *result, bool *divided, struct error *err)
{
    struct plan_options options = plan->options;
    struct plan finer = {.scene = NULL};
    /* most triangles become four: more than that are not tried */
    result->stopped = 4 * plan->n_triangles > result->most_triangles;
    options.halvings++;
    const bool done =
        result->stopped || plan_make(plan->scene, plan->sampling, &options, &finer, err);
    result->stopped = result->stopped || finer.n_triangles > result->most_triangles;
    *divided = done && !result->stopped && finer.n_triangles > plan->n_triangles;
    plan_free(*divided ? plan : &finer);
    if (*divided)
        *plan = finer;
    return done;
}

/* Divides all objects until each is good enough, or they can be divided no more. */
static bool refine(const struct options *options, struct plan *plan, struct shading **out,
                   struct error *err)
{
    enum { USUAL_TRIANGLES = 1000000 };
    const char *observer = options_detector(options);
    if (!options->accuracy)
        return true;
    if (!MAKE_ARRAY(*out, 1, err, "the error of shading"))
        return false;
    struct shading *of = *out;
    of->is_refined = true;
    of->most_triangles = options->max_triangles > 0 ? options->max_triangles : USUAL_TRIANGLES;
    of->triangles_before = plan->n_triangles;
    bool divided = true;
    bool done =
        read_wanted("--accuracy", options->accuracy, &of->wanted, &of->estimate.unit, err) &&
        look(plan, observer, &of->estimate, err);
    of->error_before = of->estimate.quantile_95;
    while (done && divided && worst_of(&of->estimate)->quantile_95 > of->wanted) {
        done = divide(plan, of, &divided, err) &&
               (!divided || look(plan, observer, &of->estimate, err));
        of->levels += divided;
    }
    of->triangles_after = plan->n_triangles;
    return done;
}

static void free_shading(struct shading *shading)
{
    free(shading->estimate.objects);
    free(shading);
}

/* ---- the error in words ---- */

static const char *unit_of(const struct accuracy_estimate *estimate)
{
    return estimate->unit == MEASURE_COUNTS ? "counts" : "CIEDE2000";
}

/* ---- notes ---- */

/* Adds a note on a refinement that did not reach the wanted error. */
static void note_refined(const struct plan *plan, struct notes *notes)
{
    const struct shading *refined = notes->shading;
    const struct accuracy_object *worst = worst_of(&refined->estimate);
    char name[256], limit[64] = "the finest --tessellation is reached";
    if (worst->quantile_95 <= refined->wanted)
        return;
    if (refined->stopped)
        snprintf(limit, sizeof limit, "--max-triangles %ld allows no more",
                 refined->most_triangles);
    object_text(plan, worst->surface, name, sizeof name);
    note_add(notes, "accuracy", "the error is still %.3g %s on %s, since %s", worst->quantile_95,
             unit_of(&refined->estimate), name, limit);
}

/* Adds a note on the object that has most points on triangles smaller than a pixel, where a quarter
 * of the triangles would do well: errors of shading grow as areas do. */
static void note_fine(const struct plan *plan, struct notes *notes)
{
    const struct accuracy_estimate *of = &notes->shading->estimate;
    const struct accuracy_object *finest = NULL;
    char name[256];
    for (int i = 0; i < of->n_objects; i++)
        if (of->objects[i].points >= FEWEST_POINTS &&
            2 * of->objects[i].n_fine > of->objects[i].points &&
            8 * of->objects[i].quantile_95 <= just_seen &&
            (!finest || of->objects[i].n_fine > finest->n_fine))
            finest = &of->objects[i];
    if (!finest)
        return;
    object_text(plan, finest->surface, name, sizeof name);
    note_add(notes, "fine",
             "the triangles of %s are smaller than a pixel: a quarter of them would be off by some "
             "%.2g CIEDE2000, and take less time",
             name, 4 * finest->quantile_95);
}

/* Adds a note on the object whose shading is worst, if it is seen to be wrong. */
static void note_shading(const struct plan *plan, struct notes *notes)
{
    const struct accuracy_object *worst = worst_of(&notes->shading->estimate);
    char name[256];
    if (!(worst->quantile_95 > just_seen)) {
        note_fine(plan, notes);
        return;
    }
    object_text(plan, worst->surface, name, sizeof name);
    note_add(notes, "shading",
             "the shading of %s is off by up to %.2g CIEDE2000 at 95 %% of its pixels "
             "(see --accuracy)",
             name, worst->quantile_95);
}

static void print_shading(const struct shading *shading, struct printed *to)
{
    const struct accuracy_estimate *estimate = &shading->estimate;
    if (shading->is_refined && estimate->known)
        print(to, "accuracy          %.3g %s at 95 %% of object pixels: %ld triangles became %ld\n",
              estimate->quantile_95, unit_of(estimate), shading->triangles_before,
              shading->triangles_after);
    else if (shading->is_refined)
        print_text(to, "accuracy          flat shading is not refined\n");
    else if (estimate->known)
        print(
            to,
            "shading           within %.2g %s of light at every point, at 95 %% of object pixels\n",
            estimate->quantile_95, unit_of(estimate));
}

/* ---- facts ---- */

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
        char name[256];
        object_text(plan, estimate->objects[i].surface, name, sizeof name);
        json_open(json, NULL, '{');
        json_string(json, "object", name);
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
        json_close(json, '}');
    }
    json_close(json, '}');
}

/* ---- the judge ---- */

/* A plan that was not refined is judged where vertices are lit: for smooth shading. */
static bool judge(const struct lit_scene *lit, int pixels, struct notes *notes, struct error *err)
{
    if (notes->shading && notes->shading->is_refined)
        note_refined(lit->plan, notes);
    else if (!MAKE_ARRAY(notes->shading, 1, err, "the error of shading") ||
             (lit->plan->view.shading == GOURAUD &&
              !accuracy_estimate(lit, "cie1931", pixels, &notes->shading->estimate, err)))
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
    {"--max-triangles N", "--accuracy makes at most N (default: 1000000)",
     SHARED(COUNT, max_triangles), .lowest = 1, .highest = 1 << 30, .needs = "--accuracy",
     .recorded = true},
};
const struct option_list accuracy_options = OPTION_LIST(accuracy_rows);
