/* SPDX-License-Identifier: MIT */
/* The command line: the table of commands, the table of options, the help that follows from both,
 * and main, which alone prints errors and exits. Each command lies in the room of its subject. */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "data/catalogue/catalogue.h"
#include "data/compare/compare.h"
#include "data/develop/develop.h"
#include "data/options/options.h"
#include "data/scene/scene.h"
#include "data/stack/stack.h"
#include "raster/cost/cost.h"
#include "raster/gl/gl.h"
#include "raster/inspect/inspect.h"
#include "raster/plan/plan.h"
#include "raster/render/render.h"
#include "raster/view/view.h"
#include "spectral.h"

/* ---- commands ---- */

struct command {
    const char *name;
    const char *operands, *summary; /* for --help */
    bool (*run)(struct options *options, struct error *err);
    int options, n_operands; /* the bit of its options; the most operands */
};
static const struct command commands[] = {
    {"render", "[SCENE] [-o STACK.tif]",
     "render, cross-check, write (default: SCENE's name + .tif)", command_render, FOR_RENDER, 1},
    {"plan", "[SCENE]", "what would be simulated, and why; draws nothing", command_plan, FOR_PLAN,
     1},
    {"develop", "STACK [-o IMAGE.tif]",
     "what a detector sees, as a colour picture (default:\nSTACK's name + -developed.tif)",
     command_develop, FOR_DEVELOP, 1},
    {"probe", "STACK|SCENE X Y [W H]", "the spectrum of a pixel, or the mean of a region",
     command_probe, FOR_PROBE, 5},
    {"compare", "STACK STACK", "where and by how much two stacks differ", command_compare,
     FOR_COMPARE, 2},
    {"cost", "[SCENE]", "what accuracy costs in time: measures many settings", command_cost,
     FOR_COST, 1},
    {"view", "[SCENE] [-o PAGE.html]", "an interactive viewer in one HTML file", command_view,
     FOR_VIEW, 1},
    {"info", "STACK", "how a stack was made", command_info, 0, 1},
    {"list", "[KIND]", "illuminants, observers, materials, shapes, scenes or\nsamplings",
     command_list, 0, 1},
};
enum { N_COMMANDS = sizeof commands / sizeof commands[0] };

/* ---- options ---- */

#define TEXT(field) .kind = OPTION_TEXT, .offset = offsetof(struct options, field)
#define FLAG(field) .kind = OPTION_FLAG, .offset = offsetof(struct options, field)
#define CHANGE(function) .kind = OPTION_CHANGE, .change = (function)

static const char *const renderers[] = {"gl", "llvmpipe", "softpipe", "raster", NULL};
static const char *const buffers[] = {"8", "16", "float", NULL};
static const char *const depths[] = {"8", "16", "32f", NULL};
static const char *const picture_bits[] = {"8", "16", NULL};

