/* SPDX-License-Identifier: MIT */
/* Makes samplings, samples scenes, and describes samplings in words. */
#include "data/sampling/inside.h"

/* ---- arrays ---- */

bool sampling_numbers(double **out, size_t count, struct error *err)
{
    return MAKE_ARRAY(*out, count, err, "%zu numbers of a sampling", count);
}

bool sampling_room(struct sampling *out, int n, int arrays, struct error *err)
{
    const size_t cells = (size_t)n * (size_t)out->fine.n;
    out->pages.n = n;
    return sampling_numbers(&out->pages.wavelength_nm, (size_t)n, err) &&
           sampling_numbers(&out->weights, (size_t)out->fine.n_channels * (size_t)n, err) &&
           (!(arrays & SEGMENTS) || MAKE_ARRAY(out->segment_nm, n, err, "%d segments", n)) &&
           (!(arrays & ANALYSIS) || sampling_numbers(&out->pages.analysis, cells, err)) &&
           (!(arrays & SYNTHESIS) || sampling_numbers(&out->synthesis, cells, err));
}

bool fine_detector_make(const struct detector *detector, double first_nm, int n,
                        struct fine_detector *out, struct error *err)
{
    *out = (struct fine_detector){.n = n, .n_channels = detector->n};
    if (!sampling_numbers(&out->nm, (1 + (size_t)detector->n) * (size_t)n, err))
        return false;
    out->weights = out->nm + n;
    for (int j = 0; j < n; j++)
        out->nm[j] = first_nm + j;
    detector_weights(detector, out->nm, n, out->weights);
    return true;
}

double sampling_seen(const struct sampling *sampling, int j)
{
    const struct fine_detector *fine = &sampling->fine;
    double sum = 0;
    for (int channel = 0; channel < fine->n_channels; channel++)
        sum += fabs(fine->weights[channel * fine->n + j]);
    return sum;
}

/* ---- between wavelengths ---- */

/* Makes the synthesis of pages that are radiances at wavelengths: linear between them, constant
 * beyond the ends. */
static bool make_synthesis(struct sampling *out, struct error *err)
{
    const double *nm = out->pages.wavelength_nm;
    const int n = out->pages.n;
    const bool done = sampling_numbers(&out->synthesis, (size_t)n * (size_t)out->fine.n, err);
    for (int j = 0; done && j < out->fine.n; j++) {
        const double at = out->pages.first_nm + j;
        const int after = samples_up_to(nm, n, at), before = after - 1;
        double *row = out->synthesis + (size_t)j * (size_t)n;
        if (before < 0 || after == n) {
            row[before < 0 ? 0 : before] = 1;
            continue;
        }
        row[after] = (at - nm[before]) / (nm[after] - nm[before]);
        row[before] = 1 - row[after];
    }
    return done;
}

/* ---- weights ---- */

static bool sees(const struct detector *detector, double nm)
{
    bool seen = false;
    for (int channel = 0; channel < detector->n; channel++)
        seen = seen || spectrum_at(&detector->sensitivity[channel], nm, SPECTRUM_ZERO) != 0;
    return seen;
}

/* No detector sees as far as this, but a file may claim any segment. */
enum { MOST_CELLS = 1000000 };

/* Finds the weights of the pages of one segment, at nm[0] to nm[pages - 1]; out[channel * n + i],
 * which is 0 before. Cells are weighed one by one, which needs no memory. */
static void weigh_segment(const struct detector *detector, const double *nm,
                          const double segment[2], int pages, int n, double *out)
{
    const int cells = (int)fmax(0, fmin(floor(segment[1] - segment[0] + 0.5), MOST_CELLS));
    for (int j = 0; j < cells; j++) {
        const double x = segment[0] + 0.5 + j;
        double cell[MOST_CHANNELS];
        if (!sees(detector, x))
            continue;
        detector_weights(detector, &x, 1, cell);
        for (int i = 0; i < pages; i++) {
            const double part = quadrature_lagrange(nm, pages, i, x);
            for (int channel = 0; channel < detector->n; channel++)
                out[channel * n + i] += cell[channel] * part;
        }
    }
}

