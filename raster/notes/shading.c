/* SPDX-License-Identifier: MIT */
/* By how much the shading of objects differs from light at every point, in words. */
#include <math.h>

#include "raster/notes/notes.h"

/* A difference of 1 CIEDE2000 is about the least that an observer sees. */
static const double just_seen = 1;
/* An object of fewer judged pixels has no quantile to rely on. */
enum { FEWEST_POINTS = 20 };

/* Returns the error of the picture as it is drawn. */
static const struct accuracy_estimate *estimate_of(const struct notes *notes)
{
    const struct refine_result *refined = notes->refined;
    return refined ? &refined->estimate : &notes->shading;
}

static const char *unit_of(const struct accuracy_estimate *estimate)
{
    return estimate->unit == MEASURE_COUNTS ? "counts" : "CIEDE2000";
}

/* ---- notes ---- */

/* Adds a note on a refinement that did not reach the wanted error. */
static void note_refined(const struct plan *plan, struct notes *notes)
{
    const struct refine_result *refined = notes->refined;
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

void note_shading(const struct plan *plan, struct notes *notes)
{
    const struct accuracy_estimate *shading = &notes->shading;
    const struct accuracy_object *worst = NULL;
    char name[256];
    int n = 0;
    if (notes->refined)
        note_refined(plan, notes);
    for (int i = 0; i < shading->n_objects; i++) {
        const struct accuracy_object *object = &shading->objects[i];
        if (!(object->quantile_95 > just_seen) || object->points < FEWEST_POINTS)
            continue;
        worst = worst ? worst : object;
        n++;
    }
    if (!worst)
        return;
    object_text(plan, worst->surface, name, sizeof name);
    note_add(notes, "shading",
             "the shading of %s%s is off by up to %.2g CIEDE2000 at 95 %% of its pixels "
             "(see --accuracy)",
             name, n > 1 ? ", the worst of several objects," : "", worst->quantile_95);
}

/* ---- in words ---- */

void refined_print(const struct notes *notes, struct printed *to)
{
    const struct refine_result *refined = notes->refined;
    if (!refined)
        return;
    const struct accuracy_estimate *estimate = estimate_of(notes);
    if (!estimate->known)
        print_text(to, "accuracy          flat shading is not refined\n");
    else if (refined->levels == 0)
        print(to, "accuracy          %.3g %s at 95 %% of object pixels, without refinement\n",
              estimate->quantile_95, unit_of(estimate));
    else
        print(to,
              "accuracy          %.3g %s at 95 %% of object pixels: %ld triangles became %ld, on "
              "%d object%s\n",
              estimate->quantile_95, unit_of(estimate), refined->triangles_before,
              refined->triangles_after, refined->n_objects, refined->n_objects == 1 ? "" : "s");
}

/* Prints at most so many lines for objects, and one for the others. */
enum { MOST_LINES = 8 };

static void print_others(int n, const char *what, struct printed *to)
{
    if (n > MOST_LINES)
        print(to, "                  and %s on %d more objects\n", what, n - MOST_LINES);
}

void shading_print(const struct plan *plan, const struct notes *notes, struct printed *to)
{
    const struct accuracy_estimate *shading = estimate_of(notes);
    const struct refine_result *refined = notes->refined;
    char name[256];
    if (!shading->known)
        return;
    print(to, "shading error     %.3g %s at 95 %% of object pixels, judged at %d\n",
          shading->quantile_95, unit_of(shading), shading->n_points);
    for (int i = 0; i < shading->n_objects && i < MOST_LINES; i++) {
        object_text(plan, shading->objects[i].surface, name, sizeof name);
        print(to, "                  %.3g on %s\n", shading->objects[i].quantile_95, name);
    }
    print_others(shading->n_objects, "less", to);
    for (int i = 0; refined && i < refined->n_objects && i < MOST_LINES; i++) {
        const struct refined_object *object = &refined->objects[i];
        object_text(plan, object->surface, name, sizeof name);
        print(to, "%s%ld triangles became %ld on %s\n",
              i == 0 ? "refined           " : "                  ", object->before, object->after,
              name);
    }
    print_others(refined ? refined->n_objects : 0, "more", to);
}

/* ---- as JSON ---- */

static void json_objects(const struct plan *plan, const struct accuracy_estimate *shading,
                         struct json *json)
{
    char name[256];
    json_open(json, "objects", '[');
    for (int i = 0; i < shading->n_objects; i++) {
        const struct accuracy_object *object = &shading->objects[i];
        object_text(plan, object->surface, name, sizeof name);
        json_open(json, NULL, '{');
        json_string(json, "object", name);
        json_number(json, "error_95", object->quantile_95);
        json_count(json, "points", (uint64_t)object->points);
        json_close(json, '}');
    }
    json_close(json, ']');
}

static void json_refined(const struct plan *plan, const struct refine_result *refined,
                         struct json *json)
{
    char name[256];
    json_open(json, "refined", '{');
    json_number(json, "wanted", refined->wanted.error);
    json_number(json, "error_95_before", refined->error_before);
    json_count(json, "triangles_before", (uint64_t)refined->triangles_before);
    json_count(json, "triangles_after", (uint64_t)refined->triangles_after);
    json_count(json, "levels", (uint64_t)refined->levels);
    json_truth(json, "stopped", refined->stopped);
    json_open(json, "objects", '[');
    for (int i = 0; i < refined->n_objects; i++) {
        object_text(plan, refined->objects[i].surface, name, sizeof name);
        json_open(json, NULL, '{');
        json_string(json, "object", name);
        json_count(json, "triangles_before", (uint64_t)refined->objects[i].before);
        json_count(json, "triangles_after", (uint64_t)refined->objects[i].after);
        json_close(json, '}');
    }
    json_close(json, ']');
    json_close(json, '}');
}

void accuracy_json(const struct plan *plan, const struct notes *notes, struct json *json)
{
    const struct accuracy_estimate *shading = estimate_of(notes);
    json_open(json, "accuracy", '{');
    json_string(json, "unit", unit_of(shading));
    json_number(json, "error_95", shading->known ? shading->quantile_95 : (double)NAN);
    json_count(json, "points", (uint64_t)shading->n_points);
    json_objects(plan, shading, json);
    if (notes->refined)
        json_refined(plan, notes->refined, json);
    json_close(json, '}');
}
