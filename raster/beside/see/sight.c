/* SPDX-License-Identifier: MIT */
/* How a detector sees a stack: the weights of its pages, its white, its objects. */
#include <float.h>

#include "raster/beside/see/inside.h"

/* A white: a surface under a light. */
struct lit_surface {
    struct spectrum light, reflectance;
    bool reflects; /* otherwise it is a perfect diffuser */
};

/* ---- weights ---- */

/* Weights and whites have this limit: no sum of them is infinite. */
static const double largest_number = (double)FLT_MAX;

static bool weights_are_finite(const struct cube *cube, const struct detector *detector,
                               const double *weights, struct error *err)
{
    for (int i = 0; i < detector->n * cube->image.n_pages; i++)
        if (!(fabs(weights[i]) <= largest_number))
            return error_usage(err, "%s: weight %g of page %d cannot be used; expected %g at most",
                               cube->image.path, weights[i], i % cube->image.n_pages + 1,
                               largest_number);
    return true;
}

/* Finds the weights of the pages in each channel. They follow from the sampling that the stack
 * records, otherwise from detector_weights. */
static bool find_weights(const struct cube *cube, const struct detector *detector, double *out,
                         struct error *err)
{
    const struct record *record = &cube->record;
    const struct image *image = &cube->image;
    const bool fixed = record->response.n > 0;
    if (fixed && strcmp(record->sampling_detector, detector->name) != 0)
        return error_usage(err,
                           "%s: was sampled by %s for %s only; expected --detector %s, or a stack "
                           "that was rendered with --detector %s",
                           image->path, record->sampling, record->sampling_detector,
                           record->sampling_detector, detector->name);
    if (fixed)
        memcpy(out, record->response.value, (size_t)record->response.n * sizeof *out);
    else if (record->segments.n > 0)
        sampling_weights(detector, image->wavelengths_nm, (double(*)[2])record->segments.value,
                         image->n_pages, out);
    else
        detector_weights(detector, image->wavelengths_nm, image->n_pages, out);
    return weights_are_finite(cube, detector, out, err);
}

static void find_lost(const struct cube *cube, const struct detector *detector, double *out)
{
    const struct record *record = &cube->record;
    const struct numbers *limits = record->response.n > 0 ? &record->range_nm : &record->segments;
    if (limits->n > 0)
        detector_lost_outside(detector, limits->value[0], limits->value[limits->n - 1], out);
    else
        detector_lost(detector, cube->image.wavelengths_nm, cube->image.n_pages, out);
}

/* Returns the radiance of a surface of this reflectance, or of a perfect diffuser, under a light.
 */
static double radiance_at(const struct lit_surface *of, double nm)
{
    return spectrum_at(&of->light, nm, SPECTRUM_ZERO) *
           (of->reflects ? spectrum_at(&of->reflectance, nm, SPECTRUM_HOLD) : 1);
}

/* Finds the response of a detector to a white, at every nm of the range of a fixed stack. NULL
 * stands for 1 everywhere. */
static bool respond_finely(const struct record *record, const struct detector *detector,
                           const struct lit_surface *white, double out[3], struct error *err)
{
    const double *range = record->range_nm.value;
    struct fine_detector fine;
    if (!fine_detector_make(detector, range[0] + 0.5,
                            (int)fmax(1, floor(range[1] - range[0] + 0.5)), &fine, err))
        return false;
    for (int j = 0; white && j < fine.n; j++)
        fine.nm[j] = radiance_at(white, fine.nm[j]); /* radiances now */
    detector_response(fine.weights, white ? fine.nm : NULL, fine.n, out);
    free(fine.nm);
    return true;
}

static bool find_equal(const struct cube *cube, struct sight *out, struct error *err)
{
    if (cube->record.response.n > 0)
        return respond_finely(&cube->record, &out->detector, NULL, out->equal, err);
    detector_response(out->weights, NULL, cube->image.n_pages, out->equal);
    return true;
}

/* ---- the white ---- */

/* Returns the mean over a box, by cells of 1 nm that begin at `origin`. */
static double mean_within(const struct lit_surface *white, const double limits[2], double origin)
{
    double sum = 0;
    for (double cell = origin + floor(limits[0] - origin); cell < limits[1]; cell++)
        sum += fmax(0, fmin(cell + 1, limits[1]) - fmax(cell, limits[0])) *
               radiance_at(white, cell + 0.5);
    return sum / (limits[1] - limits[0]);
}

