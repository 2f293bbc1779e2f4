/* SPDX-License-Identifier: MIT */
/* The facts of a plan, as JSON or in words: its work, each effect with the reason why it is
 * simulated or not, each light, each file; in words also each value that is guessed, not measured.
 */
#include "data/stack/stack.h"
#include "raster/plan/inside.h"

/* ---- work that is left out ---- */

static void put(struct json *json, const char *what, long n, long of, const char *reason)
{
    if (n == 0)
        return;
    json_open(json, NULL, '{');
    json_string(json, "what", what);
    json_count(json, "count", (uint64_t)n);
    json_count(json, "of", (uint64_t)of);
    json_string(json, "reason", reason);
    json_close(json, '}');
}

const char *const view_plane_words[VIEW_PLANES] = {
    [VIEW_LEFT] = "left of the view",      [VIEW_RIGHT] = "right of the view",
    [VIEW_BELOW] = "below the view",       [VIEW_ABOVE] = "above the view",
    [VIEW_NEAR] = "before the near plane", [VIEW_FAR] = "beyond the far plane"};

static void put_instances(struct json *json, const struct plan *plan)
{
    long n[VIEW_PLANES] = {0};
    for (int i = 0; i < plan->n_instances; i++)
        if (!plan->instances[i].in_view)
            n[plan->instances[i].outside]++;
    for (int plane = 0; plane < VIEW_PLANES; plane++)
        put(json, "instances", n[plane], plan->n_instances, view_plane_words[plane]);
}

/* Puts the work that the scene does not call for, as the list "left_out". */
static void put_left_out(const struct plan *plan, struct json *json)
{
    json_open(json, "left_out", '[');
    put_instances(json, plan);
    put(json, "lights", plan->work.idle_lights, plan->n_lights, "they reach no object in view");
    put(json, "groups of lights", plan->work.idle_groups, plan->n_light_groups,
        "no light of theirs reaches an object in view");
    put(json, "textures", plan->work.undrawn_textures, plan->n_textures,
        "only objects out of view have them");
    put(json, "passes", plan->passes.n_dark, plan->n_passes,
        "nothing in view has light in their bands");
    put(json, "passes", plan->passes.n_repeated, plan->n_passes,
        "they show the same as the pass before");
    json_close(json, ']');
}

/* ---- all facts ---- */

static void put_work(struct json *json, const struct plan *plan)
{
    const uint64_t n_groups = (uint64_t)(plan->n_light_groups - plan->work.idle_groups);
    const struct rectangle picture = plan_picture(plan);
    const uint64_t tiles = (uint64_t)plan_tiles(plan, &picture);
    json_open(json, "work", '{');
    json_count(json, "objects", (uint64_t)plan->scene->n_objects);
    json_count(json, "instances", (uint64_t)plan->n_instances);
    json_count(json, "vertices", (uint64_t)plan->n_vertices);
    json_count(json, "triangles", (uint64_t)plan->n_triangles);
    json_count(json, "materials", (uint64_t)plan->n_materials);
    json_count(json, "terms", (uint64_t)plan->work.terms);
    json_count(json, "excitation_integrals", (uint64_t)plan->work.excitation_integrals);
    json_count(json, "tiles", tiles);
    json_count(json, "tile_width", (uint64_t)plan->tile_width);
    json_count(json, "tile_height", (uint64_t)plan->tile_height);
    json_count(json, "passes", n_groups * (uint64_t)plan->passes.n_frames * tiles);
    json_count(json, "tile_bytes", (uint64_t)plan->tile_bytes);
    json_count(json, "file_bytes", plan->file_bytes);
    json_close(json, '}');
}

static void put_effects(struct json *json, const struct plan *plan)
{
    char reason[160];
    json_open(json, "effects", '[');
    for (int i = 0; i < N_EFFECTS; i++) {
        const struct plan_effect *effect = &plan->effects[i];
        const bool used = effect->used > 0;
        if (used && effect->what)
            snprintf(reason, sizeof reason, "%d of %d %s", effect->used, effect->all, effect->what);
        else
            snprintf(reason, sizeof reason, "%s",
                     used ? "the scene asks for it" : effect->otherwise);
        if (json->words) {
            print(&json->printed, "%-17s %s (%s)\n", effect->name, used ? "yes" : "no", reason);
            continue;
        }
        json_open(json, NULL, '{');
        json_string(json, "name", effect->name);
        json_truth(json, "simulated", used);
        json_string(json, "reason", reason);
        json_close(json, '}');
    }
    json_close(json, ']');
}

