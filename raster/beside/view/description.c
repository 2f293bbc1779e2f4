/* SPDX-License-Identifier: MIT */
/* Describes a drawn scene to the page, as JSON: spectra, lights, objects, detectors.
 *
 * Local illumination is linear: the radiance of a pixel is a sum of weights times spectra. Weights
 * depend on geometry only; spectra are products of light and material. The page contains the
 * weights as planes and the spectra as JSON, and multiplies them itself. Luminescence
 * depends on wavelengths outside the picture, so it is computed here for every illuminant that the
 * page offers.
 */
#include "raster/beside/view/inside.h"

/* ---- spectra and rows of numbers as JSON ---- */

/* A description is put to its end, also after a failure, which *err keeps: json_take then returns
 * no text. */
struct describer {
    const struct plan *plan;
    struct json json;
    struct spectrum *illuminants; /* that the page offers; the first n_owned are owned */
    int n_illuminants, n_owned;
    double *row; /* room for a number a band; owned */
    struct error *err;
};

/* Puts three rows of n numbers each. */
static void json_rows(struct json *json, const char *key, const double *rows, int n)
{
    json_open(json, key, '[');
    for (size_t i = 0; i < 3; i++)
        json_numbers(json, NULL, rows + i * (size_t)n, n);
    json_close(json, ']');
}

/* Puts a spectrum at the picture's wavelengths, unless it is absent. */
static void put_spectrum(struct describer *describer, const char *key,
                         const struct spectrum *spectrum, enum spectrum_ends ends)
{
    const struct plan *plan = describer->plan;
    if (spectrum->kind == SPECTRUM_NONE)
        return;
    for (int i = 0; i < plan->n_bands; i++)
        describer->row[i] = spectrum_at(spectrum, plan->scene->wavelengths_nm[i], ends);
    json_numbers(&describer->json, key, describer->row, plan->n_bands);
}

/* Puts the place of a statement: its file and its line. */
static void put_place(struct json *json, const struct place *place)
{
    json_string(json, "file", place->path);
    json_count(json, "line", (uint64_t)place->line);
}

static void put_vector(struct json *json, const char *key, struct vector v)
{
    const double values[3] = {v.x, v.y, v.z};
    json_numbers(json, key, values, 3);
}

/* ---- illuminants ---- */

static bool same_illuminant(const struct spectrum *a, const struct spectrum *b)
{
    size_t size = (size_t)a->count * sizeof *a->value;
    return strcmp(a->name, b->name) == 0 && a->kind == b->kind && a->count == b->count &&
           (size == 0 || (memcmp(a->value, b->value, size) == 0 &&
                          memcmp(a->wavelength_nm, b->wavelength_nm, size) == 0));
}

/* Returns the number of an illuminant. Adds it if it is new. Returns -1 after an error. */
static int find_illuminant(struct describer *describer, const struct spectrum *spectrum)
{
    for (int i = 0; i < describer->n_illuminants; i++)
        if (same_illuminant(&describer->illuminants[i], spectrum))
            return i;
    return array_add(&describer->illuminants, &describer->n_illuminants, spectrum, sizeof *spectrum,
                     describer->err)
               ? describer->n_illuminants - 1
               : -1;
}

static void add_builtin(struct describer *describer, const char *name)
{
    struct word word = {.start = name, .length = strlen(name)};
    struct spectrum spectrum;
    if (!spectrum_read(&word, 0, HUGE_VAL, &spectrum, describer->err))
        return;
    if (find_illuminant(describer, &spectrum) < 0)
        spectrum_free(&spectrum);
    describer->n_owned = describer->n_illuminants;
}

/* Finds the next built-in table, of a detector or an illuminant, from file *at on. Returns false
 * behind the last one. */
static bool next_table(size_t *at, bool detector, char name[BUILTIN_NAME])
{
    for (; *at < builtin_file_count; ++*at)
        if (table_is_detector(&builtin_files[*at]) == detector &&
            builtin_name(&builtin_files[*at], "tables/", ".csv", name))
            return true;
    return false;
}

