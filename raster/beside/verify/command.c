/* SPDX-License-Identifier: MIT */
/* spectral verify: the drivers and the scenes that are verified; one scene on one driver; all of
 * them, and the report. */
#include <fnmatch.h>
#include <unistd.h>

#include "raster/beside/verify/inside.h"

struct verify_options {
    struct render_options render; /* the first member */
    const char *junit, *expect;
    double limit;
    bool list;
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

/* Adds the built-in scenes that a pattern of a shell names, and then the hard cases; "hard" names
 * all of these. */
static bool add_builtin(struct verification *to, const char *pattern, struct error *err)
{
    for (size_t i = 0; i < 2 * builtin_file_count; i++) {
        const bool is_hard = i >= builtin_file_count;
        struct verified_scene scene = {.kind = is_hard ? VERIFIED_HARD : VERIFIED_BUILTIN};
        if (builtin_is(&builtin_files[i % builtin_file_count], FILE_SCENE, scene.name) &&
            (is_hard ? strncmp(scene.name, "hard/", 5) == 0 : !strchr(scene.name, '/')) &&
            (fnmatch(pattern, scene.name, 0) == 0 || (is_hard && strcmp(pattern, "hard") == 0)) &&
            !array_add(&to->scenes, &to->n_scenes, &scene, sizeof scene, err))
            return false;
    }
    return true;
}

/* Adds the scenes that a word names: built-in ones, or a file. */
static bool add_named(struct verification *to, const char *word, struct error *err)
{
    const int before = to->n_scenes;
    const size_t length = strlen(word);
    struct verified_scene scene = {.path = word, .kind = VERIFIED_FILE};
    if (!add_builtin(to, word, err))
        return false;
    if (to->n_scenes > before)
        return true;
    if (!file_expected(word, NOWHERE, FILE_SCENE, err))
        return false;
    snprintf(scene.name, sizeof scene.name, "%s",
             length < sizeof scene.name ? word : word + length - sizeof scene.name + 1);
    return array_add(&to->scenes, &to->n_scenes, &scene, sizeof scene, err);
}

/* Finds the scenes that the options name; without any, all. verification_free accepts what a
 * failure left. */
static bool find_scenes(const struct options *options, struct verification *out, struct error *err)
{
    bool done = options->n_operands > 0 || add_builtin(out, "*", err);
    for (int i = 0; i < options->n_operands && done; i++)
        done = add_named(out, options->operands[i], err);
    for (int i = 0; i < out->n_scenes; i++)
        if (out->scenes[i].kind != VERIFIED_FILE)
            out->scenes[i].path = out->scenes[i].name;
    return done;
}

/* Names the model, where Linux does, as on x86; "": it does not. */
static void name_processor(char *out, size_t capacity)
{
    struct error err = {.status = EXIT_AGREED};
    char *text = file_read("/proc/cpuinfo", NOWHERE, &err);
    const char *line = text ? strstr(text, "model name") : NULL,
               *name = line ? strchr(line, ':') : NULL;
    snprintf(out, capacity, "%.*s", name ? (int)strcspn(name + 2, "\n") : 0, name ? name + 2 : "");
    free(text);
}

/* Reads the files of a scene before any driver can end the process that draws it. */
static bool read_files(const struct options *options, const struct verified_scene *of,
                       struct error *err)
{
    struct options alone = *options;
    struct scene scene;
    alone.operand = alone.operands[0] = of->path;
    alone.n_operands = 1;
    const bool done = scene_read_options(&alone, &scene, err) && job_read_files(&scene, err);
    scene_free(&scene);
    return done;
}

/* Finds the drivers, and what an earlier report says of them. Any scene has the files that options
 * name. */
static bool verification_open(const struct options *options, struct verification *out,
                              struct error *err)
{
    const struct verify_options *own = options->own;
    for (int i = 0; i < out->n_scenes; i++)
        if ((i == 0 || out->scenes[i].kind == VERIFIED_FILE) &&
            !read_files(options, &out->scenes[i], err))
            return false;
    if (!options_check_outputs(options, err) || !find_drivers(options, out, err))
        return false;
    name_processor(out->processor, sizeof out->processor);
    const size_t n = (size_t)out->n_drivers * (size_t)out->n_scenes;
    return MAKE_ARRAY(out->results, n, err, "the results of %zu pictures", n) &&
           (!own->expect || expect_read(own->expect, out, err));
}

static bool print_scenes(const struct verification *of, struct error *err)
{
    struct printed names = {.text = NULL};
    for (int i = 0; i < of->n_scenes; i++)
        print(&names, "%s\n", of->scenes[i].name);
    return printed_show(&names, STDOUT_FILENO, err);
}

static void verification_free(struct verification *of)
{
    FREE_ALL(of->drivers, of->scenes, of->results);
    *of = (struct verification){.n_drivers = 0};
}

struct verify_result *result_of(const struct verification *of, int driver, int scene)
{
    return &of->results[driver * of->n_scenes + scene];
}

/* An outcome's place, from the best to the worst. */
static int badness(int outcome)
{
    static const int places[VERIFY_OUTCOMES] = {
        [OUTCOME_NOT_VERIFIED] = 1, [OUTCOME_DIFFERS] = 2, [VERIFY_FAILED] = 3};
    return places[outcome];
}

int change_of(const struct verify_result *result)
{
    return badness(result->expected) - badness(result->outcome);
}

struct totals totals_of(const struct verify_result *results, int n)
{
    struct totals totals = {.seconds = 0};
    for (int i = 0; i < n; i++) {
        totals.n[results[i].outcome]++;
        totals.worse += change_of(&results[i]) < 0;
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
    const struct verified_scene *scene;
};

/* Takes the verdict out of a render. */
static void take(const struct plan *plan, const struct render_result *result,
                 struct verify_result *out)
{
    struct error words = {.status = EXIT_AGREED};
    out->check = result->check;
    out->outcome = (int)check_outcome(&result->check);
    if (out->outcome == OUTCOME_AGREED)
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

/* A hard case keeps its size: a picture of another one may lack what makes it hard. */
static void keep_size(struct options *options)
{
    int n = 0;
    for (int i = 0; i < options->n_changes; i++)
        if (options->changes[i].apply != scene_set_size)
            options->changes[n++] = options->changes[i];
    options->n_changes = n;
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
    if (task->scene->kind == VERIFIED_HARD)
        keep_size(&options);
    else if (task->scene->kind == VERIFIED_BUILTIN) {
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

/* Draws and judges a scene in a process of its own, which a driver may end. Fails where the scene
 * is wrong: every other failure is a result. */
static bool verify_run(struct task *task, struct verify_result *out, struct error *err)
{
    const struct verify_options *own = task->options->own;
    const double start = clock_seconds();
    const int expected = out->expected;
    struct error failure = {.status = EXIT_AGREED};
    bool done = false;
    if (task->driver->usable)
        done = process_run(judge, task, out, sizeof *out, (unsigned)own->limit, &failure);
    if (!done) {
        *out = (struct verify_result){.outcome = VERIFY_FAILED, .seconds = clock_seconds() - start};
        snprintf(out->text, sizeof out->text, "%.1000s",
                 task->driver->usable ? error_words(&failure) : task->driver->reason);
    }
    out->expected = expected;
    if (failure.status == EXIT_INPUT)
        *err = failure;
    return failure.status != EXIT_INPUT;
}

/* ---- the runs, and the report ---- */

/* Shows lines as soon as they are known; quiet: drops them. */
static bool show(const struct options *options, struct printed *lines, struct error *err)
{
    const struct verify_options *own = options->own;
    struct printed known = *lines;
    *lines = (struct printed){.text = NULL};
    if (options->quiet)
        free(printed_end(&known));
    return options->quiet || printed_show(&known, options_table(options, own->junit), err);
}

static bool run_driver(const struct options *options, struct verification *of, int driver,
                       struct error *err)
{
    struct printed lines = {.text = NULL};
    bool done = true;
    verify_head(of, driver, &lines);
    for (int i = 0; i < of->n_scenes && done; i++) {
        struct task task = {options, &of->drivers[driver], &of->scenes[i]};
        done = show(options, &lines, err) && verify_run(&task, result_of(of, driver, i), err);
        if (done)
            verify_line(of, driver, i, &lines);
    }
    verify_sum(of, driver, &lines);
    return done && show(options, &lines, err);
}

/* Fails where a picture does not agree, or is worse than an earlier report has it. */
static bool conclude(const struct verification *of, const char *expect, struct error *err)
{
    const int n = of->n_drivers * of->n_scenes;
    const struct totals totals = totals_of(of->results, n);
    return totals.worse == 0 ||
           error_different(err, "%d of %d pictures %s%s", totals.worse, n,
                           expect                        ? "are worse than in "
                           : totals.n[VERIFY_FAILED] > 0 ? "could not be drawn, differ, or are "
                                                           "not verified"
                                                         : "differ, or are not verified",
                           expect ? expect : "");
}

static bool report(const struct verification *of, struct options *options, struct error *err)
{
    const struct verify_options *own = options->own;
    struct printed lines = {.text = NULL}, junit = {.text = NULL};
    struct json json;
    verify_end(of, options, &lines);
    if (!show(options, &lines, err))
        return false;
    if (options->json) {
        verify_json(of, &json);
        if (!json_write(&json, options->json, &options->outputs, err))
            return false;
    }
    if (own->junit)
        verify_junit(of, &junit);
    return (!own->junit || printed_write(&junit, own->junit, &options->outputs, err)) &&
           conclude(of, own->expect, err);
}

/* ---- a page ---- */

/* Writes a page that verifies the scenes where it is opened. */
static bool write_page(struct options *options, const struct verification *of, struct error *err)
{
    const struct verify_options *own = options->own;
    if (!has_live_pages())
        return error_usage(err, "--page needs a program that holds itself for browsers; "
                                "./build.sh live makes one");
    if (own->render.gl || own->render.renderer || own->render.buffer || own->junit || own->expect ||
        own->list || options->json)
        return error_usage(err, "--page draws nothing here, by the GPU of the browser that opens "
                                "it; it takes scenes and their options, --strict and --unchecked");
    return verifier_write(options, of->scenes, of->n_scenes, err) &&
           options_show_output(options, "page", options->output, err);
}

/* ---- the command ---- */

static bool run_verify(struct options *options, struct error *err)
{
    const struct verify_options *own = options->own;
    struct verification of = {.n_drivers = 0};
    if (own->render.renderer && strcmp(own->render.renderer, "raster") == 0)
        return error_usage(err,
                           "the reference needs no verification; --renderer is that of OpenGL");
    if (own->list && (options->json || own->junit))
        return error_usage(err, "--list draws nothing, and has no report to write");
    bool done = find_scenes(options, &of, err);
    if (done && options->output)
        done = write_page(options, &of, err);
    else if (done && own->list)
        done = print_scenes(&of, err);
    else if (done) {
        const double start = clock_seconds();
        done = verification_open(options, &of, err);
        for (int i = 0; i < of.n_drivers && done; i++)
            done = run_driver(options, &of, i, err);
        of.seconds = clock_seconds() - start;
        done = done && report(&of, options, err);
    }
    verification_free(&of);
    return done;
}

static const struct option verify_rows[] = {
    {"--junit FILE", "writes the results as JUnit's XML; - is standard output",
     OWN(TEXT, verify_options, junit), .writes = true},
    {"--expect OLD.json", "fails only where a picture is worse than in this report of --json",
     OWN(TEXT, verify_options, expect)},
    {"--limit SECONDS", "gives up a picture after this time (default: 120)",
     OWN(NUMBER, verify_options, limit), .lowest = 1, .highest = 1e6},
    {"--page PAGE.html",
     "writes a page that verifies the GPU of the browser that opens it, and draws nothing",
     SHARED(TEXT, output), .writes = true},
    {"--list", "prints the names of the scenes, and draws none", OWN(FLAG, verify_options, list)},
};
const struct command verify_command = {
    .name = "verify",
    .operands = "[SCENE | PATTERN...]",
    .summary = "judge OpenGL's drivers by built-in scenes and hard cases",
    .example = "verify --gl egl --junit verify.xml",
    .run = run_verify,
    .rows = OPTION_LIST(verify_rows),
    .shared = {&scene_options, &renderer_options, &library_option, &judged_options, &threads_option,
               &json_option, &quiet_option},
    .own_size = sizeof(struct verify_options),
    .n_operands = MOST_OPERANDS,
};
