/* SPDX-License-Identifier: MIT */
/* Draws conclusions from measurements: the frontier, recommendations, tables and the chart. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>

#include "raster/beside/cost/inside.h"

void cost_entry_free(struct cost_entry *entry)
{
    FREE_ALL(entry->text, entry->times);
    *entry = (struct cost_entry){.n_words = 0};
}

void cost_free(struct cost *cost)
{
    for (int i = 0; cost->entries && i < cost->n; i++)
        cost_entry_free(&cost->entries[i]);
    for (int i = 0; cost->notes && i < cost->n_notes; i++)
        free(cost->notes[i]);
    FREE_ALL(cost->entries, cost->notes, cost->scene);
    *cost = (struct cost){.scene = NULL};
}

bool cost_note(struct cost *cost, struct error *err, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    char *note;
    if (string_copy(text, &note, err) &&
        array_add(&cost->notes, &cost->n_notes, &note, sizeof note, err))
        return true;
    free(note);
    return false;
}

/* ---- the frontier ---- */

/* Chooses one of an entry's times: the median, the fastest, or the slowest. */
enum luck { NO_LUCK, GOOD_LUCK, BAD_LUCK };

static double seconds_with(const struct cost_entry *entry, enum luck luck)
{
    return luck == GOOD_LUCK ? entry->fastest : luck == BAD_LUCK ? entry->slowest : entry->seconds;
}

/* Returns whether another entry is better than this one in seconds or error, and not worse in the
 * other. */
static bool is_dominated(const struct cost *cost, int index, enum luck own, enum luck others)
{
    const double error = cost->entries[index].accuracy.quantile_95,
                 seconds = seconds_with(&cost->entries[index], own);
    for (int i = 0; i < cost->n; i++) {
        const double other_error = cost->entries[i].accuracy.quantile_95,
                     other_seconds = seconds_with(&cost->entries[i], others);
        if (i != index && other_seconds <= seconds && other_error <= error &&
            (other_seconds < seconds || other_error < error))
            return true;
    }
    return false;
}

/* The true median of a time lies between the fastest and the slowest of n runs unless all n fall on
 * one side of it: with probability 1 - 2/2^n, of 5 runs 94 % (David and Nagaraja, Order Statistics,
 * 2003, 7.1). */
void cost_mark(struct cost *cost)
{
    for (int i = 0; i < cost->n; i++) {
        struct cost_entry *entry = &cost->entries[i];
        entry->best = !is_dominated(cost, i, NO_LUCK, NO_LUCK);
        entry->uncertain = entry->best ? is_dominated(cost, i, BAD_LUCK, GOOD_LUCK)
                                       : !is_dominated(cost, i, GOOD_LUCK, BAD_LUCK);
    }
}

/* Limits of the entries that a recommendation may name. */
struct limits {
    double error, seconds;
    bool spectral;
};

static bool is_within(const struct cost_entry *entry, const struct limits *limits)
{
    return entry->accuracy.quantile_95 <= limits->error && entry->seconds <= limits->seconds &&
           (entry->accuracy.spectral || !limits->spectral);
}

/* Compares the best entry with its rivals: those within the same limits whose times overlap its
 * own. Wall time cannot rank them, and processor time scatters less. Entries are sorted by seconds,
 * so the first one within the limits is the fastest. Errors have no noise, so that the rivals of
 * the most accurate entry are as accurate. */
struct advice cost_advise(const struct cost *cost, double error, double seconds, bool spectral)
{
    const bool accurate = error == HUGE_VAL; /* the fastest is wanted otherwise */
    struct limits limits = {error, seconds, spectral};
    const struct cost_entry *best = NULL;
    for (int i = 0; i < cost->n && (accurate || !best); i++)
        if (is_within(&cost->entries[i], &limits) &&
            (!best || cost->entries[i].accuracy.quantile_95 < limits.error)) {
            best = &cost->entries[i];
            limits.error = accurate ? best->accuracy.quantile_95 : error;
        }
    struct advice advice = {best, 0};
    for (int i = 0; best && i < cost->n; i++) {
        const struct cost_entry *rival = &cost->entries[i];
        const bool overlap = rival->fastest <= best->slowest && best->fastest <= rival->slowest;
        if (rival == best || !is_within(rival, &limits) || !overlap)
            continue;
        advice.n_rivals++;
        if (rival->processor < advice.entry->processor)
            advice.entry = rival;
    }
    return advice;
}

/* ---- tables ---- */

