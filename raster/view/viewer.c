/* SPDX-License-Identifier: MIT */
/* Writes data/builtin/viewer.html with the data of a scene.
 *
 * Local illumination is linear: the radiance of a pixel is a sum of weights times spectra. Weights
 * depend on geometry only; spectra are products of light and material. The page contains the
 * weights as planes of 16 bits and the spectra as JSON, and multiplies them itself. Luminescence
 * depends on wavelengths outside the picture, so it is computed here for every illuminant that the
 * page offers.
 */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/colour/colour.h"
#include "data/material/material.h"
#include "data/mesh/mesh.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/terms/terms.h"
#include "data/text/text.h"
#include "raster/view/view.h"

/* ---- spectra and rows of numbers as JSON ---- */

struct page {
    const struct plan *plan;
    struct outputs *outputs;
    struct json json;
    struct spectrum *illuminants; /* that the page offers; the first n_owned are owned */
    int n_illuminants, n_owned;
    double *row; /* room for three numbers a band; owned */
    struct viewer_result *result;
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
static void put_spectrum(struct page *page, const char *key, const struct spectrum *spectrum,
                         enum spectrum_ends ends)
{
    const struct plan *plan = page->plan;
    if (spectrum->kind == SPECTRUM_NONE)
        return;
    for (int i = 0; i < plan->n_bands; i++)
        page->row[i] = spectrum_at(spectrum, plan->scene->wavelengths_nm[i], ends);
    json_numbers(&page->json, key, page->row, plan->n_bands);
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
static int find_illuminant(struct page *page, const struct spectrum *spectrum, struct error *err)
{
    for (int i = 0; i < page->n_illuminants; i++)
        if (same_illuminant(&page->illuminants[i], spectrum))
            return i;
    return array_add(&page->illuminants, &page->n_illuminants, spectrum, sizeof *spectrum, err)
               ? page->n_illuminants - 1
               : -1;
}

static bool add_builtin(struct page *page, const char *name, struct error *err)
{
    struct word word = {.start = name, .length = strlen(name)};
    struct spectrum spectrum;
    if (!spectrum_read(&word, 0, HUGE_VAL, &spectrum, err))
        return false;
    if (find_illuminant(page, &spectrum, err) < 0) {
        spectrum_free(&spectrum);
        return false;
    }
    page->n_owned = page->n_illuminants;
    return true;
}

/* Adds equal energy and the built-in illuminants. */
static bool add_builtins(struct page *page, struct error *err)
{
    char name[BUILTIN_NAME];
    if (!add_builtin(page, "1", err))
        return false;
    for (size_t i = 0; i < builtin_file_count; i++)
        if (!table_is_detector(&builtin_files[i]) &&
            builtin_name(&builtin_files[i], "tables/", ".csv", name) &&
            !add_builtin(page, name, err))
            return false;
    return true;
}

/* Puts the word by which a command line names the spectrum. The path of a scene's file is relative
 * to the working folder. */
static bool put_word(struct page *page, const struct spectrum *spectrum, struct error *err)
{
    char *word = spectrum->path ? file_relative(spectrum->place.path, spectrum->name) : NULL;
    if (spectrum->path && !word)
        return error_memory(err);
    json_string(&page->json, "word", word ? word : spectrum->name);
    free(word);
    return true;
}

static bool put_illuminants(struct page *page, struct error *err)
{
    bool done = true;
    json_open(&page->json, "illuminants", '[');
    for (int i = 0; done && i < page->n_illuminants; i++) {
        json_open(&page->json, NULL, '{');
        json_string(&page->json, "name", page->illuminants[i].name);
        done = put_word(page, &page->illuminants[i], err);
        put_spectrum(page, "radiance", &page->illuminants[i], SPECTRUM_ZERO);
        json_close(&page->json, '}');
    }
    json_close(&page->json, ']');
    return done;
}

/* Puts a light of the scene. Adds its illuminant if that is new. */
static bool put_light(struct page *page, const struct spectrum *spectrum, double intensity,
                      struct error *err)
{
    int illuminant = find_illuminant(page, spectrum, err);
    if (illuminant < 0)
        return false;
    json_open(&page->json, NULL, '{');
    json_count(&page->json, "illuminant", (uint64_t)illuminant);
    json_number(&page->json, "intensity", intensity);
    json_close(&page->json, '}');
    return true;
}

/* Puts the lights of the scene. A scene without ambient light gets one of intensity 0. */
static bool put_lights(struct page *page, struct error *err)
{
    const struct scene *scene = page->plan->scene;
    bool done = true;
    json_open(&page->json, "ambients", '[');
    for (int i = 0; done && i < scene->n_ambients; i++)
        done = put_light(page, &scene->ambients[i].spectrum, scene->ambients[i].intensity, err);
    if (scene->n_ambients == 0)
        done = put_light(page, &page->illuminants[0], 0, err);
    json_close(&page->json, ']');
    json_open(&page->json, "lights", '[');
    for (int i = 0; done && i < scene->n_lights; i++)
        done = put_light(page, &scene->lights[i].spectrum, scene->lights[i].intensity, err);
    json_close(&page->json, ']');
    return done;
}

/* ---- surfaces ---- */

/* Puts the luminescence of a material under each illuminant. */
static bool put_luminescence(struct page *page, const struct material *material, struct error *err)
{
    json_open(&page->json, "luminescence", '[');
    for (int i = 0; i < page->n_illuminants; i++) {
        if (!material_luminescence(&page->plan->illumination.pages, material, &page->illuminants[i],
                                   page->row, err))
            return false;
        json_numbers(&page->json, NULL, page->row, page->plan->n_bands);
    }
    json_close(&page->json, ']');
    return true;
}

/* Puts the part that each page of a spectral texture has in each band. */
static bool put_texture(struct page *page, const struct texture *texture, struct error *err)
{
    struct spectrum part = {.kind = SPECTRUM_SAMPLED,
                            .factor = 1,
                            .count = texture->image.n_pages,
                            .wavelength_nm = texture->image.wavelengths_nm};
    part.value = calloc((size_t)part.count, sizeof *part.value);
    if (!part.value)
        return error_memory(err);
    json_open(&page->json, "texture", '[');
    for (int i = 0; i < part.count; i++) {
        part.value[i] = 1;
        put_spectrum(page, NULL, &part, SPECTRUM_HOLD);
        part.value[i] = 0;
    }
    json_close(&page->json, ']');
    free(part.value);
    return true;
}

/* Puts the spectra of a shaded material. Specular light has the light's own colour by default. */
static bool put_material(struct page *page, const struct shaded_material *shaded, struct error *err)
{
    static const struct spectrum plastic = {
        .kind = SPECTRUM_CONSTANT, .parameter = {1, 0}, .factor = 1};
    const struct material *material = shaded->material;
    const bool spectral = shaded->texture && shaded->texture->spectral;
    const bool fluoresces = material->excitation.kind != SPECTRUM_NONE || material->donaldson;
    json_open(&page->json, NULL, '{');
    put_spectrum(page, "diffuse", &material->diffuse, SPECTRUM_HOLD);
    if (material->gloss > 0)
        put_spectrum(page, "specular",
                     material->specular.kind != SPECTRUM_NONE ? &material->specular : &plastic,
                     SPECTRUM_HOLD);
    put_spectrum(page, "glow", &material->glow, SPECTRUM_ZERO);
    put_spectrum(page, "excitation", &material->excitation, SPECTRUM_ZERO);
    put_spectrum(page, "emission", &material->emission, SPECTRUM_ZERO);
    bool done = (!spectral || put_texture(page, shaded->texture, err)) &&
                (!fluoresces || put_luminescence(page, material, err));
    json_close(&page->json, '}');
    return done;
}

static bool put_surfaces(struct page *page, struct error *err)
{
    const struct plan *plan = page->plan;
    struct json *json = &page->json;
    json_open(json, "shaded_materials", '[');
    for (int i = 0; i < plan->n_materials; i++)
        if (!put_material(page, &plan->materials[i], err))
            return false;
    json_close(json, ']');
    json_open(json, "objects", '[');
    for (int i = 0; i < plan->n_instances; i++) {
        json_open(json, NULL, '{');
        json_string(json, "name", object_name(plan, i));
        json_string(json, "shape", shape_name(plan->instances[i].object->shape.kind));
        json_count(json, "shaded_material", (uint64_t)plan->instances[i].shaded);
        json_close(json, '}');
    }
    json_close(json, ']');
    return true;
}

/* ---- detectors, adaptations and displays ---- */

static bool put_detector(struct page *page, const char *name, struct error *err)
{
    const struct plan *plan = page->plan;
    const double *nm = plan->scene->wavelengths_nm;
    struct detector detector = {.name = NULL};
    struct json *json = &page->json;
    double lost[3];
    const bool done = detector_read(name, &detector, err);
    if (done) {
        detector_weights(&detector, nm, plan->n_bands, page->row);
        detector_lost(&detector, nm, plan->n_bands, lost);
        json_open(json, NULL, '{');
        json_string(json, "name", name);
        json_truth(json, "observer", detector.observer);
        json_rows(json, "weights", page->row, plan->n_bands);
        json_numbers(json, "lost", lost, 3);
        json_close(json, '}');
        page->result->n_detectors++;
    }
    detector_free(&detector);
    return done;
}

static bool put_detectors(struct page *page, struct error *err)
{
    char name[BUILTIN_NAME];
    json_open(&page->json, "detectors", '[');
    for (size_t i = 0; i < builtin_file_count; i++)
        if (table_is_detector(&builtin_files[i]) &&
            builtin_name(&builtin_files[i], "tables/", ".csv", name) &&
            !put_detector(page, name, err))
            return false;
    json_close(&page->json, ']');
    return true;
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
        json_string(json, "name", adaptation_name(kind));
        json_truth(json, "incomplete", kind == ADAPTATION_FAIRCHILD);
        if (kind != ADAPTATION_NONE) {
            adaptation_cones(kind, cones);
            colour_inverse(cones, back);
            colour_apply(cones, display_white, white);
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
static double code_step(enum display_kind kind, int channel, int code)
{
    double below = 0, at = display_largest(kind, channel);
    for (double middle = at / 2; middle > below && middle < at; middle = below + (at - below) / 2)
        if (display_encode(kind, channel, middle) * 255 + 0.5 >= code)
            at = middle;
        else
            below = middle;
    return at;
}

/* Puts the displays. A tone curve is a list of its 255 steps. */
static void put_displays(struct json *json)
{
    json_open(json, "displays", '[');
    for (int i = DISPLAY_SRGB; i <= DISPLAY_MONITOR; i++) {
        enum display_kind kind = (enum display_kind)i;
        double matrix[3][3], largest[3], steps[3][255];
        display_matrix(kind, matrix);
        for (int c = 0; c < 3; c++) {
            largest[c] = display_largest(kind, c);
            for (int code = 1; code <= 255; code++)
                steps[c][code - 1] = code_step(kind, c, code);
        }
        json_open(json, NULL, '{');
        json_string(json, "name", display_name(kind));
        json_rows(json, "matrix", (const double *)matrix, 3);
        json_numbers(json, "largest", largest, 3);
        json_rows(json, "steps", (const double *)steps, 255);
        json_close(json, '}');
    }
    json_close(json, ']');
}

/* ---- the page ---- */

static bool put_json(struct page *page, const struct planes *planes, const double *scale,
                     struct error *err)
{
    const struct scene *scene = page->plan->scene;
    struct json *json = &page->json;
    json_begin(json);
    json_open(json, NULL, '{');
    json_string(json, "program", PROGRAM);
    json_string(json, "scene", scene->path);
    json_count(json, "width", (uint64_t)scene->width);
    json_count(json, "height", (uint64_t)scene->height);
    json_count(json, "positions", (uint64_t)scene->positions); /* a side of each pixel */
    json_numbers(json, "wavelengths", scene->wavelengths_nm, scene->n_wavelengths);
    if (!add_builtins(page, err) || !put_lights(page, err) || !put_illuminants(page, err) ||
        !put_surfaces(page, err) || !put_detectors(page, err))
        return false;
    put_adaptations(json);
    put_displays(json);
    json_numbers(json, "weight_scales", scale, planes->n_weights);
    json_numbers(json, "texture_scales", scale + planes->n_weights, planes->n_pages);
    json_close(json, '}');
    return true;
}

/* Writes JSON into HTML. A "<" might end the script element around it, so it is escaped; only
 * strings contain one. */
static void write_json(const char *text, struct printed *to)
{
    while (*text) {
        const size_t plain = strcspn(text, "<");
        print_bytes(to, text, plain);
        text += plain;
        if (*text == '<') {
            print_text(to, "\\u003c");
            text++;
        }
    }
}

/* Returns the page's source with the data in place of the mark, allocated; NULL: see err. */
static char *page_text(const char *json, const char *planes, size_t planes_length, size_t *bytes,
                       struct error *err)
{
    static const char mark[] = "<!-- scene -->\n";
    const struct place nowhere = {NULL, 0, 0};
    struct printed printed = {.text = NULL};
    char *source = NULL;
    size_t length;
    if (!file_read("builtin:viewer.html", nowhere, &source, &length, err))
        return NULL;
    const char *at = strstr(source, mark);
    assert(at);
    print_bytes(&printed, source, (size_t)(at - source));
    print_text(&printed, "<script id=\"scene\" type=\"application/json\">");
    write_json(json, &printed);
    print_text(&printed, "</script>\n<script id=\"planes\" type=\"text/plain\">");
    print_bytes(&printed, planes, planes_length);
    print_text(&printed, "</script>\n");
    print_text(&printed, at + strlen(mark));
    free(source);
    char *text = printed_end(&printed);
    *bytes = printed.length;
    if (!text)
        error_memory(err);
    return text;
}

static bool write_page(struct page *page, const char *json, const char *planes,
                       size_t planes_length, const char *path, struct error *err)
{
    char *text = page_text(json, planes, planes_length, &page->result->bytes, err);
    const bool done = text && file_write(path, text, page->result->bytes, page->outputs, err);
    free(text);
    return done;
}

static void page_free(struct page *page)
{
    for (int i = 0; i < page->n_owned; i++)
        spectrum_free(&page->illuminants[i]);
    free(page->illuminants);
    free(page->row);
    free(json_end(&page->json));
}

static bool make_page(struct page *page, const struct planes *planes, const char *path,
                      struct error *err)
{
    int n_planes = planes->n_weights + planes->n_pages;
    double *scale = calloc((size_t)n_planes, sizeof *scale);
    char *json = NULL, *text = NULL;
    size_t length;
    bool done = scale || error_memory(err);
    for (int i = 0; done && i < n_planes; i++)
        scale[i] = plane_scale(planes, i);
    if (done && put_json(page, planes, scale, err)) {
        json = json_end(&page->json);
        text = planes_text(planes, scale, &length);
        done = json && text ? write_page(page, json, text, length, path, err) : error_memory(err);
    } else
        done = false;
    free(scale);
    free(json);
    free(text);
    return done;
}

bool viewer_write(const struct plan *plan, const char *path, struct viewer_result *out,
                  struct notes *notes, struct outputs *outputs, struct error *err)
{
    struct page page = {.plan = plan, .outputs = outputs, .result = out};
    struct planes planes = {.n_positions = 0};
    *out = (struct viewer_result){.n_objects = plan->n_instances, .n_lights = plan->n_lights};
    page.row = calloc(3 * (size_t)plan->n_bands, sizeof *page.row);
    bool done = (page.row || error_memory(err)) && planes_rasterize(plan, &planes, notes, err) &&
                make_page(&page, &planes, path, err);
    out->n_illuminants = page.n_illuminants;
    page_free(&page);
    planes_free(&planes);
    return done;
}
