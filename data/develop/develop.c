/* SPDX-License-Identifier: MIT */
/* Develops a spectral stack: what a detector makes of it, adapted, on a display. All that is linear
 * is folded into three weights a page beforehand. The stack is read in chunks of rows, a few pages
 * at a time; each pixel is summed in the order of the pages, whatever the chunks and threads. */
#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/colour/colour.h"
#include "data/develop/develop.h"
#include "data/method/method.h"
#include "data/pages/pages.h"
#include "data/record/record.h"
#include "data/sampling/sampling.h"
#include "data/spectra/spectra.h"
#include "data/stack/stack.h"
#include "data/tiff/tiff.h"
#include "spectral.h"

/* ---- as if it were sampled ---- */

/* Between which pages a wavelength lies: the first of them, and how far towards the next, 0 to 1.
 * Beyond the ends the end page stands for it. */
static int page_before(const struct image *image, double nm, double *part)
{
    const double *page_nm = image->wavelengths_nm;
    int before = 0, behind = image->n_pages - 1;
    *part = 0;
    if (behind == 0)
        return 0;
    while (behind - before > 1) {
        const int middle = before + (behind - before) / 2;
        *(nm < page_nm[middle] ? &behind : &before) = middle;
    }
    *part = fmax(0, fmin((nm - page_nm[before]) / (page_nm[behind] - page_nm[before]), 1));
    return before;
}

/* Adds the weights of the radiance at nm, channels `stride` apart, to those of the pages. */
static void add_weight(const struct image *image, double nm, const double *weights, int stride,
                       double factor, double *out)
{
    double part;
    const int n = image->n_pages, page = page_before(image, nm, &part);
    for (int channel = 0; channel < 3; channel++) {
        const double weight = factor * weights[channel * stride];
        out[channel * n + page] += (1 - part) * weight;
        if (part > 0)
            out[channel * n + page + 1] += part * weight;
    }
}

static void fold_sampling(const struct image *image, const struct sampling *sampling, double *out)
{
    for (int i = 0; i < sampling->n; i++) {
        const double *means = sampling->light_mean != NULL
                                  ? sampling->light_mean + (size_t)i * (size_t)sampling->n_nm
                                  : NULL;
        if (means == NULL)
            add_weight(image, sampling->wavelength_nm[i], sampling->weights + i, sampling->n, 1,
                       out);
        for (int j = 0; means != NULL && j < sampling->n_nm; j++)
            if (means[j] != 0)
                add_weight(image, sampling->first_nm + j, sampling->weights + i, sampling->n,
                           means[j], out);
    }
}

/* The same of the detector itself, at every nm. */
static void fold_detector(const struct image *image, const struct sampling *sampling, double *out)
{
    for (int j = 0; j < sampling->n_nm; j++)
        add_weight(image, sampling->first_nm + j, sampling->detector_weights + j, sampling->n_nm, 1,
                   out);
}

static bool check_sampling(const struct cube *cube, const struct sampling_method *method,
                           struct error *err)
{
    const struct image *image = &cube->image;
    const double longest_nm = 1e6;
    if (cube->record.sampling != NULL)
        return error_usage(
            err,
            "%s: was sampled itself, by %s; --sampling needs a stack that was rendered"
            " without",
            image->path, cube->record.sampling);
    if (method->kind >= SAMPLING_BASIS)
        return error_usage(
            err, "--sampling basis, rgb and xyz need lights and reflectances apart, which a"
                 " stack has multiplied already; expected one of the others, or render"
                 " --sampling");
    return image->wavelengths_nm[image->n_pages - 1] <= longest_nm ||
           error_usage(err, "%s: its wavelengths reach %.10g nm; --sampling goes up to %.10g nm",
                       image->path, image->wavelengths_nm[image->n_pages - 1], longest_nm);
}

