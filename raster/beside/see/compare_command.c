/* SPDX-License-Identifier: MIT */
/* spectral compare: prints where and by how much two stacks differ, in words and as JSON. */
#include <inttypes.h>

#include "raster/beside/see/inside.h"

struct compare_own {
    const char *tolerance, *map, *other;
    bool objects;
};

/* ---- the tolerance ---- */

/* Reads "0.01", "0.1%", "0.5dE00", "0.5dE94" or "0.5dE76", the value of --tolerance. */
static bool read_tolerance(const char *text, struct tolerance *out, struct error *err)
{
    static const struct {
        const char *ending;
        enum pixel_measure measure;
    } units[] = {{"dE76", CIE76}, {"dE94", CIE94}, {"dE00", CIEDE2000}, {"%", RADIANCE}};
    struct word word = {.start = text, .length = strlen(text)};
    out->measure = RADIANCE;
    out->percent = false;
    for (size_t i = 0; i < sizeof units / sizeof units[0]; i++) {
        const size_t length = strlen(units[i].ending);
        if (word.length > length && strcmp(text + word.length - length, units[i].ending) == 0) {
            out->measure = units[i].measure;
            out->percent = units[i].measure == RADIANCE;
            word.length -= length;
            break;
        }
    }
    return word_is_number(&word, 0, &out->value) ||
           error_at(err, VALUE_OF("--tolerance"),
                    "expected a radiance as 0.01, a share of the largest as 0.1%%, or a "
                    "colour difference as 0.5dE00, not '%.100s'",
                    text);
}

/* ---- in words ---- */

static const char *name_of_pixel(const struct peak *peak, char out[32])
{
    snprintf(out, 32, "%d,%d", peak->x, peak->y);
    return peak->largest > 0 ? out : "none";
}

/* Returns what a page without a wavelength is; NULL: it has one. */
static const char *page_word(const struct cube *cube)
{
    return cube->raw ? "channel" : cube->components ? "component" : NULL;
}

static void print_bands(const struct comparison *of, struct printed *to)
{
    char pixel[32];
    const char *word = page_word(&of->a.cube);
    print(to, "%-17s %-12s %-11s %s\n", word ? word : "wavelength (nm)", "largest", "at pixel",
          "RMS");
    for (int i = 0; i < of->a.cube.image.n_pages; i++) {
        const struct band_difference *band = &of->bands[i];
        print(to, "%-17.10g %-12.6g %-11s %.6g\n", of->a.cube.image.wavelengths_nm[i],
              band->peak.largest, name_of_pixel(&band->peak, pixel), band->rms);
    }
}

/* Prints the measures of pixels; without a white there are no colours. */
static void print_pixels(const struct comparison *of, struct printed *to)
{
    const char *const names[] = {NULL, of->a.cube.components ? "component angle" : "spectral angle",
                                 "CIE76", "CIE94", "CIEDE2000"};
    char pixel[32];
    for (int i = of->alike ? SPECTRAL_ANGLE : CIE76;
         i < (of->sight.has_white ? PIXEL_MEASURES : CIE76); i++) {
        const struct pixel_difference *found = &of->pixels[i];
        print(to, "%-17s %.6g (mean), %.6g (95th percentile), %.6g (largest, at pixel %s)\n",
              names[i], found->mean, found->quantile_95, found->peak.largest,
              name_of_pixel(&found->peak, pixel));
    }
}

/* Prints the differences of pages that mean the same, or why there are none. */
static void print_pages(const struct comparison *of, struct printed *to)
{
    const struct image *a = &of->a.cube.image, *b = &of->b.cube.image;
    const char *word = page_word(&of->a.cube), *unit = word ? "" : of->a.cube.unit,
               *blank = word ? "" : " ", *other = page_word(&of->b.cube);
    const struct band_difference *all = &of->all;
    char pixel[32];
    print(to, "stacks            %d x %d pixels, %" PRIu64 " not black in both; %d %ss\n", a->width,
          a->height, of->n_pixels, a->n_pages, word ? word : "wavelength");
    if (!of->alike && !of->other_detector)
        print(to, "                  and %d other %ss: colours are compared, nothing else\n",
              b->n_pages, other ? other : "wavelength");
    if (!of->alike)
        return;
    print(to, "largest           %.6g%s%s at %s%s%.10g%s, at pixel %s\n", all->peak.largest, blank,
          unit, word ? word : "", word ? " " : "", a->wavelengths_nm[of->largest_band],
          word ? "" : " nm", name_of_pixel(&all->peak, pixel));
    print(to, "RMS               %.6g%s%s\n", all->rms, blank, unit);
    print(to, "largest of A      %.6g%s%s\n", of->largest_radiance, blank, unit);
}

