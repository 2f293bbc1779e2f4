/* SPDX-License-Identifier: MIT */
/* Chooses a sampling by the colours of a scene: candidates are tried from few pages to many. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/choice/choice.h"
#include "data/colour/colour.h"

/* ---- the words of the option ---- */

bool accuracy_read(const char *option, const char *text, struct wanted_accuracy *out,
                   struct error *err)
{
    static const char counts[] = "counts";
    const double finest = 1e-3, coarsest = 1e5;
    const size_t length = strlen(text), tail = strlen(counts);
    struct word word = {.start = text, .length = length, .place = {option, 1, 1}};
    out->counts = length > tail && strcmp(text + length - tail, counts) == 0;
    word.length -= out->counts ? tail : 0;
    return word_number(&word, "error", finest, coarsest, &out->error, err);
}

bool accuracy_accepts(const char *option, const char *value, struct error *err)
{
    struct wanted_accuracy wanted;
    return accuracy_read(option, value, &wanted, err);
}

/* ---- the colours of a scene ---- */

/* Tristimulus values of the terms of all materials, on some pages. */
struct term_values {
    struct illumination illumination;
    struct material_terms *materials; /* owned */
    double (**xyz)[3];                /* of each material, of each term; owned */
    int n;
};
struct chooser {
    const struct scene *scene;
    const char *observer;
    const struct material **materials; /* owned */
    int n;
    struct fine_spectra spectra;
    struct term_values exact; /* at every nm */
    double white[3];
};

static void values_free(struct term_values *values)
{
    for (int m = 0; m < values->n; m++) {
        material_terms_free(&values->materials[m]);
        free(values->xyz[m]);
    }
    free(values->materials);
    free(values->xyz);
    illumination_free(&values->illumination);
    *values = (struct term_values){.n = 0};
}

static bool add_material(struct term_values *out, const struct material *material,
                         const double *weights, struct error *err)
{
    struct material_terms *terms = &out->materials[out->n];
    const int n_pages = out->illumination.pages.n;
    if (!material_terms_make(&out->illumination, material, terms, err))
        return false;
    out->xyz[out->n] = calloc((size_t)terms->n + 1, sizeof *out->xyz[out->n]);
    if (!out->xyz[out->n++])
        return error_memory(err);
    for (int t = 0; t < terms->n; t++)
        detector_response(weights, terms->spectra + (size_t)t * (size_t)n_pages, n_pages,
                          out->xyz[out->n - 1][t]);
    return true;
}

/* Finds the values on pages, by the observer's weights of them. The caller always frees *out. */
static bool values_make(const struct chooser *chooser, const struct spectral_pages *pages,
                        const double *weights, struct term_values *out, struct error *err)
{
    *out = (struct term_values){.n = 0};
    if (!illumination_make(chooser->scene, pages, false, &out->illumination, err))
        return false;
    out->materials = calloc((size_t)chooser->n + 1, sizeof *out->materials);
    out->xyz = calloc((size_t)chooser->n + 1, sizeof *out->xyz);
    bool done = (out->materials && out->xyz) || error_memory(err);
    for (int m = 0; done && m < chooser->n; m++)
        done = add_material(out, chooser->materials[m], weights, err);
    return done;
}

/* A colour is the sum of some terms: the constant one; those of one light, or of all (-1); with its
 * highlight or without. */
struct colour_of {
    int light;
    bool constant, diffuse, specular;
};

static bool has_part(const struct spectral_term *term, const struct colour_of *colour)
{
    const bool lit = colour->light < 0 || term->light == colour->light;
    return term->kind == TERM_CONSTANT  ? colour->constant
           : term->kind == TERM_DIFFUSE ? colour->diffuse && lit
                                        : colour->specular && lit;
}

static void find_colour(const struct chooser *chooser, const struct term_values *values,
                        int material, const struct colour_of *colour, double lab[3])
{
    double xyz[3] = {0, 0, 0};
    for (int t = 0; t < values->materials[material].n; t++)
        for (int c = 0; c < 3 && has_part(&values->materials[material].terms[t], colour); c++)
            xyz[c] += values->xyz[material][t][c];
    cielab(xyz, chooser->white, lab);
}

static double difference(const struct chooser *chooser, const struct term_values *values,
                         int material, const struct colour_of *colour)
{
    double exact[3], seen[3];
    find_colour(chooser, &chooser->exact, material, colour, exact);
    find_colour(chooser, values, material, colour, seen);
    return ciede2000_difference(exact, seen);
}

/* Returns the largest difference of a material's colours. */
static double worst_of(const struct chooser *chooser, const struct term_values *values,
                       int material)
{
    const struct illumination *illumination = &values->illumination;
    const struct colour_of ambient = {-1, true, false, false};
    double worst = difference(chooser, values, material, &ambient);
    for (int i = -1; i < illumination->n_first; i++) {
        const int light = i < 0 ? -1 : illumination->first[i];
        const struct colour_of diffuse = {light, true, true, false},
                               shiny = {light, true, true, true};
        worst = fmax(worst, difference(chooser, values, material, &diffuse));
        worst = fmax(worst, difference(chooser, values, material, &shiny));
    }
    return worst;
}