/* The white at every nm is all that is known of the light; adaptive sampling needs it. */
static bool white_finely(const struct cube *cube, const struct develop_options *options,
                         struct fine_spectra *out, struct error *err)
{
    const struct image *image = &cube->image;
    struct error ignored = {0};
    double *white = calloc((size_t)image->n_pages, sizeof *white);
    out->lights = calloc((size_t)out->n_nm, sizeof *out->lights);
    out->products = calloc((size_t)out->n_nm, sizeof *out->products);
    const bool needed = options->sampling->kind == SAMPLING_ADAPTIVE;
    const bool done =
        (white != NULL && out->lights != NULL && out->products != NULL) || error_memory(err);
    const bool found = done && cube_white(cube, options->white, white, needed ? err : &ignored);
    if (found) {
        out->n_lights = out->n_products = 1;
        for (int j = 0; j < out->n_nm; j++) {
            double part;
            const int page = page_before(image, out->first_nm + j, &part);
            out->lights[j] =
                part > 0 ? (1 - part) * white[page] + part * white[page + 1] : white[page];
        }
        memcpy(out->products, out->lights, (size_t)out->n_nm * sizeof *out->products);
    }
    free(white);
    return done && (found || !needed);
}

/* In one line. */
static void tell_sampling(const struct sampling *sampling, struct develop_result *result)
{
    FILE *to = fmemopen(result->sampling, sizeof result->sampling - 1, "w");
    if (to == NULL)
        return;
    sampling_print(sampling, to);
    fclose(to);
    result->sampling[strcspn(result->sampling, "\n")] = '\0';
}

/* Weights of the pages, as if their spectra were sampled so, and those of the white: a fixed
 * sampling takes it as it is. */
static bool sampled_weights(const struct cube *cube, const struct detector *detector,
                            const struct develop_options *options, double *out, double *of_white,
                            struct develop_result *result, struct error *err)
{
    const struct image *image = &cube->image;
    const double first = image->wavelengths_nm[0], last = image->wavelengths_nm[image->n_pages - 1];
    struct fine_spectra spectra = {.first_nm = first};
    struct sampling sampling = {.n = 0};
    if (!check_sampling(cube, options->sampling, err))
        return false;
    spectra.n_nm = (int)floor(last - first + 1e-9) + 1;
    const bool done = white_finely(cube, options, &spectra, err) &&
                      sampling_make(options->sampling, options->detector, &spectra, &sampling, err);
    if (done) {
        fold_sampling(image, &sampling, out);
        if (sampling.fixed)
            fold_detector(image, &sampling, of_white);
        else
            memcpy(of_white, out, 3 * (size_t)image->n_pages * sizeof *out);
        if (sampling.segment_nm == NULL && !sampling.fixed)
            detector_lost(detector, sampling.wavelength_nm, sampling.n, result->lost);
        else
            detector_lost_outside(detector, first - 0.5, first + spectra.n_nm - 0.5, result->lost);
        tell_sampling(&sampling, result);
    }
    sampling_free(&sampling);
    fine_spectra_free(&spectra);
    return done;
}

/* ---- weights ---- */

static bool check_detector(const struct cube *cube, const struct detector *detector,
                           const struct develop_options *options,
                           const struct develop_result *result, const double *weights,
                           struct error *err)
{
    const struct image *image = &cube->image;
    bool sees = cube->record.n_response > 0; /* was checked; components of a black scene have 0 */
    for (int i = 0; i < 3 * image->n_pages; i++)
        sees = sees || weights[i] != 0;
    if (!sees)
        return error_usage(err, "%s: %s sees nothing from %.10g to %.10g nm", image->path,
                           detector->name, result->first_nm, result->last_nm);
    if (!detector->observer && options->adaptation.kind != ADAPTATION_NONE)
        return error_usage(err,
                           "%s is a camera or film, which does not adapt but is balanced to the"
                           " white; %s is for observers",
                           detector->name, adaptation_name(options->adaptation.kind));
    if (!detector->observer && options->values != DEVELOP_RGB)
        return error_usage(err, "%s is a camera or film, which has no %s; expected an observer",
                           detector->name,
                           options->values == DEVELOP_XYZ ? "tristimulus values" : "CIELAB");
    return true;
}

/* Each channel divided by the white's. */
static bool balance(const struct detector *detector, const double white[3], int n, double *weights,
                    struct error *err)
{
    for (int channel = 0; channel < 3; channel++) {
        if (!(white[channel] > 0))
            return error_usage(err,
                               "channel %d of %s has %.6g of the white, by which it is to be"
                               " divided; expected one that all three channels see",
                               channel + 1, detector->name, white[channel]);
        for (int i = 0; i < n; i++)
            weights[channel * n + i] /= white[channel];
    }
    return true;
}

static void fold(double m[3][3], int n, double *weights)
{
    for (int i = 0; i < n; i++) {
        double out[3];
        colour_apply(m, (double[]){weights[i], weights[n + i], weights[2 * n + i]}, out);
        for (int channel = 0; channel < 3; channel++)
            weights[channel * n + i] = out[channel];
    }
}

