/* SPDX-License-Identifier: MIT */
/* Finds the weights that develop a stack. Detector, adaptation and display are linear: together
 * they become three numbers a page. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/beside/see/inside.h"

/* ---- by a sampling of the stack's spectra ---- */

/* Adds the weights of the radiance at nm, channels `stride` apart, to those of the pages. */
static void add_weight(const struct image *image, double nm, const double *weights, int stride,
                       double factor, double *out)
{
    double part;
    const int n = image->n_pages, page = wavelength_before(image->wavelengths_nm, n, nm, &part);
    for (int channel = 0; channel < 3; channel++) {
        const double weight = factor * weights[channel * stride];
        out[channel * n + page] += (1 - part) * weight;
        if (part > 0)
            out[channel * n + page + 1] += part * weight;
    }
}

/* Folds the weights of a sampling's pages into those of the stack's. */
static void fold_sampling(const struct image *image, const struct sampling *sampling, double *out)
{
    const struct spectral_pages *pages = &sampling->pages;
    const double *mean = pages->analysis;
    for (int i = 0; i < pages->n && !mean; i++)
        add_weight(image, pages->wavelength_nm[i], sampling->weights + i, pages->n, 1, out);
    for (int i = 0; i < pages->n && mean; i++, mean += pages->n_nm)
        for (int j = 0; j < pages->n_nm; j++)
            if (mean[j] != 0)
                add_weight(image, sampling->fine.nm[j], sampling->weights + i, pages->n, mean[j],
                           out);
}

/* Folds the weights of the detector at every nm into those for the white. */
static bool fold_detector(struct development *of, const struct fine_detector *fine,
                          struct error *err)
{
    const size_t n = 3 * (size_t)of->cube.image.n_pages;
    if (!MAKE_ARRAY(of->of_white, n, err, "the weights of %s", of->cube.image.path))
        return false;
    for (int j = 0; j < fine->n; j++)
        add_weight(&of->cube.image, fine->nm[j], fine->weights + j, fine->n, 1, of->of_white);
    return true;
}

/* Refuses a stack that was sampled, or a method that needs more than its spectra. */
static bool check_sampling(const struct cube *cube, const struct sampling_method *method,
                           struct error *err)
{
    const struct image *image = &cube->image;
    const double longest_nm = 1e6;
    if (cube->record.sampling != NULL)
        return error_usage(
            err,
            "%s: was sampled when it was rendered, by %s; --sampling needs a stack that was"
            " rendered without",
            image->path, cube->record.sampling);
    if (sampling_makes_components(method))
        return error_usage(err,
                           "--sampling basis, rgb and xyz need lights and reflectances apart, and a"
                           " stack holds their products; expected another method, or render"
                           " --sampling");
    return image->wavelengths_nm[image->n_pages - 1] <= longest_nm ||
           error_usage(err, "%s: its wavelengths reach %.10g nm; --sampling goes up to %.10g nm",
                       image->path, image->wavelengths_nm[image->n_pages - 1], longest_nm);
}

/* Makes the white at every nm the only light and the only product, as adaptive sampling needs it.
 */
static bool white_finely(const struct development *of, struct fine_spectra *out, struct error *err)
{
    const struct image *image = &of->cube.image;
    double *white;
    const bool done = MAKE_ARRAY(white, image->n_pages, err, "a white") &&
                      MAKE_ARRAY(out->lights, out->n_nm, err, "a white") &&
                      MAKE_ARRAY(out->products, out->n_nm, err, "a white") &&
                      cube_white(&of->cube, of->options->white, white, err);
    for (int j = 0; done && j < out->n_nm; j++) {
        double part;
        const int page =
            wavelength_before(image->wavelengths_nm, image->n_pages, out->first_nm + j, &part);
        out->lights[j] = out->products[j] =
            part > 0 ? (1 - part) * white[page] + part * white[page + 1] : white[page];
    }
    out->n_lights = out->n_products = 1;
    free(white);
    return done;
}

/* Describes the sampling in one line. */
static bool describe_sampling(const struct sampling *sampling, struct development *of,
                              struct error *err)
{
    struct printed printed = {.text = NULL};
    sampling_print(sampling, &printed);
    char *text = printed_take(&printed, err);
    if (!text)
        return false;
    snprintf(of->sampled, sizeof of->sampled, "%.*s", (int)strcspn(text, "\n"), text);
    free(text);
    return true;
}

/* Finds both weights as if the spectra of the pages were sampled. With a fixed sampling the white
 * is not sampled. */
static bool sampled_weights(struct development *of, struct error *err)
{
    const struct image *image = &of->cube.image;
    const double first = image->wavelengths_nm[0], last = image->wavelengths_nm[image->n_pages - 1];
    struct fine_spectra spectra = {.first_nm = first};
    struct sampling sampling = {.detector = NULL};
    if (!check_sampling(&of->cube, of->options->sampling, err))
        return false;
    spectra.n_nm = (int)floor(last - first + 1e-9) + 1;
    const bool done =
        (of->options->sampling->kind != SAMPLING_ADAPTIVE || white_finely(of, &spectra, err)) &&
        sampling_make(of->options->sampling, of->options->detector_name, &spectra, &sampling,
                      err) &&
        (!sampling.fixed || fold_detector(of, &sampling.fine, err)) &&
        describe_sampling(&sampling, of, err);
    if (done) {
        fold_sampling(image, &sampling, of->weights);
        if (sampling.segment_nm == NULL && !sampling.fixed)
            detector_lost(&of->detector, sampling.pages.wavelength_nm, sampling.pages.n, of->lost);
        else
            detector_lost_outside(&of->detector, first - 0.5, first + spectra.n_nm - 0.5, of->lost);
    }
    sampling_free(&sampling);
    fine_spectra_free(&spectra);
    return done;
}

