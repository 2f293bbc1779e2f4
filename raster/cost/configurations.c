/* SPDX-License-Identifier: MIT */
/* Chooses the configurations of render that make sense for a scene: one axis after the other, then
 * the best of each together. */
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/material/material.h"
#include "data/mesh/mesh.h"
#include "data/method/method.h"
#include "data/options/options.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "raster/cost/cost.h"
#include "raster/gl/gl.h"
#include "spectral.h"

/* ---- the scene ---- */

static bool material_fluoresces(const struct material *material)
{
    return material->excitation.kind != SPECTRUM_NONE || material->donaldson ||
           (material->partner && material_fluoresces(material->partner));
}

static void survey_materials(const struct scene *scene, struct survey *out, bool *glossy)
{
    for (int i = 0; i < scene->n_materials; i++) {
        const struct material *material = &scene->materials[i];
        out->fluorescent = out->fluorescent || material_fluoresces(material);
        out->spectral_texture = out->spectral_texture || material->spectral_texture ||
                                (material->partner && material->partner->spectral_texture);
        *glossy =
            *glossy || material->gloss > 0 || (material->partner && material->partner->gloss > 0);
    }
}

/* On flat shapes without highlights directional light is the same everywhere. */
static void survey_shapes(const struct scene *scene, bool glossy, struct survey *out)
{
    bool varied = glossy;
    for (int i = 0; i < scene->n_lights; i++)
        varied = varied || !scene->lights[i].directional;
    for (int i = 0; i < scene->n_objects; i++) {
        const enum shape_kind kind = scene->objects[i].shape.kind;
        const bool counts = shape_has_counts(kind);
        varied = varied || kind == SHAPE_MESH || (counts && kind != SHAPE_DISK);
        out->tessellated = out->tessellated || counts;
    }
    out->shaded = varied && scene->n_lights > 0;
}

/* Reads the sampling of the scene by a method. */
static bool read_sampling(const struct options *options, const char *method, struct sampling *out,
                          struct error *err)
{
    struct configuration configuration = {.tessellation = 1, .renderer = BY_RASTER};
    struct cost_entry entry = {.n_words = 0};
    struct scene scene = {.path = NULL};
    snprintf(configuration.sampling, sizeof configuration.sampling, "%s", method);
    const bool done = configuration_entry(&configuration, options_detector(options), &entry, err) &&
                      cost_read(options, &entry, &scene, out, err);
    cost_entry_free(&entry);
    scene_free(&scene);
    return done;
}

/* Peaks and rank are found by samplings; one that refuses the scene finds nothing. */
static void survey_spectra(const struct options *options, struct survey *out)
{
    struct error ignored = {.status = EXIT_AGREED};
    struct sampling sampling = {.n = 0};
    out->n_peaks = -1;
    if (read_sampling(options, "adaptive:0.01", &sampling, &ignored)) {
        out->n_peaks = sampling.n_peaks < MAX_SURVEY_PEAKS ? sampling.n_peaks : MAX_SURVEY_PEAKS;
        for (int i = 0; i < out->n_peaks; i++)
            out->peak_nm[i] = sampling.peak_nm[i];
    }
    sampling_free(&sampling);
    ignored = (struct error){.status = EXIT_AGREED};
    if (!out->spectral_texture && read_sampling(options, "basis:1", &sampling, &ignored))
        out->rank = sampling.rank;
    sampling_free(&sampling);
}

static bool survey(void *context, void *result, struct error *err)
{
    const struct options *options = *(const struct options **)context;
    struct survey *out = result;
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.n = 0};
    bool glossy = false;
    const bool done = cost_read(options, NULL, &scene, &sampling, err);
    if (done) {
        snprintf(out->scene, sizeof out->scene, "%s", scene.path);
        out->width = scene.width;
        out->height = scene.height;
        survey_materials(&scene, out, &glossy);
        survey_shapes(&scene, glossy, out);
        survey_spectra(options, out);
    }
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}

bool survey_scene(const struct options *options, struct survey *out, struct error *err)
{
    *out = (struct survey){.observer = options_detector(options)};
    return process_run(survey, &options, out, sizeof *out, NULL, err);
}

/* ---- a configuration in words ---- */

static const char *const shading_names[] = {
    [SHADING_SMOOTH] = "smooth", [SHADING_FLAT] = "flat", [SHADING_PHONG] = "phong"};
static const char *const renderer_names[] = {[BY_RASTER] = "raster",
                                             [BY_LLVMPIPE] = "llvmpipe",
                                             [BY_CHECKED_LLVMPIPE] = "llvmpipe",
                                             [BY_SOFTPIPE] = "softpipe"};

