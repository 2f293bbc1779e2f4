/* SPDX-License-Identifier: MIT */
/* Renders the scene in each configuration, by running this program as a user's command line does,
 * and measures how far its stack is off. */
#include <unistd.h>

#include "raster/beside/cost/inside.h"

/* Samplings that are tried, from few pages to many. A scene refuses some: spectral textures have no
 * components. */
static const char *const samplings[] = {
    "--sampling=rgb",       "--sampling=basis:4",    "--sampling=basis:8",
    "--sampling=gauss:8",   "--sampling=riemann:40", "--sampling=adaptive:0.1",
    "--sampling=gauss:16",  "--sampling=riemann:20", "--sampling=adaptive:0.01",
    "--sampling=gauss:24",  "--sampling=riemann:10", "--sampling=adaptive:0.001",
    "--sampling=riemann:5", "--sampling=riemann:2"};
enum { N_COMPONENTS = 3, N_SAMPLINGS = sizeof samplings / sizeof samplings[0] };

static const char every_nm[] = "--sampling=riemann:1";
static const char alone[] = " --renderer=raster --no-check"; /* the reference */

enum { STANDARD, STACK, FINEST, N_STACKS }; /* files */
enum { FEWEST_RUNS = 3, WORDS_LENGTH = 5 * RENDER_WORDS };

struct measurement {
    const struct options *options;
    struct cost *cost;
    struct scene scene; /* as the command line changes it */
    struct folder folder;
    char stacks[N_STACKS][sizeof(struct folder) + 16];
    struct seen_stack standard;
    struct progress_line line;
    bool shown;           /* the line of progress */
    double begun, likely; /* seconds by the clock */
};

/* ---- times ---- */

static void timing_add(struct timing *to, double seconds)
{
    int at = to->n++;
    for (; at > 0 && to->seconds[at - 1] > seconds; at--)
        to->seconds[at] = to->seconds[at - 1];
    to->seconds[at] = seconds;
}

/* A command line that takes long is not run again: its seconds scatter less. */
static bool is_long(const struct timing *of)
{
    return of->n > 0 && of->seconds[0] > 1;
}

double median_of(const struct timing *of)
{
    return of->n == 0 ? (double)NAN : (of->seconds[(of->n - 1) / 2] + of->seconds[of->n / 2]) / 2;
}

/* ---- a run ---- */

/* Takes over an error as a note behind the words that it is about. */
static bool add_note(struct cost *cost, const char *words, const struct error *why,
                     struct error *err)
{
    struct printed text = {.text = NULL};
    print(&text, "%s: %s", words, error_words(why));
    char *note = printed_take(&text, err);
    if (note && array_add(&cost->notes, &cost->n_notes, &note, sizeof note, err))
        return true;
    free(note);
    return false;
}

/* Shows how much of the likely time has passed. A picture that is not agreed has its price, too. A
 * failure that names a temporary file is for want of room. */
static bool conclude(struct measurement *of, struct error *own, struct error *err)
{
    const double passed = clock_seconds() - of->begun;
    of->cost->n_runs++;
    of->cost->n_not_agreed += own->status == EXIT_DIFFERENT;
    if (of->shown && of->likely > 0)
        progress_show(&of->line, (long)(100 * passed), (long)(100 * fmax(of->likely, passed)) + 1);
    if (own->status == EXIT_AGREED || own->status == EXIT_DIFFERENT)
        return true;
    if (strstr(own->text, of->folder.path))
        return error_failed(err, "%s; set TMPDIR to a folder with more room", error_words(own));
    *err = *own;
    return false;
}

enum { MORE_WORDS = 24 };

/* Renders the scene with what cost was given, and then with the words of a configuration and more.
 * The scene comes last: its name may begin with a dash. A library of OpenGL is refused where the
 * reference draws alone. */
