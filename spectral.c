/* SPDX-License-Identifier: MIT */
/* The command line: the table of commands, the table of options, the help made of both, and main.
 * Only main prints errors and exits. The code of each command is in the room of its subject. */
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "data/catalogue/catalogue.h"
#include "data/compare/compare.h"
#include "data/develop/develop.h"
#include "data/options/options.h"
#include "data/process/process.h"
#include "data/scene/scene.h"
#include "data/stack/stack.h"
#include "data/text/text.h"
#include "raster/cost/cost.h"
#include "raster/driver/driver.h"
#include "raster/drivers/drivers.h"
#include "raster/exchange/exchange.h"
#include "raster/gl/gl.h"
#include "raster/inspect/inspect.h"
#include "raster/plan/plan.h"
#include "raster/render/render.h"
#include "raster/verify/verify.h"
#include "raster/view/view.h"
#include "spectral.h"

/* ---- commands ---- */

struct command {
    const char *name;
    const char *operands, *summary; /* for --help, which breaks the lines of the summary */
    const char *example;            /* the words behind "spectral" */
    bool (*run)(struct options *options, struct error *err);
    int options, n_operands; /* the bit of its options; the most operands */
};
static const struct command commands[] = {
    {"render", "[SCENE] [-o STACK.tif]",
     "render, cross-check, write (default: SCENE's name + .tif)",
     "render spheres --size 1920x1280 -o spheres.tif", command_render, FOR_RENDER, 1},
    {"plan", "[SCENE]", "print what would be simulated, and why; draw nothing", "plan fluorescence",
     command_plan, FOR_PLAN, 1},
    {"develop", "STACK [-o PICTURE.png]",
     "write what a detector sees as PNG or TIFF (default: STACK's name + -developed.png)",
     "develop spheres.tif --exposure auto -o spheres.png", command_develop, FOR_DEVELOP, 1},
    {"probe", "STACK|SCENE X Y [W H]", "print the spectrum of a pixel, or the mean of a region",
     "probe fluorescence 700 300 --svg -o spectrum.svg", command_probe, FOR_PROBE, 5},
    {"compare", "STACK STACK", "print where and by how much two stacks differ",
     "compare a.tif b.tif --tolerance 0.5dE00 --map difference.png", command_compare, FOR_COMPARE,
     2},
    {"cost", "[SCENE]", "measure what accuracy costs in time", "cost patches --svg cost.svg",
     command_cost, FOR_COST, 1},
    {"view", "[SCENE|STACK] [-o PAGE.html]",
     "write an interactive viewer in one HTML file; with -o PICTURE.png its first picture",
     "view fluorescence --size 600x400 -o fluorescence.html", command_view, FOR_VIEW, 1},
    {"info", "STACK", "print how a stack was made", "info spheres.tif", command_info, FOR_INFO, 1},
    {"envi", "STACK [-o FILE.hdr]",
     "write the header by which ENVI, SPy and GDAL map a stack (default: STACK.hdr)",
     "envi spheres.tif", command_envi, FOR_ENVI, 1},
    {"drivers", "[--measure] [--json FILE]", "list what OpenGL can draw here, by which options",
     "drivers", command_drivers, FOR_DRIVERS, 0},
    {"verify", "[SCENE...]",
     "judge OpenGL's drivers by the built-in scenes and by hard cases (hard: these alone)",
     "verify --gl egl --junit verify.xml", command_verify, FOR_VERIFY, MAX_OPERANDS},
    {"export", "[SCENE] -o FOLDER",
     "write what another program needs to draw a scene, as plain files", "export room -o room",
     command_export, FOR_EXPORT, 1},
    {"judge", "SCENE PIXELS", "judge what it drew: a folder, or a TIFF", "judge room drawn",
     command_judge, FOR_JUDGE, 2},
    {"join", "-o STACK PART...", "put the parts of a picture together, which render --part drew",
     "join -o spheres.tif spheres.*-of-4.tif", command_join, FOR_JOIN, MAX_OPERANDS},
    {"list", "[KIND]", "print the names of all that is built in, or of one kind", "list materials",
     command_list, 0, 1},
    {"show", "NAME [-o FILE]", "print a built-in file, to start a file of your own with",
     "show room -o my.scene", command_show, FOR_SHOW, 1},
};
enum { N_COMMANDS = sizeof commands / sizeof commands[0] };

/* ---- options ---- */

