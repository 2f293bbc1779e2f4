/* SPDX-License-Identifier: MIT */
/* spectral export and spectral judge. Both plan the scene as spectral render does; judge reads its
 * name and the options from the exported folder. A driver that is not known is measured by its
 * pixels of the targets: the narrowest bounds that these keep. */
#include <limits.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "raster/beside/verify/inside.h"

/* ---- the targets ---- */

const char targets_prefix[] = "targets-";

/* Reads and plans the scene of the targets. The caller frees the job, also after a failure. */
static bool plan_targets(struct render_job *job, struct error *err)
{
    struct options options = {.operand = NULL};
    bool done = options_read(&export_command, true, NULL, 0, &options, err);
    options.operand = BUILTIN_PREFIX "targets/targets.scene";
    done = done && job_read(&options, true, job, err) && job_plan(&options, job, err);
    options_free(&options);
    return done;
}

/* Pixels of the targets, and how they were judged last. */
struct targets {
    struct render_job job;
    struct foreign_pixels pixels;
    struct render_result result;
};

/* Finds whether the targets are what this driver may draw. */
static bool try_driver(struct targets *of, const struct driver *driver, bool *agrees,
                       struct error *err)
{
    const struct render_foreign foreign = {.open = drawn_open, .of = &of->pixels};
    const struct render_output output = {.foreign = &foreign, .limits = &of->job.limits};
    of->pixels.driver = driver;
    if (!render(&of->job.plan, &output, NULL, &of->result, err))
        return false;
    *agrees = check_outcome(&of->result.check) != OUTCOME_DIFFERS;
    return true;
}

/* Traits of a driver, from the narrowest value to the widest that OpenGL 2.1 allows, or, of
 * filters, that bounds can cover: see raster/beside/measure. A single operation may be off by 1 in
 * 10^5, which is 168 roundings. */
enum { TRAITS = 6, VALUES = 6 };
static const struct {
    size_t place;
    double values[VALUES];
} traits[TRAITS] = {
    {offsetof(struct driver, grid_px), {0x1p-9, 0x1p-8, 0x1p-7, 0x1p-6, 0x1p-5, 0x1p-4}},
    {offsetof(struct driver, corner_px), {0, 0x1p-8, 0x1p-7, 0x1p-6, 0x1p-5, 0x1p-4}},
    {offsetof(struct driver, value_roundings), {5, 10, 20, 40, 80, 160}},
    {offsetof(struct driver, depth_roundings), {1, 1.5, 2, 2, 2, 2}},
    {offsetof(struct driver, filter_texels), {0, 0x1p-8, 0x1p-7, 0x1p-6, 0x1p-5, 0x1p-4}},
    {offsetof(struct driver, lighting), {1, 2, 4, 8, 16, 16}},
};

static void set_trait(struct driver *driver, int trait, int value)
{
    memcpy((char *)driver + traits[trait].place, &traits[trait].values[value],
           sizeof traits[trait].values[value]);
}

/* Narrows each trait, all others as they are, as far as the targets agree. */
static bool narrow(struct targets *of, struct driver *driver, struct error *err)
{
    for (int t = 0; t < TRAITS; t++) {
        bool agrees = false;
        for (int v = 0; v < VALUES && !agrees; v++) {
            set_trait(driver, t, v);
            if (!try_driver(of, driver, &agrees, err))
                return false;
        }
    }
    /* The targets may not show the largest error there is. One of n roundings, each as likely to be
     * any, exceeds a part 1 - d of its bound in (n d / 2)^n / n! of all samples: for n up to 16 it
     * comes to 0.59 of it, in 10^5 of them. Twice the seen error is enough. */
    driver->value_roundings *= driver->value_roundings > 5 ? 2 : 1;
    driver->lighting *= driver->lighting > 1 ? 2 : 1;
    driver->watertight = true;
    return try_driver(of, driver, &driver->watertight, err);
}

bool targets_measure(const char *folder, struct driver *out, struct error *err)
{
    struct targets of = {.pixels = {folder, targets_prefix, NULL}};
    struct error words = {.status = EXIT_AGREED};
    bool agrees = false;
    *out = *driver_of(NULL);
    out->name = "measured by its targets";
    out->is_measured = true;
    for (int t = 0; t < TRAITS; t++)
        set_trait(out, t, VALUES - 1);
    bool done = plan_targets(&of.job, err) && try_driver(&of, out, &agrees, err);
    if (done && !agrees) {
        report_disagreement(&of.job.plan, &of.result.check, NULL, &words);
        done = error_failed(err,
                            "the driver cannot be checked: its targets differ by more than OpenGL "
                            "leaves free: %.600s",
                            error_words(&words));
    }
    done = done && narrow(&of, out, err);
    job_free(&of.job);
    return done;
}