/* Reads LIGHT or LIGHT*REFLECTANCE, one word, blanks and all. A reflectance is no light. */
static bool read_white(const char *value, struct lit_surface *out, struct error *err)
{
    const char *star = strrchr(value, '*');
    const struct place place = {"--white", 1, 1};
    struct word word = {.start = value, .length = strlen(value), .place = place},
                surface = {.start = star ? star + 1 : "", .place = place};
    char name[BUILTIN_NAME];
    surface.length = strlen(surface.start);
    out->reflects = surface.length > 0 && !word_begins_number(&surface);
    if (out->reflects)
        word.length = (size_t)(star - value);
    for (size_t i = 0; i < builtin_file_count; i++)
        if (builtin_is(&builtin_files[i], FILE_MATERIAL, name) && word_equals(&word, name))
            return error_at(err, place, "%s is a reflectance; name its light, too: d65*%s", name,
                            name);
    return spectrum_read(&word, 0, HUGE_VAL, &out->light, err) &&
           (!out->reflects || spectrum_read(&surface, 0, 1, &out->reflectance, err));
}

/* Finds the white that --white names: its radiance on each page, or, of a fixed stack, the response
 * of its detector. */
static bool white_of_option(const struct cube *cube, const char *value,
                            const struct detector *fixed, double *out, struct error *err)
{
    const struct record *record = &cube->record;
    struct sampling_method method;
    struct error ignored = {.status = EXIT_AGREED};
    const bool boxes = record->segments.n > 0 &&
                       sampling_read("", record->sampling, &method, &ignored) &&
                       method.kind == SAMPLING_BOX; /* pages are means over their segments */
    const double *segments = record->segments.value;
    struct lit_surface white = {.reflects = false};
    if (strncmp(value, "object:", 7) == 0 && fixed)
        return error_usage(err, "%s was sampled for %s; --white object: needs all wavelengths",
                           cube->image.path, record->sampling_detector);
    if (strncmp(value, "object:", 7) == 0)
        return object_radiance(cube->image.path, value + 7, out, err);
    const bool good = read_white(value, &white, err) &&
                      (!fixed || respond_finely(record, fixed, &white, out, err));
    for (int i = 0; good && !fixed && i < cube->image.n_pages; i++)
        out[i] = boxes ? mean_within(&white, segments + 2 * i, segments[0])
                       : radiance_at(&white, cube->image.wavelengths_nm[i]);
    spectrum_free(&white.light);
    spectrum_free(&white.reflectance);
    return good;
}

/* Finds that white; without a name, the one that the stack records. */
static bool find_white(const struct cube *cube, const char *spectrum, const struct detector *fixed,
                       double *out, struct error *err)
{
    const struct numbers *recorded = fixed ? &cube->record.white_response : &cube->record.white;
    const int n = fixed ? 3 : cube->image.n_pages;
    bool shines = false;
    if (spectrum == NULL && recorded->n == 0)
        return error_usage(err,
                           "%s has no white: no light of its scene shines at its wavelengths, or no"
                           " scene is recorded; develop --white SPECTRUM names one",
                           cube->image.path);
    if (spectrum == NULL)
        memcpy(out, recorded->value, (size_t)n * sizeof *out);
    else if (!white_of_option(cube, spectrum, fixed, out, err))
        return false;
    for (int i = 0; i < n; i++)
        shines = shines || out[i] > 0;
    return shines ||
           error_usage(err,
                       "%s: the white is 0 at all of the stack's wavelengths; expected one that"
                       " is above 0 at some",
                       cube->image.path);
}

bool cube_white(const struct cube *cube, const char *spectrum, double *out, struct error *err)
{
    return cube_needs_radiance(cube, "a white", err) && find_white(cube, spectrum, NULL, out, err);
}

/* Finds the response of the weights to a white; in a fixed stack, of its detector to the white at
 * every nm. Refuses a missing white that is needed or named, and a white too large to compute with.
 */
static bool find_white_response(const struct cube *cube, const char *spectrum, bool needed,
                                struct sight *out, struct error *err)
{
    const int n = cube->image.n_pages;
    const struct detector *fixed = cube->record.response.n > 0 ? &out->detector : NULL;
    struct error ignored = {.status = EXIT_AGREED};
    double *white;
    needed = needed || spectrum != NULL;
    if (!MAKE_ARRAY(white, n, err, "the white of %s", cube->image.path))
        return false;
    out->has_white =
        find_white(cube, spectrum, fixed, fixed ? out->white : white, needed ? err : &ignored);
    if (out->has_white && !fixed)
        detector_response(out->weights, white, n, out->white);
    free(white);
    for (int channel = 0; out->has_white && channel < 3; channel++)
        if (!(fabs(out->white[channel]) <= largest_number))
            return error_usage(err, "%s: the white has %g in channel %d; expected %g at most",
                               cube->image.path, out->white[channel], channel + 1, largest_number);
    return out->has_white || !needed;
}

/* ---- units ---- */

