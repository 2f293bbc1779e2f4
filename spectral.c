/* SPDX-License-Identifier: MIT */
/* The command line: help, and main. Only main prints errors and exits. Each command is in the room
 * of its subject; raster/beside/ has the tables of them. */
#include <signal.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "data/base/base.h"
#include "data/files/files.h"
#include "data/stack/stack.h"
#include "data/text/text.h"
#include "raster/renderers/renderers.h"
#include "spectral.h"

/* ---- help ---- */

static const char scene_operand[] =
    "SCENE is a scene file, a list of material files, a built-in scene (default:\n"
    "colorchecker), or - for standard input.\n";

static bool print_usage(struct error *err)
{
    struct printed printed = {.text = NULL}, *to = &printed;
    print(to,
          "usage: spectral COMMAND [SCENE] [OPTIONS]\n\n"
          "Renders a 3D scene wavelength by wavelength %s\n\n",
          drawing_ways.library
              ? "through OpenGL, cross-checks every\n"
                "pixel of every wavelength against its own rasterizer, and writes a TIFF stack."
              : "by its own rasterizer, and writes a\n"
                "TIFF stack. This program was built without OpenGL, and cross-checks nothing.");
    for (int i = 0; commands[i]; i++)
        print(to, "  %-8s %s\n", commands[i]->name, commands[i]->summary);
    print(to, "\n%s\n", scene_operand);
    print_text(to, "spectral COMMAND --help explains a command and lists its options.\n"
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
    help_options(command, to);
    print(to, "\nexample:\n  spectral %s\n", command->example);
    return printed_show(to, STDOUT_FILENO, err);
}

/* The answer to the name of the program alone. It ends as bad usage does, for scripts. */
static bool greet(struct error *err)
{
    struct printed printed = {.text = NULL};
    print(&printed, "spectral renders 3D scenes wavelength by wavelength%s.\n\n",
          drawing_ways.library ? ", and checks every pixel" : " by its own rasterizer");
    for (int i = 0; commands[i]; i++)
        if (commands[i]->first)
            print(&printed, "  spectral %-27s  %s\n", commands[i]->example, commands[i]->first);
    print_text(&printed,
               "\nspectral list prints what is built in. spectral COMMAND --help explains a\n"
               "command, spectral --help all of them, man spectral the scene language.\n");
    if (printed_show(&printed, STDOUT_FILENO, err))
        err->status = EXIT_INPUT;
    return false;
}

static bool print_version(struct error *err)
{
    struct printed printed = {.text = NULL};
    char gl[1024];
    const char *tiff = stack_library();
    snprintf(gl, sizeof gl, "without OpenGL");
    if (drawing_ways.library)
        drawing_ways.library(gl, sizeof gl);
    print(&printed, "spectral %s\n%s\n%.*s\n", SPECTRAL_VERSION, gl, (int)strcspn(tiff, "\n"),
          tiff);
    return printed_show(&printed, STDOUT_FILENO, err);
}

/* ---- main ---- */

/* The words are those of the whole command line. */
static bool run_with_options(const struct command *command, char *const *words, int n_words,
                             struct error *err)
{
    struct options options;
    bool done =
        options_read(command, false, (const char *const *)words + 2, n_words - 2, &options, err);
    options.program = words[0];
    if (done && !options.help)
        options_limit_memory(&options);
    done = done && (options.help ? print_command_usage(command, err) : command->run(&options, err));
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
    bool missing;
    for (int i = 0; commands[i]; i++) {
        if (strcasecmp(name, commands[i]->name) == 0)
            return commands[i];
        suggestion_add(&suggestion, &typed, commands[i]->name, strlen(commands[i]->name));
    }
    if (scene_is_missing(name, &missing, err) && !missing)
        error_usage(err,
                    "'%s' is no command; expected one before it: spectral render SCENE, "
                    "spectral info STACK, ...",
                    name);
    error_usage(err, "unknown command '%s'; %s", name, suggestion_end(&suggestion, "known are"));
    return NULL;
}

static bool run_command(int argc, char **argv, struct error *err)
{
    const char *name = argc > 1 ? argv[1] : "";
    const bool help =
        strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || strcmp(name, "help") == 0;
    if (!builtin_unpack(err))
        return false;
    if (argc < 2)
        return greet(err);
    if (strcmp(name, "--version") == 0 || strcmp(name, "-V") == 0)
        return print_version(err);
    if (help && argc == 2)
        return print_usage(err);
    const struct command *command = find_command(help ? argv[2] : name, err);
    if (!command)
        return false;
    return help ? print_command_usage(command, err) : run_with_options(command, argv, argc, err);
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
