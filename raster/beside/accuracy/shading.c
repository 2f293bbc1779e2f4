/* SPDX-License-Identifier: MIT */
/* By how much the shading of objects differs from light at every point. */
#include <math.h>
#include <stdlib.h>

#include "raster/beside/accuracy/inside.h"

/* A difference of 1 CIEDE2000 is about the least that an observer sees. */
static const double just_seen = 1;
/* An object of fewer judged pixels has no quantile to rely on. */
enum { FEWEST_POINTS = 20 };

struct shading {
    bool is_refined;
    struct refine_result refined;
    struct accuracy_estimate estimate; /* unless it was refined */
};

/* Returns the error of the picture as it is drawn. */
static const struct accuracy_estimate *estimate_of(const struct shading *shading)
{
    return shading->is_refined ? &shading->refined.estimate : &shading->estimate;
}

static const char *unit_of(const struct accuracy_estimate *estimate)
{
    return estimate->unit == MEASURE_COUNTS ? "counts" : "CIEDE2000";
}

/* ---- notes ---- */

/* Adds a note on a refinement that did not reach the wanted error. */
static void note_refined(const struct plan *plan, struct notes *notes)
{
    const struct refine_result *refined = &notes->shading->refined;
    const struct accuracy_estimate *reached = &refined->estimate;
    char name[256], limit[64] = "the finest --tessellation is reached";
    if (reached->n_objects == 0 || reached->objects[0].quantile_95 <= refined->wanted.error)
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
    if (notes->shading->is_refined)
        note_refined(plan, notes);
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

static void print_refined(const struct shading *shading, struct printed *to)
{
    const struct refine_result *refined = &shading->refined;
    if (!shading->is_refined)
        return;
    const struct accuracy_estimate *estimate = &refined->estimate;
    if (!estimate->known)
        print_text(to, "accuracy          flat shading is not refined\n");
    else
        print(to,
              "accuracy          %.3g %s at 95 %% of object pixels: %ld triangles became %ld, on "
              "%d object%s\n",
              estimate->quantile_95, unit_of(estimate), refined->triangles_before,
              refined->triangles_after, refined->n_objects, refined->n_objects == 1 ? "" : "s");
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
    const struct accuracy_estimate *estimate = estimate_of(shading);
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
        const struct refine_result *refined = &shading->refined;
        json_open(json, "refined", '{');
        json_number(json, "wanted", refined->wanted.error);
        json_number(json, "error_95_before", refined->error_before);
        json_count(json, "triangles_before", (uint64_t)refined->triangles_before);
        json_count(json, "triangles_after", (uint64_t)refined->triangles_after);
        json_count(json, "levels", (uint64_t)refined->levels);
        json_truth(json, "stopped", refined->stopped);
        json_open(json, "objects", '[');
        for (int i = 0; i < refined->n_objects; i++) {
            open_entry(plan, refined->objects[i].surface, json);
            json_count(json, "triangles_before", (uint64_t)refined->objects[i].before);
            json_count(json, "triangles_after", (uint64_t)refined->objects[i].after);
            json_close(json, '}');
        }
        json_close(json, ']');
        json_close(json, '}');
    }
    json_close(json, '}');
}

/* ---- the judge ---- */

static bool make_shading(struct shading **out, struct error *err)
{
    return MAKE_ARRAY(*out, 1, err, "the error of shading");
}

static bool refine(const struct options *options, struct plan *plan, struct shading **out,
                   struct error *err)
{
    if (!options->accuracy)
        return true;
    if (!make_shading(out, err))
        return false;
    (*out)->is_refined = true;
    return refine_options(options, plan, &(*out)->refined, err);
}

static bool judge(const struct lit_scene *lit, int pixels, struct notes *notes, struct error *err)
{
    if (!notes->shading &&
        (!make_shading(&notes->shading, err) ||
         !accuracy_estimate(lit->plan, lit->surfaces, pixels, &notes->shading->estimate, err)))
        return false;
    note_shading(lit->plan, notes);
    return true;
}

static void free_shading(struct shading *shading)
{
    accuracy_estimate_free(&shading->estimate);
    refine_result_free(&shading->refined);
    free(shading);
}

const struct shading_judge accuracy_judge = {.refine = refine,
                                             .judge = judge,
                                             .print = print_refined,
                                             .put = put_accuracy,
                                             .free = free_shading};

static const struct option accuracy_rows[] = {
    {"--accuracy ERROR",
     "at most this error for 95 % of object pixels: CIEDE2000, as 0.5, or counts, as 8counts",
     SHARED(TEXT, accuracy), .accepts = accuracy_accepts, .recorded = true},
    {"--max-triangles N", "--accuracy makes at most N (default: 4000000)",
     SHARED(COUNT, max_triangles), .lowest = 1, .highest = 1 << 30, .recorded = true},
};
const struct option_list accuracy_options = OPTION_LIST(accuracy_rows);
