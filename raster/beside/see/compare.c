/* SPDX-License-Identifier: MIT */
/* Finds where and by how much two stacks differ. Both are read in chunks of rows. Rows are compared
 * in parallel and added up in their order, so that no result depends on chunks or threads. */
#include <float.h>

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

/* ---- statistics of pixels ---- */

/* A measure of all pixels, in bins that share the first 10 binary digits of a float's mantissa. A
 * quantile is the largest value of its bin, which is too high by less than 1/1024. */
enum { MANTISSA_LEFT_OUT = 13 };

static void peak_add(struct peak *to, struct peak peak)
{
    if (peak.largest > to->largest)
        *to = peak;
}

void measure_add(struct pixel_difference *to, struct bin *bins, double value, int x, int y)
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
void measure_end(struct pixel_difference *of, const struct bin *bin, uint64_t n_pixels)
{
    const uint64_t wanted = n_pixels - n_pixels / 20;
    uint64_t so_far = bin->count;
    if (n_pixels == 0)
        return;
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

static void compare_colours(const struct comparison *of, const double a[3], const double *b,
                            double out[PIXEL_MEASURES])
{
    const double *weights = of->alike ? of->sight.weights : of->other.weights;
    double xyz[3], lab_a[3], lab_b[3];
    cielab(a, of->sight.white, lab_a);
    detector_response(weights, b, of->b.cube.image.n_pages, xyz);
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

/* Returns the least value that has a colour of its own. A CIEDE2000 of 1 is about the least
 * difference that a person sees, in the middle of the scale. A white surface under a light of 1 has
 * radiance 1, and 16 bits hold steps of 1/65536 of that. */
static double least_shown(const struct comparison *of)
{
    return of->sight.has_white ? 1.0 / 64 : 1.0 / 16384;
}

/* Returns what the map calls the largest |A - B|. */
static const char *largest_name(const struct comparison *of)
{
    return of->a.cube.components ? "largest difference of components"
                                 : "largest difference of radiance";
}

void comparison_print_colours(const struct comparison *of, struct printed *to)
{
    print(to, "%s: 0 black, ", of->sight.has_white ? "CIEDE2000" : largest_name(of));
    scale_print(least_shown(of), to);
}

/* Stores the differences of a pixel in the map: three floats, or three bytes of a colour. */
static void map_pixel(struct comparison *of, size_t at)
{
    const double *measures = of->measures[at];
    const size_t n = (size_t)of->b.n * (size_t)of->a.cube.image.width;
    if (of->coloured) {
        scale_colour(measures[of->sight.has_white ? CIEDE2000 : RADIANCE], least_shown(of),
                     (uint8_t *)of->samples + 3 * at);
        return;
    }
    of->samples[at] = (float)measures[RADIANCE];
    of->samples[n + at] = (float)measures[SPECTRAL_ANGLE];
    of->samples[2 * n + at] = (float)fmin(measures[CIEDE2000], (double)FLT_MAX);
}

/* ---- rows ---- */

/* Reads a pixel of the rows at hand. Returns the largest of its pages; 0: it is black, since no
 * page is negative. */
static double read_pixel(const struct stack_rows *rows, size_t at, double *out)
{
    double largest = 0;
    for (int page = 0; page < rows->cube.image.n_pages; page++) {
        out[page] = (double)rows->samples[(size_t)page * rows->stride + at];
        largest = fmax(largest, out[page]);
    }
    return largest;
}

/* A has been seen in an earlier comparison. */
static bool is_known(const struct comparison *of)
{
    return of->seen && of->seen->complete;
}

/* Sees a pixel of A, or knows it; its colour only if that is wanted. */
static struct seen_pixel see_pixel(const struct comparison *of, const double *pages, bool black,
                                   size_t pixel, bool coloured)
{
    struct seen_pixel seen = {.black = black};
    if (is_known(of))
        return of->seen->pixels[pixel];
    if (coloured)
        detector_response(of->sight.weights, pages, of->a.cube.image.n_pages, seen.xyz);
    if (of->seen)
        of->seen->pixels[pixel] = seen;
    return seen;
}

static void compare_row(void *context, int row)
{
    struct comparison *of = context;
    const int n_a = of->a.cube.image.n_pages, n_b = of->b.cube.image.n_pages,
              width = of->a.cube.image.width, y = of->b.first + row;
    struct band_difference *bands = of->row_bands + (size_t)row * (size_t)n_a;
    double *a = of->spectra + (size_t)row * (size_t)(n_a + n_b), *b = a + n_a;
    memset(bands, 0, (size_t)n_a * sizeof *bands);
    of->largest_a[row] = 0;
    for (int x = 0; x < width; x++) {
        const size_t at = (size_t)row * (size_t)width + (size_t)x;
        double *measures = of->measures[at];
        const double largest_a = is_known(of) ? 0 : read_pixel(&of->a, at, a),
                     largest_b = read_pixel(&of->b, at, b);
        const double largest = of->alike ? compare_bands(a, b, n_a, x, y, bands) : 0;
        const bool coloured = of->sight.has_white && (largest > 0 || !of->alike);
        const struct seen_pixel seen =
            see_pixel(of, a, largest_a == 0, (size_t)y * (size_t)width + (size_t)x, coloured);
        memset(measures, 0, sizeof of->measures[at]);
        measures[RADIANCE] = largest;
        if (largest > 0)
            measures[SPECTRAL_ANGLE] = spectral_angle(a, b, n_a);
        if (coloured)
            compare_colours(of, seen.xyz, b, measures);
        of->largest_a[row] = fmax(of->largest_a[row], largest_a);
        of->black[at] = seen.black && largest_b == 0;
        map_pixel(of, at);
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
    for (int x = 0; x < width; x++) {
        const size_t at = (size_t)row * (size_t)width + (size_t)x;
        of->n_pixels += !of->black[at];
        for (int i = 0; i < PIXEL_MEASURES && !of->black[at]; i++)
            measure_add(&of->pixels[i], of->bins + i * N_BINS, of->measures[at][i], x,
                        of->b.first + row);
    }
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
        measure_end(&of->pixels[i], of->bins + i * N_BINS, of->n_pixels);
}

static bool compare_rows(struct comparison *of, struct error *err)
{
    for (int y = 0; y < of->a.cube.image.height; y += of->a.most) {
        if (!(is_known(of) || rows_read(&of->a, y, err)) || !rows_read(&of->b, y, err))
            return false;
        threads_each(threads_count(of->options->threads), of->b.n, compare_row, of);
        for (int row = 0; row < of->b.n; row++)
            add_row(of, row);
        if (of->map && !picture_write(&of->picture, of->samples, of->b.n, err))
            return false;
    }
    if (of->seen)
        of->seen->complete = true;
    conclude(of);
    return true;
}

/* ---- preparations ---- */

/* Wavelengths that differ by less count as the same, since a file may hold them rounded. */
static const double same_nm = 1e-6;

/* Returns whether pages of the same number mean the same. A basis belongs to its scene, so the
 * responses of its components are compared, too. */
static bool are_alike(const struct cube *a, const struct cube *b)
{
    const struct record *of_a = &a->record, *of_b = &b->record;
    if (a->components != b->components || a->raw != b->raw || a->image.n_pages != b->image.n_pages)
        return false;
    for (int i = 0; i < a->image.n_pages; i++)
        if (!(fabs(a->image.wavelengths_nm[i] - b->image.wavelengths_nm[i]) < same_nm))
            return false;
    return !a->components || (strcmp(of_a->sampling, of_b->sampling) == 0 &&
                              strcmp(of_a->sampling_detector, of_b->sampling_detector) == 0 &&
                              of_a->response.n == of_b->response.n &&
                              memcmp(of_a->response.value, of_b->response.value,
                                     (size_t)of_a->response.n * sizeof(double)) == 0);
}

bool check_units(const struct cube *a, const struct cube *b, struct error *err)
{
    return !a->record.text || !b->record.text || !a->record.unit == !b->record.unit ||
           error_usage(err, "the radiances of %s are in %s, those of %s in %s", a->image.path,
                       a->unit, b->image.path, b->unit);
}

/* Refuses stacks of different size, and radiances in different units. */
static bool check_stacks(const struct cube *a, const struct cube *b, struct error *err)
{
    if (a->image.width != b->image.width || a->image.height != b->image.height)
        return error_at(err, (struct place){b->image.path, 0, 0},
                        "%d x %d pixels, but %s has %d x %d", b->image.width, b->image.height,
                        a->image.path, a->image.width, a->image.height);
    return check_units(a, b, err);
}

/* Refuses colours of raw values. */
static bool check_raw(const struct comparison *of, struct error *err)
{
    const struct cube *a = &of->a.cube, *b = &of->b.cube;
    const struct seeing by = comparison_seeing(of, false);
    return !(a->raw || b->raw) || (of->alike && !by.needs_white && !by.white && !by.matrix) ||
           error_usage(err,
                       "%s and %s: raw values have no colours; expected two files of as many "
                       "channels, and no option of colours",
                       a->image.path, b->image.path);
}

/* Refuses a tolerance and a map that colours do not have, where they alone are compared. */
static bool check_wanted(struct comparison *of, struct error *err)
{
    struct tolerance *tolerance = &of->tolerance;
    const bool radiance =
        tolerance->measure == RADIANCE && (tolerance->percent || tolerance->value > 0);
    if (!of->alike && (radiance || (of->map && !picture_is_png(of->map))))
        return error_usage(err,
                           "the pages of %s and %s differ, so that their colours alone can be "
                           "compared; expected %s",
                           of->a.cube.image.path, of->b.cube.image.path,
                           radiance ? "--tolerance as 0.5dE00" : "--map with .png");
    if (!of->alike && tolerance->measure == RADIANCE)
        tolerance->measure = CIEDE2000;
    return true;
}

/* Samples of a chunk of each stack: 64 MiB at most, but for a row. */
static const size_t chunk_samples = (size_t)16 << 20;

static bool allocate(struct comparison *of, struct error *err)
{
    const struct image *a = &of->a.cube.image;
    const size_t n = (size_t)a->n_pages, n_b = (size_t)of->b.cube.image.n_pages,
                 width = (size_t)a->width, n_pixels = width * (size_t)a->height,
                 chunk = chunk_samples / (n > n_b ? n : n_b); /* the same rows of both */
    if (!rows_allocate(&of->a, chunk * n, err) || !rows_allocate(&of->b, chunk * n_b, err))
        return false;
    const size_t rows = (size_t)of->a.most;
    return MAKE_ARRAY(of->bins, PIXEL_MEASURES * N_BINS, err, "a distribution of differences") &&
           MAKE_ARRAY(of->bands, n, err, "the bands of %s", of->a.cube.image.path) &&
           MAKE_ARRAY(of->spectra, (n + n_b) * rows, err, "rows of two stacks") &&
           MAKE_ARRAY(of->row_bands, n * rows, err, "sums of rows") &&
           MAKE_ARRAY(of->largest_a, rows, err, "sums of rows") &&
           MAKE_ARRAY(of->measures, of->a.stride, err, "differences of rows") &&
           MAKE_ARRAY(of->black, of->a.stride, err, "differences of rows") &&
           MAKE_ARRAY(of->samples, 3 * of->a.stride, err, "rows of the map") &&
           (!of->seen || of->seen->pixels ||
            MAKE_ARRAY(of->seen->pixels, n_pixels, err, "the colours of %s", a->path));
}

static bool open_map(struct comparison *of, struct error *err)
{
    struct printed printed = {.text = NULL};
    print_text(&printed, "How two spectral stacks differ");
    of->coloured = picture_is_png(of->map);
    if (of->coloured) {
        print_text(&printed, ". ");
        comparison_print_colours(of, &printed);
    }
    char *description = printed_take(&printed, err);
    const struct picture_options options = {.width = of->a.cube.image.width,
                                            .height = of->a.cube.image.height,
                                            .bits = of->coloured ? 8 : 32,
                                            .srgb = of->coloured,
                                            .channels = {largest_name(of),
                                                         of->a.cube.components
                                                             ? "component angle in degrees"
                                                             : "spectral angle in degrees",
                                                         "CIEDE2000"},
                                            .description = description};
    const bool done = description && picture_open(&of->picture, of->map, &options, err);
    free(description);
    return done;
}

/* ---- the comparison ---- */

struct seeing comparison_seeing(const struct comparison *of, bool is_b)
{
    struct seeing by = seeing_of(of->options, of->tolerance.measure != RADIANCE || !of->alike);
    if (is_b)
        by = (struct seeing){of->other_detector ? of->other_detector : by.detector, by.matrix, NULL,
                             false};
    else if (of->other_detector)
        by.matrix = NULL;
    return by;
}

bool compare(struct comparison *of, struct error *err)
{
    struct options *options = of->options;
    struct cube *a = &of->a.cube, *b = &of->b.cube;
    if (!cube_or_raw_open(options->operands[0], a, err) ||
        !cube_or_raw_open(options->operands[1], b, err))
        return false;
    of->alike = !of->seen && !of->other_detector && are_alike(a, b);
    const struct seeing by = comparison_seeing(of, false), other = comparison_seeing(of, true);
    return check_stacks(a, b, err) && check_raw(of, err) && check_wanted(of, err) &&
           sight_make(a, SIGHT_OF_OBSERVER, &by, &of->sight, err) &&
           (of->alike || sight_make(b, SIGHT_OF_OBSERVER, &other, &of->other, err)) &&
           allocate(of, err) && (!of->map || open_map(of, err)) && compare_rows(of, err) &&
           (!of->map || picture_commit(&of->picture, &options->outputs, err));
}

bool comparison_is_within(const struct comparison *of)
{
    const struct tolerance *tolerance = &of->tolerance;
    const double unit = tolerance->percent ? of->largest_radiance / 100 : 1;
    return of->pixels[tolerance->measure].peak.largest <= tolerance->value * unit;
}

void comparison_free(struct comparison *of)
{
    rows_close(&of->a);
    rows_close(&of->b);
    sight_free(&of->sight);
    sight_free(&of->other);
    picture_discard(&of->picture); /* a committed picture stays */
    FREE_ALL(of->bins, of->bands, of->spectra, of->row_bands, of->largest_a, of->measures,
             of->black, of->samples);
}

bool stack_difference(struct seen_stack *a, const char *b, const char *observer, int threads,
                      struct pixel_difference *out, struct error *err)
{
    struct options options = {
        .operands = {a->path, b}, .n_operands = 2, .detector = observer, .threads = threads};
    struct comparison of = {.options = &options, .tolerance = {.measure = CIEDE2000}, .seen = a};
    const bool done = compare(&of, err);
    if (done)
        *out = of.pixels[CIEDE2000];
    comparison_free(&of);
    return done;
}
