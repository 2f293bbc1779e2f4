/* SPDX-License-Identifier: MIT */
/* Develops a spectral stack: three weights a page make pixels of pages. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "raster/beside/see/inside.h"

enum { BLOCK_PIXELS = 1 << 13 }; /* that a thread takes at a time */

static size_t sample_bytes(const struct development *of)
{
    return of->options->values != DEVELOP_RGB ? sizeof(float) : (size_t)of->options->bits / 8;
}

/* ---- exposure ---- */

/* Finds the exposure that brings the brightest channel of all pixels (or Y) to the largest that is
 * displayed (or 100). A black picture has exposure 1. */
static bool find_exposure(struct development *of, struct error *err)
{
    const bool rgb = of->options->values == DEVELOP_RGB;
    double brightest = 0; /* in parts of the largest */
    for (int y = 0; y < of->cube.image.height; y += of->sums.most) {
        if (!sums_find(&of->sums, y, err))
            return false;
        for (int channel = rgb ? 0 : 1; channel < (rgb ? 3 : 2); channel++)
            brightest =
                fmax(brightest, sums_largest(&of->sums, channel) /
                                    (rgb ? display_largest(of->options->display, channel) : 100));
    }
    of->exposure = brightest > 1 / DBL_MAX ? 1 / brightest : 1;
    return true;
}

/* ---- pixels ---- */

/* A value beyond the largest float becomes that float. */
static float stored(double value)
{
    return (float)fmax(-(double)FLT_MAX, fmin(value, (double)FLT_MAX));
}

static void store_floats(const struct development *of, size_t pixel, const double values[3])
{
    float *samples = of->samples;
    double lab[3];
    if (of->options->values == DEVELOP_LAB)
        cielab(values, of->adapted_white, lab);
    for (int channel = 0; channel < 3; channel++)
        samples[(size_t)channel * of->sums.n + pixel] =
            stored(of->options->values == DEVELOP_LAB ? lab[channel] : values[channel]);
}