/* The thesis takes the luminance that a light adapts to for ten times its intensity. `equal` is
 * what the detector makes of radiance 1 everywhere; `adapted` will be the white. */
static bool adapt(const struct cube *cube, const struct develop_options *options,
                  const double equal[3], double *weights, struct develop_result *result,
                  double adapted[3], struct error *err)
{
    const double illumination = cube->record.illumination > 0 ? cube->record.illumination : 1;
    const int n = cube->image.n_pages;
    double m[3][3];
    if (result->adaptation.kind == ADAPTATION_FAIRCHILD && !(result->adaptation.luminance > 0))
        result->adaptation.luminance = 10 * illumination;
    if (!adaptation_matrix(&result->adaptation, result->white, equal, m, err))
        return false;
    fold(m, n, weights);
    colour_apply(m, result->white, adapted);
    if (options->values == DEVELOP_RGB) {
        display_matrix(options->display, m);
        fold(m, n, weights);
    }
    return true;
}

/* What needs no white still tells of it, if there is one. */
static bool needs_white(const struct detector *detector, const struct develop_options *options)
{
    return !detector->observer || options->adaptation.kind != ADAPTATION_NONE ||
           options->values == DEVELOP_LAB;
}

/* What the stack is, and how it was sampled if it tells. */
static void begin_result(const struct cube *cube, const struct detector *detector,
                         const struct develop_options *options, struct develop_result *out)
{
    const struct image *image = &cube->image;
    const struct record *record = &cube->record;
    const double half_cell = 0.5, *range = record->range_nm;
    *out = (struct develop_result){.width = image->width,
                                   .height = image->height,
                                   .n_pages = image->n_pages,
                                   .first_nm = image->wavelengths_nm[0],
                                   .last_nm = image->wavelengths_nm[image->n_pages - 1],
                                   .components = cube->components,
                                   .observer = detector->observer,
                                   .adaptation = options->adaptation,
                                   .exposure = options->exposure};
    if (cube->components) {
        out->first_nm = range[0] + half_cell;
        out->last_nm = range[1] - half_cell;
    }
    if (record->sampling != NULL)
        snprintf(out->sampling, sizeof out->sampling, "%s for %s (recorded)", record->sampling,
                 record->sampling_detector);
    for (char *at = out->sampling; *at != '\0'; at++) /* words of a file: they drive no terminal */
        *at = iscntrl((unsigned char)*at) ? '?' : *at;
    cube_lost(cube, detector, out->lost);
}

/* Weights that take pages to the detector's channels, and what it makes of the white and of
 * radiance 1 everywhere. */
static bool channel_weights(const struct cube *cube, const struct detector *detector,
                            const struct develop_options *options, double *out,
                            struct develop_result *result, double equal[3], struct error *err)
{
    const size_t n = 3 * (size_t)cube->image.n_pages;
    double *of_white = calloc(n, sizeof *of_white);
    bool done = of_white != NULL || error_memory(err);
    if (done && options->sampling != NULL)
        done = sampled_weights(cube, detector, options, out, of_white, result, err);
    else if (done && (done = cube_weights(cube, detector, out, err)))
        memcpy(of_white, out, n * sizeof *out);
    done = done && check_detector(cube, detector, options, result, out, err) &&
           cube_white_response(cube, options->white, needs_white(detector, options), of_white,
                               &result->has_white, result->white, err) &&
           cube_equal_response(cube, detector, of_white, equal, err);
    free(of_white);
    return done;
}

/* Weights that take pages to linear display channels, to XYZ or, for cielab, to XYZ, at exposure 1:
 * out[channel * n_pages + i]. Refuses a detector that sees none of the wavelengths. Fills in the
 * result but for what the pixels decide, and the white that an observer has adapted to. */
static bool develop_weights(const struct cube *cube, const struct detector *detector,
                            const struct develop_options *options, double *out,
                            struct develop_result *result, double adapted[3], struct error *err)
{
    double equal[3];
    begin_result(cube, detector, options, result);
    return channel_weights(cube, detector, options, out, result, equal, err) &&
           (detector->observer ? adapt(cube, options, equal, out, result, adapted, err)
                               : balance(detector, result->white, cube->image.n_pages, out, err));
}

/* ---- a stack being developed ---- */

