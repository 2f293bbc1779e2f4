/* SPDX-License-Identifier: MIT */
/* Finds where and by how much two stacks differ. Both are read in chunks of rows. Rows are compared
 * in parallel and added up in their order, so that no result depends on chunks or threads. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/beside/see/inside.h"

/* ---- a stack in chunks of rows ---- */

bool rows_allocate(struct stack_rows *rows, uint64_t most_samples, struct error *err)
{
    const uint64_t n_pages = (uint64_t)rows->cube.image.n_pages;
    const size_t width = (size_t)rows->cube.image.width, height = (size_t)rows->cube.image.height;
    const size_t fitting = (size_t)(most_samples / (n_pages * width));
    const size_t n = fitting < 1 ? 1 : fitting < height ? fitting : height;
    rows->end = rows->cube.image.height;
    rows->most = (int)n;
    rows->stride = n * width;
    return MAKE_ARRAY(rows->samples, n_pages * rows->stride, err, "rows of %s",
                      rows->cube.image.path);
}

bool rows_read(struct stack_rows *rows, int first, struct error *err)
{
    const int left = rows->end - first;
    rows->first = first;
    rows->n = left < rows->most ? left : rows->most;
    for (int page = 0; page < rows->cube.image.n_pages; page++)
        if (!image_read(&rows->cube.image, page, first, rows->n,
                        rows->samples + (size_t)page * rows->stride, err))
            return false;
    return true;
}

void rows_close(struct stack_rows *rows)
{
    cube_close(&rows->cube);
    free(rows->samples);
    rows->samples = NULL;
}

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
struct bin {
    uint64_t count;
    double largest;
};

static void peak_add(struct peak *to, struct peak peak)
{
    if (peak.largest > to->largest)
        *to = peak;
}

static void measure_add(struct pixel_difference *to, struct bin *bins, double value, int x, int y)
{
    const float rounded = (float)fmin(value, (double)FLT_MAX);
    uint32_t bits;
    memcpy(&bits, &rounded, sizeof bits); /* below 2^31: the value is not negative */
    struct bin *bin = &bins[bits >> MANTISSA_LEFT_OUT];
    bin->count++;
    bin->largest = fmax(bin->largest, value);
    to->mean += value;
    peak_add(&to->peak, (struct peak){value, x, y});
}

/* Finds the mean, and the least value that at least 95 % of the pixels do not exceed. */
static void measure_end(struct pixel_difference *of, const struct bin *bin, uint64_t n_pixels)
{
    const uint64_t wanted = n_pixels - n_pixels / 20;
    uint64_t so_far = bin->count;
    while (so_far < wanted)
        so_far += (++bin)->count;
    of->quantile_95 = bin->largest;
    of->mean /= (double)n_pixels;
}

/* ---- a pixel ---- */

double spectral_angle(const double *a, const double *b, int n)
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

static void compare_colours(const struct comparison *of, const double *a, const double *b,
                            double out[PIXEL_MEASURES])
{
    const int n = of->a.cube.image.n_pages;
    double xyz[3], lab_a[3], lab_b[3];
    detector_response(of->sight.weights, a, n, xyz);
    cielab(xyz, of->sight.white, lab_a);
    detector_response(of->sight.weights, b, n, xyz);
    cielab(xyz, of->sight.white, lab_b);
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
        peak_add(&bands[band].peak, (struct peak){difference, x, y});
    }
    return largest;
}

/* A CIEDE2000 of 1 is about the least difference that a person sees, in the middle of the scale. A
 * white surface under a light of 1 has radiance 1, and 16 bits hold steps of 1/65536 of that. */
static const struct {
    double least;
    const char *name;
} map_scales[] = {[MAP_CIEDE2000] = {1.0 / 64, "CIEDE2000"},
                  [MAP_RADIANCE] = {1.0 / 16384, "largest difference of radiance"},
                  [MAP_COMPONENT] = {1.0 / 16384, "largest difference of components"}};

void comparison_print_colours(const struct comparison *of, struct printed *to)
{
    print(to, "%s: 0 black, ", map_scales[of->shown].name);
    scale_print(map_scales[of->shown].least, to);
}