/* Adds equal energy and the built-in illuminants. */
static void add_builtins(struct describer *describer)
{
    char name[BUILTIN_NAME];
    add_builtin(describer, "e");
    for (size_t i = 0; next_table(&i, false, name); i++)
        add_builtin(describer, name);
}

/* Puts the word by which a command line names the spectrum. The path of a scene's file is relative
 * to the working folder. */
static void put_word(struct describer *describer, const struct spectrum *spectrum)
{
    char *word = spectrum->path ? file_relative(spectrum->place.path, spectrum->name) : NULL;
    if (spectrum->path && !word)
        memory_lacks(describer->err, (double)strlen(spectrum->name), "the name of a file");
    json_string(&describer->json, "word", word ? word : spectrum->name);
    free(word);
}

static void put_illuminants(struct describer *describer)
{
    struct json *json = &describer->json;
    json_open(json, "illuminants", '[');
    for (int i = 0; i < describer->n_illuminants; i++) {
        json_open(json, NULL, '{');
        json_string(json, "name", describer->illuminants[i].name);
        put_word(describer, &describer->illuminants[i]);
        put_spectrum(describer, "radiance", &describer->illuminants[i], SPECTRUM_ZERO);
        json_close(json, '}');
    }
    json_close(json, ']');
}

/* Puts n lights: the place of each in the scene's text, if it has one, and its direction or
 * position. Adds its illuminant if that is new. */
static void put_lights(struct describer *describer, const char *key, const struct light *lights,
                       int n, bool ambient)
{
    struct json *json = &describer->json;
    json_open(json, key, '[');
    for (int i = 0; i < n; i++) {
        const struct light *light = &lights[i];
        json_open(json, NULL, '{');
        json_number(json, "illuminant", find_illuminant(describer, &light->spectrum));
        json_number(json, "intensity", light->intensity);
        if (light->place.path)
            put_place(json, &light->place);
        if (!ambient) {
            put_vector(json, light->directional ? "direction" : "position", light->position);
            json_truth(json, "shadows", light->shadows);
        }
        json_close(json, '}');
    }
    json_close(json, ']');
}

/* ---- surfaces ---- */

/* Puts the luminescence of a material under each illuminant. */
static void put_luminescence(struct describer *describer, const struct material *material)
{
    const struct plan *plan = describer->plan;
    json_open(&describer->json, "luminescence", '[');
    for (int i = 0; i < describer->n_illuminants; i++)
        if (material_luminescence(&plan->illumination.pages, material, &describer->illuminants[i],
                                  describer->row, describer->err))
            json_numbers(&describer->json, NULL, describer->row, plan->n_bands);
    json_close(&describer->json, ']');
}

/* Puts the part that each page of a spectral texture has in each band. */
static void put_texture(struct describer *describer, const struct texture *texture)
{
    struct spectrum part = {.kind = SPECTRUM_SAMPLED,
                            .factor = 1,
                            .count = texture->image.n_pages,
                            .wavelength_nm = texture->image.wavelengths_nm};
    if (!MAKE_ARRAY(part.value, (size_t)part.count, describer->err, "the spectra of a page"))
        return;
    json_open(&describer->json, "texture", '[');
    for (int i = 0; i < part.count; i++) {
        part.value[i] = 1;
        put_spectrum(describer, NULL, &part, SPECTRUM_HOLD);
        part.value[i] = 0;
    }
    json_close(&describer->json, ']');
    free(part.value);
}

/* Puts the spectra of a shaded material. Specular light has the light's own colour by default. */
static void put_material(struct describer *describer, const struct shaded_material *shaded)
{
    static const struct spectrum plastic = {
        .kind = SPECTRUM_CONSTANT, .parameter = {1, 0}, .factor = 1};
    const struct material *material = shaded->material;
    json_open(&describer->json, NULL, '{');
    put_spectrum(describer, "diffuse", &material->diffuse, SPECTRUM_HOLD);
    if (material->gloss > 0)
        put_spectrum(describer, "specular",
                     material->specular.kind != SPECTRUM_NONE ? &material->specular : &plastic,
                     SPECTRUM_HOLD);
    put_spectrum(describer, "glow", &material->glow, SPECTRUM_ZERO);
    put_spectrum(describer, "excitation", &material->excitation, SPECTRUM_ZERO);
    put_spectrum(describer, "emission", &material->emission, SPECTRUM_ZERO);
    if (shaded->texture && shaded->texture->spectral)
        put_texture(describer, shaded->texture);
    if (material->excitation.kind != SPECTRUM_NONE || material->donaldson)
        put_luminescence(describer, material);
    json_close(&describer->json, '}');
}

