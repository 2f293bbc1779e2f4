/* SPDX-License-Identifier: MIT */
/* Prints the plan in words: each effect with the reason why it is simulated or not, each light, and
 * each value that is guessed, not measured. */
#include <stdlib.h>
#include <string.h>

#include "data/inputs/inputs.h"
#include "raster/notes/notes.h"

const char *why_off(const struct plan *plan, const struct light *light, int *shining)
{
    const struct spectral_pages *pages = &plan->illumination.pages;
    if (*shining < plan->n_lights && plan->sources[*shining] == light)
        return plan->is_idle[(*shining)++] ? "it reaches no object in view" : NULL;
    return light->intensity == 0                  ? "intensity 0"
           : !pages_show(pages, &light->spectrum) ? "spectrum 0 at every wavelength shown"
                                                  : "no material reflects it";
}

static void print_lights(const struct plan *plan, struct printed *to)
{
    int shining = 0;
    for (int i = 0; i < plan->scene->n_lights; i++) {
        const struct light *light = &plan->scene->lights[i];
        const char *off = why_off(plan, light, &shining);
        print(to, "light %-11d %s%s (%s, intensity %.6g)\n", i + 1, off ? "off: " : "on",
              off ? off : "", light->spectrum.name, light->intensity);
    }
}

static void print_guesses(const struct plan *plan, struct printed *to)
{
    tables_print(plan, to);
    for (int i = 0; i < plan->n_materials; i++) {
        const struct material *material = plan->materials[i].material;
        if (material->from_rgb)
            print(to, "not measured      %s: RGB of %s, spread over three bands\n", material->name,
                  material->path);
    }
}

void count_work(const struct plan *plan, int passes, struct plan_count out[PLAN_COUNTS])
{
    const struct rectangle picture = plan_picture(plan);
    const uint64_t tiles = (uint64_t)plan_tiles(plan, &picture);
    const struct plan_count counts[PLAN_COUNTS] = {
        {"objects", (uint64_t)plan->scene->n_objects},
        {"instances", (uint64_t)plan->n_instances},
        {"vertices", (uint64_t)plan->n_vertices},
        {"triangles", (uint64_t)plan->n_triangles},
        {"materials", (uint64_t)plan->n_materials},
        {"terms", (uint64_t)plan->work.terms},
        {"excitation_integrals", (uint64_t)plan->work.excitation_integrals},
        {"tiles", tiles},
        {"passes", (uint64_t)passes * tiles},
        {"tile_bytes", (uint64_t)plan->tile_bytes},
        {"file_bytes", plan->file_bytes}};
    memcpy(out, counts, sizeof counts);
}

static void print_work(const struct plan *plan, const struct left_out_list *left_out,
                       struct printed *to)
{
    struct plan_count counts[PLAN_COUNTS];
    count_work(plan, left_out->drawn_passes, counts);
    for (int i = 0; i < PLAN_COUNTS; i++)
        print(to, "%-17s %llu\n", counts[i].name, (unsigned long long)counts[i].n);
    for (int i = 0; i < left_out->n; i++)
        print(to, "left out          %ld of %ld %s (%s)\n", left_out->list[i].n,
              left_out->list[i].of, left_out->list[i].what, left_out->list[i].reason);
}

static void print_bands(const struct plan *plan, struct printed *to)
{
    const struct scene *scene = plan->scene;
    if (has_components(plan))
        print(to, "bands             %d (components)\n", plan->n_bands);
    else
        print(to, "bands             %d (%.10g to %.10g nm)\n", plan->n_bands,
              scene->wavelengths_nm[0], scene->wavelengths_nm[plan->n_bands - 1]);
    if (plan->sampling) {
        print(to, "sampling          ");
        sampling_print(plan->sampling, to);
    }
}

bool plan_files(const struct plan *plan, char **text, int *n, struct error *err)
{
    struct inputs inputs;
    struct printed printed = {.text = NULL};
    const bool done = inputs_all(plan->scene, plan->options.detector, &inputs, err) &&
                      inputs_digest(&inputs, &printed, err);
    *n = inputs.n;
    inputs_free(&inputs);
    *text = printed_end(&printed);
    return done && (*text || error_memory(err));
}

static bool print_files(const struct plan *plan, struct printed *to, struct error *err)
{
    char *text;
    int n;
    const bool done = plan_files(plan, &text, &n, err);
    for (const char *at = text; done && n-- > 0; at += strlen(at) + 1)
        print(to, "file              %s\n", at);
    free(text);
    return done;
}

bool plan_print(const struct plan *plan, struct printed *to, struct error *err)
{
    const struct scene *scene = plan->scene;
    struct left_out_list left_out;
    if (!left_out_make(plan, &left_out, err))
        return false;
    print(to, "scene             %s\n", scene->path);
    print(to, "picture           %d x %d pixels", scene->width, scene->height);
    if (scene->positions > 1)
        print(to, " of %d x %d positions", scene->positions, scene->positions);
    print_text(to, "\n");
    print_bands(plan, to);
    print_work(plan, &left_out, to);
    for (int i = 0; i < plan->n_effects; i++)
        print(to, "%-17s %s (%s)\n", plan->effects[i].name, plan->effects[i].used ? "yes" : "no",
              plan->effects[i].reason);
    print_lights(plan, to);
    print_guesses(plan, to);
    return print_files(plan, to, err);
}
