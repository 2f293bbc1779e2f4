/* SPDX-License-Identifier: MIT */
/* Conclusions from seconds and errors, which are invented here, so that the right ones are known.
 */
#include "raster/beside/cost/inside.h"
#include "test.h"

static struct configuration of(const char *words, bool components, double error, double seconds)
{
    struct configuration out = {
        .components = components, .error.quantile_95 = error, .unchecked = {{seconds}, 1}};
    snprintf(out.words, sizeof out.words, "%s", words);
    return out;
}

static void timings(void)
{
    static const double medians[] = {1, 1.5, 2, 2.5, 3};
    struct timing timing = {.seconds = {1, 2, 3, 4, 5}};
    CHECK(isnan(median_of(&timing)), "without a run there is no median");
    for (timing.n = 1; timing.n <= 5; timing.n++)
        CHECK_NEAR(median_of(&timing), medians[timing.n - 1], 0, "the median of %d runs is %g",
                   timing.n, medians[timing.n - 1]);
}

static const struct cost *invented(void)
{
    static struct cost cost;
    cost = (struct cost){.samplings = {of("close", false, 0.01, 9), of("poor", false, 5, 1),
                                       of("fair", false, 0.9, 2), of("as fair", false, 0.9, 3),
                                       of("beaten", false, 0.95, 2.5), of("rgb", true, 0.3, 0.5)},
                         .n = 6};
    return &cost;
}

static void cheapest(void)
{
    static const struct {
        double error;
        bool components;
        const char *name;
    } rows[] = {{10, false, "poor"},   {1, false, "fair"}, {0.9, false, "fair"},
                {0.5, false, "close"}, {0.001, false, ""}, {0.5, true, "rgb"},
                {0.1, true, ""}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct configuration *found =
            cost_cheapest(invented(), rows[i].error, rows[i].components);
        CHECK(strcmp(found ? found->words : "", rows[i].name) == 0,
              "within %g the cheapest %s is %s", rows[i].error,
              rows[i].components ? "of components" : "of radiances",
              rows[i].name[0] ? rows[i].name : "none");
    }
    CHECK(strcmp(cost_typical(invented())->words, "close") == 0,
          "the typical one is the cheapest of radiances within 0.5");
    struct cost few = {.samplings = {of("poor", false, 5, 1), of("rgb", true, 0.3, 0.5)}, .n = 2};
    CHECK(strcmp(cost_typical(&few)->words, "poor") == 0, "or else the most accurate of them");
    few.samplings[0].components = true;
    CHECK(cost_typical(&few) == &few.samplings[0], "or else the first");
}

static void frontier(void)
{
    static const char *const order[] = {"rgb", "poor", "fair", "beaten", "as fair", "close"};
    static const bool best[] = {true, true, true, false, false, true};
    struct cost cost = *invented();
    cost_mark(&cost);
    for (int i = 0; i < cost.n; i++)
        CHECK(strcmp(cost.samplings[i].words, order[i]) == 0 && cost.samplings[i].best == best[i],
              "%s is number %d by seconds, and %s", order[i], i + 1,
              best[i] ? "no cheaper one is closer" : "a cheaper one is as close");
}

int main(void)
{
    timings();
    cheapest();
    frontier();
    return test_end();
}
