/* SPDX-License-Identifier: MIT */
/* Develops a spectral stack: three weights a page make pixels of pages. A stack is read in chunks
 * of rows, page after page. Each pixel is summed in the order of the pages, so that chunks do not
 * change its bits. */
#include <float.h>

#include "raster/beside/see/inside.h"

enum { CHUNK_BYTES = 28 << 21 }; /* at most, or one row */

/* ---- sums of weighted pages ---- */

static bool make_room(struct development *of, struct error *err)
{
    const struct image *image = &of->cube.image;
    const size_t n = (size_t)of->sight.n, pixel = sizeof(float) + n * sizeof(double);
    const int rows = (int)(CHUNK_BYTES / pixel / (size_t)image->width);
    of->most = rows < 1 ? 1 : rows < image->height ? rows : image->height;
    of->stride = (size_t)of->most * (size_t)image->width;
    return (of->lit || MAKE_ARRAY(of->radiance, of->stride, err, "rows of %s", image->path)) &&
           MAKE_ARRAY(of->sums, n * of->stride, err, "rows of the picture") &&
           (memory_make(&of->samples, n * of->stride, (size_t)of->bits / 8) ||
            memory_lacks(err, (double)(n * of->stride) * of->bits / 8, "rows of the picture"));
}

/* Adds a band of some rows. */
static void add_band(void *context, const struct drawn_band *drawn)
{
    const struct development *of = context;
    const struct rectangle *at = &drawn->pixels;
    const int n_pages = of->cube.image.n_pages, width = of->cube.image.width;
    const float *radiance = drawn->radiance;
    for (int y = 0; y < at->height; y++, radiance += at->width)
        for (int channel = 0; channel < of->sight.n; channel++) {
            const double weight = of->sight.weights[channel * n_pages + drawn->band];
            double *restrict sums = of->sums + (size_t)channel * of->stride +
                                    (size_t)(at->y + y - of->first) * (size_t)width + at->x;
            for (int x = 0; x < at->width; x++)
                sums[x] += weight * (double)radiance[x];
        }
}

/* Finds the channels of the rows from y on, of a chunk at most. */
static bool sum_rows(struct development *of, int y, struct error *err)
{
    struct image *image = &of->cube.image;
    const struct rectangle at = {0, y, image->width,
                                 of->most < image->height - y ? of->most : image->height - y};
    struct radiances scene = {threads_count(of->options->threads), add_band, of};
    memset(of->sums, 0, (size_t)of->sight.n * of->stride * sizeof *of->sums);
    of->first = y;
    of->n = (size_t)at.width * (size_t)at.height;
    if (of->lit)
        return radiances_each(of->lit, &at, &scene, err);
    for (int page = 0; page < image->n_pages; page++) {
        const struct drawn_band band = {NULL, at, page, of->radiance};
        if (!image_read(image, page, y, at.height, of->radiance, err))
            return false;
        add_band(of, &band);
    }
    return true;
}

/* ---- exposure ---- */

/* Returns to what an automatic exposure brings the largest value of a channel: the largest that is
 * displayed, a Y of 100, or a raw value of 1. X and Z do not count. */
static double largest_wanted(const struct development *of, int channel)
{
    if (of->values == DEVELOP_RGB)
        return display_largest(&of->display, channel);
    return of->values == DEVELOP_RAW ? 1 : channel == 1 ? 100 : HUGE_VAL;
}

/* Finds the exposure, and the full scale of raw counts, if they follow from the pixels. A black
 * picture has exposure 1. */
static bool find_exposure(struct development *of, struct error *err)
{
    const bool counts = of->values == DEVELOP_RAW && of->bits == 16;
    double brightest = 0; /* in parts of the largest */
    if (!of->automatic && !counts)
        return true;
    for (int y = 0; y < of->cube.image.height; y += of->most) {
        if (!sum_rows(of, y, err))
            return false;
        for (int channel = 0; channel < of->sight.n; channel++) {
            const double *sums = of->sums + (size_t)channel * of->stride;
            double largest = 0;
            for (size_t i = 0; i < of->n; i++)
                largest = sums[i] > largest ? sums[i] : largest;
            brightest = fmax(brightest, largest / largest_wanted(of, channel));
        }
    }
    if (of->automatic)
        of->exposure = brightest > 1 / DBL_MAX ? 1 / brightest : 1;
    if (counts && brightest > 0)
        of->full_scale = of->exposure * brightest;
    return true;
}

/* ---- pixels ---- */

/* Stores a pixel on pages, as floats or as counts of the full scale. A value beyond the largest, or
 * below the least, becomes that. Returns how many values are below 0. */
