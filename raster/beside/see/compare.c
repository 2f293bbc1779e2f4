/* SPDX-License-Identifier: MIT */
/* Finds where and by how much two stacks differ. Both are read in chunks of rows. Rows are compared
 * in parallel and added up in their order, so that no result depends on chunks or threads. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/images/images.h"
#include "data/maths/maths.h"
#include "raster/beside/see/inside.h"

/* ---- tolerances ---- */

bool tolerance_read(const char *option, const char *text, struct tolerance *out, struct error *err)
{
    static const struct {
        const char *ending;
        enum tolerance_unit unit;
    } units[] = {{"dE76", TOLERANCE_CIE76},
                 {"dE94", TOLERANCE_CIE94},
                 {"dE00", TOLERANCE_CIEDE2000},
                 {"%", TOLERANCE_PERCENT}};
    struct word word = {.start = text, .length = strlen(text), .place = {option, 0, 0}};
    out->unit = TOLERANCE_RADIANCE;
    for (size_t i = 0; i < sizeof units / sizeof units[0]; i++) {
        const size_t length = strlen(units[i].ending);
        if (word.length > length && strcmp(text + word.length - length, units[i].ending) == 0) {
            out->unit = units[i].unit;
            word.length -= length;
            break;
        }
    }
    struct error ignored = {.status = EXIT_AGREED};
    return word_number(&word, "tolerance", 0, HUGE_VAL, &out->value, &ignored) ||
           error_usage(err,
                       "%s takes a radiance as 0.01, a share of the largest as 0.1%%, or a "
                       "colour difference as 0.5dE00, not '%.100s'",
                       option, text);
}

/* ---- statistics of pixels ---- */

/* A measure of all pixels, in bins that share the first 10 binary digits of a float's mantissa. A
 * quantile is the largest value of its bin, which is too high by less than 1/1024. */
enum { MANTISSA_LEFT_OUT = 13, N_BINS = 1 << 18 };
struct distribution {
    uint64_t *count;
    double *largest; /* of each bin */
    double sum;
};

static bool distribution_open(struct distribution *out, struct error *err)
{
    return MAKE_ARRAY(out->count, N_BINS, err, "a distribution of differences") &&
           MAKE_ARRAY(out->largest, N_BINS, err, "a distribution of differences");
}

static void distribution_add(struct distribution *to, struct pixel_difference *difference,
                             double value, int x, int y)
{
    const float rounded = (float)fmin(value, (double)FLT_MAX);
    uint32_t bits;
    memcpy(&bits, &rounded, sizeof bits); /* below 2^31: the value is not negative */
    const uint32_t bin = bits >> MANTISSA_LEFT_OUT;
    to->count[bin]++;
    to->largest[bin] = fmax(to->largest[bin], value);
    to->sum += value;
    if (value > difference->largest) {
        difference->largest = value;
        difference->x = x;
        difference->y = y;
    }
}

/* Finds the mean, and the least value that at least 95 % of the pixels do not exceed. */
static void distribution_end(const struct distribution *of, uint64_t n_pixels,
                             struct pixel_difference *out)
{
    const uint64_t wanted = n_pixels - n_pixels / 20;
    uint64_t so_far = of->count[0];
    int bin = 0;
    while (so_far < wanted)
        so_far += of->count[++bin];
    out->quantile_95 = of->largest[bin];
    out->mean = of->sum / (double)n_pixels;
}

static void distribution_free(struct distribution *distribution)
{
    FREE_ALL(distribution->count, distribution->largest);
}

/* ---- a pixel ---- */

/* Returns the angle in degrees: 0 if both are black, 90 if one is. b is the sum of a multiple of a
 * and of a rest at right angles to a. The rest gives the sine, so that small angles keep their
 * digits. */
static double spectral_angle(const double *a, const double *b, int n)
{
    double aa = 0, bb = 0, ab = 0, rest = 0;
    for (int i = 0; i < n; i++) {
        aa += a[i] * a[i];
        bb += b[i] * b[i];
        ab += a[i] * b[i];
    }
    if (aa == 0 || bb == 0)
        return aa == bb ? 0 : 90;
    for (int i = 0; i < n; i++) {
        const double across = b[i] - a[i] * (ab / aa);
        rest += across * across;
    }
    return angle_of(fmin(sqrt(rest / bb), 1), fmin(ab / sqrt(aa) / sqrt(bb), 1)) * (180 / PI);
}

/* ---- the map in colours ---- */

/* A CIEDE2000 of 1 is about the least difference that a person sees, in the middle of the scale. A
 * white surface under a light of 1 has radiance 1, and 16 bits hold steps of 1/65536 of that. */
