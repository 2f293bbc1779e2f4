/* SPDX-License-Identifier: MIT */
/* Chromatic adaptation: each cone response to a colour is divided by the response to the white. */
#include "raster/beside/colour/colour.h"

const char *const adaptation_names[] = {
    [ADAPTATION_NONE] = "none",           [ADAPTATION_VON_KRIES] = "von-kries",
    [ADAPTATION_FAIRCHILD] = "fairchild", [ADAPTATION_BRADFORD] = "bradford",
    [ADAPTATION_CAT16] = "cat16",
};
enum { KINDS = sizeof adaptation_names / sizeof adaptation_names[0] };

/* Matrices from XYZ of the kinds that do not adapt in von Kries's cones. Bradford: ICC.1:2010,
 * annex E. CAT16: C. Li et al., Comprehensive color solutions, Color Res. Appl. 42, 703-718 (2017).
 */
static const double cones[KINDS][3][3] = {
    [ADAPTATION_BRADFORD] = {{0.8951, 0.2664, -0.1614},
                             {-0.7502, 1.7135, 0.0367},
                             {0.0389, -0.0685, 1.0296}},
    [ADAPTATION_CAT16] = {{0.401288, 0.650173, -0.051461},
                          {-0.250268, 1.204414, 0.045854},
                          {-0.002079, 0.048952, 0.953127}},
};

/* ---- names ---- */

bool adaptation_read(const char *option, const char *text, struct adaptation *out,
                     struct error *err)
{
    static const char prefix[] = "fairchild:";
    *out = (struct adaptation){0};
    for (int kind = 0; kind < KINDS; kind++)
        if (strcmp(text, adaptation_names[kind]) == 0) {
            out->kind = (enum adaptation_kind)kind;
            return true;
        }
    if (strncmp(text, prefix, strlen(prefix)) == 0 && text[strlen(prefix)] != '\0') {
        const char *luminance = text + strlen(prefix);
        const struct word word = {
            .start = luminance, .length = strlen(luminance), .place = {option, 1, 1}};
        out->kind = ADAPTATION_FAIRCHILD;
        return word_number(&word, "luminance in cd/m2", 1e-6, 1e12, &out->luminance, err);
    }
    return error_at(err, VALUE_OF(option),
                    "expected none, von-kries, fairchild, fairchild:LUMINANCE, bradford or cat16, "
                    "not '%.100s'",
                    text);
}

/* ---- matrices ---- */

/* Computes how far each kind of cones adapts (equations 21 and 22): 1 under equal energy. */
static void incompleteness(const double white[3], const double equal[3], double luminance,
                           double out[3])
{
    const double root = power(luminance, 1.0 / 3);
    double sum = 0;
    for (int i = 0; i < 3; i++)
        sum += white[i] / equal[i];
    for (int i = 0; i < 3; i++) {
        const double m = 3 * (white[i] / equal[i]) / sum;
        out[i] = (1 + root + m) / (1 + root + 1 / m);
    }
}

/* Refuses a white with a response of 0 or less, to which no ratio exists. Deep spectral colours
 * have such responses. */
static bool check_responses(const struct adaptation *adaptation, const double response[3],
                            struct error *err)
{
    for (int i = 0; i < 3; i++)
        if (!(response[i] > 0))
            return error_usage(
                err,
                "%s adaptation needs a white with cone responses above 0; this white "
                "has %.6g, %.6g, %.6g",
                adaptation_names[adaptation->kind], response[0], response[1], response[2]);
    return true;
}

void adaptation_cones(enum adaptation_kind kind, double out[3][3])
{
    if (kind == ADAPTATION_VON_KRIES || kind == ADAPTATION_FAIRCHILD)
        tristimulus_to_cones(out);
    else
        memcpy(out, cones[kind], sizeof cones[kind]);
}

/* Equations 19 and 23 multiply responses by 100. Here the factor is the response to the display's
 * white, so that white becomes exactly the display's white. With Hunt, Pointer and Estevez's matrix
 * the two factors differ by 3e-5. */
bool adaptation_matrix(const struct adaptation *adaptation, const double white[3],
                       const double equal[3], double out[3][3], struct error *err)
{
    double forward[3][3], back[3][3];
    double of_white[3], of_display[3], of_equal[3], part[3] = {1, 1, 1};
    if (adaptation->kind == ADAPTATION_NONE) {
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                out[i][j] = i == j;
        return true;
    }
    adaptation_cones(adaptation->kind, forward);
    tristimulus_inverse(forward, back);
    tristimulus_apply(forward, white, of_white);
    tristimulus_apply(forward, display_white, of_display);
    tristimulus_apply(forward, equal, of_equal);
    if (!check_responses(adaptation, of_white, err))
        return false;
    if (adaptation->kind == ADAPTATION_FAIRCHILD)
        incompleteness(of_white, of_equal, adaptation->luminance, part);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[i][j] = part[i] * of_display[i] / of_white[i] * forward[i][j];
    tristimulus_apply_all(back, 3, out[0]);
    return true;
}