static bool add_word(struct cost_entry *entry, struct error *err, const char *option,
                     const char *value)
{
    const size_t length = strlen(option) + strlen(value) + 1;
    char *word = malloc(length);
    if (!word)
        return error_memory(err);
    snprintf(word, length, "%s%s", option, value);
    entry->words[entry->n_words++] = word;
    return true;
}

static bool add_words(const struct configuration *configuration, const char *observer,
                      struct cost_entry *out, struct error *err)
{
    char tessellation[16];
    snprintf(tessellation, sizeof tessellation, "%d", configuration->tessellation);
    return (!configuration->sampling[0] ||
            add_word(out, err, "--sampling=", configuration->sampling)) &&
           (!configuration->sampling[0] || strcmp(observer, "cie1931") == 0 ||
            add_word(out, err, "--detector=", observer)) &&
           add_word(out, err, "--shading=", shading_names[configuration->shading]) &&
           (configuration->tessellation == 1 ||
            add_word(out, err, "--tessellation=", tessellation)) &&
           add_word(out, err, "--renderer=", renderer_names[configuration->renderer]) &&
           (configuration->renderer == BY_CHECKED_LLVMPIPE ||
            add_word(out, err, "--no-check", "")) &&
           (configuration->buffer_bits == 0 ||
            add_word(out, err, "--buffer=", configuration->buffer_bits == 8 ? "8" : "16")) &&
           (configuration->bits == 0 ||
            add_word(out, err, "--depth=", configuration->bits == 8 ? "8" : "32f"));
}

bool configuration_entry(const struct configuration *configuration, const char *observer,
                         struct cost_entry *out, struct error *err)
{
    char finer[16] = "", buffer[24] = "";
    if (configuration->tessellation > 1)
        snprintf(finer, sizeof finer, " x%d", configuration->tessellation);
    if (configuration->buffer_bits > 0)
        snprintf(buffer, sizeof buffer, " buffer %d", configuration->buffer_bits);
    snprintf(out->name, sizeof out->name, "%s %s%s%s%s%s%s%s",
             configuration->sampling[0] ? configuration->sampling : "own wavelengths",
             shading_names[configuration->shading], finer,
             configuration->renderer == BY_RASTER ? "" : " ",
             configuration->renderer == BY_RASTER ? "" : renderer_names[configuration->renderer],
             configuration->renderer == BY_CHECKED_LLVMPIPE ? " checked" : "", buffer,
             configuration->bits == 0   ? ""
             : configuration->bits == 8 ? " depth 8"
                                        : " depth 32f");
    return add_words(configuration, observer, out, err);
}

/* ---- one axis after the other ---- */

const struct configuration reference_configuration = {
    .sampling = "riemann:1", .shading = SHADING_PHONG, .tessellation = 4, .renderer = BY_RASTER};

static bool same_configuration(const struct configuration *a, const struct configuration *b)
{
    return strcmp(a->sampling, b->sampling) == 0 && a->shading == b->shading &&
           a->tessellation == b->tessellation && a->renderer == b->renderer &&
           a->buffer_bits == b->buffer_bits && a->bits == b->bits;
}

/* Leaves out a configuration that is there already, or finds no room. */
static bool add(const struct survey *survey, struct attempts *attempts,
                struct configuration configuration, const char *sampling, struct error *err)
{
    snprintf(configuration.sampling, sizeof configuration.sampling, "%s", sampling);
    for (int i = 0; i < attempts->n; i++)
        if (same_configuration(&attempts->attempt[i].configuration, &configuration))
            return true;
    if (attempts->n == MAX_CONFIGURATIONS)
        return true;
    struct attempt *attempt = &attempts->attempt[attempts->n++];
    *attempt = (struct attempt){.configuration = configuration};
    return configuration_entry(&configuration, survey->observer, &attempt->entry, err);
}

/* The configuration that samplings, and then shadings, are tried with. */
static struct configuration finest(const struct survey *survey)
{
    struct configuration configuration = reference_configuration;
    configuration.tessellation = survey->tessellated ? configuration.tessellation : 1;
    return configuration;
}

/* Adds bases of the first few components, and of all. */
static bool add_bases(const struct survey *survey, struct attempts *out, struct error *err)
{
    static const int counts[] = {1, 2, 4, 8, INT_MAX};
    char name[SAMPLING_NAME];
    for (int i = 0; i < 5 && (i == 0 || counts[i - 1] < survey->rank); i++) {
        snprintf(name, sizeof name, "basis:%d",
                 counts[i] < survey->rank ? counts[i] : survey->rank);
        if (!add(survey, out, finest(survey), name, err))
            return false;
    }
    return true;
}