/* Stores the differences of a pixel in the map: three floats, or three bytes of a colour. */
static void map_pixel(struct comparison *of, size_t at, double largest)
{
    const double *measures = of->measures[at];
    if (of->shown == MAP_NUMBERS) {
        const size_t n = (size_t)of->a.n * (size_t)of->a.cube.image.width;
        of->samples[at] = (float)largest;
        of->samples[n + at] = (float)measures[SPECTRAL_ANGLE];
        of->samples[2 * n + at] = (float)fmin(measures[CIEDE2000], (double)FLT_MAX);
    } else
        scale_colour(of->shown == MAP_CIEDE2000 ? measures[CIEDE2000] : largest,
                     map_scales[of->shown].least, (uint8_t *)of->samples + 3 * at);
}

/* ---- rows ---- */

static void compare_row(void *context, int row)
{
    struct comparison *of = context;
    const int n = of->a.cube.image.n_pages, width = of->a.cube.image.width;
    struct band_difference *bands = of->row_bands + (size_t)row * (size_t)n;
    double *a = of->spectra + (size_t)row * 2 * (size_t)n, *b = a + n;
    memset(bands, 0, (size_t)n * sizeof *bands);
    of->largest_a[row] = 0;
    for (int x = 0; x < width; x++) {
        const size_t at = (size_t)row * (size_t)width + (size_t)x;
        for (int band = 0; band < n; band++) {
            a[band] = (double)of->a.samples[(size_t)band * of->a.stride + at];
            b[band] = (double)of->b.samples[(size_t)band * of->a.stride + at];
            of->largest_a[row] = fmax(of->largest_a[row], a[band]);
        }
        const double largest = compare_bands(a, b, n, x, of->a.first + row, bands);
        memset(of->measures[at], 0, sizeof of->measures[at]);
        if (largest > 0)
            of->measures[at][SPECTRAL_ANGLE] = spectral_angle(a, b, n);
        if (largest > 0 && of->sight.has_white)
            compare_colours(of, a, b, of->measures[at]);
        map_pixel(of, at, largest);
    }
}

static void add_row(struct comparison *of, int row)
{
    const int n = of->a.cube.image.n_pages, width = of->a.cube.image.width;
    const struct band_difference *bands = of->row_bands + (size_t)row * (size_t)n;
    for (int band = 0; band < n; band++) {
        peak_add(&of->bands[band].peak, bands[band].peak);
        of->bands[band].rms += bands[band].rms;
    }
    of->largest_radiance = fmax(of->largest_radiance, of->largest_a[row]);
    for (int x = 0; x < width; x++)
        for (int i = 0; i < PIXEL_MEASURES; i++)
            measure_add(&of->pixels[i], of->bins + i * N_BINS,
                        of->measures[(size_t)row * (size_t)width + (size_t)x][i], x,
                        of->a.first + row);
}

/* Turns sums into means and root mean squares. */
static void conclude(struct comparison *of)
{
    const struct image *image = &of->a.cube.image;
    const uint64_t n_pixels = (uint64_t)image->width * (uint64_t)image->height;
    double sum = 0;
    for (int band = 0; band < image->n_pages; band++) {
        if (of->bands[band].peak.largest > of->all.peak.largest) {
            of->all = of->bands[band];
            of->largest_band = band;
        }
        sum += of->bands[band].rms;
        of->bands[band].rms = sqrt(of->bands[band].rms / (double)n_pixels);
    }
    of->all.rms = sqrt(sum / (double)n_pixels / image->n_pages);
    for (int i = 0; i < PIXEL_MEASURES; i++)
        measure_end(&of->pixels[i], of->bins + i * N_BINS, n_pixels);
}

