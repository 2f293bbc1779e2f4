/* SPDX-License-Identifier: MIT */
/* The command line: one function a command; only main prints errors and exits. */
#include <ctype.h>
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/base/base.h"
#include "data/colour/colour.h"
#include "data/compare/compare.h"
#include "data/develop/develop.h"
#include "data/mesh/mesh.h"
#include "data/method/method.h"
#include "data/probe/probe.h"
#include "data/record/record.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/stack/stack.h"
#include "data/text/text.h"
#include "data/tiff/tiff.h"
#include "raster/cost/cost.h"
#include "raster/gl/gl.h"
#include "raster/inspect/inspect.h"
#include "raster/plan/plan.h"
#include "raster/render/render.h"
#include "raster/view/view.h"
#include "spectral.h"

static const char usage[] =
    "usage: spectral COMMAND [SCENE] [OPTIONS]\n"
    "\n"
    "Renders a 3D scene wavelength by wavelength through OpenGL, cross-checks every pixel\n"
    "of every wavelength against its own rasterizer, and writes a spectral TIFF stack.\n"
    "\n"
    "  render [SCENE] [-o STACK.tif]   render, cross-check, write (default: SCENE's name + .tif)\n"
    "  plan   [SCENE]                  what would be simulated, and why; draws nothing\n"
    "  develop STACK [-o IMAGE.tif]    what a detector sees, as a colour picture (default:\n"
    "                                  STACK's name + -developed.tif)\n"
    "  probe  STACK|SCENE X Y [W H]    the spectrum of a pixel, or the mean of a region\n"
    "  compare STACK STACK             where and by how much two stacks differ\n"
    "  cost   [SCENE]                  what accuracy costs in time: measures many settings\n"
    "  view   [SCENE] [-o PAGE.html]   an interactive viewer in one HTML file\n"
    "  info   STACK                    how a stack was made\n"
    "  list   [KIND]                   illuminants, observers, materials, shapes, scenes or\n"
    "                                  samplings\n"
    "\n"
    "SCENE is a scene file, a list of material files, or a built-in scene (colorchecker).\n";

static const char usage_of_options[] =
    "\n"
    "render, plan, view, cost, and probe of a scene:\n"
    "  --wavelengths START:END:STEP    in nm; or a list: 450,500.5,620\n"
    "  --size WxH                      in pixels\n"
    "  --light N=SPECTRUM[*INTENSITY]  another spectrum for light N (from 1); again for more\n"
    "  --ambient SPECTRUM[*INTENSITY]  another ambient light\n"
    "all of these but cost:\n"
    "  --shading smooth|flat|phong     phong lights each pixel: with --renderer raster\n"
    "  --tessellation FACTOR           of the slices, stacks, ... of built-in shapes\n"
    "render and plan:\n"
    "  --sampling METHOD               box:N, riemann:STEP, gauss:N[,open|xyz|lms|acc],\n"
    "                                  adaptive:TOLERANCE, basis:K, rgb or xyz\n"
    "  --detector NAME|FILE            whom it is sampled for (default cie1931)\n"
    "render:\n"
    "  -o, --output STACK.tif          /dev/null: check only, write nothing\n"
    "  --again STACK                   make that stack again, from the scene and the options that\n"
    "                                  it records; it must be the same to the last byte\n"
    "                                  (default output: STACK's name + -again.tif)\n"
    "  --renderer NAME                 whose pixels are stored: gl (default), its llvmpipe or\n"
    "                                  softpipe, or raster, the reference\n"
    "  --buffer 8|16|float             bits of OpenGL's colours (default float)\n"
    "  --no-check                      do not cross-check\n"
    "  --strict                        every pixel must have a bound, and no fragment be lost or\n"
    "                                  doubled where triangles meet\n"
    "  --keep                          store the stack even when the check fails\n"
    "  --full-scale R                  radiance of count 65535 (default: the largest)\n"
    "  --depth 8|16|32f                counts, or 32-bit float radiances (default 16)\n"
    "  --threads N                     default: one per processor\n"
    "  --json FILE                     results as JSON; - is standard output\n"
    "  --quiet                         no table and no progress; so in develop, compare, view and\n"
    "                                  cost\n"
    "develop, probe and compare:\n"
    "  --detector NAME|FILE            default cie1931; a camera only in develop (also: "
    "--observer)\n"
    "  --white SPECTRUM                default: the lights that the stack records\n"
    "develop:\n"
    "  --adaptation KIND               none (default), von-kries, bradford, cat16, or\n"
    "                                  fairchild[:LUMINANCE] in cd/m2 (default: 10 x intensity)\n"
    "  --display srgb|monitor          default srgb; monitor is that of the 1998 thesis\n"
    "  --exposure FACTOR|auto          default 1; auto: nothing is brighter than the display\n"
    "  --bits 8|16                     default 8\n"
    "  --xyz, --lab                    float tristimulus values, or CIELAB, instead of RGB\n"
    "  --sampling METHOD               as if the spectra had been sampled so (no basis, rgb, xyz)\n"
    "probe:\n"
    "  --csv, --svg                    a table, or a plot, instead of text; to -o FILE\n"
    "compare:\n"
    "  --tolerance R|P%|EdE00          largest difference that passes: radiance, per cent of the\n"
    "                                  largest radiance, or CIEDE2000 (dE94, dE76); default 0\n"
    "  --map OUT.tif                   each pixel's largest difference, spectral angle, CIEDE2000\n"
    "cost:\n"
    "  --observer NAME|FILE            default cie1931\n"
    "  --runs N                        of each setting, at least 5 (default 5)\n"
    "  --csv FILE, --svg FILE          the table, and a chart; - is standard output\n"
    "  --tolerance E                   names the cheapest setting within E CIEDE2000, for 95 %\n"
    "                                  of the pixels\n"
    "  --budget SECONDS                names the most accurate setting within the time\n"
    "all:\n"
    "  -h, --help    --version\n"
    "\n"
    "exit status: 0 agreed, 1 pictures or stacks differ, 2 bad usage or input, 3 the system "
    "failed\n";

static bool print_usage(void)
{
    return fputs(usage, stdout) >= 0 && fputs(usage_of_options, stdout) >= 0;
}

/* ---- options ---- */

struct override {
    bool (*apply)(struct scene *scene, const char *value, struct error *err);
    const char *value;
};
enum { MAX_OPERANDS = 5 };
struct options {
    const char *operand; /* the first: SCENE, STACK, or KIND of list; NULL: none */
    const char *operands[MAX_OPERANDS];
    int n_operands;
    struct override overrides[MAX_RECORD_OPTIONS];
    char *recorded[MAX_RECORD_OPTIONS]; /* those that a stack records, as one word each; owned */
    int n_overrides, n_recorded;
    const char *output, *json, *again;
    struct plan_options plan;
    const char *detector, *white, *map;
    struct develop_options develop;
    struct tolerance tolerance;
    const char *sampling;
    const char *csv_file, *svg_file, *budget, *largest_error; /* of cost */
    int runs;
    bool xyz, lab, csv, svg;
    bool no_check, strict, keep, quiet, help;
};

