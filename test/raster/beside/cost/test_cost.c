/* SPDX-License-Identifier: MIT */
/* Conclusions from times and errors, and processes that return a result. The times are invented
 * here, so that the right conclusions are known. */
#include "data/base/base.h"
#include "data/scene/scene.h"
#include "raster/beside/cost/inside.h"
#include "spectral.h"
#include "test.h"

/* ---- the frontier ---- */

static struct cost_entry entry(double fastest, double seconds, double slowest, double error)
{
    return (struct cost_entry){.fastest = fastest,
                               .seconds = seconds,
                               .slowest = slowest,
                               .accuracy = {.mean = error / 2,
                                            .quantile_95 = error,
                                            .largest = 2 * error,
                                            .radiance = (double)NAN}};
}

static void frontier(void)
{
    struct cost_entry entries[] = {
        entry(0.9, 1, 1.1, 5),   /* the fastest */
        entry(1.9, 2, 2.1, 6),   /* slower and worse than that */
        entry(2.9, 3, 3.5, 2),   /* better; may be slower than the next */
        entry(3.4, 3.6, 3.8, 2), /* as good, and may be faster */
        entry(3.9, 4, 4.1, 2.5), /* slower and worse by more than noise */
        entry(8, 9, 10, 0),      /* the best */
    };
    struct cost cost = {.entries = entries, .n = 6};
    struct cost_entry equals[] = {entry(1, 1, 1, 3), entry(1, 1, 1, 3)};
    static const bool best[] = {true, false, true, false, false, true};
    static const bool uncertain[] = {false, false, true, true, false, false};
    cost_mark(&(struct cost){.entries = equals, .n = 2});
    CHECK(equals[0].best && equals[1].best && !equals[0].uncertain,
          "two equal entries are both on the frontier");
    cost_mark(&cost);
    for (int i = 0; i < cost.n; i++) {
        CHECK(entries[i].best == best[i], "entry %d is %son the frontier", i,
              best[i] ? "" : "not ");
        CHECK(entries[i].uncertain == uncertain[i], "entry %d is %swithin noise", i,
              uncertain[i] ? "" : "not ");
    }
    CHECK(cost_advise(&cost, 2, HUGE_VAL, false).entry == &entries[2],
          "within an error of 2 the fastest entry is named");
    CHECK(cost_advise(&cost, 100, HUGE_VAL, false).entry == &entries[0],
          "within an error of 100 the fastest of all entries is named");
    CHECK(cost_advise(&cost, 0, HUGE_VAL, false).entry == &entries[5],
          "within an error of 0 the entry without error is named");
    CHECK(cost_advise(&cost, HUGE_VAL, 4, false).entry == &entries[2],
          "in 4 s the most accurate entry is named, and the faster of two equals");
    CHECK(cost_advise(&cost, HUGE_VAL, 1, false).entry == &entries[0], "a budget may be used up");
    CHECK(!cost_advise(&cost, HUGE_VAL, 0.99, false).entry, "in 0.99 s no entry is named");
    CHECK(!cost_advise(&cost, 100, HUGE_VAL, true).entry &&
              !cost_advise(&cost, HUGE_VAL, 100, true).entry,
          "no entry of the three has spectra");
    entries[4].accuracy.spectral = true;
    CHECK(cost_advise(&cost, 2.5, HUGE_VAL, true).entry == &entries[4] &&
              cost_advise(&cost, HUGE_VAL, 100, true).entry == &entries[4],
          "a request for spectra names the only entry that has them");
    entries[5].accuracy.quantile_95 = 0.5;
    CHECK(!cost_advise(&cost, 0.4, HUGE_VAL, false).entry, "within 0.4 no entry is named");
}

/* Times of the clock that overlap do not rank configurations; those of the processor do. */
static void rivals(void)
{
    struct cost_entry entries[] = {
        entry(0.9, 1, 1.5, 0.4),   /* the fastest */
        entry(1.4, 1.6, 2, 0.3),   /* overlaps it, and takes least of the processor */
        entry(1.3, 1.7, 2, 0.2),   /* overlaps it */
        entry(1.45, 1.8, 2, 0.9),  /* overlaps it, but its error is too large */
        entry(1.6, 1.9, 2.5, 0.1), /* overlaps the second, but not the fastest */
    };
    static const double processor[] = {3, 1, 2, 0.1, 0.2};
    struct cost cost = {.entries = entries, .n = 5};
    for (int i = 0; i < cost.n; i++)
        entries[i].processor = processor[i];
    struct advice advice = cost_advise(&cost, 0.5, HUGE_VAL, false);
    CHECK(advice.entry == &entries[1] && advice.n_rivals == 2,
          "of three whose times overlap, the one with the least processor time is named");
    advice = cost_advise(&cost, 0.1, HUGE_VAL, false);
    CHECK(advice.entry == &entries[4] && advice.n_rivals == 0, "an entry alone has no rivals");
    advice = cost_advise(&cost, HUGE_VAL, 1.75, false);
    CHECK(advice.entry == &entries[2] && advice.n_rivals == 0,
          "the most accurate entry has no rivals that are less accurate");
    entries[1].accuracy.quantile_95 = 0.2;
    advice = cost_advise(&cost, HUGE_VAL, 1.75, false);
    CHECK(advice.entry == &entries[1] && advice.n_rivals == 1,
          "of two that are as accurate, the one with the least processor time is named");
}

