/* SPDX-License-Identifier: MIT */
/* Raw values of a detector of any number of channels: one page a channel, linear, without balance,
 * adaptation or display. The value of a channel is the sum over pages of radiance x sensitivity x
 * width of the page in nm (detector_weights), times the exposure. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "raster/beside/see/inside.h"

/* Returns the unit of the values. */
static const char *unit_of(const struct raw *of)
{
    return !of->cube.record.unit   ? "W sr-1 m-2 (relative)"
           : of->detector.observer ? "cd m-2"
                                   : "W sr-1 m-2";
}

/* Stores a channel's n pixels as floats, or as counts of the full scale: none is below 0. */
static void store(struct raw *of, const double *sums, size_t n, void *samples)
{
    for (size_t i = 0; i < n; i++) {
        const double value = of->exposure * sums[i], count = 65535 * value / of->full_scale;
        of->below_0 += value < 0;
        if (of->options->bits == 32)
            ((float *)samples)[i] = (float)fmax(-(double)FLT_MAX, fmin(value, (double)FLT_MAX));
        else
            ((uint16_t *)samples)[i] = (uint16_t)fmax(0, fmin(floor(count + 0.5), 65535));
    }
}

/* Goes over the rows in chunks. Without a writer it only finds the largest value. */
static bool each_chunk(struct raw *of, struct stack_writer *writer, struct error *err)
{
    const struct image *image = &of->cube.image;
    struct channel_sums sums = {.cube = &of->cube,
                                .weights = of->weights,
                                .n_channels = of->detector.n,
                                .threads = of->options->threads};
    float *samples = NULL; /* of a channel: floats or counts */
    bool done =
        sums_allocate(&sums, err) && MAKE_ARRAY(samples, sums.stride, err, "rows of the picture");
    of->below_0 = 0;
    for (int y = 0; done && y < image->height; y += sums.most) {
        done = sums_find(&sums, y, err);
        for (int channel = 0; done && channel < of->detector.n; channel++) {
            const struct page_rectangle to = {channel, 0, y, image->width,
                                              (int)(sums.n / (size_t)image->width)};
            of->largest = fmax(of->largest, sums_largest(&sums, channel));
            if (!writer)
                continue;
            store(of, sums.sums + (size_t)channel * sums.stride, sums.n, samples);
            done = pages_write(&writer->pages, &to, samples, err);
        }
    }
    sums_free(&sums);
    free(samples);
    return done;
}

/* ---- the file ---- */

static char *provenance(const struct raw *of, const char *stack, struct error *err)
{
    struct printed to = {.text = NULL};
    print(&to, "program: " PROGRAM "\nraw values of: ");
    print_printable(&to, stack);
    print_text(&to, "\ndetector: ");
    print_printable(&to, of->detector.name);
    print(&to, "\nexposure: %.*g\nunit: %s\n", exact_digits(of->exposure), of->exposure,
          unit_of(of));
    return printed_take(&to, err);
}

static bool write_pages(struct raw *of, const char *stack, const char *output, struct error *err)
{
    char *text = provenance(of, stack, err);
    const struct stack_options options = {.width = of->cube.image.width,
                                          .height = of->cube.image.height,
                                          .n_wavelengths = of->detector.n,
                                          .names = (const char *const *)of->detector.channel,
                                          .unit = unit_of(of),
                                          .full_scale = of->full_scale,
                                          .bits = of->options->bits,
                                          .scene = stack,
                                          .provenance = text};
    struct stack_writer writer;
    bool done = text && stack_open(&writer, output, &options, err);
    free(text);
    if (!done)
        return false;
    done = each_chunk(of, &writer, err) &&
           stack_finish(&writer, "raw values have no check of their own", err) &&
           output_pass(&writer.pages.output, of->options->outputs, err);
    stack_discard(&writer);
    return done;
}

/* ---- the weights ---- */

