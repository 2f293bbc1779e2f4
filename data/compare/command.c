/* SPDX-License-Identifier: MIT */
/* spectral compare: prints where and by how much two stacks differ. */
#include <stdio.h>

#include "data/base/base.h"
#include "data/compare/compare.h"
#include "data/invocation/invocation.h"
#include "data/pages/pages.h"

bool compare_accepts_tolerance(const char *option, const char *value, struct error *err)
{
    struct tolerance tolerance;
    return tolerance_read(option, value, &tolerance, err);
}

/* Refuses operands that are no stacks, and outputs that cannot be written. */
static bool check_files(const struct options *options, const char *a, const char *b,
                        struct error *err)
{
    return (!options->map || picture_accepts(options->map, err)) && scene_refuse(a, err) &&
           scene_refuse(b, err) && output_can_open(options->json, err);
}

/* Writes the differences as JSON, if that is wanted, and prints them. */
static bool report(struct options *options, const struct comparison *comparison, bool within,
                   struct error *err)
{
    struct json json;
    if (options->json) {
        comparison_json(comparison, within, &json);
        if (!json_write(&json, options->json, &options->outputs, err))
            return false;
    }
    if (options->quiet)
        return true;
    struct printed printed = {.text = NULL};
    comparison_print(comparison, &printed);
    return printed_show(&printed, options_table(options, options->map), err);
}

bool command_compare(struct options *options, struct error *err)
{
    struct comparison comparison = {.n = 0};
    struct compare_options compare_options = {.observer = options_detector(options),
                                              .white = options->white,
                                              .map = options->map,
                                              .threads = options->threads,
                                              .outputs = &options->outputs};
    const char *a = options->operands[0], *b = options->operands[1];
    if (options->n_operands != 2)
        return error_usage(err, "compare takes two stacks; see spectral compare --help");
    if (options->tolerance &&
        !tolerance_read("--tolerance", options->tolerance, &compare_options.tolerance, err))
        return false;
    bool done =
        check_files(options, a, b, err) && compare(a, b, &compare_options, &comparison, err);
    const bool within = done && comparison_is_within(&comparison, &compare_options.tolerance);
    done = done && report(options, &comparison, within, err) &&
           (within || error_different(err, "%s and %s differ by more than the tolerance", a, b));
    comparison_free(&comparison);
    return done;
}
