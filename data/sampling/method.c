/* SPDX-License-Identifier: MIT */
/* The methods of sampling: how they differ, and their names as words. */
#include "data/sampling/inside.h"

static const struct sampling_words boxes = {"box", "boxes", "means of these boxes only"};
static const struct sampling_words wavelengths = {"wavelength", "wavelengths",
                                                  "radiances at these wavelengths only"};
static const struct sampling_words components = {"component", "components",
                                                 "no radiances at wavelengths"};
static const struct sampling_words three_numbers = {"component", "components",
                                                    "no spectra, and no fluorescence"};
static const char *const colours[] = {"red", "green", "blue"}, *const tristimulus[] = {"X", "Y",
                                                                                       "Z"};
const struct sampling_traits sampling_kinds[] = {
    [SAMPLING_BOX] = {"box", "", sample_box, &boxes, NEEDS_OBSERVER, NULL},
    [SAMPLING_RIEMANN] = {"riemann", "", sample_riemann, &wavelengths, ANY_DETECTOR | ANY_CHANNELS,
                          NULL},
    [SAMPLING_GAUSS] = {"gauss", "", sample_gauss, &wavelengths, ANY_CHANNELS, NULL},
    [SAMPLING_GAUSS_OPEN] = {"gauss", ",open", sample_gauss, &wavelengths,
                             ANY_DETECTOR | ANY_CHANNELS, NULL},
    [SAMPLING_GAUSS_XYZ] = {"gauss", ",xyz", sample_gauss_functions, &wavelengths,
                            NEEDS_OBSERVER | FIXED, NULL},
    [SAMPLING_GAUSS_LMS] = {"gauss", ",lms", sample_gauss_functions, &wavelengths,
                            NEEDS_OBSERVER | FIXED, NULL},
    [SAMPLING_GAUSS_ACC] = {"gauss", ",acc", sample_gauss_functions, &wavelengths,
                            NEEDS_OBSERVER | FIXED, NULL},
    [SAMPLING_ADAPTIVE] = {"adaptive", "", sample_adaptive, &wavelengths, 0, NULL},
    [SAMPLING_BASIS] = {"basis", "", sample_basis, &components, FIXED | COMPONENTS, NULL},
    [SAMPLING_RGB] = {"rgb", "", sample_tristimulus, &three_numbers,
                      NEEDS_OBSERVER | FIXED | COMPONENTS, colours},
    [SAMPLING_XYZ] = {"xyz", "", sample_tristimulus, &three_numbers,
                      NEEDS_OBSERVER | FIXED | COMPONENTS, tristimulus},
};
enum { KINDS = sizeof sampling_kinds / sizeof sampling_kinds[0] };

static bool read_number(const struct word *number, struct sampling_method *out, struct error *err)
{
    const bool gauss = out->kind >= SAMPLING_GAUSS && out->kind <= SAMPLING_GAUSS_ACC;
    long count = 0;
    if (out->kind == SAMPLING_RIEMANN)
        return word_number(number, "step in nm", 1, 10000, &out->number, err);
    if (out->kind == SAMPLING_ADAPTIVE)
        return word_number(number, "tolerance", 1e-9, 1, &out->number, err);
    const bool done = word_integer(number, "number of samples", 1,
                                   gauss ? LARGEST_QUADRATURE : 10000, &count, err);
    out->number = (double)count;
    return done;
}

bool sampling_read(const char *option, const char *text, struct sampling_method *out,
                   struct error *err)
{
    const size_t length = strcspn(text, ":");
    const char *number = text + length + (text[length] == ':'),
               *end = number + strcspn(number, ",");
    const struct word name = {.start = text, .length = length},
                      word = {.start = number,
                              .length = (size_t)(end - number),
                              .place = {option, 1, (int)length + 2}};
    int kind = 0;
    while (kind < KINDS && !(word_is(&name, sampling_kinds[kind].name) &&
                             strcmp(end, sampling_kinds[kind].functions) == 0))
        kind++;
    *out = (struct sampling_method){.kind = (enum sampling_kind)kind};
    const bool bare = kind == SAMPLING_RGB || kind == SAMPLING_XYZ;
    if (kind == KINDS || (bare ? text[length] != '\0' : word.length == 0))
        return error_at(
            err, VALUE_OF(option),
            "expected box:N, riemann:STEP, gauss:N, gauss:N,open, gauss:N,xyz, gauss:N,lms,"
            " gauss:N,acc, adaptive:TOLERANCE, basis:K, rgb or xyz, not '%.100s'",
            text);
    return bare || read_number(&word, out, err);
}

/* Returns how many digits, from `fewest` on, read back as the same number. */
static int digits_of(double number, int fewest)
{
    char text[40];
    int digits = fewest;
    for (; digits < 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, number);
        if (strtod(text, NULL) == number && (number < 1 || digits >= 15 || !strchr(text, 'e')))
            break;
    }
    return digits;
}

int exact_digits(double number)
{
    return digits_of(number, 15);
}

void sampling_name(const struct sampling_method *method, char out[SAMPLING_NAME])
{
    const struct sampling_traits *kind = &sampling_kinds[method->kind];
    char digits[32] = "";
    if (method->number > 0) /* 10 rather than 1e+01 */
        snprintf(digits, sizeof digits, ":%.*g", digits_of(method->number, 1), method->number);
    snprintf(out, SAMPLING_NAME, "%s%s%s", kind->name, digits, kind->functions);
}

/* ---- a scene as the command line samples it ---- */

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