/* Returns why a light does not shine; NULL: it shines. */
static const char *why_off(const struct plan *plan, const struct light *light)
{
    const struct spectral_pages *pages = &plan->illumination.pages;
    for (int i = 0; i < plan->n_lights; i++)
        if (plan->sources[i] == light)
            return plan->is_idle[i] ? "it reaches no object in view" : NULL;
    return light->intensity == 0                  ? "intensity 0"
           : !pages_show(pages, &light->spectrum) ? "spectrum 0 at every wavelength shown"
                                                  : "no material reflects it";
}

static void put_lights(struct json *json, const struct plan *plan)
{
    json_open(json, "lights", '[');
    for (int i = 0; i < plan->scene->n_lights; i++) {
        const struct light *light = &plan->scene->lights[i];
        json_open(json, NULL, '{');
        json_string(json, "spectrum", light->spectrum.name);
        json_number(json, "intensity", light->intensity);
        json_string(json, "off", why_off(plan, light));
        json_close(json, '}');
    }
    json_close(json, ']');
}

/* Lists "SHA-256 PATH" of each file of the scene. */
bool plan_put_files(const struct plan *plan, const char *detector, struct json *json,
                    struct error *err)
{
    struct inputs inputs;
    const bool done = inputs_list(plan->scene, detector, true, &inputs, err);
    json_strings(json, "files", (const char *const *)inputs.file, done ? inputs.n : 0);
    inputs_free(&inputs);
    return done;
}

/* Prints what triangles lose of each relief. Halves and parts of a mesh follow each other. */
static void print_reliefs(const struct plan *plan, struct printed *to)
{
    for (int i = 0; i < plan->n_meshes; i++) {
        const struct plan_mesh *mesh = &plan->meshes[i];
        const struct shape *shape = &mesh->shape;
        if (shape->relief && (i == 0 || shape->relief != plan->meshes[i - 1].shape.relief))
            print(to,
                  "relief            %s: %.3g texels a triangle of the %s (%s:%d), which misses "
                  "heights by %.2g (rms) of %g\n",
                  shape->relief, mesh->relief_texels, shape_name(shape->kind), shape->place.path,
                  shape->place.line, mesh->relief_missed, shape->relief_height);
    }
}

/* Prints what words have beside the facts: textures, and each value that is guessed. */
static void print_guesses(const struct plan *plan, struct printed *to)
{
    for (int i = 0; i < plan->n_textures; i++) {
        const struct texture *texture = &plan->textures[i];
        print(to, "texture           %s: %d x %d texels, %d levels, %zu bytes a band, %d pages%s\n",
              texture->image.path, texture->image.width, texture->image.height, texture->n_levels,
              texture->plane_size * sizeof(float), texture->image.n_pages,
              texture->spectral && plan->sampling ? ", at the wavelength of each page" : "");
    }
    print_reliefs(plan, to);
    tables_look(plan, to);
    for (int i = 0; i < plan->n_materials; i++) {
        const struct material *material = plan->materials[i].material;
        if (material->from_rgb)
            print(to, "not measured      %s: RGB of %s, spread over three bands\n", material->name,
                  material->path);
    }
}

void scene_put(const struct plan *plan, struct json *json)
{
    const struct scene *scene = plan->scene;
    json_string(json, "scene", scene->path);
    json_string(json, "scene_sha256", scene->sha256);
    json_count(json, "width", (uint64_t)scene->width);
    json_count(json, "height", (uint64_t)scene->height);
    json_count(json, "positions_per_pixel",
               (uint64_t)scene->positions * (uint64_t)scene->positions);
    json_numbers(json, "wavelengths_nm", has_components(plan) ? NULL : scene->wavelengths_nm,
                 scene->n_wavelengths);
}

void plan_facts(const struct plan *plan, struct json *json)
{
    json_string(json, "program", PROGRAM);
    scene_put(plan, json);
    json_count(json, "bands", (uint64_t)plan->n_bands);
    if (json->words && plan->sampling) {
        print_text(&json->printed, "sampling          ");
        sampling_print(plan->sampling, &json->printed);
    }
    put_work(json, plan);
    put_left_out(plan, json);
    put_effects(json, plan);
    put_lights(json, plan);
    if (json->words)
        print_guesses(plan, &json->printed);
}
