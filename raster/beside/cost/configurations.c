/* SPDX-License-Identifier: MIT */
/* Chooses the configurations of render that make sense for a scene. First one property varies at a
 * time (sampling, shading, renderer, depth); then the best values are combined. */
#include <limits.h>
#include <math.h>
#include <string.h>

#include "data/mesh/mesh.h"
#include "raster/beside/cost/inside.h"
#include "raster/renderers/renderers.h"

/* ---- a configuration in words ---- */

/* Adds an option to the words of an entry (NULL: none), and its value to the name behind `prefix`
 * (NULL: the name leaves it out). */
static bool say(struct cost_entry *entry, const char *prefix, const char *option, const char *value,
                struct error *err)
{
    const size_t named = strlen(entry->name);
    if (prefix)
        snprintf(entry->name + named, sizeof entry->name - named, "%s%s", prefix, value);
    if (!option)
        return true;
    struct printed word = {.text = NULL};
    print(&word, "%s%s", option, value);
    entry->words[entry->n_words] = printed_take(&word, err);
    return entry->words[entry->n_words++] != NULL;
}

/* An accuracy stands in place of a sampling: wavelengths stay, and shapes are divided. */
static const char accuracy_prefix[] = "accuracy:";

static bool say_sampling(const struct configuration *configuration, const char *observer,
                         struct cost_entry *out, struct error *err)
{
    const char *name = configuration->sampling;
    const size_t length = strlen(accuracy_prefix);
    if (!name[0])
        return say(out, "", NULL, "own wavelengths", err);
    return (strncmp(name, accuracy_prefix, length) == 0
                ? say(out, "", NULL, name, err) && say(out, NULL, "--accuracy=", name + length, err)
                : say(out, "", "--sampling=", name, err)) &&
           (strcmp(observer, "cie1931") == 0 || say(out, NULL, "--detector=", observer, err));
}

bool configuration_entry(const struct configuration *configuration, const char *observer,
                         struct cost_entry *out, struct error *err)
{
    static const char *const renderer[] = {[BY_RASTER] = "raster",
                                           [BY_LLVMPIPE] = "llvmpipe",
                                           [BY_CHECKED_LLVMPIPE] = "llvmpipe",
                                           [BY_SOFTPIPE] = "softpipe",
                                           [BY_SHADERS] = "gl-shader:llvmpipe"};
    const char *const buffer = configuration->buffer_bits == 8 ? "8" : "16";
    const char *const depth = configuration->bits == 8 ? "8" : "32f";
    char factor[16], positions[16];
    snprintf(factor, sizeof factor, "%d", configuration->tessellation);
    snprintf(positions, sizeof positions, "%d", configuration->positions);
    out->configuration = *configuration;
    return say_sampling(configuration, observer, out, err) &&
           say(out, " ", "--shading=", shading_words[configuration->shading], err) &&
           (configuration->tessellation == 1 || say(out, " x", "--tessellation=", factor, err)) &&
           (configuration->positions == 0 || say(out, " samples ", "--samples=", positions, err)) &&
           say(out, configuration->renderer == BY_RASTER ? NULL : " ",
               "--renderer=", renderer[configuration->renderer], err) &&
           (configuration->renderer == BY_CHECKED_LLVMPIPE
                ? say(out, " checked", NULL, "", err)
                : say(out, NULL, "--no-check", "", err)) &&
           (configuration->buffer_bits == 0 || say(out, " buffer ", "--buffer=", buffer, err)) &&
           (configuration->bits == 0 || say(out, " depth ", "--depth=", depth, err));
}

static const struct configuration every_nm = {
    .sampling = "riemann:1", .shading = SHADING_PHONG, .tessellation = 4, .renderer = BY_RASTER};

/* Means are judged by those of twice as many positions a side. Float pages hold the same radiances
 * at any full scale. Without --full-scale, render refuses phong shading where it finds no largest
 * radiance. */
bool configuration_standard(const struct cost *cost, struct cost_entry *out, struct error *err)
{
    struct configuration configuration = every_nm;
    configuration.bits = 32;
    if (cost->survey.positions > 1)
        configuration.positions = 2 * cost->survey.positions;
    return configuration_entry(&configuration, cost->survey.observer, out, err) &&
           say(out, NULL, "--full-scale=", "65535", err);
}

/* ---- the scene ---- */

/* Surveys a material, and the partner that its file gives it. */
static void survey_material(const struct material *material, struct survey *out, bool *glossy)
{
    for (; material; material = material->partner) {
        out->fluorescent =
            out->fluorescent || material->excitation.kind != SPECTRUM_NONE || material->donaldson;
        out->spectral_texture = out->spectral_texture || material->spectral_texture;
        *glossy = *glossy || material->gloss > 0;
    }
}