/* Finds the rule that leaves least of the targets, as a sum of squares: its corner, then its norm
 * and logarithm, and the corner again. A driver that is known by its name has a norm and a
 * logarithm. Bounds are wide meanwhile. */
static bool find_rule(struct targets *of, struct driver *driver, struct error *err)
{
    const int corners = 8, kinds = DETAIL_RULES / corners; /* of detail_rule's numbers */
    int best = corners * (driver->detail.largest + 2 * (int)driver->detail.logarithm);
    double least = HUGE_VAL;
    driver->detail_error = -1;
    for (int round = 0; round < (driver->is_measured ? 3 : 1); round++) {
        const int from = best;
        for (int k = 0; k < (round == 1 ? kinds : corners); k++) {
            const int i = round == 1 ? from % corners + corners * k : from - from % corners + k;
            bool agrees;
            driver->detail = detail_rule(i);
            if (!try_driver(of, driver, &agrees, err))
                return false;
            if (of->result.check.samples.sum_of_squares < least) {
                least = of->result.check.samples.sum_of_squares;
                best = i;
            }
        }
    }
    driver->detail = detail_rule(best);
    return true;
}

/* A known driver follows its own rule. Another one may be off it by twice the first of these with
 * which the targets agree: the error of a logarithm that is made of parabolas, or of steps, is half
 * as large as its largest in at least half of each piece. */
static bool find_detail(struct targets *of, struct driver *driver, struct error *err)
{
    static const double errors[] = {0.006, 0.02};
    bool agrees = !driver->is_measured;
    double error = 0;
    if (!find_rule(of, driver, err))
        return false;
    for (size_t i = 0; i < sizeof errors / sizeof *errors && !agrees; i++) {
        driver->detail_error = errors[i];
        if (!try_driver(of, driver, &agrees, err))
            return false;
        error = 2 * errors[i];
    }
    driver->detail_error = agrees ? error : -1;
    return true;
}

bool targets_detail(const char *folder, struct driver *out, struct error *err)
{
    struct targets of = {.pixels = {folder, targets_prefix, NULL}};
    const bool done = plan_targets(&of.job, err) && find_detail(&of, out, err);
    job_free(&of.job);
    return done;
}

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
                      job_plan(options, &job, err) && plan_targets(&targets, err) &&
                      export_plans(&job.plan, &targets.plan, words, options->output, err) &&
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
    struct foreign_pixels drawn = {pixels, "", NULL};
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
    return render_with_options(exported, &output, NULL, err);
}

static bool run_judge(struct options *options, struct error *err)
{
    const int n = options->n_operands;
    struct options exported = {.operand = NULL};
    const char *words[EXPORTED_WORDS];
    int n_words;
    if (n == 0)
        return error_usage(err, "judge needs FOLDER, which export wrote and another program drew "
                                "into; PIXELS may lie in another folder");
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
static const struct option_list export_list = OPTION_LIST(export_rows);
static const struct option_list *const export_lists[] = {
    &export_list,      &scene_options,    &shading_options,
    &accuracy_options, &sampling_options, &scale_option,
    &threads_option,   &common_options,   NULL};
const struct command export_command = {
    .name = "export",
    .operands = "[SCENE] -o FOLDER",
    .summary = "write a scene as plain files, for another program to draw",
    .example = "export room -o room",
    .run = run_export,
    .lists = export_lists,
    .own_size = sizeof(struct render_options),
    .n_operands = 1,
};

static const struct option_list *const judge_lists[] = {
    &judged_options, &map_option,   &threads_option, &json_option,
    &verbose_option, &quiet_option, &common_options, NULL};
const struct command judge_command = {
    .name = "judge",
    .operands = "FOLDER [PIXELS]",
    .summary = "judge what another program drew from an export",
    .example = "judge room",
    .run = run_judge,
    .lists = judge_lists,
    .own_size = sizeof(struct render_options),
    .n_operands = 2,
};