static const struct {
    double least;
    const char *name;
} map_scales[] = {[MAP_CIEDE2000] = {1.0 / 64, "CIEDE2000"},
                  [MAP_RADIANCE] = {1.0 / 16384, "largest difference of radiance"},
                  [MAP_COMPONENT] = {1.0 / 16384, "largest difference of components"}};

static void print_colours(enum map_measure measure, struct printed *to)
{
    print(to, "%s: 0 black, ", map_scales[measure].name);
    scale_print(map_scales[measure].least, to);
}

/* ---- a row ---- */

struct comparer {
    const struct compare_options *options;
    struct comparison *out;
    struct stack_rows a, b;
    struct sight sight; /* of A; it holds for B too */
    int threads;
    double *spectra;                    /* [row][a, b][band]: the pixel at hand */
    struct band_difference *bands;      /* [row][band]; rms: sum of squares so far */
    double *largest_a;                  /* [row] */
    double (*measures)[PIXEL_MEASURES]; /* [row][x] */
    float (*map)[3];                    /* [row][x]: values of a TIFF */
    uint8_t (*colours)[3];              /* [row][x]: those of a PNG */
    struct distribution distributions[PIXEL_MEASURES];
    struct picture_writer picture;
};

static void compare_colours(const struct comparer *comparer, const double *a, const double *b,
                            double out[PIXEL_MEASURES])
{
    const int n = comparer->out->n;
    double xyz[3], lab_a[3], lab_b[3];
    detector_response(comparer->sight.weights, a, n, xyz);
    cielab(xyz, comparer->sight.white, lab_a);
    detector_response(comparer->sight.weights, b, n, xyz);
    cielab(xyz, comparer->sight.white, lab_b);
    out[CIE76] = cie76_difference(lab_a, lab_b);
    out[CIE94] = cie94_difference(lab_a, lab_b);
    out[CIEDE2000] = ciede2000_difference(lab_a, lab_b);
}

/* Adds the differences of a pixel in each band. Returns the largest. */
static double compare_bands(const double *a, const double *b, int n, int x, int y,
                            struct band_difference *bands)
{
    double largest = 0;
    for (int band = 0; band < n; band++) {
        const double difference = fabs(a[band] - b[band]);
        bands[band].rms += difference * difference;
        largest = fmax(largest, difference);
        if (difference > bands[band].largest) {
            bands[band].largest = difference;
            bands[band].x = x;
            bands[band].y = y;
        }
    }
    return largest;
}

/* Stores the differences of a pixel in the map. */
static void map_pixel(struct comparer *comparer, size_t at, double largest)
{
    const double *measures = comparer->measures[at];
    const enum map_measure shown = comparer->out->map;
    comparer->map[at][0] = (float)largest;
    comparer->map[at][1] = (float)measures[SPECTRAL_ANGLE];
    comparer->map[at][2] = (float)fmin(measures[CIEDE2000], (double)FLT_MAX);
    if (shown != MAP_NUMBERS)
        scale_colour(shown == MAP_CIEDE2000 ? measures[CIEDE2000] : largest,
                     map_scales[shown].least, comparer->colours[at]);
}

static void compare_row(void *context, int row)
{
    struct comparer *comparer = context;
    const int n = comparer->out->n, width = comparer->out->width;
    const size_t stride = comparer->a.stride;
    struct band_difference *bands = comparer->bands + (size_t)row * (size_t)n;
    double *a = comparer->spectra + (size_t)row * 2 * (size_t)n, *b = a + n;
    memset(bands, 0, (size_t)n * sizeof *bands);
    comparer->largest_a[row] = 0;
    for (int x = 0; x < width; x++) {
        const size_t at = (size_t)row * (size_t)width + (size_t)x;
        for (int band = 0; band < n; band++) {
            a[band] = (double)comparer->a.samples[(size_t)band * stride + at];
            b[band] = (double)comparer->b.samples[(size_t)band * stride + at];
            comparer->largest_a[row] = fmax(comparer->largest_a[row], a[band]);
        }
        const double largest = compare_bands(a, b, n, x, comparer->a.first + row, bands);
        double *measures = comparer->measures[at];
        memset(measures, 0, sizeof comparer->measures[at]);
        if (largest > 0)
            measures[SPECTRAL_ANGLE] = spectral_angle(a, b, n);
        if (largest > 0 && comparer->out->has_white)
            compare_colours(comparer, a, b, measures);
        map_pixel(comparer, at, largest);
    }
}

