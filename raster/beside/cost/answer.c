/* SPDX-License-Identifier: MIT */
/* The answer to what accuracy costs: the cheapest way for each error, the prices of the check, of
 * positions and of triangles, and the table of all. */
#include "raster/beside/cost/inside.h"

const double wanted_errors[WANTED_ERRORS] = {2, 1, 0.5, 0.1};

/* ---- conclusions ---- */

const struct configuration *cost_cheapest(const struct cost *cost, double error, bool components)
{
    const struct configuration *best = NULL;
    for (int i = 0; i < cost->n; i++) {
        const struct configuration *one = &cost->samplings[i];
        if (one->components == components && one->error.quantile_95 <= error &&
            (!best || median_of(&one->unchecked) < median_of(&best->unchecked)))
            best = one;
    }
    return best;
}

/* Returns the cheapest within 0.5, or else the most accurate one. */
static const struct configuration *good_one(const struct cost *cost, bool components)
{
    double least = HUGE_VAL;
    for (int i = 0; i < cost->n; i++)
        if (cost->samplings[i].components == components)
            least = fmin(least, cost->samplings[i].error.quantile_95);
    return cost_cheapest(cost, fmax(least, 0.5), components);
}

const struct configuration *cost_typical(const struct cost *cost)
{
    const struct configuration *good = good_one(cost, false);
    return good ? good : &cost->samplings[0];
}

static int by_seconds(const void *a, const void *b)
{
    const double one = median_of(&((const struct configuration *)a)->unchecked),
                 two = median_of(&((const struct configuration *)b)->unchecked);
    return (one > two) - (one < two);
}

/* Returns whether the answer names a configuration. */
static bool is_named(const struct cost *cost, const struct configuration *of)
{
    bool named = of == cost_typical(cost) || of == good_one(cost, true);
    for (int i = 0; i < WANTED_ERRORS; i++)
        named = named || of == cost_cheapest(cost, wanted_errors[i], false);
    return named;
}

void cost_mark(struct cost *cost)
{
    double least[2] = {HUGE_VAL, HUGE_VAL};
    qsort(cost->samplings, (size_t)cost->n, sizeof *cost->samplings, by_seconds);
    for (int i = 0; i < cost->n; i++) {
        struct configuration *one = &cost->samplings[i];
        one->best = one->error.quantile_95 < least[one->components];
        one->named = is_named(cost, one);
        least[one->components] = fmin(least[one->components], one->error.quantile_95);
    }
}

/* ---- the table ---- */

/* Prints those that somebody would choose, and the words of the others. */
static void print_table(const struct cost *cost, struct printed *to)
{
    print(to, "\n%-26s %8s %9s %8s %8s %8s\n", "sampling", "checked", "unchecked", "95 %", "mean",
          "largest");
    for (int i = 0; i < cost->n; i++) {
        const struct configuration *of = &cost->samplings[i];
        char checked[16] = "";
        if (of->checked.n > 0)
            snprintf(checked, sizeof checked, "%.3f", median_of(&of->checked));
        if (of->best)
            print(to, "%-26s %8s %9.3f %8.3g %8.3g %8.3g  %s\n", of->words, checked,
                  median_of(&of->unchecked), of->error.quantile_95, of->error.mean,
                  of->error.peak.largest, of->components ? "no spectra" : "");
    }
    print_text(to, "dearer, not closer:");
    for (int i = 0; i < cost->n; i++)
        if (!cost->samplings[i].best)
            print(to, " %s", cost->samplings[i].words + strlen("--sampling="));
    print_text(to, "\n");
    for (int i = 0; i < cost->n_notes; i++)
        print(to, "without %s\n", cost->notes[i]);
}

/* ---- the answer ---- */

static void print_seconds(const struct configuration *of, struct printed *to)
{
    if (of->checked.n > 0)
        print(to, "%.2g s checked (%.2g unchecked)", median_of(&of->checked),
              median_of(&of->unchecked));
    else
        print(to, "%.2g s", median_of(&of->unchecked));
}

static void print_way(const struct cost *cost, const char *name, const struct configuration *of,
                      struct printed *to)
{
    print(to, "%-20s%-26s ", name, of->words);
    print_seconds(of, to);
    print(to, ", %.2g times cheaper than every nm; error %.3g\n",
          median_of(&cost->every_nm.unchecked) / median_of(&of->unchecked), of->error.quantile_95);
}

/* Prints a line for each way; one that is cheapest for several errors has them all. */
static void print_ways(const struct cost *cost, struct printed *to)
{
    for (int i = 0, n; i < WANTED_ERRORS; i += n) {
        const struct configuration *way = cost_cheapest(cost, wanted_errors[i], false);
        char errors[48];
        int length = snprintf(errors, sizeof errors, "within %g", wanted_errors[i]);
        for (n = 1;
             i + n < WANTED_ERRORS && cost_cheapest(cost, wanted_errors[i + n], false) == way; n++)
            length += snprintf(errors + length, sizeof errors - (size_t)length, ", %g",
                               wanted_errors[i + n]);
        if (way)
            print_way(cost, errors, way, to);
        else
            print(to, "%-20snone of those tried\n", errors);
    }
}

static void print_check(const struct cost *cost, struct printed *to)
{
    const double checked = median_of(&cost->typical->checked), opengl = median_of(&cost->opengl),
                 reference = median_of(&cost->typical->unchecked);
    if (!cost->checked)
        print_text(to, "check               none: the reference draws alone\n");
    else
        print(to,
              "check               %.2g s: OpenGL takes %.2g, the reference %.2g, comparing the "
              "rest\n",
              checked, opengl, reference);
}

