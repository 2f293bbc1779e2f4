/* SPDX-License-Identifier: MIT */
/* spectral cost: measures what accuracy costs in time. Each configuration is a command line of
 * render. */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "raster/beside/cost/inside.h"
#include "raster/renderers/renderers.h"

/* ---- report ---- */

/* Writes the files that the options name. */
static bool write_files(const struct cost *cost, struct options *options, struct error *err)
{
    const struct cost_options *own = options->own;
    struct printed table = {.text = NULL}, chart = {.text = NULL};
    struct json json;
    if (own->csv) {
        cost_csv(cost, &table);
        if (!printed_write(&table, own->csv, &options->outputs, err))
            return false;
    }
    if (own->svg) {
        cost_svg(cost, &chart);
        if (!printed_write(&chart, own->svg, &options->outputs, err))
            return false;
    }
    if (options->json)
        cost_json(cost, &json);
    return !options->json || json_write(&json, options->json, &options->outputs, err);
}

static void print_advice(const struct options *options, const char *what,
                         const struct advice *advice, struct printed *to)
{
    const struct cost_entry *entry = advice->entry;
    print(to, "%s: %s, %.3g s, processor %.3g s, 95 %% %.3g\n", what, entry->name, entry->seconds,
          entry->processor, entry->accuracy.quantile_95);
    if (advice->n_rivals > 0)
        print(to,
              "  as good within noise: %d other%s, whose seconds overlap; this one takes the least "
              "processor time\n",
              advice->n_rivals, advice->n_rivals > 1 ? "s" : "");
    print_text(to, "  spectral render");
    print_shell(to, options_scene(options));
    for (int i = 0; i < options->n_recorded; i++)
        print_shell(to, options->recorded[i]);
    for (int i = 0; i < entry->n_words; i++)
        print_shell(to, entry->words[i]);
    print_text(to, "\n");
}

/* Prints the best entry. If its pages are not radiances, also prints the best entry with radiances.
 * No best entry: fails with EXIT_DIFFERENT. */
static bool recommend(const struct options *options, const char *what, struct advice best,
                      struct advice spectral, struct printed *to, struct error *err)
{
    if (!best.entry)
        return error_different(err, "no configuration has %s", what);
    print_advice(options, what, &best, to);
    if (!spectral.entry)
        print_text(to, "with spectra: none\n");
    else if (spectral.entry != best.entry)
        print_advice(options, "with spectra", &spectral, to);
    return true;
}

static bool report(struct options *options, const struct cost *cost, double tolerance,
                   struct error *err)
{
    const struct cost_options *own = options->own;
    const char *csv = own->csv, *svg = own->svg;
    const bool taken = (csv && output_is_standard(csv)) || (svg && output_is_standard(svg));
    const int to = taken ? STDERR_FILENO : options_table(options, NULL);
    struct printed table = {.text = NULL}, advice = {.text = NULL};
    char what[80];
    if (!options->quiet)
        cost_print(cost, &table);
    if (!printed_show(&table, to, err) || !write_files(cost, options, err))
        return false;
    snprintf(what, sizeof what, "95 %% within %.10g CIEDE2000", tolerance);
    bool done =
        !own->tolerance || recommend(options, what, cost_advise(cost, tolerance, HUGE_VAL, false),
                                     cost_advise(cost, tolerance, HUGE_VAL, true), &advice, err);
    snprintf(what, sizeof what, "seconds within %.10g", own->budget);
    done = done && (!(own->budget > 0) ||
                    recommend(options, what, cost_advise(cost, HUGE_VAL, own->budget, false),
                              cost_advise(cost, HUGE_VAL, own->budget, true), &advice, err));
    return printed_show(&advice, to, err) && done;
}

/* ---- the command ---- */

/* Reads a tolerance of CIEDE2000, the measure of the table. */
static bool tolerance_of(const char *option, const char *value, double *out, struct error *err)
{
    struct tolerance tolerance;
    if (!tolerance_read(option, value, &tolerance, err))
        return false;
    *out = tolerance.value;
    return tolerance.unit == TOLERANCE_CIEDE2000 ||
           error_usage(err, "%s %s: cost measures CIEDE2000; expected it as 0.5dE00", option,
                       value);
}

static bool accepts_tolerance(const char *option, const char *value, struct error *err)
{
    double tolerance;
    return tolerance_of(option, value, &tolerance, err);
}

/* Refuses standard input, which can be read only once. */
static bool check_scene(const struct options *options, struct error *err)
{
    return strcmp(options_scene(options), "-") != 0 ||
           error_usage(err, "cost reads the scene anew for each configuration; expected a file, "
                            "not standard input");
}

static bool run_cost(struct options *options, struct error *err)
{
    const struct cost_options *own = options->own;
    struct cost cost = {.scene = NULL};
    double tolerance = 0;
    bool done = (!own->tolerance || tolerance_of("--tolerance", own->tolerance, &tolerance, err)) &&
                check_scene(options, err) && cost_measure(options, &cost, err) &&
                report(options, &cost, tolerance, err);
    cost_free(&cost);
    return done;
}

static const struct option cost_rows[] = {
    {"--observer, --detector NAME", "measures colour differences for it (default: cie1931)",
     SHARED(TEXT, detector)},
    {"--runs N", "runs of each configuration, at least 5 (default: 5)",
     OWN(COUNT, cost_options, runs), .lowest = 5, .highest = 1024},
    {"--csv FILE", "writes the table; - is standard output", OWN(TEXT, cost_options, csv),
     .writes = true},
    {"--svg FILE", "writes a chart; - is standard output", OWN(TEXT, cost_options, svg),
     .writes = true},
    {"--tolerance EdE00",
     "names the cheapest configuration within E CIEDE2000 for 95 % of the pixels",
     OWN(TEXT, cost_options, tolerance), .accepts = accepts_tolerance},
    {"--budget SECONDS", "names the most accurate configuration within the time",
     OWN(NUMBER, cost_options, budget), .lowest = 1e-9, .highest = 1e9},
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
