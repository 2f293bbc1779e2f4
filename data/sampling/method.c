/* SPDX-License-Identifier: MIT */
/* Reads and writes methods of sampling as words. */
#include <stdlib.h>
#include <string.h>

#include "data/sampling/sampling.h"
#include "data/text/text.h"

static const char *const kinds[] = {
    [SAMPLING_BOX] = "box",           [SAMPLING_RIEMANN] = "riemann", [SAMPLING_GAUSS] = "gauss",
    [SAMPLING_ADAPTIVE] = "adaptive", [SAMPLING_BASIS] = "basis",     [SAMPLING_RGB] = "rgb",
    [SAMPLING_XYZ] = "xyz",
};
enum { KINDS = sizeof kinds / sizeof kinds[0] };
static const char *const function_names[] = {
    [FUNCTIONS_DETECTOR] = "", [FUNCTIONS_OPEN] = "open", [FUNCTIONS_XYZ] = "xyz",
    [FUNCTIONS_LMS] = "lms",   [FUNCTIONS_ACC] = "acc",
};
enum { FUNCTIONS = sizeof function_names / sizeof function_names[0] };

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

/* Returns the index of a name of `length` bytes, or n if it is unknown. */
static int find_name(const char *const *names, int n, const char *name, size_t length)
{
    int i = 0;
    while (i < n && (strlen(names[i]) != length || strncmp(names[i], name, length) != 0))
        i++;
    return i;
}

bool sampling_read(const char *option, const char *text, struct sampling_method *out,
                   struct error *err)
{
    const size_t kind_length = strcspn(text, ":");
    const bool has_number = text[kind_length] != '\0';
    const int kind = find_name(kinds, KINDS, text, kind_length);
    *out = (struct sampling_method){.kind = (enum sampling_kind)kind};
    if (kind == KINDS || has_number == (kind == SAMPLING_RGB || kind == SAMPLING_XYZ))
        return refuse_name(option, text, err);
    if (!has_number)
        return true;
    const char *number = text + kind_length + 1, *end = number + strcspn(number, ",");
    int functions = FUNCTIONS_DETECTOR;
    if (*end == ',')
        functions =
            FUNCTIONS_OPEN + find_name(function_names + FUNCTIONS_OPEN, FUNCTIONS - FUNCTIONS_OPEN,
                                       end + 1, strlen(end + 1));
    if (end == number || functions == FUNCTIONS || (*end == ',' && kind != SAMPLING_GAUSS))
        return refuse_name(option, text, err);
    out->functions = (enum sampling_functions)functions;
    const struct word word = {.start = number,
                              .length = (size_t)(end - number),
                              .place = {option, 1, (int)kind_length + 2}};
    return read_number(&word, out, err);
}

/* Writes as few digits as read back as the same number, but 10 rather than 1e+01. */
static void shortest(double number, char *out, size_t capacity)
{
    for (int digits = 1; digits <= 17; digits++) {
        snprintf(out, capacity, "%.*g", digits, number);
        if (strtod(out, NULL) == number && (number < 1 || strchr(out, 'e') == NULL))
            return;
    }
}

void sampling_name(const struct sampling_method *method, char out[SAMPLING_NAME])
{
    const char *functions = function_names[method->functions];
    const double number = method->kind == SAMPLING_RIEMANN    ? method->step_nm
                          : method->kind == SAMPLING_ADAPTIVE ? method->tolerance
                                                              : method->count;
    char digits[32] = "";
    if (number > 0)
        shortest(number, digits, sizeof digits);
    snprintf(out, SAMPLING_NAME, "%s%s%s%s%s", kinds[method->kind], number > 0 ? ":" : "", digits,
             functions[0] != '\0' ? "," : "", functions);
}

bool sampling_takes_means(const char *name)
{
    struct sampling_method method;
    struct error ignored = {0};
    return sampling_read("", name, &method, &ignored) && method.kind == SAMPLING_BOX;
}