static uint64_t store_channels(const struct development *of, size_t pixel, const double *values)
{
    uint64_t below_0 = 0;
    for (size_t channel = 0; channel < (size_t)of->sight.n; channel++) {
        const double value = values[channel], count = floor(65535 * value / of->full_scale + 0.5);
        const size_t at = channel * of->n + pixel;
        below_0 += value < 0;
        if (of->bits == 32)
            ((float *)of->samples)[at] =
                (float)fmax(-(double)FLT_MAX, fmin(value, (double)FLT_MAX));
        else
            ((uint16_t *)of->samples)[at] = (uint16_t)fmax(0, fmin(count, 65535));
    }
    return below_0;
}

static void store_row(void *context, int row)
{
    struct development *of = context;
    const size_t n_channels = (size_t)of->sight.n, width = (size_t)of->cube.image.width,
                 first = (size_t)row * width;
    uint64_t clipped = 0;
    for (size_t i = first; i < first + width; i++) {
        double values[MOST_CHANNELS];
        for (size_t channel = 0; channel < n_channels; channel++)
            values[channel] = of->exposure * of->sums[channel * of->stride + i];
        if (of->values == DEVELOP_LAB)
            cielab(values, of->adapted_white, values);
        if (of->values == DEVELOP_RGB)
            clipped += display_store(&of->display, of->bits, values,
                                     (char *)of->samples + 3 * i * (size_t)of->bits / 8);
        else
            clipped += store_channels(of, i, values);
    }
    counter_add(&of->clipped, clipped);
}

/* ---- the picture ---- */

void print_white(struct printed *to, const double white[3], bool is_xyz, const char *source)
{
    double xy[2];
    chromaticity(white, xy);
    print(to, "white             %s%.6g %.6g %.6g", is_xyz ? "XYZ " : "", white[0], white[1],
          white[2]);
    if (is_xyz)
        print(to, ", xy %.5f %.5f", xy[0], xy[1]);
    print(to, " (%s)\n", source);
}

void print_detector(struct printed *to, const struct sight *sight, const char *matrix)
{
    print(to, "detector          %s (", sight->detector.name);
    if (matrix)
        print(to, "%d channels, to XYZ by %s)\n", sight->detector.n, matrix);
    else
        print(to, "%s)\n", sight->observes ? "observer" : "camera or film, balanced to the white");
}

void develop_print_settings(const struct development *of, struct printed *to)
{
    static const char *const values[] = {
        [DEVELOP_RGB] = "RGB", [DEVELOP_XYZ] = "XYZ", [DEVELOP_LAB] = "CIELAB"};
    const struct record *record = &of->cube.record;
    print_detector(to, &of->sight, of->options->matrix);
    if (!of->sight.observes && !of->sight.detector.named)
        print(to, "channels          %s, %s, %s as red, green, blue\n",
              of->sight.detector.channel[0], of->sight.detector.channel[1],
              of->sight.detector.channel[2]);
    if (record->sampling) {
        print_text(to, "sampling          ");
        print_printable(to, record->sampling);
        print_text(to, " for ");
        print_printable(to, record->sampling_detector);
        print_text(to, " (recorded)\n");
    }
    if (of->sight.has_white)
        print_white(to, of->sight.white, of->sight.observes,
                    of->options->white ? of->options->white : "recorded");
    else
        print_fact(to, "white", "not recorded");
    print(to, "adaptation        %s", adaptation_names[of->adaptation.kind]);
    if (of->adaptation.kind == ADAPTATION_FAIRCHILD)
        print(to, " to %.6g cd/m2", of->adaptation.luminance);
    print(to, "\nvalues            %s%s", values[of->values],
          record->unit && of->values == DEVELOP_XYZ ? ", Y in cd/m2" : "");
    if (of->values == DEVELOP_RGB)
        print(to, " of %d bits\ndisplay           %s", of->bits, of->display.name);
    print(to, "\nexposure          %.10g%s\n", of->exposure, of->automatic ? " (auto)" : "");
}

static bool open_picture(const struct development *of, struct picture_writer *out,
                         struct error *err)
{
    const bool lab = of->values == DEVELOP_LAB, rgb = of->values == DEVELOP_RGB;
    const struct display *display = &of->display;
    struct printed printed = {.text = NULL};
    print(&printed, "%-18s" PROGRAM "\n", of->lit ? "drawn by" : "developed by");
    print_fact(&printed, of->lit ? "scene" : "stack", of->cube.image.path);
    develop_print_settings(of, &printed);
    char *text = picture_text(printed_take(&printed, err));
    const struct picture_options options = {
        .width = of->cube.image.width,
        .height = of->cube.image.height,
        .bits = of->bits,
        .channels = {lab ? "L*" : "X", lab ? "a*" : "Y", lab ? "b*" : "Z"},
        .srgb = rgb && display->is_srgb,
        .profile = rgb ? display->profile : NULL,
        .profile_length = display->profile_length,
        .description = text,
        .memory = of->memory};
    const bool done = text && picture_open(out, of->options->output, &options, err);
    free(text);
    return done;
}