static void store_pixels(void *context, size_t first, size_t end)
{
    struct development *of = context;
    const double exposure = of->exposure;
    const bool rgb = of->options->values == DEVELOP_RGB;
    uint64_t clipped = 0;
    for (size_t i = first; i < end; i++) {
        double values[3];
        for (size_t channel = 0; channel < 3; channel++)
            values[channel] = exposure * of->sums.sums[channel * of->sums.stride + i];
        if (rgb)
            clipped += display_store(of->options->display, of->options->bits, values,
                                     (char *)of->samples + 3 * i * sample_bytes(of));
        else
            store_floats(of, i, values);
    }
    counter_add(&of->out_of_gamut, clipped);
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

void develop_print_settings(const struct development *of, struct printed *to)
{
    static const char *const values[] = {
        [DEVELOP_RGB] = "RGB", [DEVELOP_XYZ] = "XYZ", [DEVELOP_LAB] = "CIELAB"};
    const struct record *record = &of->cube.record;
    print(to, "detector          %s (%s)\n", of->options->detector_name,
          of->detector.observer ? "observer" : "camera or film, balanced to the white");
    if (!of->detector.named)
        print(to, "channels          %s, %s, %s as red, green, blue\n", of->detector.channel[0],
              of->detector.channel[1], of->detector.channel[2]);
    if (record->sampling) {
        print_text(to, "sampling          ");
        print_printable(to, record->sampling);
        print_text(to, " for ");
        print_printable(to, record->sampling_detector);
        print_text(to, " (recorded)\n");
    }
    if (of->has_white)
        print_white(to, of->seen_white, of->detector.observer,
                    of->options->white ? of->options->white : "recorded");
    else
        print_fact(to, "white", "not recorded");
    print(to, "adaptation        %s", adaptation_names[of->adaptation.kind]);
    if (of->adaptation.kind == ADAPTATION_FAIRCHILD)
        print(to, " to %.6g cd/m2", of->adaptation.luminance);
    print(to, "\nvalues            %s%s", values[of->options->values],
          record->unit && of->options->values == DEVELOP_XYZ ? ", Y in cd/m2" : "");
    if (of->options->values == DEVELOP_RGB)
        print(to, " of %d bits\ndisplay           %s", of->options->bits,
              display_names[of->options->display]);
    print(to, "\nexposure          %.10g%s\n", of->exposure,
          of->options->automatic ? " (auto)" : "");
}

static bool open_picture(const struct development *of, const char *path, struct picture_writer *out,
                         struct error *err)
{
    const bool lab = of->options->values == DEVELOP_LAB, rgb = of->options->values == DEVELOP_RGB;
    unsigned char profile[LARGEST_PROFILE];
    struct printed printed = {.text = NULL};
    if (of->options->lit)
        print(&printed,
              "drawn by          " PROGRAM "\nscene             %s\ndetector          %s\n"
              "adaptation        none\ndisplay           %s\nexposure          %.10g\n",
              of->cube.image.path, of->options->detector_name, display_names[of->options->display],
              of->exposure);
    else {
        print(&printed, "developed by      " PROGRAM "\nstack             %s\n",
              of->cube.image.path);
        develop_print_settings(of, &printed);
    }
    char *text = picture_text(printed_take(&printed, err));
    const struct picture_options options = {
        .width = of->cube.image.width,
        .height = of->cube.image.height,
        .bits = rgb ? of->options->bits : 32,
        .channels = {lab ? "L*" : "X", lab ? "a*" : "Y", lab ? "b*" : "Z"},
        .srgb = rgb && of->options->display == DISPLAY_SRGB,
        .profile = rgb ? profile : NULL,
        .profile_length = rgb ? profile_write(of->options->display, profile) : 0,
        .description = text,
        .memory = of->options->memory};
    const bool done = text && picture_open(out, path, &options, err);
    free(text);
    return done;
}

static bool write_picture(struct development *of, const char *path, struct error *err)
{
    const int width = of->cube.image.width, height = of->cube.image.height;
    struct picture_writer writer;
    bool done = open_picture(of, path, &writer, err);
    if (!done)
        return false;
    for (int y = 0; done && y < height; y += of->sums.most) {
        done = sums_find(&of->sums, y, err);
        threads_blocks(of->sums.threads, of->sums.n, BLOCK_PIXELS, store_pixels, of);
        done = done && picture_write(&writer, of->samples, (int)of->sums.n / width, err);
    }
    done = done && picture_commit(&writer, of->options->outputs, err);
    picture_discard(&writer);
    return done;
}

/* Writes the picture of the cube, which is open. */
static bool develop_cube(struct development *of, const char *path, struct error *err)
{
    struct channel_sums *sums = &of->sums;
    of->out_of_gamut = (struct counter)COUNTER;
    of->exposure = of->options->exposure;
    of->adaptation = of->options->adaptation;
    if (!develop_weights(of, err))
        return false;
    *sums = (struct channel_sums){.cube = &of->cube,
                                  .lit = of->options->lit,
                                  .weights = of->weights,
                                  .n_channels = 3,
                                  .threads = of->options->threads};
    return sums_allocate(sums, err) &&
           (memory_make(&of->samples, 3 * sums->stride, sample_bytes(of)) ||
            memory_lacks(err, 12 * (double)sums->stride, "rows of the picture")) &&
           (!of->options->automatic || find_exposure(of, err)) && write_picture(of, path, err);
}

bool develop(struct development *of, const char *stack, const char *output, struct error *err)
{
    return cube_open(stack, &of->cube, err) && develop_cube(of, output, err);
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

bool develop_scene(const struct lit_scene *lit, struct scene_picture *picture, struct error *err)
{
    const struct development_options options = {
        .detector_name = picture->detector ? picture->detector : "cie1931",
        .display = DISPLAY_SRGB,
        .bits = 8,
        .threads = lit->plan->options.threads,
        .exposure = 1,
        .automatic = picture->automatic,
        .outputs = picture->outputs,
        .memory = picture->memory,
        .lit = lit};
    struct development of = {.options = &options};
    const bool done =
        scene_cube(lit->plan->scene, &of.cube, err) && develop_cube(&of, picture->output, err);
    picture->out_of_gamut = of.out_of_gamut.n;
    free(of.cube.record.white.value);
    of.cube = (struct cube){.components = false}; /* the scene owns the rest */
    develop_free(&of);
    return done;
}

void develop_free(struct development *of)
{
    cube_close(&of->cube);
    detector_free(&of->detector);
    sums_free(&of->sums);
    FREE_ALL(of->weights, of->samples);
}
