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

/* ---- colours ---- */

/* Tristimulus values on some pages: of each material that is shown, of each of its terms. */
struct term_values {
    double (**xyz)[3]; /* owned */
    int n;
};
struct chooser {
    const struct scene *scene;
    const char *observer;
    double error; /* that is wanted */
    const struct stimuli *stimuli;
    struct fine_spectra spectra;
    double white[3];
    double (*exact)[3]; /* of each stimulus, L*, a* and b*; owned */
};

static void values_free(struct term_values *values)
{
    for (int m = 0; m < values->n; m++)
        free(values->xyz[m]);
    free(values->xyz);
    *values = (struct term_values){.n = 0};
}

bool terms_seen(const struct illumination *illumination, const struct material_terms *shown,
                const double *weights, double (*out)[3], struct error *err)
{
    const int n_pages = illumination->pages.n;
    struct material_terms made;
    if (!material_terms_make(illumination, shown->material, &made, err))
        return false;
    for (int t = 0; t < shown->n; t++)
        for (int i = 0; i < made.n; i++)
            if (made.terms[i].kind == shown->terms[t].kind &&
                made.terms[i].light == shown->terms[t].light)
                detector_response(weights, made.spectra + (size_t)i * (size_t)n_pages, n_pages,
                                  out[t]);
    material_terms_free(&made);
    return true;
}

/* Finds the values on pages, by the observer's weights of them. The caller always frees *out. */
static bool values_make(const struct chooser *chooser, const struct spectral_pages *pages,
                        const double *weights, struct term_values *out, struct error *err)
{
    const struct stimuli *stimuli = chooser->stimuli;
    struct illumination illumination;
    bool done = illumination_make(chooser->scene, pages, false, &illumination, err);
    *out = (struct term_values){.xyz = calloc((size_t)stimuli->n_materials + 1, sizeof *out->xyz)};
    done = done && (out->xyz || error_memory(err));
    for (; done && out->n < stimuli->n_materials; out->n++) {
        const struct material_terms *shown = stimuli->materials[out->n];
        double(**xyz)[3] = &out->xyz[out->n];
        if (!shown)
            continue;
        *xyz = calloc((size_t)shown->n + 1, sizeof **xyz);
        done = *xyz ? terms_seen(&illumination, shown, weights, *xyz, err) : error_memory(err);
    }
    illumination_free(&illumination);
    return done;
}

static void find_colour(const struct chooser *chooser, const struct term_values *values,
                        const struct stimulus *stimulus, double lab[3])
{
    double xyz[3] = {0, 0, 0};
    for (int t = 0; t < chooser->stimuli->materials[stimulus->material]->n; t++)
        for (int c = 0; c < 3; c++)
            xyz[c] +=
                stimulus->texel * stimulus->weights[t] * values->xyz[stimulus->material][t][c];
    cielab(xyz, chooser->white, lab);
}

/* Finds whether 95 % of the stimuli have at most the wanted error. */
static bool find_good(const struct chooser *chooser, const struct sampling *sampling, bool *good,
                      struct error *err)
{
    const struct stimuli *stimuli = chooser->stimuli;
    struct term_values values;
    const bool done = values_make(chooser, &sampling->pages, sampling->weights, &values, err);
    int bad = 0;
    for (int i = 0; done && i < stimuli->n && bad <= stimuli->n / 20; i++) {
        double lab[3];
        find_colour(chooser, &values, &stimuli->list[i], lab);
        bad += ciede2000_difference(chooser->exact[i], lab) > chooser->error;
    }
    *good = bad <= stimuli->n / 20;
    values_free(&values);
    return done;
}

/* ---- candidates ---- */

/* A sampling that is good enough, of the fewest pages so far. */
struct chosen {
    struct sampling_method method;
    int pages; /* 0: none yet */
};

/* Tries a method. *pages: how many it takes; 0: it refuses the scene. */
static bool try_method(const struct chooser *chooser, const struct sampling_method *method,
                       struct chosen *best, int *pages, struct error *err)
{
    struct error refusal = {.status = EXIT_AGREED};
    struct sampling sampling = {.detector = NULL};
    bool done = true, good = false;
    *pages = 0;
    if (sampling_make(method, chooser->observer, &chooser->spectra, &sampling, &refusal)) {
        *pages = sampling.pages.n;
        if (best->pages == 0 || *pages < best->pages)
            done = find_good(chooser, &sampling, &good, err);
    } else if (refusal.status == EXIT_SYSTEM) {
        *err = refusal;
        done = false;
    }
    if (done && good)
        *best = (struct chosen){*method, *pages};
    sampling_free(&sampling);
    return done;
}