/* Prints whether the stacks differ by more than the tolerance, which is given as the user wrote it,
 * and then by how much. */
static void print_comparison(const struct comparison *of, const char *tolerance, struct printed *to)
{
    if (of->all.peak.largest > 0 || of->pixels[CIEDE2000].peak.largest > 0)
        print(to, "result            the stacks differ, %s the tolerance of %s\n",
              comparison_is_within(of) ? "within" : "by more than", tolerance);
    else
        print_fact(to, "result", of->alike ? "the stacks are equal" : "the colours are equal");
    print_pages(of, to);
    print_pixels(of, to);
    if (of->sight.has_white) {
        if (of->options->matrix && !of->other_detector)
            print_detector(to, &of->sight, of->options->matrix);
        else
            print_fact(to, "observer", options_detector(of->options));
        if (of->other_detector)
            print_detector(to, &of->other, of->options->matrix);
        print_white(to, of->sight.white, true,
                    of->options->white ? of->options->white : "recorded by the first stack");
    } else
        print_fact(to, "colour",
                   of->a.cube.raw ? "none: raw values have none"
                                  : "none: there is no white; --white SPECTRUM gives one");
    if (of->map)
        print_fact(to, "map", of->map);
    if (of->coloured) {
        print_text(to, "map colours       ");
        comparison_print_colours(of, to);
        print_text(to, "\n");
    }
}

/* ---- as JSON ---- */

static void json_peak(struct json *json, const struct peak *peak)
{
    json_number(json, "largest", peak->largest);
    json_count(json, "x", (uint64_t)peak->x);
    json_count(json, "y", (uint64_t)peak->y);
}

static void json_band(struct json *json, const struct band_difference *band)
{
    json_peak(json, &band->peak);
    json_number(json, "rms", band->rms);
}

static void json_pixels(struct json *json, const char *name, const struct pixel_difference *found)
{
    json_open(json, name, '{');
    json_number(json, "mean", found->mean);
    json_number(json, "quantile_95", found->quantile_95);
    json_peak(json, &found->peak);
    json_close(json, '}');
}

static bool write_json(struct options *options, const struct comparison *of, struct error *err)
{
    static const char *const measures[] = {NULL, "angle_deg", "dE76", "dE94", "dE00"};
    static const struct band_difference unknown = {.peak = {.largest = (double)NAN},
                                                   .rms = (double)NAN};
    const struct image *image = &of->a.cube.image;
    struct json json;
    json_begin(&json);
    json_truth(&json, "within_tolerance", comparison_is_within(of));
    json_count(&json, "width", (uint64_t)image->width);
    json_count(&json, "height", (uint64_t)image->height);
    json_count(&json, "pixels_not_black", of->n_pixels);
    json_truth(&json, "colours_alone", !of->alike);
    json_numbers(&json, "wavelengths_nm",
                 page_word(&of->a.cube) || !of->alike ? NULL : image->wavelengths_nm,
                 image->n_pages);
    json_band(&json, of->alike ? &of->all : &unknown);
    json_number(&json, "largest_of_A", of->largest_radiance);
    json_string(&json, "observer", of->sight.has_white ? options_detector(options) : NULL);
    json_string(&json, "other", of->other_detector);
    json_string(&json, "matrix", options->matrix);
    for (int i = of->alike ? SPECTRAL_ANGLE : CIE76;
         i < (of->sight.has_white ? PIXEL_MEASURES : CIE76); i++)
        json_pixels(&json, measures[i], &of->pixels[i]);
    json_open(&json, "bands", '[');
    for (int i = 0; of->alike && i < image->n_pages; i++) {
        json_open(&json, NULL, '{');
        json_band(&json, &of->bands[i]);
        json_close(&json, '}');
    }
    json_close(&json, ']');
    return json_write(&json, options->json, &options->outputs, err);
}

