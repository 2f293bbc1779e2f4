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

/* Measures the differences between a and b, and prints them. */
static bool compare_and_print(const char *a, const char *b, const struct options *options,
                              const struct compare_options *compare_options, struct comparison *out,
                              struct error *err)
{
    if ((options->map && !picture_accepts(options->map, err)) || !scene_refuse(a, err) ||
        !scene_refuse(b, err) || !image_spared(options->map, a, err) ||
        !image_spared(options->map, b, err) || !compare(a, b, compare_options, out, err))
        return false;
    /* standard output may carry the map (--map /dev/stdout) */
    FILE *to = !options->map || file_is_regular(options->map) ? stdout : stderr;
    if (!options->quiet)
        comparison_print(out, to);
    return true;
}

bool command_compare(struct options *options, struct error *err)
{
    struct comparison comparison = {.n = 0};
    struct compare_options compare_options = {.observer = options_detector(options),
                                              .white = options->white,
                                              .map = options->map,
                                              .threads = options->threads};
    const char *a = options->operands[0], *b = options->operands[1];
    if (options->n_operands != 2)
        return error_usage(err, "compare takes two stacks; try spectral --help");
    if (options->tolerance &&
        !tolerance_read("--tolerance", options->tolerance, &compare_options.tolerance, err))
        return false;
    const bool done = compare_and_print(a, b, options, &compare_options, &comparison, err) &&
                      (comparison_is_within(&comparison, &compare_options.tolerance) ||
                       error_different(err, "%s and %s differ by more than the tolerance", a, b));
    comparison_free(&comparison);
    return done;
}