#define TEXT(field) .kind = OPTION_TEXT, .offset = offsetof(struct options, field)
#define FLAG(field) .kind = OPTION_FLAG, .offset = offsetof(struct options, field)
#define NUMBER(field) .kind = OPTION_NUMBER, .offset = offsetof(struct options, field)
#define COUNT(field) .kind = OPTION_COUNT, .offset = offsetof(struct options, field)
#define CHANGE(function) .kind = OPTION_CHANGE, .change = (function)

static const char *const buffers[] = {"8", "16", "float", NULL};
static const char *const drivers[] = {"llvmpipe", "softpipe", "unknown", NULL};
static const char *const depths[] = {"8", "16", "32f", NULL};
static const char *const picture_bits[] = {"8", "16", NULL};

/* In the order of --help. test/run/manual.sh makes the list of the manual page from it. */
static const struct option known_options[] = {
    {.heading = "render, plan, view, cost, verify, export, judge, and probe of a scene:"},
    {"--wavelengths START:END:STEP", "wavelengths in nm, or a list of them: 450,500.5,620",
     FOR_SCENES | RECORDED, CHANGE(scene_set_wavelengths)},
    {"--size WxH", "width and height in pixels", FOR_SCENES | RECORDED, CHANGE(scene_set_size)},
    {"--light N=SPECTRUM[*INTENSITY]", "replaces the spectrum of light N (from 1); may be repeated",
     FOR_SCENES | RECORDED, CHANGE(scene_set_light)},
    {"--ambient SPECTRUM[*INTENSITY]", "replaces the ambient light", FOR_SCENES | RECORDED,
     CHANGE(scene_set_ambient)},
    {"--samples K", "stores the mean of K x K positions of each pixel: 1 (default), 2, 4, 8 or 16",
     FOR_SCENES | RECORDED, CHANGE(scene_set_samples)},
    {.heading = "all of these but cost and verify:"},
    {"--shading smooth|flat|phong", "replaces the scene's; phong needs --renderer raster",
     FOR_SHADED | RECORDED, CHANGE(scene_set_shading)},
    {"--tessellation FACTOR", "multiplies the slices, stacks, ... of built-in shapes",
     FOR_SHADED | RECORDED, CHANGE(scene_set_tessellation)},
    {"--accuracy ERROR",
     "at most this error for 95 % of object pixels: CIEDE2000, as 0.5, or counts, as 8counts",
     FOR_SHADED | RECORDED, TEXT(accuracy), .accepts = accuracy_accepts},
    {"--max-triangles N", "--accuracy makes at most N (default: 4000000)", FOR_SHADED | RECORDED,
     COUNT(max_triangles), .lowest = 1, .highest = 1 << 30},
    {.heading = "render, plan, export and judge:"},
    {"--sampling METHOD",
     "box:N, riemann:STEP, gauss:N[,open|xyz|lms|acc], adaptive:TOLERANCE, basis:K, rgb or xyz",
     FOR_RENDER | FOR_PLAN | FOR_EXCHANGE | RECORDED, TEXT(sampling)},
    {"--detector, --observer NAME", "samples for it, a built-in one or a file (default: cie1931)",
     FOR_RENDER | FOR_PLAN | FOR_EXCHANGE | RECORDED, TEXT(detector)},
    {.heading = "render:"},
    {"-o, --output STACK.tif",
     "writes there; - is standard output; /dev/null: checks only, writes nothing", FOR_RENDER,
     TEXT(output), .writes = true},
    {"--again STACK",
     "makes that stack again, from its record (default output: STACK's name + -again.tif)",
     FOR_RENDER, TEXT(again)},
    {"--trust", "--again reads files outside of this folder, too", FOR_RENDER, FLAG(trust)},
    {"--renderer gl|llvmpipe|softpipe|gl-shader[:DRIVER]|es-shader[:DRIVER]|raster",
     "stores pixels of gl (default), of its driver llvmpipe or softpipe, of shaders by OpenGL 3.3 "
     "core or OpenGL ES 3, or of the reference",
     FOR_RENDER | FOR_VERIFY | RECORDED, TEXT(renderer), .accepts = driver_accepts_renderer},
    {"--gl LIBRARY", "osmesa, egl, egl:N for EGL's device N, or auto (default), whichever is here",
     FOR_RENDER | FOR_COST | FOR_VERIFY | RECORDED, TEXT(gl), .accepts = driver_accepts_library},
    {"--buffer 8|16|float", "bits of OpenGL's colours (default: float)",
     FOR_RENDER | FOR_VERIFY | RECORDED, TEXT(buffer), .choices = buffers},
    {"--no-check", "does not cross-check", FOR_RENDER | RECORDED, FLAG(no_check)},
    {"--strict", "like --unchecked 0; also no fragment may be lost or doubled where triangles meet",
     FOR_RENDER | FOR_VERIFY | FOR_JUDGE | RECORDED, FLAG(strict)},
    {"--unchecked SHARE",
     "the part of object pixels that may stay unchecked, from 0 to 1 (default: 0.01)",
     FOR_RENDER | FOR_VERIFY | FOR_JUDGE | RECORDED, TEXT(unchecked)},
    {"--check-map FILE",
     "writes what the check can see at each pixel, and its verdict there (.tif or .png)",
     FOR_RENDER | FOR_JUDGE, TEXT(check_map), .writes = true},
    {"--keep", "stores the stack even if the check fails", FOR_RENDER | FOR_JOIN, FLAG(keep)},
    {"--envi", "also writes STACK.tif.hdr, as envi does", FOR_RENDER | FOR_JOIN, FLAG(envi)},
    {"--part I/N", "draws part I of N as a stack of some rows of the picture; see join",
     FOR_RENDER, TEXT(part), .accepts = part_accepts},
    {"--full-scale R", "radiance of count 65535 (default: the largest)",
     FOR_RENDER | FOR_EXCHANGE | RECORDED, NUMBER(full_scale), .lowest = 1e-300, .highest = 1e300},
    {"--depth 8|16|32f", "bits of counts, or 32-bit float radiances (default: 16)",
     FOR_RENDER | RECORDED, TEXT(depth), .choices = depths},
    {"-j, --threads N", "threads to compute with (default: one per processor)",
     FOR_SCENES | FOR_STACKS, COUNT(threads), .lowest = 1, .highest = 1024},
    {"--memory MIB", "MiB of memory that a command may take beyond a tile's 300 (default: 1024)",
     FOR_ALL, COUNT(memory_mib), .lowest = 1, .highest = 1 << 24},
    {"--json FILE", "writes the results as JSON; - is standard output",
     FOR_SCENES | FOR_STACKS | FOR_INFO | FOR_DRIVERS, TEXT(json), .writes = true},
    {"-v, --verbose", "prints the plan, too: each effect, and why it is simulated",
     FOR_RENDER | FOR_JUDGE, FLAG(verbose)},
    {"-q, --quiet", "prints no table and no progress",
     FOR_RENDER | FOR_JUDGE | FOR_DEVELOP | FOR_COMPARE | FOR_VIEW | FOR_COST | FOR_VERIFY |
         FOR_JOIN,
     FLAG(quiet)},
    {.heading = "develop, probe and compare:"},
    {"--detector, --observer NAME", "sees with it (default: cie1931); a camera only in develop",
     FOR_STACKS, TEXT(detector)},
    {"--white SPECTRUM", "the light of the white (default: those that the stack records)",
     FOR_STACKS, TEXT(white)},
    {.heading = "develop:"},
    {"-o, --output PICTURE.png",
     "writes there, PNG or .tif; - is standard output (default: STACK's name + -developed.png)",
     FOR_DEVELOP, TEXT(output), .writes = true},
    {"--adaptation none|von-kries|bradford|cat16|fairchild[:LUMINANCE]",
     "takes the white to the display's (default: none); LUMINANCE: cd/m2 (10 x intensity)",
     FOR_DEVELOP, TEXT(adaptation), .accepts = develop_accepts_adaptation},
    {"--display srgb|monitor", "sRGB (default), or the monitor of the 1998 thesis", FOR_DEVELOP,
     TEXT(display), .accepts = develop_accepts_display},
    {"--exposure FACTOR|auto",
     "a factor, or auto: nothing is brighter than the display (default: 1)", FOR_DEVELOP,
     TEXT(exposure), .accepts = develop_accepts_exposure},
    {"--bits 8|16", "bits of each channel (default: 8)", FOR_DEVELOP, TEXT(bits),
     .choices = picture_bits},
    {"--xyz", "writes float tristimulus values instead of RGB", FOR_DEVELOP, FLAG(xyz)},
    {"--lab", "writes float CIELAB instead of RGB", FOR_DEVELOP, FLAG(lab)},
    {"--sampling METHOD", "as if the spectra were sampled so (not basis, rgb or xyz)", FOR_DEVELOP,
     TEXT(sampling)},
    {.heading = "probe and show:"},
    {"-o, --output FILE", "writes there (default: standard output)", FOR_PROBE | FOR_SHOW,
     TEXT(output), .writes = true},
    {"--csv", "writes a table instead of text", FOR_PROBE, FLAG(csv)},
    {"--svg", "writes a plot instead of text", FOR_PROBE, FLAG(svg)},
    {.heading = "compare:"},
    {"--tolerance R|P%|EdE00",
     "largest that passes: radiance, % of the largest, or CIEDE2000 (dE94, dE76); default: 0",
     FOR_COMPARE, TEXT(tolerance), .accepts = compare_accepts_tolerance},
    {"--map FILE",
     "writes each pixel's largest difference, spectral angle and CIEDE2000 (.tif, .png)",
     FOR_COMPARE, TEXT(map), .writes = true},
    {.heading = "view:"},
    {"-o, --output PAGE.html",
     "writes there, HTML or .png; - is standard output (default: SCENE's name + .html)", FOR_VIEW,
     TEXT(output), .writes = true},
    {"--still", "the page draws one geometry, and cannot be edited", FOR_VIEW, FLAG(still)},
    {"--gallery", "a live page of all built-in scenes", FOR_VIEW, FLAG(gallery)},
    {"--budget MB", "samples in the page of a stack, at most (default: 40)", FOR_VIEW,
     TEXT(budget)},
    {.heading = "cost:"},
    {"--observer, --detector NAME", "measures colour differences for it (default: cie1931)",
     FOR_COST, TEXT(detector)},
    {"--runs N", "runs of each configuration, at least 5 (default: 5)", FOR_COST, COUNT(runs),
     .lowest = 5, .highest = 1024},
    {"--csv FILE", "writes the table; - is standard output", FOR_COST, TEXT(csv_file),
     .writes = true},
    {"--svg FILE", "writes a chart; - is standard output", FOR_COST, TEXT(svg_file),
     .writes = true},
    {"--tolerance EdE00",
     "names the cheapest configuration within E CIEDE2000 for 95 % of the pixels", FOR_COST,
     TEXT(tolerance), .accepts = cost_accepts_tolerance},
    {"--budget SECONDS", "names the most accurate configuration within the time", FOR_COST,
     TEXT(budget)},
    {.heading = "verify:"},
    {"--junit FILE", "writes the results as JUnit's XML; - is standard output", FOR_VERIFY,
     TEXT(junit), .writes = true},
    {.heading = "export and judge:"},
    {"-o, --output FOLDER", "writes the files into this new folder", FOR_EXPORT, TEXT(output)},
    {"--driver llvmpipe|softpipe|unknown",
     "judges by the bounds of this driver (default: that of the renderer that drawn.txt names)",
     FOR_JUDGE, TEXT(driver), .choices = drivers},
    {.heading = "drivers:"},
    {"--measure", "measures what each one does where OpenGL leaves it free", FOR_DRIVERS,
     FLAG(measure)},
    {.heading = "envi:"},
    {"-o, --output FILE.hdr",
     "writes there; - is standard output (default: STACK's name + .hdr, beside it)", FOR_ENVI,
     TEXT(output), .writes = true},
    {.heading = "join:"},
    {"-o, --output STACK.tif", "writes there; - is standard output", FOR_JOIN, TEXT(output),
     .writes = true},
    {.heading = "all:"},
    {"-h, --help", "prints the help of this command; spectral -V, --version prints the versions",
     FOR_ALL, FLAG(help)},
};
static const struct option_table option_table = {known_options,
                                                 sizeof known_options / sizeof known_options[0]};