/* Finds the largest difference that a sampling makes. */
static bool find_error(const struct chooser *chooser, const struct sampling *sampling, double *out,
                       struct error *err)
{
    struct term_values values;
    const bool done = values_make(chooser, &sampling->pages, sampling->weights, &values, err);
    *out = 0;
    for (int m = 0; done && m < chooser->n; m++)
        *out = fmax(*out, worst_of(chooser, &values, m));
    values_free(&values);
    return done;
}

/* ---- candidates ---- */

/* A sampling that is good enough, of the fewest pages so far. */
struct chosen {
    struct sampling_method method;
    double error;
    int pages; /* 0: none yet */
};

/* Tries a method. *pages: how many it takes; 0: it refuses the scene. */
static bool try_method(const struct chooser *chooser, const struct sampling_method *method,
                       double wanted, struct chosen *best, int *pages, struct error *err)
{
    struct error refusal = {.status = EXIT_AGREED};
    struct sampling sampling = {.detector = NULL};
    double error;
    *pages = 0;
    if (!sampling_make(method, chooser->observer, &chooser->spectra, &sampling, &refusal)) {
        sampling_free(&sampling);
        if (refusal.status == EXIT_SYSTEM)
            *err = refusal;
        return refusal.status != EXIT_SYSTEM;
    }
    *pages = sampling.pages.n;
    bool done = best->pages > 0 && *pages >= best->pages;
    if (!done && (done = find_error(chooser, &sampling, &error, err)) && error <= wanted)
        *best = (struct chosen){*method, error, *pages};
    sampling_free(&sampling);
    return done;
}

/* Tries the methods of one kind, from few pages to many, until one is good enough or has as many
 * pages as the best one. */
static bool try_all(const struct chooser *chooser, const struct sampling_method *methods, int n,
                    double wanted, struct chosen *best, struct error *err)
{
    const int before = best->pages;
    for (int i = 0; i < n && best->pages == before; i++) {
        int pages;
        if (!try_method(chooser, &methods[i], wanted, best, &pages, err))
            return false;
        if (before > 0 && pages >= before)
            break;
    }
    return true;
}

/* A page at every nm is the standard, and always good enough. */
static bool choose(const struct chooser *chooser, double wanted, struct chosen *out,
                   struct error *err)
{
    static const int counts[] = {3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20, 24, 28, 32, 40, 48, 64};
    static const double steps_nm[] = {20, 10, 5, 4, 3, 2, 1}, tolerances[] = {0.03, 3e-3, 3e-4};
    enum {
        N_COUNTS = sizeof counts / sizeof *counts,
        N_STEPS = sizeof steps_nm / sizeof *steps_nm,
        N_TOLERANCES = sizeof tolerances / sizeof *tolerances
    };
    struct sampling_method methods[N_COUNTS];
    for (int i = 0; i < N_COUNTS; i++)
        methods[i] = (struct sampling_method){.kind = SAMPLING_GAUSS, .count = counts[i]};
    if (!try_all(chooser, methods, N_COUNTS, wanted, out, err))
        return false;
    for (int i = 0; i < N_TOLERANCES; i++)
        methods[i] =
            (struct sampling_method){.kind = SAMPLING_ADAPTIVE, .tolerance = tolerances[i]};
    if (!try_all(chooser, methods, N_TOLERANCES, wanted, out, err))
        return false;
    for (int i = 0; i < N_STEPS; i++)
        methods[i] = (struct sampling_method){.kind = SAMPLING_RIEMANN, .step_nm = steps_nm[i]};
    return try_all(chooser, methods, N_STEPS, wanted, out, err);
}

/* ---- the standard ---- */

static bool find_white(struct chooser *chooser, const struct spectral_pages *pages,
                       const double *weights, struct error *err)
{
    double *radiance = calloc((size_t)pages->n, sizeof *radiance);
    if (!radiance)
        return error_memory(err);
    const bool lit = scene_white(chooser->scene, pages, radiance) > 0;
    detector_response(weights, lit ? radiance : NULL, pages->n, chooser->white);
    free(radiance);
    return true;
}

/* Makes the colours at every nm. */
static bool open_standard(struct chooser *chooser, const struct detector *detector,
                          struct error *err)
{
    struct fine_detector fine;
    bool done =
        fine_detector_make(detector, chooser->spectra.first_nm, chooser->spectra.n_nm, &fine, err);
    const struct spectral_pages pages = {.n = fine.n, .wavelength_nm = fine.nm};
    done = done && find_white(chooser, &pages, fine.weights, err) &&
           values_make(chooser, &pages, fine.weights, &chooser->exact, err);
    /* what is left of the standard needs no pages */
    fine_detector_free(&fine);
    return done;
}

bool sampling_choose(const struct scene *scene, const char *observer, double error,
                     struct sampling_method *out, double *predicted, struct error *err)
{
    struct chooser chooser = {.scene = scene, .observer = observer};
    struct detector detector = {.name = NULL};
    struct chosen best = {.pages = 0};
    const bool done =
        observer_read(observer, &detector, err) && scene_spectra(scene, &chooser.spectra, err) &&
        materials_shown(scene, &chooser.materials, &chooser.n, err) &&
        open_standard(&chooser, &detector, err) && choose(&chooser, error, &best, err);
    *out = best.method;
    *predicted = best.error;
    values_free(&chooser.exact);
    fine_spectra_free(&chooser.spectra);
    free(chooser.materials);
    detector_free(&detector);
    return done;
}
