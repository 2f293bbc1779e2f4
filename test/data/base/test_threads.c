/* SPDX-License-Identifier: MIT */
/* A loop does each part once, on any number of threads. Stages hand over all that they make, in its
 * order, whether they work side by side or one at a time. Where one fails, all end. A stage that
 * waits sleeps. */
#include "data/base/inside.h"
#include "test.h"

#include <time.h>

/* ---- loops ---- */

enum { MOST = 5000 };
struct counts {
    int of[MOST]; /* each is changed by one thread only, if the loop is right */
    struct counter calls;
};

static void count_one(void *context, int i)
{
    struct counts *counts = context;
    counts->of[i]++;
    counter_add(&counts->calls, 1);
}

static bool all_once(const struct counts *counts, int n)
{
    for (int i = 0; i < MOST; i++)
        if (counts->of[i] != (i < n))
            return false;
    return true;
}

static void test_loops(void)
{
    static const int threads[] = {0, 1, 2, 3, 64}, lengths[] = {0, 1, 2, 63, MOST};
    static struct counts counts;
    for (size_t t = 0; t < 5; t++)
        for (size_t l = 0; l < 5; l++) {
            const int n = lengths[l];
            counts = (struct counts){.calls = COUNTER};
            threads_each(threads[t], n, count_one, &counts);
            CHECK(all_once(&counts, n) && counts.calls.n == (uint64_t)n,
                  "%d threads do each of %d parts once", threads[t], n);
        }
}

static void test_numbers(void)
{
    CHECK(threads_count(3) == 3 && threads_count(1 << 30) == MOST_THREADS && threads_count(0) >= 1,
          "as many threads as wanted, up to the most; 0: as many as processors");
}

/* ---- stages ---- */

enum { PLACES = 3, NO_FAILURE = -1, MADE, TAKEN };
/* Numbers that one stage makes, and another takes. */
struct numbers {
    struct pipeline pipeline;
    struct places made;
    long made_at[PLACES];
    int n, ahead; /* how many; so many places are looked at before the first is freed */
    int fails;    /* a stage, at half of the numbers; or NO_FAILURE */
    int n_made;
    long taken; /* how many came, in order */
    bool right; /* all of them */
    bool slow;  /* the first stage sleeps for 0.1 s before each number */
};

static bool fail_at(const struct numbers *of, int which, int i, struct error *err)
{
    return !(of->fails == which && i == of->n / 2) ||
           error_usage(err, "stage %d fails at %d", which, i);
}

static bool make_number(void *context, struct error *err)
{
    struct numbers *of = context;
    const int i = of->n_made, place = i < of->n ? places_wait(&of->made, 0) : -1;
    if (place < 0 || !fail_at(of, MADE, i, err))
        return false;
    if (of->slow)
        nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
    of->made_at[place] = of->n_made++;
    places_set(&of->made, place, i + 1);
    return true;
}

/* Looks at the numbers as far ahead as it may, then frees the first. */
static bool take_numbers(void *context, struct error *err)
{
    struct numbers *of = context;
    for (int i = 0; i < of->n; i++) {
        const int ahead = of->ahead < of->n - 1 - i ? of->ahead : of->n - 1 - i;
        const int last = places_wait(&of->made, i + ahead + 1),
                  first = places_wait(&of->made, i + 1);
        if (last < 0 || first < 0 || !fail_at(of, TAKEN, i, err))
            return false;
        of->right = of->right && of->made_at[last] == i + ahead && of->made_at[first] == i;
        of->taken++;
        places_set(&of->made, first, 0);
    }
    return true;
}

static bool run(struct numbers *of, bool alone, struct error *err)
{
    of->made = (struct places){.pipeline = &of->pipeline, .n = PLACES};
    of->right = true;
    of->pipeline =
        (struct pipeline){.make = make_number, .take = take_numbers, .context = of, .alone = alone};
    *err = (struct error){.status = EXIT_AGREED};
    return pipeline_run(&of->pipeline, err);
}

static void test_stages(void)
{
    for (int alone = 0; alone < 2; alone++)
        for (int ahead = 0; ahead < PLACES; ahead++)
            for (int n = 0; n < 2000; n = 3 * n + 1) {
                struct numbers of = {.n = n, .ahead = ahead, .fails = NO_FAILURE};
                struct error err;
                CHECK(run(&of, alone == 1, &err) && of.right && of.taken == n,
                      "%d numbers pass two stages in order, %d ahead, %s", n, ahead,
                      alone == 1 ? "one at a time" : "side by side");
            }
}

static void test_failing(void)
{
    for (int alone = 0; alone < 2; alone++)
        for (int fails = MADE; fails <= TAKEN; fails++) {
            struct numbers of = {.n = 500, .fails = fails};
            struct error err;
            char text[64];
            snprintf(text, sizeof text, "error: stage %d fails at 250", fails);
            CHECK(!run(&of, alone == 1, &err) && strcmp(err.text, text) == 0 &&
                      err.status == EXIT_INPUT,
                  "where stage %d fails, both end, with its error: %s", fails, err.text);
            CHECK(of.right && of.taken <= 250, "until then all was right: %ld numbers", of.taken);
        }
}

/* The second stage waits for the first, which sleeps for 0.4 s in all. Spinning would take 0.4 s of
 * a processor or more. */
static void test_waiting(void)
{
    for (int alone = 0; alone < 2; alone++) {
        struct numbers of = {.n = 4, .fails = NO_FAILURE, .slow = true};
        struct error err;
        const clock_t before = clock();
        CHECK(run(&of, alone == 1, &err) && of.taken == 4, "stages wait");
        const double seconds = (double)(clock() - before) / CLOCKS_PER_SEC;
        CHECK(seconds < 0.1, "while they wait, they take no processor: %g s", seconds);
    }
}

int main(void)
{
    test_loops();
    test_numbers();
    test_stages();
    test_failing();
    test_waiting();
    return test_end();
}
