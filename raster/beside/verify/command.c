/* SPDX-License-Identifier: MIT */
/* spectral verify: the drivers and the scenes that are verified; one scene on one driver; all of
 * them, and the report. */
#include <stdlib.h>
#include <string.h>

#include "raster/beside/verify/inside.h"

struct verify_options {
    struct render_options render; /* the first member */
    const char *junit;
};

/* ---- drivers ---- */

/* An OpenGL that the options name is verified even where it cannot draw: each picture then fails.
 */
static bool find_drivers(const struct options *options, struct verification *out, struct error *err)
{
    const struct verify_options *own = options->own;
    const bool named = own->render.gl || own->render.renderer;
    struct driver_list found = {.n = 0};
    const bool done = named ? drivers_add(&found, own->render.gl ? own->render.gl : "auto",
                                          own->render.renderer, false, err)
                            : drivers_list(&found, err);
    out->drivers = found.list;
    for (int i = 0; i < found.n; i++)
        if (named || (found.list[i].usable && !found.list[i].again))
            out->drivers[out->n_drivers++] = found.list[i];
    return done && (out->n_drivers > 0 ||
                    error_unsupported(err, "no OpenGL can draw here; spectral drivers prints why"));
}

/* ---- scenes ---- */

/* The list owns a copy of the path. */
static bool add_scene(struct verification *to, const struct verify_scene *scene, const char *path,
                      struct error *err)
{
    struct verify_scene kept = *scene;
    if (!string_copy(path, &kept.path, err))
        return false;
    if (array_add(&to->scenes, &to->n_scenes, &kept, sizeof kept, err))
        return true;
    free(kept.path);
    return false;
}

/* Adds the built-in scenes that a word names, and then the hard cases: by their names, or all of
 * them by "hard"; NULL: names all. */
static bool add_builtin(struct verification *to, const char *word, struct error *err)
{
    char name[BUILTIN_NAME], path[sizeof BUILTIN_PREFIX + BUILTIN_NAME];
    for (size_t i = 0; i < 2 * builtin_file_count; i++) {
        const bool hard = i >= builtin_file_count;
        const struct builtin_file *file = &builtin_files[i % builtin_file_count];
        struct verify_scene scene = {.is_hard = hard, .is_large = !hard};
        if (!builtin_name(file, hard ? "hard/" : "scenes/", ".scene", name))
            continue;
        snprintf(scene.name, sizeof scene.name, "%s%.*s", hard ? "hard/" : "", BUILTIN_NAME - 6,
                 name);
        snprintf(path, sizeof path, "%s%s", BUILTIN_PREFIX, file->name);
        if ((!word || strcmp(word, scene.name) == 0 || (hard && strcmp(word, "hard") == 0)) &&
            !add_scene(to, &scene, hard ? path : name, err))
            return false;
    }
    return true;
}

/* Adds the scenes that a word names: built-in ones, or a file. */
static bool add_named(struct verification *to, const char *word, struct error *err)
{
    const int before = to->n_scenes;
    const size_t length = strlen(word);
    struct verify_scene scene = {.is_hard = false};
    if (!add_builtin(to, word, err))
        return false;
    if (to->n_scenes > before)
        return true;
    snprintf(scene.name, sizeof scene.name, "%s",
             length < sizeof scene.name ? word : word + length - sizeof scene.name + 1);
    return add_scene(to, &scene, word, err);
}

/* Finds the drivers and scenes that the options name; without any, all. verification_free accepts
 * what a failure left. */
static bool verification_open(const struct options *options, struct verification *out,
                              struct error *err)
{
    const int n_named = options->n_operands;
    *out = (struct verification){.n_drivers = 0};
    for (int i = 0; i < n_named; i++)
        if (!add_named(out, options->operands[i], err))
            return false;
    if ((n_named == 0 && !add_builtin(out, NULL, err)) || !find_drivers(options, out, err))
        return false;
    const size_t n = (size_t)out->n_drivers * (size_t)out->n_scenes;
    return MAKE_ARRAY(out->results, n, err, "the results of %zu pictures", n);
}

static void verification_free(struct verification *of)
{
    for (int i = 0; i < of->n_scenes; i++)
        free(of->scenes[i].path);
    FREE_ALL(of->drivers, of->scenes, of->results);
    *of = (struct verification){.n_drivers = 0};
}

const struct verify_result *result_of(const struct verification *of, int driver, int scene)
{
    return &of->results[(size_t)driver * (size_t)of->n_scenes + (size_t)scene];
}

struct totals totals_of(const struct verify_result *results, int n)
{
    struct totals totals = {.seconds = 0};
    for (int i = 0; i < n; i++) {
        totals.n[results[i].outcome]++;
        totals.seconds += results[i].seconds;
    }
    return totals;
}

/* ---- one scene on one driver ---- */

const char usual_size[] = "300x200", usual_wavelengths[] = "400:700:10";
const char *const verify_words[] = {"agreed", "differs", "not verified", "failed"};

struct task {
    const struct options *options;
    const struct listed_driver *driver;
    const struct verify_scene *scene;
};

/* Takes the verdict out of a render. */
static void take(const struct plan *plan, const struct render_result *result,
                 struct verify_result *out)
{
    struct error words = {.status = EXIT_AGREED};
    out->check = result->check;
    out->outcome = (int)check_outcome(&result->check);
    if (out->outcome == VERIFY_AGREED)
        return;
    report_disagreement(plan, &result->check, "", &words);
    snprintf(out->text, sizeof out->text, "%.1000s", error_words(&words));
}