static void options_free(struct options *options)
{
    for (int i = 0; i < options->n_recorded; i++)
        free(options->recorded[i]);
}

/* "NAME=VALUE", or a flag's name. */
static bool record_option(struct options *options, const char *name, const char *value,
                          struct error *err)
{
    size_t length = strlen(name) + (value ? strlen(value) : 0) + sizeof "=";
    if (options->n_recorded == MAX_RECORD_OPTIONS)
        return error_usage(err, "%s: more than %d options of the picture", name,
                           MAX_RECORD_OPTIONS);
    char *word = malloc(length);
    if (!word)
        return error_memory(err);
    snprintf(word, length, "%s%s%s", name, value ? "=" : "", value ? value : "");
    options->recorded[options->n_recorded++] = word;
    return true;
}

static bool set_renderer(struct options *options, const char *value, struct error *err)
{
    const bool driver = strcmp(value, "llvmpipe") == 0 || strcmp(value, "softpipe") == 0;
    options->plan.store_raster = strcmp(value, "raster") == 0;
    options->plan.gl_driver = driver ? value : NULL;
    return driver || options->plan.store_raster || strcmp(value, "gl") == 0 ||
           error_usage(err, "--renderer takes gl, llvmpipe, softpipe or raster, not '%s'", value);
}

/* 8, 16, or 32 under the name of floats. */
static bool read_bits(const char *option, const char *value, const char *floats, int *out,
                      struct error *err)
{
    *out = strcmp(value, "8") == 0 ? 8 : strcmp(value, "16") == 0 ? 16 : 32;
    return *out < 32 || strcmp(value, floats) == 0 ||
           error_usage(err, "%s takes 8, 16 or %s, not '%s'", option, floats, value);
}

static bool set_depth(struct options *options, const char *value, struct error *err)
{
    return read_bits("--depth", value, "32f", &options->plan.bits, err);
}

static bool set_buffer(struct options *options, const char *value, struct error *err)
{
    return read_bits("--buffer", value, "float", &options->plan.buffer_bits, err);
}

/* Reads an option's one number through the same strict words as files. */
static bool option_number(const char *option, const char *value, double lowest, double highest,
                          double *out, struct error *err)
{
    struct text text;
    bool done = text_open_string(&text, option, value, err) && text_next_line(&text) &&
                text_number(&text, "value", lowest, highest, out, err) &&
                text_end(&text, option, err);
    if (!done)
        error_usage(err, "%s takes a number", option);
    text_free(&text);
    return done;
}

static bool set_full_scale(struct options *options, const char *value, struct error *err)
{
    return option_number("--full-scale", value, 1e-300, 1e300, &options->plan.full_scale, err);
}

static bool option_count(const char *option, const char *value, int lowest, int *out,
                         struct error *err)
{
    double count;
    if (!option_number(option, value, lowest, 1024, &count, err))
        return false;
    *out = (int)count;
    return count == *out || error_usage(err, "%s takes a whole number, not '%s'", option, value);
}

static bool set_threads(struct options *options, const char *value, struct error *err)
{
    return option_count("--threads", value, 1, &options->plan.threads, err);
}

static bool set_runs(struct options *options, const char *value, struct error *err)
{
    return option_count("--runs", value, 5, &options->runs, err);
}

static bool set_adaptation(struct options *options, const char *value, struct error *err)
{
    return adaptation_read("--adaptation", value, &options->develop.adaptation, err);
}

static bool set_display(struct options *options, const char *value, struct error *err)
{
    return display_read("--display", value, &options->develop.display, err);
}

static bool set_exposure(struct options *options, const char *value, struct error *err)
{
    options->develop.exposure = 0;
    return strcmp(value, "auto") == 0 ||
           option_number("--exposure", value, 1e-12, 1e12, &options->develop.exposure, err);
}

static bool set_bits(struct options *options, const char *value, struct error *err)
{
    options->develop.bits = strcmp(value, "16") == 0 ? 16 : 8;
    return options->develop.bits == 16 || strcmp(value, "8") == 0 ||
           error_usage(err, "--bits takes 8 or 16, not '%s'", value);
}

static bool set_tolerance(struct options *options, const char *value, struct error *err)
{
    return tolerance_read("--tolerance", value, &options->tolerance, err);
}

/* RECORDED: what decides the picture, and so is what --again takes from a stack. FOR_SHADED: all of
 * FOR_SCENES but cost, which chooses its shading itself. */
enum {
    FOR_SCENES = 1,
    FOR_RENDER = 2,
    FOR_DEVELOP = 4,
    FOR_PROBE = 8,
    FOR_COMPARE = 16,
    FOR_VIEW = 32,
    FOR_ALL = 64,
    RECORDED = 128,
    FOR_PLAN = 256,
    FOR_COST = 512,
    FOR_SHADED = 1024,
    FOR_SEEING = FOR_DEVELOP | FOR_PROBE | FOR_COMPARE
};

/* An option overrides something in the scene, is set by a function, or is a word or a flag that
 * lies in struct options at `offset`. */