/* Finds whether shadings differ. They do not on flat shapes without highlights under directional
 * lights, whose light is the same at every point of a shape. */
static void survey_picture(const struct scene *scene, struct survey *out)
{
    bool varied = false, built_in = false, curved = false;
    for (int i = 0; i < scene->n_materials; i++)
        survey_material(&scene->materials[i], out, &varied);
    for (int i = 0; i < scene->n_lights; i++)
        varied = varied || !scene->lights[i].directional;
    for (int i = 0; i < scene->n_objects; i++) {
        const enum shape_kind kind = scene->objects[i].shape.kind;
        varied = varied || kind == SHAPE_MESH || !shape_is_flat(kind);
        built_in = built_in || kind != SHAPE_MESH;
        curved = curved || !(shape_is_flat(kind) || kind == SHAPE_MESH) || kind == SHAPE_DISK;
    }
    out->tessellated = curved || (built_in && varied);
    out->shaded = varied && scene->n_lights > 0;
}

/* Makes the sampling of the scene by a method. A method that refuses the scene leaves *out
 * empty. Fails only where the system does. */
static bool read_sampling(const struct options *options, const char *method, struct render_job *out,
                          struct error *err)
{
    struct error refusal = {.status = EXIT_AGREED};
    struct cost_entry entry = {.n_words = 0};
    const bool done = say(&entry, NULL, "--sampling=", method, &refusal) &&
                      say(&entry, NULL, "--detector=", options_detector(options), &refusal) &&
                      cost_read(options, &entry, out, &refusal);
    cost_entry_free(&entry);
    if (!done)
        job_free(out);
    if (!done && refusal.status == EXIT_SYSTEM)
        *err = refusal;
    return done || refusal.status != EXIT_SYSTEM;
}

/* Finds peaks and rank by making two samplings. A sampling that refuses the scene finds nothing. */
static bool survey_spectra(const struct options *options, struct survey *out, struct error *err)
{
    struct render_job job = {.options = {.threads = 0}};
    bool done = read_sampling(options, "adaptive:0.01", &job, err);
    out->peaks = job.sampling.n_peaks > 0;
    job_free(&job);
    if (done && !out->spectral_texture) {
        done = read_sampling(options, "basis:1", &job, err);
        out->rank = job.sampling.rank;
        job_free(&job);
    }
    return done;
}

/* Leaves room for a standard of more positions. */
static bool check_positions(const struct scene *scene, struct error *err)
{
    return 2 * scene->positions <= MOST_POSITIONS || scene->positions == 1 ||
           error_usage(err, "cost takes --samples up to %d: its standard has twice as many",
                       MOST_POSITIONS / 2);
}

static bool survey(void *context, void *result, struct error *err)
{
    const struct options *options = *(const struct options **)context;
    struct survey *out = result;
    struct render_job job = {.options = {.threads = 0}};
    const struct scene *scene = &job.scene;
    struct detector observer = {.name = NULL};
    bool done = observer_read(out->observer, &observer, err) &&
                cost_read(options, NULL, &job, err) && check_positions(scene, err);
    if (done) {
        snprintf(out->scene, sizeof out->scene, "%s", scene->path);
        out->width = scene->width;
        out->height = scene->height;
        out->positions = scene->positions;
        survey_picture(scene, out);
        done = survey_spectra(options, out, err);
    }
    detector_free(&observer);
    job_free(&job);
    return done;
}

bool survey_scene(const struct options *options, struct survey *out, struct error *err)
{
    *out = (struct survey){.observer = options_detector(options)};
    return process_run(survey, &options, out, sizeof *out, err);
}

/* ---- one axis after the other ---- */

/* Returns the entry of a configuration with a sampling; NULL: there is none. */
static const struct cost_entry *
find(const struct cost *cost, const struct configuration *configuration, const char *sampling)
{
    for (int i = 0; i < cost->n; i++) {
        const struct configuration *other = &cost->entries[i].configuration;
        if (strcmp(other->sampling, sampling) == 0 && other->shading == configuration->shading &&
            other->tessellation == configuration->tessellation &&
            other->renderer == configuration->renderer &&
            other->positions == configuration->positions &&
            other->buffer_bits == configuration->buffer_bits && other->bits == configuration->bits)
            return &cost->entries[i];
    }
    return NULL;
}