/* ---- all rows ---- */

static void add_row(struct comparer *comparer, int row)
{
    const int y = comparer->a.first + row;
    struct comparison *out = comparer->out;
    const struct band_difference *bands = comparer->bands + (size_t)row * (size_t)out->n;
    for (int band = 0; band < out->n; band++) {
        const double sum = out->bands[band].rms + bands[band].rms;
        if (bands[band].largest > out->bands[band].largest)
            out->bands[band] = bands[band];
        out->bands[band].rms = sum;
    }
    out->largest_radiance = fmax(out->largest_radiance, comparer->largest_a[row]);
    for (int x = 0; x < out->width; x++) {
        const size_t at = (size_t)row * (size_t)out->width + (size_t)x;
        for (int i = 0; i < PIXEL_MEASURES; i++)
            distribution_add(&comparer->distributions[i], &out->pixels[i],
                             comparer->measures[at][i], x, y);
    }
}

static bool compare_chunk(struct comparer *comparer, int first, struct error *err)
{
    if (!rows_read(&comparer->a, first, err) || !rows_read(&comparer->b, first, err))
        return false;
    threads_each(comparer->threads, comparer->a.n, compare_row, comparer);
    for (int row = 0; row < comparer->a.n; row++)
        add_row(comparer, row);
    return !comparer->options->map ||
           picture_write(&comparer->picture,
                         comparer->out->map == MAP_NUMBERS ? (const void *)comparer->map
                                                           : (const void *)comparer->colours,
                         comparer->a.n, err);
}

/* Turns sums into means and root mean squares. */
static void conclude(struct comparer *comparer)
{
    struct comparison *out = comparer->out;
    const uint64_t n_pixels = (uint64_t)out->width * (uint64_t)out->height;
    double sum = 0;
    for (int band = 0; band < out->n; band++) {
        if (out->bands[band].largest > out->all.largest) {
            out->all = out->bands[band];
            out->largest_band = band;
        }
        sum += out->bands[band].rms;
        out->bands[band].rms = sqrt(out->bands[band].rms / (double)n_pixels);
    }
    out->all.rms = sqrt(sum / (double)n_pixels / out->n);
    for (int i = 0; i < PIXEL_MEASURES; i++)
        distribution_end(&comparer->distributions[i], n_pixels, &out->pixels[i]);
}

static bool compare_chunks(struct comparer *comparer, struct error *err)
{
    for (int y = 0; y < comparer->out->height; y += comparer->a.most)
        if (!compare_chunk(comparer, y, err))
            return false;
    conclude(comparer);
    return true;
}

/* ---- preparations ---- */

/* Wavelengths that differ by less count as the same, since a file may hold them rounded. */
static const double same_nm = 1e-6;

static bool check_sizes(const struct image *a, const struct image *b, struct error *err)
{
    const struct place place = {b->path, 0, 0};
    if (a->width != b->width || a->height != b->height)
        return error_at(err, place, "%d x %d pixels, but %s has %d x %d", b->width, b->height,
                        a->path, a->width, a->height);
    if (a->n_pages != b->n_pages)
        return error_at(err, place, "%d wavelengths, but %s has %d", b->n_pages, a->path,
                        a->n_pages);
    for (int i = 0; i < a->n_pages; i++)
        if (!(fabs(a->wavelengths_nm[i] - b->wavelengths_nm[i]) < same_nm))
            return error_at(err, place, "page %d is %.10g nm, but in %s %.10g nm", i + 1,
                            b->wavelengths_nm[i], a->path, a->wavelengths_nm[i]);
    return true;
}

/* Refuses components of different samplings: the same number means something else in each. A basis
 * belongs to its scene, so the responses are compared, too. */
static bool check_samplings(const struct cube *a, const struct cube *b, struct error *err)
{
    const struct record *of_a = &a->record, *of_b = &b->record;
    if (a->components != b->components)
        return error_usage(err, "%s holds the components of %s, %s radiances at wavelengths",
                           (a->components ? a : b)->image.path,
                           (a->components ? of_a : of_b)->sampling,
                           (a->components ? b : a)->image.path);
    if (!a->components)
        return true;
    const bool alike = strcmp(of_a->sampling, of_b->sampling) == 0 &&
                       strcmp(of_a->sampling_detector, of_b->sampling_detector) == 0;
    return (alike && of_a->response.n == of_b->response.n &&
            memcmp(of_a->response.value, of_b->response.value,
                   (size_t)of_a->response.n * sizeof *of_a->response.value) == 0) ||
           error_usage(
               err, "%s and %s hold components of different samplings: %s for %s, and %s for %s%s",
               a->image.path, b->image.path, of_a->sampling, of_a->sampling_detector,
               of_b->sampling, of_b->sampling_detector, alike ? " of other spectra" : "");
}