enum option_kind { OVERRIDE, SETTER, WORD, FLAG };
struct option {
    const char *name;
    int commands;
    enum option_kind kind;
    bool (*apply)(struct scene *scene, const char *value, struct error *err);
    bool (*set)(struct options *options, const char *value, struct error *err);
    size_t offset;
};
static const struct option known_options[] = {
    {"--wavelengths", FOR_SCENES | RECORDED, OVERRIDE, scene_set_wavelengths, NULL, 0},
    {"--size", FOR_SCENES | RECORDED, OVERRIDE, scene_set_size, NULL, 0},
    {"--light", FOR_SCENES | RECORDED, OVERRIDE, scene_set_light, NULL, 0},
    {"--ambient", FOR_SCENES | RECORDED, OVERRIDE, scene_set_ambient, NULL, 0},
    {"--shading", FOR_SHADED | RECORDED, OVERRIDE, scene_set_shading, NULL, 0},
    {"--tessellation", FOR_SHADED | RECORDED, OVERRIDE, scene_set_tessellation, NULL, 0},
    {"--sampling", FOR_RENDER | FOR_PLAN | RECORDED, WORD, NULL, NULL,
     offsetof(struct options, sampling)},
    {"--sampling", FOR_DEVELOP, WORD, NULL, NULL, offsetof(struct options, sampling)},
    {"--detector", FOR_RENDER | FOR_PLAN | RECORDED, WORD, NULL, NULL,
     offsetof(struct options, detector)},
    {"--observer", FOR_RENDER | FOR_PLAN | RECORDED, WORD, NULL, NULL,
     offsetof(struct options, detector)},
    {"--renderer", FOR_RENDER | RECORDED, SETTER, NULL, set_renderer, 0},
    {"--buffer", FOR_RENDER | RECORDED, SETTER, NULL, set_buffer, 0},
    {"--depth", FOR_RENDER | RECORDED, SETTER, NULL, set_depth, 0},
    {"--full-scale", FOR_RENDER | RECORDED, SETTER, NULL, set_full_scale, 0},
    {"--threads", FOR_RENDER | FOR_DEVELOP | FOR_COMPARE | FOR_VIEW | FOR_COST, SETTER, NULL,
     set_threads, 0},
    {"--output", FOR_RENDER | FOR_DEVELOP | FOR_PROBE | FOR_VIEW, WORD, NULL, NULL,
     offsetof(struct options, output)},
    {"-o", FOR_RENDER | FOR_DEVELOP | FOR_PROBE | FOR_VIEW, WORD, NULL, NULL,
     offsetof(struct options, output)},
    {"--json", FOR_RENDER, WORD, NULL, NULL, offsetof(struct options, json)},
    {"--again", FOR_RENDER, WORD, NULL, NULL, offsetof(struct options, again)},
    {"--no-check", FOR_RENDER | RECORDED, FLAG, NULL, NULL, offsetof(struct options, no_check)},
    {"--strict", FOR_RENDER | RECORDED, FLAG, NULL, NULL, offsetof(struct options, strict)},
    {"--keep", FOR_RENDER, FLAG, NULL, NULL, offsetof(struct options, keep)},
    {"--quiet", FOR_RENDER | FOR_DEVELOP | FOR_COMPARE | FOR_VIEW | FOR_COST, FLAG, NULL, NULL,
     offsetof(struct options, quiet)},
    {"--detector", FOR_SEEING | FOR_COST, WORD, NULL, NULL, offsetof(struct options, detector)},
    {"--observer", FOR_SEEING | FOR_COST, WORD, NULL, NULL, offsetof(struct options, detector)},
    {"--white", FOR_SEEING, WORD, NULL, NULL, offsetof(struct options, white)},
    {"--adaptation", FOR_DEVELOP, SETTER, NULL, set_adaptation, 0},
    {"--display", FOR_DEVELOP, SETTER, NULL, set_display, 0},
    {"--exposure", FOR_DEVELOP, SETTER, NULL, set_exposure, 0},
    {"--bits", FOR_DEVELOP, SETTER, NULL, set_bits, 0},
    {"--xyz", FOR_DEVELOP, FLAG, NULL, NULL, offsetof(struct options, xyz)},
    {"--lab", FOR_DEVELOP, FLAG, NULL, NULL, offsetof(struct options, lab)},
    {"--csv", FOR_PROBE, FLAG, NULL, NULL, offsetof(struct options, csv)},
    {"--svg", FOR_PROBE, FLAG, NULL, NULL, offsetof(struct options, svg)},
    {"--csv", FOR_COST, WORD, NULL, NULL, offsetof(struct options, csv_file)},
    {"--svg", FOR_COST, WORD, NULL, NULL, offsetof(struct options, svg_file)},
    {"--tolerance", FOR_COMPARE, SETTER, NULL, set_tolerance, 0},
    {"--tolerance", FOR_COST, WORD, NULL, NULL, offsetof(struct options, largest_error)},
    {"--budget", FOR_COST, WORD, NULL, NULL, offsetof(struct options, budget)},
    {"--runs", FOR_COST, SETTER, NULL, set_runs, 0},
    {"--map", FOR_COMPARE, WORD, NULL, NULL, offsetof(struct options, map)},
    {"--help", FOR_ALL, FLAG, NULL, NULL, offsetof(struct options, help)},
    {"-h", FOR_ALL, FLAG, NULL, NULL, offsetof(struct options, help)},
};
enum { N_OPTIONS = sizeof known_options / sizeof known_options[0] };

/* An option of one name may be another one for another command. */
static const struct option *find_option(const char *word, size_t length, int commands)
{
    for (int i = 0; i < N_OPTIONS; i++)
        if ((known_options[i].commands & (commands | FOR_ALL)) &&
            strlen(known_options[i].name) == length &&
            strncmp(known_options[i].name, word, length) == 0)
            return &known_options[i];
    return NULL;
}

static bool apply_option(struct options *options, const struct option *option, const char *value,
                         struct error *err)
{
    char *at = (char *)options + option->offset;
    if ((option->commands & RECORDED) && !record_option(options, option->name, value, err))
        return false;
    switch (option->kind) {
    case SETTER:
        return option->set(options, value, err);
    case WORD:
        memcpy(at, &value, sizeof value);
        return true;
    case FLAG:
        *(bool *)at = true;
        return true;
    case OVERRIDE:
        break;
    }
    options->overrides[options->n_overrides++] = (struct override){option->apply, value};
    return true;
}

/* One option with its value, which may be the next word; *index moves on. */
static bool parse_option(int argc, char **argv, int *index, int commands, struct options *options,
                         struct error *err)
{
    const char *word = argv[*index], *equals = strchr(word, '=');
    size_t length = equals ? (size_t)(equals - word) : strlen(word);
    const struct option *option = find_option(word, length, commands);
    if (!option)
        return error_usage(err, "%s has no option '%.*s'; try spectral --help", argv[1],
                           (int)length, word);
    if (option->kind == FLAG)
        return equals ? error_usage(err, "%s takes no value", option->name)
                      : apply_option(options, option, NULL, err);
    if (!equals && *index + 1 == argc)
        return error_usage(err, "%s needs a value; try spectral --help", option->name);
    return apply_option(options, option, equals ? equals + 1 : argv[++*index], err);
}

static bool parse_options(int argc, char **argv, int commands, int n_operands, struct options *out,
                          struct error *err)
{
    *out = (struct options){.runs = 5, .develop = {.exposure = 1, .bits = 8}};
    bool only_operands = false;
    for (int i = 2; i < argc; i++) {
        if (!only_operands && strcmp(argv[i], "--") == 0) {
            only_operands = true;
        } else if (!only_operands && argv[i][0] == '-' && argv[i][1]) {
            if (!parse_option(argc, argv, &i, commands, out, err))
                return false;
        } else if (out->n_operands == n_operands) {
            return error_usage(err, "'%s' is too much; try spectral --help", argv[i]);
        } else {
            out->operands[out->n_operands++] = argv[i];
        }
    }
    out->operand = out->operands[0];
    return true;
}

/* ---- scene and plan ---- */

static bool read_scene(const struct options *options, struct scene *out, struct error *err)
{
    if (!scene_read(options->operand ? options->operand : "colorchecker", out, err))
        return false;
    for (int i = 0; i < options->n_overrides; i++)
        if (!options->overrides[i].apply(out, options->overrides[i].value, err))
            return false;
    return true;
}

