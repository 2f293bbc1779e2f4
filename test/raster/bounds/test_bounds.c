/* SPDX-License-Identifier: MIT */
/* Bounds hold, and are not far too wide, where what they bound can be tried: the slack of the
 * window, triangles that may turn, and textures. Colours name triangles. */

#include "data/maths/maths.h"
#include "raster/bounds/inside.h"
#include "raster/renderers/renderers.h"
#include "test.h"

static void check_shown(void)
{
    static const struct {
        float number[3];
        int surface, triangle;
    } cases[] = {{{0, 0, 0}, -1, -1},       {{5, 2, 3}, 2, 2 * 65536 + 5},
                 {{65535, 0, 1}, 0, 65535}, {{65536, 0, 1}, 9, -1},
                 {{0.5F, 0, 1}, 9, -1},     {{1, 32768, 1}, 9, -1},
                 {{-1, 0, 1}, 9, -1},       {{1, 1, (float)NAN}, 9, -1},
                 {{0, 0, 0x1p24F}, 9, -1},  {{1, 1, 0x1p24F - 1}, 0xfffffe, 65537}};
    bool good = true;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const struct shown seen = shown_of(9, cases[i].number, 0xabcdef12);
        good = good && seen.surface == cases[i].surface && seen.triangle == cases[i].triangle &&
               seen.depth == 0xabcdef && seen.fragments == 0x12;
    }
    CHECK(good,
          "a colour names its triangle; one that is no number names an object that is not there");
}

/* A quotient of numbers that are off is off by most where one is larger and the other smaller. */
static void check_slack(void)
{
    enum { WIDE = 640, HIGH = 480 };
    const struct plan plan = {.view = {.width = WIDE, .height = HIGH}};
    uint64_t state = 12;
    double least[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, most[3] = {0, 0, 0};
    for (int i = 0; i < 1000; i++) {
        const double w = test_random(&state, 1, 9), e = 1e-3 * w;
        double clip[4], e_clip[4];
        for (int k = 0; k < 4; k++) {
            clip[k] = k < 3 ? test_random(&state, -w, w) : w;
            e_clip[k] = test_random(&state, 0.1 * e, e);
        }
        const struct slack slack = clip_slack(&plan, clip, e_clip);
        double off[3]; /* of x, y and z over w */
        for (int k = 0; k < 3; k++)
            off[k] = (fabs(clip[k]) + e_clip[k]) / (w - e_clip[3]) - fabs(clip[k]) / w;
        const double ratio[3] = {fmax(0.5 * WIDE * off[0], 0.5 * HIGH * off[1]) / slack.px,
                                 0.5 * off[2] / slack.depth, e_clip[3] / w / slack.w};
        for (int k = 0; k < 3; k++) {
            least[k] = fmin(least[k], ratio[k]);
            most[k] = fmax(most[k], ratio[k]);
        }
    }
    for (int k = 0; k < 3; k++)
        if (!CHECK(least[k] > 0.98 && most[k] < 1.01,
                   "the slack of %s is what errors of clip coordinates make, to first order",
                   k == 0   ? "a place"
                   : k == 1 ? "a depth"
                            : "w"))
            printf("# %g to %g\n", least[k], most[k]);
}

/* A triangle may turn the other way exactly where some of its corners, moved to the ends of their
 * errors, make it do so; the sum of all moves takes in a little more. */
static void check_turning(void)
{
    uint64_t state = 15;
    int missed = 0, turned = 0, wide = 0;
    for (int i = 0; i < 20000; i++) {
        struct screen_triangle triangle = {.surface = NULL};
        double *x = triangle.x, *y = triangle.y, e[3];
        bool turns = false;
        for (int c = 0; c < 3; c++) {
            x[c] = test_random(&state, 0, 2);
            y[c] = test_random(&state, 0, 2);
            e[c] = test_random(&state, 0, 0.4);
        }
        const double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        triangle.twice_area = fabs(area);
        for (int ends = 0; ends < 64; ends++) {
            double u[3], v[3];
            for (int c = 0; c < 3; c++) {
                u[c] = x[c] + (ends >> 2 * c & 1 ? e[c] : -e[c]);
                v[c] = y[c] + (ends >> 2 * c & 2 ? e[c] : -e[c]);
            }
            turns = turns ||
                    ((u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0])) * area <= 0;
        }
        const bool may = may_turn(&triangle, e);
        turned += turns;
        missed += turns && !may;
        wide += may && !turns;
    }
    if (!CHECK(missed == 0 && turned > 5000 && wide < 5000, "no triangle that may turn is missed"))
        printf("# %d of %d missed, %d too many\n", missed, turned, wide);
}