enum {
    BATCH = 8,              /* pages that are read before they are added up */
    CHUNK_PIXELS = 1 << 21, /* at most, but a row: 64 MB of a batch, 48 MB of sums */
    BLOCK_PIXELS = 1024     /* that a thread adds up at once */
};

struct development {
    const struct develop_options *options;
    struct develop_result *result;
    struct cube cube;
    double *weights; /* [channel][page] */
    double white[3]; /* as adapted, of observers */
    int rows;        /* of a chunk */
    int threads;
    size_t n_pixels; /* of a chunk */
    float *radiance; /* [page of the batch][pixel] */
    double *sums;    /* [channel][pixel] */
    void *samples;   /* as picture_write takes them */
};

static bool prepare_weights(struct development *of, struct error *err)
{
    struct detector detector;
    if (!detector_read(of->options->detector, &detector, err))
        return false;
    of->weights = calloc(3 * (size_t)of->cube.image.n_pages, sizeof *of->weights);
    const bool done =
        (of->weights != NULL || error_memory(err)) &&
        develop_weights(&of->cube, &detector, of->options, of->weights, of->result, of->white, err);
    detector_free(&detector);
    return done;
}

static size_t sample_bytes(const struct develop_options *options)
{
    return options->values != DEVELOP_RGB ? sizeof(float) : (size_t)options->bits / 8;
}

static bool prepare_chunk(struct development *of, struct error *err)
{
    const struct image *image = &of->cube.image;
    const int rows = CHUNK_PIXELS / image->width;
    of->rows = rows < 1 ? 1 : rows < image->height ? rows : image->height;
    of->n_pixels = (size_t)of->rows * (size_t)image->width;
    of->threads = threads_start(of->options->threads);
    of->radiance = calloc(BATCH * of->n_pixels, sizeof *of->radiance);
    of->sums = calloc(3 * of->n_pixels, sizeof *of->sums);
    of->samples = calloc(3 * of->n_pixels, sample_bytes(of->options));
    return (of->radiance != NULL && of->sums != NULL && of->samples != NULL) || error_memory(err);
}

/* Adds a batch of pages to up to BLOCK_PIXELS pixels, page after page. */
static void add_block(const float *restrict radiance, size_t stride, double weights[3][BATCH],
                      size_t n, double *restrict x, double *restrict y, double *restrict z)
{
    for (size_t i = 0; i < n; i++) {
        double sum[3] = {x[i], y[i], z[i]};
        for (int page = 0; page < BATCH; page++) {
            const double value = (double)radiance[(size_t)page * stride + i];
            for (int channel = 0; channel < 3; channel++)
                sum[channel] += weights[channel][page] * value;
        }
        x[i] = sum[0];
        y[i] = sum[1];
        z[i] = sum[2];
    }
}

/* Pages that are missing in the last batch have weight 0. */
static void add_batch(struct development *of, int first, size_t n)
{
    const int n_pages = of->cube.image.n_pages;
    const size_t stride = of->n_pixels;
    double weights[3][BATCH] = {{0}};
    for (int channel = 0; channel < 3; channel++)
        for (int page = 0; page < BATCH && first + page < n_pages; page++)
            weights[channel][page] = of->weights[channel * n_pages + first + page];
#pragma omp parallel for num_threads(of->threads)
    for (size_t i = 0; i < n; i += BLOCK_PIXELS)
        add_block(of->radiance + i, stride, weights, n - i < BLOCK_PIXELS ? n - i : BLOCK_PIXELS,
                  of->sums + i, of->sums + stride + i, of->sums + 2 * stride + i);
}

/* Of the chunk that begins with row y. */
static int rows_at(const struct development *of, int y)
{
    const int left = of->cube.image.height - y;
    return left < of->rows ? left : of->rows;
}

static bool sum_chunk(struct development *of, int y, int rows, struct error *err)
{
    struct image *image = &of->cube.image;
    memset(of->sums, 0, 3 * of->n_pixels * sizeof *of->sums);
    for (int page = 0; page < image->n_pages; page++) {
        if (output_interrupted())
            return error_system(err, "interrupted; nothing was written");
        if (!image_read(image, page, y, rows, of->radiance + (size_t)(page % BATCH) * of->n_pixels,
                        err))
            return false;
        if (page % BATCH == BATCH - 1 || page == image->n_pages - 1)
            add_batch(of, page / BATCH * BATCH, (size_t)rows * (size_t)image->width);
    }
    return true;
}

/* ---- exposure ---- */