static bool run(struct measurement *of, const char *words, const char *more, int stack,
                struct timing *out, struct error *err)
{
    const struct options *options = of->options;
    const bool draws = of->cost->checked && !strstr(more, alone);
    const char *line[MOST_RECORDED + MORE_WORDS] = {options->program, "render"};
    char own_words[WORDS_LENGTH], *rest;
    struct error own = {.status = EXIT_AGREED};
    struct run_seconds seconds;
    int n = 2;
    for (int i = 0; i < options->n_recorded; i++)
        if (draws || strncmp(options->recorded[i], "--gl=", strlen("--gl=")) != 0)
            line[n++] = options->recorded[i];
    const int length = snprintf(own_words, sizeof own_words, "%s%s%s --threads=%d", words, more,
                                of->cost->checked ? "" : alone, threads_count(options->threads));
    if (options->memory_mib > 0)
        snprintf(own_words + length, sizeof own_words - (size_t)length, " --memory=%d",
                 options->memory_mib);
    for (char *word = strtok_r(own_words, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
        line[n++] = word;
    if (options->detector) {
        line[n++] = "--detector";
        line[n++] = options->detector;
    }
    const char *const last[] = {
        "--keep", "--quiet", "--output", of->stacks[stack], "--", options_scene(options), NULL};
    memcpy(line + n, last, sizeof last);
    process_program(line, &seconds, &own);
    timing_add(out, seconds.processor);
    return conclude(of, &own, err);
}

/* Renders three times, but once if it takes long. */
static bool run_more(struct measurement *of, const char *words, const char *more,
                     struct timing *out, struct error *err)
{
    while (out->n < FEWEST_RUNS && !is_long(out))
        if (!run(of, words, more, STACK, out, err))
            return false;
    return true;
}

/* Finds how far the latest stack is off from another. */
static bool differ(const struct measurement *of, struct seen_stack *standard,
                   struct pixel_difference *out, struct error *err)
{
    return stack_difference(standard, of->stacks[STACK], of->cost->observer, of->options->threads,
                            out, err);
}

/* ---- samplings ---- */

/* Says how long everything is likely to take, when the first sampling has been drawn: some thirty
 * pictures, a third of them with the check, and fewer where each takes long. The numbers were
 * fitted to built-in scenes on two processors. */
static bool announce(struct measurement *of, struct error *err)
{
    static const double rest = 4, pictures = 90, fewer = 1.2;
    const double first = of->cost->samplings[0].unchecked.seconds[0];
    struct printed line = {.text = NULL};
    of->likely = clock_seconds() - of->begun + rest + pictures * first / (1 + fewer * first);
    if (of->options->quiet)
        return true;
    print(&line, "about %.2g s\n", of->likely);
    return printed_show(&line, STDERR_FILENO, err);
}

/* Renders a configuration once, and measures it. What the scene refuses becomes a note. */
static bool try_sampling(struct measurement *of, int sampling, struct error *err)
{
    struct cost *cost = of->cost;
    struct configuration *out = &cost->samplings[cost->n];
    struct error own = {.status = EXIT_AGREED};
    *out = (struct configuration){.components = sampling < N_COMPONENTS};
    snprintf(out->words, sizeof out->words, "%s", samplings[sampling]);
    const bool drawn = run(of, out->words, alone, STACK, &out->unchecked, &own);
    if (drawn && differ(of, &of->standard, &out->error, &own))
        cost->n++;
    else if (drawn && own.status == EXIT_INPUT) /* the standard has no white */
        error_usage(err, "no light shines at the wavelengths of %s: it has no colours",
                    cost->scene);
    else if (own.status == EXIT_INPUT)
        return add_note(cost, out->words, &own, err);
    else
        *err = own;
    return err->status == EXIT_AGREED;
}

/* A sampling of more pages than one within the least error costs more than that. */
static bool try_all(struct measurement *of, struct error *err)
{
    const double least = wanted_errors[WANTED_ERRORS - 1];
    for (int i = 0; i < N_SAMPLINGS && !cost_cheapest(of->cost, least, false); i++)
        if (!try_sampling(of, i, err) || (of->likely <= 0 && of->cost->n > 0 && !announce(of, err)))
            return false;
    return of->cost->n > 0 || error_usage(err, "%s", of->cost->notes[0]);
}

/* ---- the order of seconds ---- */

/* Returns whether two configurations need more runs until it is clear which is cheaper. */
static bool is_open(const struct timing *best, const struct timing *other)
{
    const double margin = other->n < FEWEST_RUNS || best->n < FEWEST_RUNS ? 1.2 : 1;
    return other->n < MOST_RUNS && !is_long(other) &&
           other->seconds[0] < margin * best->seconds[best->n - 1];
}

/* Runs the cheapest within an error, and its rivals, once more. *settled: there was no need to. */
static bool run_rivals(struct measurement *of, double error, bool components, bool *settled,
                       struct error *err)
{
    struct cost *cost = of->cost;
    const struct configuration *best = cost_cheapest(cost, error, components);
    for (int i = 0; best && i < cost->n; i++) {
        struct configuration *other = &cost->samplings[i];
        const bool counts = other->components == components && other->error.quantile_95 <= error;
        if (!counts || !is_open(&best->unchecked, &other->unchecked) ||
            (other == best && best->unchecked.n >= FEWEST_RUNS))
            continue;
        *settled = false;
        if (!run(of, other->words, alone, STACK, &other->unchecked, err))
            return false;
    }
    return true;
}

/* Runs rivals in turn, so that a slow moment of the machine meets all of them. */
static bool settle(struct measurement *of, struct error *err)
{
    bool settled = false;
    while (!settled) {
        settled = true;
        for (int i = 0; i < 2 * WANTED_ERRORS; i++)
            if (!run_rivals(of, wanted_errors[i / 2], i % 2, &settled, err))
                return false;
    }
    return true;
}

/* Renders those that the answer names with the check, as their users would. The errors of those
 * pictures decide, so that it may name others then. */
static bool run_checked(struct measurement *of, struct error *err)
{
    struct cost *cost = of->cost;
    bool all = !cost->checked;
    cost_mark(cost);
    while (!all) {
        all = true;
        for (int i = 0; i < cost->n; i++) {
            struct configuration *one = &cost->samplings[i];
            if (!one->named || one->checked.n > 0)
                continue;
            all = false;
            if (!run_more(of, one->words, "", &one->checked, err) ||
                !differ(of, &of->standard, &one->error, err))
                return false;
        }
        cost_mark(cost);
    }
    return !cost->checked || is_long(&cost->every_nm.unchecked) ||
           run_more(of, every_nm, "", &cost->every_nm.checked, err);
}

/* ---- positions and triangles, with a sampling of few pages and not too many pixels ---- */

/* Renders the typical sampling with more words. */
static bool run_typical(struct measurement *of, const char *words, const char *more, int stack,
                        double *seconds, struct error *err)
{
    const struct cost *cost = of->cost;
    struct timing timing = {.n = 0};
    char all[WORDS_LENGTH];
    snprintf(all, sizeof all, "%s%s --size=%dx%d", cost->typical->words, words, cost->small_width,
             cost->small_height);
    const bool done = run(of, all, more, stack, &timing, err);
    *seconds = timing.seconds[0];
    return done;
}

/* Renders it in the finest way, by the reference; as it is; and in a finer way, if there is one.
 * Finds how far the last two are off. Triangles have a finer way if their error is seen. Outlines
 * are few pixels, which a quantile leaves out: the mean counts. */
static bool refine(struct measurement *of, const char *finest, bool outlines,
                   struct refinement *out, struct error *err)
{
    static const double none = 0.02; /* an error that nobody would spend a second on */
    struct seen_stack standard = {.path = of->stacks[FINEST]};
    struct pixel_difference error = {.mean = 0};
    double seconds[3] = {0};
    bool done = run_typical(of, finest, alone, FINEST, &seconds[0], err) &&
                run_typical(of, "", "", STACK, &seconds[1], err) &&
                differ(of, &standard, &error, err);
    out->before = outlines ? error.mean : error.quantile_95;
    if (!outlines && of->cost->checked && out->before >= none)
        snprintf(out->words, sizeof out->words, " --accuracy=%.2g", out->before / 2);
    if (done && out->words[0]) {
        done = run_typical(of, out->words, "", STACK, &seconds[2], err) &&
               differ(of, &standard, &error, err);
        out->after = outlines ? error.mean : error.quantile_95;
        out->factor = seconds[2] / seconds[1];
    }
    free(standard.pixels);
    return done;
}

static bool find_positions(struct measurement *of, struct error *err)
{
    struct refinement *out = &of->cost->positions;
    const int side = of->scene.positions;
    char finest[RENDER_WORDS];
    out->before = (double)NAN;
    if (4 * side > MOST_POSITIONS)
        return true;
    snprintf(finest, sizeof finest, " --samples=%d", 4 * side);
    snprintf(out->words, sizeof out->words, " --samples=%d", 2 * side);
    return refine(of, finest, true, out, err);
}

static bool find_prices(struct measurement *of, struct error *err)
{
    /* each point has its own light */
    static const char finest[] = " --shading=phong --tessellation=4 --depth=32f --full-scale=65535";
    struct cost *cost = of->cost;
    cost->typical = cost_typical(cost);
    return (!cost->checked ||
            run_more(of, cost->typical->words, " --no-check", &cost->opengl, err)) &&
           find_positions(of, err) && refine(of, finest, false, &cost->triangles, err);
}

/* ---- all ---- */

/* Halves the sides of a large picture, until prices that are ratios take little time. */
static void find_small_size(struct cost *cost)
{
    static const int most = 60000; /* pixels */
    int *width = &cost->small_width, *height = &cost->small_height;
    *height = cost->height;
    for (*width = cost->width; (double)*width * *height > most; *width /= 2)
        *height = *height > 1 ? *height / 2 : 1;
}

static bool try_opengl(void *context, void *out, struct error *err)
{
    char ignored[256];
    (void)context, (void)err;
    *(bool *)out = drawing_ways.library(ignored, sizeof ignored);
    return true;
}

/* Finds whether OpenGL draws here, or is asked for by name. It is tried in a process of its own:
 * variables that it sets for this process would reach the renders. */
static bool find_opengl(const struct options *options, bool *out, struct error *err)
{
    const struct render_options *render = options->own;
    *out = gl_is_built();
    return !*out || render->gl || process_run(try_opengl, NULL, out, sizeof *out, 0, err);
}

/* Refuses a detector that is no observer. OpenGL draws no phong shading:
 * the reference alone then draws all configurations. */
static bool survey(struct measurement *of, struct error *err)
{
    struct detector observer = {.name = NULL};
    struct printed name = {.text = NULL};
    struct cost *cost = of->cost;
    cost->observer = options_detector(of->options);
    const bool done = observer_read(cost->observer, &observer, err) &&
                      scene_read_options(of->options, &of->scene, err) &&
                      job_read_files(&of->scene, err) && options_check_outputs(of->options, err) &&
                      find_opengl(of->options, &cost->checked, err);
    detector_free(&observer);
    if (!done)
        return false;
    print_text(&name, of->scene.path);
    for (int i = 0; i < of->options->n_recorded; i++)
        print(&name, " %s", of->options->recorded[i]);
    cost->width = of->scene.width;
    cost->height = of->scene.height;
    cost->checked = cost->checked && of->scene.shading != SHADING_PHONG;
    find_small_size(cost);
    cost->scene = printed_take(&name, err);
    return cost->scene != NULL;
}

static bool measure(struct measurement *of, struct error *err)
{
    struct configuration *standard = &of->cost->every_nm;
    if (!survey(of, err) || !folder_open(&of->folder, err))
        return false;
    for (int i = 0; i < N_STACKS; i++) {
        snprintf(of->stacks[i], sizeof of->stacks[i], "%s/%d.tif", of->folder.path, i);
        guard_remove(of->stacks[i]);
    }
    of->standard.path = of->stacks[STANDARD]; /* float pages at every nm, by the reference */
    snprintf(standard->words, sizeof standard->words, "%s", every_nm);
    return run(of, "--sampling=riemann:1 --depth=32f", alone, STANDARD, &standard->unchecked,
               err) &&
           try_all(of, err) && settle(of, err) && run_checked(of, err) && find_prices(of, err);
}

bool cost_measure(const struct options *options, struct cost *out, struct error *err)
{
    struct measurement of = {.options = options, .cost = out, .begun = clock_seconds()};
    *out = (struct cost){.scene = NULL};
    of.shown = progress_start(&of.line, options->quiet);
    const bool done = measure(&of, err);
    if (of.shown)
        progress_show(&of.line, 1, 1);
    for (int i = 0; i < N_STACKS; i++)
        guard_forget(of.stacks[i]);
    folder_close(&of.folder);
    free(of.standard.pixels);
    scene_free(&of.scene);
    return done;
}

void cost_free(struct cost *cost)
{
    for (int i = 0; i < cost->n_notes; i++)
        free(cost->notes[i]);
    FREE_ALL(cost->notes, cost->scene);
    *cost = (struct cost){.scene = NULL};
}