/* Adds a configuration with a sampling, unless it is there already, or there is no room. */
static void add(struct cost *cost, struct configuration configuration, const char *sampling)
{
    if (find(cost, &configuration, sampling) || cost->n == MAX_CONFIGURATIONS)
        return;
    snprintf(configuration.sampling, sizeof configuration.sampling, "%s", sampling);
    cost->entries[cost->n++].configuration = configuration;
}

/* Returns the configuration that samplings, and then shadings, are tried with. */
static struct configuration finest(const struct cost *cost)
{
    struct configuration configuration = every_nm;
    configuration.tessellation = cost->survey.tessellated ? every_nm.tessellation : 1;
    return configuration;
}

/* Adds bases of the first few components, and of all. */
static void add_bases(struct cost *cost)
{
    static const int counts[] = {1, 2, 4, 8, INT_MAX};
    const int rank = cost->survey.rank;
    char name[SAMPLING_NAME];
    for (int i = 0; i < 5 && (i == 0 || counts[i - 1] < rank); i++) {
        snprintf(name, sizeof name, "basis:%d", counts[i] < rank ? counts[i] : rank);
        add(cost, finest(cost), name);
    }
}

/* Samplings to measure. Smooth light needs more numbers of gauss, emission lines more tolerances of
 * adaptive. */
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

void configurations_samplings(struct cost *cost)
{
    const enum lights other = cost->survey.peaks ? SMOOTH_LIGHT : LINES;
    for (size_t i = 0; i < sizeof samplings / sizeof samplings[0]; i++)
        if (samplings[i].under != other)
            add(cost, finest(cost), samplings[i].name);
    if (cost->survey.spectral_texture)
        return;
    add(cost, finest(cost), "rgb");
    add(cost, finest(cost), "xyz");
    if (cost->survey.rank > 0)
        add_bases(cost);
}

/* ---- shadings, renderers and depths, with a sampling whose own error is small ---- */

/* The least that pages must hold: anything; what determines radiances; radiances at wavelengths. */
enum content { ANY_PAGES, RADIANCES, WAVELENGTHS };

static bool has_content(const struct cost_entry *entry, enum content content)
{
    return content == WAVELENGTHS ? entry->accuracy.spectral
                                  : content == ANY_PAGES || !isnan(entry->accuracy.radiance);
}

/* Returns the sampling with the fewest pages among those within a colour difference. If none is
 * within it, returns the most accurate one. */
static const char *leanest(const struct cost *cost, double tolerance, enum content content)
{
    const struct configuration axis = finest(cost);
    const struct cost_entry *best = NULL;
    double least = HUGE_VAL;
    for (int i = 0; i < cost->n; i++) {
        const struct cost_entry *entry = &cost->entries[i];
        const double error = fmax(entry->accuracy.quantile_95, tolerance);
        if (entry->accuracy.n_pages == 0 || !has_content(entry, content) ||
            find(cost, &axis, entry->configuration.sampling) != entry)
            continue;
        if (!best || error < least ||
            (error <= least && entry->accuracy.n_pages < best->accuracy.n_pages)) {
            best = entry;
            least = error;
        }
    }
    return best ? best->configuration.sampling : "";
}

void configurations_choose(struct cost *cost)
{
    static const struct {
        double tolerance;
        enum content content;
    } wanted[N_CHOSEN] = {[GOOD] = {0.1, RADIANCES},
                          [COLOURS] = {0.5, ANY_PAGES},
                          [SPECTRA] = {0.5, WAVELENGTHS},
                          [FINE_SPECTRA] = {0.1, WAVELENGTHS}};
    for (int i = 0; i < N_CHOSEN; i++)
        snprintf(cost->chosen[i], sizeof cost->chosen[i], "%s",
                 leanest(cost, wanted[i].tolerance, wanted[i].content));
}

/* The reference's pictures, roughly in the order of their time, the fastest first; then OpenGL's,
 * with smooth shading: OpenGL lights vertices only. */
static const struct configuration pictures[] = {
    {.shading = SHADING_FLAT, .tessellation = 1},
    {.shading = SHADING_SMOOTH, .tessellation = 1},
    {.shading = SHADING_PHONG, .tessellation = 1},
    {.shading = SHADING_FLAT, .tessellation = 2},
    {.shading = SHADING_SMOOTH, .tessellation = 2},
    {.shading = SHADING_PHONG, .tessellation = 2},
    {.shading = SHADING_FLAT, .tessellation = 4},
    {.shading = SHADING_SMOOTH, .tessellation = 4},
    {.shading = SHADING_PHONG, .tessellation = 4},
    {.tessellation = 1, .renderer = BY_LLVMPIPE},
    {.tessellation = 1, .renderer = BY_LLVMPIPE, .buffer_bits = 16},
    {.tessellation = 1, .renderer = BY_LLVMPIPE, .buffer_bits = 8},
    {.tessellation = 1, .renderer = BY_CHECKED_LLVMPIPE},
    {.tessellation = 1, .renderer = BY_SOFTPIPE},
    {.tessellation = 1, .renderer = BY_SHADERS}};
