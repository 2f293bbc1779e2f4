/* SPDX-License-Identifier: MIT */
/* The plan as JSON. */
#include <stdlib.h>
#include <string.h>

#include "raster/notes/notes.h"

static void json_effect(struct json *json, const struct plan_effect *effect)
{
    json_open(json, NULL, '{');
    json_string(json, "name", effect->name);
    json_truth(json, "simulated", effect->used);
    json_string(json, "reason", effect->reason);
    json_close(json, '}');
}

static void json_work(struct json *json, const struct plan *plan, int passes)
{
    struct plan_count counts[PLAN_COUNTS];
    count_work(plan, passes, counts);
    json_open(json, "work", '{');
    for (int i = 0; i < PLAN_COUNTS; i++)
        json_count(json, counts[i].name, counts[i].n);
    json_close(json, '}');
}

static void json_left_out(struct json *json, const struct left_out_list *left_out)
{
    json_open(json, "left_out", '[');
    for (int i = 0; i < left_out->n; i++) {
        json_open(json, NULL, '{');
        json_string(json, "what", left_out->list[i].what);
        json_count(json, "count", (uint64_t)left_out->list[i].n);
        json_count(json, "of", (uint64_t)left_out->list[i].of);
        json_string(json, "reason", left_out->list[i].reason);
        json_close(json, '}');
    }
    json_close(json, ']');
}

static void json_lights(struct json *json, const struct plan *plan)
{
    int shining = 0;
    json_open(json, "lights", '[');
    for (int i = 0; i < plan->scene->n_lights; i++) {
        const struct light *light = &plan->scene->lights[i];
        json_open(json, NULL, '{');
        json_string(json, "spectrum", light->spectrum.name);
        json_number(json, "intensity", light->intensity);
        json_string(json, "off", why_off(plan, light, &shining));
        json_close(json, '}');
    }
    json_close(json, ']');
}

static void json_files(struct json *json, const char *files, int n)
{
    json_open(json, "files", '[');
    for (; n > 0; n--, files += strlen(files) + 1)
        json_string(json, NULL, files);
    json_close(json, ']');
}

bool plan_json(const struct plan *plan, const struct notes *notes, struct json *json,
               struct error *err)
{
    const struct scene *scene = plan->scene;
    struct left_out_list left_out;
    char *files = NULL;
    int n_files;
    if (!left_out_make(plan, &left_out, err) || !plan_files(plan, &files, &n_files, err)) {
        free(files);
        return false;
    }
    json_begin(json);
    json_string(json, "program", PROGRAM);
    json_string(json, "scene", scene->path);
    json_string(json, "scene_sha256", scene->sha256);
    json_count(json, "width", (uint64_t)scene->width);
    json_count(json, "height", (uint64_t)scene->height);
    json_count(json, "positions_per_pixel",
               (uint64_t)scene->positions * (uint64_t)scene->positions);
    json_count(json, "bands", (uint64_t)plan->n_bands);
    json_numbers(json, "wavelengths_nm", has_components(plan) ? NULL : scene->wavelengths_nm,
                 scene->n_wavelengths);
    json_work(json, plan, left_out.drawn_passes);
    json_left_out(json, &left_out);
    json_open(json, "effects", '[');
    for (int i = 0; i < plan->n_effects; i++)
        json_effect(json, &plan->effects[i]);
    json_close(json, ']');
    json_lights(json, plan);
    accuracy_json(plan, notes, json);
    notes_json(notes, json);
    json_files(json, files, n_files);
    free(files);
    return true;
}