/* Tries the methods of one kind, from few pages to many, until one is good enough or has as many
 * pages as the best one. */
static bool try_all(const struct chooser *chooser, const struct sampling_method *methods, int n,
                    struct chosen *best, struct error *err)
{
    const int before = best->pages;
    for (int i = 0; i < n && best->pages == before; i++) {
        int pages;
        if (!try_method(chooser, &methods[i], best, &pages, err))
            return false;
        if (before > 0 && pages >= before)
            break;
    }
    return true;
}

/* A page at every nm is the standard: if nothing else is good enough, it is. */
static bool choose(const struct chooser *chooser, struct chosen *out, struct error *err)
{
    static const int counts[] = {3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20, 24, 28, 32, 40, 48, 64};
    static const double steps_nm[] = {20, 15, 12, 10, 8, 6, 5, 4, 3, 2, 1},
                        tolerances[] = {0.03, 3e-3, 3e-4};
    enum {
        N_COUNTS = sizeof counts / sizeof *counts,
        N_STEPS = sizeof steps_nm / sizeof *steps_nm,
        N_TOLERANCES = sizeof tolerances / sizeof *tolerances
    };
    struct sampling_method methods[N_COUNTS];
    for (int i = 0; i < N_COUNTS; i++)
        methods[i] = (struct sampling_method){.kind = SAMPLING_GAUSS, .count = counts[i]};
    if (!try_all(chooser, methods, N_COUNTS, out, err))
        return false;
    for (int i = 0; i < N_TOLERANCES; i++)
        methods[i] =
            (struct sampling_method){.kind = SAMPLING_ADAPTIVE, .tolerance = tolerances[i]};
    if (!try_all(chooser, methods, N_TOLERANCES, out, err))
        return false;
    for (int i = 0; i < N_STEPS; i++)
        methods[i] = (struct sampling_method){.kind = SAMPLING_RIEMANN, .step_nm = steps_nm[i]};
    if (!try_all(chooser, methods, N_STEPS, out, err))
        return false;
    if (out->pages == 0) /* every nm is refused: whoever samples the scene says why */
        out->method = methods[N_STEPS - 1];
    return true;
}

/* ---- the standard ---- */

bool white_seen(const struct scene *scene, const struct spectral_pages *pages,
                const double *weights, double white[3], struct error *err)
{
    double *radiance = calloc((size_t)pages->n, sizeof *radiance);
    if (!radiance)
        return error_memory(err);
    const bool lit = scene_white(scene, pages, radiance) > 0;
    detector_response(weights, lit ? radiance : NULL, pages->n, white);
    if (!(white[0] > 0 || white[1] > 0 || white[2] > 0))
        detector_response(weights, NULL, pages->n, white);
    free(radiance);
    return true;
}

/* Finds the colours at every nm. */
static bool find_exact(struct chooser *chooser, const struct fine_detector *fine, struct error *err)
{
    const struct stimuli *stimuli = chooser->stimuli;
    const struct spectral_pages pages = {.n = fine->n, .wavelength_nm = fine->nm};
    struct term_values values = {.n = 0};
    chooser->exact = calloc((size_t)stimuli->n + 1, sizeof *chooser->exact);
    const bool done = (chooser->exact || error_memory(err)) &&
                      white_seen(chooser->scene, &pages, fine->weights, chooser->white, err) &&
                      values_make(chooser, &pages, fine->weights, &values, err);
    for (int i = 0; done && i < stimuli->n; i++)
        find_colour(chooser, &values, &stimuli->list[i], chooser->exact[i]);
    values_free(&values);
    return done;
}

bool sampling_choose(const struct scene *scene, const char *observer, double error,
                     const struct stimuli *stimuli, struct sampling_method *out, struct error *err)
{
    struct chooser chooser = {
        .scene = scene, .observer = observer, .error = error, .stimuli = stimuli};
    struct detector detector = {.name = NULL};
    struct fine_detector fine = {.nm = NULL};
    struct chosen best = {.pages = 0};
    const bool done =
        observer_read(observer, &detector, err) && scene_spectra(scene, &chooser.spectra, err) &&
        fine_detector_make(&detector, chooser.spectra.first_nm, chooser.spectra.n_nm, &fine, err) &&
        find_exact(&chooser, &fine, err) && choose(&chooser, &best, err);
    *out = best.method;
    free(chooser.exact);
    fine_detector_free(&fine);
    fine_spectra_free(&chooser.spectra);
    detector_free(&detector);
    return done;
}