static void print_entry(const struct cost_entry *entry, struct printed *to)
{
    print(to, "%s%s %-40s %8.3f %9.3f  %7.3f..%-7.3f %8.3g %8.3g %8.3g ", entry->best ? "*" : " ",
          entry->uncertain ? "~" : " ", entry->name, entry->seconds, entry->processor,
          entry->fastest, entry->slowest, entry->accuracy.mean, entry->accuracy.quantile_95,
          entry->accuracy.largest);
    if (isnan(entry->accuracy.radiance))
        print(to, "%9s\n", "-");
    else
        print(to, "%9.3g\n", entry->accuracy.radiance);
}

void cost_print(const struct cost *cost, struct printed *to)
{
    print(to,
          "scene             %s, %d x %d pixels\n"
          "observer          %s\n"
          "runs              %d of each configuration after a warm-up, one after the other,\n"
          "                  each from exec to exit; seconds are the median, fastest and\n"
          "                  slowest; processor: the median of user's and system's seconds\n"
          "standard          every nm, phong shading, tessellation 4, in double: %.3g s\n\n",
          cost->scene, cost->width, cost->height, cost->observer, cost->runs,
          cost->standard_seconds);
    print(to, "   %-40s %8s %9s  %16s %8s %8s %8s %9s\n", "configuration", "seconds", "processor",
          "fastest..slowest", "dE00", "95 %", "largest", "radiance");
    for (int i = 0; i < cost->n; i++)
        print_entry(&cost->entries[i], to);
    print(
        to,
        "\n"
        "*  on the frontier: no other is both faster and closer for 95 %% of the pixels\n"
        "~  within noise: times between fastest and slowest would put it on the frontier, or off;\n"
        "   a true median is between them with a probability of %.4g %%\n",
        100 * (1 - ldexp(2, -cost->runs)));
    print_text(
        to,
        "dE00 is CIEDE2000 over the pixels that show an object: mean, 95 %, largest; radiance is "
        "the\n"
        "rms error of radiances at every nm, relative to theirs, - where pages determine none\n");
    for (int i = 0; i < cost->n_notes; i++)
        print(to, "%s- %s\n", i == 0 ? "\n" : "", cost->notes[i]);
}

static void print_csv_entry(const struct cost_entry *entry, struct printed *to)
{
    print(to, "\"%s\",\"", entry->name);
    for (int i = 0; i < entry->n_words; i++) {
        print_text(to, i > 0 ? " " : "");
        csv_text(entry->words[i], to);
    }
    print(to, "\",%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,", entry->seconds, entry->processor,
          entry->fastest, entry->slowest, entry->accuracy.mean, entry->accuracy.quantile_95,
          entry->accuracy.largest);
    if (!isnan(entry->accuracy.radiance))
        print(to, "%.9g", entry->accuracy.radiance);
    print(to, ",%d,%d\n", entry->best, entry->uncertain);
}

void cost_csv(const struct cost *cost, struct printed *to)
{
    print_text(to, "name,options,seconds,processor,fastest,slowest,dE00_mean,dE00_95,dE00_largest,"
                   "radiance_error,frontier,within_noise\n");
    for (int i = 0; i < cost->n; i++)
        print_csv_entry(&cost->entries[i], to);
}

static void json_entry(struct json *json, const struct cost_entry *entry)
{
    json_open(json, NULL, '{');
    json_string(json, "name", entry->name);
    json_strings(json, "options", (const char *const *)entry->words, entry->n_words);
    json_number(json, "seconds", entry->seconds);
    json_number(json, "processor_seconds", entry->processor);
    json_number(json, "fastest", entry->fastest);
    json_number(json, "slowest", entry->slowest);
    json_number(json, "dE00_mean", entry->accuracy.mean);
    json_number(json, "dE00_95", entry->accuracy.quantile_95);
    json_number(json, "dE00_largest", entry->accuracy.largest);
    json_number(json, "radiance_error", entry->accuracy.radiance);
    json_truth(json, "frontier", entry->best);
    json_truth(json, "within_noise", entry->uncertain);
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
    json_count(json, "runs", (uint64_t)cost->runs);
    json_number(json, "standard_seconds", cost->standard_seconds);
    json_open(json, "configurations", '[');
    for (int i = 0; i < cost->n; i++)
        json_entry(json, &cost->entries[i]);
    json_close(json, ']');
    json_strings(json, "notes", (const char *const *)cost->notes, cost->n_notes);
}