enum { N_PICTURES = sizeof pictures / sizeof pictures[0] };

static bool makes_sense(const struct survey *survey, const struct configuration *picture)
{
    if (picture->renderer != BY_RASTER)
        return gl_is_built();
    return (survey->tessellated || picture->tessellation == 1) &&
           (survey->shaded || picture->shading == SHADING_SMOOTH);
}

/* Adds a sampling, or an accuracy, with the plainest picture of each renderer, with so many
 * positions; 0: as the command line says. */
static void add_plain(struct cost *cost, const char *sampling, int positions)
{
    struct configuration plain = {.tessellation = 1, .positions = positions};
    add(cost, plain, sampling);
    plain.renderer = BY_LLVMPIPE;
    if (gl_is_built())
        add(cost, plain, sampling);
}

void configurations_pictures(struct cost *cost)
{
    static const char *const errors[] = {"2", "1", "0.5", "0.2", "0.1"};
    const char *good = cost->chosen[GOOD];
    struct configuration fine = finest(cost);
    char accuracy[SAMPLING_NAME];
    for (int i = 0; i < N_CHOSEN; i++)
        add(cost, fine, cost->chosen[i]);
    for (int i = 0; i < N_PICTURES; i++)
        if (makes_sense(&cost->survey, &pictures[i]))
            add(cost, pictures[i], good);
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
        snprintf(accuracy, sizeof accuracy, "%s%s", accuracy_prefix, errors[i]);
        add_plain(cost, accuracy, 0);
    }
    fine.bits = 8;
    add(cost, fine, good);
    fine.bits = 32;
    add(cost, fine, good);
    fine.bits = 0;
    for (int side = 1; side < cost->survey.positions; side *= 2) {
        fine.positions = side;
        add(cost, fine, good);
        add_plain(cost, good, side);
    }
}

/* ---- combinations ---- */

/* Adds a sampling with each shading that is more accurate than all faster ones in the list. */
static void combine(struct cost *cost, const char *sampling)
{
    const char *good = cost->chosen[GOOD];
    double best = HUGE_VAL;
    for (int i = 0; i < N_PICTURES && pictures[i].renderer == BY_RASTER; i++) {
        const struct cost_entry *entry = find(cost, &pictures[i], good);
        if (!entry || entry->accuracy.n_pages == 0 || entry->accuracy.quantile_95 >= best)
            continue;
        best = entry->accuracy.quantile_95;
        add(cost, pictures[i], sampling);
    }
    if (gl_is_built())
        add(cost, (struct configuration){.tessellation = 1, .renderer = BY_LLVMPIPE}, sampling);
}

void configurations_combined(struct cost *cost)
{
    combine(cost, cost->chosen[COLOURS]);
    combine(cost, cost->chosen[SPECTRA]);
}

/* ---- notes ---- */

static bool note_positions(struct cost *cost, struct error *err)
{
    const int side = cost->survey.positions;
    return side == 1 || cost_note(cost, err,
                                  "a pixel is the mean of %d x %d positions where no samples are "
                                  "named; the standard has %d x %d",
                                  side, side, 2 * side, 2 * side);
}

bool survey_notes(struct cost *cost, struct error *err)
{
    const struct survey *survey = &cost->survey;
    const struct {
        bool holds;
        const char *note;
    } notes[] = {
        {survey->peaks,
         "a light or material has emission peaks, which plan lists for adaptive: adaptive samples "
         "them, others may miss them or give them too much weight"},
        {survey->fluorescent, "materials fluoresce: rgb and xyz cannot show this"},
        {survey->spectral_texture,
         "spectral textures leave out basis, rgb and xyz: they have radiances at wavelengths"},
        {!survey->shaded, "all shadings are the same: nothing is curved, there are no highlights, "
                          "and no light is near"},
        {!survey->tessellated,
         "no shape has slices or stacks, so that --tessellation changes nothing"},
        {!gl_is_built(),
         "this program was built without OpenGL: raster renders all configurations"}};
    bool done = note_positions(cost, err);
    for (size_t i = 0; i < sizeof notes / sizeof notes[0]; i++)
        done = done && (!notes[i].holds || cost_note(cost, err, "%s", notes[i].note));
    return done;
}
