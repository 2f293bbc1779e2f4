/* SPDX-License-Identifier: MIT */
/* Chooses the configurations of render that make sense for a scene. First one property varies at a
 * time (sampling, shading, renderer, depth); then the best values are combined. */
#include <math.h>
#include <string.h>

#include "data/mesh/mesh.h"
#include "raster/beside/cost/inside.h"
#include "raster/renderers/renderers.h"

/* ---- a configuration in words ---- */

/* A way to draw: its name, and the options of render. */
struct style {
    const char *name, *options;
    bool is_shaded, is_finer; /* only where shadings differ; only where there are slices, ... */
};
/* The reference's styles, roughly in the order of their time, the fastest first; then OpenGL's,
 * with smooth shading: OpenGL lights vertices only. */
static const struct style styles[] = {
    {"flat", "--shading=flat --renderer=raster --no-check", true, false},
    {"smooth", "--shading=smooth --renderer=raster --no-check", false, false},
    {"phong", "--shading=phong --renderer=raster --no-check", true, false},
    {"flat x2", "--shading=flat --tessellation=2 --renderer=raster --no-check", true, true},
    {"smooth x2", "--shading=smooth --tessellation=2 --renderer=raster --no-check", false, true},
    {"phong x2", "--shading=phong --tessellation=2 --renderer=raster --no-check", true, true},
    {"flat x4", "--shading=flat --tessellation=4 --renderer=raster --no-check", true, true},
    {"smooth x4", "--shading=smooth --tessellation=4 --renderer=raster --no-check", false, true},
    {"phong x4", "--shading=phong --tessellation=4 --renderer=raster --no-check", true, true},
    {"smooth llvmpipe", "--shading=smooth --renderer=llvmpipe --no-check", false, false},
    {"smooth llvmpipe buffer 16", "--shading=smooth --renderer=llvmpipe --no-check --buffer=16",
     false, false},
    {"smooth llvmpipe buffer 8", "--shading=smooth --renderer=llvmpipe --no-check --buffer=8",
     false, false},
    {"smooth llvmpipe checked", "--shading=smooth --renderer=llvmpipe", false, false},
    {"smooth softpipe", "--shading=smooth --renderer=softpipe --no-check", false, false},
    {"smooth gl-shader:llvmpipe", "--shading=smooth --renderer=gl-shader:llvmpipe --no-check",
     false, false}};
enum { PLAIN = 1, BY_PIXEL = 2, FINEST = 8, LLVMPIPE = 9, N_STYLES = 15 };

/* Returns the style that samplings, and then depths and positions, are tried with. */
static const struct style *finest(const struct cost *cost)
{
    return &styles[cost->tessellated ? FINEST : BY_PIXEL];
}

/* An accuracy stands in place of a sampling: wavelengths stay, and shapes are divided. */
bool entry_words(struct cost_entry *entry, const char *observer, struct error *err)
{
    static const char accuracy[] = "accuracy:";
    const char *sampling = entry->sampling;
    struct printed words = {.text = NULL}; /* a NUL ends each of them */
    if (strncmp(sampling, accuracy, strlen(accuracy)) == 0)
        print(&words, "--accuracy=%s%c", sampling + strlen(accuracy), '\0');
    else if (sampling[0])
        print(&words, "--sampling=%s%c", sampling, '\0');
    if (sampling[0] && strcmp(observer, "cie1931") != 0)
        print(&words, "--detector=%s%c", observer, '\0');
    for (const char *at = entry->options; *at; at += strspn(at, " ")) {
        const size_t length = strcspn(at, " ");
        print(&words, "%.*s%c", (int)length, at, '\0');
        at += length;
    }
    entry->text = printed_take(&words, err);
    for (size_t at = 0; entry->text && at < words.length; at += strlen(entry->text + at) + 1)
        entry->words[entry->n_words++] = entry->text + at;
    return entry->text != NULL;
}

/* Means are judged by those of twice as many positions a side. Float pages hold the same radiances
 * at any full scale. Without --full-scale, render refuses phong shading where it finds no largest
 * radiance. */
