/* SPDX-License-Identifier: MIT */
/* Methods of sampling as words. */
#include <stdlib.h>
#include <string.h>

#include "data/method/method.h"
#include "data/spectra/spectra.h"
#include "data/text/text.h"
#include "spectral.h"

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

static bool read_count(const struct word *number, long most, int *out, struct error *err)
{
    long value = 0;
    const bool done = word_integer(number, "number of samples", 1, most, &value, err);
    *out = (int)value;
    return done;
}

static bool read_number(const struct word *number, struct sampling_method *out, struct error *err)
{
    switch (out->kind) {
    case SAMPLING_RIEMANN:
        return word_number(number, "step in nm", 1, 10000, &out->step_nm, err);
    case SAMPLING_ADAPTIVE:
        return word_number(number, "tolerance", 1e-9, 1, &out->tolerance, err);
    case SAMPLING_GAUSS:
        return read_count(number, LARGEST_QUADRATURE, &out->count, err);
    default:
        return read_count(number, 10000, &out->count, err);
    }
}

bool sampling_read(const char *option, const char *text, struct sampling_method *out,
                   struct error *err)
{
    const size_t kind_length = strcspn(text, ":");
    const bool has_number = text[kind_length] != '\0';
    int kind = 0, functions = FUNCTIONS_DETECTOR;
    while (kind < KINDS &&
           (strlen(kinds[kind]) != kind_length || strncmp(text, kinds[kind], kind_length) != 0))
        kind++;
    *out = (struct sampling_method){.kind = (enum sampling_kind)kind};
    if (kind == KINDS || has_number == (kind == SAMPLING_RGB || kind == SAMPLING_XYZ))
        return refuse_name(option, text, err);
    if (!has_number)
        return true;
    const char *number = text + kind_length + 1, *comma = strchr(number, ',');
    const size_t length = comma != NULL ? (size_t)(comma - number) : strlen(number);
    if (comma != NULL) {
        functions = FUNCTIONS_OPEN;
        while (functions < FUNCTIONS && strcmp(comma + 1, function_names[functions]) != 0)
            functions++;
    }
    if (length == 0 || functions == FUNCTIONS || (comma != NULL && kind != SAMPLING_GAUSS))
        return refuse_name(option, text, err);
    out->functions = (enum sampling_functions)functions;
    const struct word word = {
        .start = number, .length = length, .place = {option, 1, (int)kind_length + 2}};
    return read_number(&word, out, err);
}

/* As few digits as tell the number, but 10 rather than 1e+01. */
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
    char number[32] = "";
    switch (method->kind) {
    case SAMPLING_RIEMANN:
        shortest(method->step_nm, number, sizeof number);
        break;
    case SAMPLING_ADAPTIVE:
        shortest(method->tolerance, number, sizeof number);
        break;
    case SAMPLING_BOX:
    case SAMPLING_GAUSS:
    case SAMPLING_BASIS:
        snprintf(number, sizeof number, "%d", method->count);
        break;
    default:
        break;
    }
    const char *functions = method->kind == SAMPLING_GAUSS ? function_names[method->functions] : "";
    snprintf(out, SAMPLING_NAME, "%s%s%s%s%s", kinds[method->kind], number[0] != '\0' ? ":" : "",
             number, functions[0] != '\0' ? "," : "", functions);
}

bool sampling_takes_means(const char *name)
{
    struct sampling_method method;
    struct error ignored = {0};
    return sampling_read("", name, &method, &ignored) && method.kind == SAMPLING_BOX;
}