/* ---- the command ---- */

static bool compare_pixels(struct comparison *of, const char *tolerance, struct error *err)
{
    struct options *options = of->options;
    struct printed printed = {.text = NULL};
    if ((of->map && !picture_accepts(of->map, err)) || !compare(of, err) ||
        (options->json && !write_json(options, of, err)))
        return false;
    if (!options->quiet) {
        print_comparison(of, tolerance, &printed);
        if (options->verbose && of->alike)
            print_bands(of, &printed);
    }
    return printed_show(&printed, options_table(options, of->map), err);
}

static bool compare_objects(struct comparison *of, struct error *err)
{
    struct options *options = of->options;
    const struct pixel_difference *all = &of->pixels[CIEDE2000];
    struct printed printed = {.text = NULL};
    struct json json;
    if (of->map)
        return error_usage(err, "--objects takes no --map, which shows pixels");
    if (of->tolerance.measure == RADIANCE && of->tolerance.value == 0)
        of->tolerance.measure = CIEDE2000;
    if (of->tolerance.measure != CIEDE2000)
        return error_usage(err, "--objects compares colours; expected --tolerance as 0.5dE00");
    json_begin(&json);
    bool done = objects_compare(of, &json, &printed, err);
    print(&printed,
          "CIEDE2000         %.6g (mean), %.6g (95th percentile), %.6g (largest) of %" PRIu64
          " objects\n",
          all->mean, all->quantile_95, all->peak.largest, of->n_pixels);
    json_pixels(&json, "dE00", all);
    json_truth(&json, "within_tolerance", comparison_is_within(of));
    json_string(&json, "other", of->other_detector);
    json_string(&json, "matrix", options->matrix);
    done = done && (!options->json || json_write(&json, options->json, &options->outputs, err)) &&
           (options->quiet || printed_show(&printed, options_table(options, NULL), err));
    FREE_ALL(json.printed.text, printed.text);
    return done;
}

static bool run_compare(struct options *options, struct error *err)
{
    const struct compare_own *own = options->own;
    const char *a = options->operands[0], *b = options->operands[1];
    const char *tolerance = own->tolerance ? own->tolerance : "0";
    struct comparison comparison = {
        .options = options, .map = own->map, .other_detector = own->other};
    if (options->n_operands != 2)
        return options_misused(options->command, "a stack is missing behind", a, err);
    const bool done = read_tolerance(tolerance, &comparison.tolerance, err) &&
                      scene_refuse(a, err) && scene_refuse(b, err) &&
                      (own->objects ? compare_objects(&comparison, err)
                                    : compare_pixels(&comparison, tolerance, err)) &&
                      (comparison_is_within(&comparison) ||
                       error_different(err, "%s and %s differ by more than the tolerance", a, b));
    comparison_free(&comparison);
    return done;
}

static const struct option compare_rows[] = {
    {"--tolerance R|P%|EdE00",
     "largest that passes: radiance, % of the largest, or CIEDE2000 (dE94, dE76); default: 0",
     OWN(TEXT, compare_own, tolerance)},
    {"--map FILE",
     "writes each pixel's largest difference, spectral angle and CIEDE2000 (.tif, .png)",
     OWN(TEXT, compare_own, map), .writes = true},
    {"--other NAME", "this detector sees the second stack, with --matrix; colours are compared",
     OWN(TEXT, compare_own, other)},
    {"--objects", "compares the mean colours of each object alone, and prints a line for each",
     OWN(FLAG, compare_own, objects)},
    {"-v, --verbose", "prints the differences of each wavelength, too", SHARED(FLAG, verbose)},
};
const struct command compare_command = {
    .name = "compare",
    .operands = "STACK STACK",
    .summary = "print where and by how much two stacks differ",
    .example = "compare a.tif b.tif --tolerance 0.5dE00 --map difference.png",
    .run = run_compare,
    .rows = OPTION_LIST(compare_rows),
    .shared = {&seeing_options, &threads_option, &json_option, &quiet_option},
    .own_size = sizeof(struct compare_own),
    .n_operands = 2,
};