static const char *detector_of(const struct options *options)
{
    return options->detector ? options->detector : "cie1931";
}

/* The same, sampled as the options say; *sampling stays zeroed where they ask for none. */
static bool read_sampled(const struct options *options, struct scene *out,
                         struct sampling *sampling, struct error *err)
{
    struct sampling_method method;
    if (!options->sampling)
        return options->detector ? error_usage(err, "--detector is for whom --sampling samples; "
                                                    "develop shows a stack to any detector")
                                 : read_scene(options, out, err);
    return sampling_read("--sampling", options->sampling, &method, err) &&
           read_scene(options, out, err) &&
           scene_sample(out, &method, detector_of(options), sampling, err);
}

static bool command_plan(struct options *options, struct error *err)
{
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.n = 0};
    struct plan plan = {.scene = NULL};
    bool done = read_sampled(options, &scene, &sampling, err) &&
                plan_make(&scene, sampling_or_none(&sampling), &options->plan, &plan, err);
    if (done)
        plan_print(&plan, stdout);
    plan_free(&plan);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}

/* ---- render ---- */

struct progress_line {
    double start;
    double printed; /* when, so that the terminal is not flooded */
};

static void show_progress(void *context, long done, long all)
{
    struct progress_line *line = context;
    double time = render_clock(), elapsed = time - line->start;
    if (done == all)
        fprintf(stderr, "\r%40s\r", "");
    else if (time - line->printed > 0.1) {
        fprintf(stderr, "\r%3ld %%, %.0f s left ", 100 * done / all,
                elapsed * (double)(all - done) / (double)done);
        line->printed = time;
    }
}

/* The file's name without folder and ending, with another ending; allocated. */
static char *default_output(const char *path, const char *ending)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    size_t length = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    size_t capacity = length + strlen(ending) + 1;
    char *out = malloc(capacity);
    if (out)
        snprintf(out, capacity, "%.*s%s", (int)length, name, ending);
    return out;
}

static uint64_t peak_bytes(void)
{
    struct rusage used;
    return getrusage(RUSAGE_SELF, &used) == 0 ? (uint64_t)used.ru_maxrss * 1024 : 0;
}

static bool is_regular_file(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

/* Refuses an output that would take the place of what is read. Either may be NULL. */
static bool spares(const char *output, const char *input, struct error *err)
{
    struct stat written, read;
    return !output || !input || stat(output, &written) != 0 || stat(input, &read) != 0 ||
           !S_ISREG(read.st_mode) || written.st_dev != read.st_dev ||
           written.st_ino != read.st_ino ||
           error_usage(err, "%s would replace what is read; expected another file", output);
}

static bool spares_scene(const char *output, const struct scene *scene, struct error *err)
{
    for (int i = 0; i < scene->n_files; i++)
        if (!spares(output, scene->files[i].path, err))
            return false;
    return true;
}

/* stored: the stack's name, NULL where none was. A pipe cannot be read again for its digest. */
static bool write_json(const struct options *options, const struct plan *plan,
                       const struct render_result *result, const char *stored, struct error *err)
{
    char sha256[65];
    bool digested = stored && is_regular_file(stored);
    if (digested && !digest_file(stored, sha256, err))
        return false;
    char *json = report_json(plan, result, stored, digested ? sha256 : NULL, peak_bytes());
    bool done = json ? file_write(options->json, json, strlen(json), err) : error_memory(err);
    free(json);
    return done;
}

/* made: how the stack was made that was made again; NULL: none was. */
static bool report(const struct options *options, const struct plan *plan,
                   const struct render_result *result, const struct render_output *output,
                   const struct record *made, struct error *err)
{
    bool agreed = render_agreed(result);
    const char *wanted = output->discard ? NULL : output->path;
    const char *stored = agreed || output->keep ? wanted : NULL;
    /* standard output may carry the JSON, or the stack itself (-o /dev/stdout) */
    bool taken =
        (options->json && strcmp(options->json, "-") == 0) || (stored && !is_regular_file(stored));
    if (options->json && !write_json(options, plan, result, stored, err))
        return false;
    if (!options->quiet)
        report_print(plan, result, taken ? stderr : stdout);
    if (!options->quiet && stored)
        fprintf(taken ? stderr : stdout, "stack             %s\n", stored);
    if (!options->quiet && result->difference.compared)
        fprintf(taken ? stderr : stdout, "again             %s bytes as %s\n",
                result->difference.found ? "not the same" : "the same", output->again);
    if (agreed)
        return true;
    const char *then = !wanted        ? "nothing was to be written"
                       : output->keep ? "the stack was kept"
                                      : "no stack was written (--keep stores it all the same)";
    return result->check.unexplained > 0
               ? report_difference(plan, &result->check, then, err)
               : report_not_again(plan, result, output->again, made, then, err);
}

/* Finds a report that cannot be written before the pictures are drawn, not after; NULL: none is
 * wanted. */
static bool can_report(const char *path, struct error *err)
{
    struct output probe = {.path = NULL};
    bool able = !path || strcmp(path, "-") == 0 || output_open(&probe, path, err);
    output_discard(&probe);
    return able;
}

static bool render_planned(const struct options *options, const struct plan *plan,
                           const struct render_seconds *before, const struct render_output *output,
                           const struct record *made, struct error *err)
{
    struct progress_line line = {.start = render_clock()};
    struct render_progress progress = {NULL, &line};
    struct render_result result;
    if (!options->quiet && isatty(STDERR_FILENO))
        progress.step = show_progress;
    if (!render(plan, output, &progress, &result, err))
        return false;
    result.seconds.read += before->read;
    result.seconds.plan = before->plan;
    result.seconds.total += before->read + before->plan;
    return report(options, plan, &result, output, made, err);
}

/* Refuses a scene that is not what the record tells. */
static bool same_scene(const struct scene *scene, const char *stack, const struct record *made,
                       struct error *err)
{
    return strcmp(scene->sha256, made->scene_sha256) == 0 ||
           error_usage(err,
                       "%s: the scene's text is not that of %s: its SHA-256 is %s, recorded is "
                       "%.64s",
                       scene->path, stack, scene->sha256, made->scene_sha256);
}

/* What lights each pixel OpenGL cannot, and so cannot be checked either. */
static bool check_shading(const struct options *options, const struct scene *scene,
                          struct plan_options *plan, struct error *err)
{
    if (scene->shading != SHADING_PHONG)
        return true;
    if (!plan->store_raster)
        return error_usage(err, "phong shading is the reference's, since OpenGL lights vertices; "
                                "add --renderer raster");
    if (options->strict)
        return error_usage(err, "--strict checks OpenGL, which has no phong shading");
    plan->check = plan->use_gl = false;
    return true;
}

/* What a program without OpenGL lacks is said before anything is read. */
static bool check_gl(const struct options *options, const char *again, struct error *err)
{
    if (gl_is_built())
        return true;
    if (!options->plan.store_raster && again)
        return error_usage(err, "%s holds OpenGL's pixels, and this program was built without",
                           again);
    if (!options->plan.store_raster)
        return error_usage(err, "this program was built without OpenGL; it renders with "
                                "--renderer raster");
    return !options->strict ||
           error_usage(err, "--strict checks OpenGL, and this program was built without");
}

static struct plan_options plan_of(const struct options *options)
{
    struct plan_options plan = options->plan;
    plan.check = gl_is_built() && !options->no_check;
    plan.strict = options->strict;
    plan.use_gl = plan.check || !plan.store_raster;
    plan.recorded = options->recorded;
    plan.n_recorded = options->n_recorded;
    return plan;
}

static bool plan_and_render(const struct options *options, const struct render_output *output,
                            const struct record *made, struct error *err)
{
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.n = 0};
    struct plan plan = {.scene = NULL};
    struct plan_options plan_options = plan_of(options);
    struct render_seconds seconds = {.read = 0};
    double start = render_clock();
    bool done = check_gl(options, output->again, err) &&
                read_sampled(options, &scene, &sampling, err) &&
                check_shading(options, &scene, &plan_options, err) &&
                (!made || same_scene(&scene, output->again, made, err)) &&
                spares_scene(output->path, &scene, err) && spares_scene(options->json, &scene, err);
    seconds.read = render_clock() - start;
    done = done && plan_make(&scene, sampling_or_none(&sampling), &plan_options, &plan, err);
    seconds.plan = render_clock() - start - seconds.read;
    done = done && can_report(options->json, err) &&
           render_planned(options, &plan, &seconds, output, made, err);
    plan_free(&plan);
    sampling_free(&sampling);
    scene_free(&scene);
    return done;
}