/* ---- help ---- */

static void print_commands(struct printed *to)
{
    for (int i = 0; i < N_COMMANDS; i++) {
        char typed[64];
        snprintf(typed, sizeof typed, "%-7s %s", commands[i].name, commands[i].operands);
        help_explain(to, typed, commands[i].summary);
    }
}

static const char scene_operand[] =
    "SCENE is a scene file, a list of material files, a built-in scene (default:\n"
    "colorchecker), or - for standard input.\n";

static bool print_usage(struct error *err)
{
    struct printed printed = {.text = NULL}, *to = &printed;
    print_text(
        to, "usage: spectral COMMAND [SCENE] [OPTIONS]\n\n"
            "Renders a 3D scene wavelength by wavelength through OpenGL, cross-checks every\n"
            "pixel of every wavelength against its own rasterizer, and writes a TIFF stack.\n\n");
    print_commands(to);
    print(to, "\n%s\n", scene_operand);
    help_options(&option_table, to);
    print_text(to, "\n"
                   "exit status: 0 agreed, 1 pictures or stacks differ, 2 bad usage or input,\n"
                   "3 the system failed\n");
    return printed_show(to, STDOUT_FILENO, err);
}

static bool print_command_usage(const struct command *command, struct error *err)
{
    struct printed printed = {.text = NULL}, *to = &printed;
    print(to, "usage: spectral %s %s [OPTIONS]\n\n", command->name, command->operands);
    help_words(to, command->summary, 0);
    if (strstr(command->operands, "SCENE"))
        print(to, "\n%s", scene_operand);
    print_text(to, "\n");
    help_command_options(&option_table, command->options, to);
    print(to, "\nexample:\n  spectral %s\n", command->example);
    return printed_show(to, STDOUT_FILENO, err);
}

