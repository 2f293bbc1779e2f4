/* SPDX-License-Identifier: MIT */
/* Fuzz target: a command line, each word of it on a line of the input; the first is the command.
 * The commands are those of the program. No command is run: it could replace any file. */
#include <stdlib.h>
#include <string.h>

int spectral_main(int argc, char **argv);
#define main spectral_main
#include "data/scene/scene.h"
#include "data/stack/stack.h"
#include "data/text/text.h"
#include "spectral.c"
#include "test/fuzz/fuzz.h"
#undef main

enum { MOST_WORDS = 64 };

/* Makes the changes of the scene that the options ask for. */
static void change_scene(struct options *options)
{
    struct error err = {.status = EXIT_AGREED};
    struct scene scene = {.path = NULL};
    options->operand = "patches";
    fuzz_ends(scene_read_options(options, &scene, &err), &err);
    scene_free(&scene);
}

/* Returns whether the command changes scenes. */
static bool changes_scenes(const struct command *command)
{
    const struct option_list *const *list = command->shared;
    while (*list && *list != &scene_options)
        list++;
    return *list != NULL;
}

static void read_words(const struct command *command, char *const *words, int n_words)
{
    struct error err = {.status = EXIT_AGREED};
    struct options options;
    if (fuzz_ends(options_read(command, false, (const char *const *)words, n_words, &options, &err),
                  &err) &&
        changes_scenes(command))
        change_scene(&options);
    options_free(&options);
}

void fuzz_line(const struct fuzz_input *input)
{
    struct error err = {.status = EXIT_AGREED};
    char *line = strdup(input->bytes), *words[MOST_WORDS], *at = line;
    int n = 0;
    if (line == NULL)
        return;
    while (at != NULL && n < MOST_WORDS) {
        words[n++] = at;
        at = strchr(at, '\n');
        if (at != NULL)
            *at++ = '\0';
    }
    const struct command *command = find_command(words[0], &err);
    if (fuzz_ends(command != NULL, &err))
        read_words(command, words + 1, n - 1);
    free(line);
}