/* Smooth light calls for more of gauss, emission lines for more of adaptive. */
enum lights { ANY_LIGHT, SMOOTH_LIGHT, LINES };
static const struct {
    const char *name;
    enum lights under;
} samplings[] = {{"", ANY_LIGHT},
                 {"riemann:40", ANY_LIGHT},
                 {"riemann:20", ANY_LIGHT},
                 {"riemann:10", ANY_LIGHT},
                 {"riemann:5", ANY_LIGHT},
                 {"riemann:1", ANY_LIGHT},
                 {"gauss:4", ANY_LIGHT},
                 {"gauss:8", ANY_LIGHT},
                 {"gauss:12", SMOOTH_LIGHT},
                 {"gauss:16", ANY_LIGHT},
                 {"gauss:24", ANY_LIGHT},
                 {"gauss:8,open", ANY_LIGHT},
                 {"box:8", ANY_LIGHT},
                 {"box:16", ANY_LIGHT},
                 {"adaptive:0.1", LINES},
                 {"adaptive:0.01", ANY_LIGHT},
                 {"adaptive:0.001", LINES}};

bool configurations_samplings(const struct survey *survey, struct attempts *out, struct error *err)
{
    const enum lights other = survey->n_peaks > 0 ? SMOOTH_LIGHT : LINES;
    for (size_t i = 0; i < sizeof samplings / sizeof samplings[0]; i++)
        if (samplings[i].under != other &&
            !add(survey, out, finest(survey), samplings[i].name, err))
            return false;
    return survey->spectral_texture || (add(survey, out, finest(survey), "rgb", err) &&
                                        add(survey, out, finest(survey), "xyz", err) &&
                                        (survey->rank == 0 || add_bases(survey, out, err)));
}

/* ---- shading, renderer and arithmetic, with a sampling that is good enough not to matter ---- */

/* Returns the attempt of a configuration with a sampling; NULL: none that could be rendered. */
static const struct attempt *find(const struct attempts *attempts,
                                  struct configuration configuration, const char *sampling)
{
    snprintf(configuration.sampling, sizeof configuration.sampling, "%s", sampling);
    for (int i = 0; i < attempts->n; i++)
        if (same_configuration(&attempts->attempt[i].configuration, &configuration) &&
            attempts->attempt[i].entry.accuracy.n_pages > 0)
            return &attempts->attempt[i];
    return NULL;
}

enum content { ANY_PAGES, RADIANCES, WAVELENGTHS }; /* of pages, at least */

static bool has_content(const struct cost_entry *entry, enum content content)
{
    return content == WAVELENGTHS ? entry->accuracy.spectral
                                  : content == ANY_PAGES || !isnan(entry->accuracy.radiance);
}

/* Returns the sampling of the fewest pages within a colour difference; where none is within it, the
 * closest. */
static const char *leanest(const struct survey *survey, const struct attempts *attempts,
                           double tolerance, enum content content)
{
    const struct attempt *best = NULL;
    for (int i = 0; i < attempts->n; i++) {
        const struct attempt *attempt = &attempts->attempt[i];
        const double error = fmax(attempt->entry.accuracy.quantile_95, tolerance);
        if (find(attempts, finest(survey), attempt->configuration.sampling) != attempt ||
            !has_content(&attempt->entry, content))
            continue;
        const double least = best ? fmax(best->entry.accuracy.quantile_95, tolerance) : HUGE_VAL;
        if (error < least ||
            (error <= least && attempt->entry.accuracy.n_pages < best->entry.accuracy.n_pages))
            best = attempt;
    }
    return best ? best->configuration.sampling : "";
}

static const char *good_sampling(const struct survey *survey, const struct attempts *attempts)
{
    return leanest(survey, attempts, 0.1, RADIANCES);
}

/* About in the order of what they cost. */
static const struct configuration shadings[] = {
    {.shading = SHADING_FLAT, .tessellation = 1},   {.shading = SHADING_SMOOTH, .tessellation = 1},
    {.shading = SHADING_PHONG, .tessellation = 1},  {.shading = SHADING_FLAT, .tessellation = 2},
    {.shading = SHADING_SMOOTH, .tessellation = 2}, {.shading = SHADING_PHONG, .tessellation = 2},
    {.shading = SHADING_FLAT, .tessellation = 4},   {.shading = SHADING_SMOOTH, .tessellation = 4},
    {.shading = SHADING_PHONG, .tessellation = 4}};
enum { N_SHADINGS = sizeof shadings / sizeof shadings[0] };

static bool is_on_axis(const struct survey *survey, const struct configuration *shading)
{
    return (survey->tessellated || shading->tessellation == 1) &&
           (survey->shaded || shading->shading == SHADING_SMOOTH);
}

