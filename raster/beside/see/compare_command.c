/* SPDX-License-Identifier: MIT */
/* spectral compare: prints where and by how much two stacks differ. */
#include <stdio.h>

#include "data/images/images.h"
#include "raster/beside/see/inside.h"

struct compare_own {
    const char *tolerance, *map;
};

static bool accepts_tolerance(const char *option, const char *value, struct error *err)
{
    struct tolerance tolerance;
    return tolerance_read(option, value, &tolerance, err);
}

/* Refuses operands that are no stacks, and outputs that cannot be written. */
static bool check_files(const struct options *options, const char *a, const char *b,
                        struct error *err)
{
    const struct compare_own *own = options->own;
    return (!own->map || picture_accepts(own->map, err)) && scene_refuse(a, err) &&
           scene_refuse(b, err) && output_can_open(options->json, err);
}

/* Writes the differences as JSON, if that is wanted, and prints them. */
static bool report(struct options *options, const struct comparison *comparison, bool within,
                   struct error *err)
{
    const struct compare_own *own = options->own;
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
    return printed_show(&printed, options_table(options, own->map), err);
}

static bool run_compare(struct options *options, struct error *err)
{
    const struct compare_own *own = options->own;
    struct comparison comparison = {.n = 0};
    struct compare_options compare_options = {.observer = options_detector(options),
                                              .white = options->white,
                                              .map = own->map,
                                              .threads = options->threads,
                                              .outputs = &options->outputs};
    const char *a = options->operands[0], *b = options->operands[1];
    if (options->n_operands != 2)
        return error_usage(err, "compare takes two stacks; see spectral compare --help");
    if (own->tolerance &&
        !tolerance_read("--tolerance", own->tolerance, &compare_options.tolerance, err))
        return false;
    bool done =
        check_files(options, a, b, err) && compare(a, b, &compare_options, &comparison, err);
    const bool within = done && comparison_is_within(&comparison, &compare_options.tolerance);
    done = done && report(options, &comparison, within, err) &&
           (within || error_different(err, "%s and %s differ by more than the tolerance", a, b));
    comparison_free(&comparison);
    return done;
}

static const struct option compare_rows[] = {
    {"--tolerance R|P%|EdE00",
     "largest that passes: radiance, % of the largest, or CIEDE2000 (dE94, dE76); default: 0",
     OWN(TEXT, compare_own, tolerance), .accepts = accepts_tolerance},
    {"--map FILE",
     "writes each pixel's largest difference, spectral angle and CIEDE2000 (.tif, .png)",
     OWN(TEXT, compare_own, map), .writes = true},
};
static const struct option_list compare_list = OPTION_LIST(compare_rows);
static const struct option_list *const lists[] = {&compare_list, &seeing_options, &threads_option,
                                                  &json_option,  &quiet_option,   &common_options,
                                                  NULL};
const struct command compare_command = {
    .name = "compare",
    .operands = "STACK STACK",
    .summary = "print where and by how much two stacks differ",
    .example = "compare a.tif b.tif --tolerance 0.5dE00 --map difference.png",
    .run = run_compare,
    .lists = lists,
    .own_size = sizeof(struct compare_own),
    .n_operands = 2,
};