static bool prepare_colour(struct comparer *comparer, struct error *err)
{
    const struct compare_options *options = comparer->options;
    const struct white_request white = {options->white, options->tolerance.unit >= TOLERANCE_CIE76};
    struct comparison *out = comparer->out;
    const bool done = string_copy(options->observer, &out->observer, err) &&
                      sight_make(&comparer->a.cube, out->observer, &white, &comparer->sight, err);
    out->has_white = comparer->sight.has_white;
    return done;
}

/* Samples of a chunk of each stack: 64 MiB at most, but for a row. */
static const size_t chunk_samples = (size_t)16 << 20;

static bool prepare_chunk(struct comparer *comparer, struct error *err)
{
    if (!rows_allocate(&comparer->a, chunk_samples, err) ||
        !rows_allocate(&comparer->b, chunk_samples, err))
        return false;
    const size_t n = (size_t)comparer->out->n, rows = (size_t)comparer->a.most,
                 pixels = comparer->a.stride;
    comparer->threads = threads_count(comparer->options->threads);
    for (int i = 0; i < PIXEL_MEASURES; i++)
        if (!distribution_open(&comparer->distributions[i], err))
            return false;
    return MAKE_ARRAY(comparer->spectra, 2 * n * rows, err, "rows of two stacks") &&
           MAKE_ARRAY(comparer->bands, n * rows, err, "sums of rows") &&
           MAKE_ARRAY(comparer->largest_a, rows, err, "sums of rows") &&
           MAKE_ARRAY(comparer->measures, pixels, err, "differences of rows") &&
           MAKE_ARRAY(comparer->map, pixels, err, "rows of the map") &&
           MAKE_ARRAY(comparer->colours, pixels, err, "colours of rows");
}

static bool prepare(struct comparer *comparer, struct error *err)
{
    const struct image *image = &comparer->a.cube.image;
    struct comparison *out = comparer->out;
    const size_t n = (size_t)image->n_pages;
    *out = (struct comparison){.n = image->n_pages,
                               .width = image->width,
                               .height = image->height,
                               .components = comparer->a.cube.components};
    if (!MAKE_ARRAY(out->wavelengths_nm, n, err, "the bands of %s", image->path) ||
        !MAKE_ARRAY(out->bands, n, err, "the bands of %s", image->path))
        return false;
    memcpy(out->wavelengths_nm, image->wavelengths_nm, n * sizeof *out->wavelengths_nm);
    return check_samplings(&comparer->a.cube, &comparer->b.cube, err) &&
           check_sizes(image, &comparer->b.cube.image, err) && prepare_colour(comparer, err) &&
           prepare_chunk(comparer, err);
}

/* Returns what the map shows: a PNG has one number in colours. */
static enum map_measure map_measure(const struct comparer *comparer)
{
    const char *map = comparer->options->map;
    return !map || !picture_is_png(map) ? MAP_NUMBERS
           : comparer->out->has_white   ? MAP_CIEDE2000
           : comparer->out->components  ? MAP_COMPONENT
                                        : MAP_RADIANCE;
}

/* Returns the description of the map, allocated. NULL: no memory. */
static char *map_description(const struct comparison *comparison, struct error *err)
{
    struct printed printed = {.text = NULL};
    print_text(&printed, "How two spectral stacks differ");
    if (comparison->map != MAP_NUMBERS) {
        print_text(&printed, ". ");
        print_colours(comparison->map, &printed);
    }
    return printed_take(&printed, err);
}

static bool open_map(struct comparer *comparer, struct error *err)
{
    struct comparison *out = comparer->out;
    out->map = map_measure(comparer);
    if (!comparer->options->map)
        return true;
    char *description = map_description(out, err);
    if (!description)
        return false;
    const struct picture_options options = {
        .width = out->width,
        .height = out->height,
        .bits = out->map == MAP_NUMBERS ? 32 : 8,
        .srgb = out->map != MAP_NUMBERS,
        .channels = {out->components ? "largest difference of components"
                                     : "largest difference of radiance",
                     out->components ? "component angle in degrees" : "spectral angle in degrees",
                     "CIEDE2000"},
        .description = description};
    const bool done = picture_open(&comparer->picture, comparer->options->map, &options, err);
    free(description);
    return done;
}

/* ---- the comparison ---- */