static bool add_shadings(const struct survey *survey, struct attempts *out, struct error *err)
{
    for (int i = 0; i < N_SHADINGS; i++)
        if (is_on_axis(survey, &shadings[i]) &&
            !add(survey, out, shadings[i], good_sampling(survey, out), err))
            return false;
    return true;
}

static const struct configuration opengl = {.tessellation = 1, .renderer = BY_LLVMPIPE};

/* OpenGL lights vertices only: smooth. */
static bool add_renderers(const struct survey *survey, struct attempts *out, struct error *err)
{
    const char *sampling = good_sampling(survey, out);
    struct configuration eight = opengl, sixteen = opengl, checked = opengl, softpipe = opengl;
    eight.buffer_bits = 8;
    sixteen.buffer_bits = 16;
    checked.renderer = BY_CHECKED_LLVMPIPE;
    softpipe.renderer = BY_SOFTPIPE;
    return !gl_is_built() ||
           (add(survey, out, opengl, sampling, err) && add(survey, out, sixteen, sampling, err) &&
            add(survey, out, eight, sampling, err) && add(survey, out, checked, sampling, err) &&
            add(survey, out, softpipe, sampling, err));
}

static bool add_depths(const struct survey *survey, struct attempts *out, struct error *err)
{
    struct configuration bytes = finest(survey), floats = finest(survey);
    bytes.bits = 8;
    floats.bits = 32;
    return add(survey, out, bytes, good_sampling(survey, out), err) &&
           add(survey, out, floats, good_sampling(survey, out), err);
}

bool configurations_pictures(const struct survey *survey, struct attempts *out, struct error *err)
{
    return add_shadings(survey, out, err) && add_renderers(survey, out, err) &&
           add_depths(survey, out, err);
}

/* ---- combinations ---- */

/* Adds a sampling with each shading that is closer than all listed before it. */
static bool combine(const struct survey *survey, const char *sampling, struct attempts *attempts,
                    struct error *err)
{
    double best = HUGE_VAL;
    for (int i = 0; i < N_SHADINGS; i++) {
        const struct attempt *attempt =
            find(attempts, shadings[i], good_sampling(survey, attempts));
        if (!attempt || attempt->entry.accuracy.quantile_95 >= best)
            continue;
        best = attempt->entry.accuracy.quantile_95;
        if (!add(survey, attempts, shadings[i], sampling, err))
            return false;
    }
    return !gl_is_built() || add(survey, attempts, opengl, sampling, err);
}

bool configurations_combined(const struct survey *survey, struct attempts *attempts,
                             struct error *err)
{
    char colours[SAMPLING_NAME], spectra[SAMPLING_NAME];
    snprintf(colours, sizeof colours, "%s", leanest(survey, attempts, 0.5, ANY_PAGES));
    snprintf(spectra, sizeof spectra, "%s", leanest(survey, attempts, 0.5, WAVELENGTHS));
    return combine(survey, colours, attempts, err) && combine(survey, spectra, attempts, err);
}

/* ---- notes ---- */

bool cost_note(struct cost *cost, struct error *err, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    char **notes = array_more(cost->notes, cost->n_notes, sizeof *notes, err);
    if (!notes)
        return false;
    cost->notes = notes;
    notes[cost->n_notes] = strdup(text);
    return notes[cost->n_notes++] || error_memory(err);
}

static bool note_lights(const struct survey *survey, struct cost *cost, struct error *err)
{
    char list[16 * MAX_SURVEY_PEAKS] = "";
    if (survey->n_peaks < 0)
        return true;
    if (survey->n_peaks == 0)
        return cost_note(cost, err, "no emission peaks: gauss needs few samples");
    for (int i = 0; i < survey->n_peaks; i++)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%.6g", i > 0 ? ", " : "",
                 survey->peak_nm[i]);
    return cost_note(
        cost, err,
        "emission peaks at %s nm, of lights or materials: adaptive samples them, others "
        "may miss them or give them too much weight",
        list);
}

bool survey_notes(const struct survey *survey, struct cost *cost, struct error *err)
{
    return note_lights(survey, cost, err) &&
           (!survey->fluorescent ||
            cost_note(cost, err, "materials fluoresce: rgb and xyz cannot show it")) &&
           (!survey->spectral_texture ||
            cost_note(cost, err,
                      "spectral textures leave out basis, rgb and xyz: they have "
                      "radiances at wavelengths")) &&
           (survey->shaded ||
            cost_note(cost, err,
                      "shadings do not differ: nothing curved, no highlights, and no "
                      "light that is near")) &&
           (survey->tessellated ||
            cost_note(cost, err, "no shape has slices or stacks: there is no --tessellation")) &&
           (gl_is_built() ||
            cost_note(cost, err, "this program was built without OpenGL: raster renders all"));
}