void sampling_weights(const struct detector *detector, const double *wavelength_nm,
                      double (*segment_nm)[2], int n, double *out)
{
    for (int page = 0, pages; page < n; page += pages) {
        pages = 1;
        while (page + pages < n && segment_nm[page + pages][0] == segment_nm[page][0] &&
               segment_nm[page + pages][1] == segment_nm[page][1])
            pages++;
        weigh_segment(detector, wavelength_nm + page, segment_nm[page], pages, n, out + page);
    }
}

/* ---- making ---- */

static bool check_detector(const struct sampling_task *task, struct error *err)
{
    const struct sampling *out = task->out;
    const struct sampling_traits *kind = &sampling_kinds[out->method.kind];
    bool sees = kind->flags & ANY_DETECTOR;
    for (int j = 0; j < out->fine.n; j++)
        sees = sees || sampling_seen(out, j) > 0;
    if (task->detector->n != 3 && !(kind->flags & ANY_CHANNELS))
        return error_usage(err,
                           "%s needs three channels, and %s has %d; riemann, gauss:N and "
                           "gauss:N,open take any number",
                           task->name, out->detector, task->detector->n);
    if (kind->flags & NEEDS_OBSERVER && !task->detector->observer)
        return error_usage(err, "%s needs an observer; %s is a camera or film", task->name,
                           out->detector);
    return sees || error_usage(err, "%s: %s sees nothing from %.6g to %.6g nm", task->name,
                               out->detector, out->fine.nm[0], out->fine.nm[out->fine.n - 1]);
}

/* Completes the sampling by what follows from its pages and segments. */
static bool complete(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    double *wavelength_nm = out->pages.wavelength_nm;
    const struct sampling_traits *kind = &sampling_kinds[out->method.kind];
    out->spectral = !(kind->flags & COMPONENTS);
    out->fixed = kind->flags & FIXED;
    for (int page = 0; !out->spectral && page < out->pages.n; page++)
        wavelength_nm[page] = page + 1;
    if (out->segment_nm)
        sampling_weights(task->detector, wavelength_nm, out->segment_nm, out->pages.n,
                         out->weights);
    return out->pages.analysis || make_synthesis(out, err);
}

bool sampling_make(const struct sampling_method *method, const char *detector,
                   const struct fine_spectra *spectra, struct sampling *out, struct error *err)
{
    struct detector sees;
    struct sampling_task task = {
        .count = (int)method->number, .detector = &sees, .spectra = spectra, .out = out};
    *out = (struct sampling){.method = *method,
                             .pages = {.first_nm = spectra->first_nm, .n_nm = spectra->n_nm}};
    sampling_name(method, task.name);
    const bool done =
        channels_read(detector, &sees, err) && string_copy(sees.name, &out->detector, err) &&
        fine_detector_make(&sees, spectra->first_nm, spectra->n_nm, &out->fine, err) &&
        check_detector(&task, err) && sampling_kinds[method->kind].make(&task, err) &&
        complete(&task, err);
    detector_free(&sees);
    if (!done)
        sampling_free(out);
    return done;
}

/* ---- scenes that are sampled ---- */

/* Refuses spectral textures where pages are components. */
static bool refuse_textures(const struct scene *scene, const struct sampling *sampling,
                            struct error *err)
{
    const struct material **materials, *refused = NULL;
    char name[SAMPLING_NAME];
    int n;
    if (!materials_shown(scene, &materials, &n, err))
        return false;
    for (int i = 0; i < n && refused == NULL; i++)
        if (materials[i]->spectral_texture)
            refused = materials[i];
    free(materials);
    sampling_name(&sampling->method, name);
    return refused == NULL ||
           error_at(err, refused->texture_place,
                    "%s has no wavelengths to take a spectral texture at; box, riemann, gauss and "
                    "adaptive have",
                    name);
}

