/* SPDX-License-Identifier: MIT */
/* A baseline: the results of an earlier run, as a text file that a person can read. A line has the
 * library, GL_RENDERER, the scene, the verdict in one word, and how many pixels are not explained.
 * The version is not part of it: the question is whether a new version differs. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/index/index.h"
#include "raster/verify/verify.h"

static const char *const words[] = {"agreed", "differs", "not-verified", "failed", NULL};

void baseline_print(const struct verification *of, struct printed *to)
{
    print_text(to, "# " PROGRAM ", verify: library, GL_RENDERER, scene, verdict, pixels that are "
                   "not explained\n");
    for (int d = 0; d < of->n_drivers; d++)
        for (int s = 0; s < of->n_scenes; s++) {
            const struct verify_result *result = result_of(of, d, s);
            print(to, "\"%s\" \"%s\" \"%s\" %s %llu\n", of->drivers[d].names.library,
                  of->drivers[d].names.renderer, of->scenes[s].name, words[result->outcome],
                  (unsigned long long)result->check.unexplained);
        }
}

/* A line of the file. */
struct known {
    int outcome;
    double unexplained;
};

/* Finds the result that a line stands for; NULL: this run has none. */
static const struct verify_result *find_result(const struct verification *of,
                                               const struct word word[3])
{
    for (int d = 0; d < of->n_drivers; d++)
        for (int s = 0; s < of->n_scenes; s++)
            if (word_equals(&word[0], of->drivers[d].names.library) &&
                word_equals(&word[1], of->drivers[d].names.renderer) &&
                word_equals(&word[2], of->scenes[s].name))
                return result_of(of, d, s);
    return NULL;
}

/* Reads a line into the known result that it stands for. */
static bool read_line(struct text *text, const struct verification *of, struct known *known,
                      struct error *err)
{
    static const char *const names[3] = {"a library", "a GL_RENDERER", "a scene"};
    struct word word[3], more;
    double unexplained;
    if (!text_peek(*text, &more))
        return true;
    for (int i = 0; i < 3; i++)
        if (!text_expect(text, &word[i], names[i], err))
            return false;
    const int outcome = text_choose(text, "a verdict", words, "verdict", err);
    if (outcome < 0 || !text_number(text, "number of pixels", 0, HUGE_VAL, &unexplained, err) ||
        !text_end(text, "a result", err))
        return false;
    const struct verify_result *result = find_result(of, word);
    if (result)
        known[result - of->results] = (struct known){outcome, unexplained};
    return true;
}

/* Prints how a result is not as it was; a result that nobody knew must agree. */
static bool is_as_before(const struct verification *of, int driver, int scene,
                         const struct known *known, struct printed *to)
{
    const struct verify_result *result = result_of(of, driver, scene);
    const bool is_new = known->outcome < 0;
    char options[64];
    if (is_new ? result->outcome == VERIFY_AGREED
               : known->outcome == (int)result->outcome &&
                     known->unexplained == (double)result->check.unexplained)
        return true;
    driver_options(&of->drivers[driver], options);
    print(to, "%s%s: %s", of->scenes[scene].name, options, verify_words[result->outcome]);
    if (result->check.unexplained > 0)
        print(to, ", %llu pixels not explained", (unsigned long long)result->check.unexplained);
    if (is_new)
        print_text(to, "; not in the baseline\n");
    else
        print(to, "; in the baseline %s, %.0f pixels\n", verify_words[known->outcome],
              known->unexplained);
    return false;
}

bool baseline_compare(const struct verification *of, const char *path, struct printed *to,
                      int *differences, struct error *err)
{
    const int n = of->n_drivers * of->n_scenes;
    struct known *known = calloc((size_t)n, sizeof *known);
    struct text text;
    if (!known)
        return error_memory(err);
    for (int i = 0; i < n; i++)
        known[i].outcome = -1;
    bool done = text_open(&text, path, (struct place){NULL, 0, 0}, err);
    while (done && text_next_line(&text))
        done = read_line(&text, of, known, err);
    text_free(&text);
    *differences = 0;
    for (int i = 0; i < n && done; i++)
        *differences += !is_as_before(of, i / of->n_scenes, i % of->n_scenes, &known[i], to);
    free(known);
    return done;
}