static double largest_sum(const struct development *of, int channel, size_t n)
{
    const double *sums = of->sums + (size_t)channel * of->n_pixels;
    double largest = 0;
#pragma omp parallel for reduction(max : largest) num_threads(of->threads)
    for (size_t i = 0; i < n; i++)
        largest = sums[i] > largest ? sums[i] : largest;
    return largest;
}

/* What brings the brightest channel of all pixels (or Y) to the largest that is displayed (or 100);
 * 1 of a black picture. */
static bool find_exposure(struct development *of, struct error *err)
{
    const struct image *image = &of->cube.image;
    const bool rgb = of->options->values == DEVELOP_RGB;
    double brightest = 0; /* in parts of the largest */
    for (int y = 0; y < image->height; y += rows_at(of, y)) {
        const int rows = rows_at(of, y);
        if (!sum_chunk(of, y, rows, err))
            return false;
        for (int channel = rgb ? 0 : 1; channel < (rgb ? 3 : 2); channel++)
            brightest =
                fmax(brightest, largest_sum(of, channel, (size_t)rows * (size_t)image->width) /
                                    (rgb ? display_largest(of->options->display, channel) : 100));
    }
    of->result->exposure = brightest > 1 / DBL_MAX ? 1 / brightest : 1;
    return true;
}

/* ---- pixels ---- */

/* The largest float stands for what is beyond. */
static float stored(double value)
{
    return (float)fmax(-(double)FLT_MAX, fmin(value, (double)FLT_MAX));
}

static void store_floats(const struct development *of, size_t pixel, const double values[3])
{
    float *samples = of->samples;
    double lab[3];
    if (of->options->values == DEVELOP_LAB)
        cielab(values, of->white, lab);
    for (int channel = 0; channel < 3; channel++)
        samples[3 * pixel + (size_t)channel] =
            stored(of->options->values == DEVELOP_LAB ? lab[channel] : values[channel]);
}

/* Tells whether a channel was clipped; by less than 1e-6 it may be by rounding, as a white is. */
static bool store_rgb(const struct development *of, size_t pixel, const double values[3])
{
    const double slack = 1e-6;
    const enum display_kind display = of->options->display;
    bool clipped = false;
    for (int channel = 0; channel < 3; channel++) {
        const double value = display_encode(display, channel, values[channel]);
        const size_t at = 3 * pixel + (size_t)channel;
        if (of->options->bits == 16)
            ((uint16_t *)of->samples)[at] = (uint16_t)(value * 65535 + 0.5);
        else
            ((uint8_t *)of->samples)[at] = (uint8_t)(value * 255 + 0.5);
        clipped = clipped || values[channel] < -slack ||
                  values[channel] > display_largest(display, channel) + slack;
    }
    return clipped;
}

/* Returns how many pixels are out of gamut. */
static uint64_t store_chunk(const struct development *of, size_t n)
{
    const double exposure = of->result->exposure;
    const bool rgb = of->options->values == DEVELOP_RGB;
    uint64_t clipped = 0;
#pragma omp parallel for reduction(+ : clipped) num_threads(of->threads)
    for (size_t i = 0; i < n; i++) {
        double values[3];
        for (size_t channel = 0; channel < 3; channel++)
            values[channel] = exposure * of->sums[channel * of->n_pixels + i];
        if (rgb)
            clipped += store_rgb(of, i, values);
        else
            store_floats(of, i, values);
    }
    return clipped;
}

/* ---- in words ---- */

static void print_white(const struct develop_options *options, const struct develop_result *result,
                        FILE *to)
{
    const double *white = result->white;
    double xy[2];
    if (!result->has_white)
        fputs("white             not recorded\n", to);
    else {
        fprintf(to, "white             %s%.6g %.6g %.6g", result->observer ? "XYZ " : "", white[0],
                white[1], white[2]);
        chromaticity(white, xy);
        if (result->observer)
            fprintf(to, ", xy %.5f %.5f", xy[0], xy[1]);
        fprintf(to, " (%s)\n", options->white != NULL ? options->white : "recorded");
    }
}