/* ---- weights ---- */

static bool check_detector(const struct development *of, struct error *err)
{
    const struct image *image = &of->cube.image;
    const struct detector *detector = &of->detector;
    /* Rendering checked a recorded response; that of a black scene is 0. A scene may be black. */
    bool sees = of->options->lit || of->cube.record.response.n > 0;
    for (int i = 0; i < 3 * image->n_pages; i++)
        sees = sees || of->weights[i] != 0;
    if (!sees)
        return error_usage(err, "%s: %s sees nothing from %.10g to %.10g nm", image->path,
                           detector->name, of->first_nm, of->last_nm);
    if (!detector->observer && of->adaptation.kind != ADAPTATION_NONE)
        return error_usage(err,
                           "%s is a camera or film, which does not adapt but is balanced to the"
                           " white; %s is for observers",
                           detector->name, adaptation_names[of->adaptation.kind]);
    if (!detector->observer && of->options->values != DEVELOP_RGB)
        return error_usage(err,
                           "%s is a camera or film, which has no %s; expected an observer, or "
                           "--raw for the camera's own values",
                           detector->name,
                           of->options->values == DEVELOP_XYZ ? "tristimulus values" : "CIELAB");
    return true;
}

/* Divides each channel by the white's. */
static bool balance(const struct development *of, struct error *err)
{
    const double *white = of->seen_white;
    const int n = of->cube.image.n_pages;
    for (int channel = 0; channel < 3; channel++) {
        if (!(white[channel] > 0))
            return error_usage(err,
                               "channel %d of %s responds to the white with %.6g, and cannot be"
                               " divided by that; expected a white that all three channels see",
                               channel + 1, of->detector.name, white[channel]);
        for (int i = 0; i < n; i++)
            of->weights[channel * n + i] /= white[channel];
    }
    return true;
}

/* Adapts the weights, and the white. As in the thesis, the luminance of Fairchild's adaptation is
 * ten times the light's intensity; of absolute radiances, the white's. */
static bool adapt(struct development *of, struct error *err)
{
    const double recorded = record_illumination(&of->cube.record);
    const int n = of->cube.image.n_pages;
    struct adaptation *adaptation = &of->adaptation;
    double m[3][3];
    if (adaptation->kind == ADAPTATION_FAIRCHILD && !(adaptation->luminance > 0))
        adaptation->luminance = of->cube.record.unit
                                    ? (recorded > 0 ? recorded : 1) * of->seen_white[1]
                                    : 10 * (recorded > 0 ? recorded : 1);
    if (!adaptation_matrix(adaptation, of->seen_white, of->equal, m, err))
        return false;
    tristimulus_apply_all(m, n, of->weights);
    tristimulus_apply(m, of->seen_white, of->adapted_white);
    if (of->options->values == DEVELOP_RGB) {
        display_matrix(of->options->display, m);
        tristimulus_apply_all(m, n, of->weights);
    }
    return true;
}

/* The result reports a recorded white even where none is needed. */
static bool needs_white(const struct development *of)
{
    return !of->detector.observer || of->adaptation.kind != ADAPTATION_NONE ||
           of->options->values == DEVELOP_LAB;
}

/* Describes the range of the stack, and the sampling that it records. */
static void describe_stack(struct development *of)
{
    const struct image *image = &of->cube.image;
    const struct record *record = &of->cube.record;
    const double half_cell = 0.5;
    const bool components = of->cube.components;
    of->first_nm = components ? record->range_nm.value[0] + half_cell : image->wavelengths_nm[0];
    of->last_nm = components ? record->range_nm.value[1] - half_cell
                             : image->wavelengths_nm[image->n_pages - 1];
    if (record->sampling != NULL)
        snprintf(of->sampled, sizeof of->sampled, "%s for %s (recorded)", record->sampling,
                 record->sampling_detector);
    hide_unprintable(of->sampled, "");
    cube_lost(&of->cube, &of->detector, of->lost);
}

/* Finds the weights that take pages to the detector's channels, and the response to the white and
 * to radiance 1 everywhere. */
static bool channel_weights(struct development *of, struct error *err)
{
    const struct cube *cube = &of->cube;
    const struct white_request request = {of->options->white, needs_white(of)};
    if (!(of->options->sampling != NULL ? sampled_weights(of, err)
                                        : cube_weights(cube, &of->detector, of->weights, err)) ||
        !check_detector(of, err))
        return false;
    const double *of_white = of->of_white != NULL ? of->of_white : of->weights;
    if (!cube_white_response(cube, &request, of_white, &of->has_white, of->seen_white, err) ||
        !cube_equal_response(cube, &of->detector, of_white, of->equal, err))
        return false;
    const double luminance = cube_luminance(cube, &of->detector);
    for (int i = 0; i < 3 * cube->image.n_pages; i++)
        of->weights[i] *= luminance;
    for (int i = 0; i < 3; i++) {
        of->seen_white[i] *= luminance;
        of->equal[i] *= luminance;
    }
    return true;
}

bool develop_weights(struct development *of, struct error *err)
{
    const size_t n = 3 * (size_t)of->cube.image.n_pages;
    if (!MAKE_ARRAY(of->weights, n, err, "the weights of %s", of->cube.image.path) ||
        !detector_read(of->options->detector_name, &of->detector, err))
        return false;
    describe_stack(of);
    return channel_weights(of, err) && (of->detector.observer ? adapt(of, err) : balance(of, err));
}