/* Finds the weights of any detector. */
static bool raw_weights(const struct cube *cube, const char *name, struct detector *detector,
                        double **weights, struct error *err)
{
    const struct image *image = &cube->image;
    if (cube->record.response.n > 0)
        return error_usage(err,
                           "%s was sampled by %s for %s alone, and has no raw values; riemann, "
                           "gauss:N, gauss:N,open, box and adaptive have",
                           image->path, cube->record.sampling, cube->record.sampling_detector);
    if (!channels_read(name, detector, err) ||
        !MAKE_ARRAY(*weights, (size_t)detector->n * (size_t)image->n_pages, err,
                    "the weights of %s", image->path))
        return false;
    if (!cube_weights(cube, detector, *weights, err))
        return false;
    const double luminance = cube_luminance(cube, detector);
    for (int i = 0; i < detector->n * image->n_pages; i++)
        (*weights)[i] *= luminance;
    return true;
}

bool camera_open(const struct cube *cube, const char *name, struct camera_channels *out,
                 struct error *err)
{
    if (!channels_read(name, &out->detector, err))
        return false;
    const bool observer = out->detector.observer;
    detector_free(&out->detector);
    return observer || raw_weights(cube, name, &out->detector, &out->weights, err);
}

void camera_add(const struct camera_channels *camera, double *spectrum, int n)
{
    for (int i = 0; i < camera->detector.n; i++) {
        spectrum[n + i] = 0;
        for (int page = 0; page < n; page++)
            spectrum[n + i] += camera->weights[i * n + page] * spectrum[page];
    }
}

void camera_close(struct camera_channels *camera)
{
    detector_free(&camera->detector);
    free(camera->weights);
}

/* Finds what is lost. Refuses a detector that sees nothing of the stack. */
static bool check_sight(struct raw *of, struct error *err)
{
    const struct image *image = &of->cube.image;
    bool sees = false;
    if (!MAKE_ARRAY(of->lost, of->detector.n, err, "the weights of %s", image->path))
        return false;
    cube_lost(&of->cube, &of->detector, of->lost);
    for (int i = 0; i < of->detector.n * image->n_pages; i++)
        sees = sees || of->weights[i] != 0;
    return sees || error_usage(err, "%s: %s sees nothing of its wavelengths", image->path,
                               of->detector.name);
}

bool develop_raw(struct raw *of, const char *stack, const char *output, struct error *err)
{
    const struct development_options *options = of->options;
    of->exposure = options->exposure;
    of->full_scale = 1;
    if (!cube_open(stack, &of->cube, err) || !cube_needs_radiance(&of->cube, "--raw", err) ||
        !raw_weights(&of->cube, options->detector_name, &of->detector, &of->weights, err) ||
        !check_sight(of, err))
        return false;
    if ((options->automatic || options->bits == 16) && !each_chunk(of, NULL, err))
        return false;
    if (options->automatic)
        of->exposure = of->largest > 0 ? 1 / of->largest : 1;
    if (options->bits == 16 && of->largest > 0)
        of->full_scale = of->exposure * of->largest;
    return write_pages(of, stack, output, err);
}

void raw_print(const struct raw *of, const char *output, struct printed *to)
{
    print(to, "detector          %s (%d channel%s)\n", of->detector.name, of->detector.n,
          of->detector.n == 1 ? "" : "s");
    print(to, "values            raw, %s, %s\n",
          of->options->bits == 32 ? "float" : "16-bit counts", unit_of(of));
    if (of->options->bits == 16)
        print(to, "full scale        %.10g\n", of->full_scale);
    print(to, "exposure          %.10g%s\n", of->exposure, of->options->automatic ? " (auto)" : "");
    for (int i = 0; i < of->detector.n; i++)
        print(to, "channel %-9d %s: %.4g %% of its sensitivity lies outside\n", i + 1,
              of->detector.channel[i], 100 * of->lost[i]);
    if (of->below_0 > 0)
        print(to, "below 0           %llu values%s\n", (unsigned long long)of->below_0,
              of->options->bits == 32 ? "" : ", which become 0");
    print_fact(to, "picture", output);
}

void raw_free(struct raw *of)
{
    cube_close(&of->cube);
    detector_free(&of->detector);
    FREE_ALL(of->weights, of->lost);
}