/* The change comes before those of the command line, so that the user's win. */
static void put_first(struct options *options, struct option_change change)
{
    if (options->n_changes == MOST_RECORDED)
        return;
    memmove(options->changes + 1, options->changes,
            (size_t)options->n_changes * sizeof *options->changes);
    options->changes[0] = change;
    options->n_changes++;
}

static bool judge(void *context, void *out, struct error *err)
{
    const struct task *task = context;
    struct options options = *task->options;
    struct render_job job = {.limits = {false, 0}};
    const struct render_output nothing = {.limits = &job.limits};
    struct render_result result;
    const double start = clock_seconds();
    memset(out, 0, sizeof(struct verify_result));
    struct verify_options own = *(const struct verify_options *)task->options->own;
    own.render.gl = task->driver->library;
    own.render.renderer = task->driver->renderer;
    options.own = &own;
    options.operand = options.operands[0] = task->scene->path;
    options.n_operands = 1;
    if (task->scene->is_large) {
        put_first(&options, (struct option_change){scene_set_size, usual_size});
        put_first(&options, (struct option_change){scene_set_wavelengths, usual_wavelengths});
    }
    const bool done = job_read(&options, false, &job, err) && job_plan(&options, &job, err) &&
                      render(&job.plan, &nothing, NULL, &result, err);
    if (done)
        take(&job.plan, &result, out);
    job_free(&job);
    ((struct verify_result *)out)->seconds = clock_seconds() - start;
    return done;
}

/* Draws and judges a scene in a process of its own, which a driver may end. Fails where it is
 * interrupted, or the scene is wrong: every other failure is a result. */
static bool verify_run(struct task *task, struct verify_result *out, struct error *err)
{
    struct error own = {.status = EXIT_AGREED};
    if (process_run(judge, task, out, sizeof *out, &own))
        return true;
    if (own.status == EXIT_INPUT) {
        *err = own;
        return false;
    }
    *out = (struct verify_result){.outcome = VERIFY_FAILED};
    snprintf(out->text, sizeof out->text, "%.1000s", error_words(&own));
    return true;
}

/* ---- the runs ---- */

/* The options are those of the command. */
static bool run_all(const struct options *options, struct verification *of, struct error *err)
{
    struct progress_line line;
    const bool shown = progress_start(&line, options->quiet);
    const double start = clock_seconds();
    const int n = of->n_drivers * of->n_scenes;
    for (int i = 0; i < n; i++) {
        struct verify_result *result = &of->results[i];
        struct task task = {options, &of->drivers[i / of->n_scenes], &of->scenes[i % of->n_scenes]};
        if (!verify_run(&task, result, err))
            return false;
        if (shown)
            progress_show(&line, i + 1, n);
    }
    of->seconds = clock_seconds() - start;
    return true;
}

/* ---- the report ---- */

/* A driver that draws some scenes and fails at others differs from what it should do. */
static bool conclude(const struct verification *of, struct error *err)
{
    const int n = of->n_drivers * of->n_scenes;
    const struct totals totals = totals_of(of->results, n);
    const int failed = totals.n[VERIFY_FAILED],
              different = totals.n[VERIFY_DIFFERS] + totals.n[VERIFY_NOT_VERIFIED];
    const char *reason = "";
    for (int i = 0; i < n; i++)
        if (of->results[i].outcome == VERIFY_FAILED)
            reason = of->results[i].text;
    if (failed == n)
        return error_failed(err, "no picture could be drawn: %s", reason);
    if (failed > 0)
        return error_different(err,
                               "%d of %d pictures could not be drawn, and %d differ or are not "
                               "verified",
                               failed, n, different);
    return different == 0 ||
           error_different(err, "%d of %d pictures differ, or are not verified", different, n);
}

static bool report(const struct verification *of, struct options *options, struct error *err)
{
    const struct verify_options *own = options->own;
    struct printed table = {.text = NULL}, junit = {.text = NULL};
    struct json json;
    if (!options->quiet)
        verify_print(of, options, &table);
    if (!printed_show(&table, options_table(options, own->junit), err))
        return false;
    if (options->json) {
        verify_json(of, &json);
        if (!json_write(&json, options->json, &options->outputs, err))
            return false;
    }
    if (own->junit)
        verify_junit(of, &junit);
    return (!own->junit || printed_write(&junit, own->junit, &options->outputs, err)) &&
           conclude(of, err);
}

/* ---- the command ---- */

static bool run_verify(struct options *options, struct error *err)
{
    const struct verify_options *own = options->own;
    struct verification of = {.n_drivers = 0};
    if (own->render.renderer && strcmp(own->render.renderer, "raster") == 0)
        return error_usage(err,
                           "the reference needs no verification; --renderer is that of OpenGL");
    const bool done = verification_open(options, &of, err) && run_all(options, &of, err) &&
                      report(&of, options, err);
    verification_free(&of);
    return done;
}

static const struct option verify_rows[] = {
    {"--junit FILE", "writes the results as JUnit's XML; - is standard output",
     OWN(TEXT, verify_options, junit), .writes = true},
};
const struct command verify_command = {
    .name = "verify",
    .operands = "[SCENE...]",
    .summary = "judge OpenGL's drivers by built-in scenes and hard cases",
    .example = "verify --gl egl --junit verify.xml",
    .run = run_verify,
    .rows = OPTION_LIST(verify_rows),
    .shared = {&scene_options, &renderer_options, &library_option, &judged_options, &threads_option,
               &json_option, &quiet_option},
    .own_size = sizeof(struct verify_options),
    .n_operands = MOST_OPERANDS,
};
