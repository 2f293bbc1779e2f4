/* SPDX-License-Identifier: MIT */
/* Raw values of a detector of any number of channels: one page a channel, linear, without balance,
 * adaptation or display. The value of a channel is the sum over pages of radiance x sensitivity x
 * width of the page in nm (detector_weights), times the exposure. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "raster/beside/see/inside.h"

struct raw {
    const struct development_options *options;
    double exposure; /* of the options, or found */
    struct cube cube;
    struct camera_channels camera; /* also the XYZ of an observer */
    double *lost;                  /* cube_lost; owned */
    double largest;                /* at exposure 1; found if the exposure or the counts need it */
    double full_scale;             /* of counts: the largest value with the exposure */
    uint64_t below_0;              /* values */
};

/* Returns the unit of the values. */
static const char *unit_of(const struct raw *of)
{
    return !of->cube.record.unit          ? "W sr-1 m-2 (relative)"
           : of->camera.detector.observer ? "cd m-2"
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
                                .weights = of->camera.weights,
                                .n_channels = of->camera.detector.n,
                                .threads = of->options->threads};
    float *samples = NULL; /* of a channel: floats or counts */
    bool done =
        sums_allocate(&sums, err) && MAKE_ARRAY(samples, sums.stride, err, "rows of the picture");
    of->below_0 = 0;
    for (int y = 0; done && y < image->height; y += sums.most) {
        done = sums_find(&sums, y, err);
        for (int channel = 0; done && channel < of->camera.detector.n; channel++) {
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
    print_printable(&to, of->camera.detector.name);
    print(&to, "\nexposure: %.*g\nunit: %s\n", exact_digits(of->exposure), of->exposure,
          unit_of(of));
    return printed_take(&to, err);
}

static bool write_pages(struct raw *of, const char *stack, const char *output, struct error *err)
{
    char *text = provenance(of, stack, err);
    const struct stack_options options = {.width = of->cube.image.width,
                                          .height = of->cube.image.height,
                                          .n_wavelengths = of->camera.detector.n,
                                          .names = (const char *const *)of->camera.detector.channel,
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
static bool raw_weights(const struct cube *cube, const char *name, struct camera_channels *out,
                        struct error *err)
{
    const struct image *image = &cube->image;
    struct detector *detector = &out->detector;
    if (cube->record.response.n > 0)
        return error_usage(err,
                           "%s was sampled by %s for %s alone, and has no raw values; riemann, "
                           "gauss:N, gauss:N,open, box and adaptive have",
                           image->path, cube->record.sampling, cube->record.sampling_detector);
    if (!channels_read(name, detector, err) ||
        !MAKE_ARRAY(out->weights, (size_t)detector->n * (size_t)image->n_pages, err,
                    "the weights of %s", image->path))
        return false;
    if (!cube_weights(cube, detector, out->weights, err))
        return false;
    const double luminance = cube_luminance(cube, detector);
    for (int i = 0; i < detector->n * image->n_pages; i++)
        out->weights[i] *= luminance;
    return true;
}

bool camera_open(const struct cube *cube, const char *name, struct camera_channels *out,
                 struct error *err)
{
    if (!channels_read(name, &out->detector, err))
        return false;
    const bool observer = out->detector.observer;
    detector_free(&out->detector);
    return observer || raw_weights(cube, name, out, err);
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
    if (!MAKE_ARRAY(of->lost, of->camera.detector.n, err, "the weights of %s", image->path))
        return false;
    cube_lost(&of->cube, &of->camera.detector, of->lost);
    for (int i = 0; i < of->camera.detector.n * image->n_pages; i++)
        sees = sees || of->camera.weights[i] != 0;
    return sees || error_usage(err, "%s: %s sees nothing of its wavelengths", image->path,
                               of->camera.detector.name);
}

static bool write_raw(struct raw *of, const char *stack, const char *output, struct error *err)
{
    const struct development_options *options = of->options;
    if (!cube_open(stack, &of->cube, err) || !cube_needs_radiance(&of->cube, "--raw", err) ||
        !raw_weights(&of->cube, options->detector_name, &of->camera, err) || !check_sight(of, err))
        return false;
    if ((options->automatic || options->bits == 16) && !each_chunk(of, NULL, err))
        return false;
    if (options->automatic)
        of->exposure = of->largest > 0 ? 1 / of->largest : 1;
    if (options->bits == 16 && of->largest > 0)
        of->full_scale = of->exposure * of->largest;
    return write_pages(of, stack, output, err);
}

static void print_raw(const struct raw *of, const char *output, struct printed *to)
{
    print(to, "detector          %s (%d channel%s)\n", of->camera.detector.name,
          of->camera.detector.n, of->camera.detector.n == 1 ? "" : "s");
    print(to, "values            raw, %s, %s\n",
          of->options->bits == 32 ? "float" : "16-bit counts", unit_of(of));
    if (of->options->bits == 16)
        print(to, "full scale        %.10g\n", of->full_scale);
    print(to, "exposure          %.10g%s\n", of->exposure, of->options->automatic ? " (auto)" : "");
    for (int i = 0; i < of->camera.detector.n; i++)
        print(to, "channel %-9d %s: %.4g %% of its sensitivity lies outside\n", i + 1,
              of->camera.detector.channel[i], 100 * of->lost[i]);
    if (of->below_0 > 0)
        print(to, "below 0           %llu values%s\n", (unsigned long long)of->below_0,
              of->options->bits == 32 ? "" : ", which become 0");
    print_fact(to, "picture", output);
}

bool develop_raw(const struct development_options *settings, struct options *options,
                 struct error *err)
{
    struct raw of = {.options = settings, .exposure = settings->exposure, .full_scale = 1};
    struct printed printed = {.text = NULL};
    const bool done = scene_refuse(options->operand, err) &&
                      write_raw(&of, options->operand, options->output, err);
    if (done && !options->quiet)
        print_raw(&of, options->output, &printed);
    cube_close(&of.cube);
    camera_close(&of.camera);
    free(of.lost);
    return printed_show(&printed, options_table(options, options->output), err) && done;
}
