/* SPDX-License-Identifier: MIT */
/* By how much the shading of objects differs from light at every point. */
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

/* The worst object comes first. */
void note_shading(const struct plan *plan, struct notes *notes)
{
    const struct accuracy_estimate *shading = &notes->shading;
    char name[256];
    int worst = 0;
    if (notes->refined)
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

void refined_print(const struct notes *notes, struct printed *to)
{
    const struct refine_result *refined = notes->refined;
    if (!refined)
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

static void put_refined(const struct plan *plan, const struct refine_result *refined,
                        struct json *json)
{
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

enum { WORST_IN_WORDS = 8 }; /* objects; JSON has them all */

void accuracy_put(const struct plan *plan, const struct notes *notes, struct json *json)
{
    const struct accuracy_estimate *shading = estimate_of(notes);
    json_open(json, "accuracy", '{');
    json_string(json, "unit", unit_of(shading));
    json_number(json, "error_95", shading->known ? shading->quantile_95 : (double)NAN);
    json_count(json, "points", (uint64_t)shading->n_points);
    json_open(json, "objects", '[');
    for (int i = 0; i < shading->n_objects && !(json->words && i == WORST_IN_WORDS); i++) {
        open_entry(plan, shading->objects[i].surface, json);
        json_number(json, "error_95", shading->objects[i].quantile_95);
        json_count(json, "points", (uint64_t)shading->objects[i].points);
        json_close(json, '}');
    }
    json_close(json, ']');
    if (notes->refined)
        put_refined(plan, notes->refined, json);
    json_close(json, '}');
}