/* The reference's stack is the same, however it was checked: that is not recorded. */
static void forget_check(struct options *options)
{
    int n = 0;
    for (int i = 0; i < options->n_recorded; i++)
        if (strcmp(options->recorded[i], "--no-check") == 0 ||
            strcmp(options->recorded[i], "--strict") == 0)
            free(options->recorded[i]);
        else
            options->recorded[n++] = options->recorded[i];
    options->n_recorded = n;
}

static bool render_scene(struct options *options, struct error *err)
{
    const char *scene = options->operand ? options->operand : "colorchecker";
    char *named = options->output ? NULL : default_output(scene, ".tif");
    const char *output = options->output ? options->output : named;
    if (!output)
        return error_memory(err);
    if (options->plan.store_raster)
        forget_check(options);
    struct render_output wanted = {.path = strcmp(output, "/dev/null") == 0 ? NULL : output,
                                   .keep = options->keep};
    bool done = plan_and_render(options, &wanted, NULL, err);
    free(named);
    return done;
}

static bool read_record(const char *path, struct image *image, struct record *out,
                        struct error *err)
{
    const struct place nowhere = {0};
    return image_open(path, nowhere, image, err) && record_read(image, out, err);
}

/* What the record says of scene and picture, and what the command line says of all else. */
static bool recorded_options(const struct options *options, const struct record *record,
                             struct options *out, struct error *err)
{
    char command[] = "render", *words[2 + MAX_RECORD_OPTIONS] = {command, command};
    for (int i = 0; i < record->n_options; i++)
        words[2 + i] = record->options[i];
    if (!parse_options(2 + record->n_options, words, RECORDED, 1, out, err))
        return false;
    if (out->operand)
        return error_usage(err, "%s records '%s', which is no option", options->again,
                           out->operand);
    out->operand = record->scene;
    out->json = options->json;
    out->plan.threads = options->plan.threads;
    out->quiet = options->quiet;
    if (!out->plan.store_raster)
        return !(options->no_check || options->strict) ||
               error_usage(err,
                           "%s holds OpenGL's pixels: it tells itself whether they are "
                           "checked, --again takes no %s",
                           options->again, options->no_check ? "--no-check" : "--strict");
    out->no_check = options->no_check;
    out->strict = options->strict;
    return true;
}

/* What is known before anything is drawn. */
static bool can_be_same(const struct record *record, const struct render_output *output,
                        struct error *err)
{
    if (strcmp(record->program, PROGRAM) != 0 && !output->keep) {
        error_usage(err,
                    "%s was made by %.80s, this is " PROGRAM ", which tells so in its stacks "
                    "(--keep stores one all the same)",
                    output->again, record->program);
        err->status = EXIT_DIFFERENT;
        return false;
    }
    return !scene_is_missing(record->scene) ||
           error_usage(err,
                       "%s: its scene '%.500s' is not there; names are relative to the folder "
                       "where it was made",
                       output->again, record->scene);
}

/* -o /dev/null: the stack is laid out under its default name, compared, and not kept. */
static bool render_again(struct options *options, struct error *err)
{
    struct image image = {.path = NULL};
    struct record record = {.text = NULL};
    struct options made = {.operand = NULL};
    bool discard = options->output && strcmp(options->output, "/dev/null") == 0;
    char *named = default_output(options->again, "-again.tif");
    struct render_output wanted = {.path = options->output && !discard ? options->output : named,
                                   .again = options->again,
                                   .keep = options->keep,
                                   .discard = discard};
    forget_check(options);
    if (options->operand || options->n_recorded > 0)
        error_usage(err, "--again takes no %s: the stack tells it",
                    options->operand ? "SCENE" : options->recorded[0]);
    else if (!named)
        error_memory(err);
    bool done = err->status == EXIT_AGREED && read_record(options->again, &image, &record, err) &&
                recorded_options(options, &record, &made, err) &&
                can_be_same(&record, &wanted, err) && plan_and_render(&made, &wanted, &record, err);
    options_free(&made);
    record_free(&record);
    image_close(&image);
    free(named);
    return done;
}

static bool command_render(struct options *options, struct error *err)
{
    return options->again ? render_again(options, err) : render_scene(options, err);
}

/* ---- develop ---- */

/* A built-in scene has no pixels yet. */
static bool takes_stack(const char *stack, struct error *err)
{
    return access(stack, F_OK) == 0 || scene_is_missing(stack) ||
           error_usage(err, "'%s' is a scene, not a stack; spectral render %s writes one", stack,
                       stack);
}