/* ---- the pages of raw values ---- */

const char *raw_unit(const struct development *of)
{
    return !of->cube.record.unit ? "W sr-1 m-2 (relative)"
           : of->sight.observes  ? "cd m-2"
                                 : "W sr-1 m-2";
}

static bool open_raw(const struct development *of, struct stack_writer *out, struct error *err)
{
    struct printed made = {.text = NULL}, channels = {.text = NULL};
    for (int i = 0; i < of->sight.n; i++)
        print(&channels, "%s\n", of->sight.detector.channel[i]);
    print(&made, "program: " PROGRAM "\nraw values of: ");
    print_printable(&made, of->cube.image.path);
    print_text(&made, "\ndetector: ");
    print_printable(&made, of->sight.detector.name);
    print(&made, "\nexposure: %.*g\nunit: %s\n", exact_digits(of->exposure), of->exposure,
          raw_unit(of));
    const struct stack_options options = {.width = of->cube.image.width,
                                          .height = of->cube.image.height,
                                          .n_wavelengths = of->sight.n,
                                          .unit = raw_unit(of),
                                          .full_scale = of->full_scale,
                                          .bits = of->bits,
                                          .scene = of->cube.image.path};
    return named_pages_open(out, of->options->output, options, &made, &channels, err);
}

/* Writes the rows at hand. */
static bool put_raw(const struct development *of, struct stack_writer *writer, struct error *err)
{
    const int width = of->cube.image.width;
    struct page_rectangle to = {0, 0, of->first, width, (int)of->n / width};
    const size_t page = of->n * (size_t)of->bits / 8;
    for (; to.page < of->sight.n; to.page++)
        if (!pages_write(&writer->pages, &to, (char *)of->samples + (size_t)to.page * page, err))
            return false;
    return true;
}

/* ---- the file ---- */

static bool write_picture(struct development *of, struct error *err)
{
    const bool is_raw = of->values == DEVELOP_RAW;
    const int width = of->cube.image.width;
    struct picture_writer picture;
    struct stack_writer raw;
    bool done = is_raw ? open_raw(of, &raw, err) : open_picture(of, &picture, err);
    if (!done)
        return false;
    for (int y = 0; done && y < of->cube.image.height; y += of->most) {
        done = sum_rows(of, y, err);
        threads_each(threads_count(of->options->threads), (int)of->n / width, store_row, of);
        done = done && (is_raw ? put_raw(of, &raw, err)
                               : picture_write(&picture, of->samples, (int)of->n / width, err));
    }
    if (is_raw)
        return named_pages_end(&raw, done, "raw values have no check of their own",
                               &of->options->outputs, err);
    done = done && picture_commit(&picture, &of->options->outputs, err);
    picture_discard(&picture);
    return done;
}

bool develop(struct development *of, struct error *err)
{
    const char *display = of->options->display;
    of->exposure = exposure_factor(of->options, of->lit ? "auto" : "1");
    of->automatic = of->exposure == 0;
    of->clipped = (struct counter)COUNTER;
    of->full_scale = 1;
    return display_read(display ? display : "srgb", &of->display, err) &&
           (of->lit || cube_open(of->options->operand, &of->cube, err)) &&
           develop_weights(of, err) && make_room(of, err) && find_exposure(of, err) &&
           write_picture(of, err);
}

bool scene_cube(const struct scene *scene, struct cube *out, struct error *err)
{
    const struct spectral_pages pages = scene_pages(scene);
    struct numbers *white = &out->record.white;
    *out = (struct cube){.record.unit = scene_is_absolute(scene) ? ABSOLUTE_UNIT : NULL,
                         .image = {.path = scene->path,
                                   .width = scene->width,
                                   .height = scene->height,
                                   .n_pages = scene->n_wavelengths,
                                   .wavelengths_nm = scene->wavelengths_nm}};
    if (!MAKE_ARRAY(white->value, pages.n, err, "the white of a picture"))
        return false;
    white->n = scene_white(scene, &pages, white->value) > 0 ? pages.n : 0;
    return true;
}

bool develop_scene(const struct lit_scene *lit, struct options *options, struct printed *memory,
                   double *exposure, uint64_t *out_of_gamut, struct error *err)
{
    struct development of = {.options = options, .bits = 8, .memory = memory, .lit = lit};
    const bool done = scene_cube(lit->plan->scene, &of.cube, err) && develop(&of, err);
    *exposure = of.exposure;
    *out_of_gamut = of.clipped.n;
    free(of.cube.record.white.value);
    of.cube = (struct cube){.components = false}; /* the scene owns the rest */
    develop_free(&of);
    return done;
}

void develop_free(struct development *of)
{
    cube_close(&of->cube);
    sight_free(&of->sight);
    FREE_ALL(of->radiance, of->sums, of->samples);
}
