/* SPDX-License-Identifier: MIT */
/* spectral develop: the colour picture of a stack. */
#include "raster/beside/see/inside.h"

/* ---- options ---- */

static bool accept_exposure(const char *option, const char *value, struct error *err)
{
    double ignored;
    return strcmp(value, "auto") == 0 || option_number(option, value, 1e-12, 1e12, &ignored, err);
}

static const struct option exposure_rows[] = {
    {"--exposure FACTOR|auto",
     "a factor, or auto: nothing is brighter than the display (default: 1; view: auto)",
     SHARED(TEXT, exposure), .accepts = accept_exposure},
};
const struct option_list exposure_option = OPTION_LIST(exposure_rows);

double exposure_factor(const struct options *options, const char *usual)
{
    const char *value = options->exposure ? options->exposure : usual;
    return strcmp(value, "auto") == 0 ? 0 : strtod(value, NULL);
}

struct develop_own {
    const char *adaptation, *bits;
    bool xyz, lab, raw;
};

static bool read_options(struct options *options, struct development *out, struct error *err)
{
    const struct develop_own *own = options->own;
    *out = (struct development){.options = options,
                                .values = own->raw   ? DEVELOP_RAW
                                          : own->xyz ? DEVELOP_XYZ
                                          : own->lab ? DEVELOP_LAB
                                                     : DEVELOP_RGB};
    out->bits = own->bits ? (int)strtol(own->bits, NULL, 10) : out->values == DEVELOP_RGB ? 8 : 32;
    if (own->xyz && own->lab)
        return error_usage(err, "--xyz and --lab exclude each other");
    return !own->adaptation ||
           adaptation_read("--adaptation", own->adaptation, &out->adaptation, err);
}

/* ---- in words, and as JSON ---- */

static void print_development(const struct development *of, const char *output, struct printed *to)
{
    const struct image *image = &of->cube.image;
    const double pixels = (double)image->width * image->height;
    develop_print_settings(of, to);
    print(to, "%s       %d, %s %.10g to %.10g nm\n",
          of->cube.components ? "components " : "wavelengths", image->n_pages,
          of->cube.components ? "of" : "from", of->first_nm, of->last_nm);
    for (int i = 0; i < of->sight.detector.n; i++)
        print(to, "%s%.4g %%", i == 0 ? "unseen            " : ", ", 100 * of->sight.lost[i]);
    print_text(to, " of the sensitivities lie outside\n");
    if (of->values == DEVELOP_RGB)
        print(to, "out of gamut      %llu of %.0f pixels (%.3f %%)\n",
              (unsigned long long)of->clipped.n, pixels, 100 * (double)of->clipped.n / pixels);
    print_fact(to, "picture", output);
}

static void print_raw(const struct development *of, const char *output, struct printed *to)
{
    const struct detector *detector = &of->sight.detector;
    print(to, "detector          %s (%d channel%s)\n", detector->name, detector->n,
          detector->n == 1 ? "" : "s");
    print(to, "values            raw, %s, %s\n", of->bits == 32 ? "float" : "16-bit counts",
          raw_unit(of));
    if (of->bits == 16)
        print(to, "full scale        %.10g\n", of->full_scale);
    print(to, "exposure          %.10g%s\n", of->exposure, of->automatic ? " (auto)" : "");
    for (int i = 0; i < detector->n; i++)
        print(to, "channel %-9d %s: %.4g %% of its sensitivity lies outside\n", i + 1,
              detector->channel[i], 100 * of->sight.lost[i]);
    if (of->clipped.n > 0)
        print(to, "below 0           %llu values%s\n", (unsigned long long)of->clipped.n,
              of->bits == 32 ? "" : ", which become 0");
    print_fact(to, "picture", output);
}

static bool write_json(struct options *options, const struct development *of, struct error *err)
{
    static const char *const values[] = {"RGB", "XYZ", "Lab"};
    struct json json;
    json_begin(&json);
    json_string(&json, "detector", options_detector(options));
    json_string(&json, "matrix", options->matrix);
    json_truth(&json, "observer", of->sight.observes);
    json_numbers(&json, "white", of->sight.has_white ? of->sight.white : NULL, 3);
    json_string(&json, "adaptation", adaptation_names[of->adaptation.kind]);
    json_string(&json, "values", values[of->values]);
    json_number(&json, "exposure", of->exposure);
    json_count(&json, "width", (uint64_t)of->cube.image.width);
    json_count(&json, "height", (uint64_t)of->cube.image.height);
    json_count(&json, "pages", (uint64_t)of->cube.image.n_pages);
    json_number(&json, "first_nm", of->first_nm);
    json_number(&json, "last_nm", of->last_nm);
    json_numbers(&json, "unseen", of->sight.lost, of->sight.detector.n);
    json_count(&json, "out_of_gamut_pixels", of->values == DEVELOP_RGB ? of->clipped.n : 0);
    json_string(&json, "output", options->output);
    return json_write(&json, options->json, &options->outputs, err);
}