static bool command_develop(struct options *options, struct error *err)
{
    struct develop_options *develop_options = &options->develop;
    struct develop_result result;
    if (!options->operand)
        return error_usage(err, "develop takes a STACK; try spectral --help");
    if (options->xyz && options->lab)
        return error_usage(err, "--xyz and --lab exclude each other");
    struct sampling_method method;
    if (options->sampling && !sampling_read("--sampling", options->sampling, &method, err))
        return false;
    develop_options->sampling = options->sampling ? &method : NULL;
    char *named = options->output ? NULL : default_output(options->operand, "-developed.tif");
    const char *output = options->output ? options->output : named;
    develop_options->detector = detector_of(options);
    develop_options->white = options->white;
    develop_options->threads = options->plan.threads;
    develop_options->values = options->xyz ? DEVELOP_XYZ : options->lab ? DEVELOP_LAB : DEVELOP_RGB;
    bool done = output
                    ? takes_stack(options->operand, err) && spares(output, options->operand, err) &&
                          develop(options->operand, output, develop_options, &result, err)
                    : error_memory(err);
    if (done && !options->quiet) {
        FILE *to = is_regular_file(output) ? stdout : stderr;
        develop_print(develop_options, &result, to);
        fprintf(to, "picture           %s\n", output);
    }
    free(named);
    return done;
}

/* ---- probe ---- */

static bool region_read(const struct options *options, struct probe_options *out, struct error *err)
{
    static const char *const names[] = {"X", "Y", "W", "H"};
    double numbers[] = {0, 0, 1, 1};
    if (options->n_operands != 3 && options->n_operands != 5)
        return error_usage(err, "probe takes a STACK or SCENE, X and Y, and perhaps W and H; try "
                                "spectral --help");
    for (int i = 0; i + 1 < options->n_operands; i++)
        if (!option_number(names[i], options->operands[1 + i], i < 2 ? 0 : 1, INT32_MAX,
                           &numbers[i], err) ||
            (numbers[i] != (int)numbers[i] && !error_usage(err, "%s is a whole number, not '%s'",
                                                           names[i], options->operands[1 + i])))
            return false;
    *out = (struct probe_options){(int)numbers[0], (int)numbers[1],      (int)numbers[2],
                                  (int)numbers[3], detector_of(options), options->white};
    return true;
}

static bool is_tiff(const char *path)
{
    char start[4] = "";
    FILE *file = is_regular_file(path) ? fopen(path, "rb") : NULL;
    size_t length = file ? fread(start, 1, sizeof start, file) : 0;
    if (file)
        fclose(file);
    return length == sizeof start && (memcmp(start, "II", 2) == 0 || memcmp(start, "MM", 2) == 0) &&
           (start[2] + start[3] == 42 || start[2] + start[3] == 43);
}

static bool probe_planned(const struct options *options, const struct probe_options *region,
                          struct probe *out, struct error *err)
{
    struct scene scene = {.path = NULL};
    struct plan plan = {.scene = NULL};
    struct plan_options plan_options = {.store_raster = true};
    bool done = read_scene(options, &scene, err) && spares_scene(options->output, &scene, err) &&
                plan_make(&scene, NULL, &plan_options, &plan, err) &&
                probe_scene(&plan, region, out, err);
    plan_free(&plan);
    scene_free(&scene);
    return done;
}

static bool probe_write(const struct options *options, const struct probe *probe, struct error *err)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = options->svg ? NULL : open_memstream(&text, &length);
    if (options->svg)
        text = probe_svg(probe);
    if (stream) {
        (options->csv ? probe_print_csv : probe_print)(probe, stream);
        if (fclose(stream) != 0) {
            free(text);
            text = NULL;
        }
    }
    bool done = text ? file_write(options->output ? options->output : "-", text, strlen(text), err)
                     : error_memory(err);
    free(text);
    return done;
}

static bool command_probe(struct options *options, struct error *err)
{
    struct probe_options region;
    struct probe probe = {.source = NULL};
    if (!region_read(options, &region, err))
        return false;
    if (options->csv && options->svg)
        return error_usage(err, "--csv and --svg exclude each other");
    bool stack = is_tiff(options->operand);
    if (stack && options->n_recorded > 0)
        return error_usage(err, "%s is a stack: it takes no %s", options->operand,
                           options->recorded[0]);
    bool done = (stack ? spares(options->output, options->operand, err) &&
                             probe_stack(options->operand, &region, &probe, err)
                       : probe_planned(options, &region, &probe, err)) &&
                probe_write(options, &probe, err);
    probe_free(&probe);
    return done;
}

/* ---- compare ---- */

static bool command_compare(struct options *options, struct error *err)
{
    struct comparison comparison = {.n = 0};
    struct compare_options compare_options = {detector_of(options), options->white, options->map,
                                              options->tolerance, options->plan.threads};
    if (options->n_operands != 2)
        return error_usage(err, "compare takes two stacks; try spectral --help");
    const char *a = options->operands[0], *b = options->operands[1];
    bool done = takes_stack(a, err) && takes_stack(b, err) && spares(options->map, a, err) &&
                spares(options->map, b, err) && compare(a, b, &compare_options, &comparison, err);
    /* standard output may carry the map (--map /dev/stdout) */
    if (done && !options->quiet)
        comparison_print(&comparison,
                         !options->map || is_regular_file(options->map) ? stdout : stderr);
    if (done && !comparison_is_within(&comparison, &options->tolerance)) {
        done = error_usage(err, "%s and %s differ by more than the tolerance", a, b);
        err->status = EXIT_DIFFERENT;
    }
    comparison_free(&comparison);
    return done;
}

/* ---- view ---- */

static bool command_view(struct options *options, struct error *err)
{
    struct scene scene = {.path = NULL};
    struct plan plan = {.scene = NULL};
    struct plan_options plan_options = {
        .store_raster = true, .exchangeable = true, .threads = options->plan.threads};
    struct viewer_result result;
    const char *named = options->operand ? options->operand : "colorchecker";
    char *page = options->output ? NULL : default_output(named, ".html");
    const char *output = options->output ? options->output : page;
    bool done = output ? read_scene(options, &scene, err) && spares_scene(output, &scene, err) &&
                             plan_make(&scene, NULL, &plan_options, &plan, err) &&
                             viewer_write(&plan, output, &result, err)
                       : error_memory(err);
    if (done && !options->quiet)
        fprintf(is_regular_file(output) ? stdout : stderr,
                "objects           %d\nlights            %d, %d illuminants to choose from\n"
                "detectors         %d\npage              %s, %.2f MB\n",
                result.n_objects, result.n_lights, result.n_illuminants, result.n_detectors, output,
                (double)result.bytes / 1e6);
    plan_free(&plan);
    scene_free(&scene);
    free(page);
    return done;
}

/* ---- cost ---- */

/* A command line of render: what cost was told of the scene, then a configuration's words. */
static bool parse_render(const struct options *options, char *const *words, int n_words,
                         struct options *out, struct error *err)
{
    char command[] = "render", *line[2 + MAX_RECORD_OPTIONS + COST_WORDS] = {command, command};
    int n = 2;
    for (int i = 0; i < options->n_recorded; i++)
        line[n++] = options->recorded[i];
    for (int i = 0; i < n_words; i++)
        line[n++] = words[i];
    if (!parse_options(n, line, FOR_SCENES | FOR_SHADED | FOR_RENDER, 0, out, err))
        return false;
    out->operand = options->operand;
    out->plan.threads = options->plan.threads;
    out->quiet = true;
    return true;
}