/* In the order of --help. */
static const struct option known_options[] = {
    {.heading = "render, plan, view, cost, and probe of a scene:",
     .name = "--wavelengths",
     .commands = FOR_SCENES | RECORDED,
     CHANGE(scene_set_wavelengths),
     .usage = "--wavelengths START:END:STEP",
     .help = "in nm; or a list: 450,500.5,620"},
    {.name = "--size",
     .commands = FOR_SCENES | RECORDED,
     CHANGE(scene_set_size),
     .usage = "--size WxH",
     .help = "in pixels"},
    {.name = "--light",
     .commands = FOR_SCENES | RECORDED,
     CHANGE(scene_set_light),
     .usage = "--light N=SPECTRUM[*INTENSITY]",
     .help = "another spectrum for light N (from 1); again for more"},
    {.name = "--ambient",
     .commands = FOR_SCENES | RECORDED,
     CHANGE(scene_set_ambient),
     .usage = "--ambient SPECTRUM[*INTENSITY]",
     .help = "another ambient light"},
    {.heading = "all of these but cost:",
     .name = "--shading",
     .commands = FOR_SHADED | RECORDED,
     CHANGE(scene_set_shading),
     .usage = "--shading smooth|flat|phong",
     .help = "phong lights each pixel: with --renderer raster"},
    {.name = "--tessellation",
     .commands = FOR_SHADED | RECORDED,
     CHANGE(scene_set_tessellation),
     .usage = "--tessellation FACTOR",
     .help = "of the slices, stacks, ... of built-in shapes"},
    {.heading = "render and plan:",
     .name = "--sampling",
     .commands = FOR_RENDER | FOR_PLAN | RECORDED,
     TEXT(sampling),
     .usage = "--sampling METHOD",
     .help = "box:N, riemann:STEP, gauss:N[,open|xyz|lms|acc],\n"
             "adaptive:TOLERANCE, basis:K, rgb or xyz"},
    {.name = "--detector",
     .alias = "--observer",
     .commands = FOR_RENDER | FOR_PLAN | RECORDED,
     TEXT(detector),
     .usage = "--detector NAME|FILE",
     .help = "whom it is sampled for (default cie1931)"},
    {.heading = "render:",
     .name = "--output",
     .alias = "-o",
     .commands = FOR_RENDER | FOR_DEVELOP | FOR_PROBE | FOR_VIEW,
     TEXT(output),
     .usage = "-o, --output STACK.tif",
     .help = "/dev/null: check only, write nothing"},
    {.name = "--again",
     .commands = FOR_RENDER,
     TEXT(again),
     .usage = "--again STACK",
     .help = "make that stack again, from the scene and the options that\n"
             "it records; it must be the same to the last byte\n"
             "(default output: STACK's name + -again.tif)"},
    {.name = "--renderer",
     .commands = FOR_RENDER | RECORDED,
     TEXT(renderer),
     .choices = renderers,
     .usage = "--renderer NAME",
     .help = "whose pixels are stored: gl (default), its llvmpipe or\n"
             "softpipe, or raster, the reference"},
    {.name = "--buffer",
     .commands = FOR_RENDER | RECORDED,
     TEXT(buffer),
     .choices = buffers,
     .usage = "--buffer 8|16|float",
     .help = "bits of OpenGL's colours (default float)"},
    {.name = "--no-check",
     .commands = FOR_RENDER | RECORDED,
     FLAG(no_check),
     .usage = "--no-check",
     .help = "do not cross-check"},
    {.name = "--strict",
     .commands = FOR_RENDER | RECORDED,
     FLAG(strict),
     .usage = "--strict",
     .help = "every pixel must have a bound, and no fragment be lost or\n"
             "doubled where triangles meet"},
    {.name = "--keep",
     .commands = FOR_RENDER,
     FLAG(keep),
     .usage = "--keep",
     .help = "store the stack even when the check fails"},
    {.name = "--full-scale",
     .commands = FOR_RENDER | RECORDED,
     .kind = OPTION_NUMBER,
     .offset = offsetof(struct options, full_scale),
     .lowest = 1e-300,
     .highest = 1e300,
     .usage = "--full-scale R",
     .help = "radiance of count 65535 (default: the largest)"},
    {.name = "--depth",
     .commands = FOR_RENDER | RECORDED,
     TEXT(depth),
     .choices = depths,
     .usage = "--depth 8|16|32f",
     .help = "counts, or 32-bit float radiances (default 16)"},
    {.name = "--threads",
     .commands = FOR_RENDER | FOR_DEVELOP | FOR_COMPARE | FOR_VIEW | FOR_COST,
     .kind = OPTION_COUNT,
     .offset = offsetof(struct options, threads),
     .lowest = 1,
     .usage = "--threads N",
     .help = "default: one per processor"},
    {.name = "--json",
     .commands = FOR_RENDER,
     TEXT(json),
     .usage = "--json FILE",
     .help = "results as JSON; - is standard output"},
    {.name = "--quiet",
     .commands = FOR_RENDER | FOR_DEVELOP | FOR_COMPARE | FOR_VIEW | FOR_COST,
     FLAG(quiet),
     .usage = "--quiet",
     .help = "no table and no progress; so in develop, compare, view and\n"
             "cost"},
    {.heading = "develop, probe and compare:",
     .name = "--detector",
     .alias = "--observer",
     .commands = FOR_STACKS,
     TEXT(detector),
     .usage = "--detector NAME|FILE",
     .help = "default cie1931; a camera only in develop (also: --observer)"},
    {.name = "--white",
     .commands = FOR_STACKS,
     TEXT(white),
     .usage = "--white SPECTRUM",
     .help = "default: the lights that the stack records"},
    {.heading = "develop:",
     .name = "--adaptation",
     .commands = FOR_DEVELOP,
     TEXT(adaptation),
     .accepts = develop_accepts_adaptation,
     .usage = "--adaptation KIND",
     .help = "none (default), von-kries, bradford, cat16, or\n"
             "fairchild[:LUMINANCE] in cd/m2 (default: 10 x intensity)"},
    {.name = "--display",
     .commands = FOR_DEVELOP,
     TEXT(display),
     .accepts = develop_accepts_display,
     .usage = "--display srgb|monitor",
     .help = "default srgb; monitor is that of the 1998 thesis"},
    {.name = "--exposure",
     .commands = FOR_DEVELOP,
     TEXT(exposure),
     .accepts = develop_accepts_exposure,
     .usage = "--exposure FACTOR|auto",
     .help = "default 1; auto: nothing is brighter than the display"},
    {.name = "--bits",
     .commands = FOR_DEVELOP,
     TEXT(bits),
     .choices = picture_bits,
     .usage = "--bits 8|16",
     .help = "default 8"},
    {.name = "--xyz",
     .commands = FOR_DEVELOP,
     FLAG(xyz),
     .usage = "--xyz, --lab",
     .help = "float tristimulus values, or CIELAB, instead of RGB"},
    {.name = "--lab", .commands = FOR_DEVELOP, FLAG(lab)},
    {.name = "--sampling",
     .commands = FOR_DEVELOP,
     TEXT(sampling),
     .usage = "--sampling METHOD",
     .help = "as if the spectra had been sampled so (no basis, rgb, xyz)"},
    {.heading = "probe:",
     .name = "--csv",
     .commands = FOR_PROBE,
     FLAG(csv),
     .usage = "--csv, --svg",
     .help = "a table, or a plot, instead of text; to -o FILE"},
    {.name = "--svg", .commands = FOR_PROBE, FLAG(svg)},
    {.heading = "compare:",
     .name = "--tolerance",
     .commands = FOR_COMPARE,
     TEXT(tolerance),
     .accepts = compare_accepts_tolerance,
     .usage = "--tolerance R|P%|EdE00",
     .help = "largest difference that passes: radiance, per cent of the\n"
             "largest radiance, or CIEDE2000 (dE94, dE76); default 0"},
    {.name = "--map",
     .commands = FOR_COMPARE,
     TEXT(map),
     .usage = "--map OUT.tif",
     .help = "each pixel's largest difference, spectral angle, CIEDE2000"},
    {.heading = "cost:",
     .name = "--observer",
     .alias = "--detector",
     .commands = FOR_COST,
     TEXT(detector),
     .usage = "--observer NAME|FILE",
     .help = "default cie1931"},
    {.name = "--runs",
     .commands = FOR_COST,
     .kind = OPTION_COUNT,
     .offset = offsetof(struct options, runs),
     .lowest = 5,
     .usage = "--runs N",
     .help = "of each setting, at least 5 (default 5)"},
    {.name = "--csv",
     .commands = FOR_COST,
     TEXT(csv_file),
     .usage = "--csv FILE, --svg FILE",
     .help = "the table, and a chart; - is standard output"},
    {.name = "--svg", .commands = FOR_COST, TEXT(svg_file)},
    {.name = "--tolerance",
     .commands = FOR_COST,
     TEXT(tolerance),
     .usage = "--tolerance E",
     .help = "names the cheapest setting within E CIEDE2000, for 95 %\n"
             "of the pixels"},
    {.name = "--budget",
     .commands = FOR_COST,
     TEXT(budget),
     .usage = "--budget SECONDS",
     .help = "names the most accurate setting within the time"},
    {.heading = "all:",
     .name = "--help",
     .alias = "-h",
     .commands = FOR_ALL,
     FLAG(help),
     .usage = "-h, --help    --version"},
};
static const struct option_table option_table = {known_options,
                                                 sizeof known_options / sizeof known_options[0]};