/* The answer to the name of the program alone. It ends as bad usage does, for scripts. */
static bool greet(struct error *err)
{
    struct printed printed = {.text = NULL};
    print_text(&printed,
               "spectral renders 3D scenes wavelength by wavelength, and checks every pixel.\n"
               "\n"
               "  spectral render colorchecker          writes the stack colorchecker.tif\n"
               "  spectral develop colorchecker.tif     writes the picture that a person sees\n"
               "  spectral probe colorchecker 100 100   prints the spectrum of a pixel\n"
               "  spectral view fluorescence            writes a page for the browser\n"
               "  spectral show spheres -o my.scene     copies a scene, to change it\n"
               "\n"
               "spectral list prints what is built in. spectral COMMAND --help explains a\n"
               "command, spectral --help all of them, man spectral the scene language.\n");
    if (printed_show(&printed, STDOUT_FILENO, err))
        err->status = EXIT_INPUT;
    return false;
}

static bool print_version(struct error *err)
{
    struct printed printed = {.text = NULL};
    char gl[256];
    const char *tiff = stack_library();
    gl_library(gl, sizeof gl);
    print(&printed, "spectral %s\n%s\n%.*s\n", SPECTRAL_VERSION, gl, (int)strcspn(tiff, "\n"),
          tiff);
    return printed_show(&printed, STDOUT_FILENO, err);
}