struct cost_entry standard_entry(const struct cost *cost)
{
    struct cost_entry entry = {.sampling = "riemann:1"};
    snprintf(entry.options, sizeof entry.options, "%s --samples=%d --depth=32f --full-scale=65535",
             styles[FINEST].options, cost->positions > 1 ? 2 * cost->positions : 1);
    return entry;
}

/* ---- the scene ---- */

/* Surveys a material, and the partner that its file gives it. */
static void survey_material(const struct material *material, struct cost *out, bool *glossy)
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
static void survey_picture(const struct scene *scene, struct cost *out)
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

/* Leaves room for a standard of more positions. */
static bool check_positions(const struct scene *scene, struct error *err)
{
    return 2 * scene->positions <= MOST_POSITIONS || scene->positions == 1 ||
           error_usage(err, "cost takes --samples up to %d: its standard has twice as many",
                       MOST_POSITIONS / 2);
}

bool survey_scene(const struct scene *scene, const struct options *options, struct cost *out,
                  struct error *err)
{
    struct printed name = {.text = NULL};
    print_text(&name, scene->path);
    for (int i = 0; i < options->n_recorded; i++)
        print(&name, " %s", options->recorded[i]);
    out->width = scene->width;
    out->height = scene->height;
    out->positions = scene->positions;
    survey_picture(scene, out);
    out->scene = printed_take(&name, err);
    return out->scene && check_positions(scene, err);
}

/* ---- one axis after the other ---- */

/* Returns the entry of a sampling with these options; NULL: there is none. */
static const struct cost_entry *find(const struct cost *cost, const char *sampling,
                                     const char *options)
{
    for (int i = 0; i < cost->n; i++)
        if (strcmp(cost->entries[i].sampling, sampling) == 0 &&
            strcmp(cost->entries[i].options, options) == 0)
            return &cost->entries[i];
    return NULL;
}

/* Adds a sampling with a style, and perhaps one more option as "depth 8" ("": none), unless it is
 * there already, there is no room, or this program has no OpenGL for it. */