static bool replace_wavelengths(struct scene *scene, const struct sampling *sampling,
                                struct error *err)
{
    const double *nm = sampling->pages.wavelength_nm;
    scene->n_wavelengths = 0;
    for (int i = 0; i < sampling->pages.n; i++)
        if (!array_add(&scene->wavelengths_nm, &scene->n_wavelengths, &nm[i], sizeof *nm, err))
            return false;
    return true;
}

bool scene_sample(struct scene *scene, const struct sampling_method *method, const char *detector,
                  struct sampling *out, struct error *err)
{
    struct fine_spectra spectra = {.n_nm = 0};
    *out = (struct sampling){.detector = NULL};
    const bool done = scene_spectra(scene, &spectra, err) &&
                      sampling_make(method, detector, &spectra, out, err) &&
                      (out->spectral || refuse_textures(scene, out, err)) &&
                      replace_wavelengths(scene, out, err);
    FREE_ALL(spectra.lights, spectra.products);
    return done;
}

/* ---- in words ---- */

void sampling_label(const struct sampling_method *method, int page, char out[24])
{
    const struct sampling_traits *kind = &sampling_kinds[method->kind];
    out[0] = '\0';
    if (kind->labels)
        snprintf(out, 24, "%s", kind->labels[page]);
    else if (kind->flags & COMPONENTS)
        snprintf(out, 24, "component %d", page + 1);
}

/* Prints how many weights are negative, and the least one in parts of its channel's sum. Channels
 * that see nothing, or as much negative as positive, have no parts. */
static void print_negative(const struct sampling *sampling, struct printed *to)
{
    const int n = sampling->pages.n, n_channels = sampling->fine.n_channels;
    double most_negative = 0;
    int n_negative = 0;
    for (int channel = 0; channel < n_channels; channel++) {
        const double *weights = sampling->weights + channel * n;
        double sum = 0, least = 0;
        for (int page = 0; page < n; page++) {
            sum += weights[page];
            least = fmin(least, weights[page]);
            n_negative += weights[page] < 0;
        }
        if (sum > 0)
            most_negative = fmin(most_negative, least / sum);
    }
    if (n_negative > 0)
        print(to, ", %d of %d weights negative (%.2g %%)", n_negative, n_channels * n,
              100 * most_negative);
}

static void print_peaks(const struct sampling *sampling, struct printed *to)
{
    enum { MOST = 8 };
    print(to, ", %d emission peak%s", sampling->n_peaks, sampling->n_peaks == 1 ? "" : "s");
    for (int i = 0; i < sampling->n_peaks && i < MOST; i++)
        print(to, "%s%.6g", i == 0 ? " (" : ", ", sampling->peak_nm[i]);
    if (sampling->n_peaks > 0)
        print_text(to, sampling->n_peaks > MOST ? ", ... nm)" : " nm)");
}

/* Most components have negative weights, which are therefore not reported. */
void sampling_print(const struct sampling *sampling, struct printed *to)
{
    char name[SAMPLING_NAME];
    const struct sampling_traits *kind = &sampling_kinds[sampling->method.kind];
    sampling_name(&sampling->method, name);
    print(to, "%s for %s: %d %s", name, sampling->detector, sampling->pages.n,
          sampling->pages.n == 1 ? kind->words->page : kind->words->pages);
    if (sampling->method.kind == SAMPLING_BASIS)
        print(to, " of rank %d", sampling->rank);
    if (sampling->method.kind == SAMPLING_ADAPTIVE)
        print_peaks(sampling, to);
    if (sampling->spectral)
        print_negative(sampling, to);
    print(to, "; %s", kind->words->limit);
    if (sampling->fixed)
        print(to, "; for no detector but %s", sampling->detector);
    print_text(to, "\n");
}

void sampling_free(struct sampling *sampling)
{
    FREE_ALL(sampling->detector, sampling->pages.wavelength_nm, sampling->pages.analysis,
             sampling->pages.reflectance_analysis, sampling->segment_nm, sampling->weights,
             sampling->fine.nm, sampling->synthesis, sampling->peak_nm);
    *sampling = (struct sampling){.detector = NULL};
}