static void comparer_free(struct comparer *comparer)
{
    rows_close(&comparer->a);
    rows_close(&comparer->b);
    sight_free(&comparer->sight);
    for (int i = 0; i < PIXEL_MEASURES; i++)
        distribution_free(&comparer->distributions[i]);
    FREE_ALL(comparer->spectra, comparer->bands, comparer->largest_a, comparer->measures,
             comparer->map, comparer->colours);
}

bool compare(const char *a, const char *b, const struct compare_options *options,
             struct comparison *out, struct error *err)
{
    struct comparer comparer = {.options = options, .out = out};
    *out = (struct comparison){.n = 0};
    bool done = cube_open(a, &comparer.a.cube, err) && cube_open(b, &comparer.b.cube, err) &&
                prepare(&comparer, err);
    const bool opened = done && open_map(&comparer, err);
    done = opened && compare_chunks(&comparer, err) &&
           (!options->map || picture_commit(&comparer.picture, options->outputs, err));
    if (opened && options->map)
        picture_discard(&comparer.picture); /* a committed picture stays */
    comparer_free(&comparer);
    return done;
}

bool comparison_is_within(const struct comparison *comparison, const struct tolerance *tolerance)
{
    if (tolerance->unit >= TOLERANCE_CIE76)
        return comparison->pixels[CIE76 + (int)tolerance->unit - TOLERANCE_CIE76].largest <=
               tolerance->value;
    const double unit =
        tolerance->unit == TOLERANCE_PERCENT ? comparison->largest_radiance / 100 : 1;
    return comparison->all.largest <= tolerance->value * unit;
}

/* Writes the pixel of the largest difference, or "none". */
static void pixel_text(double largest, int x, int y, char out[32])
{
    if (largest > 0)
        snprintf(out, 32, "%d,%d", x, y);
    else
        snprintf(out, 32, "none");
}

static void print_bands(const struct comparison *comparison, struct printed *to)
{
    print(to, "%-17s %-12s %-11s %s\n", comparison->components ? "component" : "wavelength (nm)",
          "largest", "at pixel", "RMS");
    for (int i = 0; i < comparison->n; i++) {
        const struct band_difference *band = &comparison->bands[i];
        char pixel[32];
        pixel_text(band->largest, band->x, band->y, pixel);
        print(to, "%-17.10g %-12.6g %-11s %.6g\n", comparison->wavelengths_nm[i], band->largest,
              pixel, band->rms);
    }
}

static void print_pixels(const struct comparison *comparison, struct printed *to)
{
    const char *const names[] = {comparison->components ? "component angle" : "spectral angle",
                                 "CIE76", "CIE94", "CIEDE2000"};
    for (int i = 0; i < (comparison->has_white ? PIXEL_MEASURES : 1); i++) {
        const struct pixel_difference *difference = &comparison->pixels[i];
        char pixel[32];
        pixel_text(difference->largest, difference->x, difference->y, pixel);
        print(to, "%-17s %.6g (mean), %.6g (95th percentile), %.6g (largest, at pixel %s)\n",
              names[i], difference->mean, difference->quantile_95, difference->largest, pixel);
    }
}

void comparison_print(const struct comparison *comparison, struct printed *to)
{
    const bool components = comparison->components;
    const char *unit = components ? "" : " W sr-1 m-2 nm-1 (relative)";
    const struct band_difference *all = &comparison->all;
    char pixel[32];
    pixel_text(all->largest, all->x, all->y, pixel);
    print_bands(comparison, to);
    print(to, "stacks            %d x %d pixels, %d %s\n", comparison->width, comparison->height,
          comparison->n, components ? "components" : "wavelengths");
    print(to, "largest           %.6g%s at %s%.10g%s, at pixel %s\n", all->largest, unit,
          components ? "component " : "", comparison->wavelengths_nm[comparison->largest_band],
          components ? "" : " nm", pixel);
    print(to, "RMS               %.6g%s\n", all->rms, unit);
    print(to, "largest of A      %.6g%s\n", comparison->largest_radiance, unit);
    print_pixels(comparison, to);
    if (comparison->has_white)
        print(to, "observer          %s\n", comparison->observer);
    else
        print(to, "colour            none: there is no white; --white SPECTRUM gives one\n");
    if (comparison->map != MAP_NUMBERS) {
        print_text(to, "map colours       ");
        print_colours(comparison->map, to);
        print(to, "%c", '\n');
    }
}

void comparison_free(struct comparison *comparison)
{
    FREE_ALL(comparison->wavelengths_nm, comparison->bands, comparison->observer);
    *comparison = (struct comparison){.n = 0};
}