/* ---- the command ---- */

/* Names the picture, if the command line does not, and refuses a PNG of floats. */
static bool name_picture(struct options *options, const char *stack, struct error *err)
{
    const struct develop_own *own = options->own;
    const char *floats = own->xyz ? "--xyz" : own->lab ? "--lab" : own->raw ? "--raw" : NULL;
    char ending[16] = ".png";
    if (floats)
        snprintf(ending, sizeof ending, "%s.tif", floats + 1); /* "-xyz.tif" */
    if (!options_name_output(options, stack, ending, err) || !picture_accepts(options->output, err))
        return false;
    if (own->bits && (own->xyz || own->lab))
        return error_usage(err, "%s writes floats; expected no --bits", floats);
    return !floats || !picture_is_png(options->output) ||
           error_at(err, (struct place){options->output, 0, 0},
                    "%s writes floats, and a PNG has none; expected .tif or .tiff", floats);
}

/* Refuses the options of pictures beside --raw. */
static bool check_raw(const struct options *options, struct error *err)
{
    const struct develop_own *own = options->own;
    const char *other = own->xyz           ? "--xyz"
                        : own->lab         ? "--lab"
                        : own->adaptation  ? "--adaptation"
                        : options->display ? "--display"
                        : options->white   ? "--white"
                        : options->matrix  ? "--matrix"
                        : options->json    ? "--json"
                                           : NULL;
    if (own->raw && other)
        return error_usage(err, "--raw takes no %s", other);
    return !own->raw || !own->bits || strcmp(own->bits, "16") == 0 ||
           error_usage(err, "--raw writes floats, or counts of --bits 16");
}

static bool run_develop(struct options *options, struct error *err)
{
    struct development of;
    struct printed printed = {.text = NULL};
    const char *stack = options->operand;
    if (!name_picture(options, stack, err) || !read_options(options, &of, err) ||
        !check_raw(options, err))
        return false;
    const bool done = scene_refuse(stack, err) && develop(&of, err) &&
                      (!options->json || write_json(options, &of, err));
    if (done && !options->quiet)
        (of.values == DEVELOP_RAW ? print_raw : print_development)(&of, options->output, &printed);
    develop_free(&of);
    return printed_show(&printed, options_table(options, options->output), err) && done;
}

static const char *const picture_bits[] = {"8", "16", NULL};
static const struct option develop_rows[] = {
    {"-o, --output PICTURE.png",
     "writes there, PNG or .tif; - is standard output (default: STACK's name + .png)",
     SHARED(TEXT, output), .writes = true},
    {"--adaptation none|von-kries|bradford|cat16|fairchild[:LUMINANCE]",
     "takes the white to the display's (default: none); LUMINANCE: cd/m2 (10 x intensity)",
     OWN(TEXT, develop_own, adaptation)},
    {"--display srgb|monitor|FILE",
     "sRGB (default), the monitor of the 1998 thesis, or primaries, gain, offset and gamma",
     SHARED(TEXT, display)},
    {"--bits 8|16", "bits of each channel (default: 8)", OWN(TEXT, develop_own, bits),
     .choices = picture_bits},
    {"--xyz", "writes float tristimulus values instead of RGB", OWN(FLAG, develop_own, xyz)},
    {"--lab", "writes float CIELAB instead of RGB", OWN(FLAG, develop_own, lab)},
    {"--raw", "writes a page for each channel of the detector, linear floats or --bits 16 counts",
     OWN(FLAG, develop_own, raw)},
};
const struct command develop_command = {
    .name = "develop",
    .operands = "STACK [-o PICTURE.png]",
    .summary = "write what a detector sees, as PNG or TIFF",
    .example = "develop colorchecker.tif",
    .first = "writes the picture that a person sees",
    .run = run_develop,
    .rows = OPTION_LIST(develop_rows),
    .shared = {&exposure_option, &seeing_options, &threads_option, &json_option, &quiet_option},
    .own_size = sizeof(struct develop_own),
    .n_operands = 1,
};
