/* SPDX-License-Identifier: MIT */
/* spectral cost: measures what accuracy costs in time. Each configuration is a command line of
 * render. */
#include <unistd.h>

#include "raster/beside/cost/inside.h"

struct cost_options {
    struct render_options render; /* the first member */
    const char *csv, *svg;
};

/* Writes the files that the options name, and prints the answer. */
static bool report(struct options *options, const struct cost *cost, struct error *err)
{
    const struct cost_options *own = options->own;
    const char *csv = own->csv, *svg = own->svg;
    const bool taken = (csv && output_is_standard(csv)) || (svg && output_is_standard(svg));
    struct printed answer = {.text = NULL}, table = {.text = NULL}, chart = {.text = NULL};
    struct json json;
    if (!options->quiet)
        cost_print(options, cost, &answer);
    if (!printed_show(&answer, taken ? STDERR_FILENO : options_table(options, NULL), err))
        return false;
    if (csv) {
        cost_csv(cost, &table);
        if (!printed_write(&table, csv, &options->outputs, err))
            return false;
    }
    if (svg) {
        cost_svg(cost, &chart);
        if (!printed_write(&chart, svg, &options->outputs, err))
            return false;
    }
    if (options->json)
        cost_json(cost, &json);
    return !options->json || json_write(&json, options->json, &options->outputs, err);
}

/* ---- the command ---- */

/* Refuses standard input, which can be read only once. */
static bool run_cost(struct options *options, struct error *err)
{
    struct cost cost = {.scene = NULL};
    if (strcmp(options_scene(options), "-") == 0)
        return error_usage(err, "cost reads the scene anew for each configuration; expected a "
                                "file, not standard input");
    const bool done = cost_measure(options, &cost, err) && report(options, &cost, err);
    cost_free(&cost);
    return done;
}

static const struct option cost_rows[] = {
    {"--observer, --detector NAME", "measures colour differences for it (default: cie1931)",
     SHARED(TEXT, detector)},
    {"--csv FILE", "writes the table; - is standard output", OWN(TEXT, cost_options, csv),
     .writes = true},
    {"--svg FILE", "writes a chart; - is standard output", OWN(TEXT, cost_options, svg),
     .writes = true},
    {"-v, --verbose", "prints the table, too", SHARED(FLAG, verbose)},
};
const struct command cost_command = {
    .name = "cost",
    .operands = "[SCENE]",
    .summary = "measure what accuracy costs in time",
    .example = "cost patches --svg cost.svg",
    .run = run_cost,
    .rows = OPTION_LIST(cost_rows),
    .shared = {&library_option, &scene_options, &threads_option, &json_option, &quiet_option},
    .own_size = sizeof(struct cost_options),
    .n_operands = 1,
};
