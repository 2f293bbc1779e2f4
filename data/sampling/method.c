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
static const struct sampling_traits kinds[] = {
    [SAMPLING_BOX] = {"box", sample_box, &boxes, .flags = NEEDS_OBSERVER},
    [SAMPLING_RIEMANN] = {"riemann", sample_riemann, &wavelengths, .flags = ANY_DETECTOR},
    [SAMPLING_GAUSS] = {"gauss", .words = NULL},
    [SAMPLING_ADAPTIVE] = {"adaptive", sample_adaptive, &wavelengths, .flags = 0},
    [SAMPLING_BASIS] = {"basis", sample_basis, &components, .flags = FIXED | COMPONENTS},
    [SAMPLING_RGB] = {"rgb",
                      sample_tristimulus,
                      &three_numbers,
                      NEEDS_OBSERVER | FIXED | COMPONENTS,
                      {"red", "green", "blue"}},
    [SAMPLING_XYZ] = {"xyz",
                      sample_tristimulus,
                      &three_numbers,
                      NEEDS_OBSERVER | FIXED | COMPONENTS,
                      {"X", "Y", "Z"}},
};
static const struct sampling_traits gauss[] = {
    [FUNCTIONS_DETECTOR] = {"", sample_gauss_detector, &wavelengths, .flags = 0},
    [FUNCTIONS_OPEN] = {"open", sample_gauss_open, &wavelengths, .flags = ANY_DETECTOR},
    [FUNCTIONS_XYZ] = {"xyz", sample_gauss_functions, &wavelengths,
                       .flags = NEEDS_OBSERVER | FIXED},
    [FUNCTIONS_LMS] = {"lms", sample_gauss_functions, &wavelengths,
                       .flags = NEEDS_OBSERVER | FIXED},
    [FUNCTIONS_ACC] = {"acc", sample_gauss_functions, &wavelengths,
                       .flags = NEEDS_OBSERVER | FIXED},
};
enum { KINDS = sizeof kinds / sizeof kinds[0], FUNCTIONS = sizeof gauss / sizeof gauss[0] };

const struct sampling_traits *traits_of(const struct sampling_method *method)
{
    return method->kind == SAMPLING_GAUSS ? &gauss[method->functions] : &kinds[method->kind];
}

bool sampling_makes_components(const struct sampling_method *method)
{
    return traits_of(method)->flags & COMPONENTS;
}

static bool refuse_name(const char *option, const char *text, struct error *err)
{
    return error_usage(err,
                       "%s is box:N, riemann:STEP, gauss:N, gauss:N,open, gauss:N,xyz, gauss:N,lms,"
                       " gauss:N,acc, adaptive:TOLERANCE, basis:K, rgb or xyz, not '%.100s'",
                       option, text);
}

static bool read_number(const struct word *number, struct sampling_method *out, struct error *err)
{
    const long most = out->kind == SAMPLING_GAUSS ? LARGEST_QUADRATURE : 10000;
    long count = 0;
    if (out->kind == SAMPLING_RIEMANN)
        return word_number(number, "step in nm", 1, 10000, &out->step_nm, err);
    if (out->kind == SAMPLING_ADAPTIVE)
        return word_number(number, "tolerance", 1e-9, 1, &out->tolerance, err);
    const bool done = word_integer(number, "number of samples", 1, most, &count, err);
    out->count = (int)count;
    return done;
}

/* Returns the index of a name of `length` bytes from row `first` on, or n if it is unknown. */
static int find_name(const struct sampling_traits *rows, int first, int n, const char *name,
                     size_t length)
{
    int i = first;
    while (i < n && (strlen(rows[i].name) != length || strncmp(rows[i].name, name, length) != 0))
        i++;
    return i;
}

bool sampling_read(const char *option, const char *text, struct sampling_method *out,
                   struct error *err)
{
    const size_t kind_length = strcspn(text, ":");
    const bool has_number = text[kind_length] != '\0';
    const int kind = find_name(kinds, 0, KINDS, text, kind_length);
    *out = (struct sampling_method){.kind = (enum sampling_kind)kind};
    if (kind == KINDS || has_number == (kind == SAMPLING_RGB || kind == SAMPLING_XYZ))
        return refuse_name(option, text, err);
    if (!has_number)
        return true;
    const char *number = text + kind_length + 1, *end = number + strcspn(number, ",");
    int functions = FUNCTIONS_DETECTOR;
    if (*end == ',')
        functions = find_name(gauss, FUNCTIONS_OPEN, FUNCTIONS, end + 1, strlen(end + 1));
    if (end == number || functions == FUNCTIONS || (*end == ',' && kind != SAMPLING_GAUSS))
        return refuse_name(option, text, err);
    out->functions = (enum sampling_functions)functions;
    const struct word word = {.start = number,
                              .length = (size_t)(end - number),
                              .place = {option, 1, (int)kind_length + 2}};
    return read_number(&word, out, err);
}

/* Returns how many digits, from `fewest` on, read back as the same number. */
static int digits_of(double number, int fewest)
{
    char text[32];
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
    const char *functions = gauss[method->functions].name;
    const double number = method->kind == SAMPLING_RIEMANN    ? method->step_nm
                          : method->kind == SAMPLING_ADAPTIVE ? method->tolerance
                                                              : method->count;
    char digits[32] = "";
    if (number > 0) /* 10 rather than 1e+01 */
        snprintf(digits, sizeof digits, "%.*g", digits_of(number, 1), number);
    snprintf(out, SAMPLING_NAME, "%s%s%s%s%s", kinds[method->kind].name, number > 0 ? ":" : "",
             digits, functions[0] != '\0' ? "," : "", functions);
}

bool sampling_takes_means(const char *name)
{
    struct sampling_method method;
    struct error ignored = {0};
    return sampling_read("", name, &method, &ignored) && method.kind == SAMPLING_BOX;
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