/* Prints what halving an error costs. */
static void print_refinement(const struct cost *cost, const char *name, const char *what,
                             const struct refinement *of, struct printed *to)
{
    if (isnan(of->before)) {
        print(to, "%-20snot known: there is nothing finer\n", name);
        return;
    }
    print(to, "%-20s%s %.2g", name, what, of->before);
    if (of->words[0])
        print(to, ";%s: %.2g, for %.2g times the seconds", of->words, of->after, of->factor);
    if (of->words[0] && of->after < of->before)
        print(to, "; each halving costs %.2g times",
              power(fmax(of->factor, 1), 1 / binary_logarithm(of->before / of->after)));
    if (cost->small_width < cost->width)
        print(to, " (at %d x %d)", cost->small_width, cost->small_height);
    print_text(to, "\n");
}

/* Prints the command that renders what errors are from. */
static void print_standard(const struct options *options, struct printed *to)
{
    print_text(to, "errors              from every nm; compare shows them:\n  spectral render");
    print_shell(to, options_scene(options));
    for (int i = 0; i < options->n_recorded; i++)
        print_shell(to, options->recorded[i]);
    if (options->detector) {
        print_text(to, " --detector");
        print_shell(to, options->detector);
    }
    print_text(to, " --sampling=riemann:1 --depth=32f --renderer=raster --no-check "
                   "-o every-nm.tif\n");
}

void cost_print(const struct options *options, const struct cost *cost, struct printed *to)
{
    const struct configuration *without_spectra = good_one(cost, true);
    print(to,
          "scene               %s, %d x %d pixels, seen by %s\n"
          "                    seconds of processors, unchecked by the reference alone; "
          "CIEDE2000 of 95 %% of the pixels\n",
          cost->scene, cost->width, cost->height, cost->observer);
    print_ways(cost, to);
    print(to, "%-20s%-26s ", "every nm", "--sampling=riemann:1");
    print_seconds(&cost->every_nm, to);
    print_text(to, "\n");
    if (without_spectra)
        print_way(cost, "without spectra", without_spectra, to);
    print_check(cost, to);
    print_refinement(cost, "samples of a pixel", "on average off by", &cost->positions, to);
    print_refinement(cost, "triangles", "light is off by", &cost->triangles, to);
    print_standard(options, to);
    if (cost->n_not_agreed > 0)
        print(to, "%d of %d pictures did not agree: spectral render says why\n", cost->n_not_agreed,
              cost->n_runs);
    if (options->verbose)
        print_table(cost, to);
}

/* ---- as CSV and JSON ---- */

void cost_csv(const struct cost *cost, struct printed *to)
{
    print_text(to, "options,checked,unchecked,runs,dE00_mean,dE00_95,dE00_largest,spectra,best\n");
    for (int i = 0; i < cost->n; i++) {
        const struct configuration *of = &cost->samplings[i];
        print_text(to, "\"");
        csv_text(of->words, to);
        print_text(to, "\",");
        if (of->checked.n > 0)
            print(to, "%.9g", median_of(&of->checked));
        print(to, ",%.9g,%d,%.9g,%.9g,%.9g,%d,%d\n", median_of(&of->unchecked), of->unchecked.n,
              of->error.mean, of->error.quantile_95, of->error.peak.largest, !of->components,
              of->best);
    }
}

static void json_row(struct json *json, const char *key, const struct configuration *of)
{
    json_open(json, key, '{');
    json_string(json, "options", of->words);
    json_number(json, "checked_seconds", median_of(&of->checked));
    json_number(json, "unchecked_seconds", median_of(&of->unchecked));
    json_count(json, "runs", (uint64_t)of->unchecked.n);
    json_number(json, "dE00_mean", of->error.mean);
    json_number(json, "dE00_95", of->error.quantile_95);
    json_number(json, "dE00_largest", of->error.peak.largest);
    json_truth(json, "spectra", !of->components);
    json_truth(json, "best", of->best);
    json_close(json, '}');
}

static void json_refinement(struct json *json, const char *key, const struct refinement *of)
{
    json_open(json, key, '{');
    json_string(json, "options", of->words[0] ? of->words + 1 : NULL);
    json_number(json, "before", of->before);
    json_number(json, "after", of->words[0] ? of->after : (double)NAN);
    json_number(json, "times", of->words[0] ? of->factor : (double)NAN);
    json_close(json, '}');
}

void cost_json(const struct cost *cost, struct json *json)
{
    json_begin(json);
    json_string(json, "program", PROGRAM);
    json_string(json, "scene", cost->scene);
    json_count(json, "width", (uint64_t)cost->width);
    json_count(json, "height", (uint64_t)cost->height);
    json_string(json, "observer", cost->observer);
    json_row(json, "every_nm", &cost->every_nm);
    json_open(json, "samplings", '[');
    for (int i = 0; i < cost->n; i++)
        json_row(json, NULL, &cost->samplings[i]);
    json_close(json, ']');
    json_string(json, "typical", cost->typical->words);
    json_number(json, "opengl_seconds", median_of(&cost->opengl));
    json_refinement(json, "positions", &cost->positions);
    json_refinement(json, "triangles", &cost->triangles);
    json_count(json, "pictures", (uint64_t)cost->n_runs);
    json_count(json, "not_agreed", (uint64_t)cost->n_not_agreed);
    json_strings(json, "notes", (const char *const *)cost->notes, cost->n_notes);
}