/* Takes an observer's XYZ to cd m-2. */
static void make_absolute(struct sight *of, int n_weights)
{
    const double luminance = detector_luminance(&of->detector);
    for (int i = 0; i < n_weights; i++)
        of->weights[i] *= luminance;
    for (int i = 0; i < 3; i++) {
        of->white[i] *= luminance;
        of->equal[i] *= luminance;
    }
}

struct seeing seeing_of(const struct options *options, bool needs_white)
{
    return (struct seeing){options_detector(options), options->matrix, options->white, needs_white};
}

/* ---- a matrix behind the detector ---- */

/* Takes the weights of the detector's channels to those of XYZ. */
static bool apply_matrix(const char *path, int n_pages, struct sight *of, struct error *err)
{
    double rows[MOST_CHANNELS][3], *xyz;
    const int n = of->n;
    if (!rows_of_three(path, (const char *const *)of->detector.channel, n, rows, err) ||
        !MAKE_ARRAY(xyz, 3 * n_pages, err, "the weights of %s", path))
        return false;
    for (int i = 0; i < 3 * n_pages; i++)
        for (int channel = 0; channel < n; channel++)
            xyz[i] += rows[channel][i / n_pages] * of->weights[channel * n_pages + i % n_pages];
    free(of->weights);
    of->weights = xyz;
    of->n = 3;
    of->observes = true;
    return true;
}

/* ---- as a detector sees it ---- */

bool sight_make(const struct cube *cube, enum sight_kind kind, const struct seeing *by,
                struct sight *out, struct error *err)
{
    static bool (*const read[])(const char *, struct detector *,
                                struct error *) = {[SIGHT_RELATIVE] = detector_read,
                                                   [SIGHT_OF_OBSERVER] = observer_read,
                                                   [SIGHT_OF_PICTURE] = detector_read,
                                                   [SIGHT_OF_CHANNELS] = channels_read};
    const bool has_matrix = by->matrix && kind != SIGHT_OF_CHANNELS;
    const int n_pages = cube->image.n_pages;
    if (has_matrix && cube->record.response.n > 0)
        return error_usage(err, "%s was sampled for %s; --matrix needs all wavelengths",
                           cube->image.path, cube->record.sampling_detector);
    if (!read[has_matrix ? SIGHT_OF_CHANNELS : kind](by->detector, &out->detector, err))
        return false;
    out->n = out->detector.n;
    out->observes = out->detector.observer;
    find_lost(cube, &out->detector, out->lost);
    if (!MAKE_ARRAY(out->weights, out->n * n_pages, err, "the weights of %s", cube->image.path) ||
        !find_weights(cube, &out->detector, out->weights, err) ||
        (has_matrix && !apply_matrix(by->matrix, n_pages, out, err)))
        return false;
    const bool balanced = kind == SIGHT_OF_PICTURE && !out->observes;
    if (kind != SIGHT_OF_CHANNELS &&
        (!find_white_response(cube, by->white, by->needs_white || balanced, out, err) ||
         !find_equal(cube, out, err)))
        return false;
    if (kind != SIGHT_RELATIVE && cube->record.unit && out->observes && !has_matrix)
        make_absolute(out, 3 * n_pages);
    return true;
}

bool sights_make(const struct cube *cube, const struct options *options, struct sight *camera,
                 struct sight *colours, struct error *err)
{
    struct seeing by = seeing_of(options, false);
    if (!sight_make(cube, SIGHT_OF_CHANNELS, &by, camera, err))
        return false;
    if (camera->observes)
        sight_free(camera);
    else if (!by.matrix)
        by.detector = "cie1931";
    return sight_make(cube, SIGHT_OF_OBSERVER, &by, colours, err);
}

void sight_free(struct sight *sight)
{
    detector_free(&sight->detector);
    free(sight->weights);
    sight->weights = NULL;
}

/* ---- the object map ---- */

bool cube_objects(const struct cube *cube, int x, int y, int n, int *out, struct error *err)
{
    const struct record *record = &cube->record;
    const uint64_t pixel = (uint64_t)y * (uint64_t)cube->image.width + (uint64_t)x;
    const size_t length = (size_t)record->map_bytes, count = (size_t)n;
    const unsigned char *bytes = (const unsigned char *)out;
    if (length > 0 && !image_read_bytes(&cube->image, record->map_offset + pixel * length,
                                        count * length, out, err))
        return false;
    for (size_t i = count; i-- > 0;) { /* from the end: a number takes more room than its bytes */
        int number = length > 0 ? bytes[i * length] : record->objects.n + 1;
        if (length > 1)
            number += 256 * bytes[i * length + 1];
        out[i] = number <= record->objects.n ? number : -1;
    }
    return true;
}