static bool cost_render(void *context, char *const *words, int n_words, const char *output,
                        struct error *err)
{
    struct options options = {.operand = NULL};
    bool done = parse_render(context, words, n_words, &options, err);
    options.output = output;
    done = done && render_scene(&options, err);
    options_free(&options);
    return done;
}

static bool cost_read(void *context, char *const *words, int n_words, struct scene *scene,
                      struct sampling *sampling, struct error *err)
{
    struct options options = {.operand = NULL};
    bool done = parse_render(context, words, n_words, &options, err) &&
                read_sampled(&options, scene, sampling, err);
    options_free(&options);
    return done;
}

/* A file that is NULL is not wanted. */
static bool cost_write(const struct cost *cost, const char *csv, const char *svg, struct error *err)
{
    char *table = NULL, *chart = NULL;
    size_t length = 0;
    FILE *stream = csv ? open_memstream(&table, &length) : NULL;
    if (stream) {
        cost_print_csv(cost, stream);
        if (fclose(stream) != 0)
            length = 0;
    }
    if (svg)
        chart = cost_svg(cost);
    bool done = (!csv || length > 0) && (!svg || chart) ? true : error_memory(err);
    done = done && (!csv || file_write(csv, table, length, err)) &&
           (!svg || file_write(svg, chart, strlen(chart), err));
    free(table);
    free(chart);
    return done;
}

/* As one would type it. */
static void print_word(const char *word, FILE *to)
{
    const bool plain = word[strspn(word, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                         "0123456789%+,-./:=@_")] == '\0';
    fputs(plain ? " " : " '", to);
    for (; *word; word++)
        if (*word == '\'')
            fputs("'\\''", to);
        else
            fputc(*word, to);
    fputs(plain ? "" : "'", to);
}

static void print_setting(const struct options *options, const char *what,
                          const struct cost_entry *entry, FILE *to)
{
    fprintf(to, "%s: %s, %.3g s, dE00 %.3g\n  spectral render", what, entry->name, entry->seconds,
            entry->quantile_95);
    print_word(options->operand ? options->operand : "colorchecker", to);
    for (int i = 0; i < options->n_recorded; i++)
        print_word(options->recorded[i], to);
    for (int i = 0; i < entry->n_words; i++)
        print_word(entry->words[i], to);
    fputc('\n', to);
}

/* Where the one that serves best is no stack of wavelengths, the best that is one, too. */
static bool recommend(const struct options *options, const char *what, const struct cost *cost,
                      const struct cost_entry *(*find)(const struct cost *cost, double limit,
                                                       bool spectral),
                      double limit, FILE *to, struct error *err)
{
    const struct cost_entry *entry = find(cost, limit, false), *other = find(cost, limit, true);
    if (!entry) {
        error_usage(err, "no setting is %s", what);
        err->status = EXIT_DIFFERENT;
        return false;
    }
    print_setting(options, what, entry, to);
    if (!other)
        fputs("with spectra: none\n", to);
    else if (other != entry)
        print_setting(options, "with spectra", other, to);
    return true;
}

static bool report_cost(const struct options *options, const struct cost *cost, double tolerance,
                        double budget, struct error *err)
{
    const bool taken = (options->csv_file && strcmp(options->csv_file, "-") == 0) ||
                       (options->svg_file && strcmp(options->svg_file, "-") == 0);
    FILE *to = taken ? stderr : stdout;
    char what[80];
    if (!options->quiet)
        cost_print(cost, to);
    if (!cost_write(cost, options->csv_file, options->svg_file, err))
        return false;
    snprintf(what, sizeof what, "within %.10g CIEDE2000", tolerance);
    if (options->largest_error && !recommend(options, what, cost, cost_within, tolerance, to, err))
        return false;
    snprintf(what, sizeof what, "within %.10g s", budget);
    return !options->budget || recommend(options, what, cost, cost_affordable, budget, to, err);
}

static bool can_cost(struct options *options, struct error *err)
{
    struct scene scene = {.path = NULL};
    struct sampling sampling = {.n = 0};
    const char *csv = options->csv_file, *svg = options->svg_file;
    bool done = cost_read(options, NULL, 0, &scene, &sampling, err) &&
                spares_scene(csv, &scene, err) && spares_scene(svg, &scene, err) &&
                can_report(csv, err) && can_report(svg, err);
    sampling_free(&sampling);
    scene_free(&scene);
    return done && (!csv || !svg || strcmp(csv, svg) != 0 ||
                    error_usage(err, "--csv and --svg are written to different files"));
}

static bool command_cost(struct options *options, struct error *err)
{
    struct progress_line line = {.start = render_clock()};
    const struct cost_program program = {cost_render, cost_read, options};
    const struct cost_options cost_options = {
        .observer = detector_of(options),
        .given = options->recorded,
        .n_given = options->n_recorded,
        .runs = options->runs,
        .threads = options->plan.threads,
        .progress = !options->quiet && isatty(STDERR_FILENO) ? show_progress : NULL,
        .progress_context = &line};
    struct cost cost = {.scene = NULL};
    double tolerance = 0, budget = 0;
    bool done =
        (!options->largest_error ||
         option_number("--tolerance", options->largest_error, 0, 1000, &tolerance, err)) &&
        (!options->budget || option_number("--budget", options->budget, 0, 1e9, &budget, err)) &&
        can_cost(options, err) && cost_measure(&program, &cost_options, &cost, err) &&
        report_cost(options, &cost, tolerance, budget, err);
    cost_free(&cost);
    return done;
}

/* ---- info ---- */

/* A file's words: a control character among them could drive the terminal. */
static void print_fact(const char *name, const char *value)
{
    printf("%-17s ", name);
    for (; *value; value++)
        putchar(iscntrl((unsigned char)*value) ? '?' : *value);
    putchar('\n');
}

static void print_record(const struct image *image, const struct record *record)
{
    print_fact("program", record->program);
    print_fact("scene", record->scene);
    print_fact("scene SHA-256", record->scene_sha256);
    for (int i = 0; i < record->n_options; i++)
        print_fact("option", record->options[i]);
    print_fact("renderer", record->renderer);
    for (int i = 0; i < record->n_lights; i++)
        print_fact("light", record->lights[i]);
    for (int i = 0; i < record->n_ambients; i++)
        print_fact("ambient light", record->ambients[i]);
    if (record->sampling) {
        print_fact("sampling", record->sampling);
        print_fact(record->n_response > 0 ? "sampled only for" : "sampled for",
                   record->sampling_detector);
    }
    if (record->map_bytes > 0)
        printf("objects           %d\n", record->n_objects);
    printf("pages             %d of %d x %d pixels\n", image->n_pages, image->width, image->height);
    if (image->wavelengths_nm)
        printf("wavelengths       %.10g to %.10g nm\n", image->wavelengths_nm[0],
               image->wavelengths_nm[image->n_pages - 1]);
    if (record->components)
        printf("components        of %.10g to %.10g nm\n", record->range_nm[0] + 0.5,
               record->range_nm[1] - 0.5);
    print_fact("full scale", record->full_scale);
    print_fact("scale", record->scale);
    print_fact("verdict", image->verdict);
}