static void check_rigid(void)
{
    const struct matrix turned = matrix_rotation(30, (struct vector){1, 2, 2}),
                        twice = matrix_scaling((struct vector){2, 2, 2}),
                        nearly = matrix_scaling((struct vector){2, 2, 2 * (1 + 0.4e-6)}),
                        near_one = matrix_scaling((struct vector){1 + 1e-6, 1 + 1e-6, 1 + 1e-6}),
                        far_off = matrix_scaling((struct vector){1, 1, 1.5});
    CHECK(distance_from_rigid(&turned) < 1e-14 && distance_from_rigid(&twice) == 0 &&
              distance_from_rigid(&far_off) == 0,
          "what is rigid, and what no driver takes for it, has no distance from it");
    CHECK_NEAR(distance_from_rigid(&nearly) / 2.4e-6, 1, 1e-5,
               "a scale that is nearly even has one");
    CHECK_NEAR(distance_from_rigid(&near_one) / 6e-6, 1, 1e-5, "so has one that is nearly 1");
}

/* ---- textures ---- */

/* Returns the largest difference / bound of a texture's value at places within their error. */
static double texel_ratio(const struct texels *texels, const struct texel_point *at,
                          const struct texel_value *value, uint64_t *state)
{
    double worst = 0;
    for (int i = 0; i < 40; i++) {
        double place[TEXEL_PLACE], off[TEXEL_PLACE];
        for (int k = 0; k < TEXEL_PLACE; k++) {
            off[k] = (double)at->e_place[k] *
                     (i < 8 ? (i >> k & 1 ? 0.999 : -0.999) : test_random(state, -1, 1));
            place[k] = at->place[k] + off[k];
        }
        place[PLACE_DETAIL] = fmin(fmax(0, place[PLACE_DETAIL]), texels->n_levels - 1);
        off[PLACE_DETAIL] = place[PLACE_DETAIL] - at->place[PLACE_DETAIL];
        const double seen = texel_at(texels, place);
        worst = fmax(worst, fabs(seen - value->value) / value->error);
        if (value->is_straight)
            worst = fmax(worst,
                         fabs(seen - value->value - value->slope[PLACE_ACROSS] * off[PLACE_ACROSS] -
                              value->slope[PLACE_UP] * off[PLACE_UP] -
                              value->slope[PLACE_DETAIL] * off[PLACE_DETAIL]) /
                             value->rest);
    }
    return worst;
}

static void check_texel_point(void)
{
    const float off[2] = {0, 0.25F};
    const double s_t[2] = {0, -3};
    const struct texels texels = {NULL, 64, 32, false, 1};
    const struct texel_point at = texel_point(&texels, driver_of("llvmpipe"), s_t, off);
    CHECK_NEAR((double)at.e_place[0], 64 * roundings(4), 1e-9,
               "a coordinate of 0 is off by roundings of the width");
    CHECK_NEAR((double)at.e_place[1], 32 * (0.25 + roundings(16)), 1e-6,
               "others by those of themselves as well, and by their own error");
}

/* Levels of 7, 3 and 1 texels a side have values of their own here. */
static void check_texels(bool linear, int n_levels, double widest)
{
    enum { SIDE = 7, TEXELS = 49 + 9 + 1, TRIALS = 20000 };
    uint64_t state = 13;
    float values[TEXELS];
    double worst = 0;
    int straight = 0, tight = 0;
    for (int i = 0; i < TRIALS; i++) {
        const struct texels texels = {values, SIDE, SIDE, linear, n_levels};
        struct texel_point at = {.e_weights = 0};
        struct texel_value value;
        for (int t = 0; t < TEXELS && i % 100 == 0; t++)
            values[t] = (float)test_random(&state, 0, 1);
        for (int k = 0; k < 2; k++) {
            at.place[k] = test_random(&state, -SIDE, 2 * SIDE);
            at.e_place[k] = (float)pow(10, test_random(&state, -3, log10(widest)));
        }
        if (n_levels > 1) {
            at.place[PLACE_DETAIL] = test_random(&state, 0, n_levels - 1);
            at.e_place[PLACE_DETAIL] =
                (float)pow(10, test_random(&state, -3, log10(fmin(2, widest))));
        }
        texel_value(&texels, &at, 1, &value);
        const double ratio = value.error > 0 ? texel_ratio(&texels, &at, &value, &state) : 0;
        worst = fmax(worst, ratio);
        straight += value.is_straight;
        tight += ratio > 0.3;
    }
    if (!CHECK(
            worst <= 1 && tight > TRIALS / 10 && (straight > TRIALS / 10) == linear,
            "the bound of %s texels of %d levels holds within %g texels, and is not far too wide",
            linear ? "linear" : "nearest", n_levels, widest))
        printf("# worst difference / bound %g, %d straight, %d tight\n", worst, straight, tight);
}

/* Mixes four texels by weights in steps of 1/256: those of each direction round to a step, their
 * products again, two up and two down. */
