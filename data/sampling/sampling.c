/* SPDX-License-Identifier: MIT */
/* Samplings: making them, what they make of spectra, and what they tell of themselves. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/material/material.h"
#include "data/method/method.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/terms/terms.h"
#include "spectral.h"

/* ---- what all kinds need ---- */

static bool numbers(double **out, size_t count, struct error *err)
{
    *out = calloc(count, sizeof **out);
    return *out != NULL || error_memory(err);
}

bool sampling_room(struct sampling *out, int n, bool segments, bool synthesis, struct error *err)
{
    const size_t pages = (size_t)n;
    out->n = n;
    if (segments) {
        out->segment_nm = calloc(pages, sizeof *out->segment_nm);
        if (out->segment_nm == NULL)
            return error_memory(err);
    }
    return numbers(&out->wavelength_nm, pages, err) && numbers(&out->weights, 3 * pages, err) &&
           (!synthesis || numbers(&out->synthesis, pages * (size_t)out->n_nm, err));
}

double sampling_grid(const struct sampling *sampling, int j)
{
    return sampling->first_nm + j;
}

double sampling_seen(const struct sampling *sampling, int j)
{
    double sum = 0;
    for (int channel = 0; channel < 3; channel++)
        sum += fabs(sampling->detector_weights[channel * sampling->n_nm + j]);
    return sum;
}

void sampling_linear(struct sampling *out)
{
    const double *nm = out->wavelength_nm;
    for (int j = 0; j < out->n_nm; j++) {
        const double x = sampling_grid(out, j);
        double *row = out->synthesis + (size_t)j * (size_t)out->n;
        int right = 0;
        while (right < out->n && nm[right] < x)
            right++;
        if (right == 0 || right == out->n) {
            row[right == 0 ? 0 : out->n - 1] = 1;
        } else {
            row[right] = (x - nm[right - 1]) / (nm[right] - nm[right - 1]);
            row[right - 1] = 1 - row[right];
        }
    }
}

void sampling_respond(struct sampling *out)
{
    for (int channel = 0; channel < 3; channel++)
        for (int page = 0; page < out->n; page++) {
            double sum = 0;
            for (int j = 0; j < out->n_nm; j++)
                sum += out->detector_weights[channel * out->n_nm + j] *
                       out->synthesis[(size_t)j * (size_t)out->n + (size_t)page];
            out->weights[channel * out->n + page] = sum;
        }
}

/* ---- weights ---- */

static bool sees(const struct detector *detector, double nm)
{
    bool seen = false;
    for (int channel = 0; channel < 3; channel++)
        seen = seen || spectrum_at(&detector->sensitivity[channel], nm, SPECTRUM_ZERO) != 0;
    return seen;
}

/* A file may claim any segment; no detector sees as far as this. */
enum { MOST_CELLS = 1000000 };

/* Weights of the pages of one segment, at nm[0] to nm[pages - 1]; out[channel * n + i]. Cells are
 * weighed one by one: that needs no memory. */