/* ---- main ---- */

static bool run_limited(const struct command *command, struct options *options, struct error *err)
{
    options_limit_memory(options);
    return command->run(options, err);
}

/* The words are those of the whole command line. */
static bool run_with_options(const struct command *command, char *const *words, int n_words,
                             struct error *err)
{
    const struct option_rules rules = {command->name, &option_table, command->options,
                                       command->n_operands};
    struct options options;
    bool done = options_read(&rules, words + 2, n_words - 2, &options, err);
    options.program = words[0];
    done = done &&
           (options.help ? print_command_usage(command, err) : run_limited(command, &options, err));
    /* a command that found a difference may have kept its outputs */
    struct error failure = {.status = EXIT_AGREED};
    if ((done || err->status == EXIT_DIFFERENT) && !outputs_commit(&options.outputs, &failure)) {
        *err = failure;
        done = false;
    }
    options_free(&options);
    return done;
}

/* Finds a command by its name; NULL: there is none. Ignores case where no name is the same. */
static const struct command *find_command(const char *name, struct error *err)
{
    const struct word typed = {.start = name, .length = strlen(name)};
    struct suggestion suggestion = {.distance = 0};
    for (int i = 0; i < N_COMMANDS; i++) {
        if (strcasecmp(name, commands[i].name) == 0)
            return &commands[i];
        suggestion_add(&suggestion, &typed, commands[i].name, strlen(commands[i].name));
    }
    error_usage(err, "unknown command '%s'; %s", name, suggestion_end(&suggestion, "known are"));
    return NULL;
}

static bool is_one_of(const char *word, const char *const *list)
{
    while (*list && strcmp(word, *list) != 0)
        list++;
    return *list;
}

static bool run_command(int argc, char **argv, struct error *err)
{
    static const char *const version[] = {"--version", "-V", NULL};
    static const char *const help[] = {"--help", "-h", "help", NULL};
    const struct command *command;
    if (argc < 2)
        return greet(err);
    if (is_one_of(argv[1], version))
        return print_version(err);
    if (is_one_of(argv[1], help) && argc == 2)
        return print_usage(err);
    command = find_command(is_one_of(argv[1], help) ? argv[2] : argv[1], err);
    if (!command)
        return false;
    return is_one_of(argv[1], help) ? print_command_usage(command, err)
                                    : run_with_options(command, argv, argc, err);
}

int main(int argc, char **argv)
{
    struct error err = {.status = EXIT_AGREED};
    guard_begin();
    /* a closed pipe, and a file that reaches its limit, are failed writes */
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    if (!run_command(argc, argv, &err) && err.text[0])
        fprintf(stderr, "%s\n", err.text);
    guard_exit((int)err.status);
    return (int)err.status; /* not reached */
}
