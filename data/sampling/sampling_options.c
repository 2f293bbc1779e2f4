/* SPDX-License-Identifier: MIT */
/* A scene as the command line samples it. */
#include "data/sampling/sampling.h"
#include "data/text/text.h"

static const struct option sampling_rows[] = {
    {"--sampling METHOD",
     "box:N, riemann:STEP, gauss:N[,open|xyz|lms|acc], adaptive:TOLERANCE, basis:K, rgb or xyz",
     SHARED(TEXT, sampling), .recorded = true},
    {"--detector, --observer NAME", "samples for it, a built-in one or a file (default: cie1931)",
     SHARED(TEXT, detector), .recorded = true},
};
const struct option_list sampling_options = OPTION_LIST(sampling_rows);

bool scene_read_sampled(const struct options *options, struct scene *out, struct sampling *sampling,
                        struct error *err)
{
    struct sampling_method method;
    if (!options->sampling)
        return options->detector && !options->accuracy
                   ? error_usage(err, "--detector needs --sampling, which samples "
                                      "for it; develop takes any detector")
                   : scene_read_options(options, out, err);
    return sampling_read("--sampling", options->sampling, &method, err) &&
           scene_read_options(options, out, err) &&
           scene_sample(out, &method, options_detector(options), sampling, err);
}