/* ---- configurations ---- */

static const struct cost_entry *named(const struct cost *cost, const char *name)
{
    for (int i = 0; i < cost->n; i++)
        if (strcmp(cost->entries[i].name, name) == 0)
            return &cost->entries[i];
    return NULL;
}

/* Entries as they are added without any measurement: the chosen sampling is that of the scene. */
static void configurations(void)
{
    static struct cost_entry entries[MOST_CONFIGURATIONS];
    struct cost cost = {.entries = entries, .positions = 4, .tessellated = true, .shaded = true};
    configurations_first(&cost);
    entries[1].accuracy.rank = 3;
    configurations_samplings(&cost);
    const int n = cost.n;
    configurations_samplings(&cost);
    CHECK(cost.n == n, "nothing is added twice");
    CHECK(named(&cost, "basis:2 phong x4") && named(&cost, "basis:3 phong x4") &&
              !named(&cost, "basis:4 phong x4"),
          "a basis has at most as many components as the products");
    CHECK(named(&cost, "gauss:12 phong x4") && !named(&cost, "adaptive:0.1 phong x4"),
          "without peaks the light is smooth");
    configurations_styles(&cost);
    CHECK(named(&cost, "own wavelengths flat x2") && named(&cost, "accuracy:0.5 smooth") &&
              named(&cost, "own wavelengths phong x4 depth 32f"),
          "styles, accuracies and depths are named");
    CHECK(named(&cost, "own wavelengths smooth samples 2") &&
              !named(&cost, "own wavelengths smooth samples 4"),
          "fewer positions than those asked for are tried");
}

static void words(void)
{
    struct error err = {.status = EXIT_AGREED};
    struct cost_entry seen = {.sampling = "gauss:8,open",
                              .options = "--shading=smooth --renderer=llvmpipe --depth=32f"};
    static const char *const expected[] = {"--sampling=gauss:8,open", "--detector=my observer",
                                           "--shading=smooth", "--renderer=llvmpipe",
                                           "--depth=32f"};
    CHECK(entry_words(&seen, "my observer", &err) && seen.n_words == 5,
          "a configuration has a word for each option");
    for (int i = 0; i < seen.n_words && i < 5; i++)
        CHECK_TEXT(seen.words[i], expected[i], "word %d is %s", i + 1, expected[i]);
    cost_entry_free(&seen);
    seen = (struct cost_entry){.sampling = "accuracy:0.5"};
    CHECK(entry_words(&seen, "cie1931", &err) && seen.n_words == 1,
          "the default observer adds no word");
    CHECK_TEXT(seen.words[0], "--accuracy=0.5", "an accuracy is no sampling");
    cost_entry_free(&seen);
    seen = standard_entry(&(struct cost){.positions = 2});
    CHECK(entry_words(&seen, "cie1931", &err) && seen.n_words == 8,
          "the standard has eight words, without an observer");
    CHECK_TEXT(seen.words[5], "--samples=4", "the standard has twice as many positions");
    CHECK_TEXT(seen.words[7], "--full-scale=65535",
               "the reference has a full scale, so that phong shading is never refused");
    cost_entry_free(&seen);
}

/* Names are in quotation marks: some have a comma. */
static void csv(void)
{
    struct cost_entry entries[] = {entry(1, 2, 3, 0.1)};
    struct cost cost = {.entries = entries, .n = 1};
    struct error err = {.status = EXIT_AGREED};
    strcpy(entries[0].sampling, "rgb");
    strcpy(entries[0].name, "rgb smooth");
    strcpy(entries[0].options, "--shading=smooth --renderer=raster --no-check");
    entry_words(&entries[0], "a \"film\".csv", &err);
    struct printed printed = {.text = NULL};
    cost_csv(&cost, &printed);
    char *text = printed_end(&printed);
    CHECK_TEXT(
        strchr(text, '\n') + 1,
        "\"rgb smooth\",\"--sampling=rgb --detector=a \"\"film\"\".csv --shading=smooth "
        "--renderer=raster --no-check\",2,0,1,3,0.05,0.1,0.2,,0,0\n",
        "a line of the table holds an observer with quotation marks in its name, and no radiances");
    free(text);
    cost_entry_free(&entries[0]);
}

int main(void)
{
    frontier();
    rivals();
    configurations();
    words();
    csv();
    return test_end();
}