static bool compare_rows(struct comparison *of, struct error *err)
{
    for (int y = 0; y < of->a.cube.image.height; y += of->a.most) {
        if (!rows_read(&of->a, y, err) || !rows_read(&of->b, y, err))
            return false;
        threads_each(threads_count(of->options->threads), of->a.n, compare_row, of);
        for (int row = 0; row < of->a.n; row++)
            add_row(of, row);
        if (of->map && !picture_write(&of->picture, of->samples, of->a.n, err))
            return false;
    }
    conclude(of);
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

/* Refuses components of different samplings, and radiances in different units: the same number
 * means something else in each. A basis belongs to its scene, so the responses are compared, too.
 */
static bool check_samplings(const struct cube *a, const struct cube *b, struct error *err)
{
    const struct record *of_a = &a->record, *of_b = &b->record;
    if (a->components != b->components)
        return error_usage(err, "%s holds the components of %s, %s radiances at wavelengths",
                           (a->components ? a : b)->image.path,
                           (a->components ? of_a : of_b)->sampling,
                           (a->components ? b : a)->image.path);
    if (of_a->text && of_b->text && !of_a->unit != !of_b->unit)
        return error_usage(err, "the radiances of %s are in %s, those of %s in %s", a->image.path,
                           cube_unit(a), b->image.path, cube_unit(b));
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

/* Samples of a chunk of each stack: 64 MiB at most, but for a row. */
static const size_t chunk_samples = (size_t)16 << 20;

static bool allocate(struct comparison *of, struct error *err)
{
    if (!rows_allocate(&of->a, chunk_samples, err) || !rows_allocate(&of->b, chunk_samples, err))
        return false;
    const size_t n = (size_t)of->a.cube.image.n_pages, rows = (size_t)of->a.most;
    return MAKE_ARRAY(of->bins, PIXEL_MEASURES * N_BINS, err, "a distribution of differences") &&
           MAKE_ARRAY(of->bands, n, err, "the bands of %s", of->a.cube.image.path) &&
           MAKE_ARRAY(of->spectra, 2 * n * rows, err, "rows of two stacks") &&
           MAKE_ARRAY(of->row_bands, n * rows, err, "sums of rows") &&
           MAKE_ARRAY(of->largest_a, rows, err, "sums of rows") &&
           MAKE_ARRAY(of->measures, of->a.stride, err, "differences of rows") &&
           MAKE_ARRAY(of->samples, 3 * of->a.stride, err, "rows of the map");
}

static bool open_map(struct comparison *of, struct error *err)
{
    const bool components = of->a.cube.components;
    struct printed printed = {.text = NULL};
    print_text(&printed, "How two spectral stacks differ");
    if (picture_is_png(of->map)) { /* which has one number, in colours */
        of->shown = of->sight.has_white ? MAP_CIEDE2000 : components ? MAP_COMPONENT : MAP_RADIANCE;
        print_text(&printed, ". ");
        comparison_print_colours(of, &printed);
    }
    char *description = printed_take(&printed, err);
    const bool coloured = of->shown != MAP_NUMBERS;
    const struct picture_options options = {
        .width = of->a.cube.image.width,
        .height = of->a.cube.image.height,
        .bits = coloured ? 8 : 32,
        .srgb = coloured,
        .channels = {components ? "largest difference of components"
                                : "largest difference of radiance",
                     components ? "component angle in degrees" : "spectral angle in degrees",
                     "CIEDE2000"},
        .description = description};
    const bool done = description && picture_open(&of->picture, of->map, &options, err);
    free(description);
    return done;
}

/* ---- the comparison ---- */

bool compare(struct comparison *of, struct error *err)
{
    struct options *options = of->options;
    const struct white_request white = {options->white, of->tolerance.unit >= TOLERANCE_CIE76};
    struct cube *a = &of->a.cube, *b = &of->b.cube;
    return cube_open(options->operands[0], a, err) && cube_open(options->operands[1], b, err) &&
           check_samplings(a, b, err) && check_sizes(&a->image, &b->image, err) &&
           sight_make(a, options_detector(options), &white, &of->sight, err) && allocate(of, err) &&
           (!of->map || open_map(of, err)) && compare_rows(of, err) &&
           (!of->map || picture_commit(&of->picture, &options->outputs, err));
}

bool comparison_is_within(const struct comparison *of)
{
    const struct tolerance *tolerance = &of->tolerance;
    if (tolerance->unit >= TOLERANCE_CIE76)
        return of->pixels[CIE76 + (int)tolerance->unit - TOLERANCE_CIE76].peak.largest <=
               tolerance->value;
    const double unit = tolerance->unit == TOLERANCE_PERCENT ? of->largest_radiance / 100 : 1;
    return of->all.peak.largest <= tolerance->value * unit;
}

void comparison_free(struct comparison *of)
{
    rows_close(&of->a);
    rows_close(&of->b);
    sight_free(&of->sight);
    picture_discard(&of->picture); /* a committed picture stays */
    FREE_ALL(of->bins, of->bands, of->spectra, of->row_bands, of->largest_a, of->measures,
             of->samples);
}