static double mix_by_steps(const struct texels *texels, const double *place, int way)
{
    static const int up[3][4] = {{1, 1, -1, -1}, {1, -1, 1, -1}, {1, -1, -1, 1}};
    const double x = floor(place[0] - 0.5), y = floor(place[1] - 0.5),
                 u = nearbyint(256 * (place[0] - 0.5 - x)) / 256,
                 v = nearbyint(256 * (place[1] - 0.5 - y)) / 256;
    double sum = 0;
    for (int k = 0; k < 4; k++) {
        const double weight = (k & 1 ? u : 1 - u) * (k >> 1 ? v : 1 - v);
        const double off = up[way % 3][k] * (way < 3 ? 1 : -1) / 512.0;
        const double at[TEXEL_PLACE] = {x + (k & 1) + 0.5, y + (k >> 1) + 0.5};
        sum += (weight + off) * texel_at(texels, at);
    }
    return sum;
}

static void check_weights(void)
{
    enum { SIDE = 8, TRIALS = 20000 };
    const float exact[2] = {0, 0};
    uint64_t state = 17;
    float values[SIDE * SIDE];
    const struct texels texels = {values, SIDE, SIDE, true, 1};
    struct driver driver = *driver_of("llvmpipe");
    double worst = 0, worst_beside = 0;
    driver.filter_texels = 1 / 512.0;
    for (int i = 0; i < TRIALS; i++) {
        const double s_t[2] = {test_random(&state, -1, 2), test_random(&state, -1, 2)};
        for (int t = 0; t < SIDE * SIDE && i % 100 == 0; t++)
            values[t] = (float)(test_random(&state, 0, 1) < 0.5);
        const struct texel_point at = texel_point(&texels, &driver, s_t, exact);
        struct texel_value value;
        texel_value(&texels, &at, 1, &value);
        double *most = value.is_straight ? &worst : &worst_beside;
        for (int way = 0; way < 6; way++)
            *most = fmax(*most, fabs(mix_by_steps(&texels, at.place, way) - value.value) /
                                    fmax(value.error, 1e-300));
    }
    if (!CHECK(worst <= 1 && worst > 0.9 && worst_beside <= 1 && worst_beside > 0.5,
               "the bound holds for weights that round as products of two, and is not too wide"))
        printf("# worst difference / bound %g, near a texel's centre %g\n", worst, worst_beside);
}

/* The interval of the level of detail takes in that of all steps within their bounds, for each norm
 * and logarithm; of a table it is two values, where only two are near. */
static void check_detail(void)
{
    enum { TRIALS = 20000, RULES = 6 };
    const struct texels texels = {NULL, 256, 64, true, 9};
    uint64_t state = 19;
    int missed = 0, pairs = 0;
    double widest = 0, widest_any = HUGE_VAL;
    for (int i = 0; i < TRIALS; i++) {
        struct driver driver = *driver_of("llvmpipe");
        double steps[2][2], errors[2][2], seen[2][2];
        struct texel_point at = {.e_weights = 0};
        driver.detail =
            (struct detail_rule){.largest = i % 2, .logarithm = (enum detail_logarithm)(i / 2 % 3)};
        for (int k = 0; k < 4; k++) {
            const double step = pow(10, test_random(&state, -1, 2));
            steps[k / 2][k % 2] = k % 3 ? step : -step;
            errors[k / 2][k % 2] = step * pow(10, test_random(&state, -6, -3));
            seen[k / 2][k % 2] =
                steps[k / 2][k % 2] + errors[k / 2][k % 2] * test_random(&state, -1, 1);
        }
        texel_detail(&texels, &driver, steps, errors, &at);
        const double detail = detail_of(&driver.detail, texels.n_levels, seen),
                     e = (double)at.e_place[PLACE_DETAIL];
        missed += fabs(detail - at.place[PLACE_DETAIL]) > e && fabs(detail - at.other) > e;
        pairs += at.other != at.place[PLACE_DETAIL];
        widest = fmax(widest, e);
    }
    for (int i = 0; i < RULES; i++) {
        struct driver driver = *driver_of("llvmpipe");
        double steps[2][2] = {{1, 2}, {3, (double)NAN}},
               errors[2][2] = {{0, 0}, {HUGE_VAL, HUGE_VAL}};
        struct texel_point at = {.e_weights = 0};
        driver.detail =
            (struct detail_rule){.largest = i % 2, .logarithm = (enum detail_logarithm)(i / 2)};
        texel_detail(&texels, &driver, steps, errors, &at);
        widest_any = fmin(widest_any, at.place[PLACE_DETAIL] + (double)at.e_place[PLACE_DETAIL]);
    }
    CHECK(widest_any >= texels.n_levels - 1, "a step without a bound may lead to any level");
    if (!CHECK(missed == 0 && pairs > 100 && pairs < TRIALS / 10 && widest < 0.01,
               "the level of detail lies within its bound, by any rule"))
        printf("# %d missed, %d pairs, widest %g\n", missed, pairs, widest);
}

int main(void)
{
    check_shown();
    check_slack();
    check_turning();
    check_rigid();
    check_texel_point();
    check_texels(true, 1, 0.1);
    check_texels(true, 1, 40);
    check_texels(false, 1, 40);
    check_texels(true, 3, 0.1);
    check_texels(true, 3, 40);
    check_detail();
    check_weights();
    return test_end();
}