static void put_surfaces(struct describer *describer)
{
    const struct plan *plan = describer->plan;
    const struct vector own_origin = {0, 0, 0};
    const struct material *right = NULL; /* the right half of an object follows its left half */
    struct json *json = &describer->json;
    json_open(json, "shaded_materials", '[');
    for (int i = 0; i < plan->n_materials; i++)
        put_material(describer, &plan->materials[i]);
    json_close(json, ']');
    json_open(json, "objects", '[');
    for (int i = 0; i < plan->n_instances; i++) {
        const struct object *object = plan->instances[i].object;
        const struct material *own = plan->materials[plan->instances[i].shaded].material,
                              *partner = scene_partner(plan->scene, own);
        json_open(json, NULL, '{');
        json_string(json, "name", object_name(plan, i));
        json_string(json, "shape", shape_name(object->shape.kind));
        json_string(json, "half", partner ? "left" : own == right ? "right" : NULL);
        right = partner;
        json_count(json, "shaded_material", (uint64_t)plan->instances[i].shaded);
        json_count(json, "object", (uint64_t)(object - plan->scene->objects));
        json_string(json, "material_file", own->path);
        put_place(json, &object->place);
        put_vector(json, "origin", matrix_point(&object->transform, own_origin));
        json_close(json, '}');
    }
    json_close(json, ']');
}

/* ---- detectors, adaptations and displays ---- */

/* Puts a detector and its weights. Leaves out one that cannot see the cube. */
static void put_detector(const struct cube *cube, bool is_stack, const char *name,
                         struct json *json, struct error *err)
{
    const struct seeing by = {.detector = name};
    struct sight sight = {.weights = NULL};
    if (sight_make(cube, SIGHT_RELATIVE, &by, &sight, err)) {
        json_open(json, NULL, '{');
        json_string(json, "name", name);
        json_truth(json, "observer", sight.detector.observer);
        json_rows(json, "weights", sight.weights, cube->image.n_pages);
        json_numbers(json, "lost", sight.lost, 3);
        if (is_stack) {
            json_numbers(json, "equal", sight.equal, 3);
            json_numbers(json, "of_white", sight.white, sight.has_white ? 3 : 0);
        }
        json_close(json, '}');
    }
    sight_free(&sight);
}

/* Puts the matrix from XYZ to the cone responses in which each kind adapts, and the matrix from
 * adapted responses, which are 1 to the white, to XYZ under the display's white. */
static void put_adaptations(struct json *json)
{
    json_open(json, "adaptations", '[');
    for (int i = ADAPTATION_NONE; i <= ADAPTATION_CAT16; i++) {
        enum adaptation_kind kind = (enum adaptation_kind)i;
        double cones[3][3], back[3][3], white[3];
        json_open(json, NULL, '{');
        json_string(json, "name", adaptation_names[kind]);
        json_truth(json, "incomplete", kind == ADAPTATION_FAIRCHILD);
        if (kind != ADAPTATION_NONE) {
            adaptation_cones(kind, cones);
            tristimulus_inverse(cones, back);
            tristimulus_apply(cones, display_white, white);
            for (int k = 0; k < 9; k++)
                back[k / 3][k % 3] *= white[k % 3];
            json_rows(json, "cones", (const double *)cones, 3);
            json_rows(json, "from_cones", (const double *)back, 3);
        }
        json_close(json, '}');
    }
    json_close(json, ']');
}

/* Returns the least linear value that is shown as this 8-bit code. */
static double code_step(const struct display *of, int channel, int code)
{
    double below = 0, at = display_largest(of, channel);
    for (double middle = at / 2; middle > below && middle < at; middle = below + (at - below) / 2)
        if (display_encode(of, channel, middle) * 255 + 0.5 >= code)
            at = middle;
        else
            below = middle;
    return at;
}

