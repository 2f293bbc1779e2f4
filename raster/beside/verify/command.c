/* SPDX-License-Identifier: MIT */
/* spectral verify: judges scenes on drivers, and reports the results. */
#include <string.h>

#include "raster/beside/verify/inside.h"

/* ---- the runs ---- */

static bool run_all(const struct options *options, struct verification *of, struct error *err)
{
    struct progress_line line;
    const bool shown = progress_start(&line, options->quiet);
    const double start = clock_seconds();
    const int n = of->n_drivers * of->n_scenes;
    for (int i = 0; i < n; i++) {
        struct verify_driver *driver = &of->drivers[i / of->n_scenes];
        struct verify_result *result = &of->results[i];
        if (!verify_run(options, driver, &of->scenes[i % of->n_scenes], result, err))
            return false;
        if (result->outcome != VERIFY_FAILED) {
            driver->names = result->names;
            memcpy(driver->profile, result->profile, sizeof driver->profile);
        }
        if (shown)
            progress_show(&line, i + 1, n);
    }
    of->seconds = clock_seconds() - start;
    return true;
}

/* ---- the report ---- */

static bool write_junit(const struct verification *of, struct options *options, struct error *err)
{
    const struct verify_options *own = options->own;
    struct printed printed = {.text = NULL};
    verify_junit(of, &printed);
    return printed_write(&printed, own->junit, &options->outputs, err);
}

static bool write_json(const struct verification *of, struct options *options, struct error *err)
{
    struct json json;
    verify_json(of, &json);
    return json_write(&json, options->json, &options->outputs, err);
}

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
    struct printed table = {.text = NULL};
    if (!options->quiet) {
        verify_print(of, &table);
        verify_print_failures(of, options, &table);
    }
    return printed_show(&table, options_table(options, own->junit), err) &&
           (!options->json || write_json(of, options, err)) &&
           (!own->junit || write_junit(of, options, err)) && conclude(of, err);
}

/* ---- the command ---- */

static bool check_options(const struct options *options, struct error *err)
{
    const struct verify_options *own = options->own;
    if (own->render.renderer && strcmp(own->render.renderer, "raster") == 0)
        return error_usage(err,
                           "the reference needs no verification; --renderer is that of OpenGL");
    return output_can_open(options->json, err) && output_can_open(own->junit, err);
}

static bool run_verify(struct options *options, struct error *err)
{
    struct verification of = {.n_drivers = 0};
    const bool done = check_options(options, err) && verification_open(options, &of, err) &&
                      run_all(options, &of, err) && report(&of, options, err);
    verification_free(&of);
    return done;
}

static const struct option verify_rows[] = {
    {"--junit FILE", "writes the results as JUnit's XML; - is standard output",
     OWN(TEXT, verify_options, junit), .writes = true},
};
static const struct option_list verify_list = OPTION_LIST(verify_rows);
static const struct option_list *const lists[] = {
    &verify_list,    &scene_options, &renderer_options, &library_option, &judged_options,
    &threads_option, &json_option,   &quiet_option,     &common_options, NULL};
const struct command verify_command = {
    .name = "verify",
    .operands = "[SCENE...]",
    .summary = "judge OpenGL's drivers by built-in scenes and hard cases",
    .example = "verify --gl egl --junit verify.xml",
    .run = run_verify,
    .lists = lists,
    .own_size = sizeof(struct verify_options),
    .n_operands = MAX_OPERANDS,
};