/* All that decides a developed picture, but for the stack. */
static void print_settings(const struct develop_options *options,
                           const struct develop_result *result, FILE *to)
{
    static const char *const values[] = {
        [DEVELOP_RGB] = "RGB", [DEVELOP_XYZ] = "XYZ", [DEVELOP_LAB] = "CIELAB"};
    fprintf(to, "detector          %s (%s)\n", options->detector,
            result->observer ? "observer" : "camera or film, balanced to the white");
    if (result->sampling[0] != '\0')
        fprintf(to, "sampling          %s\n", result->sampling);
    print_white(options, result, to);
    fprintf(to, "adaptation        %s", adaptation_name(result->adaptation.kind));
    if (result->adaptation.kind == ADAPTATION_FAIRCHILD)
        fprintf(to, " to %.6g cd/m2", result->adaptation.luminance);
    fprintf(to, "\nvalues            %s", values[options->values]);
    if (options->values == DEVELOP_RGB)
        fprintf(to, " of %d bits\ndisplay           %s", options->bits,
                display_name(options->display));
    fprintf(to, "\nexposure          %.10g%s\n", result->exposure,
            options->exposure > 0 ? "" : " (auto)");
}

void develop_print(const struct develop_options *options, const struct develop_result *result,
                   FILE *to)
{
    const double pixels = (double)result->width * result->height, *lost = result->lost;
    print_settings(options, result, to);
    fprintf(to, "%s       %d, %s %.10g to %.10g nm\n",
            result->components ? "components " : "wavelengths", result->n_pages,
            result->components ? "of" : "from", result->first_nm, result->last_nm);
    fprintf(to, "unseen            %.4g %%, %.4g %%, %.4g %% of the sensitivities lie outside\n",
            100 * lost[0], 100 * lost[1], 100 * lost[2]);
    if (options->values == DEVELOP_RGB)
        fprintf(to, "out of gamut      %llu of %.0f pixels (%.3f %%)\n",
                (unsigned long long)result->out_of_gamut, pixels,
                100 * (double)result->out_of_gamut / pixels);
}

/* ---- the picture ---- */

/* ASCII: what else names hold becomes '?'. NULL: no memory. */
static char *description(const struct development *of)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (stream == NULL)
        return NULL;
    fprintf(stream, "developed by      " PROGRAM "\nstack             %s\n", of->cube.image.path);
    print_settings(of->options, of->result, stream);
    if (fclose(stream) != 0) {
        free(text);
        return NULL;
    }
    for (char *at = text; *at != '\0'; at++)
        if ((*at < ' ' || *at > '~') && *at != '\n')
            *at = '?';
    return text;
}

static bool open_picture(const struct development *of, const char *path, struct picture_writer *out,
                         struct error *err)
{
    const bool lab = of->options->values == DEVELOP_LAB, rgb = of->options->values == DEVELOP_RGB;
    unsigned char profile[LARGEST_PROFILE];
    char *text = description(of);
    if (text == NULL)
        return error_memory(err);
    const struct picture_options options = {
        .width = of->result->width,
        .height = of->result->height,
        .samples = !rgb                      ? PICTURE_FLOAT
                   : of->options->bits == 16 ? PICTURE_16
                                             : PICTURE_8,
        .channels = {lab ? "L*" : "X", lab ? "a*" : "Y", lab ? "b*" : "Z"},
        .profile = rgb ? profile : NULL,
        .profile_length = rgb ? profile_write(of->options->display, profile) : 0,
        .description = text};
    const bool done = picture_open(out, path, &options, err);
    free(text);
    return done;
}

static bool write_picture(struct development *of, const char *path, struct error *err)
{
    const struct image *image = &of->cube.image;
    struct picture_writer writer;
    bool done = open_picture(of, path, &writer, err);
    if (!done)
        return false;
    for (int y = 0; done && y < image->height; y += rows_at(of, y)) {
        const int rows = rows_at(of, y);
        done = sum_chunk(of, y, rows, err);
        of->result->out_of_gamut += store_chunk(of, (size_t)rows * (size_t)image->width);
        done = done && picture_write(&writer, of->samples, rows, err);
    }
    done = done && picture_commit(&writer, err);
    picture_discard(&writer);
    return done;
}

bool develop(const char *stack, const char *output, const struct develop_options *options,
             struct develop_result *out, struct error *err)
{
    struct development of = {.options = options, .result = out};
    bool done = cube_open(stack, &of.cube, err) && prepare_weights(&of, err) &&
                prepare_chunk(&of, err) && (options->exposure > 0 || find_exposure(&of, err)) &&
                write_picture(&of, output, err);
    cube_close(&of.cube);
    free(of.weights);
    free(of.radiance);
    free(of.sums);
    free(of.samples);
    return done;
}