static void add(struct cost *cost, const char *sampling, const struct style *style,
                const char *more)
{
    struct cost_entry *entry = &cost->entries[cost->n];
    const int named = (int)strcspn(more, " ");
    if (cost->n == MOST_CONFIGURATIONS || (style >= styles + LLVMPIPE && !gl_is_built()))
        return;
    *entry = (struct cost_entry){.n_words = 0};
    snprintf(entry->sampling, sizeof entry->sampling, "%s", sampling);
    snprintf(entry->options, sizeof entry->options, named ? "%s --%.*s=%s" : "%s", style->options,
             named, more, more + named + 1);
    snprintf(entry->name, sizeof entry->name, "%s %s%s%s",
             sampling[0] ? sampling : "own wavelengths", style->name, named ? " " : "", more);
    cost->n += !find(cost, entry->sampling, entry->options);
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

/* These two find the emission peaks and the rank of the products of lights and reflectances. */
void configurations_first(struct cost *cost)
{
    add(cost, "adaptive:0.01", finest(cost), "");
    if (!cost->spectral_texture)
        add(cost, "basis:1", finest(cost), "");
}

/* Adds bases of the first few components, and of all. */
static void add_bases(struct cost *cost, int rank)
{
    char name[SAMPLING_NAME];
    for (int n = 1; n < 2 * rank && n <= 16; n *= 2) {
        snprintf(name, sizeof name, "basis:%d", n < rank && n <= 8 ? n : rank);
        add(cost, name, finest(cost), "");
    }
}

void configurations_samplings(struct cost *cost)
{
    const char *options = finest(cost)->options;
    const struct cost_entry *adaptive = find(cost, "adaptive:0.01", options),
                            *basis = find(cost, "basis:1", options);
    cost->peaks = adaptive->accuracy.n_peaks > 0;
    for (size_t i = 0; i < sizeof samplings / sizeof samplings[0]; i++)
        if (samplings[i].under != (cost->peaks ? SMOOTH_LIGHT : LINES))
            add(cost, samplings[i].name, finest(cost), "");
    if (!basis)
        return;
    add(cost, "rgb", finest(cost), "");
    add(cost, "xyz", finest(cost), "");
    add_bases(cost, basis->accuracy.rank);
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
 * within it, returns the most accurate one. All entries have the finest style so far. */
static const char *leanest(const struct cost *cost, double tolerance, enum content content)
{
    const struct cost_entry *best = NULL;
    double least = HUGE_VAL;
    for (int i = 0; i < cost->n; i++) {
        const struct cost_entry *entry = &cost->entries[i];
        const double error = fmax(entry->accuracy.quantile_95, tolerance);
        if (entry->accuracy.n_pages == 0 || !has_content(entry, content))
            continue;
        if (!best || error < least ||
            (error <= least && entry->accuracy.n_pages < best->accuracy.n_pages)) {
            best = entry;
            least = error;
        }
    }
    return best ? best->sampling : "";
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

void configurations_styles(struct cost *cost)
{
    static const char *const accuracies[] = {"accuracy:2", "accuracy:1", "accuracy:0.5",
                                             "accuracy:0.2", "accuracy:0.1"};
    const char *good = cost->chosen[GOOD];
    char more[24];
    for (int i = 0; i < N_CHOSEN; i++)
        add(cost, cost->chosen[i], finest(cost), "");
    for (int i = 0; i < N_STYLES; i++)
        if ((cost->shaded || !styles[i].is_shaded) && (cost->tessellated || !styles[i].is_finer))
            add(cost, good, &styles[i], "");
    for (size_t i = 0; i < sizeof accuracies / sizeof *accuracies; i++) {
        add(cost, accuracies[i], &styles[PLAIN], "");
        add(cost, accuracies[i], &styles[LLVMPIPE], "");
    }
    add(cost, good, finest(cost), "depth 8");
    add(cost, good, finest(cost), "depth 32f");
    for (int side = 1; side < cost->positions; side *= 2) {
        snprintf(more, sizeof more, "samples %d", side);
        add(cost, good, finest(cost), more);
        add(cost, good, &styles[PLAIN], more);
        add(cost, good, &styles[LLVMPIPE], more);
    }
}

/* ---- combinations ---- */

/* Adds a sampling with each shading that is more accurate than all faster ones in the list. */
static void combine(struct cost *cost, const char *sampling)
{
    double best = HUGE_VAL;
    for (int i = 0; i < LLVMPIPE; i++) {
        const struct cost_entry *entry = find(cost, cost->chosen[GOOD], styles[i].options);
        if (!entry || entry->accuracy.n_pages == 0 || entry->accuracy.quantile_95 >= best)
            continue;
        best = entry->accuracy.quantile_95;
        add(cost, sampling, &styles[i], "");
    }
    add(cost, sampling, &styles[LLVMPIPE], "");
}

void configurations_combined(struct cost *cost)
{
    combine(cost, cost->chosen[COLOURS]);
    combine(cost, cost->chosen[SPECTRA]);
}

/* ---- notes ---- */

static bool note_positions(struct cost *cost, struct error *err)
{
    const int side = cost->positions;
    return side == 1 || cost_note(cost, err,
                                  "a pixel is the mean of %d x %d positions where no samples are "
                                  "named; the standard has %d x %d",
                                  side, side, 2 * side, 2 * side);
}

bool survey_notes(struct cost *cost, bool lit, struct error *err)
{
    const struct {
        bool holds;
        const char *note;
    } notes[] = {
        {cost->peaks,
         "a light or material has emission peaks, which plan lists for adaptive: adaptive samples "
         "them, others may miss them or give them too much weight"},
        {cost->fluorescent, "materials fluoresce: rgb and xyz cannot show this"},
        {cost->spectral_texture,
         "spectral textures leave out basis, rgb and xyz: they have radiances at wavelengths"},
        {!cost->shaded, "all shadings are the same: nothing is curved, there are no highlights, "
                        "and no light is near"},
        {!cost->tessellated,
         "no shape has slices or stacks, so that --tessellation changes nothing"},
        {!gl_is_built(),
         "this program was built without OpenGL: raster renders all configurations"},
        {!lit, "the observer sees no light: the white is a radiance of 1"}};
    bool done = note_positions(cost, err);
    for (size_t i = 0; i < sizeof notes / sizeof notes[0]; i++)
        done = done && (!notes[i].holds || cost_note(cost, err, "%s", notes[i].note));
    return done;
}