static bool command_info(struct options *options, struct error *err)
{
    struct image image = {.path = NULL};
    struct record record = {.text = NULL};
    bool done = options->operand ? takes_stack(options->operand, err) &&
                                       read_record(options->operand, &image, &record, err)
                                 : error_usage(err, "info takes a STACK; try spectral --help");
    if (done)
        print_record(&image, &record);
    record_free(&record);
    image_close(&image);
    return done;
}

/* ---- list ---- */

static void list_folder(const char *folder, const char *ending)
{
    size_t before = strlen(folder), after = strlen(ending);
    for (size_t i = 0; i < builtin_file_count; i++) {
        const char *name = builtin_files[i].name;
        size_t length = strlen(name);
        if (length > before + after && strncmp(name, folder, before) == 0 &&
            strcmp(name + length - after, ending) == 0)
            printf("  %.*s\n", (int)(length - before - after), name + before);
    }
}

static void list_shapes(void)
{
    static const char *const arguments[] = {
        [SHAPE_SPHERE] = "radius slices stacks",
        [SHAPE_TORUS] = "tube ring sides rings",
        [SHAPE_BOX] = "width height depth",
        [SHAPE_PLANE] = "width height",
        [SHAPE_CYLINDER] = "radius height slices stacks",
        [SHAPE_CONE] = "radius height slices stacks",
        [SHAPE_DISK] = "radius slices",
        [SHAPE_TEAPOT] = "size divisions",
        [SHAPE_MESH] = "FILE.obj [unitize] [crease ANGLE]",
    };
    for (int kind = SHAPE_SPHERE; kind <= SHAPE_MESH; kind++)
        printf("  %s %s\n", shape_name((enum shape_kind)kind), arguments[kind]);
}

/* Tables of one value column are illuminants, of three observers. */
static void list_tables(bool observers)
{
    for (size_t i = 0; i < builtin_file_count; i++) {
        const char *name = builtin_files[i].name, *dot = strrchr(name, '.');
        if (strncmp(name, "tables/", 7) != 0)
            continue;
        if (table_is_detector(&builtin_files[i]) == observers)
            printf("  %.*s\n", (int)(dot - name) - 7, name + 7);
    }
}

static void list_samplings(void)
{
    fputs(
        "  box:N               N boxes of equal area under the detector's functions\n"
        "  riemann:STEP        a sample every STEP nm\n"
        "  gauss:N             Gaussian quadrature weighted by the detector's functions\n"
        "  gauss:N,open        by none: the detector is left open\n"
        "  gauss:N,xyz|lms|acc by tristimulus values, cones or opponent functions, each its own\n"
        "  adaptive:TOLERANCE  emission peaks, and quadrature between them\n"
        "  basis:K             K principal components of lights x reflectances: no spectra\n"
        "  rgb, xyz            three numbers a light and a material: no spectra, no fluorescence\n",
        stdout);
}

static bool command_list(struct options *options, struct error *err)
{
    static const char *const kinds[] = {"illuminants", "observers", "materials",
                                        "shapes",      "scenes",    "samplings"};
    const char *wanted = options->operand;
    bool found = false;
    for (int i = 0; i < 6; i++) {
        if (wanted && strcmp(wanted, kinds[i]) != 0)
            continue;
        found = true;
        printf("%s\n", kinds[i]);
        if (i < 2)
            list_tables(i == 1);
        else if (i == 2)
            list_folder("materials/", ".txt");
        else if (i == 3)
            list_shapes();
        else if (i == 4)
            list_folder("scenes/", ".scene");
        else
            list_samplings();
    }
    return found || error_usage(err,
                                "there is no list of '%s'; there are illuminants, observers, "
                                "materials, shapes, scenes and samplings",
                                wanted);
}

/* ---- main ---- */

static bool print_version(void)
{
    char gl[256];
    const char *tiff = stack_library();
    gl_library(gl, sizeof gl);
    printf("spectral %s\n%s\n%.*s\n", SPECTRAL_VERSION, gl, (int)strcspn(tiff, "\n"), tiff);
    return true;
}

struct command {
    const char *name;
    int options, n_operands;
    bool (*run)(struct options *options, struct error *err);
};
static const struct command commands[] = {
    {"render", FOR_SCENES | FOR_SHADED | FOR_RENDER, 1, command_render},
    {"plan", FOR_SCENES | FOR_SHADED | FOR_PLAN, 1, command_plan},
    {"develop", FOR_DEVELOP, 1, command_develop},
    {"probe", FOR_SCENES | FOR_SHADED | FOR_PROBE, 5, command_probe},
    {"compare", FOR_COMPARE, 2, command_compare},
    {"cost", FOR_SCENES | FOR_COST, 1, command_cost},
    {"view", FOR_SCENES | FOR_SHADED | FOR_VIEW, 1, command_view},
    {"info", 0, 1, command_info},
    {"list", 0, 1, command_list},
};
enum { N_COMMANDS = sizeof commands / sizeof commands[0] };

static bool run_with_options(const struct command *command, int argc, char **argv,
                             struct error *err)
{
    struct options options;
    bool done = parse_options(argc, argv, command->options, command->n_operands, &options, err) &&
                (options.help ? print_usage() : command->run(&options, err));
    options_free(&options);
    return done;
}

static bool run_command(int argc, char **argv, struct error *err)
{
    if (argc < 2)
        return error_usage(err, "a command is missing; try spectral --help");
    if (strcmp(argv[1], "--version") == 0)
        return print_version();
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 ||
        strcmp(argv[1], "help") == 0)
        return print_usage();
    for (int i = 0; i < N_COMMANDS; i++)
        if (strcmp(argv[1], commands[i].name) == 0)
            return run_with_options(&commands[i], argc, argv, err);
    return error_usage(err,
                       "'%s' is no command; there are render, plan, develop, probe, compare, cost, "
                       "view, info and list",
                       argv[1]);
}

int main(int argc, char **argv)
{
    struct error err = {.status = EXIT_AGREED};
    signal(SIGPIPE, SIG_IGN); /* a closed pipe is a failed write, with a message */
    bool done = run_command(argc, argv, &err);
    errno = 0;
    if (fflush(stdout) != 0 || ferror(stdout)) {
        error_system(&err, "cannot write to standard output");
        done = false;
    }
    if (done)
        return EXIT_AGREED;
    fprintf(stderr, "%s\n", err.text);
    return (int)err.status;
}