static void weigh_segment(const struct detector *detector, const double *nm,
                          const double segment[2], int pages, int n, double *out)
{
    const int cells = (int)fmax(0, fmin(floor(segment[1] - segment[0] + 0.5), MOST_CELLS));
    for (int i = 0; i < pages; i++)
        for (int channel = 0; channel < 3; channel++)
            out[channel * n + i] = 0;
    for (int j = 0; j < cells; j++) {
        const double x = segment[0] + 0.5 + j;
        double cell[3];
        if (!sees(detector, x))
            continue;
        detector_weights(detector, &x, 1, cell);
        for (int i = 0; i < pages; i++) {
            const double part = quadrature_lagrange(nm, pages, i, x);
            for (int channel = 0; channel < 3; channel++)
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

/* Channels that see nothing, or as much negative as positive, have no parts. */
static void count_negative(struct sampling *out)
{
    for (int channel = 0; channel < 3; channel++) {
        const double *weights = out->weights + channel * out->n;
        double sum = 0, least = 0;
        for (int page = 0; page < out->n; page++) {
            sum += weights[page];
            least = fmin(least, weights[page]);
            out->n_negative += weights[page] < 0;
        }
        if (sum > 0)
            out->most_negative = fmin(out->most_negative, least / sum);
    }
}

/* ---- making ---- */

/* Is the detector what the pages are chosen by, so that another would see nothing of them? */
static bool is_open(const struct sampling_method *method)
{
    return method->kind == SAMPLING_RIEMANN ||
           (method->kind == SAMPLING_GAUSS && method->functions == FUNCTIONS_OPEN);
}

static bool needs_observer(const struct sampling_method *method)
{
    return method->kind == SAMPLING_BOX || method->kind == SAMPLING_RGB ||
           method->kind == SAMPLING_XYZ ||
           (method->kind == SAMPLING_GAUSS && method->functions >= FUNCTIONS_XYZ);
}

static bool check_detector(const struct sampling_task *task, struct error *err)
{
    const struct sampling *out = task->out;
    double sum = 0;
    for (int j = 0; j < out->n_nm; j++)
        sum += sampling_seen(out, j);
    if (needs_observer(task->method) && !task->detector->observer)
        return error_usage(err, "%s needs an observer; %s is a camera or film", task->name,
                           out->detector);
    return sum > 0 || is_open(task->method) ||
           error_usage(err, "%s: %s sees nothing from %.6g to %.6g nm", task->name, out->detector,
                       out->first_nm, sampling_grid(out, out->n_nm - 1));
}

static bool prepare(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    const size_t n_nm = (size_t)task->spectra->n_nm;
    double *grid = NULL;
    out->first_nm = task->spectra->first_nm;
    out->n_nm = task->spectra->n_nm;
    out->detector = strdup(task->detector->name);
    if (out->detector == NULL)
        return error_memory(err);
    if (!numbers(&out->detector_weights, 3 * n_nm, err) || !numbers(&grid, n_nm, err))
        return false;
    for (int j = 0; j < out->n_nm; j++)
        grid[j] = sampling_grid(out, j);
    detector_weights(task->detector, grid, out->n_nm, out->detector_weights);
    free(grid);
    return check_detector(task, err);
}

static bool make(const struct sampling_task *task, struct error *err)
{
    switch (task->method->kind) {
    case SAMPLING_BOX:
        return sample_box(task, err);
    case SAMPLING_RIEMANN:
        return sample_riemann(task, err);
    case SAMPLING_GAUSS:
        return sample_gauss(task, err);
    case SAMPLING_ADAPTIVE:
        return sample_adaptive(task, err);
    case SAMPLING_BASIS:
        return sample_basis(task, err);
    default:
        return sample_tristimulus(task, err);
    }
}

bool sampling_make(const struct sampling_method *method, const char *detector,
                   const struct fine_spectra *spectra, struct sampling *out, struct error *err)
{
    struct detector sees;
    struct sampling_task task = {
        .method = method, .detector = &sees, .spectra = spectra, .out = out};
    *out = (struct sampling){.method = *method};
    sampling_name(method, task.name);
    if (!detector_read(detector, &sees, err))
        return false;
    const bool done = prepare(&task, err) && make(&task, err);
    detector_free(&sees);
    if (done)
        count_negative(out);
    else
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
        if (materials[i]->spectral_texture != NULL)
            refused = materials[i];
    free(materials);
    sampling_name(&sampling->method, name);
    return refused == NULL ||
           error_at(err, refused->spectral_texture_place,
                    "%s has no wavelengths to take a spectral texture at; box, riemann, gauss and "
                    "adaptive have",
                    name);
}

static bool replace_wavelengths(struct scene *scene, const struct sampling *sampling,
                                struct error *err)
{
    const size_t n = (size_t)sampling->n;
    double *wavelengths_nm = malloc(n * sizeof *wavelengths_nm);
    if (wavelengths_nm == NULL)
        return error_memory(err);
    memcpy(wavelengths_nm, sampling->wavelength_nm, n * sizeof *wavelengths_nm);
    free(scene->wavelengths_nm);
    scene->wavelengths_nm = wavelengths_nm;
    scene->n_wavelengths = sampling->n;
    return true;
}

bool scene_sample(struct scene *scene, const struct sampling_method *method, const char *detector,
                  struct sampling *out, struct error *err)
{
    struct fine_spectra spectra = {.n_nm = 0};
    *out = (struct sampling){.n = 0};
    const bool done = scene_spectra(scene, &spectra, err) &&
                      sampling_make(method, detector, &spectra, out, err) &&
                      (out->spectral || refuse_textures(scene, out, err)) &&
                      replace_wavelengths(scene, out, err);
    fine_spectra_free(&spectra);
    if (!done)
        sampling_free(out);
    return done;
}

const struct sampling *sampling_or_none(const struct sampling *sampling)
{
    return sampling->n > 0 ? sampling : NULL;
}

struct spectral_pages sampling_pages(const struct sampling *sampling)
{
    return (struct spectral_pages){.n = sampling->n,
                                   .wavelength_nm = sampling->wavelength_nm,
                                   .first_nm = sampling->first_nm,
                                   .n_nm = sampling->n_nm,
                                   .light_mean = sampling->light_mean,
                                   .reflectance_mean = sampling->reflectance_mean,
                                   .analysis = sampling->analysis,
                                   .clips = sampling->clips,
                                   .no_luminescence =
                                       !sampling->spectral && sampling->analysis == NULL};
}

/* ---- what a stack records ---- */

void sampling_describe(const struct sampling *sampling, struct sampling_description *out)
{
    *out = (struct sampling_description){
        .detector = sampling->detector, .components = !sampling->spectral, .n = sampling->n};
    sampling_name(&sampling->method, out->method);
    if (sampling->fixed) {
        out->response = sampling->weights;
        out->range_nm[0] = sampling->first_nm - 0.5;
        out->range_nm[1] = sampling->first_nm + sampling->n_nm - 0.5;
    } else
        out->segment_nm = sampling->segment_nm;
}

bool sampling_white(const struct sampling *sampling, const struct scene *scene, double out[3],
                    double *illumination, struct error *err)
{
    const int n = sampling->n_nm;
    double *nm = calloc(2 * (size_t)n, sizeof *nm), *white = nm + n;
    if (nm == NULL)
        return error_memory(err);
    for (int j = 0; j < n; j++)
        nm[j] = sampling_grid(sampling, j);
    const struct spectral_pages pages = {.n = n, .wavelength_nm = nm};
    *illumination = scene_white(scene, &pages, white);
    detector_response(sampling->detector_weights, white, n, out);
    free(nm);
    bool seen = false, finite = true;
    for (int channel = 0; channel < 3; channel++) {
        seen = seen || out[channel] > 0;
        finite = finite && fabs(out[channel]) <= DBL_MAX;
    }
    if (!(seen && finite))
        *illumination = 0;
    return true;
}

/* ---- in words ---- */

void sampling_label(const struct sampling *sampling, int page, char out[24])
{
    static const char *const rgb[] = {"red", "green", "blue"}, *const xyz[] = {"X", "Y", "Z"};
    out[0] = '\0';
    if (sampling->method.kind == SAMPLING_BASIS)
        snprintf(out, 24, "component %d", page + 1);
    else if (!sampling->spectral)
        snprintf(out, 24, "%s", (sampling->method.kind == SAMPLING_RGB ? rgb : xyz)[page]);
}

static void print_peaks(const struct sampling *sampling, FILE *to)
{
    enum { MOST = 8 };
    fprintf(to, ", %d emission peak%s", sampling->n_peaks, sampling->n_peaks == 1 ? "" : "s");
    for (int i = 0; i < sampling->n_peaks && i < MOST; i++)
        fprintf(to, "%s%.6g", i == 0 ? " (" : ", ", sampling->peak_nm[i]);
    if (sampling->n_peaks > 0)
        fputs(sampling->n_peaks > MOST ? ", ... nm)" : " nm)", to);
}

static const char *limit_of(const struct sampling_method *method)
{
    switch (method->kind) {
    case SAMPLING_BOX:
        return "tells only these means";
    case SAMPLING_BASIS:
        return "no radiances at wavelengths";
    case SAMPLING_RGB:
    case SAMPLING_XYZ:
        return "no spectra, and no fluorescence";
    default:
        return "tells only these wavelengths";
    }
}

/* Components have negative weights as a matter of course. */
void sampling_print(const struct sampling *sampling, FILE *to)
{
    char name[SAMPLING_NAME];
    const enum sampling_kind kind = sampling->method.kind;
    const char *pages = !sampling->spectral    ? "component"
                        : kind == SAMPLING_BOX ? "box"
                                               : "wavelength";
    sampling_name(&sampling->method, name);
    fprintf(to, "%s for %s: %d %s%s", name, sampling->detector, sampling->n, pages,
            sampling->n == 1       ? ""
            : kind == SAMPLING_BOX ? "es"
                                   : "s");
    if (kind == SAMPLING_BASIS)
        fprintf(to, " of rank %d", sampling->rank);
    if (kind == SAMPLING_ADAPTIVE)
        print_peaks(sampling, to);
    if (sampling->spectral && sampling->n_negative > 0)
        fprintf(to, ", %d of %d weights negative (%.2g %%)", sampling->n_negative, 3 * sampling->n,
                100 * sampling->most_negative);
    fprintf(to, "; %s", limit_of(&sampling->method));
    if (sampling->fixed)
        fprintf(to, "; only %s can be served", sampling->detector);
    fputc('\n', to);
}

void sampling_free(struct sampling *sampling)
{
    free(sampling->detector);
    free(sampling->wavelength_nm);
    free(sampling->segment_nm);
    free(sampling->weights);
    free(sampling->detector_weights);
    free(sampling->light_mean);
    free(sampling->reflectance_mean);
    free(sampling->analysis);
    free(sampling->synthesis);
    free(sampling->peak_nm);
    *sampling = (struct sampling){0};
}
