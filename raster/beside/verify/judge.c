/* SPDX-License-Identifier: MIT */
/* spectral export and spectral judge. Both plan the scene as spectral render does; judge reads its
 * name and the options from the exported folder. */
#include <limits.h>

#include "raster/beside/verify/inside.h"

/* ---- the options of export ---- */

enum { EXPORTED_WORDS = 1 + MOST_RECORDED };

/* Prints the scene, and each option as options_read takes it, in lines. Refuses a line break in
 * them: the rest would be read as another option. */
static bool print_exported(const struct options *options, struct printed *to, struct error *err)
{
    const char *scene = options_scene(options);
    char path[PATH_MAX];
    bool found = false; /* a folder may have the name of a built-in scene, as that of an export */
    if (!scene_is_input(scene) && !file_is_regular(scene, &found, err))
        return false;
    if (found && !realpath(scene, path))
        return error_system(err, "cannot find the folder of %s", scene);
    print(to, "%s\n", found ? path : scene);
    bool broken = strchr(found ? path : scene, '\n') != NULL;
    for (int i = 0; i < options->n_recorded; i++) {
        broken = broken || strchr(options->recorded[i], '\n');
        print(to, "%s\n", options->recorded[i]);
    }
    return !broken || error_usage(err, "a name with a line break cannot be exported");
}

/* Reads these lines; the words point into the text, which is returned. */
static char *read_exported(const char *folder, const char *words[EXPORTED_WORDS], int *n,
                           struct error *err)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%.4000s/exported.txt", folder);
    char *text = file_read(path, NOWHERE, err), *at = text;
    for (*n = 0; at && *at && *n < EXPORTED_WORDS; (*n)++) {
        words[*n] = at;
        at += strcspn(at, "\n");
        if (*at)
            *at++ = '\0';
    }
    if (text && (*n == 0 || scene_is_input(words[0]) || *at))
        error_usage(err, "%s names no scene, or too many options; export a scene from a file",
                    path);
    else if (text)
        return text;
    free(text);
    return NULL;
}

/* ---- spectral export ---- */

static bool run_export(struct options *options, struct error *err)
{
    struct render_job job = {.limits = {false, 0}}, targets = {.limits = {false, 0}};
    struct printed lines = {.text = NULL};
    if (!options->output)
        return error_usage(err, "export needs -o FOLDER");
    const bool prints = print_exported(options, &lines, err);
    char *words = printed_take(&lines, err);
    const bool done = prints && words && job_read(options, true, &job, err) &&
                      job_plan(options, &job, err) && targets_plan(NULL, true, &targets, err) &&
                      export_plans(&job.plan, &targets.plan, words, options, err) &&
                      options_show_output(options, "folder", options->output, err);
    free(words);
    job_free(&targets);
    job_free(&job);
    return done;
}

/* ---- spectral judge ---- */

/* Takes all that decides the picture from export's options, and how to judge it from judge's. */
static bool judge_pixels(struct options *options, struct options *exported, const char *pixels,
                         struct error *err)
{
    const struct render_options *own = options->own;
    struct foreign_pixels drawn = {.path = pixels, .prefix = ""};
    struct printed numbers = {.text = NULL};
    const struct render_foreign foreign = {.open = drawn_open, .of = &drawn};
    const struct render_output output = {
        .check_map = own->check_map, .outputs = &options->outputs, .foreign = &foreign};
    struct render_options *made = exported->own;
    const double full_scale = made->full_scale;
    *made = *own;
    made->full_scale = full_scale;
    exported->json = options->json;
    exported->threads = options->threads;
    exported->quiet = options->quiet;
    exported->verbose = options->verbose;
    const bool done = render_with_options(exported, &output, NULL, err);
    if (!drawn.driver.is_measured || !options->verbose)
        return done;
    print_text(&numbers, "driver            ");
    traits_numbers(&drawn.driver, &numbers);
    return printed_show(&numbers, options_table(options, NULL), err) && done;
}

static bool run_judge(struct options *options, struct error *err)
{
    const int n = options->n_operands;
    struct options exported = {.operand = NULL};
    const char *words[EXPORTED_WORDS];
    int n_words;
    char *text = read_exported(options->operands[0], words, &n_words, err);
    bool done = text &&
                options_read(&export_command, true, words + 1, n_words - 1, &exported, err) &&
                (!exported.operand || error_usage(err, "%s/exported.txt: '%.100s' is no option",
                                                  options->operands[0], exported.operand));
    exported.operand = done ? words[0] : NULL;
    done = done && judge_pixels(options, &exported, options->operands[n - 1], err);
    options_free(&exported);
    free(text);
    return done;
}

/* ---- the commands ---- */

static const struct option export_rows[] = {
    {"-o, --output FOLDER", "writes the files into this new folder", SHARED(TEXT, output),
     .writes = true},
};
const struct command export_command = {
    .name = "export",
    .operands = "[SCENE] -o FOLDER",
    .summary = "write a scene as plain files, for another program to draw",
    .example = "export patches -o patches",
    .run = run_export,
    .rows = OPTION_LIST(export_rows),
    .shared = {&scene_options, &shading_options, &accuracy_options, &sampling_options,
               &scale_option, &threads_option},
    .own_size = sizeof(struct render_options),
    .n_operands = 1,
};

const struct command judge_command = {
    .name = "judge",
    .operands = "FOLDER [PIXELS]",
    .summary = "judge what another program drew from an export",
    .example = "judge patches",
    .run = run_judge,
    .shared = {&judged_options, &map_option, &threads_option, &json_option, &verbose_option,
               &quiet_option},
    .own_size = sizeof(struct render_options),
    .n_operands = 2,
};