/* ---- help ---- */

/* Prints what is typed, and beside it the lines that explain it; NULL: nothing explains it. */
static void print_explained(const char *typed, const char *lines)
{
    if (!lines) {
        printf("  %s\n", typed);
        return;
    }
    printf("  %-31s ", typed);
    for (;;) {
        const size_t length = strcspn(lines, "\n");
        printf("%.*s\n", (int)length, lines);
        if (!lines[length])
            return;
        lines += length + 1;
        printf("%34s", "");
    }
}

static void print_commands(void)
{
    for (int i = 0; i < N_COMMANDS; i++) {
        char typed[64];
        snprintf(typed, sizeof typed, "%-6s %s", commands[i].name, commands[i].operands);
        print_explained(typed, commands[i].summary);
    }
}

static void print_options(void)
{
    for (int i = 0; i < option_table.n; i++) {
        const struct option *option = &known_options[i];
        if (option->heading)
            printf("%s\n", option->heading);
        if (option->usage)
            print_explained(option->usage, option->help);
    }
}

/* Always succeeds: main reports a failed write to standard output. */
static bool print_usage(void)
{
    fputs("usage: spectral COMMAND [SCENE] [OPTIONS]\n"
          "\n"
          "Renders a 3D scene wavelength by wavelength through OpenGL, cross-checks every pixel\n"
          "of every wavelength against its own rasterizer, and writes a spectral TIFF stack.\n"
          "\n",
          stdout);
    print_commands();
    fputs("\n"
          "SCENE is a scene file, a list of material files, or a built-in scene (colorchecker).\n"
          "\n",
          stdout);
    print_options();
    fputs("\n"
          "exit status: 0 agreed, 1 pictures or stacks differ, 2 bad usage or input, 3 the system "
          "failed\n",
          stdout);
    return true;
}

static bool print_version(void)
{
    char gl[256];
    const char *tiff = stack_library();
    gl_library(gl, sizeof gl);
    printf("spectral %s\n%s\n%.*s\n", SPECTRAL_VERSION, gl, (int)strcspn(tiff, "\n"), tiff);
    return true;
}

/* ---- main ---- */

static bool run_with_options(const struct command *command, char *const *words, int n_words,
                             struct error *err)
{
    const struct option_rules rules = {command->name, &option_table, command->options,
                                       command->n_operands};
    struct options options;
    bool done = options_read(&rules, words, n_words, &options, err) &&
                (options.help ? print_usage() : command->run(&options, err));
    options_free(&options);
    return done;
}

static bool refuse_command(const char *name, struct error *err)
{
    const char *names[N_COMMANDS];
    char list[128];
    for (int i = 0; i < N_COMMANDS; i++)
        names[i] = commands[i].name;
    words_join(names, N_COMMANDS, "and", list, sizeof list);
    return error_usage(err, "'%s' is no command; there are %s", name, list);
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
            return run_with_options(&commands[i], argv + 2, argc - 2, err);
    return refuse_command(argv[1], err);
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