/* Puts a display. A tone curve is a list of its 255 steps. */
static void put_display(const char *name, struct json *json, struct error *err)
{
    struct display display;
    double largest[3], steps[3][255];
    if (!display_read(name, &display, err))
        return;
    for (int c = 0; c < 3; c++) {
        largest[c] = display_largest(&display, c);
        for (int code = 1; code <= 255; code++)
            steps[c][code - 1] = code_step(&display, c, code);
    }
    json_open(json, NULL, '{');
    json_string(json, "name", name);
    json_rows(json, "matrix", (const double *)display.matrix, 3);
    json_numbers(json, "largest", largest, 3);
    json_rows(json, "steps", (const double *)steps, 255);
    json_close(json, '}');
}

void put_eyes(const struct cube *cube, bool is_stack, const struct options *options,
              struct json *json, struct error *err)
{
    const char *chosen = options->detector, *display = options->display;
    char name[BUILTIN_NAME];
    json_string(json, "detector", chosen);
    json_open(json, "detectors", '[');
    if (chosen)
        put_detector(cube, is_stack, chosen, json, err);
    for (size_t i = 0; next_table(&i, true, name); i++) {
        struct error refused = {.status = EXIT_AGREED};
        if (!chosen || strcmp(chosen, name) != 0)
            put_detector(cube, is_stack, name, json, &refused);
        if (refused.status == EXIT_SYSTEM)
            *err = refused;
    }
    json_close(json, ']');
    put_adaptations(json);
    json_string(json, "display", display);
    json_open(json, "displays", '[');
    put_display("srgb", json, err);
    put_display("monitor", json, err);
    if (display && !display_is_known(display))
        put_display(display, json, err);
    json_close(json, ']');
}

/* ---- all of it ---- */

static void put_camera(struct json *json, const struct camera *camera)
{
    json_open(json, "camera", '{');
    json_truth(json, "perspective", camera->perspective);
    json_number(json, "extent", camera->extent);
    json_number(json, "near", camera->near);
    json_number(json, "far", camera->far);
    put_vector(json, "eye", camera->eye);
    put_vector(json, "look", camera->look);
    put_vector(json, "up", camera->up);
    json_close(json, '}');
}

char *description_make(const struct viewing *view, struct error *err)
{
    struct describer describer = {.plan = view->plan, .err = err};
    const struct scene *scene = view->plan->scene;
    struct cube cube;
    struct json *json = &describer.json;
    json_begin(json);
    json_string(json, "program", PROGRAM);
    json_string(json, "scene", scene->path);
    json_string(json, "radiance_unit", scene_is_absolute(scene) ? ABSOLUTE_UNIT : NULL);
    json_numbers(json, "wavelengths", scene->wavelengths_nm, scene->n_wavelengths);
    json_count(json, "width", (uint64_t)scene->width);
    json_count(json, "height", (uint64_t)scene->height);
    put_camera(json, &scene->camera);
    add_builtins(&describer);
    if (MAKE_ARRAY(describer.row, (size_t)view->plan->n_bands, err, "the spectra of a page") &&
        describer.n_illuminants > 0) {
        /* A scene without ambient light gets one of intensity 0. */
        const struct light none = {.spectrum = describer.illuminants[0]};
        const bool dark = scene->n_ambients == 0;
        put_lights(&describer, "ambients", dark ? &none : scene->ambients,
                   dark ? 1 : scene->n_ambients, true);
        put_lights(&describer, "lights", scene->lights, scene->n_lights, false);
        put_illuminants(&describer);
        put_surfaces(&describer);
        if (scene_cube(scene, &cube, err))
            put_eyes(&cube, false, view->options, json, err);
        free(cube.record.white.value);
    }
    for (int i = 0; i < describer.n_owned; i++)
        spectrum_free(&describer.illuminants[i]);
    FREE_ALL(describer.illuminants, describer.row);
    return json_take(json, err);
}
